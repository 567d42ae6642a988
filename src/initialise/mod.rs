//! Stage 3: a first guess, arc by arc (paper §6.2.1): the centre of mass first, with an
//! unknown duration where the tempo is unknown ([`ballistic`], on a [`clock`] that the turning
//! tells), then orientation ([`turn`]),
//! then all arcs on one time line ([`guess()`]); from these what touches where the scene leaves
//! that open ([`contact`]), and what marks weigh beside samples ([`weigh()`]).

pub mod ballistic;
pub mod clock;
pub mod contact;
pub mod guess;
pub mod turn;
pub mod weigh;

pub use guess::guess;
pub use weigh::weigh;
