//! Whether an estimate that calls itself physical is: gaps and a simulation, apart from the
//! solver.

use enact::math::so3;
use enact::motion::{ArcEstimate, Estimate, GoalTarget, LinkIndex, MechanismIndex, Scene};
use enact::physics::impact::{Law, Side};
use enact::physics::{State, flow};

use crate::perform::encounter::{Encounter, still};
use crate::perform::{Truth, simulate};

/// Gaps up to these are rounding: twice what the program allows itself [m, rad, m/s, rad/s].
const GAP: [f64; 4] = [2e-9, 2e-9, 2e-8, 2e-7];
/// A simulation may differ by this [s, m], and by what a change of the first state by
/// [`NUDGE`] makes of it.
const SIMULATED: f64 = 1e-7;
const NUDGE: f64 = 1e-9;
/// As many events are simulated.
const SIMULATED_EVENTS: usize = 8;
/// A named contact point this deep in its surface is inside \[m\].
const DIP_M: f64 = 1e-6;
/// Slower than this is no approach [m/s].
const NO_SPEED_M_S: f64 = 1e-4;
/// Spacing at which depth is looked at \[s\].
const DIP_STEP_S: f64 = 1e-3;

/// What an independent look finds.
#[derive(Clone, Debug, PartialEq)]
pub enum Finding {
    /// All is as it says.
    Agrees,
    /// Gaps close, but a named contact point is inside its surface at another time than that of
    /// its collision, so that the motion is one through the table.
    Dips,
    /// Gaps close, but a collision touches without speed, so that nothing bounces: its impulse
    /// is none. A simulation cannot see it.
    Grazes,
    /// It is not what it says.
    Disagrees(String),
}

/// Holds an estimate of verdict `physical` against gaps of its arcs and against a simulation.
pub fn check(scene: &Scene, estimate: &Estimate) -> Finding {
    if let Some(what) = gap(scene, estimate) {
        return Finding::Disagrees(what);
    }
    if dips(scene, estimate) {
        return Finding::Dips;
    }
    if grazes(scene, estimate) {
        return Finding::Grazes;
    }
    simulated(scene, estimate).map_or(Finding::Agrees, Finding::Disagrees)
}

/// A mechanism's arcs, in order.
fn arcs(estimate: &Estimate, mechanism: MechanismIndex) -> Vec<&ArcEstimate> {
    let own = estimate
        .arcs
        .iter()
        .filter(|arc| arc.mechanism == mechanism);
    let mut arcs: Vec<&ArcEstimate> = own.collect();
    arcs.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
    arcs
}

fn parameters(estimate: &Estimate) -> Vec<f64> {
    estimate.parameters.iter().map(|p| p.value).collect()
}

fn flown(scene: &Scene, estimate: &Estimate, arc: &ArcEstimate, time_s: f64) -> State {
    let body = scene.body_of(arc.mechanism);
    let gravity = &estimate.gravity_m_s2;
    flow::advance(body, gravity, &arc.state, time_s - arc.epoch_s)
}

/// The first gap that does not close.
fn gap(scene: &Scene, estimate: &Estimate) -> Option<String> {
    let times_s: Vec<f64> = estimate.events.iter().map(|event| event.time_s).collect();
    if !times_s.is_sorted() {
        return Some("events are out of order".into());
    }
    for (event, of) in scene.events.iter().enumerate() {
        if of.kind.collision().is_some()
            && let Some(what) = collision_gap(scene, estimate, event)
        {
            return Some(format!("{}: {what}", of.name));
        }
    }
    scene.goals.iter().find_map(|goal| {
        let mechanism = scene.mechanism_of(goal.link);
        let before = collisions_before(scene, mechanism, goal.event);
        let arc = arcs(estimate, mechanism)[before];
        let state = flown(scene, estimate, arc, times_s[goal.event]);
        let (miss_m, miss_rad) = match &goal.target {
            GoalTarget::Pose { world_from_body } => {
                let shift = state.position_m - world_from_body.translation.vector;
                let turn = world_from_body.rotation.inverse() * state.orientation;
                (shift.norm(), so3::log(&turn).norm())
            }
            GoalTarget::PositionWithin { lower_m, upper_m } => {
                let x = state.position_m;
                ((lower_m - x).sup(&(x - upper_m)).max().max(0.0), 0.0)
            }
            GoalTarget::Condition(condition) => {
                let time_of = |event: usize| times_s.get(event).copied();
                let state_of = |_| Some(state);
                let miss = scene.condition_distance(goal, condition, &time_of, &state_of);
                (miss.unwrap_or(f64::INFINITY), 0.0)
            }
        };
        let met = miss_m <= GAP[0] && miss_rad <= GAP[1];
        (!met).then(|| format!("a goal is missed by {miss_m:.1e} m, {miss_rad:.1e} rad"))
    })
}

