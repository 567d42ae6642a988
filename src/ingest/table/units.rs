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
    /// Ticks of 100 ns, as Windows and .NET count.
    Tick,
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
            "ms" | "msec" | "msecs" | "millis" | "millisec" | "millisecond" | "milliseconds" => {
                Some(Self::Millisecond)
            }
            "us" | "µs" | "μs" | "usec" | "usecs" | "micros" | "microsec" | "microsecond"
            | "microseconds" => Some(Self::Microsecond),
            "100ns" | "tick" | "ticks" | "filetime" => Some(Self::Tick),
            "ns" | "nsec" | "nsecs" | "nanosec" | "nanosecs" | "nanos" | "nanosecond"
            | "nanoseconds" => Some(Self::Nanosecond),
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
            Self::Tick => Some(2),
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
            Self::Tick => "100ns",
            Self::Nanosecond => "ns",
            Self::Frame => "frames",
        }
    }
}

/// Unit of angles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AngleUnit {
    /// A full turn is 2π.
    Radian,
    /// A full turn is 360.
    Degree,
}

impl AngleUnit {
    /// The unit with a name, as heads of tables and people write it.
    pub fn of(name: &str) -> Option<Self> {
        match name {
            "deg" | "degs" | "degree" | "degrees" | "°" | "º" => Some(Self::Degree),
            "rad" | "rads" | "radian" | "radians" => Some(Self::Radian),
            _ => None,
        }
    }

    /// As it is written for `--angle-unit`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Radian => "rad",
            Self::Degree => "deg",
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

/// The name of a unit of length, as `--length-unit` takes it.
pub fn length_name(unit: LengthUnit) -> &'static str {
    match unit {
        LengthUnit::Millimetre => "mm",
        LengthUnit::Centimetre => "cm",
        LengthUnit::Inch => "in",
        LengthUnit::Foot => "ft",
        LengthUnit::Metre => "m",
    }
}
