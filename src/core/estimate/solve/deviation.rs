//! Standard deviations of an estimate, and quantities that the performance does not determine.

use crate::estimate::covariance::bins::Residuals;
use crate::estimate::covariance::timing;
use crate::estimate::covariance::{Covariance, Moment};
use crate::estimate::schedule::recipe::Solution;
use crate::estimate::terms::context::SolveContext;
use crate::motion::{AtBound, Estimate, MotionPart, Scene, Undetermined};

/// Sets the standard deviations of events, duration and parameters of an estimate, `None` for fixed
/// or undetermined ones, and lists what is undetermined. Where the matrix cannot be factorised,
/// nothing is determined. `errors` are the residuals of the solution's samples.
pub fn fill(
    estimate: &mut Estimate,
    scene: &Scene,
    context: &SolveContext,
    solution: &Solution,
    found: Option<&[Residuals]>,
) {
    let covariance = found.and_then(|errors| {
        Covariance::new(
            context,
            &solution.point,
            &solution.system,
            &solution.multipliers,
            errors,
        )
    });
    let sds = |moments: &[Moment]| match &covariance {
        Some(covariance) => covariance.sds(moments),
        None => vec![None; moments.len()],
    };
    let events =
        (0..scene.events.len()).map(|event| timing::event_moment(context, &solution.point, event));
    let parameters = context.layout.parameters.iter().map(|at| vec![(*at, 1.0)]);
    let lasting = timing::duration(context, &solution.point).moment;
    let moments: Vec<Moment> = events.chain(parameters).chain([lasting]).collect();
    let mut each = moments.iter().zip(sds(&moments));
    // At a bound the deviation covers what the performance asks for beyond it.
    let covering = |sd: Option<f64>, moment: &Moment, at_bound: Option<AtBound>| {
        let covariance = covariance.as_ref().filter(|_| at_bound.is_some());
        let beyond = covariance.map_or(0.0, |covariance| covariance.beyond_bounds(moment));
        sd.map(|sd| sd.hypot(beyond))
    };
    let mut undetermined_times = Vec::new();
    for (event, (moment, sd_s)) in estimate.events.iter_mut().zip(&mut each) {
        if event.is_fixed {
            continue;
        }
        event.sd_s = covering(sd_s, moment, event.at_bound);
        if !moment.is_empty() && sd_s.is_none() {
            undetermined_times.push(Undetermined::EventTime(event.event));
        }
    }
    let parameters = estimate.parameters.iter_mut().enumerate();
    for ((index, parameter), (moment, sd)) in parameters.zip(&mut each) {
        parameter.sd = covering(sd, moment, parameter.at_bound);
        if sd.is_none() {
            estimate.undetermined.push(Undetermined::Parameter(index));
        }
    }
    estimate.undetermined.extend(undetermined_times);
    if context.problem.keeps_starts || !context.problem.regulariser.is_empty() {
        let open = undetermined_motion(context, sds);
        estimate.undetermined.extend(open);
    }
    let (lasting, own_s) = each.next().expect("the last moment is the duration's");
    // A fixed time line has no deviation.
    let own_s = if lasting.is_empty() { Some(0.0) } else { own_s };
    let contradiction_s = covariance.as_ref().map_or(0.0, |covariance| {
        timing::contradiction_s(context, &solution.system, covariance)
    });
    estimate.duration.sd_s = own_s.map(|own_s| own_s.hypot(contradiction_s));
    if !estimate.duration.is_determined() {
        estimate.undetermined.push(Undetermined::Duration);
    }
}

/// Parts of mechanisms' states that the performance does not determine, in whichever flight. What no
/// track sees at all of a flight is open, even where impacts and goals seem to tell it: they may tell
/// another motion as well.
fn undetermined_motion(
    context: &SolveContext,
    sds: impl Fn(&[Moment]) -> Vec<Option<f64>>,
) -> Vec<Undetermined> {
    let mut undetermined = Vec::new();
    for (index, arc) in context.problem.arcs.iter().enumerate() {
        let state = context.layout.state(index);
        let moments: Vec<Moment> = state.map(|at| vec![(at, 1.0)]).collect();
        for (of_part, part) in sds(&moments).chunks(3).zip(MotionPart::ALL) {
            let mechanism = arc.mechanism;
            let open = Undetermined::Motion { mechanism, part };
            let is_blind = arc.sample_count() > 0 && !arc.shows(part.kind());
            let is_open = is_blind || of_part.iter().any(Option::is_none);
            if is_open && !undetermined.contains(&open) {
                undetermined.push(open);
            }
        }
    }
    undetermined
}
