//! How far apart the expected features of a collision are.
//!
//! By parry's distances where they measure what the scene expects to touch, else by the gap
//! function of the contact. What is measured is chosen contact by contact just before the
//! collision, the first of these whose nearest points lie on the expected features:
//!
//! - of a point, rounded or not, the ball that it is from the whole solid of the other side;
//! - the two whole solids from each other;
//! - the features themselves, endless as they are ([`Contact::touch`]): where a rim or an edge
//!   is named that another part of the solid hides, or a face is met beyond its solid's edge.

use nalgebra::{Point3, Vector3};

use super::expected;
use super::law::Law;
use super::meeting::{FINITE, Partner, World};
use crate::math::Pose;
use crate::motion::Against;
use crate::physics::contact::{Contact, Feature, Frame};
use crate::physics::shape::Solid;

/// The gaps of the contacts of a collision.
pub(super) struct Gaps<'w> {
    solid: &'w Solid,
    contacts: Vec<Gap<'w>>,
}

struct Gap<'w> {
    contact: Contact,
    partner: Partner<'w>,
    measure: Measure,
}

/// What is measured.
enum Measure {
    /// The body's point, from the partner's solid.
    Ball(Ball),
    /// The partner's point, from the body's solid.
    BallOfPartner(Ball),
    /// The body's solid from the partner's.
    Solids,
    /// The features.
    Features,
}

/// A point of a body or of the world, with its radius.
struct Ball {
    centre_m: Vector3<f64>,
    solid: Solid,
}

impl<'w> Gaps<'w> {
    /// Those of a collision; what measures them is chosen in these poses. `None` where the
    /// other body does not fly up to the event.
    pub(super) fn new(
        world: &'w World<'w>,
        law: &Law,
        event: usize,
        body: &Pose,
        other: Option<&Pose>,
    ) -> Option<Self> {
        let collision = world.scene.events[event].kind.collision()?;
        let events = &world.estimate.events;
        let time_s = events.iter().find(|e| e.event == event)?.time_s;
        let solid = &world.links[law.link].solid;
        let pairs = law.meeting.contacts().iter().zip(&collision.contacts);
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
            Some(Gap {
                contact: *contact,
                partner,
                measure: Measure::of(contact, &partner, solid, body, other),
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

impl Gap<'_> {
    fn gap_m(&self, solid: &Solid, body: &Pose, other: Option<&Pose>) -> Option<f64> {
        let closest = match &self.measure {
            Measure::Ball(ball) => {
                self.partner
                    .closest_to(&ball.solid, &ball.placed(Some(body)), other)
            }
            Measure::BallOfPartner(ball) => ball
                .solid
                .closest(&ball.placed(other), solid, body)
                .expect(FINITE),
            Measure::Solids => self.partner.closest_to(solid, body, other),
            Measure::Features => {
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

impl Measure {
    fn of(
        contact: &Contact,
        partner: &Partner,
        solid: &Solid,
        body: &Pose,
        other: Option<&Pose>,
    ) -> Self {
        // Points are of the body's axes, of the world's.
        let is_on_body = |point_m: &Vector3<f64>| expected::is_on(contact.a(), point_m);
        let is_on_partner = |point_m: &Vector3<f64>| {
            let to_partner = other.map_or(Pose::identity(), Pose::inverse);
            let point_m = to_partner * Point3::from(*point_m);
            expected::is_on(contact.b(), &point_m.coords)
        };
        if let Some(ball) = Ball::of(contact.a()) {
            let at = ball.placed(Some(body));
            let closest = partner.closest_to(&ball.solid, &at, other);
            if is_on_partner(&closest.other_point_m) {
                return Measure::Ball(ball);
            }
        }
        if let Some(ball) = Ball::of(contact.b()) {
            let at = ball.placed(other);
            let closest = ball.solid.closest(&at, solid, body).expect(FINITE);
            let point_m = body.inverse_transform_point(&Point3::from(closest.other_point_m));
            if is_on_body(&point_m.coords) {
                return Measure::BallOfPartner(ball);
            }
        }
        let closest = partner.closest_to(solid, body, other);
        if is_on_body(&closest.point_m) && is_on_partner(&closest.other_point_m) {
            return Measure::Solids;
        }
        Measure::Features
    }
}

impl Ball {
    /// Of a point.
    fn of(feature: &Feature) -> Option<Self> {
        let Feature::Point { point_m, radius_m } = *feature else {
            return None;
        };
        Some(Self {
            centre_m: point_m,
            solid: Solid::ball(radius_m),
        })
    }

    /// Where it is when its body is there; of the world's, without.
    fn placed(&self, body: Option<&Pose>) -> Pose {
        let centre_m = Point3::from(self.centre_m);
        let centre_m = body.map_or(centre_m, |pose| pose * centre_m);
        Pose::from(centre_m.coords)
    }
}
