//! Times of the events of joined bodies: windows, given times, goals of times, and collisions that are counted.

use enact::motion::{
    AtBound, Condition, Estimate, EventKind, Goal, GoalQuantity, GoalSet, GoalTarget, LinkIndex,
    Mark, Moment, TakeEvent, Verdict,
};
use enact::pipeline::Pipeline;
use enact_tools::tree_impacts::{Acted, Form, Strike, Struck, strike};
use enact_tools::trees::Jointed;
use nalgebra::Vector3;

const fn struck(links: usize, hangs_m: Option<f64>, impacts: usize) -> Struck {
    Struck {
        form: Form::Rod,
        links,
        joints: Jointed::Pin,
        hangs_m,
        impacts,
        law: [0.5, 0.2],
    }
}

/// A pendulum above the table, and a flail that hits twice.
const PENDULUM: Struck = struck(2, Some(0.35), 1);
const FLAIL: Struck = struck(2, None, 2);

/// The collisions of a scene (indices into its events).
fn hits(strike: &Strike) -> Vec<usize> {
    let events = strike.scene.events.iter().enumerate();
    let hits = events.filter(|(_, event)| event.kind.collision().is_some());
    hits.map(|(index, _)| index).collect()
}

fn found(strike: &Strike) -> Estimate {
    let estimate = strike.finished().estimate;
    assert!(
        estimate.verdict != Verdict::Failed,
        "{:?}",
        estimate.reason.end
    );
    estimate
}

/// A window that the true time is not in holds the event at its nearer end, and it says so; one that it is in changes
/// nothing; a given time is that of the mark.
#[test]
fn events_keep_to_their_windows() {
    let acted = Acted {
        mark_sd_s: 0.0,
        ..Acted::of(0.25)
    };
    let mut strike = strike(&PENDULUM, &acted, 8400);
    let hit = hits(&strike)[0];
    let free = found(&strike).events[hit].clone();
    let mark_s = strike.impacts_s[0];
    assert_eq!(free.at_bound, None);
    strike.scene.events[hit].time.window_s = [-0.2, 0.2];
    let within = found(&strike).events[hit].clone();
    assert!((within.time_s - free.time_s).abs() < 1e-9);
    assert_eq!(within.at_bound, None);
    for (window_s, bound, at_s) in [
        ([0.01, 0.03], AtBound::Lower, 0.01),
        ([-0.03, -0.01], AtBound::Upper, -0.01),
    ] {
        strike.scene.events[hit].time.window_s = window_s;
        let held = found(&strike).events[hit].clone();
        assert!((held.time_s - mark_s - at_s).abs() < 1e-8, "{held:?}");
        assert_eq!(held.at_bound, Some(bound));
    }
    strike.scene.events[hit].time.window_s = [f64::NEG_INFINITY, f64::INFINITY];
    strike.scene.events[hit].time.is_free = Some(false);
    let given = found(&strike).events[hit].clone();
    assert!(given.is_fixed && (given.time_s - mark_s).abs() < 1e-8);
}

fn timed(event: usize, since: Option<usize>, time_s: f64, sd: Option<f64>) -> Goal {
    Goal {
        event,
        link: LinkIndex(0),
        target: GoalTarget::Condition(Condition {
            quantity: GoalQuantity::Time { since },
            set: GoalSet::Box {
                lower: Vector3::new(time_s, f64::NEG_INFINITY, f64::NEG_INFINITY),
                upper: Vector3::new(time_s, f64::INFINITY, f64::INFINITY),
            },
            moment: Moment::Before,
            sd,
        }),
    }
}

/// A hard goal of an interval between two impacts is met exactly, one with a weight draws them towards it.
#[test]
fn intervals_between_impacts_are_goals() {
    let mut strike = strike(&FLAIL, &Acted::of(0.25), 8410);
    let [first, second] = hits(&strike)[..] else {
        panic!("two impacts");
    };
    let interval_s = |of: &Estimate| of.events[second].time_s - of.events[first].time_s;
    let free_s = interval_s(&found(&strike));
    let asked_s = free_s + 0.02;
    strike
        .scene
        .goals
        .push(timed(second, Some(first), asked_s, None));
    let met = found(&strike);
    assert!(
        (interval_s(&met) - asked_s).abs() < 1e-9,
        "{}",
        interval_s(&met)
    );
    assert!(
        strike
            .scene
            .goals_attained(&met)
            .iter()
            .all(|goal| goal.is_met())
    );
    strike.scene.goals.pop();
    strike
        .scene
        .goals
        .push(timed(second, Some(first), asked_s, Some(0.01)));
    let drawn_s = interval_s(&found(&strike));
    assert!(
        (free_s + 1e-5..asked_s - 1e-5).contains(&drawn_s),
        "{free_s} {drawn_s}"
    );
}

/// As many collisions as there are marks: the motion is that of the scene that lists them.
#[test]
fn collisions_are_counted() {
    let strike = strike(&PENDULUM, &Acted::of(0.25), 8411);
    let listed = found(&strike);
    let hits = hits(&strike);
    let mut scene = strike.scene.clone();
    let each = scene.events[hits[0]].kind.collision().expect("a collision");
    let each = each.clone();
    scene.events[hits[0]].kind = EventKind::Collisions {
        each,
        least: 1,
        most: 4,
    };
    let events = strike.events.iter().map(|event| match event {
        TakeEvent::Mark(mark) => TakeEvent::Mark(Mark {
            event: None,
            ..mark.clone()
        }),
        pose => pose.clone(),
    });
    let outcome = Pipeline::of(scene, events).finish(&mut ());
    let counted = outcome.expect("an estimate").estimate;
    assert_eq!(counted.verdict, listed.verdict);
    for (counted, listed) in counted.events.iter().zip(&listed.events) {
        assert!((counted.time_s - listed.time_s).abs() < 1e-9);
    }
}
