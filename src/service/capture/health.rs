//! Whether a take could be started and written now: `/health`.
//!
//! Each part of the daemon says what is wrong with it, or that nothing is. A part that has said
//! nothing for [`OLD`] is itself what is wrong.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// Interval of looking at the folder.
const LOOK: Duration = Duration::from_millis(500);

/// A part that was not heard for so long does not work.
const OLD: Duration = Duration::from_millis(1500);

/// Free space below which a take cannot be written \[bytes\].
const ROOM_BYTES: u64 = 1 << 20;

/// Descriptors that a take wants.
const DESCRIPTORS: usize = 4;

/// What may be wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum HealthPart {
    /// The take that was last begun could not be written.
    Take,
    /// The thread that journals.
    Recorder,
    /// The folder of the takes.
    Folder,
    /// The thread that polls iceoryx2.
    Listening,
    /// The services of iceoryx2.
    Services,
}

impl HealthPart {
    /// The parts that say at intervals how they are.
    const BEATING: [(Self, &str); 3] = [
        (
            Self::Recorder,
            "nothing is journalled: the disk or this machine does not keep up",
        ),
        (Self::Folder, "the folder of the takes does not answer"),
        (Self::Listening, "nothing is received: recording waits"),
    ];
}

/// What is wrong.
#[derive(Debug, Default)]
pub(super) struct Health {
    parts: Mutex<BTreeMap<HealthPart, (Instant, Option<String>)>>,
    free_bytes: AtomicU64,
}

impl Health {
    /// A part says what is wrong with it, or that nothing is.
    pub(super) fn say(&self, part: HealthPart, trouble: Option<String>) {
        let mut parts = self
            .parts
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        parts.insert(part, (Instant::now(), trouble));
    }

    /// Everything that is wrong.
    pub(super) fn troubles(&self, now: Instant) -> Vec<String> {
        let parts = self
            .parts
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        let said = parts.values().filter_map(|(_, trouble)| trouble.clone());
        let silent = HealthPart::BEATING.iter().filter(|(part, _)| {
            let heard = parts.get(part).map(|(at, _)| *at);
            heard.is_some_and(|at| now.saturating_duration_since(at) > OLD)
        });
        said.chain(silent.map(|(_, what)| (*what).to_owned()))
            .collect()
    }

    /// Why no take could be begun in the folder: what was seen last, looked at once more.
    pub(super) fn of_folder(&self, folder: &Path) -> Option<String> {
        {
            let parts = self
                .parts
                .lock()
                .unwrap_or_else(|poisoned| poisoned.into_inner());
            parts.get(&HealthPart::Folder)?.1.as_ref()?;
        }
        let trouble = self.look_at(folder).err();
        self.say(HealthPart::Folder, trouble.clone());
        trouble
    }

    /// Free space in the folder of the takes \[bytes\].
    pub(super) fn free_bytes(&self) -> u64 {
        self.free_bytes.load(Ordering::Relaxed)
    }

    /// Looks at the folder at intervals until it is told to stop.
    pub(super) fn watch(&self, folder: &Path, stop: &AtomicBool) {
        while !stop.load(Ordering::Relaxed) {
            self.say(HealthPart::Folder, self.look_at(folder).err());
            thread::sleep(LOOK);
        }
    }

    /// Fails where a take could not be begun in the folder.
    fn look_at(&self, folder: &Path) -> Result<(), String> {
        let name = folder.display();
        let free = fs4::available_space(folder).map_err(|error| format!("{name:?}: {error}"))?;
        self.free_bytes.store(free, Ordering::Relaxed);
        if free < ROOM_BYTES {
            return Err(format!(
                "{name:?}: the disk is full: {} KiB are free",
                free >> 10
            ));
        }
        let made = tempfile::tempfile_in(folder);
        let made = made.map_err(|error| format!("{name:?}: no file can be made: {error}"))?;
        let more: Result<Vec<File>, _> = (1..DESCRIPTORS).map(|_| made.try_clone()).collect();
        more.map_err(|error| format!("a take could not open its files: {error}"))?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_wrong_is_said_until_it_is_not() {
        let health = Health::default();
        assert!(health.troubles(Instant::now()).is_empty());
        health.say(HealthPart::Take, Some("take 3: broken".to_owned()));
        health.say(HealthPart::Folder, None);
        assert_eq!(health.troubles(Instant::now()), ["take 3: broken"]);
        health.say(HealthPart::Take, None);
        assert!(health.troubles(Instant::now()).is_empty());
        // The take need not say anything for ever; the folder must.
        let later = Instant::now() + 2 * OLD;
        assert_eq!(
            health.troubles(later),
            ["the folder of the takes does not answer"]
        );
    }

    #[test]
    fn a_folder_that_cannot_be_used_is_seen() {
        let health = Health::default();
        let folder = tempfile::tempdir().expect("folder");
        assert_eq!(health.look_at(folder.path()), Ok(()));
        assert!(health.free_bytes() > 0);
        let gone = folder.path().join("gone");
        assert!(health.look_at(&gone).is_err_and(|why| why.contains("gone")));
        let proc = health.look_at(Path::new("/proc"));
        assert!(proc.is_err_and(|why| why.contains("full") || why.contains("no file")));
    }
}
