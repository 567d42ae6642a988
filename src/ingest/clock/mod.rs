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

mod follower;
mod smoother;
mod stream;

pub use follower::Follower;
pub use smoother::Smoother;
pub use stream::{ClockQuality, Reading, StreamClock};
