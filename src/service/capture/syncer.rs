//! The thread that syncs journals to disk, separate because a sync may take long.

use std::fs::File;
use std::sync::mpsc::Receiver;

use super::event::CaptureEvent;
use super::notice::{Notice, Speaker};

/// Syncs every file from the queue until it is closed; reports errors.
pub(super) fn sync_all(queue: &Receiver<File>, speaker: &Speaker) {
    for file in queue {
        if let Err(error) = file.sync_data() {
            let text = format!("the journal was not synced: {error}");
            speaker.say_at_once(Notice::of(CaptureEvent::Warning { text }));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::mpsc::sync_channel;

    use super::super::notice;
    use super::*;

    /// The system refuses to sync a device: that it is asked to is seen by its complaint.
    #[test]
    fn the_system_is_asked_to_sync_every_file() {
        let (speaker, notices) = notice::queue(&Arc::default());
        let (sender, queue) = sync_channel(3);
        for _ in 0..2 {
            let device = File::open("/dev/null").expect("open");
            sender.send(device).expect("room");
        }
        sender
            .send(tempfile::tempfile().expect("file"))
            .expect("room");
        drop(sender);
        sync_all(&queue, &speaker);
        let said: Vec<CaptureEvent> = notices.try_iter().map(|notice| notice.said).collect();
        assert_eq!(said.len(), 2, "{said:?}");
        for said in said {
            assert!(
                matches!(&said, CaptureEvent::Warning { text } if text.contains("was not synced")),
                "{said:?}"
            );
        }
    }
}
