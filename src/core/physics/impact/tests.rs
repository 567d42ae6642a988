use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::math::differentiate;
use crate::physics::body::Body;
use crate::physics::contact::{Contact, Feature, Frame, Touch};
use crate::physics::state::{State, StateTangent};

mod derivatives;
mod held;
mod knocks;
mod model;
mod spring_back;

/// Number of random draws after which a suitable case must have occurred.
pub(super) const DRAWS: usize = 10_000;

/// Bodies, poses and contacts of unit scale, from a seed.
pub(super) struct Draw(ChaCha8Rng);

impl Draw {
    pub(super) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0.random_range(low..high)
    }

    pub(super) fn vector(&mut self, size: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.between(-size, size))
    }

    fn direction(&mut self) -> Vector3<f64> {
        let mut draws = (0..DRAWS).map(|_| self.vector(1.0));
        let v = draws.find(|v| (0.1..1.0).contains(&v.norm()));
        v.expect("a direction").normalize()
    }

    pub(super) fn body(&mut self) -> Body {
        let mass = self.between(0.3, 3.0);
        let (axial, ratio) = (self.between(0.1, 0.5), self.between(0.55, 3.0));
        let mut moments = Vector3::repeat(mass * axial * ratio);
        moments[self.0.random_range(0..3)] = mass * axial;
        Body::new(mass, moments).expect("a body")
    }

    pub(super) fn state(&mut self) -> State {
        let turn = self.direction() * self.between(0.0, 3.0);
        State {
            position_m: self.vector(1.0),
            orientation: UnitQuaternion::from_scaled_axis(turn),
            velocity_m_s: self.vector(2.0),
            angular_velocity_rad_s: self.vector(3.0),
        }
    }

    fn radius(&mut self) -> f64 {
        self.between(0.1, 0.4)
    }

    fn point(&mut self, radius_m: f64) -> Feature {
        Feature::Point {
            point_m: self.vector(0.8),
            radius_m,
        }
    }

    fn line(&mut self, radius_m: f64) -> Feature {
        Feature::Line {
            point_m: self.vector(0.8),
            direction: self.direction(),
            radius_m,
        }
    }

    fn rim(&mut self) -> Feature {
        Feature::Rim {
            centre_m: self.vector(0.6),
            axis: self.direction(),
            radius_m: self.radius(),
        }
    }

    pub(super) fn face(&mut self) -> Feature {
        Feature::Face {
            point_m: self.vector(0.8),
            normal: self.direction(),
        }
    }

    /// A contact of the kind that `kind` says, of [`KINDS`].
    pub(super) fn contact(&mut self, kind: usize) -> Contact {
        let (r, s) = (self.radius(), self.radius());
        let (a, b) = match kind {
            0 => (self.point(0.0), self.face()),
            1 => (self.point(r), self.face()),
            2 => (self.face(), self.point(r)),
            3 => (self.rim(), self.face()),
            4 => (self.face(), self.rim()),
            5 => (self.point(r), self.point(s)),
            6 => (self.point(r), self.line(0.0)),
            7 => (self.line(r), self.point(0.0)),
            8 => (self.line(0.0), self.line(0.0)),
            _ => (self.line(r), self.line(s)),
        };
        Contact::new(a, b).expect("a known pair")
    }
}

/// How many kinds of contact there are to draw.
pub(super) const KINDS: usize = 10;

/// A body and its state.
type Mover = (Body, State);

fn side(mover: &Mover) -> Side<'_> {
    Side {
        body: &mover.0,
        state: &mover.1,
    }
}

fn frame(mover: Option<&Mover>) -> Frame {
    mover.map_or_else(Frame::world, |(_, state)| Frame::of(state))
}

/// One contact that closes its gap and approaches.
pub(super) struct Case {
    pub(super) a: Mover,
    pub(super) b: Option<Mover>,
    pub(super) contact: Contact,
    pub(super) law: Law,
}

