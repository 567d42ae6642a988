//! Two things meet in one point, without friction: a corner of a body on a face of the static
//! world or of another body.
//!
//! Written apart from the estimator's own law, so that a truth is no copy of what it judges.
//! With the contact point `p`, the unit normal `n` out of the face, `c = Rᵀ((p − x) × n)` of
//! either side and `u = n·(v_A − v_B) + c_A·ω_A − c_B·ω_B`,
//!
//! ```text
//! j = −(1 + e) u / (1/m_A + 1/m_B + c_Aᵀ I_A⁻¹ c_A + c_Bᵀ I_B⁻¹ c_B)
//! v_A⁺ = v_A + (j/m_A) n,   ω_A⁺ = ω_A + I_A⁻¹ c_A j,   B with −j
//! ```
//!
//! so that `u⁺ = −e u`; with `1/e` it is undone.

use enact::math::so3;
use enact::motion::{LinkIndex, Partner, Quantity, Scene};
use enact::physics::{Body, State, contact};
use nalgebra::{UnitQuaternion, Vector3};

/// The static world's state: identity, at rest.
pub fn still() -> State {
    State {
        position_m: Vector3::zeros(),
        orientation: UnitQuaternion::identity(),
        velocity_m_s: Vector3::zeros(),
        angular_velocity_rad_s: Vector3::zeros(),
    }
}

/// Who meets whom where, and how hard they part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encounter {
    /// A, the link with the corner.
    pub link: LinkIndex,
    /// B, whose face it is; none: the static world.
    pub other: Option<LinkIndex>,
    /// The corner [m, A].
    pub point_m: Vector3<f64>,
    /// A point of the face [m, B].
    pub face_point_m: Vector3<f64>,
    /// The face's unit normal \[B\].
    pub face_normal: Vector3<f64>,
    /// The normal along which they push, tilted from the face's \[B\].
    pub push_normal: Vector3<f64>,
    /// Coefficient of restitution.
    pub restitution: f64,
    inverse: [Inverse; 2],
}

/// Inverse mass [1/kg] and inverse moments [1/(kg m²)]; zero for the static world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Inverse {
    mass: f64,
    moments: Vector3<f64>,
}

impl Inverse {
    fn of(body: &Body) -> Self {
        Self {
            mass: 1.0 / body.mass_kg(),
            moments: body.moments_kg_m2().map(|moment| 1.0 / moment),
        }
    }
}

impl Encounter {
    /// Of the scene's first link, whose corner hits a face of the static world that pushes
    /// straight.
    pub fn of_corner(
        body: &Body,
        point_m: Vector3<f64>,
        face_point_m: Vector3<f64>,
        face_normal: Vector3<f64>,
        restitution: f64,
    ) -> Self {
        Self {
            link: LinkIndex(0),
            other: None,
            point_m,
            face_point_m,
            face_normal,
            push_normal: face_normal,
            restitution,
            inverse: [Inverse::of(body), Inverse::default()],
        }
    }

    /// The collision that event of the scene is, with these values of the scene's free
    /// parameters; none if the event is no collision of a sharp corner with a face.
    pub fn of(scene: &Scene, parameters: &[f64], event: usize) -> Option<Self> {
        let collision = scene.events[event].kind.collision()?;
        let [touching] = collision.contacts[..] else {
            return None;
        };
        let moving = &scene.links[collision.link];
        let other = match collision.partner {
            Partner::World => None,
            Partner::Link(other) => Some(other),
        };
        let face = match other {
            None => scene.surfaces[touching.other?].geometry,
            Some(other) => scene.links[other].features[touching.other?].geometry,
        };
        let corner = moving.features[touching.feature?].geometry;
        let (
            contact::Feature::Point {
                point_m,
                radius_m: 0.0,
            },
            contact::Feature::Face {
                point_m: face_point_m,
                normal,
            },
        ) = (corner, face)
        else {
            return None;
        };
        let value_of = |quantity: Quantity| {
            let index = scene.parameters.iter().position(|p| p.quantity == quantity);
            index.map(|index| parameters[index])
        };
        let tilt: Vector3<f64> = tangents(&normal)
            .iter()
            .enumerate()
            .map(|(tangent, axis)| {
                axis * value_of(Quantity::Tilt { event, tangent }).unwrap_or(0.0)
            })
            .sum();
        Some(Self {
            link: collision.link,
            other,
            point_m,
            face_point_m,
            face_normal: normal,
            push_normal: so3::exp(&tilt) * normal,
            restitution: value_of(Quantity::Restitution { law: collision.law })
                .unwrap_or(scene.law_of(collision).restitution),
            inverse: [
                Inverse::of(&moving.body),
                other.map_or(Inverse::default(), |b| Inverse::of(&scene.links[b].body)),
            ],
        })
    }

