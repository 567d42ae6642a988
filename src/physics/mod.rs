//! Rigid bodies: what they are ([`body`], [`shape`]), how they fly ([`flow`]), where
//! they touch ([`contact`], [`features`]) and how they bounce ([`impact`]); each formula beside its derivatives. All of parry is behind [`shape`].

pub mod body;
pub mod contact;
pub mod features;
pub mod flow;
pub mod impact;
pub mod observe;
pub mod shape;
pub mod state;

pub use body::{Body, BodyError};
pub use shape::{Shape, ShapeError};
pub use state::State;
