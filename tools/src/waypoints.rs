//! Performances with waypoints, of which goals are asked: on pencils, cubes and two bodies.

use enact::motion::{Goal, GoalTarget, LinkIndex, Scene};
use enact::pipeline::Outcome;

use crate::case::Case;
use crate::goals::Pair;
use crate::perform::{Acting, Truth};

/// Which flight of a body a waypoint is in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum In {
    /// Its first.
    First,
    /// Its last.
    Last,
}

/// What moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A pencil.
    Pencil,
    /// A cube.
    Cube,
    /// Two bodies.
    Two,
}

impl Kind {
    /// All of them.
    pub const ALL: [Kind; 3] = [Kind::Pencil, Kind::Cube, Kind::Two];

    /// A motion and a neighbour of it; not every number has one.
    pub fn pair(self, number: u64) -> Option<Pair> {
        match self {
            Kind::Pencil => Pair::of_one(8000 + 5 * number),
            Kind::Cube => Pair::of_one(8001 + 5 * number),
            Kind::Two => Pair::of_two(8000 + number),
        }
    }
}

/// The body that is asked: the last.
pub fn body(truth: &Truth) -> LinkIndex {
    LinkIndex(truth.scene.links.len() - 1)
}

/// The time at a share of a flight \[s\].
pub fn time_s(truth: &Truth, flight: In, share: f64) -> f64 {
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
pub struct Asked {
    /// The performance.
    pub case: Case,
    /// The waypoints' events.
    pub events: Vec<usize>,
}

impl Asked {
    /// Marks are off by as much, as far as they stay between those beside them \[s, acted\].
    pub fn new(truth: &Truth, acting: &Acting, seed: u64, waypoints: &[(f64, f64)]) -> Self {
        let mut truth = truth.clone();
        for (number, (at_s, _)) in waypoints.iter().enumerate() {
            let link = body(&truth);
            truth = truth.with_waypoint(&name(number), link, *at_s).0;
        }
        let acting = Acting {
            marks_named: true,
            // They are off by what is said.
            mark_error_s: 0.0,
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

    /// What it happens in.
    pub fn scene(&mut self) -> &mut Scene {
        &mut self.case.performance.truth.scene
    }

    /// Asks something of the body at a waypoint.
    pub fn ask(&mut self, waypoint: usize, target: GoalTarget) {
        let (event, link) = (self.events[waypoint], body(&self.case.performance.truth));
        self.scene().goals.push(Goal {
            event,
            link,
            target,
        });
    }

    /// What the program makes of it.
    pub fn outcome(&self) -> Outcome {
        self.case.estimated(&mut ()).unwrap()
    }
}

/// Name of a waypoint.
pub fn name(number: usize) -> String {
    format!("way {number}")
}
