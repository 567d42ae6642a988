//! Numbers with units for people.

/// Decimals that show two digits of a standard deviation, from none to eight.
pub fn decimals(sd: Option<f64>) -> usize {
    match sd {
        // Rounded down, log₁₀ is where the first digit stands.
        Some(sd) if sd > 0.0 && sd < 10.0 => (1.0 - sd.log10().floor()).min(8.0) as usize,
        Some(sd) if sd >= 10.0 => 0,
        _ => 4,
    }
}

/// The unit in which people read values in an SI unit, and how many of it are one.
pub fn for_people(unit: &str) -> (f64, &str) {
    match unit {
        "rad" => (1f64.to_degrees(), "°"),
        "m" => (1e3, "mm"),
        "s" => (1e3, "ms"),
        "s/s" => (1e2, "%"),
        other => (1.0, other),
    }
}

/// A standard deviation of a time.
pub fn deviation_ms(sd_s: f64) -> String {
    if sd_s < 5e-5 {
        "± < 0.1 ms".into()
    } else {
        format!("± {:.1} ms", sd_s * 1e3)
    }
}

/// A time to the millisecond.
pub fn seconds(seconds: f64) -> String {
    format!("{seconds:.3} s")
}

/// A wall time.
pub fn duration(seconds: f64) -> String {
    if seconds < 1.0 {
        format!("{:.2} ms", seconds * 1e3)
    } else {
        format!("{seconds:.2} s")
    }
}

/// A length in the unit that suits it.
pub fn length(m: f64) -> String {
    if m < 1e-6 {
        "< 1 µm".into()
    } else if m < 1e-3 {
        format!("{:.0} µm", m * 1e6)
    } else {
        format!("{:.1} mm", m * 1e3)
    }
}

/// An angle in degrees.
pub fn angle(rad: f64) -> String {
    let degrees = rad.to_degrees();
    if degrees < 1e-3 {
        "< 0.001°".into()
    } else {
        format!("{degrees:.3}°")
    }
}

/// The end of a range.
pub fn bound(value: f64) -> String {
    match value {
        f64::INFINITY => "∞".into(),
        f64::NEG_INFINITY => "-∞".into(),
        _ => format!("{value:.4}")
            .trim_end_matches('0')
            .trim_end_matches('.')
            .to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_digits_of_a_deviation_are_shown() {
        for (sd, expected) in [
            (Some(0.0213), 3),
            (Some(0.1), 2),
            (Some(2.5), 1),
            (Some(37.0), 0),
            (Some(1e-30), 8),
            (Some(0.0), 4),
            (Some(f64::NAN), 4),
            (None, 4),
        ] {
            assert_eq!(decimals(sd), expected, "{sd:?}");
        }
    }

    #[test]
    fn gaps_have_units_for_people() {
        assert_eq!(length(3e-9), "< 1 µm");
        assert_eq!(length(4.2e-5), "42 µm");
        assert_eq!(length(0.0394), "39.4 mm");
        assert_eq!(angle(0.1), "5.730°");
        assert_eq!(bound(f64::NEG_INFINITY), "-∞");
        assert_eq!(bound(-12.0), "-12");
        assert_eq!(bound(0.25), "0.25");
    }
}
