//! Stage 2: cut the streams at the marks ([`cut`]), and move marks that reaction time has put
//! beside their collision ([`refine`]).

pub mod cut;
pub mod refine;

pub use cut::{SegmentError, cut};
pub use refine::refine;
