//! What a rebound tells of how a body turns of which the centre of mass alone is seen.
//!
//! The impulse `m Δv` acts at the point that touches, at `r` from the centre: it changes the angular
//! velocity by `Δω = I⁻¹ (r × m Δv)`, and the point leaves at `e` times the speed at which it came,
//!
//! ```text
//! n·(v⁺ + ω⁺ × r) = −e n·(v⁻ + ω⁻ × r),   ω^± = ω ± ½ Δω
//! ```
//!
//! of which the least mean `ω` is along `r × n`. So the velocities of the centre before and after tell
//! how fast it turns about one axis.

use nalgebra::{UnitQuaternion, Vector3, Vector4};

use crate::math::so3;
use crate::motion::{MechanismIndex, Partner, Scene};
use crate::physics::contact::Feature;
use crate::physics::{Body, State};

/// Greatest share of `r` along the normal where a bounce is to tell a rotation: an upright one tells none.
const UPRIGHT_MOST: f64 = 0.8;
/// Least share of `r` across the normal that tells one.
const ACROSS_LEAST: f64 = 1e-3;

/// A point of a free body that touches a plane of the static world, alone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rebound<'a> {
    body: &'a Body,
    /// The point in body axes, not the centre of mass \[m\].
    point_m: Vector3<f64>,
    radius_m: f64,
    plane_m: Vector3<f64>,
    normal: Vector3<f64>,
    restitution: f64,
}

/// How a body turns about a rebound [rad/s, world].
#[derive(Clone, Copy, Debug)]
pub(super) struct ReboundSpin {
    /// The mean of the angular velocities before and after.
    pub(super) mean_rad_s: Vector3<f64>,
    /// That after less that before.
    pub(super) change_rad_s: Vector3<f64>,
}

impl<'a> Rebound<'a> {
    /// What a mechanism does at an event, if it is that.
    pub(super) fn of(scene: &'a Scene, mechanism: MechanismIndex, event: usize) -> Option<Self> {
        let collision = scene.events[event].kind.collision()?;
        let link = scene.free_link(mechanism);
        let [touching] = collision.contacts.as_slice() else {
            return None;
        };
        let is_own = collision.partner == Partner::World && collision.link == link;
        let (plane_m, normal) = scene.surfaces[touching.other.filter(|_| is_own)?].plane()?;
        let feature = scene.links[link].features[touching.feature?].geometry;
        let Feature::Point { point_m, radius_m } = feature else {
            return None;
        };
        (point_m.norm() > 0.0).then_some(Self {
            body: &scene.links[link].body,
            point_m,
            radius_m,
            plane_m,
            normal,
            restitution: scene.law_of(collision).restitution,
        })
    }

    /// The orientation nearest to a given one in which the point reaches the plane, or comes nearest to it.
    pub(super) fn touching(
        &self,
        centre_m: &Vector3<f64>,
        like: &UnitQuaternion<f64>,
    ) -> UnitQuaternion<f64> {
        self.turned(like, self.upright(centre_m).clamp(-1.0, 1.0))
    }

    /// The same, but never upright, and then turned about the normal by a heading \[rad\].
    pub(super) fn leaning(
        &self,
        centre_m: &Vector3<f64>,
        like: &UnitQuaternion<f64>,
        heading_rad: f64,
    ) -> UnitQuaternion<f64> {
        let upright = self.upright(centre_m);
        let turned = self.turned(like, upright.clamp(-UPRIGHT_MOST, UPRIGHT_MOST));
        UnitQuaternion::from_scaled_axis(self.normal * heading_rad) * turned
    }

    /// The mean of the angular velocities before and after, and their difference [rad/s, world], in an
    /// orientation, between two states of which the centres are known; `None` where the point is below or
    /// above the centre.
    pub(super) fn spin_rad_s(
        &self,
        orientation: &UnitQuaternion<f64>,
        [before, after]: [&State; 2],
    ) -> Option<ReboundSpin> {
        let lever_m = orientation * self.point_m - self.normal * self.radius_m;
        let across_m = lever_m.cross(&self.normal);
        if across_m.norm() < ACROSS_LEAST * lever_m.norm() {
            return None;
        }
        let impulse_n_s = (after.velocity_m_s - before.velocity_m_s) * self.body.mass_kg();
        let moment = orientation.inverse() * lever_m.cross(&impulse_n_s);
        let change_rad_s = orientation * moment.component_div(&self.body.moments_kg_m2());
        let e = self.restitution;
        let lacks_m_s = self
            .normal
            .dot(&(after.velocity_m_s + before.velocity_m_s * e))
            + 0.5 * (1.0 - e) * change_rad_s.dot(&across_m);
        let mean_rad_s = across_m * (-lacks_m_s / ((1.0 + e) * across_m.norm_squared()));
        Some(ReboundSpin {
            mean_rad_s,
            change_rad_s,
        })
    }

    /// How far two states are off at a bounce between them \[m\]: the point's height over the plane, and
    /// what the lever across the impulse lacks to turn the body as it does; of the mean orientation.
    pub(super) fn off_m(&self, [before, after]: &[State; 2]) -> Vector4<f64> {
        let between = before.orientation.inverse() * after.orientation;
        let orientation = before.orientation * so3::exp(&(so3::log(&between) * 0.5));
        let centre_m = (before.position_m + after.position_m) * 0.5;
        let point_m = orientation * self.point_m - self.normal * self.radius_m;
        let height_m = self.normal.dot(&(centre_m + point_m - self.plane_m));
        let impulse_n_s = (after.velocity_m_s - before.velocity_m_s) * self.body.mass_kg();
        let [came, left] = [before, after].map(|state| {
            let moments_kg_m2 = self.body.moments_kg_m2();
            state.orientation * moments_kg_m2.component_mul(&state.angular_velocity_rad_s)
        });
        let lacks_n_m_s = left - came - point_m.cross(&impulse_n_s);
        let lacks_m = lacks_n_m_s / impulse_n_s.norm().max(f64::MIN_POSITIVE);
        Vector4::new(height_m, lacks_m.x, lacks_m.y, lacks_m.z)
    }

