//! Likely mistakes in what is said of a performance, in words and as the key to change.

use std::fmt;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::motion::{
    Diagnosis, Distance, LengthUnit, MountSlip, QuaternionSlip, Remedy, SampleSource, Scene,
    SignedAxis,
};

/// One likely mistake.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct DiagnosisLine {
    /// What is likely wrong.
    pub cause: String,
    /// The scene's key to change, or the field of the stream's messages: `stream.position`,
    /// `stream.orientation`, `stream.stamp`.
    pub key: String,
    /// Its right value as in a scene file; for a field of the stream what to do with it.
    pub value: String,
    /// All of that as a sentence, with what is gained.
    pub sentence: String,
}

impl DiagnosisLine {
    /// With the scene's names.
    pub fn new(scene: &Scene, diagnosis: &Diagnosis) -> Self {
        let remedy = &diagnosis.remedy;
        let value = value(scene, remedy);
        let gain = gain(diagnosis.without, diagnosis.with);
        Self {
            cause: cause(remedy).to_owned(),
            key: key(remedy, diagnosis.source).to_owned(),
            sentence: format!("{}; {gain}", advice(scene, diagnosis, &value)),
            value,
        }
    }
}

fn cause(remedy: &Remedy) -> &'static str {
    match remedy {
        Remedy::Up { .. } => "up_axis",
        Remedy::Gravity { .. } => "gravity_direction",
        Remedy::PositionUnit(_) => "position_unit",
        Remedy::SceneUnit(_) => "scene_unit",
        Remedy::StampUnit { .. } => "stamp_unit",
        Remedy::FrameNumbers { .. } => "frame_numbers",
        Remedy::Tempo { .. } => "acted_tempo",
        Remedy::Mount { slip, .. } => match slip {
            MountSlip::Negated => "tracker_sign",
            MountSlip::Inverted => "tracker_inverse",
            MountSlip::Missing => "tracker_missing",
            MountSlip::Offset => "tracker_offset",
            MountSlip::Quaternion => "tracker_quaternion",
            MountSlip::Turned => "tracker_turned",
            MountSlip::Elsewhere => "tracker_elsewhere",
        },
        Remedy::StreamQuaternions(QuaternionSlip::Inverse) => "stream_inverse",
        Remedy::StreamQuaternions(_) => "stream_quaternion",
        Remedy::GoalQuaternions(QuaternionSlip::Inverse) => "goal_inverse",
        Remedy::GoalQuaternions(_) => "goal_quaternion",
        Remedy::Surface { .. } => "surface_height",
        Remedy::Origin { .. } => "origin",
        Remedy::MissedCollision { .. } => "missed_collision",
        Remedy::StuckTogether { .. } => "stuck_together",
        Remedy::FreeLabels { .. } => "goal_labels",
    }
}

fn key(remedy: &Remedy, source: SampleSource) -> &'static str {
    let of_source = |stream, keyframe| match source {
        SampleSource::Tracker => stream,
        SampleSource::Keyframe => keyframe,
    };
    match remedy {
        Remedy::Up { .. } | Remedy::Gravity { .. } => "gravity_m_s2",
        Remedy::PositionUnit(_) => of_source("stream.position", "keyframe.position"),
        Remedy::SceneUnit(_) => "*_mm",
        Remedy::StampUnit { .. } | Remedy::FrameNumbers { .. } => {
            of_source("stream.stamp", "keyframe.time")
        }
        Remedy::Tempo { .. } => "timing.stamps",
        Remedy::Mount { slip, .. } => match slip {
            MountSlip::Negated | MountSlip::Missing | MountSlip::Offset => {
                "body.tracker.position_mm"
            }
            MountSlip::Inverted | MountSlip::Elsewhere => "body.tracker",
            MountSlip::Quaternion | MountSlip::Turned => "body.tracker.orientation_wxyz",
        },
        Remedy::StreamQuaternions(_) => "stream.orientation",
        Remedy::GoalQuaternions(_) => "goal.orientation_wxyz",
        Remedy::Surface { .. } | Remedy::Origin { .. } => "surface.point_mm",
        Remedy::MissedCollision { .. } => "event",
        Remedy::StuckTogether { .. } => "joint",
        Remedy::FreeLabels { .. } => "goal.labels",
    }
}

