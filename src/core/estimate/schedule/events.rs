//! Initial times of events where bodies rotate fast.
//!
//! A mark is right to a sample or two. Where a body turns by half a radian or more from one sample
//! to the next, that is a radian or two between the mark and the event, and the sweep would rotate
//! the states instead of moving the event: it would leave the performer's motion for another one.
//! The arcs' own fits determine better when they meet. Measured on a brick that flips four and
//! eight times before its bounce (`tools/results`, 24 performances each): from the marks 92 and 54 %
//! ended at the best known optimum, after 33 and 140 iterations in the mean; from the times found
//! here all do, after 12 and 14 (two of the eight-flip ones only since their arcs are fitted
//! right).
//!
//! Slow bodies keep their marks. At eight times the usual distortion, where the fits themselves
//! meet late or early, searching the times of all events lost one in ten (a cube's six bounces) and
//! one in twelve (a pencil) of the optima found from marks.

use std::f64::consts::PI;

use crate::estimate::constraint::At;
use crate::estimate::problem::{ArcSample, Problem};
use crate::estimate::terms::context::SolveContext;
use crate::estimate::unknowns::point::Point;
use crate::optimise::block::Block;

/// Least angle that a fast body turns between samples \[rad\].
const FAST_RAD: f64 = 0.5;
/// Reach of the search on either side of a mark, in samples.
const REACH_SAMPLES: f64 = 2.0;
/// Greatest angle that a body turns between two times that are tried \[rad\].
const STEP_RAD: f64 = 0.25;

/// Moves the times of events at which bodies turn fast to where the unchanged arcs of `point`
/// violate the event's contacts, continuity of poses and goals the least.
pub fn align(context: &SolveContext, point: &mut Point) {
    for event in 0..context.problem.event_is_free.len() {
        let (interval_s, turned_rad) = between_samples(context.problem, point, event);
        if context.problem.event_is_free[event] && turned_rad >= FAST_RAD {
            let reach_s = REACH_SAMPLES * interval_s;
            let steps = (REACH_SAMPLES * turned_rad / STEP_RAD).ceil();
            point.event_times_s[event] = nearest_s(context, point, event, reach_s, steps as i32);
            context.problem.hold(point, Some(event));
        }
    }
}

/// Longest sampling interval of the arcs at an event \[s\], and the largest angle that one turns in
/// it \[rad\], at most π: larger angles look like smaller ones.
fn between_samples(problem: &Problem, point: &Point, event: usize) -> (f64, f64) {
    let arcs = problem.arcs.iter().zip(&point.arcs);
    let beside = arcs.filter(|(arc, _)| arc.start == Some(event) || arc.end == Some(event));
    beside.fold(
        (0.0, 0.0),
        |(longest_s, most_rad): (f64, f64), (arc, state)| {
            let times_s =
                |sample: &ArcSample| sample.stamped_s(&point.node_times_s, &point.parameters);
            // Of the track that sees orientations most often.
            let views = arc.views.iter().filter(|view| view.kinds()[1]);
            let interval_s = views.filter_map(|view| match view.samples.as_slice() {
                [first, .., last] => {
                    Some((times_s(last) - times_s(first)) / (view.samples.len() - 1) as f64)
                }
                _ => None,
            });
            let interval_s = interval_s.reduce(f64::min).unwrap_or(0.0);
            let turned_rad = (state.angular_velocity_rad_s.norm() * interval_s).min(PI);
            (longest_s.max(interval_s), most_rad.max(turned_rad))
        },
    )
}

/// The best of a grid of times about an event's, refined to the minimum of the parabola through it
/// and its neighbours \[s\].
fn nearest_s(context: &SolveContext, point: &Point, event: usize, reach_s: f64, steps: i32) -> f64 {
    let mut point = point.clone();
    let around_s = point.event_times_s[event];
    let step_s = reach_s / f64::from(steps);
    let mut misses = |time_s: f64| {
        point.event_times_s[event] = time_s;
        context.problem.hold(&mut point, Some(event));
        miss(context, &point, event)
    };
    let times_s = (-steps..=steps).map(|step| around_s + f64::from(step) * step_s);
    let tried = times_s.map(|time_s| (misses(time_s), time_s));
    let best = tried.min_by(|a, b| a.0.total_cmp(&b.0));
    let (least, best_s) = best.expect("the mark at least");
    let [before, after] = [-step_s, step_s].map(|past_s| misses(best_s + past_s));
    let bend = before + after - 2.0 * least;
    if bend > 0.0 && bend.is_finite() {
        best_s + (0.5 * step_s * (before - after) / bend).clamp(-step_s, step_s)
    } else {
        best_s
    }
}

