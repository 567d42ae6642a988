//! The clearances that a motion's overlaps ask for.

use nalgebra::Vector3;

use super::conditions::acting;
use crate::estimate::covariance::timing;
use crate::estimate::problem::Problem;
use crate::estimate::problem::clearance::{Clearance, ClearanceTouches, FlightEnd, KeptFrom};
use crate::motion::{Against, ArcEstimate, Estimate, LinkIndex, Penetration, Scene};
use crate::physics::contact::{Contact, Feature, Frame};
use crate::physics::outline::{Nearest, SolidOutline};
use crate::physics::{State, flow};

/// Least distance that is asked for, in tolerances: overlaps within the tolerance are none.
const LEAST: f64 = -0.5;
/// How far a body may go between the moment at which it is deepest and that at which it will be nearest, in radii.
const REACH: f64 = 0.3;
/// Way \[m\] before and after a moment at which features are looked for again.
const BESIDE_M: f64 = 5e-5;
/// Cosine of the angle between normals before and after that are the same.
const SAME: f64 = 0.98;
/// Least length of the mean of two unit normals that shows a way out.
const SHOWN: f64 = 0.3;
/// Difference of two depths that are the same \[m\].
const SAME_M: f64 = 2e-5;

/// A motion whose solids overlap.
pub(in crate::estimate) struct Overlapping<'a> {
    /// The scene as estimated.
    pub(in crate::estimate) scene: &'a Scene,
    /// The motion.
    pub(in crate::estimate) estimate: &'a Estimate,
    /// The problem that it solves.
    pub(in crate::estimate) problem: &'a Problem,
}

/// A body, and what it meets, at any time.
struct OverlapMeeting<'a> {
    of: &'a Overlapping<'a>,
    link: LinkIndex,
    arc: usize,
    flight: &'a ArcEstimate,
    outline: SolidOutline,
    with: MetOutline,
}

/// What a body meets.
enum MetOutline {
    Plane {
        point_m: Vector3<f64>,
        normal: Vector3<f64>,
    },
    Solid {
        outline: SolidOutline,
        from: KeptFrom,
        arc: Option<usize>,
    },
}

/// One pair of features all the time.
fn one(contact: Contact) -> ClearanceTouches {
    ClearanceTouches::One(Box::new(contact))
}

impl<'a> Overlapping<'a> {
    /// What keeps the two solids of an overlap out of each other about its moment; `None` where no features tell.
    pub(in crate::estimate) fn clearance(&'a self, found: &Penetration) -> Option<Clearance> {
        let Penetration {
            link,
            against,
            time_s,
            ..
        } = *found;
        // What is in the hand does not fly.
        let (link, against) = match against {
            Against::Link(other) if self.scene.is_held(link) => (other, Against::Link(link)),
            _ => (link, against),
        };
        let (arc, flight) = self.flight(link, time_s)?;
        let of_link = &self.scene.links[link];
        let with = self.met(against, time_s)?;
        let meeting = OverlapMeeting {
            of: self,
            link,
            arc,
            flight,
            outline: SolidOutline::new(&of_link.shape, &of_link.shape_at_m).ok()?,
            with,
        };
        meeting.clearance(against, time_s, found.depth_m)
    }

    /// The arc of a link at a time, in the problem and as estimated: of two that meet there the first.
    fn flight(&self, link: LinkIndex, time_s: f64) -> Option<(usize, &'a ArcEstimate)> {
        let mechanism = self.scene.mechanism_of(link);
        let mut flown = self.estimate.arcs.iter();
        let flown = flown.find(|arc| {
            arc.mechanism == mechanism && arc.start_s <= time_s && time_s <= arc.end_s
        })?;
        // Arcs of a mechanism are in order of time in both.
        let of_it = |of: &&ArcEstimate| of.mechanism == mechanism && of.start_s < flown.start_s;
        let place = self.estimate.arcs.iter().filter(of_it).count();
        let arcs = self.problem.arcs.iter().enumerate();
        let mut arcs = arcs.filter(|(_, arc)| arc.mechanism == mechanism);
        Some((arcs.nth(place)?.0, flown))
    }

