//! The estimation problem in the solver's terms: arcs, events, constraints and what is free.

use nalgebra::{UnitQuaternion, Vector3};

use crate::math::Pose;
use crate::motion::{
    FreeParameter, GoalTarget, Quantity, Scene, Segment, Sketch, Timing, Touching,
};
use crate::physics::impact::Contact;
use crate::physics::{Body, contact};

/// Units in which constraints are weighed (METHOD's `u`): one of each is equally bad.
pub mod unit {
    /// Contact gap and position \[m\].
    pub const POSITION_M: f64 = 0.01;
    /// Orientation \[rad\].
    pub const ORIENTATION_RAD: f64 = 0.1;
    /// Velocity [m/s].
    pub const VELOCITY_M_S: f64 = 0.1;
    /// Angular velocity [rad/s].
    pub const ANGULAR_VELOCITY_RAD_S: f64 = 1.0;
}

/// One sample of an arc.
#[derive(Clone, Copy, Debug)]
pub struct ArcSample {
    /// Centre of mass [m, world].
    pub position_m: Vector3<f64>,
    /// World from body.
    pub orientation: UnitQuaternion<f64>,
    /// Index into [`Problem::nodes_acted_s`].
    pub node: usize,
}

/// Free flight of one body between two events.
#[derive(Clone, Debug)]
pub struct Arc {
    /// Index into [`Problem::bodies`].
    pub body: usize,
    /// Event at its start.
    pub start: Option<usize>,
    /// Event at its end.
    pub end: Option<usize>,
    /// Its samples in order.
    pub samples: Vec<ArcSample>,
}

/// A bounce that ties two arcs of one body.
#[derive(Clone, Debug)]
pub struct Collision {
    /// Event at which it happens.
    pub event: usize,
    /// Arc before.
    pub before: usize,
    /// Arc after.
    pub after: usize,
    /// Which point touches what.
    pub contact: Contact,
    /// Restitution, where it is not free.
    pub restitution: f64,
    /// Parameter that holds the restitution.
    pub restitution_parameter: Option<usize>,
    /// Tangents of the surface and the parameters that hold the normal's tilt about them.
    pub tilts: Vec<(Vector3<f64>, usize)>,
}

/// A hard condition on an arc at an event.
#[derive(Clone, Debug)]
pub struct ArcGoal {
    /// Event at which it holds.
    pub event: usize,
    /// Arc that ends there (or begins there, if none ends).
    pub arc: usize,
    /// What must hold.
    pub target: ArcTarget,
}

/// What a goal asks of an arc.
#[derive(Clone, Debug)]
pub enum ArcTarget {
    /// The body's pose.
    Pose(Pose),
    /// One coordinate of the centre of mass within bounds \[m\].
    Coordinate {
        /// World axis.
        axis: usize,
        /// Least value.
        lower_m: f64,
        /// Greatest value.
        upper_m: f64,
    },
}

/// Everything the solver needs, and nothing else.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Bodies of the scene.
    pub bodies: Vec<Body>,
    /// Gravity, where it is not free [m/s², world].
    pub gravity_m_s2: Vector3<f64>,
    /// Parameters that hold components of gravity.
    pub gravity_parameters: [Option<usize>; 3],
    /// All arcs, in order of time.
    pub arcs: Vec<Arc>,
    /// Whether the time of each of the scene's events is an unknown.
    pub event_is_free: Vec<bool>,
    /// Acted times of the scene's events \[s\].
    pub events_acted_s: Vec<f64>,
    /// Bounces.
    pub collisions: Vec<Collision>,
    /// Goals.
    pub goals: Vec<ArcGoal>,
    /// Free parameters.
    pub parameters: Vec<FreeParameter>,
    /// Those of them that have a bound.
    pub bounded: Vec<usize>,
    /// Acted times of the samples, distinct and increasing \[s\]: the nodes of the time map.
    pub nodes_acted_s: Vec<f64>,
    /// Strength of the tempo prior; `None` where physical times are the acted ones.
    pub tempo_sd_per_sqrt_s: Option<f64>,
    /// One unit of position residual \[m\].
    pub position_unit_m: f64,
    /// One unit of orientation residual \[rad\].
    pub orientation_unit_rad: f64,
}

