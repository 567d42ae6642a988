//! Infers which features touch at a collision (paper §5.1) from the poses of the arc fits.
//!
//! Against a plane the lowest feature touches first, so that candidates are ranked by their gaps in
//! the poses of the fits before and after the event. Two solids are first moved back along their
//! flights to the beginning of their overlap; there candidates are ranked by their gap plus the
//! distance of their contact points from the solids (since features are infinite as geometry).

use nalgebra::Vector3;

use crate::math::{Pose, so3};
use crate::motion::held::Mounted;
use crate::motion::{
    Contacts, Goal, GoalTarget, Guess, HeldMotion, LinkIndex, Partner, Scene, Seen, Segment,
    Sketch, Touching,
};
use crate::physics::contact::{Contact, Frame, Touch};
use crate::physics::shape::Solid;
use crate::physics::{Shape, State};

/// Longest time by which two solids are moved back \[s\], and number of bisections.
const BACK_S: f64 = 0.25;
const HALVINGS: usize = 16;
/// Distance of a contact point from a solid that is not counted, relative to the solid's radius.
const SLACK: f64 = 0.02;
/// Greatest distance of a likely candidate beyond the first, in spreads.
const SPREADS_MAX: f64 = 4.0;

/// A candidate, and its distance from the performance.
#[derive(Clone, Debug, PartialEq)]
pub struct Reach {
    /// The contacts.
    pub contacts: Contacts,
    /// Change of the pose for which these contacts would touch first \[m\].
    pub reach_m: f64,
}

/// The candidates of one collision.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranking {
    /// The collision (index into `Scene::events`).
    pub event: usize,
    /// Candidates; the one that touches first comes first.
    pub candidates: Vec<Reach>,
    /// Uncertainty of the bodies' surfaces at the event \[m\].
    pub spread_m: f64,
}

impl Ranking {
    /// Whether the second is as good as the first within the uncertainty.
    pub fn is_ambiguous(&self) -> bool {
        const SPREADS: f64 = 2.0;
        let reach_m = |index: usize| self.candidates.get(index).map(|c| c.reach_m);
        match (reach_m(0), reach_m(1)) {
            (Some(first_m), Some(second_m)) => second_m - first_m < SPREADS * self.spread_m,
            _ => false,
        }
    }

    /// Candidates that are not much farther from touching than the first.
    pub fn likely(&self) -> &[Reach] {
        let first_m = self.candidates.first().map_or(0.0, |first| first.reach_m);
        let most_m = first_m + SPREADS_MAX * self.spread_m;
        let count = self.candidates.partition_point(|c| c.reach_m <= most_m);
        &self.candidates[..count]
    }
}

/// Ranks the candidates of an open collision by the arc fits on both sides of it.
///
/// There are none where no pair of features may touch.
pub fn rank(
    scene: &Scene,
    sketch: &Sketch,
    segments: &[Segment],
    guess: &Guess,
    event: usize,
) -> Ranking {
    let view = View {
        scene,
        sketch,
        segments,
        guess,
        event,
    };
    let mut candidates: Vec<Reach> = Vec::new();
    let all = scene.candidates(event);
    let Some(collision) = scene.events[event].kind.collision() else {
        return Ranking {
            event,
            candidates,
            spread_m: 0.0,
        };
    };
    match collision.partner {
        Partner::Link(_) => candidates.extend(view.against_solid(&all, None)),
        Partner::World => {
            for surface in 0..scene.surfaces.len() {
                let of_it = with_surfaces(&all, |other| other == surface);
                if scene.surfaces[surface].obstacle.is_none() {
                    candidates.extend(view.against_plane(&of_it));
                }
            }
            for obstacle in 0..scene.obstacles.len() {
                let of_it = with_surfaces(&all, |other| {
                    scene.surfaces[other].obstacle == Some(obstacle)
                });
                candidates.extend(view.against_solid(&of_it, Some(obstacle)));
            }
        }
    }
    candidates.sort_by(|a, b| a.reach_m.total_cmp(&b.reach_m));
    // The distance of fits from samples, or half that of the first candidate from touching.
    let first_m = candidates.first().map_or(0.0, |first| first.reach_m);
    Ranking {
        event,
        candidates,
        spread_m: view.spread_m().max(0.5 * first_m),
    }
}

fn with_surfaces(all: &[Contacts], is_wanted: impl Fn(usize) -> bool) -> Vec<Contacts> {
    let wanted = |contacts: &&Contacts| contacts[0].other.is_some_and(&is_wanted);
    all.iter().filter(wanted).cloned().collect()
}

