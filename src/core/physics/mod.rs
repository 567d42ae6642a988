//! Rigid bodies: their mass, drag, lift and shape ([`body`], [`drag`], [`shape`]), free flight ([`flow`]), contact
//! geometry ([`contact`], [`features`]), impacts ([`impact`]) and how they are measured
//! (`observe`). Each formula stands beside its derivatives. Only [`shape`] imports parry.

pub mod body;
pub mod contact;
pub mod drag;
pub mod driven;
pub mod features;
pub mod flow;
pub mod impact;
pub mod observe;
pub mod outline;
pub mod shape;
pub mod state;
pub mod stuck;
pub mod support;
pub mod tree;

pub use body::{Body, BodyError};
pub use drag::Drag;
pub use shape::{Shape, ShapeError};
pub use state::State;
pub use support::{OnPlane, PlaneSupport, Support, Sustained};
