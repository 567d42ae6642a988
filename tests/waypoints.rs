//! Waypoints through the program: goals at a moment of a flight, on pencils, cubes and two bodies. What is
//! asked is where a neighbour of the performed motion is, so that a physical motion meets it.

use enact::motion::{
    BodyPoint, Condition, Estimate, EventKind, Goal, GoalQuantity, GoalSet, GoalTarget, LinkIndex,
    Moment, Scene, Stamp, TakeEvent, Undetermined, Verdict,
};
use enact::physics::State;
use enact::pipeline::Outcome;
use enact_tools::case::Case;
use enact_tools::goals::Pair;
use enact_tools::perform::{Acting, Truth};
use nalgebra::Vector3;

/// Which flight of a body a waypoint is in.
#[derive(Clone, Copy, Debug, PartialEq)]
enum In {
    First,
    Last,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Pencil,
    Cube,
    Two,
}

const KINDS: [Kind; 3] = [Kind::Pencil, Kind::Cube, Kind::Two];
/// Performances of each kind.
const NUMBERS: std::ops::Range<u64> = 0..20;

impl Kind {
    fn pair(self, number: u64) -> Option<Pair> {
        match self {
            Kind::Pencil => Pair::of_one(8000 + 5 * number),
            Kind::Cube => Pair::of_one(8001 + 5 * number),
            Kind::Two => Pair::of_two(8000 + number),
        }
    }
}

/// With stamps of a tempo, and physical ones.
fn actings() -> [Acting; 2] {
    [Acting::default(), Acting::timing_known()]
}

/// The body that is asked: the last.
fn body(truth: &Truth) -> LinkIndex {
    LinkIndex(truth.scene.links.len() - 1)
}

/// The time at a share of a flight \[s\].
fn time_s(truth: &Truth, flight: In, share: f64) -> f64 {
    let mechanism = truth.scene.mechanism_of(body(truth));
    let mut arcs = truth.arcs.iter().filter(|arc| arc.mechanism == mechanism);
    let arc = match flight {
        In::First => arcs.next(),
        In::Last => arcs.next_back(),
    };
    let arc = arc.unwrap();
    arc.start_s + share * (arc.end_s - arc.start_s)
}

/// A performance with waypoints at these times, of which goals are asked in their order.
struct Asked {
    case: Case,
    /// The waypoints' events.
    events: Vec<usize>,
}

impl Asked {
    /// Marks are off by as much, as far as they stay between those beside them \[s, acted\].
    fn new(truth: &Truth, acting: &Acting, seed: u64, waypoints: &[(f64, f64)]) -> Self {
        let mut truth = truth.clone();
        for (number, (at_s, _)) in waypoints.iter().enumerate() {
            let link = body(&truth);
            truth = truth.with_waypoint(&name(number), link, *at_s).0;
        }
        let acting = Acting {
            marks_named: true,
            ..*acting
        };
        let mut case = Case::new(&truth, &acting, seed);
        for (number, (_, off_s)) in waypoints.iter().enumerate() {
            case.move_mark(&name(number), *off_s);
        }
        let event_of = |number| {
            let mut events = truth.scene.events.iter();
            events.position(|of| of.name == name(number)).unwrap()
        };
        let events = (0..waypoints.len()).map(event_of).collect();
        Self { case, events }
    }

    fn scene(&mut self) -> &mut Scene {
        &mut self.case.performance.truth.scene
    }

    /// Asks something of the body at a waypoint.
    fn ask(&mut self, waypoint: usize, target: GoalTarget) {
        let (event, link) = (self.events[waypoint], body(&self.case.performance.truth));
        self.scene().goals.push(Goal {
            event,
            link,
            target,
        });
    }

    fn outcome(&self) -> Outcome {
        self.case.estimated(&mut ()).unwrap()
    }
}

fn name(number: usize) -> String {
    format!("way {number}")
}

fn position(there: &State) -> GoalTarget {
    GoalTarget::PositionWithin {
        lower_m: there.position_m,
        upper_m: there.position_m,
    }
}

/// Distances of all goals.
fn distances(outcome: &Outcome) -> Vec<f64> {
    let attained = outcome.scene.goals_attained(&outcome.estimate);
    attained.iter().map(|of| of.distance).collect()
}

#[test]
fn explore() {
    for (way, acting) in actings().iter().enumerate() {
        for kind in KINDS {
            for flight in [In::First, In::Last] {
                let (mut all, mut physical, mut met, mut late, mut far, mut its) =
                    (0, 0, 0, vec![], vec![], vec![]);
                for number in NUMBERS {
                    let Some(pair) = kind.pair(number) else {
                        println!("no pair {kind:?} {number}");
                        continue;
                    };
                    let at_s = time_s(&pair.neighbour, flight, 0.5);
                    let there = pair.neighbour.state(body(&pair.truth), at_s);
                    let mut times = vec![];
                    for off_s in [0.0, 0.1, -0.1] {
                        let mut asked = Asked::new(&pair.truth, acting, number, &[(at_s, off_s)]);
                        asked.ask(0, position(&there));
                        let outcome = asked.outcome();
                        let e = &outcome.estimate;
                        all += 1;
                        physical += usize::from(e.verdict == Verdict::Physical);
                        let d = distances(&outcome);
                        met += usize::from(d.len() == 1 && d[0] < 1e-9);
                        times.push(e.events[asked.events[0]].time_s);
                        its.push(e.counters.iterations);
                        if e.verdict != Verdict::Physical || d.len() != 1 {
                            println!(
                                "{way} {kind:?} {number} {flight:?} {off_s} {:?} {:?} {d:?} its {} doubts {:?}",
                                e.verdict,
                                e.reason.end.as_str(),
                                e.counters.iterations,
                                e.doubts.len()
                            );
                        }
                    }
                    late.push((
                        (times[1] - times[0]).abs().max((times[2] - times[0]).abs()),
                        number,
                    ));
                    far.push(((times[0] - at_s).abs(), number));
                }
                late.sort_by(|a, b| a.0.total_cmp(&b.0));
                far.sort_by(|a, b| a.0.total_cmp(&b.0));
                its.sort();
                println!(
                    "{way} {kind:?} {flight:?}: {physical} physical, {met} met of {all}; slid apart median {:.4} max {:.4?}; from neighbour median {:.4} max {:.4?}; its {} {}",
                    late[late.len() / 2].0,
                    &late[late.len() - 4..],
                    far[far.len() / 2].0,
                    &far[far.len() - 3..],
                    its[its.len() / 2],
                    its[its.len() - 1]
                );
            }
        }
    }
}
