//! The motion's events, parameters, segments and duration, with the scene's names.

use serde::{Deserialize, Serialize};

use super::along::{AlongLine, instants_s};
use super::impacts::{ImpactLine, impact_lines};
use super::read::{bounds, number, unbounded, unknown};
use super::reported::Reported;
use super::samples::Ordered;
use crate::motion::{
    ArcEstimate, BorneForce, DurationEstimate, Estimate, EventEstimate, EventKind, LinkIndex,
    Scene, Undetermined,
};

/// An event as estimated.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct EventLine {
    /// Name in the scene.
    pub name: String,
    /// `start`, `collision`, `change`, `waypoint` or `end`.
    pub kind: String,
    /// Physical time since the first sample.
    #[serde(default = "unknown")]
    pub time_s: f64,
    /// Its standard deviation, where it is not fixed and is determined.
    pub time_sd_s: Option<f64>,
    /// Whether the time is fixed or the performance determines it.
    pub time_is_determined: bool,
    /// `fixed`, `estimated`, `undetermined` or `not computed`, of the deviation.
    pub time_is: String,
    /// `lower` or `upper` where the time is at a bound of the scene.
    pub time_at_bound: Option<String>,
    /// The guess of the scene on which the time leans by more than its deviation, which supposes it.
    pub time_leans_on: Option<LeaningLine>,
    /// Acted time since the first sample.
    pub acted_s: f64,
    /// Names of the bodies that it concerns.
    pub bodies: Vec<String>,
    /// What touches, at a collision.
    pub contact: Option<String>,
    /// Whether that was inferred: the scene leaves it open.
    pub contact_inferred: bool,
    /// Other contacts that are not ruled out where it was, and why they are not.
    pub contact_rivals: Vec<RivalLine>,
    /// What happens at each contact of a collision.
    pub impacts: Vec<ImpactLine>,
    /// Largest position gap.
    #[serde(default = "unknown")]
    pub gap_m: f64,
    /// Largest orientation gap.
    #[serde(default = "unknown")]
    pub gap_rad: f64,
    /// Largest velocity gap.
    #[serde(default = "unknown")]
    pub gap_m_s: f64,
    /// Largest angular velocity gap.
    #[serde(default = "unknown")]
    pub gap_rad_s: f64,
}

/// What a time leans on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct LeaningLine {
    /// Name of the guessed quantity.
    pub quantity: String,
    /// Its value in the scene,
    pub value: f64,
    /// another one,
    pub other: f64,
    /// and by how much later the event is with that, about.
    pub later_s: f64,
}

/// Another contact than the inferred one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RivalLine {
    /// What would touch.
    pub contact: String,
    /// `alike`, `no motion found` or `not tried`.
    pub standing: String,
}

/// A free parameter as estimated.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ParameterLine {
    /// Its value.
    #[serde(default = "unknown")]
    pub value: f64,
    /// Its standard deviation, where it is determined; with the bounds as a prior where it is at
    /// one.
    pub sd: Option<f64>,
    /// `lower`, `upper` or `cone` where it is at that bound.
    pub at_bound: Option<String>,
    /// Least and greatest value allowed.
    #[serde(default = "unbounded", deserialize_with = "bounds")]
    pub bounds: [f64; 2],
    /// Unit of them all; empty for ratios.
    pub unit: String,
}

/// How well one arc fits.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SegmentLine {
    /// Name of the body.
    pub body: String,
    /// Name of the phase in which something carries it; none in flight.
    pub phase: Option<String>,
    /// Physical time at which it begins.
    pub start_s: f64,
    /// Physical time at which it ends.
    pub end_s: f64,
    /// Samples in the objective.
    pub samples: usize,
    /// Root mean square distance of the centre of mass.
    pub residual_mm: Option<f64>,
    /// Root mean square angle.
    pub residual_deg: Option<f64>,
    /// How hard the surface presses that carries it; none elsewhere.
    pub normal_n: Option<AlongLine>,
    /// Friction of that surface; none elsewhere.
    pub friction_n: Option<AlongLine>,
    /// Force of the place to which it is tied, or at which it is held still; none elsewhere.
    pub pivot_n: Option<AlongLine>,
}

