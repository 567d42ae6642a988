//! Calm: a pull towards rest, which chooses among motions that are seen alike.
//!
//! Of a body whose centre of mass alone is seen, nothing tells how it turns, but as far as impacts and goals
//! do. Of all motions that are seen alike the least is meant: the state `q = (x, R, v, ω)` of a flight of
//! which no track sees both places and orientations is pulled to rest,
//!
//! ```text
//! ½ |U⁻¹ (q ⊟ rest)|²
//! ```
//!
//! with units `U` so large that nothing that is seen gives way. What only a pull holds counts as
//! undetermined ([`covariance`](crate::estimate::covariance)).

use crate::estimate::problem::pull::Pull;
use crate::estimate::problem::{Arc, Shows};
use crate::physics::State;

/// How far from rest a motion may stray where nothing is seen of it: a standard deviation of position
/// \[m\], orientation \[rad\], velocity [m/s] and angular velocity [rad/s].
const STRAY: [f64; 4] = [30.0, 10.0, 30.0, 100.0];

/// The pulls on arcs of which places or orientations are not seen.
pub(in crate::estimate) fn pulls(arcs: &[Arc]) -> Vec<Pull> {
    let pulls = arcs.iter().enumerate().filter_map(|(arc, of)| {
        let [place, turn] = [0, 1].map(|kind| is_seen(of, kind));
        let unit = |part: usize| {
            let is_seen = [place, turn][part % 2];
            if is_seen { f64::INFINITY } else { STRAY[part] }
        };
        let is_open = of.sample_count() > 0 && !(place && turn);
        is_open.then(|| Pull::new(arc, State::at_rest(), 1.0, std::array::from_fn(unit)))
    });
    pulls.collect()
}

/// Whether samples show the places (0) or the orientations (1) of a flight, with a weight that is not
/// nothing.
fn is_seen(arc: &Arc, kind: usize) -> bool {
    let mut whole = arc.views.iter().filter(|view| match view.shows {
        Shows::Pose | Shows::Orientation => true,
        Shows::Point => view.is_plain,
        Shows::Direction(_) => false,
    });
    whole.any(|view| !view.samples.is_empty() && view.kinds()[kind])
}