impl Problem {
    /// The problem of a scene and a sketch cut into segments.
    pub fn new(scene: &Scene, sketch: &Sketch, segments: &[Segment]) -> Self {
        let mut nodes_acted_s: Vec<f64> = segments
            .iter()
            .flat_map(|s| &sketch.bodies[s.body].samples[s.samples.clone()])
            .map(|sample| sample.acted_s)
            .collect();
        nodes_acted_s.sort_by(f64::total_cmp);
        nodes_acted_s.dedup();
        let arcs: Vec<Arc> = segments
            .iter()
            .map(|segment| arc(sketch, segment, &nodes_acted_s))
            .collect();
        let parameter = |quantity: Quantity| {
            scene
                .parameters
                .iter()
                .position(|free| free.quantity == quantity)
        };
        let is_goal = |event| scene.goals.iter().any(|goal| goal.event == event);
        let event_is_free = scene
            .events
            .iter()
            .enumerate()
            .map(|(event, e)| e.kind.collision().is_some() || is_goal(event))
            .collect();
        Self {
            bodies: scene.bodies.iter().map(|body| body.body).collect(),
            gravity_m_s2: scene.gravity_m_s2,
            gravity_parameters: [0, 1, 2].map(|axis| parameter(Quantity::Gravity { axis })),
            collisions: collisions(scene, &arcs, &parameter),
            goals: goals(scene, &arcs),
            arcs,
            event_is_free,
            events_acted_s: sketch.marks_s.clone(),
            parameters: scene.parameters.clone(),
            bounded: (0..scene.parameters.len())
                .filter(|index| {
                    let free = &scene.parameters[*index];
                    free.lower.is_finite() || free.upper.is_finite()
                })
                .collect(),
            nodes_acted_s,
            tempo_sd_per_sqrt_s: match scene.timing {
                Timing::Known | Timing::Edited => None,
                Timing::Unknown {
                    tempo_sd_per_sqrt_s,
                } => Some(tempo_sd_per_sqrt_s),
            },
            position_unit_m: scene.weights.position_m,
            orientation_unit_rad: scene.weights.orientation_rad,
        }
    }

    /// Whether sample times are unknowns.
    pub fn times_are_unknown(&self) -> bool {
        self.tempo_sd_per_sqrt_s.is_some()
    }

    /// How much the samples of an arc know, against 48 samples that are weighed in the units of
    /// [`mod@unit`]. Prices of constraints and damping are multiples of it, so that the way to the
    /// optimum depends neither on the number of samples nor on the weights' scale.
    pub fn information(&self) -> f64 {
        const REFERENCE_SAMPLES: f64 = 48.0;
        let per_arc = self.sample_count() as f64 / self.arcs.len() as f64;
        let position = unit::POSITION_M / self.position_unit_m;
        let orientation = unit::ORIENTATION_RAD / self.orientation_unit_rad;
        let ratio = position.max(orientation);
        per_arc / REFERENCE_SAMPLES * ratio * ratio
    }

    /// Whether a constraint is an inequality that may well act at the optimum: a goal's or a
    /// parameter's bound, as opposed to contacts that must not recede.
    pub fn has_bounds(&self) -> bool {
        let is_inequality = |goal: &ArcGoal| matches!(goal.target, ArcTarget::Coordinate { lower_m, upper_m, .. } if lower_m < upper_m);
        !self.bounded.is_empty() || self.goals.iter().any(is_inequality)
    }

    /// Gravity with its free components taken from `parameters` [m/s², world].
    pub fn gravity(&self, parameters: &[f64]) -> Vector3<f64> {
        let mut gravity = self.gravity_m_s2;
        for axis in 0..3 {
            if let Some(index) = self.gravity_parameters[axis] {
                gravity[axis] = parameters[index];
            }
        }
        gravity
    }

