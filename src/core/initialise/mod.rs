//! Stage 3: a first guess, arc by arc (paper §6.2.1): the centre of mass first, with an
//! unknown duration where the tempo is unknown ([`ballistic`], in the times of a [`clock`] from the
//! body's rotation), then orientation ([`turn`]), then all arcs on one time line ([`guess()`]).
//! From these follow the contacts that the scene leaves open ([`contact`], paper §5.1), and the
//! weight of marks relative to samples ([`weigh()`]).

mod aliased;
pub mod ballistic;
pub mod between;
mod carried;
mod circle;
pub mod clock;
pub mod contact;
mod crossing;
mod fit;
mod flights;
pub mod guess;
mod keyed;
mod open_times;
mod pointing;
pub mod readings;
mod rebound;
mod released;
mod roll;
mod swing;
mod tied;
pub mod tree;
pub mod turn;
mod twirl;
mod unseen;
pub mod weigh;

pub use guess::guess;
pub use weigh::weigh;
