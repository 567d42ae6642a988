//! The motion of all once more from its first state alone, with steps of half the length: through impacts by their
//! law, at the times that were estimated.

use super::larger;
use crate::motion::{Deviation, Estimate, LinkIndex, Pull, Scene, TreeTouch};
use crate::physics::State;
use crate::physics::state::part;
use crate::physics::tree::{ForestFlow, ForestSnapshot, TreeState, tableau};
use crate::verify::pull;

/// How far off the motion is, at most.
#[derive(Clone, Debug, Default)]
pub(super) struct Off {
    /// A link's centre, at any state of the estimate, from where this one has it \[m\].
    pub(super) position_m: f64,
    /// The contact of an impact from touching \[m\].
    pub(super) gap_m: f64,
    /// How fast the contact of an impact recedes before it [m/s].
    pub(super) receding_m_s: f64,
    /// Of each link at the end.
    pub(super) ends: Vec<Deviation>,
    /// Contacts that pull.
    pub(super) pulls: Vec<Pull>,
    /// What an impact gains of the kinetic energy of what takes part beyond what it is given, of that before.
    pub(super) energy: f64,
}

/// Distances of the estimate from the motion done again, in its scene as estimated. What is not finite, or not there, is infinitely far.
pub(super) fn off(scene: &Scene, estimate: &Estimate) -> Off {
    let mut off = Off::default();
    // All trees have their states at the same times, two at that of an impact.
    let motion = estimate.trees.first();
    let Some((motion, [first, rest @ ..])) = motion.map(|of| (of, of.knots.as_slice())) else {
        return off;
    };
    let (forest, gravity_m_s2) = (scene.forest_with(&estimate.held), &estimate.gravity_m_s2);
    let told = |time_s: f64| scene.forest_state(estimate, &forest, time_s);
    let Some(start) = told(first.time_s) else {
        off.position_m = f64::INFINITY;
        return off;
    };
    let mut flow = ForestFlow::new(&forest, gravity_m_s2, tableau::DORMAND_PRINCE);
    flow.begin(&start, false);
    let mut snapshot = ForestSnapshot::new(&forest, gravity_m_s2);
    let mut touches = touches(scene, estimate).into_iter().peekable();
    let mut now_s = first.time_s;
    for knot in rest {
        if let Some((_, event, touch)) = touches.next_if(|(time_s, ..)| {
            // The second state at the time of an impact is that after it.
            *time_s == now_s && knot.time_s == now_s
        }) {
            let state = flow.state();
            snapshot.set(&state);
            let Ok(impact) = snapshot.impact(&state, &touch.at, &touch.law) else {
                off.gap_m = f64::INFINITY;
                return off;
            };
            let after = TreeState {
                rates: impact.rates,
                ..state
            };
            let before_j = snapshot.kinetic_energy_at(&touch.at);
            snapshot.set(&after);
            let pushed = impact.normal_impulses_n_s.iter().zip(&impact.speeds_m_s);
            // What a bumper gives along the normal; friction takes of it.
            let collision = scene.events[event].kind.collision();
            let is_bumper = collision.is_some_and(|of| scene.law_of(of).is_bumper);
            let more = match is_bumper {
                true => (touch.law.restitution - 1.0).max(0.0),
                false => 0.0,
            };
            let given_j: f64 = pushed.map(|(n_s, m_s)| -0.5 * more * n_s * m_s).sum();
            let gained_j = snapshot.kinetic_energy_at(&touch.at) - before_j - given_j;
            for (gap_m, speed_m_s) in impact.gaps_m.iter().zip(&impact.speeds_m_s) {
                off.gap_m = larger(off.gap_m, gap_m.abs());
                off.receding_m_s = larger(off.receding_m_s, *speed_m_s);
            }
            off.pulls
                .extend(pull::of(event, &impact.normal_impulses_n_s));
            // A hand does work on what hangs from it while that hits something.
            let mut trees = touch.at.places().map(|place| forest.tree_of(place).0);
            if !trees.any(|tree| forest.trees()[tree].is_in_hand()) {
                off.energy = larger(off.energy, gained_j / before_j);
            }
            flow.begin(&after, false);
        }
        let interval_s = knot.time_s - now_s;
        if interval_s != 0.0 {
            let steps = (interval_s / motion.step_s).ceil().max(1.0) as usize;
            flow.advance(interval_s, 2 * steps);
        }
        now_s = knot.time_s;
        let states = |snapshot: &ForestSnapshot| -> Vec<State> {
            (0..forest.link_count())
                .map(|of| snapshot.link_state(of))
                .collect()
        };
        let Some(here) = told(knot.time_s) else {
            off.position_m = f64::INFINITY;
            return off;
        };
        snapshot.set(&here);
        let here = states(&snapshot);
        snapshot.set(&flow.state());
        let again = states(&snapshot);
        let both = scene.forest_links().zip(again.iter().zip(&here));
        let ends = both.map(|(link, (again, here))| deviation(link, again, here));
        off.ends = ends.collect();
        for end in &off.ends {
            off.position_m = larger(off.position_m, end.position_m);
        }
    }
    if touches.peek().is_some() {
        // An impact that the states of the estimate do not have.
        off.gap_m = f64::INFINITY;
    }
    off
}

/// How far a link ends from where it was told to \[m, rad, m/s, rad/s\].
fn deviation(link: LinkIndex, again: &State, told: &State) -> Deviation {
    let off = again.minus(told);
    let norm = |part: usize| off.fixed_rows::<3>(part).norm();
    Deviation {
        link,
        event: None,
        time_s: 0.0,
        position_m: norm(part::POSITION),
        orientation_rad: norm(part::ORIENTATION),
        velocity_m_s: norm(part::VELOCITY),
        angular_velocity_rad_s: norm(part::ANGULAR_VELOCITY),
    }
}

/// Impacts by their times, in order, with their events.
fn touches(scene: &Scene, estimate: &Estimate) -> Vec<(f64, usize, TreeTouch)> {
    let events = estimate.events.iter();
    let touches = events.filter_map(|of| Some((of.time_s, of.event, scene.tree_touch(of.event)?)));
    let mut touches: Vec<_> = touches.collect();
    touches.sort_by(|a, b| a.0.total_cmp(&b.0));
    touches
}