    fn met(&self, against: Against, time_s: f64) -> Option<MetOutline> {
        match against {
            Against::Surface(surface) => {
                let (point_m, normal) = self.scene.surfaces[surface].plane()?;
                Some(MetOutline::Plane { point_m, normal })
            }
            Against::Obstacle(index) => {
                let obstacle = &self.scene.obstacles[index];
                let pose = &obstacle.world_from_shape;
                let frame = Frame {
                    position_m: pose.translation.vector,
                    orientation: pose.rotation,
                };
                Some(MetOutline::Solid {
                    outline: SolidOutline::new(&obstacle.shape, &Vector3::zeros()).ok()?,
                    from: KeptFrom::Still(frame),
                    arc: None,
                })
            }
            Against::Link(other) => {
                let of_other = &self.scene.links[other];
                let outline = SolidOutline::new(&of_other.shape, &of_other.shape_at_m).ok()?;
                let held = self.estimate.held_motion(other);
                let (from, arc) = match held {
                    Some(held) => (KeptFrom::Held(Box::new(held.clone())), None),
                    None => (KeptFrom::Flying, Some(self.flight(other, time_s)?.0)),
                };
                Some(MetOutline::Solid { outline, from, arc })
            }
        }
    }

    fn state(&self, link: LinkIndex, flight: &ArcEstimate, time_s: f64) -> State {
        let body = &self.scene.links[link].body;
        let since_s = time_s - flight.epoch_s;
        flow::advance(body, &self.estimate.gravity_m_s2, &flight.state, since_s)
    }
}

