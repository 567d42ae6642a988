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

#[cfg(test)]
mod tests {
    use super::nanoseconds;
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
        }
    }
}