    /// All samples of all arcs.
    pub fn sample_count(&self) -> usize {
        self.arcs.iter().map(|arc| arc.samples.len()).sum()
    }
}

fn arc(sketch: &Sketch, segment: &Segment, nodes_acted_s: &[f64]) -> Arc {
    let samples = &sketch.bodies[segment.body].samples[segment.samples.clone()];
    Arc {
        body: segment.body,
        start: segment.start_event,
        end: segment.end_event,
        samples: samples
            .iter()
            .map(|sample| ArcSample {
                position_m: sample.position_m,
                orientation: sample.orientation,
                node: nodes_acted_s.partition_point(|acted| *acted < sample.acted_s),
            })
            .collect(),
    }
}

fn collisions(
    scene: &Scene,
    arcs: &[Arc],
    parameter: &impl Fn(Quantity) -> Option<usize>,
) -> Vec<Collision> {
    let mut collisions = Vec::new();
    for (event, scene_event) in scene.events.iter().enumerate() {
        let Some(collision) = scene_event.kind.collision() else {
            continue;
        };
        let body = collision.body;
        let [
            Touching {
                feature: Some(feature),
                other: Some(surface),
            },
        ] = collision.contacts[..]
        else {
            panic!("one contact that is known");
        };
        let feature = scene.bodies[body].features[feature].geometry;
        let surface = scene.surfaces[surface].geometry;
        let (
            contact::Feature::Point { point_m, .. },
            contact::Feature::Face {
                point_m: surface_point_m,
                normal,
            },
        ) = (feature, surface)
        else {
            panic!("a point on a face");
        };
        let arc_with = |end: bool| {
            arcs.iter().position(|arc| {
                arc.body == body && (if end { arc.end } else { arc.start }) == Some(event)
            })
        };
        let (Some(before), Some(after)) = (arc_with(true), arc_with(false)) else {
            continue;
        };
        let first = normal.cross(&least_axis(&normal)).normalize();
        let tangents = [first, normal.cross(&first)];
        collisions.push(Collision {
            event,
            before,
            after,
            contact: Contact {
                point_m,
                surface_point_m,
                surface_normal: normal,
            },
            restitution: collision.restitution,
            restitution_parameter: parameter(Quantity::Restitution { event }),
            tilts: (0..2)
                .filter_map(|tangent| {
                    let index = parameter(Quantity::Tilt { event, tangent })?;
                    Some((tangents[tangent], index))
                })
                .collect(),
        });
    }
    collisions
}

/// The world axis least along `direction`.
fn least_axis(direction: &Vector3<f64>) -> Vector3<f64> {
    Vector3::ith(direction.iamin(), 1.0)
}

fn goals(scene: &Scene, arcs: &[Arc]) -> Vec<ArcGoal> {
    let mut goals = Vec::new();
    for goal in &scene.goals {
        let arc = arcs
            .iter()
            .position(|arc| arc.body == goal.body && arc.end == Some(goal.event))
            .or_else(|| {
                arcs.iter()
                    .position(|arc| arc.body == goal.body && arc.start == Some(goal.event))
            });
        let Some(arc) = arc else { continue };
        let event = goal.event;
        match &goal.target {
            GoalTarget::Pose { world_from_body } => {
                goals.push(ArcGoal {
                    event,
                    arc,
                    target: ArcTarget::Pose(*world_from_body),
                });
            }
            GoalTarget::PositionWithin { lower_m, upper_m } => {
                for axis in 0..3 {
                    let (lower_m, upper_m) = (lower_m[axis], upper_m[axis]);
                    if lower_m.is_finite() || upper_m.is_finite() {
                        let target = ArcTarget::Coordinate {
                            axis,
                            lower_m,
                            upper_m,
                        };
                        goals.push(ArcGoal { event, arc, target });
                    }
                }
            }
        }
    }
    goals
}
