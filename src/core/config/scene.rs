//! Checks the whole scene, part by part.

use nalgebra::Vector3;
use typed_index_collections::TiVec;

use super::board::board;
use super::body::{body, is_same};
use super::error::{Fault, fault};
use super::event::events;
use super::goal::{check, goals};
use super::held::hold;
use super::joint::{join, refuse, refuse_dependent};
use super::law::{self, Laws};
use super::number::{
    Taken, direction, name, pose, positive, topic, unique, vector, vector_from_mm,
};
use super::parameter::parameters;
use super::phase::{check_beginnings, grips, phases};
use super::raw::{Number, RawObstacle, RawScene, RawSurface, RawTiming, RawWeights, Text};
use super::rest::{rest_goals, split};
use super::solid::{SizeLimits, shape};
use super::spanned::Spanned;
use crate::math::Pose;
use crate::motion::{
    FreeBody, Obstacle, Performer, Scene, Surface, Timing, Track, VelocityGaps, Weights,
};
use crate::physics::contact;

const STANDARD_GRAVITY_M_S2: Vector3<f64> = Vector3::new(0.0, 0.0, -9.80665);
const MARKS_TOPIC: &str = "/marks";
const TEMPO_SD_PER_SQRT_S: f64 = 0.5;
/// What a hand leaves.
const ACTED: Weights = Weights {
    position_m: 0.01,
    orientation_rad: 0.1,
};
/// What cameras and tags leave of a motion that nobody acted.
const MEASURED: Weights = Weights {
    position_m: 0.001,
    orientation_rad: 0.01,
};

/// Greatest gravity [m/s²]; a larger one suggests a wrong unit.
const GRAVITY_LIMIT_M_S2: f64 = 1e3;

/// Longest simulation past the sketch \[s\].
const SETTLE_LIMIT_S: f64 = 60.0;

/// Least exactness of shapes and places \[m\].
const TOLERANCE_LIMIT_M: f64 = 0.1;

const OBSTACLE_SIZE: SizeLimits = SizeLimits {
    least_m: 1e-4,
    greatest_m: 1e4,
};

/// The checked scene.
pub(super) fn scene(raw: &RawScene) -> Result<Scene, Fault> {
    let name = name("scene", &raw.name)?;
    let gravity_m_s2 = gravity_m_s2(raw)?;
    let marks_topic = match &raw.marks_topic {
        Some(text) => topic("marks_topic", text)?,
        None => MARKS_TOPIC.into(),
    };
    let performer = performer(raw.hand.as_ref())?;
    let weights = weights(raw.weights.as_ref(), performer)?;
    let bodies = bodies(raw, &marks_topic, &weights)?;
    let mut obstacles = obstacles(&raw.obstacle)?;
    let mut surfaces = surfaces(&raw.surface, &mut obstacles)?;
    add_obstacles(raw, &obstacles, &mut surfaces);
    let mut scene = Scene {
        name,
        gravity_m_s2,
        timing: timing(&raw.timing)?,
        mark_sd_s: mark_sd_s(&raw.timing)?,
        marks_topic,
        links: TiVec::new(),
        mechanisms: TiVec::new(),
        tracks: TiVec::new(),
        obstacles,
        surfaces,
        contact_laws: TiVec::new(),
        events: Vec::new(),
        phases: Vec::new(),
        goals: Vec::new(),
        rest_goals: Vec::new(),
        parameters: Vec::new(),
        cones: Vec::new(),
        velocity_gaps: velocity_gaps(raw.velocity_gaps.as_ref())?,
        weights,
        performer,
        tolerance_m: tolerance_m(raw.tolerance_mm.as_ref())?.unwrap_or(Scene::TOLERANCE_M),
        settle_s: settle_s(raw.settle_s.as_ref())?,
    };
    for (body, tracks, link_from_given) in bodies {
        let link = scene.add(body);
        scene.links[link].link_from_given = link_from_given;
        scene.tracks.pop();
        let of_link = tracks.into_iter().map(|track| Track { link, ..track });
        scene.tracks.extend(of_link);
    }
    hold(raw, &mut scene)?;
    join(raw, &mut scene)?;
    if raw.tolerance_mm.is_none() {
        scene.tolerance_m = scene.usual_tolerance_m();
    }
    check_tracked(raw, &scene)?;
    let mut laws = Laws::new();
    let of_links = law::of_bodies(&raw.body, &mut laws)?;
    scene.events = events(&raw.event, &scene, &of_links, &mut laws)?;
    scene.phases = phases(raw, &scene, &of_links, &mut laws)?;
    scene.contact_laws = laws;
    if let (Some(settle_s), Some(last)) = (&raw.settle_s, scene.events.len().checked_sub(1))
        && let Some(phase) = scene.tied_at(last)
    {
        let message = format!(
            "{:?} ties {:?} to the end, what follows is not known, expected no settle_s",
            phase.name, scene.links[phase.link].name
        );
        return fault(settle_s.span(), message);
    }
    let [at_rest, at_events] = split(&raw.goal);
    let (goals, goal_spans) = goals(&at_events, &scene)?;
    scene.goals = goals;
    scene.rest_goals = rest_goals(&at_rest, &scene)?;
    parameters(&raw.free, &mut scene)?;
    refuse(raw, &scene)?;
    for (event, spanned) in raw.event.iter().enumerate() {
        scene.contact_set(event).map_err(|error| Fault {
            span: spanned.span(),
            message: error.to_string(),
        })?;
    }
    check_beginnings(raw, &scene)?;
    refuse_dependent(raw, &scene)?;
    for (goal, span) in goal_spans.iter().enumerate() {
        if let Err(error) = scene.snap_to_contact(goal) {
            return fault(span.clone(), error.to_string());
        }
    }
    check(&scene, &goal_spans)?;
    Ok(scene)
}

