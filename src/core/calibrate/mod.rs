//! Calibration: what a scene says of a tracker and of the room, measured with the tracker itself.
//!
//! | calibration | performed | found |
//! |---|---|---|
//! | [`pivot()`] | the tip stays in one place, the object swings about it | the tip in the tracker's axes, the place |
//! | [`plane()`] | the tip touches the table, three times or more, not in a line | the table's normal and place |
//! | [`rest()`], [`mount()`] | the object stands still, on one side or on several | the tracker's noise; how the tracker is turned on the body |
//! | [`gravity()`] | drops or tosses | gravity in the tracker's frame; what it says of axes and units |
//! | [`clock()`] | two trackers on one object that turns | offset and drift between their clocks |
//!
//! # Intervals
//!
//! The noise of trackers and hands is correlated in time, so that samples are not worth their number. Each
//! calibration is estimated again without one block of time after the other (delete-block jackknife, a cluster-robust
//! covariance of type CR3; Cameron and Miller, "A Practitioner's Guide to Cluster-Robust Inference", 2015),
//! in blocks longer than the residuals are correlated; intervals are those of Student's t with as many
//! degrees of freedom as blocks, less one. Where residuals wander as slowly as the recording is long no blocks are
//! independent, and the result says so ([`Spread::is_slow`]). Of short flights the correlation is marginalised instead,
//! and of touches each counts as one.
//!
//! What is common to the whole recording is in no interval: a tip that rolls, a tracker whose scale is
//! wrong, a table that is bent.

mod clock;
mod error;
mod flights;
mod gravity;
mod mount;
mod pivot;
mod plane;
mod regression;
mod rest;
mod spread;
mod stream;
mod turn_rate;

pub use clock::{ClockFit, clock};
pub use error::CalibrateError;
pub use flights::{LEAST as LEAST_FLIGHT, flights};
pub use gravity::{Flight, GravityFit, LengthUnit, gravity, unlike};
pub use mount::{Mounted, Standing, mount};
pub use pivot::{PivotFit, pivot};
pub use plane::{PlaneFit, Touch, plane, touch};
pub use rest::{NoiseAxis, RestFit, rest};
pub use spread::{CONFIDENCE, Measured, Spread};
pub use stream::{Reading, Stream};