impl Case {
    pub(super) fn draw(draw: &mut Draw, kind: usize, has_two: bool) -> Self {
        for _ in 0..DRAWS {
            let contact = draw.contact(kind);
            let mut a = (draw.body(), draw.state());
            let mut b = has_two.then(|| (draw.body(), draw.state()));
            let law = Law {
                restitution: draw.between(0.0, 1.0),
                friction: draw.between(0.0, 1.2),
                tangential_restitution: 0.0,
                tilt_rad: [0.0; 2],
            };
            // Near a degenerate pose everything is steep.
            let Ok((touch, rates)) = contact.touch_derivative(&frame(Some(&a)), &frame(b.as_ref()))
            else {
                continue;
            };
            if rates.on_a.norm() + rates.on_b.norm() + rates.normal.norm() > 12.0 {
                continue;
            }
            a.1.position_m -= touch.normal * touch.gap_m;
            let case = Self { a, b, contact, law };
            if case.speed() < -0.05 {
                return case;
            }
            a.1 = reversed(&a.1);
            b = b.map(|(body, state)| (body, reversed(&state)));
            let case = Self { a, b, contact, law };
            if case.speed() < -0.05 {
                return case;
            }
        }
        panic!("no case of kind {kind} in {DRAWS} draws");
    }

    fn touch(&self) -> Touch {
        self.contact
            .touch(&frame(Some(&self.a)), &frame(self.b.as_ref()))
            .expect("a regular pose")
    }

    fn impact(&self) -> Impact {
        let contacts = ContactSet::with_friction(&[self.contact]).expect("one contact");
        contacts
            .impact(
                &side(&self.a),
                self.b.as_ref().map(side).as_ref(),
                &self.law,
            )
            .expect("a regular pose")
    }

    fn speed(&self) -> f64 {
        self.impact().speeds_m_s[0]
    }

    /// Velocity of A's point relative to B's.
    fn relative(&self, velocities: &[Velocities; 2]) -> Vector3<f64> {
        let touch = self.touch();
        let of = |frame: Frame, v: &Velocities, point: &Vector3<f64>| {
            v.velocity_m_s + frame.orientation * v.angular_velocity_rad_s.cross(point)
        };
        let b = frame(self.b.as_ref());
        of(frame(Some(&self.a)), &velocities[0], &touch.on_a_m)
            - of(b, &velocities[1], &touch.on_b_m)
    }

    fn movers(&self) -> impl Iterator<Item = &Mover> {
        std::iter::once(&self.a).chain(&self.b)
    }

    fn before(&self) -> [Velocities; 2] {
        let b = self.b.as_ref();
        [
            Velocities::of(&self.a.1),
            b.map_or_else(Velocities::default, |(_, state)| Velocities::of(state)),
        ]
    }

    fn energy(&self, velocities: &[Velocities; 2]) -> f64 {
        self.movers()
            .zip(velocities)
            .map(|((body, _), v)| {
                let omega = v.angular_velocity_rad_s;
                0.5 * body.mass_kg() * v.velocity_m_s.norm_squared()
                    + 0.5 * body.moments_kg_m2().dot(&omega.component_mul(&omega))
            })
            .sum()
    }

    /// Linear momentum, and angular momentum about a point.
    fn momenta(
        &self,
        velocities: &[Velocities; 2],
        about: &Vector3<f64>,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let mut sum = (Vector3::zeros(), Vector3::zeros());
        for ((body, state), v) in self.movers().zip(velocities) {
            let linear = v.velocity_m_s * body.mass_kg();
            let spin = body
                .moments_kg_m2()
                .component_mul(&v.angular_velocity_rad_s);
            sum.0 += linear;
            sum.1 += (state.position_m - about).cross(&linear) + state.orientation * spin;
        }
        sum
    }
}

fn reversed(state: &State) -> State {
    State {
        velocity_m_s: -state.velocity_m_s,
        angular_velocity_rad_s: -state.angular_velocity_rad_s,
        ..*state
    }
}

fn difference(a: &Velocities, b: &Velocities) -> f64 {
    (a.velocity_m_s - b.velocity_m_s).norm()
        + (a.angular_velocity_rad_s - b.angular_velocity_rad_s).norm()
}

/// Cases of every kind of contact, half of them of two bodies.
fn cases(count: usize) -> impl Iterator<Item = (usize, Case)> {
    let mut draw = Draw::new(1998);
    (0..count).map(move |index| {
        let has_two = (index / KINDS).is_multiple_of(2);
        (index, Case::draw(&mut draw, index % KINDS, has_two))
    })
}

