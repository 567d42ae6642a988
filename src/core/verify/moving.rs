//! The motion of one link: its estimated arcs, and bounds of its speeds.

use nalgebra::Vector3;

use super::bound::SpeedBound;
use super::link::{JoinedLink, piece};
use crate::motion::held::{GripEstimate, HeldEstimate};
use crate::motion::{ArcEstimate, Estimate, Link, LinkIndex, Scene};
use crate::physics::shape::Solid;
use crate::physics::{State, flow};

/// A link of the scene, its solid, and its arcs in order of time.
pub(super) struct MovingLink<'a> {
    pub(super) of_scene: &'a Link,
    pub(super) solid: Solid,
    pub(super) radius_m: f64,
    /// Which of its features the scene declares besides the shape's own: to find them all faces are computed.
    is_declared: Vec<bool>,
    /// Of a held link, what of its motion lies between its collisions; with what it does in a hand for a while.
    pub(super) arcs: Vec<ArcEstimate>,
    /// Its motion, if it is held.
    pub(super) held: Option<&'a HeldEstimate>,
    /// Its motions while it is in a hand.
    grips: Vec<&'a GripEstimate>,
    /// Its motion, if it is joined to others.
    joined: Option<JoinedLink<'a>>,
    gravity_m_s2: Vector3<f64>,
}

impl<'a> MovingLink<'a> {
    pub(super) fn new(scene: &'a Scene, index: LinkIndex, estimate: &'a Estimate) -> Self {
        let of_scene = &scene.links[index];
        let mechanism = of_scene.mechanism;
        let is_its = |arc: &&ArcEstimate| arc.mechanism == mechanism && arc.end_s >= arc.start_s;
        let held = estimate.held_motion(index);
        let joined = JoinedLink::new(scene, index, estimate);
        let arcs = match (held, &joined) {
            (Some(held), _) => between_collisions(held, scene, index, estimate),
            (None, Some(joined)) => joined.arcs(),
            (None, None) => {
                let flights = estimate.arcs.iter().filter(is_its).cloned();
                let grips = estimate.grips_of(index);
                let grips = grips.map(|of| piece(mechanism, of.span_s, of.state(of.span_s[0])));
                let mut arcs: Vec<ArcEstimate> = grips.chain(flights).collect();
                arcs.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
                arcs
            }
        };
        Self {
            of_scene,
            solid: of_scene.solid(),
            radius_m: of_scene.radius_m(),
            is_declared: {
                let mut is_declared = vec![false; of_scene.features.len()];
                for feature in of_scene.declared_features() {
                    is_declared[feature] = true;
                }
                is_declared
            },
            arcs,
            held,
            grips: estimate.grips_of(index).collect(),
            joined,
            gravity_m_s2: estimate.gravity_m_s2,
        }
    }

    /// The link, and which of its features its scene declares.
    pub(super) fn is_declared(&self) -> &[bool] {
        &self.is_declared
    }

    /// What moves it on an arc, if a hand does that for a while.
    pub(super) fn grip(&self, arc: &ArcEstimate) -> Option<&'a GripEstimate> {
        let is_it = |of: &&&GripEstimate| of.span_s == [arc.start_s, arc.end_s];
        self.grips.iter().find(is_it).copied()
    }

    /// The state on an arc.
    pub(super) fn state(&self, arc: &ArcEstimate, time_s: f64) -> State {
        if let Some(held) = self.held {
            return held.state(time_s);
        }
        if let Some(grip) = self.grip(arc) {
            return grip.state(time_s);
        }
        if let Some(joined) = &self.joined {
            return joined.state(arc, time_s);
        }
        let since_s = time_s - arc.epoch_s;
        let body = self.of_scene.body.with_support(arc.support);
        flow::advance(&body, &self.gravity_m_s2, &arc.state, since_s)
    }

    /// The arc that ends at a time.
    pub(super) fn ending_at(&self, time_s: f64) -> Option<&ArcEstimate> {
        self.arcs.iter().find(|arc| arc.end_s == time_s)
    }

    /// The arc that begins at a time.
    pub(super) fn starting_at(&self, time_s: f64) -> Option<&ArcEstimate> {
        self.arcs.iter().find(|arc| arc.start_s == time_s)
    }

    /// Upper bound of the speed of all points of the link on a part of an arc [m/s]: `|v| + |ω| r`.
    pub(super) fn speed_bound_m_s(&self, arc: &ArcEstimate, from_s: f64, to_s: f64) -> f64 {
        let grip = self.grip(arc).map(|of| &of.motion);
        if let Some(held) = self.held.or(grip) {
            let [speed, spin] = held.curve.speed_bounds(from_s, to_s);
            return speed + spin * self.radius_m;
        }
        if let Some(joined) = &self.joined {
            return joined.speed_bound_m_s(self.radius_m);
        }
        let ends = [from_s, to_s].map(|time_s| self.state(arc, time_s));
        let body = &self.of_scene.body;
        let bound = SpeedBound::new(body, &self.gravity_m_s2, arc, &ends, to_s - from_s);
        bound.speed_m_s + bound.spin_rad_s * self.radius_m
    }
}

/// The motion of a held link as pieces between its collisions, over the time of all flights.
fn between_collisions(
    held: &HeldEstimate,
    scene: &Scene,
    link: LinkIndex,
    estimate: &Estimate,
) -> Vec<ArcEstimate> {
    let Some([start_s, end_s]) = estimate.extent_s() else {
        return Vec::new();
    };
    let hits = held.passed.iter().map(|passed| passed.time_s);
    let hits = hits.filter(|time_s| (start_s..=end_s).contains(time_s));
    let mut ends_s: Vec<f64> = [start_s].into_iter().chain(hits).chain([end_s]).collect();
    ends_s.sort_by(f64::total_cmp);
    let mechanism = scene.mechanism_of(link);
    let pieces = ends_s.windows(2);
    let pieces = pieces.map(|pair| piece(mechanism, [pair[0], pair[1]], held.state(pair[0])));
    pieces.collect()
}
