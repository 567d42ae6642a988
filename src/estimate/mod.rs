//! Stage 4: the estimation.

pub mod constraint;
pub mod descend;
pub mod finish;
pub mod layout;
pub mod merit;
pub mod point;
pub mod problem;
pub mod recipe;
pub mod samples;
pub mod system;
pub mod tempo;
