//! Performances acted live, and stamps from sequence numbers and from arrivals, end to end.

use enact::ingest::Recording;
use enact::motion::TakeEvent;

use super::{events, scene_of};
use crate::harness::{Daemon, House, bytes, enact};
use enact_tools::perform::{Acting, Style, perform};

const PENCIL: &str = "recordings/pencil_tip.mcap";
const RATE_HZ: f64 = 120.0;

/// Stamps that were made and arrivals that they were made from [ns], of the pencil's samples in
/// the order in which they came.
fn stamps_and_arrivals(take: &std::path::Path) -> (Vec<i64>, Vec<i64>) {
    let recording = Recording::open(take).expect("open");
    let scene = scene_of(&recording);
    let events = recording.take(&scene).expect("take").events;
    let stamps = events.iter().filter_map(|event| match event {
        TakeEvent::Pose { sample, .. } => Some(sample.stamp.0),
        TakeEvent::Mark(_) => None,
    });
    let container = recording.container();
    let mut walk = container.walk();
    let mut arrivals = Vec::new();
    while let Some(message) = walk.next_message() {
        let topic = &container.channels()[&message.channel_id].topic;
        if topic == "/capture/tracker/pencil/pose" {
            arrivals.push(message.log_time as i64);
        }
    }
    (stamps.collect(), arrivals)
}

/// Sum of squares of second differences [s²]: how uneven a stream is.
fn unevenness(times_ns: &[i64]) -> f64 {
    let second = |w: &[i64]| (w[2] - 2 * w[1] + w[0]) as f64 * 1e-9;
    times_ns.windows(3).map(|w| second(w).powi(2)).sum()
}

/// A take in real time by a tracker that says no times of its own.
fn take_by(source: &str) -> (Vec<i64>, Vec<i64>) {
    let house = House::new();
    let scene = house.folder().join("scene.toml");
    let text = std::fs::read_to_string("config/pencil_tip.toml").expect("scene");
    let table = format!("[[capture.tracker]]\nbody = \"pencil\"\n{source}\n");
    std::fs::write(&scene, format!("{text}\n{table}")).expect("write");
    let mut daemon = Daemon::start(&house, house.text(&scene), &[]);
    let sent = house.tracker(&[PENCIL, "--take", "--no-sample-time"]);
    let closed = daemon.wait_for("closed");
    let tracker = &closed["counts"]["trackers"][0];
    let word = tracker["clock"]["source"].as_str().expect("word");
    assert!(source.contains(word), "{word}");
    assert_eq!(tracker["clock"]["unstamped"].as_u64(), Some(0));
    let estimated = daemon.wait_for("estimated");
    assert_eq!(estimated["report"]["verdict"], "physical", "{source}");
    daemon.end();
    // The journal says what the take was made of: the same bytes by replay.
    let take = house.path(closed["recording"].as_str().expect("path"));
    let replayed = house.folder().join("replayed.mcap");
    enact(&["replay", house.text(&take), "-o", house.text(&replayed)]);
    assert!(bytes(&take.with_extension("estimate.mcap")) == bytes(&replayed));
    let (stamps, arrivals) = stamps_and_arrivals(&take);
    assert_eq!(stamps.len() as u64, sent["poses"].as_u64().expect("number"));
    assert_eq!(stamps.len(), arrivals.len());
    assert!(stamps.is_sorted(), "{source}");
    (stamps, arrivals)
}

#[test]
fn a_take_can_be_stamped_by_sequence_numbers() {
    let (stamps, arrivals) = take_by(&format!("stamps = \"sequence\"\nrate_hz = {RATE_HZ}"));
    for (stamp, arrival) in stamps.iter().zip(&arrivals) {
        assert!(stamp <= arrival, "{} ns ahead", stamp - arrival);
    }
    // The numbers' own spacing, but where the least delay so far is underbid.
    let mut intervals: Vec<i64> = stamps.windows(2).map(|w| w[1] - w[0]).collect();
    intervals.sort_unstable();
    let median_s = intervals[intervals.len() / 2] as f64 * 1e-9;
    assert!((median_s * RATE_HZ - 1.0).abs() < 0.01, "{median_s} s");
}

#[test]
fn a_take_can_be_stamped_on_arrival() {
    let (stamps, arrivals) = take_by("stamps = \"receipt\"");
    let (before, after) = (unevenness(&arrivals), unevenness(&stamps));
    assert!(after < before / 2.0, "{before} s² to {after} s²");
    let delay = |k: usize| (arrivals[k] - stamps[k]) as f64 * 1e-9;
    let mean_s = (0..stamps.len()).map(delay).sum::<f64>() / stamps.len() as f64;
    assert!(mean_s.abs() < 0.02, "{mean_s} s");
}

#[test]
fn a_performance_that_is_acted_live_is_the_one_that_its_seed_determines() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, "config/pencil_tip.toml", &[]);
    let manner = ["--perform", "tip", "--seed", "3", "--distortion", "1.5"];
    let live = |more: &[&str]| house.tracker(&[&manner, more].concat());
    let sent = live(&["--start-ns", "1000000000000", "--take", "--rate", "0"]);
    let closed = daemon.wait_for("closed");
    let acting = Acting {
        distortion: 1.5,
        start: enact::motion::Stamp(1_000_000_000_000),
        ..Acting::default()
    };
    let performance = perform(&Style::Tip.truth(), &acting, 3);
    let mut expected: Vec<String> = performance
        .events
        .iter()
        .map(|e| format!("{e:?}"))
        .collect();
    expected.sort();
    let taken = house.path(closed["recording"].as_str().expect("path"));
    assert_eq!(events(&taken), expected);
    let first = daemon.wait_for("estimated");
    assert_eq!(first["report"]["verdict"], "physical");

    // Now, at thrice the pace, with samples that are lost on the way.
    let before_ns = now_ns();
    let faulty = live(&["--take", "--rate", "3", "--drop", "20..25"]);
    let closed = daemon.wait_for("closed");
    let counts = &closed["counts"]["trackers"][0]["counts"];
    assert_eq!(counts["missing"].as_u64(), Some(5), "{counts}");
    let of = |sent: &serde_json::Value, what: &str| sent[what].as_u64().expect("number");
    assert_eq!(of(&faulty, "poses") + 5, of(&sent, "poses"));
    assert_eq!((of(&faulty, "marks"), of(&sent, "marks")), (2, 2));
    let taken = house.path(closed["recording"].as_str().expect("path"));
    let (stamps, _) = stamps_and_arrivals(&taken);
    assert!(stamps[0] >= before_ns && stamps[0] <= now_ns());
    let second = daemon.wait_for("estimated");
    assert_eq!(second["report"]["verdict"], "physical");
    daemon.end_with(3);
}

fn now_ns() -> i64 {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    since.expect("after 1970").as_nanos() as i64
}
