//! Tracks: what trackers see of a body, and how it is weighed.

use crate::config::spanned::Spanned;
use nalgebra::{Unit, UnitQuaternion, Vector3};

use super::error::{Fault, fault};
use super::number::{direction, index_of, name, pose, positive, topic, unique};
use super::raw::{RawBody, RawTrack, RawTracker, Text};
use crate::math::Pose;
use crate::motion::{Feature, LinkIndex, Sees, Track, Weighing, Weights};

/// The tracks of a body of that name: one, unless the scene lists several. Links are numbered by
/// [`Scene::add`](crate::motion::Scene::add).
pub(super) fn tracks(
    raw: &RawBody,
    body: &str,
    features: &[Feature],
    link_from_given: &Pose,
    weights: &Weights,
) -> Result<Vec<Track>, Fault> {
    let of_body = |topic: String, link_from_tracker: Pose| Track {
        name: body.to_owned(),
        topic,
        link: LinkIndex(0),
        link_from_tracker,
        sees: Sees::Pose,
        weighing: Weighing::Scene,
    };
    let usual = || format!("/tracker/{body}/pose");
    if let Some(tracked) = raw.tracked.as_ref().filter(|of| !*of.get_ref()) {
        let given = raw.topic.is_some() || raw.tracker.is_some() || !raw.track.is_empty();
        if given {
            let said =
                "tracked = false beside topic, tracker or [[body.track]], expected none of them";
            return fault(tracked.span(), said);
        }
        return Ok(Vec::new());
    }
    if raw.track.is_empty() {
        let topic = raw.topic.as_ref().map(|text| topic("topic", text));
        let topic = topic.transpose()?.unwrap_or_else(usual);
        let link_from_tracker = link_from_given * mount(raw.tracker.as_ref())?;
        return Ok(vec![of_body(topic, link_from_tracker)]);
    }
    let of_the_body = [
        ("topic", raw.topic.as_ref().map(Spanned::span)),
        ("tracker", raw.tracker.as_ref().map(Spanned::span)),
    ];
    for (key, span) in of_the_body {
        if let Some(span) = span {
            let said = format!("{key} beside [[body.track]], expected it in each of them");
            return fault(span, said);
        }
    }
    let mut tracks: Vec<Track> = Vec::new();
    for spanned in &raw.track {
        let track = spanned.get_ref();
        let mut made = of_body(usual(), Pose::identity());
        if let Some(text) = &track.name {
            let own = name("track", text)?;
            made.name = format!("{body}.{own}");
            made.topic = format!("/tracker/{body}/{own}");
            let taken = tracks.iter().map(|track| track.name.as_str());
            unique("track", text, &made.name, taken)?;
        } else if raw.track.len() > 1 {
            return fault(
                spanned.span(),
                "one of several tracks without a name, expected a name for each",
            );
        }
        if let Some(text) = &track.topic {
            made.topic = topic("topic", text)?;
        }
        made.sees = match sees(spanned)? {
            Sees::Direction(axis) => Sees::Direction(link_from_given.rotation * axis),
            other => other,
        };
        made.link_from_tracker = match (&made.sees, &track.point) {
            (Sees::Point, Some(text)) => at_point(text, features, track.tracker.as_ref())?,
            _ => link_from_given * mount(track.tracker.as_ref())?,
        };
        made.weighing = weighing(spanned, made.sees, weights)?;
        tracks.push(made);
    }
    Ok(tracks)
}

fn mount(tracker: Option<&Spanned<RawTracker>>) -> Result<Pose, Fault> {
    let Some(tracker) = tracker.map(Spanned::get_ref) else {
        return Ok(Pose::identity());
    };
    let turn = (tracker.orientation_wxyz.as_ref(), tracker.rpy_deg.as_ref());
    pose("the tracker", tracker.position_mm.as_ref(), turn)
}

