//! `/health` is red soon after takes cannot be written any more, and not before.

use std::path::Path;
use std::time::{Duration, Instant};

use super::SCENE;
use super::socket::get;
use crate::harness::{Daemon, House, Patience};
use crate::skip::skip;

/// How soon it must be red, and how much longer a busy machine may take.
const SOON: Duration = Duration::from_secs(2);
const BUSY: Duration = Duration::from_secs(1);

/// Waits until health is that; how long it took, and what is said.
pub fn wait(url: &str, expected: u16) -> (Duration, String) {
    let begun = Instant::now();
    let patience = Patience::new();
    loop {
        patience.check("health changes");
        let (status, said) = get(url, "/health");
        if status == expected {
            return (begun.elapsed(), said);
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

pub fn wait_for_red(url: &str, word: &str) {
    let (after, said) = wait(url, 503);
    assert!(said.contains(word), "{said}");
    assert!(after < SOON + BUSY, "{after:?}");
}

#[test]
fn a_full_disk_is_seen_before_and_after_a_take() {
    let house = House::new();
    let started = Daemon::start_on_small_disk(&house, SCENE, "8m", "--metrics-port 0");
    let Some(mut daemon) = started else {
        return skip(
            "a_full_disk_is_seen_before_and_after_a_take",
            "no file system may be mounted here",
        );
    };
    let url = daemon.ready["metrics"].as_str().expect("served").to_owned();
    assert_eq!(get(&url, "/health").0, 200);
    let filler = daemon.seen(&house.folder().join("filler"));
    std::fs::write(&filler, vec![1; 15 << 19]).expect("write");
    wait_for_red(&url, "the disk is full");
    std::fs::remove_file(&filler).expect("remove");
    wait(&url, 200);
    // A take that fills it breaks, and that is said until one begins again.
    let load = [
        "--load",
        "1",
        "--names",
        "pencil",
        "--rate-hz",
        "1000",
        "--seconds",
        "3",
    ];
    let (code, ..) = house.take(&["start"]);
    assert_eq!(code, Some(0));
    let rest = vec![1; 8 << 20];
    let _ = std::fs::write(&filler, &rest);
    house.tracker(&[&load[..], &["--wait", "1"]].concat());
    daemon.wait_for("broken");
    wait_for_red(&url, "take 1 could not be recorded");
    std::fs::remove_file(&filler).expect("remove");
    let (code, said, _) = house.take(&["status"]);
    assert_eq!(code, Some(3), "{said}");
    assert!(
        said.contains("trouble: take 1 could not be recorded"),
        "{said}"
    );
    house.take(&["start"]);
    wait(&url, 200);
    daemon.terminate();
    assert_eq!(daemon.finished(), Some(3));
}

#[test]
fn a_folder_that_goes_and_services_that_go_are_seen() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, SCENE, &["--metrics-port", "0"]);
    let url = daemon.ready["metrics"].as_str().expect("served").to_owned();
    assert_eq!(get(&url, "/health").0, 200);
    let away = house.folder().with_file_name("away");
    std::fs::rename(house.folder(), &away).expect("rename");
    wait_for_red(&url, "takes");
    std::fs::rename(&away, house.folder()).expect("rename");
    wait(&url, 200);
    // As those do who tidy up /tmp: trackers would find no service, and make one that nobody hears.
    let services = house.iceoryx2().with_file_name("iceoryx2").join("services");
    remove_all(&services);
    wait_for_red(&url, "are gone");
    daemon.kill();
}

fn remove_all(folder: &Path) {
    for entry in std::fs::read_dir(folder).expect("list") {
        std::fs::remove_file(entry.expect("entry").path()).expect("remove");
    }
}
