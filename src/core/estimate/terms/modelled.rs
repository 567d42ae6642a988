//! What flies, how it is seen and what touches at given values of the parameters that act on them
//! ([`influence`](crate::estimate::problem::influence)).

use std::borrow::Cow;

use nalgebra::{SMatrix, Vector3};

use crate::estimate::problem::influence::{Influence, Owner};
use crate::estimate::problem::{Arc, ArcCollision, ArcSample, Problem};
use crate::estimate::unknowns::point::Point;
use crate::math::{Pose, so3};
use crate::motion::TrackIndex;
use crate::physics::contact::Contact;
use crate::physics::impact::ContactSet;
use crate::physics::{Body, Drag, PlaneSupport, Support};

/// How a tracker is mounted, corrected by parameters.
#[derive(Clone, Copy, Debug)]
pub struct Mount {
    /// Correction of its orientation in link axes, `R' = R·Exp(turn)`.
    pub turn: Vector3<f64>,
    /// From the tracker's place before the correction to that after it, both seen from the centre of
    /// mass in link axes \[m\].
    pub from_m: Vector3<f64>,
    /// The same after it \[m\].
    pub to_m: Vector3<f64>,
    /// Rate of the clock's correction.
    pub rate: f64,
    /// Offset of the clock's correction \[s\].
    pub offset_s: f64,
    /// Whether nothing is corrected.
    pub is_right: bool,
}

impl Problem {
    /// The equations of motion on an arc, with free quantities taken from `parameters`; `None` where no body
    /// has such moments.
    pub fn body_at(&self, arc: usize, parameters: &[f64]) -> Option<Body> {
        let Arc {
            mechanism, body, ..
        } = &self.arcs[arc];
        let mut force_m_s2 = body.force_m_s2();
        let (mut drag, mut lift): (Drag, f64) = (body.drag(), body.lift());
        let (mut mass, mut moments) = (1.0, Vector3::repeat(1.0));
        let mut is_changed = false;
        for role in &self.roles {
            if !matches!(role.owner, Owner::Link(_, of) if of == *mechanism) {
                continue;
            }
            let value = parameters[role.parameter];
            match role.influence {
                Influence::Pull(axis) => force_m_s2[axis] = value,
                Influence::LinearDrag => drag.linear_per_s = value,
                Influence::QuadraticDrag => drag.quadratic_per_m = value,
                Influence::Lift => lift = value,
                Influence::Moment(axes) => {
                    for axis in (0..3).filter(|axis| axes[*axis]) {
                        moments[axis] = value;
                    }
                }
                Influence::Mass => mass = value,
                _ => continue,
            }
            is_changed = true;
        }
        let mut body = *body;
        if is_changed {
            body = body.with_factors(mass, &moments).ok()?;
            body = body.with_force(force_m_s2).ok()?.with_drag(drag).ok()?;
            body = body.with_lift(lift).ok()?;
        }
        let friction = self.arcs[arc].friction_parameter;
        let support = body.support().zip(friction);
        Some(match support {
            Some((Support::Plane(plane), parameter)) => {
                body.with_support(Some(Support::Plane(PlaneSupport {
                    friction: parameters[parameter],
                    ..plane
                })))
            }
            _ => body,
        })
    }

    /// How the tracker of a track that sees an arc is mounted, with free quantities taken from `parameters`.
    pub(in crate::estimate) fn mount_at(
        &self,
        arc: usize,
        track: TrackIndex,
        parameters: &[f64],
    ) -> Mount {
        let arc = &self.arcs[arc];
        let link_from_tracker: &Pose = &self.mounts[track];
        let from_m = link_from_tracker.translation.vector;
        let (mut turn, mut to_m) = (Vector3::zeros(), from_m);
        let (mut rate, mut offset_s) = (0.0, 0.0);
        for acting in &arc.acting {
            if !acting.is_on(track) {
                continue;
            }
            let value = parameters[acting.parameter];
            match acting.influence {
                Influence::Centre(axis) => to_m[axis] -= value,
                Influence::TrackerPosition(axis) => to_m[axis] += value,
                Influence::TrackerOrientation(axis) => turn[axis] += value,
                Influence::ClockRate => rate = value,
                Influence::ClockOffset => offset_s += value,
                _ => {}
            }
        }
        Mount {
            turn: -(link_from_tracker.rotation * turn),
            from_m,
            to_m,
            rate,
            offset_s,
            is_right: arc.acting.is_empty(),
        }
    }