    /// Distance of the corner from the face \[m\]; negative inside.
    pub fn gap_m(&self, a: &State, b: &State) -> f64 {
        let normal = b.orientation * self.face_normal;
        let face_point_m = b.position_m + b.orientation * self.face_point_m;
        normal.dot(&(a.position_m + a.orientation * self.point_m - face_point_m))
    }

    /// Speed of the corner away from the face, along the normal of the push [m/s].
    pub fn speed_m_s(&self, a: &State, b: &State) -> f64 {
        let [normal, arm_a, arm_b] = self.arms(a, b);
        normal.dot(&(a.velocity_m_s - b.velocity_m_s)) + arm_a.dot(&a.angular_velocity_rad_s)
            - arm_b.dot(&b.angular_velocity_rad_s)
    }

    /// Mass that resists the push \[kg\].
    pub fn mass_kg(&self, a: &State, b: &State) -> f64 {
        let [_, arm_a, arm_b] = self.arms(a, b);
        let along = |inverse: &Inverse, arm: &Vector3<f64>| {
            inverse.mass + arm.dot(&arm.component_mul(&inverse.moments))
        };
        1.0 / (along(&self.inverse[0], &arm_a) + along(&self.inverse[1], &arm_b))
    }

    /// The states just after the collision.
    pub fn after(&self, a: &State, b: &State) -> (State, State) {
        self.pushed(a, b, self.restitution)
    }

    /// The states just before the collision that has led to these.
    pub fn before(&self, a: &State, b: &State) -> (State, State) {
        self.pushed(a, b, 1.0 / self.restitution)
    }

    fn pushed(&self, a: &State, b: &State, restitution: f64) -> (State, State) {
        let [normal, arm_a, arm_b] = self.arms(a, b);
        let impulse_n_s = -(1.0 + restitution) * self.speed_m_s(a, b) * self.mass_kg(a, b);
        let push = |state: &State, inverse: &Inverse, arm: &Vector3<f64>, impulse_n_s: f64| State {
            velocity_m_s: state.velocity_m_s + normal * (impulse_n_s * inverse.mass),
            angular_velocity_rad_s: state.angular_velocity_rad_s
                + arm.component_mul(&inverse.moments) * impulse_n_s,
            ..*state
        };
        (
            push(a, &self.inverse[0], &arm_a, impulse_n_s),
            push(b, &self.inverse[1], &arm_b, -impulse_n_s),
        )
    }

    /// The normal of the push \[world\] and both sides' arms of it [m, own axes].
    fn arms(&self, a: &State, b: &State) -> [Vector3<f64>; 3] {
        let normal = b.orientation * self.push_normal;
        let arm_a = self
            .point_m
            .cross(&a.orientation.inverse_transform_vector(&normal));
        let from_b = a.position_m + a.orientation * self.point_m - b.position_m;
        let arm_b = b
            .orientation
            .inverse_transform_vector(&from_b.cross(&normal));
        [normal, arm_a, arm_b]
    }
}

/// The tangents of a face about which its normal is tilted: across the axis least along it, and
/// across both.
fn tangents(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let first = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
    [first, normal.cross(&first)]
}
