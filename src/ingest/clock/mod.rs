//! When a live sample was measured: state machines from what a driver says and when it came to
//! a stamp. They read no clock themselves.
//!
//! | source | stamp | for |
//! |---|---|---|
//! | `sample` | the driver's time on the system clock, as it is | drivers that know it |
//! | `device` | the device's clock plus the least delay seen ([`Follower`]) | trackers with a clock of their own |
//! | `sequence` | the sequence number over the nominal rate, likewise | trackers that keep a rate and number their readings |
//! | `receipt` | arrival, through a filter that knows the stream is even ([`Smoother`]) | nothing else to go by |
//!
//! Where the scene does not say, the first valid sample decides: `sample` if it has such a time,
//! else `device` if it has that, else `receipt`. A clock that is set or a publisher that
//! restarts does not tear the stamps apart: [`StreamClock`] goes on from the last stamp by the
//! time between arrivals, and counts it.
//!
//! # What is noticed of a clock that is set
//!
//! | stream | forward | back |
//! |---|---|---|
//! | live and even ([`Cadence`]), after 32 samples | more than 10 ms and 8 times the noise | the same |
//! | any other: played faster than it was made, uneven, in bursts | more than 500 ms | more than 50 ms |
//!
//! The noise is that of intervals between readings and of delays on the way: 1 ms and less on an
//! idle machine, so that 10 ms decide. What is less than that stays in `sample` stamps as the
//! driver said it; of `device` stamps a step forward is never seen, for the least delay follows it
//! at once, and a step back is drawn out at 1 ms a second. `receipt` does not depend on other
//! clocks; `sequence` has none.

mod cadence;
mod follower;
mod smoother;
mod stream;

pub use cadence::Cadence;
pub use follower::Follower;
pub use smoother::Smoother;
pub use stream::{ClockQuality, Reading, StreamClock};