    /// Physical time of a sample of an arc \[s\].
    pub fn sample_time_s(
        &self,
        arc: usize,
        track: TrackIndex,
        sample: &ArcSample,
        point: &Point,
    ) -> f64 {
        let time_s = sample.stamped_s(&point.node_times_s, &point.parameters);
        if self.arcs[arc].is_plain {
            return time_s;
        }
        let zero_s = point.node_times_s.first().copied().unwrap_or(0.0);
        let mount = self.mount_at(arc, track, &point.parameters);
        mount.time_s(time_s, zero_s)
    }

    /// The contacts of a collision, with free quantities taken from `parameters`; `None` where they
    /// are none then.
    pub(in crate::estimate) fn touching_at<'a>(
        &self,
        collision: &'a ArcCollision,
        parameters: &[f64],
    ) -> Option<TouchedPair<'a>> {
        let mut shifts_m = [Vector3::zeros(); 2];
        let (mut height_m, mut tilt_rad) = (0.0, [0.0; 2]);
        let (mut is_shifted, mut is_moved) = (false, false);
        for acting in &collision.acting {
            let value = parameters[acting.parameter];
            match (acting.influence, acting.side) {
                (Influence::Centre(axis), Some(side)) => shifts_m[side][axis] -= value,
                (Influence::SurfaceHeight, _) => height_m = value,
                (Influence::SurfaceTilt(tangent), _) => tilt_rad[tangent] = value,
                _ => continue,
            }
            let is_surface = acting.side.is_none();
            is_moved |= is_surface;
            is_shifted |= !is_surface;
        }
        let mut touching = TouchedPair {
            contacts: Cow::Borrowed(&collision.contacts),
            motions: [SMatrix::zeros(); 3],
        };
        if !is_shifted && !is_moved {
            return Some(touching);
        }
        let mut contacts: Vec<Contact> = collision.contacts.as_slice().to_vec();
        for (contact, motion) in contacts.iter_mut().zip(&mut touching.motions) {
            if is_shifted {
                *contact = contact.with_shifts(shifts_m).ok()?;
            }
            if is_moved {
                (*contact, *motion) = contact.with_surface(height_m, tilt_rad)?;
            }
        }
        let set = if collision.contacts.has_friction() {
            ContactSet::with_friction(&contacts)
        } else {
            ContactSet::frictionless(&contacts)
        };
        touching.contacts = Cow::Owned(set.ok()?);
        Some(touching)
    }
}

/// What touches at a collision at some values of the parameters.
pub(in crate::estimate) struct TouchedPair<'a> {
    /// The contacts.
    pub(in crate::estimate) contacts: Cow<'a, ContactSet>,
    /// Of each contact's face, if it is moved: its motion by height and tilts
    /// ([`Contact::with_surface`]).
    pub(in crate::estimate) motions: [SMatrix<f64, 6, 3>; 3],
}

impl Mount {
    /// Centre of mass [m, world] and orientation that a sample shows.
    pub fn seen(&self, sample: &ArcSample) -> (Vector3<f64>, nalgebra::UnitQuaternion<f64>) {
        if self.is_right {
            return (sample.position_m, sample.orientation);
        }
        let orientation = sample.orientation * so3::exp(&self.turn);
        let position_m =
            sample.position_m + sample.orientation * self.from_m - orientation * self.to_m;
        (position_m, orientation)
    }

    /// A sample's time after the clock's correction \[s\].
    pub fn time_s(&self, time_s: f64, zero_s: f64) -> f64 {
        if self.is_right {
            return time_s;
        }
        time_s + self.rate * (time_s - zero_s) + self.offset_s
    }
}
