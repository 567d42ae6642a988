//! Units of tables.

use crate::motion::LengthUnit;

/// What a column of times counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeUnit {
    /// Seconds.
    Second,
    /// Milliseconds.
    Millisecond,
    /// Microseconds.
    Microsecond,
    /// Nanoseconds.
    Nanosecond,
    /// Frames at a rate.
    Frame,
}

impl TimeUnit {
    /// The unit with a name, as heads of tables and people write it.
    pub fn of(name: &str) -> Option<Self> {
        match name {
            "s" | "sec" | "secs" | "second" | "seconds" => Some(Self::Second),
            "ms" | "msec" | "millis" | "millisecond" | "milliseconds" => Some(Self::Millisecond),
            "us" | "µs" | "μs" | "usec" | "micros" | "microsecond" | "microseconds" => {
                Some(Self::Microsecond)
            }
            "ns" | "nsec" | "nsecs" | "nanosec" | "nanos" | "nanosecond" | "nanoseconds" => {
                Some(Self::Nanosecond)
            }
            "frame" | "frames" => Some(Self::Frame),
            _ => None,
        }
    }

    /// The power of ten that makes nanoseconds of it; `None` for frames.
    pub(super) fn nanosecond_power(self) -> Option<i32> {
        match self {
            Self::Second => Some(9),
            Self::Millisecond => Some(6),
            Self::Microsecond => Some(3),
            Self::Nanosecond => Some(0),
            Self::Frame => None,
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Second => "s",
            Self::Millisecond => "ms",
            Self::Microsecond => "µs",
            Self::Nanosecond => "ns",
            Self::Frame => "frames",
        }
    }
}

/// The unit of length with a name, as heads of tables and people write it.
pub fn length_unit(name: &str) -> Option<LengthUnit> {
    match name {
        "m" | "meter" | "meters" | "metre" | "metres" => Some(LengthUnit::Metre),
        "cm" | "centimeter" | "centimeters" | "centimetre" | "centimetres" => {
            Some(LengthUnit::Centimetre)
        }
        "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => {
            Some(LengthUnit::Millimetre)
        }
        "in" | "inch" | "inches" => Some(LengthUnit::Inch),
        "ft" | "foot" | "feet" => Some(LengthUnit::Foot),
        _ => None,
    }
}
