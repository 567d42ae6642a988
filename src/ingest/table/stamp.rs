//! Decimal numbers of time as integer nanoseconds, exactly: a double has no room for the nanoseconds of
//! this century.

/// A decimal number times a power of ten, rounded to the nearest whole number, halves away from zero. `None`
/// for what is no number, or needs more than 64 bits. A comma may stand for the point.
pub fn nanoseconds(text: &str, power: i32) -> Option<i64> {
    let text = text.trim();
    let (mantissa, exponent) = match text.find(['e', 'E']) {
        Some(at) => (&text[..at], text[at + 1..].parse::<i32>().ok()?),
        None => (text, 0),
    };
    let is_negative = mantissa.starts_with('-');
    let digits = mantissa.strip_prefix(['-', '+']).unwrap_or(mantissa);
    let (whole, fraction) = digits.split_once(['.', ',']).unwrap_or((digits, ""));
    let all = || whole.bytes().chain(fraction.bytes());
    if whole.len() + fraction.len() == 0 || !all().all(|digit| digit.is_ascii_digit()) {
        return None;
    }
    // So many of all digits stand before the point of the result.
    let kept = i64::from(power) + i64::from(exponent) + whole.len() as i64;
    let mut value: i128 = 0;
    let digit_at = |index: i64| {
        let index = usize::try_from(index).ok()?;
        all().nth(index).map(|digit| i128::from(digit - b'0'))
    };
    let is_zero = all().all(|digit| digit == b'0');
    if is_zero {
        return Some(0);
    }
    // No number of 64 bits has more.
    const DIGITS_MAX: i64 = 400;
    if kept > DIGITS_MAX {
        return None;
    }
    for index in 0..kept {
        value = value.checked_mul(10)?;
        value += digit_at(index).unwrap_or(0);
        if value > i128::from(i64::MAX) {
            return None;
        }
    }
    if digit_at(kept).is_some_and(|digit| digit >= 5) {
        value += 1;
    }
    i64::try_from(if is_negative { -value } else { value }).ok()
}

/// A time that is written as a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TextTime {
    /// Since 1970, or since midnight where it has no date \[ns\].
    pub(super) ns: i64,
    /// Whether it has a date.
    pub(super) has_date: bool,
}

const DAY_NS: i64 = 86_400_000_000_000;

/// A date and a time of day (`2026-01-05T10:00:00.25+01:00`, with a blank for the `T`, with or without a zone), or
/// a time of day alone (`10:00:00.25`), which may have more than 24 hours; `None` for other texts.
pub(super) fn text_time(text: &str) -> Option<TextTime> {
    let text = text.trim();
    // No time has more characters.
    const LENGTH_MAX: usize = 40;
    if text.len() > LENGTH_MAX || !text.contains(':') {
        return None;
    }
    let Some((date, clock)) = text.split_once(['T', ' ', '_']) else {
        let ns = time_of_day_ns(text)?;
        return Some(TextTime {
            ns,
            has_date: false,
        });
    };
    let (clock, zone_ns) = zoned(clock.trim())?;
    let days = days_since_1970(date)?;
    let ns = days.checked_mul(DAY_NS)?;
    let ns = ns
        .checked_add(time_of_day_ns(clock)?)?
        .checked_sub(zone_ns)?;
    Some(TextTime { ns, has_date: true })
}

/// Whether a cell is a time as a text.
pub(super) fn is_text_time(text: &str) -> bool {
    text_time(text).is_some()
}

fn time_of_day_ns(text: &str) -> Option<i64> {
    let mut parts = text.split(':');
    let (hours, minutes, seconds) = (parts.next()?, parts.next()?, parts.next());
    if parts.next().is_some() {
        return None;
    }
    // `mm:ss.fff` where there are two parts.
    let (hours, minutes, seconds) = match seconds {
        Some(seconds) => (hours, minutes, seconds),
        None if minutes.contains(['.', ',']) => ("0", hours, minutes),
        None => return None,
    };
    let whole = |text: &str| -> Option<i64> {
        let is_digits = !text.is_empty() && text.bytes().all(|of| of.is_ascii_digit());
        is_digits.then(|| text.parse().ok()).flatten()
    };
    let seconds_ns = nanoseconds(seconds, 9).filter(|ns| *ns >= 0)?;
    let minutes = whole(hours)?
        .checked_mul(60)?
        .checked_add(whole(minutes)?)?;
    minutes.checked_mul(60_000_000_000)?.checked_add(seconds_ns)
}

