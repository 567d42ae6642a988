//! Events.

use crate::config::spanned::Spanned;

use super::error::{Fault, fault};
use super::free_flight;
use super::held::check_collision;
use super::law::{self, BodyLaws, Laws};
use super::number::{Taken, finite, index_of, name, positive};
use super::raw::{Number, RawCount, RawEvent, Text};
use crate::motion::{
    Collision, ContactLawIndex, Event, EventKind, EventTime, Link, LinkIndex, Partner, Scene,
    Timing, Touching,
};

/// The events of a scene whose bodies and surfaces are known, in order: a start only first, an end
/// only last. Appends the laws of those that have their own.
pub(super) fn events(
    raw: &[Spanned<RawEvent>],
    scene: &Scene,
    of_links: &BodyLaws,
    laws: &mut Laws,
) -> Result<Vec<Event>, Fault> {
    let mut events: Vec<Event> = Vec::new();
    let mut taken = Taken::default();
    for (index, spanned) in raw.iter().enumerate() {
        let event = spanned.get_ref();
        let name = name("event", &event.name)?;
        taken.take("event", &event.name, &name)?;
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
            "start" => free_flight::plain(event, EventKind::Start)?,
            "end" => free_flight::plain(event, EventKind::End)?,
            "waypoint" => {
                let body = event.body.as_ref();
                let body = body.map(|text| Ok((text, link_of(text, scene)?)));
                free_flight::waypoint(event, body.transpose()?, scene)?
            }
            "change" => {
                let body = event.body.as_ref();
                let body = body.map(|text| link_of(text, scene));
                free_flight::change(event, body.transpose()?)?
            }
            "collision" => repeated(event, collision(spanned, scene, of_links, laws)?, &events)?,
            other => {
                return fault(
                    event.kind.span(),
                    format!(
                        "unknown kind of event {other:?}, expected one of start, collision, change, waypoint, end"
                    ),
                );
            }
        };
        let time = event_time(event, scene.timing)?;
        events.push(Event { name, kind, time });
    }
    Ok(events)
}

/// What is known of an event's time beside its mark.
fn event_time(event: &RawEvent, timing: Timing) -> Result<EventTime, Fault> {
    let known = [
        ("time_sd_ms", &event.time_sd_ms),
        ("earliest_ms", &event.earliest_ms),
        ("latest_ms", &event.latest_ms),
    ];
    let mut known = known
        .into_iter()
        .filter_map(|(key, number)| Some((key, number.as_ref()?)));
    let first = known.next();
    let is_free = match (&event.time, first) {
        (None, None) => None,
        (None, Some(_)) => Some(true),
        (Some(text), first) => match (text.get_ref().as_str(), first) {
            ("fixed", None) => Some(false),
            ("free", _) => Some(true),
            ("fixed", Some((key, number))) => {
                return fault(
                    number.span(),
                    format!("{key} does not apply to a fixed time, expected time = \"free\""),
                );
            }
            (other, _) => {
                return fault(
                    text.span(),
                    format!("time is {other:?}, expected \"fixed\" or \"free\""),
                );
            }
        },
    };
    if let (Timing::Edited, Some((key, number))) = (timing, first) {
        return fault(
            number.span(),
            format!("{key} is about a mark and does not apply to edited stamps"),
        );
    }
    let after_s = |what: &str, number: &Option<Number>, otherwise: f64| {
        let given = number.as_ref().map(|number| finite(what, number));
        Ok(given.transpose()?.map_or(otherwise, |ms| ms / 1e3))
    };
    let earliest_s = after_s("earliest_ms", &event.earliest_ms, f64::NEG_INFINITY)?;
    let latest_s = after_s("latest_ms", &event.latest_ms, f64::INFINITY)?;
    if let Some(latest) = event.latest_ms.as_ref().filter(|_| earliest_s >= latest_s) {
        return fault(
            latest.span(),
            format!(
                "latest_ms is {}, expected more than earliest_ms, {}: a time that is known is fixed",
                latest_s * 1e3,
                earliest_s * 1e3
            ),
        );
    }
    let sd_ms = event.time_sd_ms.as_ref();
    let sd_ms = sd_ms
        .map(|number| positive("time_sd_ms", number))
        .transpose()?;
    Ok(EventTime {
        is_free,
        mark_sd_s: sd_ms.map(|sd_ms| sd_ms / 1e3),
        window_s: [earliest_s, latest_s],
    })
}

/// Greatest number of collisions that a count may stand for.
const COUNT_MAX: usize = 1000;