impl OverlapMeeting<'_> {
    fn clearance(&self, against: Against, time_s: f64, depth_m: f64) -> Option<Clearance> {
        let other = match (&self.with, against) {
            (MetOutline::Solid { arc: Some(arc), .. }, Against::Link(other)) => {
                Some((*arc, self.of.flight(other, time_s)?.1))
            }
            _ => None,
        };
        let others = other.map(|(_, flight)| flight);
        let from_s = others.map_or(self.flight.start_s, |of| {
            of.start_s.max(self.flight.start_s)
        });
        let to_s = others.map_or(self.flight.end_s, |of| of.end_s.min(self.flight.end_s));
        let speed_m_s = self.speed_m_s(against, time_s)?.max(f64::MIN_POSITIVE);
        let nearest = self.nearest(against, time_s)?;
        let beside_s = BESIDE_M / speed_m_s;
        let touches = if (nearest.gap_m + depth_m).abs() > SAME_M {
            // What is deeper is of a feature that may touch.
            one(self.of_feature(time_s, depth_m)?)
        } else {
            let sides_s = [time_s - beside_s, time_s + beside_s];
            let is_within = sides_s[0] > from_s && sides_s[1] < to_s;
            let sides = is_within.then(|| sides_s.map(|at_s| self.nearest(against, at_s)));
            match sides {
                Some([Some(before), Some(after)]) => {
                    self.touches(against, time_s, sides_s, &nearest, [before, after])
                }
                _ => one(nearest.contact),
            }
        };
        let arcs: Vec<usize> = [self.arc]
            .into_iter()
            .chain(other.map(|(arc, _)| arc))
            .collect();
        let problem = self.of.problem;
        let own = [(self.arc, self.flight)].into_iter().chain(other);
        let end = |side: usize, at_s: f64| {
            let mut ended = own
                .clone()
                .filter(|(_, flight)| [flight.start_s, flight.end_s][side] == at_s);
            ended
                .next()
                .map_or(FlightEnd::At(at_s), |(arc, _)| self.end(arc, side, at_s))
        };
        let mut radius_m = self.of.scene.links[self.link].radius_m();
        if let Against::Link(other) = against {
            radius_m = radius_m.min(self.of.scene.links[other].radius_m());
        }
        Some(Clearance {
            link: self.link,
            against,
            from: match &self.with {
                MetOutline::Plane { .. } => KeptFrom::Still(Frame::world()),
                MetOutline::Solid { from, .. } => from.clone(),
            },
            touches,
            around_s: time_s,
            reach_s: REACH * radius_m / speed_m_s,
            ends: [end(0, from_s), end(1, to_s)],
            depth_m,
            least_m: LEAST * self.of.scene.tolerance_m,
            acting: acting(&problem.arcs, &arcs, &problem.gravity_parameters, &[]),
            arcs,
        })
    }

    /// How an end of an arc, which is at a time, moves.
    fn end(&self, arc: usize, side: usize, at_s: f64) -> FlightEnd {
        let problem = self.of.problem;
        let arc = &problem.arcs[arc];
        let event = [arc.start, arc.end][side];
        if let Some(event) = event.filter(|event| problem.event_is_free[*event]) {
            return FlightEnd::Event(event);
        }
        if !problem.times_are_unknown() {
            return FlightEnd::At(at_s);
        }
        if let Some(event) = event {
            let (node, share) = timing::place(problem, event);
            return FlightEnd::Node(node, share);
        }
        let sample = arc.ends().map(|ends| ends[side]);
        sample.map_or(FlightEnd::At(at_s), |of| FlightEnd::Node(of.node, of.share))
    }

    /// Features before and after the moment at which the solids are deepest.
    fn touches(
        &self,
        against: Against,
        time_s: f64,
        sides_s: [f64; 2],
        nearest: &Nearest,
        [before, after]: [Nearest; 2],
    ) -> ClearanceTouches {
        let single = one(nearest.contact);
        if before.normal.dot(&after.normal) > SAME {
            return single;
        }
        let rate = |of: &Nearest| {
            let gap_m = |at_s: f64| {
                let (at, other_at) = self.frames(against, at_s)?;
                let touch = of.contact.touch(&at, &other_at).ok()?;
                Some(touch.gap_m)
            };
            Some((gap_m(sides_s[1])? - gap_m(sides_s[0])?) / (sides_s[1] - sides_s[0]))
        };
        let (Some(falls), Some(rises)) = (rate(&before), rate(&after)) else {
            return single;
        };
        if !(falls < 0.0 && rises > 0.0) {
            return single;
        }
        let share = rises / (rises - falls);
        let out = before.normal * share + after.normal * (1.0 - share);
        if out.norm() >= SHOWN {
            return ClearanceTouches::Switching(Box::new([before.contact, after.contact]));
        }
        // Straight through: the way out is across.
        let aside = || {
            let (at, other_at) = self.frames(against, time_s)?;
            let MetOutline::Solid { outline, .. } = &self.with else {
                return None;
            };
            let way = self.way_m_s(against, time_s)?;
            self.outline.aside(&at, outline, &other_at, &way)
        };
        aside().map_or(single, |aside| one(aside.contact))
    }

    /// The feature that may touch and is so deep.
    fn of_feature(&self, time_s: f64, depth_m: f64) -> Option<Contact> {
        let MetOutline::Plane { point_m, normal } = &self.with else {
            return None;
        };
        let face = Feature::face(*point_m, *normal);
        let at = Frame::of(&self.of.state(self.link, self.flight, time_s));
        let features = self.of.scene.links[self.link].features.iter();
        let contacts = features.filter_map(|of| Contact::new(of.geometry, face).ok());
        let gap_m = |of: &Contact| Some(of.touch(&at, &Frame::world()).ok()?.gap_m);
        let mut same =
            contacts.filter(|of| gap_m(of).is_some_and(|gap_m| (gap_m + depth_m).abs() < SAME_M));
        same.next()
    }

    fn nearest(&self, against: Against, time_s: f64) -> Option<Nearest> {
        let (at, other_at) = self.frames(against, time_s)?;
        match &self.with {
            MetOutline::Plane { point_m, normal } => self.outline.lowest(&at, point_m, normal),
            MetOutline::Solid { outline, .. } => self.outline.nearest(&at, outline, &other_at),
        }
    }

    /// States of both; what stands still is at rest.
    fn states(&self, against: Against, time_s: f64) -> Option<[State; 2]> {
        let own = self.of.state(self.link, self.flight, time_s);
        let other = match (&self.with, against) {
            (
                MetOutline::Solid {
                    from: KeptFrom::Held(held),
                    ..
                },
                _,
            ) => held.state(time_s),
            (
                MetOutline::Solid {
                    from: KeptFrom::Still(frame),
                    ..
                },
                _,
            ) => State {
                position_m: frame.position_m,
                orientation: frame.orientation,
                ..State::at_rest()
            },
            (MetOutline::Solid { .. }, Against::Link(other)) => {
                let (_, flight) = self.of.flight(other, time_s)?;
                self.of.state(other, flight, time_s)
            }
            _ => State::at_rest(),
        };
        Some([own, other])
    }

    fn frames(&self, against: Against, time_s: f64) -> Option<(Frame, Frame)> {
        let [own, other] = self.states(against, time_s)?;
        Some((Frame::of(&own), Frame::of(&other)))
    }

    /// Velocity of the body relative to what it meets [m/s, world].
    fn way_m_s(&self, against: Against, time_s: f64) -> Option<Vector3<f64>> {
        let [own, other] = self.states(against, time_s)?;
        Some(own.velocity_m_s - other.velocity_m_s)
    }

    /// Upper bound of the speed of its points relative to what it meets [m/s].
    fn speed_m_s(&self, against: Against, time_s: f64) -> Option<f64> {
        let [own, other] = self.states(against, time_s)?;
        let mut speed_m_s = (own.velocity_m_s - other.velocity_m_s).norm();
        speed_m_s += own.angular_velocity_rad_s.norm() * self.of.scene.links[self.link].radius_m();
        if let Against::Link(link) = against {
            speed_m_s += other.angular_velocity_rad_s.norm() * self.of.scene.links[link].radius_m();
        }
        Some(speed_m_s)
    }
}