/// A time of day, and how far its zone is ahead \[ns\].
fn zoned(text: &str) -> Option<(&str, i64)> {
    let text = text.strip_suffix("UTC").unwrap_or(text).trim_end();
    if let Some(clock) = text.strip_suffix(['Z', 'z']) {
        return Some((clock, 0));
    }
    let Some(at) = text.rfind(['+', '-']) else {
        return Some((text, 0));
    };
    let (clock, zone) = text.split_at(at);
    let digits: String = zone[1..].chars().filter(|of| *of != ':').collect();
    let is_zone = matches!(digits.len(), 2 | 4) && digits.bytes().all(|of| of.is_ascii_digit());
    if !is_zone {
        return None;
    }
    let hours: i64 = digits[..2].parse().ok()?;
    let minutes: i64 = digits.get(2..4).map_or(Some(0), |of| of.parse().ok())?;
    let ahead_ns = (60 * hours + minutes) * 60_000_000_000;
    Some((
        clock.trim_end(),
        if zone.starts_with('-') {
            -ahead_ns
        } else {
            ahead_ns
        },
    ))
}

/// Days since 1970 of a date of the Gregorian calendar, the year first.
fn days_since_1970(date: &str) -> Option<i64> {
    let parts: Vec<&str> = date.split(['-', '/', '.']).collect();
    let [year, month, day] = parts[..] else {
        return None;
    };
    if year.len() != 4 {
        return None;
    }
    let number = |text: &str| text.parse::<u16>().ok().map(i64::from);
    let (year, month, day) = (number(year)?, number(month)?, number(day)?);
    if !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    // Years that begin in March, so that the day of a leap year is the last.
    let (year, month) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let days_before_month = (153 * month + 2) / 5;
    let leaps = year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
    const DAYS_UNTIL_1970: i64 = 719_469;
    Some(365 * year + leaps + days_before_month + day - DAYS_UNTIL_1970)
}

#[cfg(test)]
mod tests {
    use super::{nanoseconds, text_time};
    use proptest::prelude::*;

    #[test]
    fn decimals_become_nanoseconds_exactly() {
        for (text, power, expected) in [
            ("1403636580.838555574", 9, Some(1_403_636_580_838_555_574)),
            ("0,5", 9, Some(500_000_000)),
            ("-1.5", 9, Some(-1_500_000_000)),
            ("1.403636580838555574e9", 9, Some(1_403_636_580_838_555_574)),
            ("1e-3", 9, Some(1_000_000)),
            ("0.00000000049", 9, Some(0)),
            ("0.0000000005", 9, Some(1)),
            ("12.5", 0, Some(13)),
            ("+7", 6, Some(7_000_000)),
            (".5", 9, Some(500_000_000)),
            ("9223372036854775807", 0, Some(i64::MAX)),
            ("9223372036854775808", 0, None),
            ("0e99999", 9, Some(0)),
            ("1e99999", 9, None),
            ("1e-99999", 9, Some(0)),
            ("", 9, None),
            (".", 9, None),
            ("-", 9, None),
            ("1.2.3", 9, None),
            ("nan", 9, None),
            ("0x10", 9, None),
        ] {
            assert_eq!(nanoseconds(text, power), expected, "{text}");
        }
    }

    #[test]
    fn times_as_texts_are_read() {
        let day = 86_400_000_000_000_i64;
        for (text, ns, has_date) in [
            ("1970-01-01T00:00:00Z", 0, true),
            (
                "2026-01-05T10:00:00.008509Z",
                1_767_607_200_008_509_000,
                true,
            ),
            (
                "2026-01-05 11:00:00.25+01:00",
                1_767_607_200_250_000_000,
                true,
            ),
            (
                "2026/01/05 05:00:00,5 -0500",
                1_767_607_200_500_000_000,
                true,
            ),
            ("2000-03-01T00:00:00", 11_017 * day, true),
            ("2000-02-29T00:00:00", 11_016 * day, true),
            ("10:00:00.016", 36_000_016_000_000, false),
            ("02:03.5", 123_500_000_000, false),
        ] {
            let found = text_time(text).unwrap_or_else(|| panic!("{text}"));
            assert_eq!((found.ns, found.has_date), (ns, has_date), "{text}");
        }
        for text in [
            "",
            ":",
            "12",
            "a:b:c",
            "10:00",
            "2026-13-05T10:00:00",
            "05.01.2026 10:00:00",
            "1:2:3:4",
        ] {
            assert_eq!(text_time(text), None, "{text}");
        }
    }

    proptest! {
        #[test]
        fn nanoseconds_of_seconds_are_read_again(ns in any::<i64>()) {
            let sign = if ns < 0 { "-" } else { "" };
            let of = ns.unsigned_abs();
            let text = format!("{sign}{}.{:09}", of / 1_000_000_000, of % 1_000_000_000);
            let expected = (ns != i64::MIN).then_some(ns);
            prop_assert_eq!(nanoseconds(&text, 9), expected);
        }

        #[test]
        fn any_text_is_answered(text in ".{0,30}", power in -30_i32..30) {
            let _ = nanoseconds(&text, power);
            let _ = text_time(&text);
        }

        #[test]
        fn any_date_is_answered(text in "[-+0-9:TZ ./]{0,40}") {
            let _ = text_time(&text);
        }
    }
}
