use super::*;
use crate::config::capture_from_toml;
use crate::ingest::Recording;
use crate::ingest::live::stream_topics;

const MS: Duration = Duration::from_millis(1);
const RAW: &str = "/capture/tracker/pencil/pose";

/// A take of the pencil scene, with that `[capture]`.
fn take(folder: &Path, capture: &str) -> (OpenTake, CaptureSettings) {
    let text = include_str!("../../../../config/pencil_tip.toml");
    let text = format!("{text}\n[capture]\n{capture}\n");
    let (scene, settings) = capture_from_toml(&text).expect("a scene");
    let path = folder.join("take.mcap");
    let topics = stream_topics(&scene);
    let take = OpenTake::begin(
        1,
        &path,
        &scene,
        text.as_bytes(),
        &topics,
        &settings,
        &|_| None,
    );
    (take.expect("begun"), settings)
}

fn record(k: u64) -> PoseRecord {
    PoseRecord {
        sequence: k,
        available_ns: k as i64,
        sample_ns: 1_700_000_000_000_000_000 + k as i64 * 1_000_000,
        device_ns: k as i64,
        position_m: [k as f64, 0.5, 0.25],
        quaternion_xyzw: [0.0, 0.0, 0.0, 1.0],
        flags: 1,
        session: 1,
    }
}

/// Log times of the samples that a killed process would leave.
fn on_disk(part: &std::path::Path) -> Vec<u64> {
    let recording = Recording::open(part).expect("open");
    let container = recording.container();
    assert!(container.is_sorted() && !container.damages().is_loss());
    let mut walk = container.walk();
    let mut times = Vec::new();
    while let Some(message) = walk.next_message() {
        if container.channels()[&message.channel_id].topic == RAW {
            times.push(message.log_time);
        }
    }
    times
}

/// At any moment, all but what came in the last `chunk_ms` is in the file.
#[test]
fn what_came_is_in_the_file_after_chunk_ms() {
    for chunk_ms in [40_u32, 100, 250] {
        let folder = tempfile::tempdir().expect("folder");
        let (mut take, settings) = take(folder.path(), &format!("chunk_ms = {chunk_ms}"));
        assert_eq!(settings.chunk, MS * chunk_ms);
        let part = take.journal.part().to_owned();
        let begun = take.anchor.at;
        let mut least = usize::MAX;
        for k in 0..900_u32 {
            let now = begun + MS * k;
            take.pose(now, 0, &record(u64::from(k)), false)
                .expect("kept");
            // As often as the recorder does, at the least.
            if k % 5 > 0 {
                continue;
            }
            take.tick(now, &settings).expect("ticked");
            let found = on_disk(&part).len();
            let due = (k + 1).saturating_sub(chunk_ms) as usize;
            assert!(found >= due, "after {k} ms: {found} of {due} samples");
            least = least.min(found.saturating_sub(due));
        }
        // It is not written at once either: that would be a chunk for every sample.
        assert!(least < chunk_ms as usize / 2, "{least}");
    }
}

/// Arrivals are stamped by a clock that is never set: changes of the system clock do not matter
/// once a take has begun.
#[test]
fn log_times_follow_no_clock_that_can_be_set() {
    let folder = tempfile::tempdir().expect("folder");
    let (mut take, settings) = take(folder.path(), "sync_ms = 50");
    let begun = take.anchor.at;
    // The system clock was an hour later when the take began: it was set back since.
    let wall_ns = now_ns() + 3_600_000_000_000;
    take.anchor = TakeAnchor { wall_ns, at: begun };
    for k in 0..400_u32 {
        let now = begun + MS * k;
        take.pose(now, 0, &record(u64::from(k)), false)
            .expect("kept");
        take.tick(now, &settings).expect("ticked");
    }
    take.note_counts().expect("counted");
    take.journal.close_chunk().expect("closed");
    let expected: Vec<u64> = (0..400).map(|k| wall_ns as u64 + k * 1_000_000).collect();
    assert_eq!(on_disk(take.journal.part()), expected);
    // What came before the take began, by the same poll.
    let before = take.anchor.stamp(begun - MS * 3);
    assert_eq!(before, Stamp(wall_ns - 3_000_000));
}