fn value(scene: &Scene, remedy: &Remedy) -> String {
    match remedy {
        Remedy::Up { gravity_m_s2, .. } | Remedy::Gravity { gravity_m_s2 } => {
            array(gravity_m_s2.as_slice())
        }
        Remedy::PositionUnit(unit) => format!("× {}", Plain(unit.length_m())),
        Remedy::SceneUnit(unit) => format!("× {}", Plain(unit.length_m() * 1e3)),
        Remedy::StampUnit { factor } => format!("÷ {}", Plain(*factor)),
        Remedy::FrameNumbers { rate_hz } => format!("÷ {}", Plain(*rate_hz)),
        Remedy::Tempo { .. } => "\"tempo\"".to_owned(),
        Remedy::Mount {
            track,
            link_from_tracker,
            slip,
        } => {
            let given_from_tracker = scene.link_seen_by(*track).given_from(link_from_tracker);
            let offset_mm = tenths(&(given_from_tracker.translation.vector * 1e3));
            let q = given_from_tracker.rotation.quaternion();
            let wxyz = array(&[q.w, q.i, q.j, q.k]);
            match slip {
                MountSlip::Negated | MountSlip::Missing | MountSlip::Offset => offset_mm,
                MountSlip::Inverted | MountSlip::Elsewhere => {
                    format!("{{ position_mm = {offset_mm}, orientation_wxyz = {wxyz} }}")
                }
                MountSlip::Quaternion | MountSlip::Turned => wxyz,
            }
        }
        Remedy::StreamQuaternions(slip) => match slip {
            QuaternionSlip::Inverse => "world from body".to_owned(),
            QuaternionSlip::ScalarFirst | QuaternionSlip::ScalarLast => "x, y, z, w".to_owned(),
        },
        Remedy::GoalQuaternions(slip) => match slip {
            QuaternionSlip::Inverse => "world from body".to_owned(),
            QuaternionSlip::ScalarFirst | QuaternionSlip::ScalarLast => "[w, x, y, z]".to_owned(),
        },
        Remedy::Surface { point_m, .. } => tenths(&(point_m * 1e3)),
        Remedy::MissedCollision { link, surface, .. } => format!(
            "{{ kind = \"collision\", body = {:?}, surface = {:?}, … }}",
            scene.links[*link].name, scene.surfaces[*surface].name
        ),
        Remedy::StuckTogether { event, links } => {
            let [child, parent] = links.map(|link| &scene.links[link].name);
            let from = &scene.events[*event].name;
            format!(
                "{{ kind = \"fixed\", parent = {parent:?}, child = {child:?}, from = {from:?} }}"
            )
        }
        Remedy::FreeLabels { .. } => "\"free\"".to_owned(),
        Remedy::Origin { higher_m } => format!("+ {}", tenths(&(higher_m * 1e3))),
    }
}

