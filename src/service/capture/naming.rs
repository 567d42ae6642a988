//! Names of the takes' files.

use std::path::{Path, PathBuf};

use crate::write::recover::PART_SUFFIX;

/// Longer ones are dates, or somebody else's.
const MOST_DIGITS: usize = 7;

const NANOSECONDS_PER_SECOND: i64 = 1_000_000_000;
const SECONDS_PER_DAY: i64 = 86_400;

/// Folder in that of the takes to which those are moved that are discarded.
pub(super) const DISCARDED: &str = "discarded";

/// The greatest number of a take in the folder, discarded or not, 0 where there is none: numbers go on over restarts.
pub(super) fn last_number(folder: &Path) -> u64 {
    let folders = [folder, &folder.join(DISCARDED)];
    let entries = folders.into_iter().flat_map(std::fs::read_dir);
    let entries = entries.flatten().flatten();
    let numbers = entries.filter_map(|entry| {
        let name = entry.file_name();
        let (number, rest) = name.to_str()?.strip_prefix("take-")?.split_once('-')?;
        let is_ours = rest.contains(".mcap") && number.len() <= MOST_DIGITS;
        is_ours.then(|| number.parse().ok())?
    });
    numbers.max().unwrap_or(0)
}

/// `take-0012-20261121T171000Z.mcap` in the folder, with `-2`, `-3`, … where a recording or a journal
/// of that name exists.
pub(super) fn take_path(folder: &Path, number: u64, now_ns: i64) -> PathBuf {
    let stem = format!("take-{number:04}-{}", utc(now_ns));
    let names = std::iter::once(format!("{stem}.mcap"))
        .chain((2..).map(|count| format!("{stem}-{count}.mcap")));
    let is_free = |name: &String| {
        let part = folder.join(format!("{name}{PART_SUFFIX}"));
        !folder.join(name).exists() && !part.exists()
    };
    let free = names.into_iter().find(is_free);
    folder.join(free.expect("there are names without end"))
}

/// The time in ISO 8601 basic format, in UTC.
fn utc(now_ns: i64) -> String {
    let seconds = now_ns.div_euclid(NANOSECONDS_PER_SECOND);
    let (days, of_day) = (
        seconds.div_euclid(SECONDS_PER_DAY),
        seconds.rem_euclid(SECONDS_PER_DAY),
    );
    let (year, month, day) = civil(days);
    let (hour, minute, second) = (of_day / 3600, of_day / 60 % 60, of_day % 60);
    format!("{year:04}{month:02}{day:02}T{hour:02}{minute:02}{second:02}Z")
}

/// Year, month and day of the Gregorian calendar, given the days since 1970-01-01. 400 years are
/// 146097 days; in a year that begins in March the leap day is the last.
fn civil(days: i64) -> (i64, i64, i64) {
    let since = days + 719_468;
    let era = since.div_euclid(146_097);
    let of_era = since.rem_euclid(146_097);
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let march_month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * march_month + 2) / 5 + 1;
    let month = if march_month < 10 {
        march_month + 3
    } else {
        march_month - 9
    };
    let year = year_of_era + 400 * era + i64::from(month <= 2);
    (year, month, day)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_have_their_dates() {
        for (seconds, expected) in [
            (0, "19700101T000000Z"),
            (951_782_400, "20000229T000000Z"),
            (1_709_251_199, "20240229T235959Z"),
            (1_709_251_200, "20240301T000000Z"),
            (4_107_542_400, "21000301T000000Z"),
            (-1, "19691231T235959Z"),
        ] {
            assert_eq!(utc(seconds * NANOSECONDS_PER_SECOND), expected);
        }
    }

    #[test]
    fn numbers_go_on_and_other_files_do_not_count() {
        let folder = tempfile::tempdir().expect("folder");
        assert_eq!(last_number(folder.path()), 0);
        for name in [
            "take-0003-20261121T171000Z.mcap",
            "take-0007-20261121T171000Z.mcap.part.recovered",
            "take-0005-20261121T171000Z.estimate.mcap",
            "take-20261121T171000Z-2.mcap",
            "take-99-notes.txt",
            "take-x-1.mcap",
            "other-9-1.mcap",
        ] {
            std::fs::write(folder.path().join(name), b"").expect("write");
        }
        assert_eq!(last_number(folder.path()), 7);
        let aside = folder.path().join(DISCARDED);
        std::fs::create_dir(&aside).expect("folder");
        std::fs::write(aside.join("take-0008-20261121T171000Z.mcap"), b"").expect("write");
        assert_eq!(last_number(folder.path()), 8);
        assert_eq!(last_number(&folder.path().join("gone")), 0);
    }

    #[test]
    fn no_two_takes_have_one_name() {
        let folder = tempfile::tempdir().expect("folder");
        let first = take_path(folder.path(), 12, 0);
        std::fs::write(format!("{}{PART_SUFFIX}", first.display()), b"").expect("write");
        let second = take_path(folder.path(), 12, 0);
        std::fs::write(&second, b"").expect("write");
        let third = take_path(folder.path(), 12, 0);
        let names = [first, second, third].map(|path| path.display().to_string());
        for (name, end) in names.iter().zip(["0Z.mcap", "0Z-2.mcap", "0Z-3.mcap"]) {
            assert!(
                name.contains("/take-0012-1970") && name.ends_with(end),
                "{name}"
            );
        }
        assert_eq!(last_number(folder.path()), 12);
    }
}