struct View<'a> {
    scene: &'a Scene,
    sketch: &'a Sketch,
    segments: &'a [Segment],
    guess: &'a Guess,
    event: usize,
}

impl View<'_> {
    fn links(&self) -> Vec<LinkIndex> {
        let collision = self.scene.events[self.event].kind.collision();
        collision.map_or_else(Vec::new, |collision| collision.links().collect())
    }

    /// The link's arcs that end (or begin) at the event.
    fn arc(&self, link: LinkIndex, ends: bool) -> Option<usize> {
        let mechanism = self.scene.mechanism_of(link);
        self.segments.iter().position(|segment| {
            let event = if ends {
                segment.end_event
            } else {
                segment.start_event
            };
            segment.mechanism == mechanism && event == Some(self.event)
        })
    }

    /// The pose that a goal requires of a link at the event.
    fn goal(&self, link: LinkIndex) -> Option<Frame> {
        let at = |goal: &&Goal| goal.event == self.event && goal.link == link;
        let mut goals = self.scene.goals.iter().filter(at);
        goals.find_map(|goal| match &goal.target {
            GoalTarget::Pose { world_from_body } => Some(Frame {
                position_m: world_from_body.translation.vector,
                orientation: world_from_body.rotation,
            }),
            GoalTarget::PositionWithin { .. } | GoalTarget::Condition(_) => None,
        })
    }

    /// The state by the fit of an arc, a time after the event; moved through the pose of a goal
    /// there.
    fn state(&self, arc: usize, after_s: f64) -> State {
        let fit = &self.guess.arcs[arc];
        let mechanism = self.segments[arc].mechanism;
        let link = self.scene.free_link(mechanism);
        let dynamics = self.scene.dynamics(mechanism);
        let advance = |state: &State, duration_s: f64| {
            dynamics.advance(&self.scene.gravity_m_s2, state, duration_s)
        };
        let duration_s = self.guess.event_times_s[self.event] - fit.epoch_s;
        let mut at_event = advance(&fit.state, duration_s);
        if let Some(goal) = self.goal(link) {
            at_event.position_m = goal.position_m;
            at_event.orientation = goal.orientation;
        }
        advance(&at_event, after_s)
    }

    fn contact(&self, touching: &Touching) -> Option<Contact> {
        let set = self.scene.contact_set_of(self.event, &[*touching]);
        set.ok()?.map(|set| set.as_slice()[0])
    }

    /// Gap of contacts with a plane, the lowest of several, averaged over both fits.
    fn gap_m(&self, contacts: &Contacts, link: LinkIndex) -> Option<f64> {
        let arcs = [true, false].map(|ends| self.arc(link, ends));
        let mut sum = (0.0, 0.0);
        for arc in arcs.into_iter().flatten() {
            let frame = Frame::of(&self.state(arc, 0.0));
            let gaps = contacts.iter().filter_map(|touching| {
                let touch = self.contact(touching)?.touch(&frame, &Frame::world());
                Some(touch.ok()?.gap_m)
            });
            let lowest_m = gaps.fold(f64::INFINITY, f64::min);
            sum = (sum.0 + lowest_m, sum.1 + 1.0);
        }
        (sum.1 > 0.0 && sum.0.is_finite()).then_some(sum.0 / sum.1)
    }

    fn against_plane(&self, candidates: &[Contacts]) -> Vec<Reach> {
        let Some(link) = self.links().first().copied() else {
            return Vec::new();
        };
        let gaps: Vec<(&Contacts, f64)> = candidates
            .iter()
            .filter_map(|contacts| Some((contacts, self.gap_m(contacts, link)?)))
            .collect();
        let lowest_m = gaps
            .iter()
            .map(|(_, gap_m)| *gap_m)
            .fold(f64::INFINITY, f64::min);
        let reach = |(contacts, gap_m): (&Contacts, f64)| Reach {
            contacts: contacts.clone(),
            reach_m: lowest_m.abs() + gap_m - lowest_m,
        };
        gaps.into_iter().map(reach).collect()
    }

    /// Candidates against an obstacle, or against the other link.
    fn against_solid(&self, candidates: &[Contacts], obstacle: Option<usize>) -> Vec<Reach> {
        let Some(pair) = Solids::new(self, obstacle) else {
            return Vec::new();
        };
        let distance_m = pair.distance_m(0.0);
        let moment_s = pair.first_overlap_s();
        let gaps: Vec<(&Contacts, f64)> = candidates
            .iter()
            .filter_map(|contacts| {
                let gaps = contacts.iter().map(|touching| {
                    let contact = self.contact(touching)?;
                    pair.nearness_m(&contact, moment_s)
                });
                let farthest_m = gaps
                    .collect::<Option<Vec<f64>>>()?
                    .into_iter()
                    .fold(0.0, f64::max);
                Some((contacts, farthest_m))
            })
            .collect();
        let nearest_m = gaps
            .iter()
            .map(|(_, gap_m)| *gap_m)
            .fold(f64::INFINITY, f64::min);
        let reach = |(contacts, gap_m): (&Contacts, f64)| Reach {
            contacts: contacts.clone(),
            reach_m: distance_m.abs() + gap_m - nearest_m,
        };
        gaps.into_iter().map(reach).collect()
    }

    /// Root mean square distance of fits from samples near the event, plus the rms angle times the
    /// radius; the greatest over the links \[m\].
    fn spread_m(&self) -> f64 {
        let links = self.links().into_iter();
        links.map(|link| self.spread_of_m(link)).fold(0.0, f64::max)
    }

    fn spread_of_m(&self, link: LinkIndex) -> f64 {
        if self.goal(link).is_some() {
            return 0.0;
        }
        let radius_m = self.scene.links[link].shape.radius_m();
        let dynamics = self.scene.dynamics(self.scene.mechanism_of(link));
        let (mut shift_m2, mut turn_rad2, mut count) = (0.0, 0.0, 0.0);
        for arc in [true, false]
            .map(|ends| self.arc(link, ends))
            .into_iter()
            .flatten()
        {
            let samples = self.sketch.samples_in(&self.segments[arc]);
            let fit = &self.guess.arcs[arc];
            for (sample, time_s) in samples.zip(&fit.sample_times_s) {
                // What is not seen whole says less of what is near.
                let Seen::Pose {
                    position_m,
                    orientation,
                } = sample.seen
                else {
                    continue;
                };
                let gravity = &self.scene.gravity_m_s2;
                let duration_s = time_s - fit.epoch_s;
                let state = dynamics.advance(gravity, &fit.state, duration_s);
                shift_m2 += (state.position_m - position_m).norm_squared();
                let turn = so3::log(&(orientation.inverse() * state.orientation));
                turn_rad2 += turn.norm_squared();
                count += 1.0;
            }
        }
        if count == 0.0 {
            return 0.0;
        }
        (shift_m2 / count).sqrt() + radius_m * (turn_rad2 / count).sqrt()
    }
}