#[test]
fn the_law_keeps_its_promises() {
    let (mut stuck, mut slid) = (0, 0);
    for (index, case) in cases(12_000) {
        let impact = case.impact();
        let (before, touch, law) = (case.before(), case.touch(), &case.law);
        assert!(touch.gap_m.abs() < 1e-13);
        let (v, w) = (case.relative(&before), case.relative(&impact.after));
        let speed = touch.normal.dot(&v);
        assert!((impact.speeds_m_s[0] - speed).abs() < 1e-12, "{index}");
        let rebound = touch.normal.dot(&w) + law.restitution * speed;
        assert!(rebound.abs() < 1e-11, "{index}: {rebound}");

        let energy = case.energy(&before);
        assert!(
            case.energy(&impact.after) <= energy * (1.0 + 1e-13),
            "{index}: energy"
        );

        let impulse = (impact.after[0].velocity_m_s - before[0].velocity_m_s) * case.a.0.mass_kg();
        let normal = touch.normal.dot(&impulse);
        assert!((normal - impact.normal_impulses_n_s[0]).abs() < 1e-11);
        assert!(normal > 0.0 && !impact.pulls(), "{index}: pulls");
        let tangential = (impulse - touch.normal * normal).norm();
        assert!(tangential <= law.friction * normal + 1e-11, "{index}: cone");
        if impact.sticks {
            stuck += 1;
            // What is left of it is e W P_I, read off the frictionless plastic impact.
            let plastic = Case {
                law: Law::frictionless(0.0),
                ..case
            };
            let left = (case.relative(&plastic.impact().after) - v) * law.restitution;
            assert!((w - left).norm() < 1e-11, "{index}: slides");
        } else {
            slid += 1;
            assert!((tangential - law.friction * normal).abs() < 1e-11);
        }
    }
    assert!(stuck > 2500 && slid > 2500, "{stuck} {slid}");
}

#[test]
fn momentum_of_two_bodies_is_conserved() {
    let about = Vector3::new(0.3, -2.0, 1.1);
    for (index, case) in cases(2000).filter(|(_, case)| case.b.is_some()) {
        let (linear, angular) = case.momenta(&case.before(), &about);
        let (linear_after, angular_after) = case.momenta(&case.impact().after, &about);
        assert!((linear - linear_after).norm() < 1e-12, "{index}");
        assert!((angular - angular_after).norm() < 1e-11, "{index}");
    }
}

#[test]
fn without_friction_it_is_newtons_rule() {
    for (index, mut case) in cases(1000) {
        case.law.friction = 0.0;
        let contacts = ContactSet::frictionless(&[case.contact]).expect("one contact");
        let b = case.b.as_ref().map(side);
        let newton = contacts
            .impact(&side(&case.a), b.as_ref(), &case.law)
            .expect("regular");
        let limit = case.impact();
        for body in 0..2 {
            let off = difference(&limit.after[body], &newton.after[body]);
            assert!(off < 1e-12, "{index}: {off}");
        }
    }
}

#[test]
fn a_very_heavy_body_is_the_static_world() {
    let mut draw = Draw::new(7);
    for index in 0..1000 {
        let mut case = Case::draw(&mut draw, index % KINDS, false);
        let alone = case.impact();
        let heavy = Body::new(1e12, Vector3::repeat(1e12)).expect("heavy");
        let at_rest = State {
            position_m: Vector3::zeros(),
            orientation: UnitQuaternion::identity(),
            velocity_m_s: Vector3::zeros(),
            angular_velocity_rad_s: Vector3::zeros(),
        };
        case.b = Some((heavy, at_rest));
        let against = case.impact();
        let off = difference(&alone.after[0], &against.after[0]);
        assert!(off < 1e-9, "{index}: {off}");
        assert_eq!(alone.sticks, against.sticks);
        assert_eq!(alone.after[1], Velocities::default());
    }
}

#[test]
fn exchanged_bodies_move_the_same() {
    for (index, case) in cases(2000) {
        // Lines take A's side; exchanged ones only in poses that solids can have.
        let Some(b) = case.b.filter(|_| index % KINDS != 8) else {
            continue;
        };
        let contact = Contact::new(*case.contact.b(), *case.contact.a()).expect("known");
        let here = case.impact();
        let exchanged = Case {
            a: b,
            b: Some(case.a),
            contact,
            law: case.law,
        };
        if exchanged.touch().normal.dot(&case.touch().normal) > 0.0 {
            assert_eq!(index % KINDS, 9);
            continue;
        }
        let there = exchanged.impact();
        for body in 0..2 {
            let off = difference(&here.after[body], &there.after[1 - body]);
            assert!(off < 1e-11, "{index}: {off}");
        }
    }
}

