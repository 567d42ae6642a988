//! A body that goes into something: which of their features keep them apart.

use nalgebra::Vector3;

use crate::estimate::problem::clearance::{ClearSolids, ClearanceTouches, KeptFrom};
use crate::motion::{Against, Estimate, LinkIndex, Penetration, Scene};
use crate::physics::State;
use crate::physics::contact::{Contact, Feature, Frame};
use crate::physics::outline::{Nearest, SolidOutline};

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

/// A body, and what it meets, at any time.
pub(in crate::estimate) struct OverlapMeeting<'a> {
    scene: &'a Scene,
    link: LinkIndex,
    against: Against,
    from: KeptFrom,
    outline: SolidOutline,
    with: MetOutline,
    states: &'a dyn Fn(f64) -> Option<[State; 2]>,
}

/// What a body meets.
enum MetOutline {
    Plane {
        point_m: Vector3<f64>,
        normal: Vector3<f64>,
    },
    Solid(SolidOutline),
}

/// One pair of features all the time.
fn one(contact: Contact) -> ClearanceTouches {
    ClearanceTouches::One(Box::new(contact))
}

/// The body that must keep out and what of: a body in the hand moves as it does.
pub(in crate::estimate) fn keeping_out(scene: &Scene, found: &Penetration) -> (LinkIndex, Against) {
    match found.against {
        Against::Link(other) if scene.is_held(found.link) => (other, Against::Link(found.link)),
        against => (found.link, against),
    }
}

/// Where what a body must stay out of stands; `None` of another body.
pub(in crate::estimate) fn standing(scene: &Scene, against: Against) -> Option<Frame> {
    match against {
        Against::Surface(_) => Some(Frame::world()),
        Against::Obstacle(index) => {
            let pose = &scene.obstacles[index].world_from_shape;
            Some(Frame {
                position_m: pose.translation.vector,
                orientation: pose.rotation,
            })
        }
        Against::Link(_) => None,
    }
}

/// How what a body must stay out of moves.
pub(in crate::estimate) fn kept_from(
    scene: &Scene,
    estimate: &Estimate,
    against: Against,
) -> KeptFrom {
    let held = match against {
        Against::Link(other) => estimate.held_motion(other),
        Against::Surface(_) | Against::Obstacle(_) => None,
    };
    match (standing(scene, against), held) {
        (Some(frame), _) => KeptFrom::Still(frame),
        (None, Some(held)) => KeptFrom::Held(Box::new(held.clone())),
        (None, None) => KeptFrom::Flying,
    }
}

/// Its state at a time, where it stands still, at rest, or is in a hand; `None` of what else moves.
pub(in crate::estimate) fn given_state(from: &KeptFrom, time_s: f64) -> Option<State> {
    match from {
        KeptFrom::Still(frame) => Some(State {
            position_m: frame.position_m,
            orientation: frame.orientation,
            ..State::at_rest()
        }),
        KeptFrom::Held(held) => Some(held.state(time_s)),
        KeptFrom::Flying => None,
    }
}

impl<'a> OverlapMeeting<'a> {
    /// By the states of both at any time; `None` where one is no solid.
    pub(in crate::estimate) fn new(
        scene: &'a Scene,
        link: LinkIndex,
        against: Against,
        from: KeptFrom,
        states: &'a dyn Fn(f64) -> Option<[State; 2]>,
    ) -> Option<Self> {
        let of_link = |link: LinkIndex| {
            let of = &scene.links[link];
            SolidOutline::new(&of.shape, &of.shape_at_m).ok()
        };
        let with = match against {
            Against::Surface(surface) => {
                let (point_m, normal) = scene.surfaces[surface].plane()?;
                MetOutline::Plane { point_m, normal }
            }
            Against::Obstacle(index) => {
                let shape = &scene.obstacles[index].shape;
                MetOutline::Solid(SolidOutline::new(shape, &Vector3::zeros()).ok()?)
            }
            Against::Link(other) => MetOutline::Solid(of_link(other)?),
        };
        Some(Self {
            scene,
            link,
            against,
            from,
            outline: of_link(link)?,
            with,
            states,
        })
    }