/// Two solids that meet, on the flights by which they do.
struct Solids<'a> {
    view: &'a View<'a>,
    shapes: [&'a Shape; 2],
    solids: [Solid; 2],
    point: Solid,
    /// Arc of the first, and of the second if it flies.
    arcs: (usize, Option<usize>),
    /// The second, if it is held.
    held: Option<HeldSolid<'a>>,
    /// Where the second stands otherwise.
    standing: Pose,
}

impl<'a> Solids<'a> {
    fn new(view: &'a View<'a>, obstacle: Option<usize>) -> Option<Self> {
        let links = view.links();
        let first = *links.first()?;
        let scene = view.scene;
        let mut held = None;
        let (shape, arc, standing) = match obstacle {
            Some(obstacle) => {
                let obstacle = &scene.obstacles[obstacle];
                (&obstacle.shape, None, obstacle.world_from_shape)
            }
            None => {
                let second = *links.get(1)?;
                let arc = if scene.is_held(second) {
                    held = Some(HeldSolid::new(view, second)?);
                    None
                } else {
                    Some(view.arc(second, true)?)
                };
                (&scene.links[second].shape, arc, Pose::identity())
            }
        };
        let shapes = [&scene.links[first].shape, shape];
        let point = Shape::Sphere { radius_m: 1e-6 };
        Some(Self {
            view,
            shapes,
            solids: [shapes[0].solid().ok()?, shape.solid().ok()?],
            point: point.solid().ok()?,
            arcs: (view.arc(first, true)?, arc),
            held,
            standing,
        })
    }

    fn states(&self, after_s: f64) -> (State, Option<State>) {
        let second = self.arcs.1.map(|arc| self.view.state(arc, after_s));
        let second = second.or(self.held.as_ref().map(|held| held.state(after_s)));
        (self.view.state(self.arcs.0, after_s), second)
    }

