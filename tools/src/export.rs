//! A problem as JSON that any solver can read: everything [`Problem`] knows, where to start from,
//! and what this program finds at named points, so that a reader can show that its own formulas
//! agree. The format is documented in `tools/peers/README.md`.

#![allow(missing_docs, reason = "tools/peers/README.md documents the fields")]

use enact::estimate::problem::{
    Arc, ArcCollision, ArcGoal, ArcPair, ArcTarget, Problem as Estimation, unit,
};
use enact::estimate::schedule::recipe;
use enact::estimate::terms::context::{Guidance, SolveContext};
use enact::estimate::unknowns::layout::Layout;
use enact::estimate::unknowns::point::Point;
use enact::motion::{Cone, FreeParameter, Guess};
use enact::optimise::Program;
use enact::physics::State;
use enact::physics::body::{Body, Symmetry};
use enact::physics::contact::{Contact, Feature};
use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// What this format is called.
pub const FORMAT: &str = "enact problem 1";

type V3 = [f64; 3];
type Wxyz = [f64; 4];

/// An exported problem. `None` for a bound: there is none.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Problem {
    pub format: String,
    pub name: String,
    pub gravity_m_s2: V3,
    pub constraint_units: Units,
    pub position_unit_m: f64,
    pub orientation_unit_rad: f64,
    pub tempo_sd_per_sqrt_s: Option<f64>,
    pub velocity_gap_weight: Option<f64>,
    pub nodes_acted_s: Vec<f64>,
    pub events: Vec<Event>,
    pub bodies: Vec<RigidBody>,
    pub arcs: Vec<Flight>,
    pub collisions: Vec<Impact>,
    pub goals: Vec<Goal>,
    pub parameters: Vec<Parameter>,
    pub gravity_parameters: [Option<usize>; 3],
    pub bounded: Vec<usize>,
    pub cones: Vec<Circle>,
    pub points: Vec<Named>,
}

/// One of each is equally bad, and the rows of the constraints are counted in them.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Units {
    pub position_m: f64,
    pub orientation_rad: f64,
    pub velocity_m_s: f64,
    pub angular_velocity_rad_s: f64,
}

/// An event of the scene.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Event {
    pub is_free: bool,
    pub acted_s: f64,
}

/// Mass, principal moments, and how many of these are equal.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct RigidBody {
    pub mass_kg: f64,
    pub moments_kg_m2: V3,
    pub symmetry: String,
    pub axis: Option<usize>,
}

/// Free flight of one body, with what was measured of it.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Flight {
    pub body: usize,
    pub start_event: Option<usize>,
    pub end_event: Option<usize>,
    pub epoch_s: f64,
    pub samples: Vec<Sample>,
}

/// A measured pose.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Sample {
    pub node: usize,
    pub position_m: V3,
    pub orientation_wxyz: Wxyz,
}

/// An impact that ties the flights of one body, or of two.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Impact {
    pub event: usize,
    pub sides: Vec<Arcs>,
    pub contacts: Vec<Pair>,
    pub touches_by_goal: bool,
    pub has_friction: bool,
    pub restitution: f64,
    pub friction: f64,
    pub tilt_rad: [f64; 2],
    pub restitution_parameter: Option<usize>,
    pub friction_parameter: Option<usize>,
    pub tilt_parameters: [Option<usize>; 2],
}

/// A body and its arcs before and after.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Arcs {
    pub body: usize,
    pub before: usize,
    pub after: usize,
}

/// What touches what, and about which axes the normal may tilt.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Pair {
    pub a: Part,
    pub b: Part,
    pub tilt_axes: Option<[V3; 2]>,
}

/// A feature of a surface.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Part {
    pub kind: String,
    pub point_m: V3,
    pub direction: Option<V3>,
    pub radius_m: f64,
}

/// A hard condition on an arc at an event: a pose, or a coordinate within bounds.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Goal {
    pub event: usize,
    pub arc: usize,
    pub pose: Option<(V3, Wxyz)>,
    pub coordinate: Option<(usize, Option<f64>, Option<f64>)>,
}

/// A free parameter.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Parameter {
    pub name: String,
    pub initial: f64,
    pub lower: Option<f64>,
    pub upper: Option<f64>,
    pub prior_sd: Option<f64>,
    pub unit: f64,
}

