//! Kinds of sketches of one motion, each with full poses of it that have as many residuals.

use anyhow::{Context, Result};
use enact::estimate::problem::Problem;
use enact::motion::{
    BodyPoint, Condition, Goal, GoalQuantity, GoalSet, GoalTarget, LinkIndex, Moment, OpenTime,
    Scene, TakeEvent,
};
use enact_tools::case::{Case, Posed, estimated};
use enact_tools::parts::Part;
use enact_tools::perform::{Acting, Keyframed, Keyframing, Style, Truth};

use crate::options::Options;

const SEED: u64 = 1;
/// Full poses with a goal at a moment of a flight.
const WAYPOINT: &str = "pose, and a waypoint";
/// Keyframes of a flight.
const KEYFRAMES: usize = 8;

/// A sketch of a kind and one of full poses.
pub struct Sketched {
    pub kind: &'static str,
    pub timing: &'static str,
    pub own: Posed,
    pub full: Posed,
}

/// All kinds that are asked for; of a quick run those that are solved at once.
pub fn sketches(options: &Options) -> Result<Vec<Sketched>> {
    let mut all = Vec::new();
    let ways = [
        ("known", Acting::timing_known()),
        ("unknown", Acting::default()),
    ];
    let truth = Style::Tip.truth();
    for (timing, acting) in ways {
        let is_asked = |part: &Part| {
            let is_slow = options.quick && part.is_slow();
            *part != Part::Pose && !is_slow && options.wants(part.as_str())
        };
        for part in Part::ALL.into_iter().filter(is_asked) {
            let case = Case::new(&truth, &acting, SEED);
            let (scene, events) = part.seen(&case);
            let own = posed(&scene, &events).context(part.as_str())?;
            all.push(Sketched {
                kind: part.as_str(),
                timing,
                full: full(&truth, &acting, residuals(&own.problem))?,
                own,
            });
        }
        if !options.wants(WAYPOINT) {
            continue;
        }
        let own = waypoint(&truth, &acting)?;
        all.push(Sketched {
            kind: WAYPOINT,
            timing,
            full: full(&truth, &acting, residuals(&own.problem))?,
            own,
        });
    }
    let truth = Keyframed::Pencil(Style::Tip).truth(SEED)?;
    for (kind, is_open) in [
        ("keyframes", false),
        ("keyframes, one in two at open times", true),
    ] {
        if !options.wants(kind) {
            continue;
        }
        let mut events = Keyframing::exact(KEYFRAMES).of(&truth, SEED);
        if is_open {
            open_times(&mut events);
        }
        let own = posed(&truth.scene, &events).context(kind)?;
        all.push(Sketched {
            kind,
            timing: "known",
            full: full(&truth, &Acting::timing_known(), residuals(&own.problem))?,
            own,
        });
    }
    Ok(all)
}

/// Number of residuals of samples.
pub fn residuals(problem: &Problem) -> usize {
    let of = problem.views().map(|(_, view)| {
        let seen = view.kinds().into_iter().filter(|is_seen| *is_seen);
        3 * seen.count() * view.samples.len()
    });
    of.sum()
}

/// The problem that the program solves.
fn posed(scene: &Scene, events: &[TakeEvent]) -> Result<Posed> {
    let outcome = estimated(scene, events, &mut ())?;
    Ok(Posed::new(&outcome.given, &outcome.sketch))
}

/// Full poses with about so many residuals.
fn full(truth: &Truth, acting: &Acting, wanted: usize) -> Result<Posed> {
    let at = |rate_hz: f64| {
        let acting = Acting {
            rate_hz,
            stamp_jitter_s: acting.stamp_jitter_s.min(0.05 / rate_hz),
            ..*acting
        };
        let case = Case::new(truth, &acting, SEED);
        posed(case.scene(), &case.performance.events)
    };
    let mut rate_hz = acting.rate_hz;
    let mut found = at(rate_hz)?;
    for _ in 0..3 {
        let share = wanted as f64 / residuals(&found.problem) as f64;
        rate_hz *= share;
        found = at(rate_hz)?;
    }
    Ok(found)
}

/// The performance with a waypoint in the middle of the last flight, at which the centre of mass is where
/// it truly is.
fn waypoint(truth: &Truth, acting: &Acting) -> Result<Posed> {
    let link = LinkIndex(0);
    let last = truth.arcs.last().context("no flight")?;
    let time_s = 0.5 * (last.start_s + last.end_s);
    let (truth, event) = truth.clone().with_waypoint("by", link, time_s);
    let acting = Acting {
        marks_named: true,
        ..*acting
    };
    let mut case = Case::new(&truth, &acting, SEED);
    case.performance.truth.scene.goals.push(Goal {
        event,
        link,
        target: GoalTarget::Condition(Condition {
            quantity: GoalQuantity::Position {
                point: BodyPoint::Centre,
                seen_from: None,
            },
            set: GoalSet::point(truth.state(link, time_s).position_m),
            moment: Moment::Before,
            sd: None,
        }),
    });
    posed(case.scene(), &case.performance.events)
}

/// Forgets the times of every other keyframe that has one on both sides in its flight.
fn open_times(events: &mut [TakeEvent]) {
    let mut number = 0;
    for event in events {
        if let TakeEvent::Pose { sample, .. } = event {
            let place = number % KEYFRAMES;
            if place % 2 == 1 && place + 1 < KEYFRAMES {
                sample.open = Some(OpenTime {
                    before_ns: None,
                    after_ns: None,
                });
            }
            number += 1;
        }
    }
}
