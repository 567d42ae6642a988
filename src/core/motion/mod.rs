//! The data that the stages exchange: the trackers' readings ([`take`]), the scene ([`scene`]), the
//! performance as the estimator sees it ([`sketch`]), the result ([`estimate`]), how certain it is ([`certainty`]), the checks of it
//! ([`verification`]), doubts about it ([`doubt`]), likely mistakes in what
//! is said of it ([`diagnosis`]), what it says of quantities that takes share ([`take_share`]), its continuation ([`settled`]) and how it ends ([`rest`]), free flights in a path
//! ([`mod@fall`]), what is seen besides flights ([`seen_phase`]), and the observer of a run ([`observe`]).

mod borne;
pub mod certainty;
pub mod contact_rival;
pub mod diagnosis;
pub mod doubt;
pub mod estimate;
pub mod fall;
pub mod fit;
pub mod guess;
pub mod held;
pub mod index;
pub mod joined;
mod keyframe;
pub mod keyframes;
mod knocks;
pub mod observe;
pub mod open;
mod open_times;
pub mod partial;
mod performance;
pub mod reason;
pub mod rest;
pub mod sample_time;
pub mod scene;
pub mod seen_phase;
pub mod settled;
pub mod sketch;
pub mod snap;
pub mod spread;
pub mod suspect;
pub mod take;
pub mod take_share;
pub mod time_map;
pub mod verdict;
pub mod verification;

pub use borne::BorneForce;
pub use certainty::{FlightCertainty, FlightChange, StateDeviation, Variance};
pub use contact_rival::{ContactRival, Standing};
pub use diagnosis::{
    Diagnosis, Distance, LengthUnit, MountSlip, QuaternionSlip, Remedy, SignedAxis,
};
pub use doubt::{About, Doubt, Place};
pub use estimate::{
    ArcEstimate, AtBound, Counters, DurationEstimate, Estimate, EventEstimate, Gap, Leaning,
    MotionPart, ParameterEstimate, SegmentResidual, Undetermined,
};
pub use fall::{Fall, acceleration, falls};
pub use fit::{Fit, FitUntold, Fits, Tested};
pub use guess::{ArcGuess, Guess};
pub use held::{Driven, HeldMotion};
pub use index::{ContactLawIndex, LinkIndex, MechanismIndex, TrackIndex};
pub use joined::{TrackResidual, TreeEstimate, TreeKnot};
pub use keyframe::{Keyframe, KeyframeTime, Mount, SketchRow};
pub use observe::{Counted, Observer, Phase, Quiet, WorkLimited};
pub use open::Contacts;
pub use performance::Performance;
pub use reason::{End, Measured, Progress, Reason};
pub use rest::{Lie, Rest, RestWork};
pub use sample_time::SampleTime;
pub use scene::{
    Against, AtPivot, Axes, BodyPoint, Collision, CollisionError, Combination, Condition, Cone,
    ContactLaw, Event, EventKind, EventTime, Feature, FreeBody, FreeParameter, Goal, GoalEstimate,
    GoalQuantity, GoalSet, GoalTarget, GoalUnit, Group, Held, InHand, Joint, JointEnd, JointTree,
    Link, Mechanism, Moment, Obstacle, OnSurface, Partner, Performer, Quantity, RestGoal, Scene,
    Sees, StuckPair, StuckTo, SupportPhase, SupportedBy, Surface, Timing, Together, Touching,
    Track, TreeTouch, Untold, VelocityGaps, Weighing, Weights,
};
pub use seen_phase::{SeenMotion, SeenOnSurface, SeenPhase};
pub use settled::{Settled, SettledLink};
pub use sketch::{
    DropReason, Grip, MarkChanges, MarkTime, Sample, SampleCounts, Seen, Segment, Sketch,
    TrackSketch, View,
};
pub use snap::SnapError;
pub use spread::{LinkSpread, Spread};
pub use suspect::Suspect;
pub use take::{
    Covariance, Holds, Mark, OpenTime, PoseSample, SampleSource, Stamp, StampSource, TakeEvent,
};
pub use take_share::TakeShare;
pub use time_map::TimeMap;
pub use verdict::Verdict;
pub use verification::{Balance, Deviation, Penetration, Pull, SingleShot, Touch, Verification};