/// What the track sees; keys that mean nothing for it are refused.
fn sees(spanned: &Spanned<RawTrack>) -> Result<Sees, Fault> {
    let track = spanned.get_ref();
    let said = track.sees.as_ref().map_or("pose", |text| text.get_ref());
    let sees = match (said, &track.axis) {
        ("pose", _) => Sees::Pose,
        ("point", _) => Sees::Point,
        ("orientation", _) => Sees::Orientation,
        ("direction", Some(axis)) => Sees::Direction(Unit::new_unchecked(direction("axis", axis)?)),
        ("direction", None) => {
            return fault(
                spanned.span(),
                "a direction of what? Expected axis, in body axes",
            );
        }
        (other, _) => {
            let span = track.sees.as_ref().map_or(spanned.span(), Spanned::span);
            return fault(
                span,
                format!(
                    "sees is {other:?}, expected \"pose\", \"point\", \"orientation\" or \"direction\""
                ),
            );
        }
    };
    let [position, turn] = shows(sees);
    let wrong = [
        (
            "axis",
            track.axis.as_ref().map(Spanned::span),
            said == "direction",
        ),
        (
            "point",
            track.point.as_ref().map(Spanned::span),
            said == "point",
        ),
        (
            "position_sd_mm",
            track.position_sd_mm.as_ref().map(Spanned::span),
            position,
        ),
        (
            "orientation_sd_deg",
            track.orientation_sd_deg.as_ref().map(Spanned::span),
            turn,
        ),
    ];
    for (key, span, applies) in wrong {
        if let Some(span) = span.filter(|_| !applies) {
            return fault(
                span,
                format!("{key} does not apply to a track that sees a {said}"),
            );
        }
    }
    Ok(sees)
}

fn shows(sees: Sees) -> [bool; 2] {
    match sees {
        Sees::Pose => [true, true],
        Sees::Point => [true, false],
        Sees::Orientation | Sees::Direction(_) => [false, true],
    }
}

/// The place of a named point feature, or of the centre of mass.
fn at_point(
    text: &Text,
    features: &[Feature],
    tracker: Option<&Spanned<RawTracker>>,
) -> Result<Pose, Fault> {
    if let Some(tracker) = tracker {
        return fault(tracker.span(), "tracker beside point, expected one of them");
    }
    let place_m = if text.get_ref() == "centre" {
        Vector3::zeros()
    } else {
        let names = features.iter().map(|feature| feature.name.as_str());
        let named = index_of("point", text, names.chain(["centre"]))?;
        features[named].geometry.place_m()
    };
    Ok(Pose::from_parts(place_m.into(), UnitQuaternion::identity()))
}

fn weighing(spanned: &Spanned<RawTrack>, sees: Sees, weights: &Weights) -> Result<Weighing, Fault> {
    let track = spanned.get_ref();
    let own = [&track.position_sd_mm, &track.orientation_sd_deg];
    match &track.weights {
        Some(text) if text.get_ref() == "messages" => {
            if let Some(number) = own.into_iter().flatten().next() {
                return fault(
                    number.span(),
                    "a weight of the track beside those of its messages, expected one of them",
                );
            }
            if let Sees::Direction(_) = sees {
                return fault(
                    text.span(),
                    "messages say nothing of how good a direction is",
                );
            }
            return Ok(Weighing::Messages);
        }
        Some(text) => {
            return fault(
                text.span(),
                format!("weights are {:?}, expected \"messages\"", text.get_ref()),
            );
        }
        None => {}
    }
    if own.iter().all(|number| number.is_none()) {
        return Ok(Weighing::Scene);
    }
    let mut own_weights = *weights;
    if let Some(number) = &track.position_sd_mm {
        own_weights.position_m = positive("position_sd_mm", number)? / 1e3;
    }
    if let Some(number) = &track.orientation_sd_deg {
        own_weights.orientation_rad = positive("orientation_sd_deg", number)?.to_radians();
    }
    Ok(Weighing::Own(own_weights))
}