/// A body by itself is seen by a tracker, and so is one of joined ones.
fn check_tracked(raw: &RawScene, scene: &Scene) -> Result<(), Fault> {
    for mechanism in scene.mechanisms.keys() {
        if scene.tracks_of(mechanism).next().is_some() {
            continue;
        }
        let first = scene.name_of_mechanism(mechanism);
        if grips(raw, scene, first) {
            continue;
        }
        let mut bodies = raw.body.iter().map(Spanned::get_ref);
        let of = bodies.find(|of| *of.name.get_ref() == first);
        let says = of.and_then(|of| of.tracked.as_ref());
        let span = says.map_or(raw.name.span(), Spanned::span);
        return fault(
            span,
            "no tracker sees the body or what it is joined to, expected one that does; what a held body grips is let go at the `until` of its joint",
        );
    }
    Ok(())
}

fn gravity_m_s2(raw: &RawScene) -> Result<Vector3<f64>, Fault> {
    let Some(given) = &raw.gravity_m_s2 else {
        return Ok(STANDARD_GRAVITY_M_S2);
    };
    let gravity_m_s2 = vector("gravity_m_s2", given)?;
    if gravity_m_s2.amax() > GRAVITY_LIMIT_M_S2 {
        return fault(
            given.span(),
            format!(
                "gravity_m_s2 has {} m/s², expected at most {GRAVITY_LIMIT_M_S2}: it is in metres, not in millimetres",
                gravity_m_s2.amax()
            ),
        );
    }
    Ok(gravity_m_s2)
}

fn timing(raw: &RawTiming) -> Result<Timing, Fault> {
    match (raw.stamps.get_ref().as_str(), &raw.tempo_sd_per_sqrt_s) {
        ("physical", None) => Ok(Timing::Known),
        ("edited", None) => Ok(Timing::Edited),
        (stamps @ ("physical" | "edited"), Some(tempo)) => fault(
            tempo.span(),
            format!("tempo_sd_per_sqrt_s does not apply to {stamps} stamps"),
        ),
        ("tempo", tempo) => Ok(Timing::Unknown {
            tempo_sd_per_sqrt_s: match tempo {
                Some(number) => positive("tempo_sd_per_sqrt_s", number)?,
                None => TEMPO_SD_PER_SQRT_S,
            },
        }),
        (other, _) => fault(
            raw.stamps.span(),
            format!("stamps are {other:?}, expected \"tempo\", \"physical\" or \"edited\""),
        ),
    }
}

