//! Infers which features touch at a collision (paper §5.1) from the poses of the arc fits.
//!
//! Against a plane the lowest feature touches first, so that candidates are ranked by their gaps in
//! the poses of the fits before and after the event. Two solids are first moved back along their
//! flights to the beginning of their overlap; there candidates are ranked by their gap plus the
//! distance of their contact points from the solids (since features are infinite as geometry).

mod fitted;
mod flights;
mod rank;
mod ranking;
mod solids;

pub use self::fitted::Fitted;
use self::flights::ContactFlights;
pub use self::rank::ranked;
pub use self::ranking::{Ranking, Reach};
use crate::motion::{Guess, Scene, Segment, Sketch};

/// Ranks the candidates of an open collision by the arc fits on both sides of it.
///
/// There are none where no pair of features may touch.
pub fn rank(
    scene: &Scene,
    sketch: &Sketch,
    segments: &[Segment],
    guess: &Guess,
    event: usize,
) -> Ranking {
    let flights = ContactFlights {
        scene,
        sketch,
        segments,
        guess,
        event,
    };
    ranked(scene, event, &flights)
}
