//! Daemons killed in the middle of a take, and what is recovered.

use std::path::PathBuf;
use std::time::Duration;

use enact::ingest::Recording;

use super::raw_sequences;
use crate::harness::{Daemon, House, bytes, enact, ended};

/// Takes that were recovered, and what they were then.
type Earlier = Vec<(PathBuf, Vec<u8>)>;

/// Kills a daemon in the middle of a real-time load, when `moment` says so, and recovers. What
/// of the time before is not in the recording [ns].
fn lost_by_kill(
    house: &House,
    scene: &str,
    earlier: &mut Earlier,
    moment: impl FnOnce(&mut Daemon),
) -> i64 {
    let mut daemon = Daemon::start(house, scene, &["--start"]);
    daemon.wait_for("started");
    // It goes on after the daemon is gone.
    let load = [
        "--load",
        "1",
        "--rate-hz",
        "1000",
        "--seconds",
        "2.5",
        "--names",
        "pencil",
    ];
    let child = house.spawn_tracker(&[&load[..], &["--wait", "1"]].concat());
    moment(&mut daemon);
    let killed_ns = daemon.kill();
    let output = ended(child);
    let [part] = &house.parts()[..] else {
        panic!("{:?}", house.parts());
    };
    let said = enact(&["recover", house.text(house.folder()), "--format", "ndjson"]);
    let said: serde_json::Value = serde_json::from_str(&said).expect("json");
    // A chunk that was being written may not be whole; nothing else may be unread.
    let unread = said["unread"].as_array().expect("ranges");
    assert!(
        unread.iter().all(|range| range[1] == said["bytes"]),
        "{said}"
    );
    let kept = PathBuf::from(said["kept"].as_str().expect("a path"));
    assert!(kept.exists() && !part.exists(), "{said}");
    let saved = house.folder().join(part.file_stem().expect("name"));
    let sequences = raw_sequences(&saved);
    let raw = said["topics"].as_array().expect("topics").iter();
    let mut raw = raw.filter(|topic| topic[0] == "/capture/tracker/pencil/pose");
    let found = raw.next().and_then(|topic| topic[1].as_u64());
    assert_eq!(found, Some(sequences.len() as u64));
    assert!(
        Recording::open(&saved)
            .expect("open")
            .container()
            .is_sorted()
    );
    // From the first on none is missing and none doubled.
    let numbers = sequences.iter().map(|(sequence, _)| *sequence);
    assert!(numbers.eq(0..sequences.len() as u64));
    for (path, before) in earlier.iter() {
        assert!(bytes(path) == *before, "an earlier take was touched");
    }
    earlier.push((saved.clone(), bytes(&saved)));
    let sent = String::from_utf8_lossy(&output.stdout);
    let sent = sent.lines().find(|line| line.starts_with('{'));
    let sent: Option<serde_json::Value> = sent.and_then(|line| serde_json::from_str(line).ok());
    let first_ns = sent.and_then(|sent| sent["first_ns"].as_i64());
    let last_ns = sequences.last().map(|(_, sent_ns)| *sent_ns).or(first_ns);
    last_ns.map_or(0, |last_ns| (killed_ns - last_ns).max(0))
}

/// Between two flushes a kill costs most: the moment is taken from the last one seen, and lies
/// also where a daemon that flushed less often would lose more than it may.
#[test]
fn of_a_killed_daemon_all_but_the_stated_window_is_recovered() {
    use rand::{RngExt, SeedableRng};
    const CHUNK_MS: u64 = 200;
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(41);
    let house = House::new();
    let scene = house.folder().join("scene.toml");
    let text = std::fs::read_to_string("config/pencil_tip.toml").expect("scene");
    let text = format!("{text}\n[capture]\nchunk_ms = {CHUNK_MS}\n");
    std::fs::write(&scene, text).expect("write");
    let mut earlier = Earlier::new();
    for (samples, least_ms) in [(30, 60), (200, 230), (400, 260), (100, 500), (700, 120)] {
        let after = Duration::from_millis(least_ms + random.random_range(0..30));
        let mut stalled = Duration::ZERO;
        let moment = |daemon: &mut Daemon| {
            daemon.wait_until_journalled(samples);
            stalled = daemon.wait_after_growth(after);
        };
        let lost_ns = lost_by_kill(&house, house.text(&scene), &mut earlier, moment);
        let lost = Duration::from_nanos(lost_ns as u64);
        let bound = Duration::from_millis(CHUNK_MS) + stalled;
        assert!(
            lost <= bound,
            "{after:?} after a flush: {lost:?}, may be {bound:?}"
        );
    }
    let mut daemon = Daemon::start(&house, "config/pencil_tip.toml", &[]);
    assert_eq!(daemon.ready["abandoned"].as_array().map(Vec::len), Some(0));
    daemon.end();
}

#[test]
#[ignore = "takes minutes: cargo test --test capture -- --ignored --nocapture kills"]
fn a_hundred_kills_at_random_moments() {
    use rand::{RngExt, SeedableRng};
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(100);
    let house = House::new();
    let mut earlier = Earlier::new();
    let mut lost_ms: Vec<f64> = (0..100)
        .map(|_| {
            let after = Duration::from_millis(random.random_range(0..1800));
            let moment = |_: &mut Daemon| std::thread::sleep(after);
            let scene = "config/pencil_tip.toml";
            lost_by_kill(&house, scene, &mut earlier, moment) as f64 * 1e-6
        })
        .collect();
    lost_ms.sort_by(f64::total_cmp);
    println!(
        "lost: median {:.1} ms, 90 %: {:.1} ms, most {:.1} ms",
        lost_ms[50], lost_ms[90], lost_ms[99]
    );
    // chunk_ms, by default, and what a busy machine holds up.
    assert!(lost_ms[90] <= 100.0 && lost_ms[99] < 200.0);
}