    /// What keeps them apart about a time at which they are so deep in each other, between the ends of their motion \[s\];
    /// `None` where no features tell.
    pub(in crate::estimate) fn solids(
        self,
        time_s: f64,
        depth_m: f64,
        ends_s: [f64; 2],
    ) -> Option<ClearSolids> {
        let speed_m_s = self.speed_m_s(time_s)?.max(f64::MIN_POSITIVE);
        let nearest = self.nearest(time_s)?;
        let beside_s = BESIDE_M / speed_m_s;
        let touches = if (nearest.gap_m + depth_m).abs() > SAME_M {
            // What is deeper is of a feature that may touch.
            one(self.of_feature(time_s, depth_m)?)
        } else {
            let sides_s = [time_s - beside_s, time_s + beside_s];
            let is_within = sides_s[0] > ends_s[0] && sides_s[1] < ends_s[1];
            let sides = is_within.then(|| sides_s.map(|at_s| self.nearest(at_s)));
            match sides {
                Some([Some(before), Some(after)]) => {
                    self.touches(time_s, sides_s, &nearest, [before, after])
                }
                _ => one(nearest.contact),
            }
        };
        let mut radius_m = self.scene.links[self.link].radius_m();
        if let Against::Link(other) = self.against {
            radius_m = radius_m.min(self.scene.links[other].radius_m());
        }
        Some(ClearSolids {
            link: self.link,
            against: self.against,
            from: self.from,
            touches,
            around_s: time_s,
            reach_s: REACH * radius_m / speed_m_s,
            least_m: LEAST * self.scene.tolerance_m,
            depth_m,
        })
    }

    /// Features before and after the moment at which the solids are deepest.
    fn touches(
        &self,
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
                let [at, other_at] = self.frames(at_s)?;
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
            let [at, other_at] = self.frames(time_s)?;
            let MetOutline::Solid(outline) = &self.with else {
                return None;
            };
            let way = self.way_m_s(time_s)?;
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
        let [at, _] = self.frames(time_s)?;
        let features = self.scene.links[self.link].features.iter();
        let contacts = features.filter_map(|of| Contact::new(of.geometry, face).ok());
        let gap_m = |of: &Contact| Some(of.touch(&at, &Frame::world()).ok()?.gap_m);
        let mut same =
            contacts.filter(|of| gap_m(of).is_some_and(|gap_m| (gap_m + depth_m).abs() < SAME_M));
        same.next()
    }

    fn nearest(&self, time_s: f64) -> Option<Nearest> {
        let [at, other_at] = self.frames(time_s)?;
        match &self.with {
            MetOutline::Plane { point_m, normal } => self.outline.lowest(&at, point_m, normal),
            MetOutline::Solid(outline) => self.outline.nearest(&at, outline, &other_at),
        }
    }

    fn frames(&self, time_s: f64) -> Option<[Frame; 2]> {
        let both = (self.states)(time_s)?;
        Some([Frame::of(&both[0]), Frame::of(&both[1])])
    }

    /// Velocity of the body relative to what it meets [m/s, world].
    fn way_m_s(&self, time_s: f64) -> Option<Vector3<f64>> {
        let [own, other] = (self.states)(time_s)?;
        Some(own.velocity_m_s - other.velocity_m_s)
    }

    /// Upper bound of the speed of its points relative to what it meets [m/s].
    fn speed_m_s(&self, time_s: f64) -> Option<f64> {
        let [own, other] = (self.states)(time_s)?;
        let mut speed_m_s = (own.velocity_m_s - other.velocity_m_s).norm();
        speed_m_s += own.angular_velocity_rad_s.norm() * self.scene.links[self.link].radius_m();
        if let Against::Link(link) = self.against {
            speed_m_s += other.angular_velocity_rad_s.norm() * self.scene.links[link].radius_m();
        }
        Some(speed_m_s)
    }
}
