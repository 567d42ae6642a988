//! Events and goals.

use std::ops::Range;

use nalgebra::Vector3;
use toml::Spanned;

use super::error::{Fault, fault};
use super::number::{finite, index_of, name, pose, unique};
use super::raw::{RawEvent, RawGoal};
use crate::motion::{Event, EventKind, Goal, GoalTarget, SceneBody, Surface};

/// The events in order: a start only first, an end only last.
pub(super) fn events(
    raw: &[Spanned<RawEvent>],
    bodies: &[SceneBody],
    surfaces: &[Surface],
) -> Result<Vec<Event>, Fault> {
    let mut events: Vec<Event> = Vec::new();
    for (index, spanned) in raw.iter().enumerate() {
        let event = spanned.get_ref();
        let name = name("event", &event.name)?;
        unique(
            "event",
            &event.name,
            &name,
            events.iter().map(|e| e.name.as_str()),
        )?;
        let kind = match event.kind.get_ref().as_str() {
            "start" if index > 0 => {
                return fault(
                    event.kind.span(),
                    format!("event {name:?} is a start, expected it before every other event"),
                );
            }
            "end" if index + 1 < raw.len() => {
                return fault(
                    event.kind.span(),
                    format!("event {name:?} is an end, expected it after every other event"),
                );
            }
            "start" => plain(event, EventKind::Start)?,
            "end" => plain(event, EventKind::End)?,
            "collision" => collision(spanned, bodies, surfaces)?,
            other => {
                return fault(
                    event.kind.span(),
                    format!(
                        "unknown kind of event {other:?}, expected one of start, collision, end"
                    ),
                );
            }
        };
        events.push(Event { name, kind });
    }
    Ok(events)
}

fn plain(event: &RawEvent, kind: EventKind) -> Result<EventKind, Fault> {
    for (key, span) in [
        ("body", event.body.as_ref().map(Spanned::span)),
        ("feature", event.feature.as_ref().map(Spanned::span)),
        ("surface", event.surface.as_ref().map(Spanned::span)),
        ("restitution", event.restitution.as_ref().map(Spanned::span)),
    ] {
        if let Some(span) = span {
            return fault(
                span,
                format!("{key} does not apply to an event of kind {:?}", kind.word()),
            );
        }
    }
    Ok(kind)
}

fn collision(
    spanned: &Spanned<RawEvent>,
    bodies: &[SceneBody],
    surfaces: &[Surface],
) -> Result<EventKind, Fault> {
    let event = spanned.get_ref();
    let missing = |key: &str| Fault {
        span: spanned.span(),
        message: format!(
            "missing key `{key}`: a collision needs body, feature, surface and restitution"
        ),
    };
    let body = index_of(
        "body",
        event.body.as_ref().ok_or_else(|| missing("body"))?,
        bodies.iter().map(|b| b.name.as_str()),
    )?;
    let feature = index_of(
        &format!("feature of {:?}", bodies[body].name),
        event.feature.as_ref().ok_or_else(|| missing("feature"))?,
        bodies[body].features.iter().map(|f| f.name.as_str()),
    )?;
    let surface = index_of(
        "surface",
        event.surface.as_ref().ok_or_else(|| missing("surface"))?,
        surfaces.iter().map(|s| s.name.as_str()),
    )?;
    let number = event
        .restitution
        .as_ref()
        .ok_or_else(|| missing("restitution"))?;
    let restitution = finite("restitution", number)?;
    if !(0.0..=1.0).contains(&restitution) {
        return fault(
            number.span(),
            format!("restitution is {restitution}, expected 0 to 1"),
        );
    }
    Ok(EventKind::Collision {
        body,
        feature,
        surface,
        restitution,
    })
}

/// The goals, each on an event and a body that exist, none twice.
pub(super) fn goals(
    raw: &[Spanned<RawGoal>],
    bodies: &[SceneBody],
    events: &[Event],
) -> Result<Vec<Goal>, Fault> {
    let mut goals: Vec<Goal> = Vec::new();
    for spanned in raw {
        let goal = spanned.get_ref();
        let event = index_of("event", &goal.event, events.iter().map(|e| e.name.as_str()))?;
        let body = index_of("body", &goal.body, bodies.iter().map(|b| b.name.as_str()))?;
        let target = target(spanned)?;
        if goals.iter().any(|g| g.event == event && g.body == body) {
            return fault(
                spanned.span(),
                format!(
                    "a second goal for {:?} at {:?}, expected one",
                    bodies[body].name, events[event].name
                ),
            );
        }
        goals.push(Goal {
            event,
            body,
            target,
        });
    }
    Ok(goals)
}

fn target(spanned: &Spanned<RawGoal>) -> Result<GoalTarget, Fault> {
    let goal = spanned.get_ref();
    match (
        &goal.position_mm,
        &goal.orientation_wxyz,
        &goal.position_within_mm,
    ) {
        (Some(position), Some(wxyz), None) => Ok(GoalTarget::Pose {
            world_from_body: pose("the goal", Some(position), Some(wxyz))?,
        }),
        (None, None, Some(bounds)) => within(bounds.span(), bounds.get_ref()),
        _ => fault(
            spanned.span(),
            "a goal needs position_mm and orientation_wxyz both, or position_within_mm alone",
        ),
    }
}

fn within(span: Range<usize>, [lower, upper]: &[[f64; 3]; 2]) -> Result<GoalTarget, Fault> {
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let (low, high) = (lower[axis], upper[axis]);
        // `low <= high` is false for NaN too.
        let some_room = low <= high && low < f64::INFINITY && high > f64::NEG_INFINITY;
        if !some_room {
            return fault(
                span,
                format!(
                    "position_within_mm allows {name} from {low} to {high}, expected a lower bound and one not below it"
                ),
            );
        }
    }
    if lower.iter().chain(upper).all(|bound| bound.is_infinite()) {
        return fault(
            span,
            "position_within_mm bounds nothing, expected at least one finite bound",
        );
    }
    Ok(GoalTarget::PositionWithin {
        lower_m: Vector3::from(*lower) / 1e3,
        upper_m: Vector3::from(*upper) / 1e3,
    })
}
