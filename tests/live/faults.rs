//! Every call of the system fails once, and at random: disk full, an error of the device, no
//! descriptors left, interrupted, half written, killed in the middle of a write. After each the
//! promises hold: what bears a final name is whole, what was synced is there, nothing is deleted.
//! They are stated in `docs/promises.md`.
//!
//! The faults are made by `faults/shim.c`, which needs a C compiler, as the build does.
#![cfg(all(
    target_os = "linux",
    any(target_arch = "x86_64", target_arch = "aarch64")
))]

mod commands;
mod desk;
mod live;

use crate::journals::journal;
use desk::{Desk, Run};
use rand::{RngExt, SeedableRng};

/// Kinds of calls, with the ways in which each fails: numbers of errors are those of Linux.
const FAULTS: [(&str, &[&str]); 8] = [
    ("open", &["5", "24", "4", "28"]),
    ("read", &["5", "4"]),
    ("write", &["28", "5", "4", "short", "torn"]),
    ("sync", &["5", "28", "4"]),
    ("rename", &["5", "28", "13", "4"]),
    ("lock", &["4", "37", "5"]),
    ("truncate", &["5"]),
    ("unlink", &["5", "13"]),
];

/// Every fault of each kind at every call, until there are no more calls of that kind.
fn every(mut run: impl FnMut(&str) -> bool) -> usize {
    let mut fired = 0;
    for (kind, ways) in FAULTS {
        for way in ways {
            for number in 1.. {
                assert!(number < 300, "{kind} has no end");
                if !run(&format!("{kind}:{number}:{way}")) {
                    break;
                }
                fired += 1;
            }
        }
    }
    fired
}

/// Several faults at once, that go on or not.
fn random(seed: u64, count: usize, mut run: impl FnMut(&str) -> bool) -> usize {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut fired = 0;
    for _ in 0..count {
        let several = random.random_range(1..4);
        let faults: Vec<String> = (0..several)
            .map(|_| {
                let (kind, ways) = FAULTS[random.random_range(0..FAULTS.len())];
                let way = ways[random.random_range(0..ways.len())];
                let number = random.random_range(1..12);
                // Who is interrupted for ever waits for ever.
                let goes_on = random.random_bool(0.5) && way != "4";
                format!("{kind}:{number}{}:{way}", if goes_on { "+" } else { "" })
            })
            .collect();
        fired += usize::from(run(&faults.join(",")));
    }
    fired
}

/// A recovery that failed leaves the journal, and no recording or a whole one; the next ends as one
/// that nothing happened to.
#[test]
fn a_recovery_that_fails_at_any_call_deletes_nothing_and_can_be_repeated() {
    let written = journal(4, 30);
    let new_desk = || {
        let desk = Desk::new()?;
        desk.put("take.mcap.part", &written.bytes);
        Some(desk)
    };
    let Some(desk) = new_desk() else {
        return;
    };
    assert_eq!(desk.run(&["recover", "."], "").code, Some(0));
    let expected = desk.files();
    let fails = |faults: &str| {
        let desk = new_desk().expect("a desk");
        let Run { code, fired, .. } = desk.run(&["recover", "take.mcap.part"], faults);
        let left = desk.files();
        let journals = left.values().filter(|bytes| **bytes == written.bytes);
        assert_eq!(journals.count(), 1, "{faults}: {:?}", left.keys());
        if let Some(recording) = left.get("take.mcap") {
            assert!(*recording == expected["take.mcap"], "{faults}: not whole");
        }
        // Killed, or failed and said so, or done.
        if code == Some(0) {
            assert!(left == expected, "{faults}: {:?}", left.keys());
        }
        assert!(matches!(code, None | Some(0 | 1)), "{faults}: {code:?}");
        let again = desk.run(&["recover", "."], "");
        assert_eq!(again.code, Some(0), "{faults}: {}", again.said);
        assert!(
            desk.files() == expected,
            "{faults}: {:?}",
            desk.files().keys()
        );
        fired
    };
    let fired = every(fails);
    assert!(fired > 40, "{fired} faults");
    let fired = random(18, 150, fails);
    assert!(fired > 50, "{fired} faults");
}
