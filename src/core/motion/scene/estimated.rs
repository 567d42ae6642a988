//! The scene as estimated: what the estimation changed, in its place.

use nalgebra::Vector3;

use super::event::EventKind;
use super::goal::GoalTarget;
use super::joint::{Joint, JointEnd};
use super::link::Mechanism;
use super::quantity::Quantity;
use super::whole::Scene;
use crate::math::{Pose, so3};
use crate::motion::estimate::Estimate;
use crate::motion::index::{LinkIndex, TrackIndex};
use crate::physics::contact::Feature;
use crate::physics::{Body, BodyError, Drag};

/// Values of quantities; what is not among them stays as the scene has it.
struct EstimatedValues<'a>(&'a [(Quantity, f64)]);

impl EstimatedValues<'_> {
    fn of(&self, quantity: Quantity) -> Option<f64> {
        let mut values = self.0.iter();
        let (_, value) = values.find(|(other, _)| *other == quantity)?;
        Some(*value)
    }

    /// Corrections along three axes.
    fn vector(&self, along: impl Fn(usize) -> Quantity) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| self.of(along(axis)).unwrap_or(0.0))
    }
}

impl Scene {
    /// The scene with the parameters of an estimate of it in their places ([`Scene::with_values`]);
    /// the scene itself where no body has such moments, which only a failed estimate has.
    pub fn as_estimated(&self, estimate: &Estimate) -> Scene {
        let values = estimate.parameters.iter().filter_map(|parameter| {
            let mut free = self.parameters.iter();
            let free = free.find(|free| free.name == parameter.name)?;
            Some((free.quantity, parameter.value))
        });
        let values: Vec<(Quantity, f64)> = values.collect();
        self.with_values(&values).unwrap_or_else(|_| self.clone())
    }

    /// The scene with these values of its quantities: each in its place, so that in the result every
    /// correction is zero again and every factor one.
    ///
    /// Where a centre of mass moves, the link's axes move with it: features, shape, trackers and
    /// goals of poses and points stay where they are on the object. A surface of an obstacle takes the obstacle and
    /// all of its surfaces along. Clocks are no part of a scene: their values change nothing. The
    /// list of parameters stays as it is.
    ///
    /// Fails where no body has such a mass, moments, force, drag or lift.
    pub fn with_values(&self, values: &[(Quantity, f64)]) -> Result<Scene, BodyError> {
        let values = EstimatedValues(values);
        let mut scene = self.clone();
        scene.set_laws(&values);
        for link in self.links.keys() {
            scene.links[link].body = self.body_with(link, &values)?;
            scene.move_centre(link, values.vector(|axis| Quantity::Centre { link, axis }));
        }
        for track in self.tracks.keys() {
            scene.correct_tracker(track, &values);
        }
        for surface in 0..self.surfaces.len() {
            scene.move_surface(surface, &values);
        }
        for mechanism in &mut scene.mechanisms {
            if let Mechanism::Tree(tree) = mechanism {
                tree.joints
                    .iter_mut()
                    .for_each(|joint| set_joint(joint, &values));
            }
        }
        Ok(scene)
    }

    /// Gravity, restitution, friction and the tilts that impacts see.
    fn set_laws(&mut self, values: &EstimatedValues) {
        for axis in 0..3 {
            let gravity = values.of(Quantity::Gravity { axis });
            self.gravity_m_s2[axis] = gravity.unwrap_or(self.gravity_m_s2[axis]);
        }
        for (law, of) in self.contact_laws.iter_mut_enumerated() {
            let restitution = values.of(Quantity::Restitution { law });
            of.restitution = restitution.unwrap_or(of.restitution);
            let friction = values.of(Quantity::Friction { law });
            of.friction = friction.unwrap_or(of.friction);
            let tangential = values.of(Quantity::TangentialRestitution { law });
            of.tangential_restitution = tangential.unwrap_or(of.tangential_restitution);
        }
        for (event, of) in self.events.iter_mut().enumerate() {
            if let EventKind::Collision(collision) = &mut of.kind {
                for (tangent, tilt_rad) in collision.tilt_rad.iter_mut().enumerate() {
                    let tilt = values.of(Quantity::Tilt { event, tangent });
                    *tilt_rad = tilt.unwrap_or(*tilt_rad);
                }
            }
        }
    }