/// What is likely wrong and what to change.
fn advice(scene: &Scene, of: &Diagnosis, value: &str) -> String {
    let is_keyframes = of.source == SampleSource::Keyframe;
    match &of.remedy {
        Remedy::Up { axis, .. } => {
            let (up, down) = (Signed(*axis), Signed(axis.opposite()));
            let [who, what, axes] = match is_keyframes {
                true => ["the sketch", "keyframes", "axes of the sketch"],
                false => ["the tracker", "stream", "tracker's axes"],
            };
            format!(
                "the motion falls along {down}: is {who} {up}-up? Turn the {what}, or set \
                 `gravity_m_s2 = {value}` and give surfaces, obstacles and goals in the {axes}"
            )
        }
        Remedy::Gravity { gravity_m_s2 } => {
            let down = SignedAxis::along(gravity_m_s2);
            let down = down.map_or_else(|| "elsewhere".into(), |down| format!("along {}", Signed(down)));
            format!(
                "the motion falls {down}, and gravity points elsewhere: set `gravity_m_s2 = {value}`"
            )
        }
        Remedy::PositionUnit(unit) => format!(
            "the motion falls as if its positions were in {}: expected metres, so multiply them by {}",
            plural(*unit),
            Plain(unit.length_m())
        ),
        Remedy::SceneUnit(unit) => format!(
            "the bodies are too small for their motion: are the scene's lengths in {}? Keys that end in \
             `_mm` are in millimetres, so multiply them by {}",
            plural(*unit),
            Plain(unit.length_m() * 1e3)
        ),
        Remedy::StampUnit { factor } => {
            let (pace, change) = if *factor > 1.0 {
                (*factor, format!("divide them by {}", Plain(*factor)))
            } else {
                (1.0 / factor, format!("multiply them by {}", Plain(1.0 / factor)))
            };
            let pace = Plain(pace.round());
            let side = if *factor > 1.0 { "long" } else { "short" };
            format!(
                "the motion takes {pace} times too {side}: are the {} in another unit? Expected \
                 {}, so {change}",
                if is_keyframes { "times" } else { "stamps" },
                match is_keyframes {
                    true => "seconds, or milliseconds in `t_ms`",
                    false => "nanoseconds or seconds as the message type says",
                }
            )
        }
        Remedy::FrameNumbers { rate_hz } => format!(
            "the stamps are whole seconds: are they frame numbers? Divide them by the frames in a second, \
             about {}",
            Plain(*rate_hz)
        ),
        Remedy::Tempo { slowness } => format!(
            "the motion falls {slowness:.1} times slower than a thrown body: was it acted in slow motion? \
             Stamps are then no physical times: set `timing.stamps = {value}`"
        ),
        Remedy::Mount { track, slip, .. } => {
            let body = &scene.link_seen_by(*track).name;
            let (wrong, key) = match slip {
                MountSlip::Negated => ("the tracker's offset has the wrong sign", "position_mm = "),
                MountSlip::Missing => ("the tracker's offset is missing", "position_mm = "),
                MountSlip::Offset => ("the tracker is elsewhere on the body", "position_mm = "),
                MountSlip::Inverted => (
                    "the tracker's pose is the body's in the tracker's axes, expected the tracker's in \
                     the body's",
                    "",
                ),
                MountSlip::Turned => (
                    "the tracker's axes are turned otherwise",
                    "orientation_wxyz = ",
                ),
                MountSlip::Elsewhere => (
                    "the tracker is elsewhere on the body, and its axes are turned otherwise",
                    "",
                ),
                MountSlip::Quaternion => (
                    "the tracker's orientation is in the order x, y, z, w",
                    "orientation_wxyz = ",
                ),
            };
            let set = match slip {
                MountSlip::Inverted | MountSlip::Elsewhere => format!("`tracker = {value}`"),
                _ => format!("`tracker = {{ {key}{value}, … }}`"),
            };
            format!("on `{body}` it seems that {wrong}: set {set}")
        }
        Remedy::StreamQuaternions(slip) => match slip {
            QuaternionSlip::ScalarFirst => {
                "the stream's quaternions seem to have w first: the message wants x, y, z, w".to_owned()
            }
            QuaternionSlip::ScalarLast => "the stream's quaternions seem to be read with w first, where it \
                                           is last: the message wants x, y, z, w"
                .to_owned(),
            QuaternionSlip::Inverse => "the stream's quaternions seem to be world in body axes: expected \
                                        world from body, so negate x, y, z"
                .to_owned(),
        },
        Remedy::GoalQuaternions(slip) => match slip {
            QuaternionSlip::Inverse => "the goals' quaternions seem to be world in body axes: expected \
                                        world from body, so negate x, y, z in `goal.orientation_wxyz`"
                .to_owned(),
            QuaternionSlip::ScalarFirst | QuaternionSlip::ScalarLast => {
                "the goals' quaternions seem to be in the order x, y, z, w: `goal.orientation_wxyz` has w \
                 first"
                    .to_owned()
            }
        },
        Remedy::Surface {
            surface, higher_m, ..
        } => {
            let surface = &scene.surfaces[*surface];
            let up = surface.plane().map_or(*higher_m, |(_, normal)| normal);
            let (height_mm, side) = height(higher_m.norm() * higher_m.dot(&up).signum());
            let name = &surface.name;
            format!(
                "the bounces are {height_mm:.0} mm {side} `{name}`: set `surface.point_mm = {value}` there"
            )
        }
        Remedy::MissedCollision {
            link,
            surface,
            acted_s,
            ..
        } => format!(
            "`{}` hits `{}` at {acted_s:.3} s of the recording, of which no event tells: add `[[event]]` with {value}, and a \
             mark there",
            scene.links[*link].name, scene.surfaces[*surface].name
        ),
        Remedy::StuckTogether { event, links } => {
            let [child, parent] = links.map(|link| &scene.links[link].name);
            let from = &scene.events[*event].name;
            format!(
                "`{child}` and `{parent}` fly as one from `{from}` on: make of it an event with `kind = \"change\"` and `body = {child:?}` \
                 alone, and add `[[joint]]` with {value}"
            )
        }
        Remedy::FreeLabels { goal } => {
            let goal = &scene.rest_goals[*goal];
            format!(
                "with the labels of `{}` turned it shows {}: it moves the same whatever its sides are called, so set \
                 `labels = {value}` in its goal at rest",
                scene.links[goal.link].name, goal.name
            )
        }
        Remedy::Origin { higher_m } => {
            let up = -scene.gravity_m_s2;
            let (height_mm, side) = height(higher_m.norm() * higher_m.dot(&up).signum());
            format!(
                "the motion is {height_mm:.0} mm {side} where the scene is: {} another zero? Add \
                 {} to `surface.point_mm`, and to `position_mm` of obstacles and goals",
                if is_keyframes { "have the keyframes" } else { "has the tracker" },
                tenths(&(higher_m * 1e3))
            )
        }
    }
}

