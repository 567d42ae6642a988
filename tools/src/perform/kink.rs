//! How a hand rounds the kinks of a path: an impact changes a velocity at once, and no hand does.
//!
//! Each kink is convolved with a Gaussian of standard deviation `τ`, the flights beside it are not.
//! With a velocity that changes by `Δv` at the acted time `s_k` and `u = (s − s_k)/τ` that adds
//!
//! ```text
//! Δv τ (φ(u) − |u| Φ(−|u|))
//! ```
//!
//! to the position, at most `0.4 τ |Δv|`. With the angular velocity's change `Δω` in its place it is a turn
//! about axes of the body: kinks of a rotation are taken as small turns. Where kinks overlap, shifts and
//! turns are added. Where a performer stops holding still, or begins to, the path stays as sharp as it is.

use std::f64::consts::{SQRT_2, TAU};

use enact::math::{Pose, so3};
use enact::motion::LinkIndex;
use nalgebra::Vector3;
use statrs::function::erf::erfc;

use super::tempo::Tempo;
use super::truth::Truth;

/// Standard deviations from a kink beyond which the path is the true one, to 2·10⁻¹⁰ `τ |Δv|`.
const REACH: f64 = 6.0;

/// The kinks of a link's path, as a hand rounds them.
pub(super) struct Kinks {
    kinks: Vec<Kink>,
    /// Standard deviation of the rounding [s, acted].
    rounding_s: f64,
}

/// A change of velocities.
struct Kink {
    acted_s: f64,
    /// Of the velocity [m per acted second, world].
    velocity_m_s: Vector3<f64>,
    /// Of the angular velocity [rad per acted second, body].
    angular_velocity_rad_s: Vector3<f64>,
}

impl Kinks {
    /// Those between the arcs of the link's mechanism; none where nothing is rounded.
    pub(super) fn of(truth: &Truth, link: LinkIndex, tempo: &Tempo, rounding_s: f64) -> Self {
        let mut kinks = Vec::new();
        if rounding_s > 0.0 {
            let mechanism = truth.scene.mechanism_of(link);
            let arcs = truth.arcs.iter().filter(|arc| arc.mechanism == mechanism);
            for (ended, begun) in arcs.clone().zip(arcs.skip(1)) {
                let time_s = begun.start_s;
                let [before, after] = [ended, begun].map(|arc| truth.flown(arc, time_s));
                let acted_s = tempo.acted_s(time_s);
                let rate = tempo.rate(acted_s);
                let turning_rad_s = after.angular_velocity_rad_s - before.angular_velocity_rad_s;
                kinks.push(Kink {
                    acted_s,
                    velocity_m_s: (after.velocity_m_s - before.velocity_m_s) * rate,
                    angular_velocity_rad_s: turning_rad_s * rate,
                });
            }
        }
        Self { kinks, rounding_s }
    }

    /// Where the hand has the body that truly is there at an acted time.
    pub(super) fn rounded(&self, world_from_body: Pose, acted_s: f64) -> Pose {
        let off = |kink: &Kink| ((acted_s - kink.acted_s) / self.rounding_s).abs();
        let all = self.kinks.iter().map(|kink| (kink, off(kink)));
        let mut near = all.filter(|(_, u)| *u < REACH).peekable();
        // To the bit: a turn by nothing would round.
        if near.peek().is_none() {
            return world_from_body;
        }
        let (mut shift_m, mut turn_rad) = (Vector3::zeros(), Vector3::zeros());
        for (kink, u) in near {
            let time_s = self.rounding_s * rounding(u);
            shift_m += kink.velocity_m_s * time_s;
            turn_rad += kink.angular_velocity_rad_s * time_s;
        }
        Pose::from_parts(
            (world_from_body.translation.vector + shift_m).into(),
            world_from_body.rotation * so3::exp(&turn_rad),
        )
    }
}

/// `φ(u) − u Φ(−u)` of a `u` that is not negative.
fn rounding(u: f64) -> f64 {
    (-0.5 * u * u).exp() / TAU.sqrt() - 0.5 * u * erfc(u / SQRT_2)
}