    fn body_with(&self, link: LinkIndex, values: &EstimatedValues) -> Result<Body, BodyError> {
        let of = &self.links[link];
        if of.held.is_some() {
            return Ok(of.body);
        }
        let factor = |quantity| values.of(quantity).unwrap_or(1.0);
        let moments = Vector3::from_fn(|axis, _| {
            let axis = of.moment_axis(axis);
            factor(Quantity::Moment { link, axis })
        });
        let body = of
            .body
            .with_factors(factor(Quantity::Mass { link }), &moments)?;
        let (force, drag) = (body.force_m_s2(), body.drag());
        let force = Vector3::from_fn(|axis, _| {
            let value = values.of(Quantity::Force { link, axis });
            value.unwrap_or(force[axis])
        });
        let linear = values.of(Quantity::LinearDrag { link });
        let quadratic = values.of(Quantity::QuadraticDrag { link });
        let lift = values.of(Quantity::Lift { link });
        body.with_force(force)?
            .with_drag(Drag {
                linear_per_s: linear.unwrap_or(drag.linear_per_s),
                quadratic_per_m: quadratic.unwrap_or(drag.quadratic_per_m),
            })?
            .with_lift(lift.unwrap_or(body.lift()))
    }

    /// Moves a link's axes to where its centre of mass is \[m, its axes\].
    fn move_centre(&mut self, link: LinkIndex, by_m: Vector3<f64>) {
        if by_m == Vector3::zeros() {
            return;
        }
        let old_from_new = Pose::translation(by_m.x, by_m.y, by_m.z);
        let new_from_old = old_from_new.inverse();
        let of = &mut self.links[link];
        of.shape_at_m -= by_m;
        of.link_from_given = new_from_old * of.link_from_given;
        for feature in &mut of.features {
            feature.geometry = feature.geometry.placed(&new_from_old);
        }
        for track in self.tracks.iter_mut().filter(|track| track.link == link) {
            track.link_from_tracker = new_from_old * track.link_from_tracker;
        }
        for mechanism in &mut self.mechanisms {
            if let Mechanism::Tree(tree) = mechanism {
                for joint in &mut tree.joints {
                    joint.move_centre(link, &by_m);
                }
            }
        }
        for goal in &mut self.goals {
            match &mut goal.target {
                GoalTarget::Pose { world_from_body } if goal.link == link => {
                    *world_from_body *= old_from_new;
                }
                GoalTarget::Condition(condition) => {
                    let is_seen_from = condition.quantity.seen_from() == Some(link);
                    *condition =
                        condition
                            .clone()
                            .with_centre_moved(goal.link == link, is_seen_from, &by_m);
                }
                _ => {}
            }
        }
    }

    fn correct_tracker(&mut self, track: TrackIndex, values: &EstimatedValues) {
        let by_m = values.vector(|axis| Quantity::TrackerPosition { track, axis });
        let turn = values.vector(|axis| Quantity::TrackerOrientation { track, axis });
        let pose = &mut self.tracks[track].link_from_tracker;
        pose.translation.vector += by_m;
        if turn != Vector3::zeros() {
            pose.rotation *= so3::exp(&turn);
        }
    }

    /// Moves a face along its normal and turns it about its point, with the obstacle that it is of.
    fn move_surface(&mut self, surface: usize, values: &EstimatedValues) {
        let height_m = values.of(Quantity::SurfaceHeight { surface });
        let tilts = [0, 1].map(|tangent| values.of(Quantity::SurfaceTilt { surface, tangent }));
        if height_m.is_none() && tilts == [None; 2] {
            return;
        }
        let Feature::Face { point_m, normal } = self.surfaces[surface].geometry else {
            return;
        };
        let tangents = Feature::tangents(&normal);
        let turn: Vector3<f64> = (0..2).map(|i| tangents[i] * tilts[i].unwrap_or(0.0)).sum();
        let to_m = point_m + normal * height_m.unwrap_or(0.0);
        let rotation = so3::exp(&turn);
        let moved = Pose::from_parts((to_m - rotation * point_m).into(), rotation);
        let solid = self.surfaces[surface].obstacle;
        for (index, other) in self.surfaces.iter_mut().enumerate() {
            if index == surface || (solid.is_some() && other.obstacle == solid) {
                other.geometry = other.geometry.placed(&moved);
            }
        }
        if let Some(solid) = solid {
            let pose = &mut self.obstacles[solid].world_from_shape;
            *pose = moved * *pose;
        }
    }
}

/// Moves a joint, and turns its axes.
fn set_joint(joint: &mut Joint, values: &EstimatedValues) {
    let child = joint.child;
    for end in [JointEnd::Parent, JointEnd::Child] {
        for axis in 0..3 {
            if let Some(by_m) = values.of(Quantity::JointPlace { child, end, axis }) {
                joint.shift(end, axis, by_m);
            }
        }
    }
    let turns = joint.turns().into_iter().enumerate();
    let turn: Vector3<f64> = turns
        .map(|(about, axis)| {
            let turn = values.of(Quantity::JointTurn { child, about });
            axis * turn.unwrap_or(0.0)
        })
        .sum();
    if turn != Vector3::zeros() {
        joint.turn(turn);
    }
}

#[cfg(test)]
mod tests;