fn height(higher_m: f64) -> (f64, &'static str) {
    let side = if higher_m > 0.0 { "above" } else { "below" };
    (higher_m.abs() * 1e3, side)
}

/// What the remedy gains.
fn gain(without: Option<Distance>, with: Distance) -> String {
    let words = |distance: Distance| {
        let (mm, degrees) = (
            distance.position_m * 1e3,
            distance.orientation_rad.to_degrees(),
        );
        format!("{mm:.1} mm and {degrees:.1}°")
    };
    match without {
        Some(without) => format!(
            "with that the motion is {} from the samples, without it {}",
            words(with),
            words(without)
        ),
        None => format!(
            "with that there is a motion, {} from the samples",
            words(with)
        ),
    }
}

fn plural(unit: LengthUnit) -> &'static str {
    match unit {
        LengthUnit::Millimetre => "millimetres",
        LengthUnit::Centimetre => "centimetres",
        LengthUnit::Inch => "inches",
        LengthUnit::Foot => "feet",
        LengthUnit::Metre => "metres",
    }
}

/// `-y`, `z`.
struct Signed(SignedAxis);

impl fmt::Display for Signed {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let sign = if self.0.is_negative { "-" } else { "" };
        write!(f, "{sign}{}", ["x", "y", "z"][self.0.axis])
    }
}

/// A number without zeros at its end.
struct Plain(f64);

impl fmt::Display for Plain {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let text = format!("{:.6}", self.0);
        let text = text.trim_end_matches('0').trim_end_matches('.');
        f.write_str(if text == "-0" { "0" } else { text })
    }
}

fn array(numbers: &[f64]) -> String {
    let numbers: Vec<String> = numbers.iter().map(|x| Plain(*x).to_string()).collect();
    format!("[{}]", numbers.join(", "))
}

/// Millimetres to a tenth.
fn tenths(vector_mm: &Vector3<f64>) -> String {
    array(vector_mm.map(|x| (x * 10.0).round() / 10.0).as_slice())
}