fn mark_sd_s(raw: &RawTiming) -> Result<Option<f64>, Fault> {
    let Some(sd_ms) = &raw.mark_sd_ms else {
        return Ok(None);
    };
    if raw.stamps.get_ref() == "edited" {
        return fault(sd_ms.span(), "mark_sd_ms does not apply to edited stamps");
    }
    Ok(Some(positive("mark_sd_ms", sd_ms)? / 1e3))
}

fn velocity_gaps(raw: Option<&Text>) -> Result<VelocityGaps, Fault> {
    let Some(text) = raw else {
        return Ok(VelocityGaps::WhenNeeded);
    };
    match text.get_ref().as_str() {
        "when needed" => Ok(VelocityGaps::WhenNeeded),
        "always" => Ok(VelocityGaps::Always),
        "never" => Ok(VelocityGaps::Never),
        other => fault(
            text.span(),
            format!(
                "velocity_gaps is {other:?}, expected \"when needed\", \"always\" or \"never\""
            ),
        ),
    }
}

fn performer(raw: Option<&Text>) -> Result<Performer, Fault> {
    let Some(text) = raw else {
        return Ok(Performer::Unsaid);
    };
    match text.get_ref().as_str() {
        "acted" => Ok(Performer::Hand),
        "none" => Ok(Performer::Nobody),
        other => fault(
            text.span(),
            format!("hand is {other:?}, expected \"acted\" or \"none\""),
        ),
    }
}

fn weights(raw: Option<&RawWeights>, performer: Performer) -> Result<Weights, Fault> {
    let mut weights = match performer {
        Performer::Nobody => MEASURED,
        Performer::Hand | Performer::Unsaid => ACTED,
    };
    if let Some(number) = raw.and_then(|raw| raw.position_mm.as_ref()) {
        weights.position_m = positive("position_mm", number)? / 1e3;
    }
    if let Some(number) = raw.and_then(|raw| raw.orientation_deg.as_ref()) {
        weights.orientation_rad = positive("orientation_deg", number)?.to_radians();
    }
    Ok(weights)
}

fn tolerance_m(raw: Option<&Number>) -> Result<Option<f64>, Fault> {
    let Some(number) = raw else { return Ok(None) };
    let tolerance_m = positive("tolerance_mm", number)? / 1e3;
    if tolerance_m > TOLERANCE_LIMIT_M {
        let most_mm = 1e3 * TOLERANCE_LIMIT_M;
        let message = format!(
            "tolerance_mm is {}, expected {most_mm} at most",
            1e3 * tolerance_m
        );
        return fault(number.span(), message);
    }
    Ok(Some(tolerance_m))
}

fn settle_s(raw: Option<&Number>) -> Result<Option<f64>, Fault> {
    let Some(number) = raw else {
        return Ok(None);
    };
    let settle_s = positive("settle_s", number)?;
    if settle_s > SETTLE_LIMIT_S {
        return fault(
            number.span(),
            format!("settle_s is {settle_s} s, expected at most {SETTLE_LIMIT_S}"),
        );
    }
    Ok(Some(settle_s))
}