#[test]
fn velocities_are_continuous_where_sticking_turns_to_sliding() {
    let mut crossed = 0;
    for (index, mut case) in cases(400) {
        case.law.friction = 5.0;
        if !case.impact().sticks {
            continue;
        }
        // Bisects for the friction at which it just sticks.
        let (mut slides, mut sticks) = (0.0, 5.0);
        while sticks - slides > 1e-13 {
            case.law.friction = 0.5 * (slides + sticks);
            if case.impact().sticks {
                sticks = case.law.friction;
            } else {
                slides = case.law.friction;
            }
        }
        let after = [slides, sticks].map(|friction| {
            case.law.friction = friction;
            case.impact().after
        });
        for body in 0..2 {
            let jump = difference(&after[0][body], &after[1][body]);
            assert!(jump < 1e-10, "{index}: {jump}");
        }
        crossed += 1;
    }
    assert!(crossed > 200, "{crossed}");
}

/// With `c = p × Rᵀn'` of the tilted normal `n'` and `u' = n'·v + c·ω`,
///
/// ```text
/// j = −(1 + e) u' / (1/m + cᵀ I⁻¹ c),   v⁺ = v + (j/m) n',   ω⁺ = ω + I⁻¹ c j
/// ```
///
/// and the bounce with `1/e` undoes it.
#[test]
fn a_point_on_a_plane_without_friction_has_a_closed_form_and_an_inverse() {
    let mut draw = Draw::new(3);
    for _ in 0..200 {
        let case = Case::draw(&mut draw, 0, false);
        let (
            Feature::Point { point_m, .. },
            Feature::Face {
                point_m: surface_point_m,
                normal,
            },
        ) = (*case.contact.a(), *case.contact.b())
        else {
            panic!("a point on a face");
        };
        let (body, state) = &case.a;
        let tilt_rad = [draw.between(-0.1, 0.1), draw.between(-0.1, 0.1)];
        let law = Law {
            tilt_rad,
            ..Law::frictionless(case.law.restitution.max(0.1))
        };
        let contacts = ContactSet::frictionless(&[case.contact]).expect("one contact");
        let impact = contacts
            .impact(&side(&case.a), None, &law)
            .expect("regular");
        let axes = case.contact.tilt_axes().expect("a face");
        let tilt = axes[0] * tilt_rad[0] + axes[1] * tilt_rad[1];
        let tilted = crate::math::so3::exp(&tilt) * normal;

        let arm_along = |normal: &Vector3<f64>| {
            point_m.cross(&state.orientation.inverse_transform_vector(normal))
        };
        let speed_along = |normal: &Vector3<f64>| {
            normal.dot(&state.velocity_m_s) + arm_along(normal).dot(&state.angular_velocity_rad_s)
        };
        let arm = arm_along(&tilted);
        let turned = arm.component_div(&body.moments_kg_m2());
        let inertia = 1.0 / body.mass_kg() + arm.dot(&turned);
        let impulse = -(1.0 + law.restitution) * speed_along(&tilted) / inertia;
        let bounced = Velocities {
            velocity_m_s: state.velocity_m_s + tilted * (impulse / body.mass_kg()),
            angular_velocity_rad_s: state.angular_velocity_rad_s + turned * impulse,
        };
        assert!(difference(&impact.after[0], &bounced) < 1e-12);
        let gap_m = normal.dot(&(state.position_m + state.orientation * point_m - surface_point_m));
        assert!((impact.gaps_m[0] - gap_m).abs() < 1e-14);
        assert!((impact.speeds_m_s[0] - speed_along(&normal)).abs() < 1e-13);

        let after = State {
            velocity_m_s: bounced.velocity_m_s,
            angular_velocity_rad_s: bounced.angular_velocity_rad_s,
            ..*state
        };
        let inverse = Law {
            restitution: 1.0 / law.restitution,
            ..law
        };
        let back = contacts
            .impact(&side(&(*body, after)), None, &inverse)
            .expect("regular");
        assert!(difference(&back.after[0], &Velocities::of(state)) < 1e-11);
    }
}

/// Corners of a box's lower face, on the ground.
pub(super) fn corners(count: usize) -> Vec<Contact> {
    let ground = Feature::Face {
        point_m: Vector3::zeros(),
        normal: Vector3::z(),
    };
    [[0.5, 0.4], [-0.5, 0.4], [0.5, -0.4]][..count]
        .iter()
        .map(|[x, y]| {
            let corner = Feature::Point {
                point_m: Vector3::new(*x, *y, -0.3),
                radius_m: 0.0,
            };
            Contact::new(corner, ground).expect("point on face")
        })
        .collect()
}