/// Two parameters within a circle about zero.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Circle {
    pub parameters: [usize; 2],
    pub limit: f64,
}

/// A value of all unknowns and what this program makes of it.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Named {
    pub name: String,
    pub states: Vec<Motion>,
    pub event_times_s: Vec<f64>,
    pub node_times_s: Vec<f64>,
    pub parameters: Vec<f64>,
    pub objective: f64,
    pub rows: Vec<Row>,
    pub velocity_gaps: Vec<f64>,
}

/// State of an arc at its epoch.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Motion {
    pub position_m: V3,
    pub orientation_wxyz: Wxyz,
    pub velocity_m_s: V3,
    pub angular_velocity_rad_s: V3,
}

/// A constraint `lower ≤ value ≤ upper`, in units.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Row {
    pub value: f64,
    pub lower: Option<f64>,
    pub upper: Option<f64>,
}

/// The problem, with epochs and first point from `guess`; `others` are further points to know
/// the answers at.
pub fn problem(
    name: &str,
    problem: &Estimation,
    layout: &Layout,
    guess: &Guess,
    others: &[(&str, &Point)],
) -> Problem {
    let epochs_s = recipe::epochs_s(guess);
    let start = Point::new(problem, guess);
    let context = SolveContext::new(problem, layout, epochs_s.clone(), &start);
    let points = [("start", &start)]
        .into_iter()
        .chain(others.iter().copied());
    let events = problem.event_is_free.iter().zip(&problem.events_acted_s);
    Problem {
        format: FORMAT.to_owned(),
        name: name.to_owned(),
        gravity_m_s2: problem.gravity_m_s2.into(),
        constraint_units: Units {
            position_m: unit::POSITION_M,
            orientation_rad: unit::ORIENTATION_RAD,
            velocity_m_s: unit::VELOCITY_M_S,
            angular_velocity_rad_s: unit::ANGULAR_VELOCITY_RAD_S,
        },
        position_unit_m: problem.position_unit_m,
        orientation_unit_rad: problem.orientation_unit_rad,
        tempo_sd_per_sqrt_s: problem.counted_tempo_sd(),
        velocity_gap_weight: problem.velocity_gap_weight,
        nodes_acted_s: problem.nodes_acted_s.clone(),
        events: events
            .map(|(is_free, acted_s)| Event {
                is_free: *is_free,
                acted_s: *acted_s,
            })
            .collect(),
        bodies: problem.bodies.iter().map(body).collect(),
        arcs: problem
            .arcs
            .iter()
            .zip(&epochs_s)
            .map(|(arc, epoch_s)| flight(arc, *epoch_s))
            .collect(),
        collisions: problem.collisions.iter().map(impact).collect(),
        goals: problem.goals.iter().map(goal).collect(),
        parameters: problem.parameters.iter().map(parameter).collect(),
        gravity_parameters: problem.gravity_parameters,
        bounded: problem.bounded.iter().map(|of| of.parameter).collect(),
        cones: problem.cones.iter().map(circle).collect(),
        points: points.map(|(name, at)| named(name, &context, at)).collect(),
    }
}

fn wxyz(rotation: &UnitQuaternion<f64>) -> Wxyz {
    [rotation.w, rotation.i, rotation.j, rotation.k]
}

fn finite(bound: f64) -> Option<f64> {
    bound.is_finite().then_some(bound)
}

fn body(body: &Body) -> RigidBody {
    let (symmetry, axis) = match body.symmetry() {
        Symmetry::Spherical => ("spherical", None),
        Symmetry::Axial { axis } => ("axial", Some(axis)),
        Symmetry::Asymmetric => ("asymmetric", None),
    };
    RigidBody {
        mass_kg: body.mass_kg(),
        moments_kg_m2: body.moments_kg_m2().into(),
        symmetry: symmetry.to_owned(),
        axis,
    }
}

fn flight(arc: &Arc, epoch_s: f64) -> Flight {
    let samples = arc.samples().map(|sample| Sample {
        node: sample.node,
        position_m: sample.position_m.into(),
        orientation_wxyz: wxyz(&sample.orientation),
    });
    Flight {
        body: arc.mechanism.into(),
        start_event: arc.start,
        end_event: arc.end,
        epoch_s,
        samples: samples.collect(),
    }
}