/// One collision, or a repeated one that stands for as many as there are marks.
fn repeated(event: &RawEvent, each: Collision, before: &[Event]) -> Result<EventKind, Fault> {
    let Some(count) = &event.count else {
        return Ok(EventKind::Collision(each));
    };
    let (least, most) = match *count.get_ref() {
        RawCount::Exact(count) => (count, count),
        RawCount::Range([least, most]) => (least, most),
    };
    if !(1..=most).contains(&least) || most > COUNT_MAX {
        return fault(
            count.span(),
            format!("count is {least} to {most}, expected 1 to {COUNT_MAX}, the least first"),
        );
    }
    let is_repeat = |event: &Event| matches!(event.kind, EventKind::Collisions { .. });
    if before.iter().any(is_repeat) {
        return fault(
            count.span(),
            "a second count, expected one: by marks only one can be told",
        );
    }
    Ok(EventKind::Collisions { each, least, most })
}

fn collision(
    spanned: &Spanned<RawEvent>,
    scene: &Scene,
    of_links: &BodyLaws,
    laws: &mut Laws,
) -> Result<Collision, Fault> {
    let event = spanned.get_ref();
    let missing = |key: &str| Fault {
        span: spanned.span(),
        message: format!("missing key `{key}`: a collision needs body and restitution"),
    };
    let body = event.body.as_ref().ok_or_else(|| missing("body"))?;
    let link = link_of(body, scene)?;
    let other = event.other.as_ref();
    let other = other.map(|text| Ok((text, link_of(text, scene)?)));
    check_collision(body, link, other.transpose()?, scene)?;
    let (partner, other) = match (&event.surface, &event.other) {
        (Some(_), Some(other)) => {
            return fault(
                other.span(),
                "a collision is with a surface or with another body, expected one of surface, other",
            );
        }
        (Some(surface), None) => {
            let names = scene.surfaces.iter().map(|s| s.name.as_str());
            (Partner::World, Some(index_of("surface", surface, names)?))
        }
        (None, Some(text)) => {
            let other = link_of(text, scene)?;
            if other == link {
                return fault(text.span(), "a body does not collide with itself");
            }
            let feature = event.other_feature.as_ref();
            let feature = feature.map(|text| feature_of(&scene.links[other], text));
            (Partner::Link(other), feature.transpose()?)
        }
        (None, None) => (Partner::World, None),
    };
    if let (Partner::World, Some(text)) = (partner, &event.other_feature) {
        return fault(text.span(), "other_feature needs other, the body it is of");
    }
    let contacts: Vec<Touching> = features(event, &scene.links[link])?
        .into_iter()
        .map(|feature| Touching { feature, other })
        .collect();
    let mut collision = Collision {
        link,
        partner,
        contacts,
        law: ContactLawIndex::default(),
        tilt_rad: [0.0; 2],
    };
    collision.law = law::of_event(spanned, &collision, of_links, laws)?;
    let count = collision.contacts.len();
    let joined = scene.joint_tree(scene.mechanism_of(link));
    let may_lie = count == 3 && partner == Partner::World && joined.is_none();
    if count > 1 && !may_lie && laws[collision.law].friction > 0.0 {
        return fault(
            spanned.span(),
            "friction is for one contact, not for several at once",
        );
    }
    Ok(collision)
}

/// The features of `link` that touch: one, several at once, or `None` for one to be inferred.
fn features(event: &RawEvent, link: &Link) -> Result<Vec<Option<usize>>, Fault> {
    match (&event.feature, &event.features) {
        (None, None) => Ok(vec![None]),
        (Some(text), None) => Ok(vec![Some(feature_of(link, text)?)]),
        (Some(_), Some(several)) => fault(
            several.span(),
            "expected one of feature and features, not both",
        ),
        (None, Some(several)) => {
            let texts = several.get_ref();
            if !(1..=3).contains(&texts.len()) {
                return fault(
                    several.span(),
                    format!("{} features touch at once, expected 1 to 3", texts.len()),
                );
            }
            let features = texts.iter().map(|text| feature_of(link, text).map(Some));
            features.collect()
        }
    }
}

/// The link of the body that is meant.
pub(super) fn link_of(text: &Text, scene: &Scene) -> Result<LinkIndex, Fault> {
    let names = scene.links.iter().map(|link| link.name.as_str());
    index_of("body", text, names).map(LinkIndex)
}

/// The feature of a link that is meant.
pub(super) fn feature_of(link: &Link, text: &Text) -> Result<usize, Fault> {
    let names = link.features.iter().map(|f| f.name.as_str());
    index_of(&format!("feature of {:?}", link.name), text, names)
}
