//! The scene's conditions ([`Condition`]) on the arcs of a problem.

use crate::estimate::problem::arc_condition::{ActingParameter, ArcCondition, Rows, Touched};
use crate::estimate::problem::influence::{Acting, Influence};
use crate::estimate::problem::{Arc, ArcCollision, Problem, unit};
use crate::motion::{
    BodyPoint, Condition, EventKind, Goal, GoalQuantity, GoalSet, GoalTarget, GoalUnit, LinkIndex,
    MechanismIndex, Moment, Partner, Scene,
};

/// The conditions whose arcs are all there.
pub(in crate::estimate) fn conditions(
    scene: &Scene,
    arcs: &[Arc],
    collisions: &[ArcCollision],
    gravity_parameters: &[Option<usize>; 3],
) -> Vec<ArcCondition> {
    let mut conditions: Vec<ArcCondition> = Vec::new();
    for (index, goal) in scene.goals.iter().enumerate() {
        let GoalTarget::Condition(condition) = &goal.target else {
            continue;
        };
        if is_implied(scene, index, condition) {
            continue;
        }
        let posed = posed(scene, arcs, collisions, gravity_parameters, goal, condition);
        conditions.extend(posed);
    }
    conditions
}

/// Whether other goals leave nothing to do: a hard pose of the body or, of how it is turned, a hard
/// orientation, with which makers of scenes have compared it; or the same condition.
fn is_implied(scene: &Scene, index: usize, condition: &Condition) -> bool {
    let goal = &scene.goals[index];
    let (quantity, is_hard) = (&condition.quantity, condition.sd.is_none());
    let is_of_turn = quantity.unit() == GoalUnit::Radian;
    let is_told = quantity.is_of_pose() && quantity.seen_from().is_none();
    let mut others = scene.goals.iter().enumerate();
    let is_held = others.any(|(other, of)| {
        let is_here = other != index && of.event == goal.event && of.link == goal.link;
        is_here
            && match &of.target {
                GoalTarget::Pose { .. } => is_told,
                GoalTarget::Condition(of) => {
                    of.is_turn_equality()
                        && is_of_turn
                        && !condition.is_turn_equality()
                        && of.quantity.seen_from() == quantity.seen_from()
                }
                GoalTarget::PositionWithin { .. } => false,
            }
    });
    let is_again = scene.goals[..index].iter().any(|other| other == goal);
    is_hard && (is_held || is_again)
}

fn posed(
    scene: &Scene,
    arcs: &[Arc],
    collisions: &[ArcCollision],
    gravity_parameters: &[Option<usize>; 3],
    goal: &Goal,
    condition: &Condition,
) -> Option<ArcCondition> {
    let event = goal.event;
    let arc_of = |link: LinkIndex| {
        let mechanism = scene.mechanism_of(link);
        flight_at(scene, arcs, mechanism, event, condition.moment)
    };
    let mut links = match condition.quantity {
        GoalQuantity::Time { .. } => Vec::new(),
        _ => vec![goal.link],
    };
    links.extend(condition.quantity.seen_from());
    let mut touched = None;
    if let Some(BodyPoint::Contact(contact)) = condition.quantity.point() {
        let collision = collisions.iter().position(|of| of.event == event)?;
        let of_scene = scene.events[event].kind.collision()?;
        let side = of_scene.links().position(|link| link == goal.link)?;
        touched = Some(Touched {
            collision,
            contact,
            side,
        });
        if let Partner::Link(other) = of_scene.partner {
            let other = [other, of_scene.link][side];
            if !links.contains(&other) {
                links.push(other);
            }
        }
    }
    let arcs_of: Vec<usize> = links
        .iter()
        .map(|link| arc_of(*link))
        .collect::<Option<_>>()?;
    let surface = touched.map(|touched| collisions[touched.collision].acting.as_slice());
    Some(ArcCondition {
        event,
        acting: acting(
            arcs,
            &arcs_of,
            gravity_parameters,
            surface.unwrap_or_default(),
        ),
        condition: condition.clone(),
        arcs: arcs_of,
        touched,
        rows: Rows::of(scene, goal, condition),
    })
}

