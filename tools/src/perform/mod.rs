//! The performance maker: recordings of acted motions whose truth is known.
//!
//! A true physical motion ([`truth`], [`styles`], [`hat_box`], [`mod@bounces`], [`mod@clatter`], [`mod@flips`], [`rolls`]; [`die`] is
//! none) is performed as a person would ([`act`]): slowly, in a wavering [`tempo`], with a hand
//! that wanders ([`wander`]) and may round what impacts bend, before a tracker that is noisy, jitters
//! and loses sight. A seed and the knobs in [`acting`] determine every byte.

pub mod act;
pub mod acting;
pub mod bounces;
pub mod clatter;
pub mod die;
mod drawn;
pub mod encounter;
pub mod flips;
pub mod hat_box;
pub mod held;
pub mod keyframes;
mod kink;
pub mod performance;
pub mod recording;
pub mod rolls;
mod streams;
pub mod styles;
pub mod tempo;
pub mod truth;
pub mod wander;
pub mod wish;

pub use act::perform;
pub use acting::{Acting, Outliers};
pub use bounces::{Polyhedron, Throw, bounces, thrown};
pub use clatter::clatter;
pub use flips::flips;
pub use keyframes::{Keyframed, Keyframing, Off};
pub use performance::Performance;
pub use rolls::Roll;
pub use styles::Style;
pub use truth::{Truth, TruthError, simulate};