/// Collisions of a mechanism before an event.
fn collisions_before(scene: &Scene, mechanism: MechanismIndex, event: usize) -> usize {
    let before = scene.events[..event].iter();
    let collisions = before.filter_map(|event| event.kind.collision());
    collisions
        .filter(|collision| scene.takes_part(mechanism, collision))
        .count()
}

fn collision_gap(scene: &Scene, estimate: &Estimate, event: usize) -> Option<String> {
    let collision = scene.events[event].kind.collision()?;
    let time_s = estimate.events[event].time_s;
    let links: Vec<LinkIndex> = collision.links().collect();
    let at = |link: LinkIndex, later: usize| {
        let mechanism = scene.mechanism_of(link);
        let arc = collisions_before(scene, mechanism, event) + later;
        flown(scene, estimate, arcs(estimate, mechanism)[arc], time_s)
    };
    let a = at(links[0], 0);
    let b = links.get(1).map(|link| at(*link, 0));
    let (gap_m, speed_m_s, after) =
        if let Some(meet) = Encounter::of(scene, &parameters(estimate), event) {
            let b = b.unwrap_or_else(still);
            let (after_a, after_b) = meet.after(&a, &b);
            (
                meet.gap_m(&a, &b),
                meet.speed_m_s(&a, &b),
                [after_a, after_b],
            )
        } else {
            let contacts = scene.contact_set(event).ok().flatten()?;
            let side = |link: LinkIndex, state| Side {
                body: &scene.links[link].body,
                state,
            };
            let a_side = side(links[0], &a);
            let b_side = b.as_ref().map(|state| side(links[1], state));
            let law = Law::frictionless(scene.law_of(collision).restitution);
            let impact = contacts.impact(&a_side, b_side.as_ref(), &law).ok()?;
            let pushed = |state: &State, index: usize| State {
                velocity_m_s: impact.after[index].velocity_m_s,
                angular_velocity_rad_s: impact.after[index].angular_velocity_rad_s,
                ..*state
            };
            let b = b.unwrap_or_else(still);
            let after = [pushed(&a, 0), pushed(&b, 1)];
            (impact.gaps_m[0], impact.speeds_m_s[0], after)
        };
    if !(gap_m.abs() <= GAP[0]) {
        return Some(format!("contact gap {gap_m:.1e} m"));
    }
    if !(speed_m_s <= GAP[2]) {
        return Some(format!("recedes at {speed_m_s:.1e} m/s"));
    }
    links.iter().enumerate().find_map(|(index, link)| {
        let off = at(*link, 1).minus(&after[index]);
        let offs: Vec<f64> = (0..4)
            .map(|part| off.fixed_rows::<3>(3 * part).norm())
            .collect();
        let closes = offs
            .iter()
            .zip(GAP)
            .all(|(off, gap)| *off <= gap * 3f64.sqrt());
        (!closes).then(|| {
            format!(
                "jumps by {:.1e} m, {:.1e} rad, {:.1e} m/s, {:.1e} rad/s",
                offs[0], offs[1], offs[2], offs[3]
            )
        })
    })
}

/// Whether the contact point of a collision is inside the static surface it bounces off, in any
/// flight of its mechanism.
fn dips(scene: &Scene, estimate: &Estimate) -> bool {
    (0..scene.events.len()).any(|event| {
        let Some(meet) = Encounter::of(scene, &parameters(estimate), event) else {
            return false;
        };
        if meet.other.is_some() {
            return false;
        }
        let arcs = arcs(estimate, scene.mechanism_of(meet.link));
        arcs.iter().any(|arc| {
            let steps = ((arc.end_s - arc.start_s) / DIP_STEP_S)
                .clamp(1.0, 1e5)
                .ceil() as usize;
            (0..=steps).any(|step| {
                let share = step as f64 / steps as f64;
                let time_s = arc.start_s + share * (arc.end_s - arc.start_s);
                let state = flown(scene, estimate, arc, time_s);
                meet.gap_m(&state, &still()) < -DIP_M
            })
        })
    })
}