/// The arc on which a mechanism is at a side of an event: the one that the event ends or begins, or
/// through which it passes.
pub(in crate::estimate) fn flight_at(
    scene: &Scene,
    arcs: &[Arc],
    mechanism: MechanismIndex,
    event: usize,
    moment: Moment,
) -> Option<usize> {
    let of_it = |arc: &&Arc| arc.mechanism == mechanism;
    let found = |is_it: &dyn Fn(&Arc) -> bool| {
        let mut each = arcs.iter().enumerate();
        let (index, _) = each.find(|(_, arc)| of_it(arc) && is_it(arc))?;
        Some(index)
    };
    if scene.concerns(event, mechanism) {
        let is_start = scene.events[event].kind == EventKind::Start;
        return if is_start || moment == Moment::After {
            found(&|arc| arc.start == Some(event))
        } else {
            found(&|arc| arc.end == Some(event))
        };
    }
    // Events are in order of time.
    let concerned = |events: std::ops::Range<usize>| {
        events
            .filter(|other| scene.concerns(*other, mechanism))
            .collect::<Vec<_>>()
    };
    let start = concerned(0..event).last().copied();
    let end = concerned(event..scene.events.len()).first().copied();
    found(&|arc| arc.start == start && arc.end == end)
}

/// What acts on arcs, and on a surface that is touched.
pub(in crate::estimate) fn acting(
    arcs: &[Arc],
    of: &[usize],
    gravity_parameters: &[Option<usize>; 3],
    at_collision: &[Acting],
) -> Vec<ActingParameter> {
    let mut all: Vec<ActingParameter> = Vec::new();
    let mut add = |parameter: usize, on: (Option<usize>, Influence)| match all
        .iter_mut()
        .find(|known| known.parameter == parameter)
    {
        Some(known) => known.on.push(on),
        None => all.push(ActingParameter {
            parameter,
            on: vec![on],
        }),
    };
    for (side, arc) in of.iter().enumerate() {
        let arc = &arcs[*arc];
        if arc.is_plain {
            for (axis, parameter) in gravity_parameters.iter().enumerate() {
                if let Some(parameter) = parameter {
                    add(*parameter, (Some(side), Influence::Pull(axis)));
                }
            }
            // Gravity may be among what acts on it for what is seen of it: it counts once.
            continue;
        }
        for acting in &arc.acting {
            let moves_it = matches!(
                acting.influence,
                Influence::Pull(_)
                    | Influence::LinearDrag
                    | Influence::QuadraticDrag
                    | Influence::Lift
                    | Influence::Moment(_)
                    | Influence::Centre(_)
            );
            if moves_it {
                add(acting.parameter, (Some(side), acting.influence));
            }
        }
    }
    for acting in at_collision {
        if matches!(
            acting.influence,
            Influence::SurfaceHeight | Influence::SurfaceTilt(_)
        ) {
            add(acting.parameter, (None, acting.influence));
        }
    }
    all
}

impl ArcCondition {
    /// One unit of its rows, in the unit of its quantity.
    pub fn unit(&self) -> f64 {
        unit::of(self.condition.quantity.unit())
    }
}

impl Problem {
    /// Number of equalities among the conditions' rows.
    pub(in crate::estimate) fn condition_equalities(&self) -> usize {
        let equalities = self.conditions.iter().filter(|of| !of.is_soft());
        let rows = equalities.map(|of| match (&of.rows, &of.condition.set) {
            (Rows::OnFace(_), _) => 2,
            (Rows::Axes(axes), GoalSet::Box { lower, upper }) => axes
                .iter()
                .filter(|axis| lower[**axis] == upper[**axis])
                .count(),
            _ => 0,
        });
        rows.sum()
    }
}