/// How long the motion lasts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct DurationLine {
    /// From the beginning of the first flight to the end of the last.
    #[serde(deserialize_with = "number")]
    pub physical_s: f64,
    /// Its standard deviation, zero where it is fixed; none where nothing determines it.
    pub physical_sd_s: Option<f64>,
    /// Whether that deviation is within a tenth of it.
    pub physical_is_determined: bool,
}

impl DurationLine {
    /// Of an estimate's duration.
    pub fn new(duration: &DurationEstimate) -> Self {
        Self {
            physical_s: duration.duration_s,
            physical_sd_s: duration.sd_s,
            physical_is_determined: duration.is_determined(),
        }
    }
}

/// The events in order of time.
pub(super) fn event_lines(of: &Reported) -> Vec<EventLine> {
    let (scene, estimate) = (of.scene, of.estimate);
    let name = |link: LinkIndex| scene.links[link].name.clone();
    let events = estimate.events.iter();
    events
        .map(|event| {
            let of_scene = &scene.events[event.event];
            let time = Undetermined::EventTime(event.event);
            EventLine {
                name: of_scene.name.clone(),
                kind: of_scene.kind.as_str().to_owned(),
                time_s: event.time_s,
                time_sd_s: event.sd_s,
                time_is_determined: !estimate.undetermined.contains(&time),
                time_is: match event.sd_s {
                    _ if event.is_fixed => "fixed",
                    Some(_) => "estimated",
                    None if estimate.undetermined.contains(&time) => "undetermined",
                    None => "not computed",
                }
                .to_owned(),
                time_at_bound: event.at_bound.map(|end| end.as_str().to_owned()),
                time_leans_on: leaning_line(scene, event),
                acted_s: event.acted_s,
                bodies: match &of_scene.kind {
                    EventKind::Start | EventKind::Collisions { .. } | EventKind::End => {
                        scene.links.keys().map(name).collect()
                    }
                    EventKind::Collision(_) | EventKind::Change(_) | EventKind::Waypoint(_) => {
                        scene.links_at(event.event).into_iter().map(name).collect()
                    }
                },
                contact: scene.contact_words(event.event),
                contact_inferred: of.inferred.contains(&event.event),
                contact_rivals: rival_lines(scene, estimate, event.event),
                impacts: impact_lines(scene, estimate, event),
                gap_m: event.gap.position_m,
                gap_rad: event.gap.orientation_rad,
                gap_m_s: event.gap.velocity_m_s,
                gap_rad_s: event.gap.angular_velocity_rad_s,
            }
        })
        .collect()
}

fn leaning_line(scene: &Scene, event: &EventEstimate) -> Option<LeaningLine> {
    let leaning = event.leaning?;
    let is_more = event.sd_s.is_some_and(|sd_s| leaning.later_s.abs() > sd_s);
    // A guess at the end of what is physical is wrong to the other side.
    let [lower, upper] = scene.limits_of(leaning.quantity);
    let up = leaning.value + leaning.change;
    let (other, sign) = match (lower..=upper).contains(&up) {
        true => (up, 1.0),
        false => (leaning.value - leaning.change, -1.0),
    };
    is_more.then(|| LeaningLine {
        quantity: scene.name_of_quantity(leaning.quantity),
        value: leaning.value,
        other,
        later_s: sign * leaning.later_s,
    })
}

/// What else may touch at a collision.
fn rival_lines(scene: &Scene, estimate: &Estimate, event: usize) -> Vec<RivalLine> {
    let rivals = estimate.contact_rivals.iter();
    let of_event = rivals.filter(|rival| rival.event == event);
    let lines = of_event.filter_map(|rival| {
        Some(RivalLine {
            contact: scene.words_of(event, &rival.contacts)?,
            standing: rival.standing.as_str().to_owned(),
        })
    });
    lines.collect()
}