/// Whether a collision happens without speed.
fn grazes(scene: &Scene, estimate: &Estimate) -> bool {
    (0..scene.events.len()).any(|event| {
        let Some(meet) = Encounter::of(scene, &parameters(estimate), event) else {
            return false;
        };
        let arrived = |link: LinkIndex| {
            let mechanism = scene.mechanism_of(link);
            let arc = arcs(estimate, mechanism)[collisions_before(scene, mechanism, event)];
            flown(scene, estimate, arc, estimate.events[event].time_s)
        };
        let b = meet.other.map_or_else(still, arrived);
        meet.speed_m_s(&arrived(meet.link), &b).abs() < NO_SPEED_M_S
    })
}

/// What a simulation from the first states has otherwise; nothing where it cannot tell. Of many
/// collisions only the first are simulated: beyond, rounding has grown too large.
fn simulated(scene: &Scene, estimate: &Estimate) -> Option<String> {
    let sharp = |event: usize| {
        scene.events[event].kind.collision().is_none()
            || Encounter::of(scene, &parameters(estimate), event).is_some()
    };
    if !(0..scene.events.len()).all(sharp) {
        return None;
    }
    let starts_s = estimate.arcs.iter().map(|arc| arc.start_s);
    let start_s = starts_s.fold(f64::INFINITY, f64::min);
    let times_s: Vec<f64> = estimate.events.iter().map(|e| e.time_s - start_s).collect();
    let mut scene = scene.clone();
    scene.goals.clear();
    let duration_s = match times_s.get(SIMULATED_EVENTS..SIMULATED_EVENTS + 1) {
        Some([next_s]) => {
            scene.events.truncate(SIMULATED_EVENTS);
            0.5 * (times_s[SIMULATED_EVENTS - 1] + next_s)
        }
        _ => *times_s.last()?,
    };
    let scene = &scene;
    let mechanisms = scene.mechanisms.keys();
    let initial: Vec<State> = mechanisms
        .map(|mechanism| flown(scene, estimate, arcs(estimate, mechanism)[0], start_s))
        .collect();
    let from = |initial: &[State]| {
        simulate(scene, &parameters(estimate), initial, duration_s).map(|truth| End::of(&truth))
    };
    let own = match from(&initial) {
        Ok(end) => end,
        Err(error) => return Some(format!("simulated: {error}")),
    };
    let mut allowed = SIMULATED;
    for index in 0..initial.len() {
        for axis in 0..12 {
            let mut nudged = initial.clone();
            let mut delta = enact::physics::state::StateTangent::zeros();
            delta[axis] = NUDGE;
            nudged[index] = nudged[index].retract(&delta);
            // Where a nudge ends a collision, a simulation cannot tell.
            allowed += from(&nudged).ok()?.off(&own);
        }
    }
    let estimated = End {
        times_s: times_s[..scene.events.len()].to_vec(),
        states: scene
            .mechanisms
            .keys()
            .map(|mechanism| {
                let flown_by = collisions_before(scene, mechanism, scene.events.len());
                let arc = arcs(estimate, mechanism)[flown_by];
                flown(scene, estimate, arc, start_s + duration_s)
            })
            .collect(),
    };
    let off = estimated.off(&own);
    (!(off <= allowed)).then(|| format!("simulated otherwise by {off:.1e}"))
}

/// Where a motion leads.
struct End {
    times_s: Vec<f64>,
    states: Vec<State>,
}

impl End {
    fn of(truth: &Truth) -> Self {
        let links = truth.scene.links.keys();
        Self {
            times_s: truth.event_times_s.clone(),
            states: links
                .map(|link| truth.state(link, truth.duration_s))
                .collect(),
        }
    }

    /// The largest difference, seconds and metres alike.
    fn off(&self, other: &Self) -> f64 {
        let times = self.times_s.iter().zip(&other.times_s);
        let times = times.map(|(a, b)| (a - b).abs());
        let places = self.states.iter().zip(&other.states);
        let places = places.map(|(a, b)| (a.position_m - b.position_m).norm());
        times.chain(places).fold(0.0, f64::max)
    }
}
