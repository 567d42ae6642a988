use std::os::unix::fs::MetadataExt;
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::time::Duration;

use tokio::sync::watch;

use super::super::event::Status;
use super::super::notice;
use super::*;
use crate::config::capture_from_toml;
use crate::ingest::live::stream_topics;

/// The journal is handed on to be synced every `sync_ms`, and nothing else is.
#[test]
fn the_journal_is_synced_as_often_as_said() {
    let folder = tempfile::tempdir().expect("folder");
    let text = include_str!("../../../../config/pencil_tip.toml");
    let text = format!("{text}\n[capture]\nsync_ms = 300\n");
    let (scene, mut settings) = capture_from_toml(&text).expect("a scene");
    settings.folder = folder.path().to_owned();
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
        orders: std::sync::mpsc::channel().1,
    };
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
