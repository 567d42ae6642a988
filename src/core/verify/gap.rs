//! Distances between the expected features of a collision.
//!
//! They are parry's distances where these measure the features that the scene expects to touch,
//! else the gap function of the contact. The measure is chosen contact by contact just before the
//! collision: the first of these whose nearest points lie on the expected features:
//!
//! - for a point, rounded or not: from its ball to the whole solid of the other side;
//! - between the two whole solids;
//! - between the features themselves as infinite geometry ([`Contact::touch`]): where a rim or an
//!   edge is named that another part of the solid hides, or a face is met beyond its solid's edge.

use nalgebra::{Point3, Vector3};

use super::expected;
use super::law::CheckedLaw;
use super::meeting::{FINITE, MeetingPartner, World};
use crate::math::Pose;
use crate::motion::Against;
use crate::physics::contact::{Contact, Feature, Frame};
use crate::physics::shape::Solid;

/// The gaps of the contacts of a collision.
pub(super) struct Gaps<'w> {
    solid: &'w Solid,
    contacts: Vec<ContactGap<'w>>,
}

struct ContactGap<'w> {
    contact: Contact,
    partner: MeetingPartner<'w>,
    measure: MeasuredPair,
}

/// The pair whose distance is measured.
enum MeasuredPair {
    /// The body's point and the partner's solid.
    PointBall(PointBall),
    /// The partner's point and the body's solid.
    BallOfPartner(PointBall),
    /// The body's solid and the partner's.
    Solids,
    /// The two features.
    Features,
}

/// A point of a body or of the world, with its radius.
struct PointBall {
    centre_m: Vector3<f64>,
    solid: Solid,
}

impl<'w> Gaps<'w> {
    /// The gaps of a collision; the measures are chosen in these poses. `None` where the
    /// other body has no arc that ends at the event.
    pub(super) fn new(
        world: &'w World<'w>,
        law: &CheckedLaw,
        event: usize,
        body: &Pose,
        other: Option<&Pose>,
    ) -> Option<Self> {
        let collision = world.scene.events[event].kind.collision()?;
        let events = &world.estimate.events;
        let time_s = events.iter().find(|e| e.event == event)?.time_s;
        let solid = &world.links[law.link].solid;
        let pairs = law.contacts.as_slice().iter().zip(&collision.contacts);
        let contacts = pairs.map(|(contact, touching)| {
            let against = match law.other {
                Some(other) => Against::Link(other),
                None => {
                    let surface = touching.other?;
                    match world.scene.surfaces[surface].obstacle {
                        Some(obstacle) => Against::Obstacle(obstacle),
                        None => Against::Surface(surface),
                    }
                }
            };
            let partner = world.partner(against, Some(time_s))?;
            Some(ContactGap {
                contact: *contact,
                partner,
                measure: MeasuredPair::of(contact, &partner, solid, body, other),
            })
        });
        Some(Self {
            solid,
            contacts: contacts.collect::<Option<_>>()?,
        })
    }

    /// The least of them in these poses \[m\]; `None` where a contact is degenerate.
    pub(super) fn least_m(&self, body: &Pose, other: Option<&Pose>) -> Option<f64> {
        let mut least_m = f64::INFINITY;
        for gap in &self.contacts {
            least_m = least_m.min(gap.gap_m(self.solid, body, other)?);
        }
        Some(least_m)
    }
}

impl ContactGap<'_> {
    fn gap_m(&self, solid: &Solid, body: &Pose, other: Option<&Pose>) -> Option<f64> {
        let closest = match &self.measure {
            MeasuredPair::PointBall(ball) => {
                self.partner
                    .closest_to(&ball.solid, &ball.placed(Some(body)), other)
            }
            MeasuredPair::BallOfPartner(ball) => ball
                .solid
                .closest(&ball.placed(other), solid, body)
                .expect(FINITE),
            MeasuredPair::Solids => self.partner.closest_to(solid, body, other),
            MeasuredPair::Features => {
                let frame = |pose: &Pose| Frame {
                    position_m: pose.translation.vector,
                    orientation: pose.rotation,
                };
                let other = other.map_or(Frame::world(), frame);
                return Some(self.contact.touch(&frame(body), &other).ok()?.gap_m);
            }
        };
        Some(closest.gap_m)
    }
}

impl MeasuredPair {
    fn of(
        contact: &Contact,
        partner: &MeetingPartner,
        solid: &Solid,
        body: &Pose,
        other: Option<&Pose>,
    ) -> Self {
        // The first point is in the body's axes, the second in those of the world.
        let is_on_body = |point_m: &Vector3<f64>| expected::is_on(contact.a(), point_m);
        let is_on_partner = |point_m: &Vector3<f64>| {
            let to_partner = other.map_or(Pose::identity(), Pose::inverse);
            let point_m = to_partner * Point3::from(*point_m);
            expected::is_on(contact.b(), &point_m.coords)
        };
        if let Some(ball) = PointBall::of(contact.a()) {
            let at = ball.placed(Some(body));
            let closest = partner.closest_to(&ball.solid, &at, other);
            if is_on_partner(&closest.other_point_m) {
                return MeasuredPair::PointBall(ball);
            }
        }
        if let Some(ball) = PointBall::of(contact.b()) {
            let at = ball.placed(other);
            let closest = ball.solid.closest(&at, solid, body).expect(FINITE);
            let point_m = body.inverse_transform_point(&Point3::from(closest.other_point_m));
            if is_on_body(&point_m.coords) {
                return MeasuredPair::BallOfPartner(ball);
            }
        }
        let closest = partner.closest_to(solid, body, other);
        if is_on_body(&closest.point_m) && is_on_partner(&closest.other_point_m) {
            return MeasuredPair::Solids;
        }
        MeasuredPair::Features
    }
}

impl PointBall {
    /// The ball of a point feature; `None` for other features.
    fn of(feature: &Feature) -> Option<Self> {
        let Feature::Point { point_m, radius_m } = *feature else {
            return None;
        };
        Some(Self {
            centre_m: point_m,
            solid: Solid::ball(radius_m),
        })
    }

    /// Its pose, given that of its body; without a body, its pose in the world.
    fn placed(&self, body: Option<&Pose>) -> Pose {
        let centre_m = Point3::from(self.centre_m);
        let centre_m = body.map_or(centre_m, |pose| pose * centre_m);
        Pose::from(centre_m.coords)
    }
}