fn impact(collision: &ArcCollision) -> Impact {
    let tilt = |tangent: usize| {
        let mut tilts = collision.tilts.iter();
        tilts
            .find(|(of, _)| *of == tangent)
            .map(|(_, parameter)| *parameter)
    };
    let arcs = |side: &ArcPair| Arcs {
        body: side.mechanism.into(),
        before: side.before,
        after: side.after,
    };
    Impact {
        event: collision.event,
        sides: collision.sides.iter().map(arcs).collect(),
        contacts: collision.contacts.as_slice().iter().map(pair).collect(),
        touches_by_goal: collision.touches_by_goal,
        has_friction: collision.contacts.has_friction(),
        restitution: collision.law.restitution,
        friction: collision.law.friction,
        tilt_rad: collision.law.tilt_rad,
        restitution_parameter: collision.restitution_parameter,
        friction_parameter: collision.friction_parameter,
        tilt_parameters: [tilt(0), tilt(1)],
    }
}

fn pair(contact: &Contact) -> Pair {
    Pair {
        a: part(contact.a()),
        b: part(contact.b()),
        tilt_axes: contact.tilt_axes().map(|axes| axes.map(V3::from)),
    }
}

fn part(feature: &Feature) -> Part {
    let (point_m, direction, radius_m): (Vector3<f64>, Option<Vector3<f64>>, f64) = match *feature {
        Feature::Point { point_m, radius_m } => (point_m, None, radius_m),
        Feature::Line {
            point_m,
            direction,
            radius_m,
        } => (point_m, Some(direction), radius_m),
        Feature::Rim {
            centre_m,
            axis,
            radius_m,
        } => (centre_m, Some(axis), radius_m),
        Feature::Face { point_m, normal } => (point_m, Some(normal), 0.0),
    };
    Part {
        kind: feature.kind().to_owned(),
        point_m: point_m.into(),
        direction: direction.map(V3::from),
        radius_m,
    }
}

fn goal(goal: &ArcGoal) -> Goal {
    let (pose, coordinate) = match &goal.target {
        ArcTarget::Pose(pose) => {
            let position_m: V3 = pose.translation.vector.into();
            (Some((position_m, wxyz(&pose.rotation))), None)
        }
        ArcTarget::Coordinate {
            axis,
            lower_m,
            upper_m,
        } => (None, Some((*axis, finite(*lower_m), finite(*upper_m)))),
    };
    Goal {
        event: goal.event,
        arc: goal.arc,
        pose,
        coordinate,
    }
}

fn parameter(free: &FreeParameter) -> Parameter {
    Parameter {
        name: free.name.clone(),
        initial: free.initial,
        lower: finite(free.lower),
        upper: finite(free.upper),
        prior_sd: free.prior_sd,
        unit: free.length(),
    }
}

fn circle(cone: &Cone) -> Circle {
    Circle {
        parameters: cone.parameters,
        limit: cone.limit,
    }
}

fn motion(state: &State) -> Motion {
    Motion {
        position_m: state.position_m.into(),
        orientation_wxyz: wxyz(&state.orientation),
        velocity_m_s: state.velocity_m_s.into(),
        angular_velocity_rad_s: state.angular_velocity_rad_s.into(),
    }
}

fn named(name: &str, context: &SolveContext, point: &Point) -> Named {
    let system = context.evaluated(&Guidance::none(), point);
    let rows = system.blocks.iter().flat_map(|block| {
        let rows = block.values.iter().zip(&block.bounds);
        rows.map(|(value, (lower, upper))| Row {
            value: *value,
            lower: finite(*lower),
            upper: finite(*upper),
        })
    });
    let gaps = system.priced.iter();
    Named {
        name: name.to_owned(),
        states: point.arcs.iter().map(motion).collect(),
        event_times_s: point.event_times_s.clone(),
        node_times_s: point.node_times_s.clone(),
        parameters: point.parameters.clone(),
        objective: 2.0 * system.cost,
        rows: rows.collect(),
        velocity_gaps: gaps.flat_map(|block| block.values.clone()).collect(),
    }
}