/// Sum of squared violations of an event's contacts, poses and goals, in units.
fn miss(context: &SolveContext, point: &Point, event: usize) -> f64 {
    let (problem, structure) = (context.problem, &context.layout.structure);
    let mut at = At::new(problem, point, &context.epochs_s);
    let (mut rows, mut priced) = (Block::default(), Block::default());
    let mut sum = 0.0;
    let patterns = structure.blocks.iter().zip(&structure.priced);
    for (constraint, patterns) in problem.constraints().zip(patterns) {
        if constraint.event() == Some(event) {
            constraint.fill(
                &mut at,
                [(patterns.0, &mut rows), (patterns.1, &mut priced)],
            );
            let places = constraint.places(&rows).into_iter().flatten();
            sum += square_of(&rows, places);
        }
    }
    if sum.is_nan() { f64::INFINITY } else { sum }
}

fn square_of(block: &Block, rows: impl Iterator<Item = usize>) -> f64 {
    rows.map(|row| block.violation(row).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};

    use super::*;
    use crate::estimate::schedule::recipe::epochs_s;
    use crate::estimate::tests::{EPOCHS_S, scene, sketch};
    use crate::estimate::unknowns::layout::Layout;
    use crate::motion::{LinkIndex, Timing};
    use crate::physics::{State, flow};

    const EVENT_S: f64 = 0.22;

    /// A rod that touches at [`EVENT_S`] and bounces off, turning that fast [rad/s]; where its
    /// bounce is said to begin from a time [s].
    fn begun_s(speed_rad_s: f64, from_s: f64) -> f64 {
        let mut scene = scene(Timing::Known);
        scene.goals.clear();
        scene.parameters.clear();
        let (sketch, segments, mut guess) = sketch(&scene, 0.0);
        let orientation = UnitQuaternion::from_euler_angles(0.3, -0.2, 0.5);
        let tip_m = Vector3::new(0.0, 0.01, -0.1);
        let spins = [Vector3::new(0.7, -0.5, 0.5), Vector3::new(-0.2, 0.9, 0.4)];
        let velocities_m_s = [Vector3::new(0.5, -0.2, -1.0), Vector3::new(0.6, -0.1, 0.8)];
        for (arc, of) in guess.arcs.iter_mut().enumerate() {
            let touching = State {
                position_m: -(orientation * tip_m),
                orientation,
                velocity_m_s: velocities_m_s[arc],
                angular_velocity_rad_s: spins[arc].normalize() * speed_rad_s,
            };
            let (body, gravity) = (&scene.links[LinkIndex(0)].body, &scene.gravity_m_s2);
            of.state = flow::advance(body, gravity, &touching, EPOCHS_S[arc] - EVENT_S);
        }
        guess.event_times_s[0] = from_s;
        let problem = Problem::new(&scene, &sketch, &segments);
        let layout = Layout::new(&problem);
        let mut point = Point::new(&problem, &guess);
        let context = SolveContext::new(&problem, &layout, epochs_s(&guess), &point);
        align(&context, &mut point);
        point.event_times_s[0]
    }

    #[test]
    fn a_fast_body_bounces_where_its_fits_meet() {
        // Samples are 20 ms apart: two thirds of a turn from one to the next.
        for speed_rad_s in [40.0, 100.0, 200.0] {
            for off_s in [-0.03, 0.011, 0.03] {
                let error_s = begun_s(speed_rad_s, EVENT_S + off_s) - EVENT_S;
                let turned_rad = speed_rad_s * error_s.abs();
                assert!(turned_rad < 0.02, "{speed_rad_s} {off_s}: {turned_rad} rad");
            }
        }
    }

    #[test]
    fn a_slow_body_keeps_its_mark() {
        assert_eq!(begun_s(20.0, EVENT_S + 0.011), EVENT_S + 0.011);
    }
}
