//! What the tools and the tests of `enact` share.
//!
//! - performances with known truth: [`perform`], estimated as a [`case`]; whole [`scenes`] drawn at random, and [`mod@phases`] of motions; [`fits`] of one truth; [`goals`] near them; [`hands`] that wander
//!   otherwise, [`nonsense`] that is no such performance, what nothing ties to it ([`beside`]), and what makes it hard ([`stress`],
//!   [`mod@open`]); real [`tosses`] of a cube, of household [`objects`] and of an [`elbow`];
//! - answers from elsewhere: [`starts`] of the solver about the truth, covariances by [`dense`]
//!   matrices, other [`methods`] of estimation, [`ways`] of posing the same problem, free turns to
//!   thirty digits ([`mod@reference`]), problems and mechanisms for other
//!   programs ([`export`], [`mechanism_file`]);
//! - how far an answer is off ([`errors`]) and two motions are [`apart`](mod@apart), and the committed measurements of flows ([`front`]);
//! - a [`tracker`] that publishes what it is told, and the program's answer to a recording ([`replay`]).
//!
//! The measurements themselves are the program `measure`.

#![forbid(unsafe_code)]

pub mod apart;
pub mod beside;
pub mod case;
pub mod dense;
pub mod elbow;
pub mod errors;
pub mod export;
pub mod fits;
pub mod front;
pub mod goals;
pub mod hands;
pub mod joint_wrongs;
pub mod mechanism_file;
pub mod methods;
pub mod nonsense;
pub mod objects;
pub mod open;
pub mod parts;
pub mod perform;
pub mod phases;
pub mod reference;
pub mod replay;
pub mod scenes;
pub mod starts;
pub mod stress;
pub mod tosses;
pub mod tracker;
pub mod tree_hands;
pub mod tree_impacts;
pub mod tree_meetings;
pub mod tree_stress;
pub mod trees;
pub mod waypoints;
pub mod ways;
