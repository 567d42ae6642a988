//! The journal of a live take, written by a child process whose calls fail.

use std::path::{Path, PathBuf};
use std::process::Command;

use enact::motion::Stamp;
use enact::wire::container::Container;
use enact::wire::live::payload::{NO_TIME, PoseRecord};
use enact::write::{Journal, WriteError};

use super::desk::{Desk, Run};
use super::{every, random};

const START: i64 = 1_700_000_000_000_000_000;
const MS: i64 = 1_000_000;
const SAMPLES: i64 = 300;
const RAW_TOPIC: &str = "/capture/tracker/a/pose";

/// Where the child writes.
const FOLDER: &str = "ENACT_FAULTS_FOLDER";

fn record(k: i64) -> PoseRecord {
    PoseRecord {
        sequence: k as u64,
        available_ns: START + k * MS,
        sample_ns: START + k * MS,
        device_ns: NO_TIME,
        position_m: [k as f64 * 0.1, (k as f64).sin(), 0.5],
        quaternion_xyzw: [0.0, 0.0, 0.0, 1.0],
        flags: 1,
        session: 3,
    }
}

/// Journals a take as the daemon does: chunks are closed, then synced; an error ends it where it
/// was last whole. Says how many samples were synced.
fn journal_take(folder: &Path) -> Result<(), WriteError> {
    let topics = ["/tracker/a/pose".to_owned()];
    let path = folder.join("take.mcap");
    let mut journal = Journal::create(&path, &topics, "/marks", b"name = \"x\"\n")?;
    for k in 0..SAMPLES {
        let stamp = Stamp(START + k * MS);
        let sample = record(k).pose(stamp);
        let kept = journal.pose(0, stamp, &record(k), Some(&sample));
        let kept = kept.and_then(|()| match k % 20 {
            19 => journal.close_chunk(),
            _ => Ok(()),
        });
        if let Err(error) = kept {
            println!("failed: {error}");
            return journal.salvage();
        }
        if k % 40 == 39
            && journal
                .sync_handle()
                .is_ok_and(|file| file.sync_data().is_ok())
        {
            println!("synced {}", k + 1);
        }
    }
    journal.finish()?;
    println!("synced {SAMPLES}");
    Ok(())
}

#[test]
#[ignore = "the child of the next test, which runs it with faults"]
fn a_take_is_journalled() {
    let made = tempfile::tempdir().expect("folder");
    let given = std::env::var_os(FOLDER).map(PathBuf::from);
    let folder = given.as_deref().unwrap_or(made.path());
    if let Err(error) = journal_take(folder) {
        println!("ended: {error}");
    }
    let is_there = |name: &str| folder.join(name).exists();
    assert!(given.is_some() || is_there("take.mcap") && !is_there("take.mcap.part"));
}

/// The samples of a recording: all up to some number, bit for bit.
fn samples(bytes: &[u8], faults: &str) -> i64 {
    let container = Container::new(bytes.to_vec()).expect("MCAP");
    let mut walk = container.walk();
    let mut count = 0;
    while let Some(message) = walk.next_message() {
        if container.channels()[&message.channel_id].topic == RAW_TOPIC {
            assert_eq!(
                message.data[4..],
                record(count).to_bytes(),
                "{faults}: {count}"
            );
            count += 1;
        }
    }
    count
}

/// Whatever fails: what was synced is in the take, or in the journal and recovered from it, and no
/// file that bears the take's name has damage in it.
#[test]
fn of_a_live_take_nothing_is_lost_that_was_synced() {
    let take = |faults: &str| {
        let Some(desk) = Desk::new() else {
            return false;
        };
        let mut command = Command::new(std::env::current_exe().expect("this program"));
        command
            .args([
                "--exact",
                "faults::live::a_take_is_journalled",
                "--ignored",
                "--nocapture",
            ])
            .env(FOLDER, desk.folder());
        let Run { fired, said, .. } = desk.run_command(command, faults);
        let synced = said.lines().filter_map(|line| line.split_once("synced "));
        let synced = synced.filter_map(|(_, count)| count.trim().parse::<i64>().ok());
        let synced = synced.max().unwrap_or(0);
        let files = desk.files();
        let mut names = files.keys().map(String::as_str);
        assert!(
            names.all(|name| matches!(name, "take.mcap" | "take.mcap.part")),
            "{faults}: {:?}",
            files.keys()
        );
        if let Some(bytes) = files.get("take.mcap") {
            let container = Container::new(bytes.clone()).expect("MCAP");
            assert!(!container.damages().is_loss(), "{faults}: {said}");
            let found = samples(bytes, faults);
            assert!(found >= synced, "{faults}: {found} of {synced}: {said}");
        } else {
            let recovered = desk.run(&["recover", "."], "");
            let files = desk.files();
            match files.get("take.mcap") {
                Some(bytes) => {
                    let found = samples(bytes, faults);
                    assert!(found >= synced, "{faults}: {found} of {synced}: {said}");
                }
                None => assert_eq!(synced, 0, "{faults}: {said} {}", recovered.said),
            }
        }
        if faults.is_empty() {
            assert_eq!((synced, files.len()), (SAMPLES, 1), "{said}");
        }
        fired
    };
    assert!(!take(""));
    if super::desk::shim().is_none() {
        return;
    }
    let fired = every(take);
    assert!(fired > 40, "{fired} faults");
    let fired = random(19, 100, take);
    assert!(fired > 30, "{fired} faults");
}