#[test]
fn a_face_that_lands_flat_rebounds_flat() {
    let mut draw = Draw::new(11);
    for count in [2, 3] {
        for _ in 0..500 {
            let body = draw.body();
            let mut state = draw.state();
            state.orientation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.7);
            state.position_m.z = 0.3;
            let restitution = draw.between(0.0, 1.0);
            let contacts = corners(count);
            let contacts = ContactSet::frictionless(&contacts).expect("a few");
            let a = (body, state);
            let impact = contacts
                .impact(&side(&a), None, &Law::frictionless(restitution))
                .expect("independent");
            let mut bounced = state;
            bounced.velocity_m_s = impact.after[0].velocity_m_s;
            bounced.angular_velocity_rad_s = impact.after[0].angular_velocity_rad_s;
            let after = contacts
                .impact(&side(&(body, bounced)), None, &Law::frictionless(0.0))
                .expect("independent");
            for contact in 0..count {
                assert!(impact.gaps_m[contact].abs() < 1e-15);
                let rebound = after.speeds_m_s[contact] + restitution * impact.speeds_m_s[contact];
                assert!(rebound.abs() < 1e-12, "{rebound}");
            }
            let case = Case {
                a,
                b: None,
                contact: contacts.as_slice()[0],
                law: Law::frictionless(restitution),
            };
            let (before, later) = (case.energy(&case.before()), case.energy(&impact.after));
            assert!(later <= before * (1.0 + 1e-13));
        }
    }
}

/// Friction takes its share of the slip, turning about the normal with it, and nothing else: with small impulses one
/// after the other, each against the slip of its moment.
#[test]
fn friction_of_a_flat_landing_is_that_of_many_small_impulses() {
    const STEPS: usize = 20_000;
    let mut draw = Draw::new(12);
    let contacts = ContactSet::with_friction(&corners(3)).expect("a face");
    let (mut stuck, mut slid) = (0, 0);
    for index in 0..60 {
        let body = draw.body();
        let mut state = draw.state();
        state.orientation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.7);
        state.velocity_m_s.z = -draw.between(0.1, 2.0);
        let law = Law {
            restitution: draw.between(0.0, 1.0),
            friction: draw.between(0.0, 1.2),
            tangential_restitution: 0.0,
            tilt_rad: [0.0; 2],
        };
        let a = (body, state);
        let impact = contacts.impact(&side(&a), None, &law).expect("regular");
        let smooth = Law::frictionless(law.restitution);
        let rebound = ContactSet::frictionless(&corners(3)).expect("three");
        let rebound = rebound.impact(&side(&a), None, &smooth).expect("regular");
        let [mut stepped, _] = rebound.after;
        let about_kg_m2 = body.moments_kg_m2().z;
        let gyration_m = (about_kg_m2 / body.mass_kg()).sqrt();
        let pressed = -(1.0 + law.restitution) * state.velocity_m_s.z;
        let mut sticks = false;
        for _ in 0..STEPS {
            let v = stepped.velocity_m_s;
            let slip = Vector3::new(v.x, v.y, gyration_m * stepped.angular_velocity_rad_s.z);
            let takes = law.friction * pressed / STEPS as f64;
            if slip.norm() <= takes {
                sticks = true;
            }
            let left = (1.0 - takes / slip.norm()).max(0.0);
            stepped.velocity_m_s.x *= left;
            stepped.velocity_m_s.y *= left;
            stepped.angular_velocity_rad_s.z *= left;
        }
        assert_eq!(impact.sticks, sticks, "{index}");
        let off = difference(&impact.after[0], &stepped);
        assert!(off < 1e-9, "{index}: {off}");
        let case = Case {
            a,
            b: None,
            contact: contacts.as_slice()[0],
            law,
        };
        let (before, later) = (case.energy(&case.before()), case.energy(&impact.after));
        assert!(later <= before * (1.0 + 1e-13), "{index}");
        let pressed_n_s = impact.normal_impulses_n_s.iter().sum::<f64>();
        assert!((pressed_n_s - pressed * body.mass_kg()).abs() < 1e-12);
        stuck += usize::from(sticks);
        slid += usize::from(!sticks);
    }
    assert!(stuck > 5 && slid > 5, "{stuck} {slid}");
}

