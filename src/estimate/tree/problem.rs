//! What is asked of a tree's motion: samples, goals, and where its unknown states are.

use nalgebra::Vector3;

use crate::estimate::problem::unit;
use crate::motion::{
    BodyPoint, Condition, EventKind, GoalQuantity, GoalSet, GoalUnit, JointTree, MechanismIndex,
    Sample, Scene, Seen, Sees, Sketch, Stamp, TrackIndex,
};
use crate::physics::tree::Tree;
use crate::physics::tree::tableau::{self, Tableau};

/// Standard deviation of the rates of joints and of a free base's spin at the start [rad/s]: of two
/// motions that are as near to the sketch the one that whirls less is kept.
pub const RATE_SD_RAD_S: f64 = 10.0;

/// How many times as long steps are where they need not be exact.
const COARSER: f64 = 1.5;

/// A part of a sample: a quantity of one link at a time, and where it was seen.
#[derive(Clone, Debug)]
pub struct TreeSample {
    /// Of which track.
    pub track: TrackIndex,
    /// When it was measured.
    pub stamp: Stamp,
    /// Physical time \[s\].
    pub time_s: f64,
    /// The link's place in the tree.
    pub place: usize,
    /// What was seen.
    pub quantity: GoalQuantity,
    /// Point of the link that it is about [m, link axes].
    pub point_m: Vector3<f64>,
    /// Its value.
    pub seen: Vector3<f64>,
    /// One unit of its residual, in the quantity's own.
    pub unit: f64,
}

/// A condition at an event.
#[derive(Clone, Debug)]
pub struct TreeGoal {
    /// Index into `Scene::goals`.
    pub goal: usize,
    /// Index into `Scene::events`.
    pub event: usize,
    /// Physical time \[s\].
    pub time_s: f64,
    /// The link's place in the tree, and that of the link in whose axes it is seen.
    pub places: [usize; 2],
    /// Point of the link that it is about [m, link axes].
    pub point_m: Vector3<f64>,
    /// What must hold.
    pub condition: Condition,
    /// The numbers of the quantity that a box bounds; none where the set has one row.
    pub axes: Vec<usize>,
}

/// A tree's motion to be estimated.
#[derive(Clone, Debug)]
pub struct TreeProblem {
    /// What moves.
    pub mechanism: MechanismIndex,
    /// Its equations of motion.
    pub tree: Tree,
    /// Gravity [m/s², world].
    pub gravity_m_s2: Vector3<f64>,
    /// Beginning and end of the motion \[s\].
    pub span_s: [f64; 2],
    /// In order of time.
    pub samples: Vec<TreeSample>,
    /// In order of time.
    pub goals: Vec<TreeGoal>,
    /// Where states are unknown \[s\]: at the beginning, and where errors would grow too much.
    pub nodes_s: Vec<f64>,
    /// The integrator,
    pub tableau: Tableau,
    /// and its longest step \[s\].
    pub step_s: f64,
    /// Least and greatest information of residuals, as
    /// [`Program::information`](crate::optimise::Program::information) says.
    pub information: (f64, f64),
}

impl TreeProblem {
    /// The problem of a tree of the scene, with one node. Times are physical stamps.
    pub fn new(
        scene: &Scene,
        sketch: &Sketch,
        (mechanism, joined): (MechanismIndex, &JointTree),
    ) -> Self {
        let span_s = span_s(scene, sketch);
        let mut samples = Vec::new();
        for (index, track) in scene.tracks.iter_enumerated() {
            let Some(place) = joined.place_of(track.link) else {
                continue;
            };
            let weights = track.weights(&scene.weights);
            let within = |sample: &&Sample| (span_s[0]..=span_s[1]).contains(&sample.acted_s);
            for sample in sketch.tracks[index].samples.iter().filter(within) {
                let begun = TreeSample {
                    track: index,
                    stamp: sample.stamp,
                    time_s: sample.acted_s,
                    place,
                    quantity: GoalQuantity::Position {
                        point: BodyPoint::Centre,
                        seen_from: None,
                    },
                    point_m: Vector3::zeros(),
                    seen: Vector3::zeros(),
                    unit: weights.position_m,
                };
                samples.extend(parts(
                    &begun,
                    &sample.seen,
                    (track.sees, track.point_m()),
                    weights.orientation_rad,
                ));
            }
        }
        samples.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        let mut goals = goals(scene, sketch, joined, span_s);
        goals.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        let weighs = samples.iter().map(|sample| match sample.quantity.unit() {
            GoalUnit::Metre => (unit::POSITION_M / sample.unit).powi(2),
            _ => (unit::ORIENTATION_RAD / sample.unit).powi(2),
        });
        let least = weighs.clone().fold(f64::INFINITY, f64::min);
        let most = weighs.fold(0.0, f64::max);
        Self {
            mechanism,
            tree: scene.tree_model(joined),
            gravity_m_s2: scene.gravity_m_s2,
            span_s,
            samples,
            goals,
            nodes_s: vec![span_s[0]],
            tableau: tableau::DORMAND_PRINCE,
            step_s: f64::INFINITY,
            information: (least, most),
        }
    }