fn bodies(
    raw: &RawScene,
    marks_topic: &str,
    weights: &Weights,
) -> Result<Vec<(FreeBody, Vec<Track>, Pose)>, Fault> {
    let mut bodies: Vec<(FreeBody, Vec<Track>, Pose)> = Vec::new();
    let mut names = Taken::default();
    let mut taken = vec![marks_topic.to_owned()];
    for spanned in &raw.body {
        let raw_body = spanned.get_ref();
        let (body, tracks, link_from_given) = body(spanned, weights)?;
        names.take("body", &raw_body.name, &body.name)?;
        for (number, track) in tracks.iter().enumerate() {
            let own = raw_body.track.get(number);
            let own = own.and_then(|raw| raw.get_ref().topic.as_ref());
            unique(
                "use of the topic",
                own.or(raw_body.topic.as_ref()).unwrap_or(&raw_body.name),
                &track.topic,
                taken.iter().map(String::as_str),
            )?;
        }
        // Two tracks of a body may see different parts of the same messages.
        taken.extend(tracks.iter().map(|track| track.topic.clone()));
        bodies.push((body, tracks, link_from_given));
    }
    if bodies.is_empty() {
        return fault(
            raw.name.span(),
            "the scene has no body, expected at least one [[body]]",
        );
    }
    Ok(bodies)
}

/// The surfaces; boards are obstacles too, which are appended to those.
fn surfaces(raw: &[RawSurface], obstacles: &mut Vec<Obstacle>) -> Result<Vec<Surface>, Fault> {
    let mut surfaces: Vec<Surface> = Vec::new();
    let mut names = Taken::default();
    for surface in raw {
        let name = name("surface", &surface.name)?;
        names.take("surface", &surface.name, &name)?;
        let point_m = vector_from_mm("point_mm", &surface.point_mm)?;
        let normal = direction("normal", &surface.normal)?;
        let board = board(surface, &name, point_m, normal)?;
        let obstacle = match board {
            Some(board) => {
                let taken = obstacles.iter().map(|o| o.name.as_str());
                unique("obstacle", &surface.name, &board.name, taken)?;
                obstacles.push(board);
                Some(obstacles.len() - 1)
            }
            None => None,
        };
        surfaces.push(Surface {
            name,
            geometry: contact::Feature::face(point_m, normal),
            obstacle,
        });
    }
    Ok(surfaces)
}

/// Appends features of obstacles as surfaces, `mug floor/end +z`: those that events name, or all
/// where an event leaves open which surface is hit.
fn add_obstacles(raw: &RawScene, obstacles: &[Obstacle], surfaces: &mut Vec<Surface>) {
    let events = || raw.event.iter().map(|spanned| spanned.get_ref());
    let is_open = events().any(|event| {
        event.kind.get_ref() == "collision" && event.surface.is_none() && event.other.is_none()
    });
    for (index, obstacle) in obstacles.iter().enumerate() {
        for (feature, geometry) in obstacle.shape.features().unwrap_or_default() {
            let name = format!("{}/{feature}", obstacle.name);
            let is_it = |text: &Text| *text.get_ref() == name;
            let is_named = events().any(|event| event.surface.as_ref().is_some_and(is_it));
            let geometry = geometry.placed(&obstacle.world_from_shape);
            // The upper side of a board is a surface already.
            let is_taken = surfaces.iter().any(|surface| {
                let is_of_it = surface.obstacle == Some(index);
                surface.name == name || is_of_it && is_same(&surface.geometry, &geometry)
            });
            if (is_open || is_named) && !is_taken {
                surfaces.push(Surface {
                    name,
                    geometry,
                    obstacle: Some(index),
                });
            }
        }
    }
}

fn obstacles(raw: &[RawObstacle]) -> Result<Vec<Obstacle>, Fault> {
    let mut obstacles: Vec<Obstacle> = Vec::new();
    let mut names = Taken::default();
    for obstacle in raw {
        let name = name("obstacle", &obstacle.name)?;
        names.take("obstacle", &obstacle.name, &name)?;
        let placed = shape("the obstacle", &obstacle.shape, &OBSTACLE_SIZE)?;
        let world_from_given = pose(
            "the obstacle",
            Some(&obstacle.position_mm),
            (
                obstacle.orientation_wxyz.as_ref(),
                obstacle.rpy_deg.as_ref(),
            ),
        )?;
        obstacles.push(Obstacle {
            name,
            shape: placed.shape,
            world_from_shape: world_from_given * placed.given_from_shape,
        });
    }
    Ok(obstacles)
}