    /// The share of the lever along the normal in which the point reaches the plane.
    fn upright(&self, centre_m: &Vector3<f64>) -> f64 {
        (self.radius_m - self.normal.dot(&(centre_m - self.plane_m))) / self.point_m.norm()
    }

    /// The orientation nearest to a given one with that share along the normal.
    fn turned(&self, like: &UnitQuaternion<f64>, upright: f64) -> UnitQuaternion<f64> {
        let lever = like * self.point_m;
        let level = lever - self.normal * self.normal.dot(&lever);
        let level = level
            .try_normalize(1e-9 * self.point_m.norm())
            .unwrap_or_else(|| Feature::tangents(&self.normal)[0]);
        let there = self.normal * upright + level * (1.0 - upright * upright).sqrt();
        UnitQuaternion::rotation_between(&lever, &there).map_or(*like, |turn| turn * like)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::contact::Contact;
    use crate::physics::impact::{ContactSet, Law, Side};

    const SCENE: &str = include_str!("../../../config/pencil_tip.toml");

    #[test]
    fn the_impact_law_gives_back_the_jump_from_which_the_rotation_was_told() {
        let scene = crate::config::scene_from_toml(SCENE).expect("a valid scene file");
        let rebound = |event| Rebound::of(&scene, MechanismIndex(0), event);
        let rebound = (0..scene.events.len()).find_map(rebound).expect("a bounce");
        let orientation = UnitQuaternion::from_scaled_axis(Vector3::new(0.4, -0.3, 1.0));
        let state = |angular_velocity_rad_s: Vector3<f64>| State {
            orientation,
            velocity_m_s: Vector3::new(0.3, -0.2, -1.9),
            angular_velocity_rad_s,
            ..State::at_rest()
        };
        let point = Feature::corner(rebound.point_m);
        let plane = Feature::face(orientation * rebound.point_m, rebound.normal);
        let contact = Contact::new(point, plane).expect("a point and a plane");
        let contacts = ContactSet::frictionless(&[contact]).expect("one contact");
        let law = Law::frictionless(rebound.restitution);
        let after = |before: &State| {
            let side = Side {
                body: rebound.body,
                state: before,
            };
            let impact = contacts.impact(&side, None, &law).expect("a response");
            impact.after[0]
        };
        let before = state(Vector3::new(7.0, -4.0, 11.0));
        let acted = after(&before);
        let rebounded = State {
            velocity_m_s: acted.velocity_m_s,
            ..before
        };
        let told = rebound.spin_rad_s(&orientation, [&before, &rebounded]);
        let told = told.expect("the pencil leans");
        let [first, then] = [-0.5, 0.5].map(|half| told.mean_rad_s + told.change_rad_s * half);
        let again = after(&state(orientation.inverse() * first));
        assert!((again.velocity_m_s - acted.velocity_m_s).norm() < 1e-9);
        let spin = orientation * again.angular_velocity_rad_s;
        assert!((spin - then).norm() < 1e-9 * then.norm());
        // Of all that do, it is the least.
        let mean_rad_s = before.angular_velocity_rad_s + acted.angular_velocity_rad_s;
        assert!(2.0 * told.mean_rad_s.norm() < mean_rad_s.norm());
    }

    #[test]
    fn the_point_reaches_the_plane_where_the_centre_lets_it_and_leans_where_it_must() {
        let scene = crate::config::scene_from_toml(SCENE).expect("a valid scene file");
        let rebound = |event| Rebound::of(&scene, MechanismIndex(0), event);
        let rebound = (0..scene.events.len()).find_map(rebound).expect("a bounce");
        let like = UnitQuaternion::from_scaled_axis(Vector3::new(2.1, 0.3, -0.4));
        let arm_m = rebound.point_m.norm();
        let above_m = |height_m: f64| rebound.plane_m + rebound.normal * height_m;
        let height_m = |centre_m: Vector3<f64>, turn: UnitQuaternion<f64>| {
            let lowest_m = centre_m + turn * rebound.point_m - rebound.plane_m;
            rebound.normal.dot(&lowest_m) - rebound.radius_m
        };
        let low_m = above_m(0.6 * arm_m);
        let touching = rebound.touching(&low_m, &like);
        assert!(height_m(low_m, touching).abs() < 1e-12);
        for heading_rad in [0.0, 2.0] {
            let about = UnitQuaternion::from_scaled_axis(rebound.normal * heading_rad);
            let leaning = rebound.leaning(&low_m, &like, heading_rad);
            assert!(leaning.angle_to(&(about * touching)) < 1e-9);
        }
        // Too high to be reached: upright, or as far as tells a rotation.
        let high_m = above_m(2.0 * arm_m);
        let upright = |turn: UnitQuaternion<f64>| -rebound.normal.dot(&(turn * rebound.point_m));
        assert!((upright(rebound.touching(&high_m, &like)) - arm_m).abs() < 1e-12);
        let leaning_m = upright(rebound.leaning(&high_m, &like, 1.0));
        assert!((leaning_m - UPRIGHT_MOST * arm_m).abs() < 1e-12);
    }
}
