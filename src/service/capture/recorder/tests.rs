use std::fs::File;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::sync_channel;

use tokio::sync::watch;

use super::super::event::Status;
use super::super::notice;
use super::super::presence::Presence;
use super::*;
use crate::config::capture_from_toml;
use crate::ingest::live::{PoseRecord, Token, stream_topics};

/// A recorder for that folder, with what it hands on to be synced.
fn recorder(folder: &Path) -> (Recorder, Receiver<File>) {
    let text = include_str!("../../../../config/pencil_tip.toml");
    let text = format!("{text}\n[capture]\nsync_ms = 300\n");
    let (scene, mut settings) = capture_from_toml(&text).expect("a scene");
    settings.folder = folder.to_owned();
    let metrics = Arc::default();
    let (publisher, _notices) = notice::queue(&metrics);
    let (syncer, files) = sync_channel(1);
    let recorder = Recorder {
        topics: stream_topics(&scene),
        scene,
        scene_toml: text.into_bytes(),
        settings,
        publisher,
        so_far: sync_channel(1).0,
        finals: sync_channel(1).0,
        syncer,
        status: watch::Sender::new(Status::default()),
        metrics,
        feed: None,
        token: Token::NONE,
        page: None,
        orders: std::sync::mpsc::channel().1,
        acted: std::sync::mpsc::channel().1,
    };
    (recorder, files)
}

/// Who is behind says so, and does not take the trackers for silent that it has not heard yet.
#[test]
fn a_recorder_that_is_behind_says_so_and_calls_nobody_silent() {
    let folder = tempfile::tempdir().expect("folder");
    let (recorder, _files) = recorder(folder.path());
    let mut state = RecorderState::new(&recorder);
    let begun = state.listened;
    for k in 0..100_u64 {
        let at = begun + Duration::from_millis(10 * k);
        state.pulses[0].sample(at, &PoseRecord::numbered(k));
    }
    let mut look = |behind_ms: u64| {
        state.behind = Duration::from_millis(behind_ms);
        recorder.tick(
            &mut state,
            begun + Duration::from_millis(4000 + 3000 - behind_ms),
        );
        let troubles = recorder.metrics.health.troubles(Instant::now()).join("; ");
        (
            state.status(begun + Duration::from_secs(4)).trackers[0].state,
            troubles,
        )
    };
    let (heard, troubles) = look(3000);
    assert_eq!(heard, Presence::Sending);
    assert!(troubles.contains("recording is 3.0 s behind"), "{troubles}");
    assert_eq!(look(0), (Presence::Silent, String::new()));
}

/// The journal is handed on to be synced every `sync_ms`, and nothing else is.
#[test]
fn the_journal_is_synced_as_often_as_said() {
    let folder = tempfile::tempdir().expect("folder");
    let (recorder, files) = recorder(folder.path());
    let mut state = RecorderState::new(&recorder);
    recorder.start(&mut state, None);
    let take = state.take.as_ref().expect("a take");
    let inode = std::fs::metadata(take.journal.part()).expect("there").ino();
    let begun = take.synced;
    let mut synced_ms = Vec::new();
    for ms in (0..2000).step_by(20) {
        recorder.tick(&mut state, begun + Duration::from_millis(ms));
        for file in files.try_iter() {
            assert_eq!(file.metadata().expect("open").ino(), inode);
            synced_ms.push(ms);
        }
    }
    assert_eq!(synced_ms, [300, 600, 900, 1200, 1500, 1800]);
}
