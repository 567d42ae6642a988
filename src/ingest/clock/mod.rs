//! The stamps of live samples: state machines from a driver's reading and its arrival to the time
//! of measurement. They read no clock themselves.
//!
//! | source | stamp | for |
//! |---|---|---|
//! | `sample` | the driver's time on the system clock, as it is | drivers that know it |
//! | `device` | the device's clock plus the least delay seen ([`Follower`]) | trackers with a clock of their own |
//! | `sequence` | the sequence number over the nominal rate, likewise | trackers that keep a rate and number their readings |
//! | `receipt` | arrival, through a filter that knows the stream is even ([`Smoother`]) | nothing else to go by |
//!
//! Where the scene names no source, the first valid sample decides: `sample` if it has such a time,
//! else `device` if it has that, else `receipt`. When a clock is set or a publisher restarts,
//! [`StreamClock`] continues from the last stamp by the time between arrivals, and counts it.
//!
//! # Which steps of a clock are detected
//!
//! | stream | forward | back |
//! |---|---|---|
//! | live and even ([`Cadence`]), after 32 samples | more than 10 ms and 8 times the noise | the same |
//! | any other: played faster than it was made, uneven, in bursts | more than 500 ms | more than 50 ms |
//!
//! The noise is that of intervals between readings and of delivery delays: 1 ms and less on an
//! idle machine, so that 10 ms decide. Smaller steps stay in `sample` stamps. In `device` stamps a
//! small step forward disappears, since the least delay follows it at once, and a small step back
//! is spread over time at 1 ms per second. `receipt` does not depend on other clocks; `sequence`
//! uses none.

mod cadence;
mod follower;
mod smoother;
mod stream;

pub use cadence::Cadence;
pub use follower::Follower;
pub use smoother::Smoother;
pub use stream::{ClockQuality, StampReading, StreamClock};