/// The free parameters by name, in the scene's order.
pub(super) fn parameter_lines(scene: &Scene, estimate: &Estimate) -> Ordered<ParameterLine> {
    let unit_of = |name: &str| {
        let free = scene.parameters.iter().find(|free| free.name == name);
        free.map_or("", |free| free.quantity.unit())
    };
    let parameters = estimate.parameters.iter().map(|parameter| {
        let line = ParameterLine {
            value: parameter.value,
            sd: parameter.sd,
            at_bound: parameter.at_bound.map(|end| end.as_str().to_owned()),
            bounds: [parameter.lower, parameter.upper],
            unit: unit_of(&parameter.name).to_owned(),
        };
        (parameter.name.clone(), line)
    });
    Ordered(parameters.collect())
}

/// The phase of an arc.
pub(super) fn phase_name(scene: &Scene, estimate: &Estimate, arc: &ArcEstimate) -> Option<String> {
    let phase = scene.phase_of(arc, &estimate.events)?;
    Some(phase.name.clone())
}

/// How well the arcs fit, in their order.
pub(super) fn segment_lines(scene: &Scene, estimate: &Estimate) -> Vec<SegmentLine> {
    let residuals = estimate.residuals.iter();
    let with_arcs = residuals.map(|residual| (residual, &estimate.arcs[residual.arc]));
    let of_flights = with_arcs.map(|(residual, arc)| {
        let forces = arc.borne(scene, &estimate.gravity_m_s2, instants_s(arc));
        let along = |part: fn(&BorneForce) -> Option<f64>| {
            let sizes: Option<Vec<f64>> = forces.as_ref()?.iter().map(part).collect();
            Some(AlongLine::new(Some(sizes?)))
        };
        SegmentLine {
            body: scene.tracks[residual.track].name.clone(),
            phase: phase_name(scene, estimate, arc),
            start_s: arc.start_s,
            end_s: arc.end_s,
            samples: residual.samples,
            residual_mm: residual.position_rms_m.map(|rms_m| rms_m * 1e3),
            residual_deg: residual.orientation_rms_rad.map(f64::to_degrees),
            normal_n: along(BorneForce::pressing_n),
            friction_n: along(BorneForce::friction_n),
            pivot_n: along(BorneForce::pivot_n),
        }
    });
    let of_trees = estimate.trees.iter().flat_map(|tree| {
        let [start_s, end_s] = tree.span_s();
        tree.residuals.iter().map(move |residual| SegmentLine {
            body: scene.tracks[residual.track].name.clone(),
            phase: None,
            start_s,
            end_s,
            samples: residual.samples,
            residual_mm: residual.position_rms_m.map(|rms_m| rms_m * 1e3),
            residual_deg: residual.orientation_rms_rad.map(f64::to_degrees),
            ..SegmentLine::default()
        })
    });
    of_flights.chain(of_trees).collect()
}

/// Names of what the performance does not determine.
pub(super) fn undetermined_names(scene: &Scene, estimate: &Estimate) -> Vec<String> {
    let name = |of: &Undetermined| match of {
        Undetermined::Parameter(parameter) => estimate.parameters[*parameter].name.clone(),
        Undetermined::EventTime(event) => format!("time of {}", scene.events[*event].name),
        Undetermined::Contact(event) => format!("contact of {}", scene.events[*event].name),
        Undetermined::Duration => "duration".to_owned(),
        Undetermined::Motion { mechanism, part } => {
            format!(
                "{} of {}",
                part.as_str(),
                scene.name_of_mechanism(*mechanism)
            )
        }
        Undetermined::Link { link, part } => {
            format!("{} of {}", part.as_str(), scene.links[*link].name)
        }
    };
    estimate.undetermined.iter().map(name).collect()
}