/// A box that slides as it lands is pressed ahead of its middle: friction would tip it over its leading edge.
#[test]
fn a_flat_landing_is_pressed_where_friction_shifts_it() {
    let contacts = ContactSet::with_friction(&corners(3)).expect("a face");
    let body = Body::new(1.0, Vector3::repeat(0.1)).expect("a body");
    let state = State {
        position_m: Vector3::new(0.0, 0.0, 0.3),
        velocity_m_s: Vector3::new(3.0, 0.0, -1.0),
        ..State::at_rest()
    };
    let law = Law {
        restitution: 0.0,
        friction: 0.4,
        tangential_restitution: 0.0,
        tilt_rad: [0.0; 2],
    };
    let impact = contacts.impact(&side(&(body, state)), None, &law);
    let impact = impact.expect("regular");
    let points = [[0.5, 0.4], [-0.5, 0.4], [0.5, -0.4]];
    let pressed = impact.normal_impulses_n_s.iter().zip(points);
    let pressed = pressed.fold([0.0; 2], |sum, (n_s, [x, y])| {
        [sum[0] + n_s * x, sum[1] + n_s * y]
    });
    // h μ ahead.
    assert!((pressed[0] - 0.3 * 0.4).abs() < 1e-12 && pressed[1].abs() < 1e-12);
}

#[test]
fn contacts_that_would_pull_are_reported() {
    // The box comes down on one edge's corners while spinning up the other's.
    let contacts = corners(3);
    let contacts = ContactSet::frictionless(&contacts).expect("three");
    let body = Body::new(1.0, Vector3::repeat(0.1)).expect("a body");
    let state = |spin: f64| State {
        position_m: Vector3::new(0.0, 0.0, 0.3),
        orientation: UnitQuaternion::identity(),
        velocity_m_s: Vector3::new(0.0, 0.0, -1.0),
        angular_velocity_rad_s: Vector3::new(0.0, spin, 0.0),
    };
    let pulls = |spin: f64| {
        let a = (body, state(spin));
        contacts
            .impact(&side(&a), None, &Law::frictionless(0.3))
            .expect("independent")
            .pulls()
    };
    assert!(pulls(-4.0));
    let two = ContactSet::frictionless(&contacts.as_slice()[..2]).expect("two");
    let falling = (body, state(0.0));
    let impact = two
        .impact(&side(&falling), None, &Law::frictionless(0.3))
        .expect("independent");
    assert!(!impact.pulls());
}

#[test]
fn what_is_not_known_is_refused_by_name() {
    let contacts = corners(3);
    let refused =
        |result: Result<ContactSet, ContactSetError>| result.expect_err("refused").to_string();
    assert_eq!(
        refused(ContactSet::frictionless(&[])),
        "0 contacts at once, expected one, two or three"
    );
    assert_eq!(
        refused(ContactSet::with_friction(&contacts[..2])),
        "friction at 2 contacts at once is not supported: leave it out, use one contact, or a face that lands flat on one of the world's"
    );
    let mut draw = Draw::new(5);
    let ball = ContactSet::frictionless(&[draw.contact(5)]).expect("one");
    assert_eq!(
        ball.check_tilt().expect_err("no face").to_string(),
        "the normal of contact 0 cannot be tilted: what it touches is a point, only a face has a normal of its own"
    );
    let mut on_line = contacts.clone();
    on_line[2] = Contact::new(
        Feature::Point {
            point_m: Vector3::new(0.1, 0.4, -0.3),
            radius_m: 0.0,
        },
        *contacts[0].b(),
    )
    .expect("point on face");
    let a = (draw.body(), draw.state());
    for dependent in [&on_line[..], &[contacts[1]; 2]] {
        let contacts = ContactSet::frictionless(dependent).expect("a few");
        let count = dependent.len();
        let law = Law::frictionless(0.5);
        let expected = Err(ImpactError::Dependent { count });
        assert_eq!(contacts.impact(&side(&a), None, &law), expected);
        let derivative = contacts.derivative(&side(&a), None, &law, &mut ImpactDerivative::zeros());
        assert_eq!(derivative, expected);
    } // A state that a solver's step threw out of all measure.
    let one = ContactSet::with_friction(&contacts[..1]).expect("one");
    let (body, mut state) = a;
    state.orientation = UnitQuaternion::new_unchecked(Quaternion::new(f64::NAN, 0.0, 0.0, 0.0));
    let impact = one.impact(&side(&(body, state)), None, &Law::frictionless(0.5));
    assert_eq!(impact, Err(ImpactError::NoResponse));
}
