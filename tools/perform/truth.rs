//! True motions: one body in free flight between bounces, to rounding.

use enact::math::Pose;
use enact::motion::{ArcEstimate, EventKind, GoalTarget, Scene};
use enact::physics::{Body, State, contact, flow, impact};
use nalgebra::Vector3;
use thiserror::Error;

/// Contacts are looked for at this spacing [s]: no feature of an object one throws dips under a
/// surface and comes out again within it, except to graze.
const SCAN_S: f64 = 2.5e-4;

/// A motion that obeys physics exactly.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// What it happens in.
    pub scene: Scene,
    /// Body by body, in order of time; physical time is zero at the start of the motion.
    pub arcs: Vec<ArcEstimate>,
    /// Physical time of each of the scene's events [s].
    pub event_times_s: Vec<f64>,
    /// Physical time of the end [s].
    pub duration_s: f64,
}

/// Why there is no such motion.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum TruthError {
    /// Only scenes with one body can be simulated.
    #[error("the scene has {count} bodies, expected one")]
    Bodies {
        /// As given.
        count: usize,
    },
    /// A collision does not happen.
    #[error("event {event}: no contact between {from_s} and {to_s} s")]
    NoContact {
        /// Index into the scene's events.
        event: usize,
        /// Start of the arc [s].
        from_s: f64,
        /// Where the search ended [s].
        to_s: f64,
    },
    /// The scene is not what the style needs.
    #[error("the scene lacks {what}")]
    Lacks {
        /// What it should have.
        what: &'static str,
    },
    /// A random search found no motion.
    #[error("no motion with {count} bounces found in {tries} tries")]
    NotFound {
        /// Bounces asked for.
        count: usize,
        /// Arcs looked at.
        tries: usize,
    },
}

impl Truth {
    /// State of a body at a physical time; at the instant of a bounce, the state after it.
    ///
    /// # Panics
    /// If the body has no arc: a truth has arcs for every body of its scene.
    pub fn state(&self, body: usize, time_s: f64) -> State {
        let mut arcs = self.arcs.iter().filter(|arc| arc.body == body);
        let first = arcs.next().expect("a truth has arcs for every body");
        let arc = arcs
            .take_while(|arc| arc.start_s <= time_s)
            .last()
            .unwrap_or(first);
        flow::advance(
            &self.scene.bodies[body].body,
            &self.scene.gravity_m_s2,
            &arc.state,
            time_s - arc.epoch_s,
        )
    }

    /// Where a body is at a physical time.
    pub fn world_from_body(&self, body: usize, time_s: f64) -> Pose {
        self.state(body, time_s).world_from_body()
    }

    /// The largest miss of a pose goal, metres and radians alike.
    pub fn goal_miss(&self) -> f64 {
        let miss = |goal: &enact::motion::Goal| match &goal.target {
            GoalTarget::Pose { world_from_body } => {
                let pose = self.world_from_body(goal.body, self.event_times_s[goal.event]);
                let turn = world_from_body.rotation.inverse() * pose.rotation;
                let shift = pose.translation.vector - world_from_body.translation.vector;
                shift.norm().max(enact::math::so3::log(&turn).norm())
            }
            GoalTarget::PositionWithin { lower_m, upper_m } => {
                let x = self
                    .state(goal.body, self.event_times_s[goal.event])
                    .position_m;
                (lower_m - x).sup(&(x - upper_m)).max().max(0.0)
            }
        };
        self.scene.goals.iter().map(miss).fold(0.0, f64::max)
    }
}