    fn distance_m(&self, after_s: f64) -> f64 {
        let (first, second) = self.states(after_s);
        let there = second.map_or(self.standing, |state| pose(&state));
        let distance = self.solids[0].distance_m(&pose(&first), &self.solids[1], &there);
        distance.unwrap_or(f64::INFINITY)
    }

    /// Beginning of their overlap relative to the event \[s\]; zero where they do not overlap at
    /// it.
    fn first_overlap_s(&self) -> f64 {
        if self.distance_m(0.0) >= 0.0 || self.distance_m(-BACK_S) < 0.0 {
            return 0.0;
        }
        let (mut apart_s, mut inside_s) = (-BACK_S, 0.0);
        for _ in 0..HALVINGS {
            let middle_s = 0.5 * (apart_s + inside_s);
            if self.distance_m(middle_s) < 0.0 {
                inside_s = middle_s;
            } else {
                apart_s = middle_s;
            }
        }
        apart_s
    }

    /// Size of a contact's gap at that time plus the distance of its points from the solids \[m\];
    /// `None` where it recedes from a fixed solid.
    fn nearness_m(&self, contact: &Contact, after_s: f64) -> Option<f64> {
        let (first, second) = self.states(after_s);
        let there = second.map_or_else(Frame::world, |state| Frame::of(&state));
        let touch = contact.touch(&Frame::of(&first), &there).ok()?;
        let still = State {
            velocity_m_s: Vector3::zeros(),
            angular_velocity_rad_s: Vector3::zeros(),
            ..first
        };
        let speed_m_s = approach_m_s(&touch, &first, second.as_ref().unwrap_or(&still));
        // A feature of the static world is in world axes.
        let on_second_m = match second {
            Some(_) => Pose::from(touch.on_b_m),
            None => self.standing.inverse() * Pose::from(touch.on_b_m),
        };
        // Errors of the fits may put a point off its solid.
        let off_m = |which: usize, at: &Pose| {
            let slack_m = SLACK * self.shapes[which].radius_m();
            let distance = self.solids[which].distance_m(&Pose::identity(), &self.point, at);
            distance
                .ok()
                .map(|distance_m| (distance_m - slack_m).max(0.0))
        };
        let beside_m = off_m(0, &Pose::from(touch.on_a_m))? + off_m(1, &on_second_m)?;
        // Excludes the far sides of fixed solids; one of two bodies may recede before the other.
        let meets = second.is_some() || speed_m_s < 0.0;
        meets.then_some(touch.gap_m.abs() + beside_m)
    }
}

/// A held body near an event.
struct HeldSolid<'a> {
    motion: &'a HeldMotion,
    link_from_tracker: Pose,
    /// Acted time of the event \[s\].
    acted_s: f64,
    /// Acted time that passes in a second, in the mean over the flight before the event.
    rate: f64,
}

impl<'a> HeldSolid<'a> {
    fn new(view: &View<'a>, link: LinkIndex) -> Option<Self> {
        let mut tracks = view.scene.tracks.iter_enumerated();
        let (track, of) = tracks.find(|(_, track)| track.link == link)?;
        let before = view.arc(*view.links().first()?, true)?;
        let flight = &view.segments[before];
        let shown = flight.views.first().map(|of| view.sketch.samples_of(of));
        let times_s = &view.guess.arcs[before].sample_times_s;
        let rate = match shown {
            Some(samples @ [first, .., last]) => {
                let lasts_s = times_s[samples.len() - 1] - times_s[0];
                (last.acted_s - first.acted_s) / lasts_s
            }
            _ => 1.0,
        };
        Some(Self {
            motion: view.sketch.tracks[track].held.as_ref()?,
            link_from_tracker: of.link_from_tracker,
            acted_s: view.sketch.marks_s[view.event],
            rate,
        })
    }

    fn state(&self, after_s: f64) -> State {
        let tracker = self.motion.at(self.acted_s + after_s * self.rate);
        let mounted = Mounted::new(&tracker, &self.link_from_tracker);
        mounted.driven.at_rate(self.rate).state
    }
}

fn pose(state: &State) -> Pose {
    Pose::from_parts(state.position_m.into(), state.orientation)
}

/// Rate of the gap [m/s]; negative approaching. For a fixed second solid its point does not matter.
fn approach_m_s(touch: &Touch, first: &State, second: &State) -> f64 {
    let velocity = |state: &State, point_m: &Vector3<f64>| {
        state.velocity_m_s + state.orientation * state.angular_velocity_rad_s.cross(point_m)
    };
    let apart = velocity(first, &touch.on_a_m) - velocity(second, &touch.on_b_m);
    touch.normal.dot(&apart)
}