    /// The same problem read coarsely, for what need not be exact: of the samples those that are this far
    /// apart, with the weight of all, and steps of a cheaper integrator that may be as long.
    pub fn coarse(&self, apart_s: f64) -> Self {
        let mut last_s = f64::NEG_INFINITY;
        let mut kept = self.samples.clone();
        kept.retain(|sample| {
            let is_next = sample.time_s >= last_s + apart_s;
            if is_next {
                last_s = sample.time_s;
            }
            sample.time_s == last_s
        });
        let share = kept.len() as f64 / self.samples.len() as f64;
        for sample in &mut kept {
            sample.unit *= share.sqrt();
        }
        Self {
            samples: kept,
            tableau: tableau::BUTCHER,
            step_s: COARSER * self.step_s,
            ..self.clone()
        }
    }

    /// Number of unknowns of a node.
    pub fn width(&self) -> usize {
        2 * self.tree.freedoms()
    }
}

/// Physical times at which the motion begins and ends: the events, or the first and the last sample.
fn span_s(scene: &Scene, sketch: &Sketch) -> [f64; 2] {
    let samples = || sketch.tracks.iter().flat_map(|track| &track.samples);
    let first_s = samples()
        .map(|sample| sample.acted_s)
        .fold(f64::INFINITY, f64::min);
    let last_s = samples()
        .map(|sample| sample.acted_s)
        .fold(f64::NEG_INFINITY, f64::max);
    let mark_s = |kind: EventKind| {
        let event = scene.events.iter().position(|event| event.kind == kind)?;
        Some(sketch.marks_s[event])
    };
    [
        mark_s(EventKind::Start).unwrap_or(first_s),
        mark_s(EventKind::End).unwrap_or(last_s),
    ]
}

/// A sample's parts: its place and how it is turned.
fn parts(
    begun: &TreeSample,
    seen: &Seen,
    (sees, point_m): (Sees, Vector3<f64>),
    orientation_rad: f64,
) -> Vec<TreeSample> {
    let placed = |at_m: Vector3<f64>, point_m: Vector3<f64>| TreeSample {
        point_m,
        seen: at_m,
        ..begun.clone()
    };
    let turned = |quantity: GoalQuantity| TreeSample {
        quantity,
        unit: orientation_rad,
        ..begun.clone()
    };
    let turn = |from| {
        turned(GoalQuantity::Turn {
            from,
            seen_from: None,
        })
    };
    match (*seen, sees) {
        (
            Seen::Pose {
                position_m,
                orientation,
            },
            _,
        ) => vec![placed(position_m, Vector3::zeros()), turn(orientation)],
        (Seen::Point(at_m), _) => vec![placed(at_m, point_m)],
        (Seen::Orientation(orientation), _) => vec![turn(orientation)],
        (Seen::Direction(towards), Sees::Direction(axis)) => {
            vec![turned(GoalQuantity::Direction {
                axis: axis.into_inner(),
                towards: towards.into_inner(),
                seen_from: None,
            })]
        }
        (Seen::Direction(_), _) => unreachable!("directions are of tracks that see one"),
    }
}

fn goals(scene: &Scene, sketch: &Sketch, joined: &JointTree, span_s: [f64; 2]) -> Vec<TreeGoal> {
    let mut all = Vec::new();
    for (index, goal) in scene.goals.iter().enumerate() {
        let Some(place) = joined.place_of(goal.link) else {
            continue;
        };
        for condition in goal.target.conditions() {
            let seen_from = condition.quantity.seen_from();
            let other = seen_from
                .and_then(|link| joined.place_of(link))
                .unwrap_or(place);
            let point_m = match condition.quantity.point() {
                Some(BodyPoint::Fixed(point_m)) => point_m,
                _ => Vector3::zeros(),
            };
            let axes = match &condition.set {
                GoalSet::Box { lower, upper } => (0..condition.quantity.dimension())
                    .filter(|axis| lower[*axis].is_finite() || upper[*axis].is_finite())
                    .collect(),
                _ => Vec::new(),
            };
            all.push(TreeGoal {
                goal: index,
                event: goal.event,
                time_s: sketch.marks_s[goal.event].clamp(span_s[0], span_s[1]),
                places: [place, other],
                point_m,
                condition,
                axes,
            });
        }
    }
    all
}

impl TreeGoal {
    /// Number of its rows that must hold: none of one that weighs.
    pub fn row_count(&self) -> usize {
        match self.condition.sd {
            Some(_) => 0,
            None => self.axes.len().max(1),
        }
    }

    /// One unit of its rows, in the unit of its quantity.
    pub fn unit(&self) -> f64 {
        unit::of(self.condition.quantity.unit())
    }
}