/// Simulates a scene of one body through all its collisions, up to `duration_s`.
pub fn simulate(scene: &Scene, initial: &State, duration_s: f64) -> Result<Truth, TruthError> {
    let [moving] = scene.bodies.as_slice() else {
        return Err(TruthError::Bodies {
            count: scene.bodies.len(),
        });
    };
    let flight = Flight {
        body: &moving.body,
        gravity_m_s2: &scene.gravity_m_s2,
    };
    let mut truth = Truth {
        scene: scene.clone(),
        arcs: Vec::new(),
        event_times_s: Vec::new(),
        duration_s,
    };
    let (mut start_s, mut state) = (0.0, *initial);
    for (event, kind) in scene.events.iter().map(|event| &event.kind).enumerate() {
        let time_s = match kind {
            EventKind::Start => 0.0,
            EventKind::End => duration_s,
            EventKind::Collisions { .. } => return Err(TruthError::Lacks { what: "a number" }),
            EventKind::Collision(collision) => {
                let contact =
                    contact_of(scene, kind).ok_or(TruthError::Lacks { what: "a contact" })?;
                let flown_s = flight
                    .until_contact_s(&state, &contact, duration_s - start_s)
                    .ok_or(TruthError::NoContact {
                        event,
                        from_s: start_s,
                        to_s: duration_s,
                    })?;
                let end_s = start_s + flown_s;
                truth.arcs.push(ArcEstimate {
                    body: 0,
                    epoch_s: start_s,
                    state,
                    start_s,
                    end_s,
                });
                // From the time as it is recorded, so that the record is what was simulated.
                let before = flight.advance(&state, end_s - start_s);
                let normal = contact.surface_normal;
                state = impact::bounce(
                    &moving.body,
                    &contact,
                    &normal,
                    collision.restitution,
                    &before,
                );
                start_s = end_s;
                end_s
            }
        };
        truth.event_times_s.push(time_s);
    }
    truth.arcs.push(ArcEstimate {
        body: 0,
        epoch_s: start_s,
        state,
        start_s,
        end_s: duration_s,
    });
    Ok(truth)
}

/// The contact of a collision; none for other events.
pub fn contact_of(scene: &Scene, kind: &EventKind) -> Option<impact::Contact> {
    let collision = kind.collision()?;
    let [touching] = collision.contacts[..] else {
        return None;
    };
    let feature = scene.bodies[collision.body].features[touching.feature?].geometry;
    let surface = scene.surfaces[touching.other?].geometry;
    match (feature, surface) {
        (
            contact::Feature::Point { point_m, .. },
            contact::Feature::Face {
                point_m: surface_point_m,
                normal,
            },
        ) => Some(impact::Contact {
            point_m,
            surface_point_m,
            surface_normal: normal,
        }),
        _ => None,
    }
}

/// Free flight of one body.
#[derive(Clone, Copy)]
pub struct Flight<'a> {
    /// What flies.
    pub body: &'a Body,
    /// Gravity [m/s²].
    pub gravity_m_s2: &'a Vector3<f64>,
}

impl Flight<'_> {
    /// The state `duration_s` later, or earlier.
    pub fn advance(&self, state: &State, duration_s: f64) -> State {
        flow::advance(self.body, self.gravity_m_s2, state, duration_s)
    }

    /// Time until a contact point next goes through its surface, inward, to rounding.
    pub fn until_contact_s(
        &self,
        state: &State,
        contact: &impact::Contact,
        limit_s: f64,
    ) -> Option<f64> {
        crossing_s(SCAN_S, limit_s, |time_s| {
            contact.gap_m(&self.advance(state, time_s))
        })
    }

    /// How long ago a contact point last left its surface, to rounding.
    pub fn since_contact_s(
        &self,
        state: &State,
        contact: &impact::Contact,
        limit_s: f64,
    ) -> Option<f64> {
        crossing_s(SCAN_S, limit_s, |time_s| {
            contact.gap_m(&self.advance(state, -time_s))
        })
    }
}

/// First time at which a gap goes from positive to not positive, by scan and bisection.
pub(super) fn crossing_s(scan_s: f64, limit_s: f64, gap_m: impl Fn(f64) -> f64) -> Option<f64> {
    let steps = (limit_s / scan_s).ceil() as usize;
    let (mut low_s, mut outside) = (0.0, false);
    for step in 1..=steps {
        let time_s = (step as f64 * scan_s).min(limit_s);
        let is_outside = gap_m(time_s) > 0.0;
        if outside && !is_outside {
            return Some(bisect(low_s, time_s, &gap_m));
        }
        (low_s, outside) = (time_s, is_outside);
    }
    None
}

/// Root of a gap that is positive at `low_s` and not at `high_s`: the neighbour with the smaller
/// gap of the last two floating-point numbers.
fn bisect(mut low_s: f64, mut high_s: f64, gap_m: &impl Fn(f64) -> f64) -> f64 {
    loop {
        let middle_s = 0.5 * (low_s + high_s);
        if middle_s <= low_s || middle_s >= high_s {
            let nearer = gap_m(low_s).abs() < gap_m(high_s).abs();
            return if nearer { low_s } else { high_s };
        }
        if gap_m(middle_s) > 0.0 {
            low_s = middle_s;
        } else {
            high_s = middle_s;
        }
    }
}
