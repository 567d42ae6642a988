//! What a scene means, for people who wrote it.

use serde::Serialize;

use crate::motion::{
    Collision, EventKind, LinkIndex, Partner, Scene, Sees, SupportPhase, Timing, Track,
};

/// What a scene means: what moves, what is expected on which topics, what each mark stands for, and what is
/// missing.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneCheck {
    /// Name of the scene.
    pub scene: String,
    /// `tempo`, `physical` or `edited`.
    pub stamps: &'static str,
    /// What moves.
    pub bodies: Vec<BodyCheck>,
    /// What is expected in a recording.
    pub topics: Vec<TopicCheck>,
    /// What happens, in the order of the marks.
    pub events: Vec<EventCheck>,
    /// What is estimated beside the motion.
    pub free: Vec<String>,
    /// What is not given, and what is made of that.
    pub open: Vec<String>,
    /// What is needed for an estimate and is not there.
    pub missing: Vec<String>,
}

/// A body.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BodyCheck {
    /// Its name.
    pub name: String,
    /// Whether it is in the hand.
    pub held: bool,
    /// Its mass; none of a held body.
    pub mass_g: Option<f64>,
    /// Its centre of mass, in the frame in which it is given.
    pub centre_mm: [f64; 3],
    /// Its principal moments; none of a held body.
    pub moments_kg_m2: Option<[f64; 3]>,
    /// By how much its principal axes are turned from those in which it is given.
    pub turn_deg: f64,
    /// How they are turned: given from principal.
    pub orientation_wxyz: [f64; 4],
    /// Names of what may touch something.
    pub features: Vec<String>,
}

/// A topic.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TopicCheck {
    /// Its name.
    pub topic: String,
    /// What is on it.
    pub carries: String,
}

/// An event.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EventCheck {
    /// Its name.
    pub name: String,
    /// `start`, `collision`, `change`, `waypoint` or `end`.
    pub kind: &'static str,
    /// What the mark of it says.
    pub means: String,
    /// Least and greatest number of marks.
    pub marks: [usize; 2],
    /// Number of goals there.
    pub goals: usize,
}

/// What a scene means.
pub fn check_scene(scene: &Scene) -> SceneCheck {
    let is_edited = scene.timing == Timing::Edited;
    let events: Vec<EventCheck> = (0..scene.events.len()).map(|at| event(scene, at)).collect();
    let (mut open, mut missing) = (Vec::new(), Vec::new());
    for (names, count) in inferred(scene) {
        match count {
            0 => missing.push(format!(
                "nothing can touch at {names}: no feature of the body and surface that may meet, expected features_mm, [[body.face]] or [[surface]]"
            )),
            1 => {}
            count => open.push(format!(
                "what touches at {names} is inferred among {count}: name feature and surface where you know them"
            )),
        }
    }
    for (link, of) in scene.links.iter_enumerated() {
        let is_met = scene.events.iter().any(|event| concerns(&event.kind, link))
            || scene.phases.iter().any(|phase| phase.link == link);
        if !is_met && !scene.is_held(link) && scene.events.len() > 1 {
            open.push(format!(
                "{:?} takes part in no collision: it only flies",
                of.name
            ));
        }
        let mut tracks = scene.tracks.iter().filter(|track| track.link == link);
        let at_origin = |track: &Track| {
            let given = of.given_from(&track.link_from_tracker);
            matches!(track.sees, Sees::Pose)
                && given.translation.vector.norm() < 1e-9
                && given.rotation.angle() < 1e-9
        };
        if tracks.any(at_origin) {
            open.push(format!(
                "the tracker of {:?} is taken to be at its origin, along its axes: set body.tracker if it is elsewhere",
                of.name
            ));
        }
    }
    if scene.events.is_empty() && !is_edited {
        open.push("no events: the motion is one flight, from the first sample to the last".into());
    }
    let last = scene.events.last();
    if last.is_some_and(|event| event.kind != EventKind::End) {
        open.push("no end: the motion ends with the last sample".into());
    }
    let used = |surface: usize| {
        let collisions = scene
            .events
            .iter()
            .filter_map(|event| event.kind.collision());
        let mut worlds = collisions.filter(|of| of.partner == Partner::World);
        let mut phases = scene.phases.iter();
        phases.any(|phase| phase.on_surface().is_some_and(|on| on.surface == surface))
            || worlds.any(|of| {
                let mut contacts = of.contacts.iter();
                contacts.any(|touching| touching.other.is_none_or(|other| other == surface))
            })
    };
    for (index, surface) in scene.surfaces.iter().enumerate() {
        if !used(index) && surface.obstacle.is_none() {
            open.push(format!("nothing touches {:?} before the end", surface.name));
        }
    }
    SceneCheck {
        scene: scene.name.clone(),
        stamps: match scene.timing {
            Timing::Known => "physical",
            Timing::Edited => "edited",
            Timing::Unknown { .. } => "tempo",
        },
        bodies: scene.links.keys().map(|link| body(scene, link)).collect(),
        topics: topics(scene),
        events,
        free: scene.parameters.iter().map(|of| of.name.clone()).collect(),
        open,
        missing,
    }
}

/// Events of which it is inferred what touches, with the number of candidates; those with as many together.
fn inferred(scene: &Scene) -> Vec<(String, usize)> {
    // A repeated collision is as many as it is at least.
    let written = scene.with_marks(0);
    let mut found: Vec<(String, usize)> = Vec::new();
    for at in written.open_events() {
        let name = format!("{:?}", written.events[at].name);
        let count = written.candidates(at).len();
        match found.iter_mut().find(|(_, other)| *other == count) {
            Some((names, _)) => {
                *names += ", ";
                *names += &name;
            }
            None => found.push((name, count)),
        }
    }
    found
}

fn concerns(kind: &EventKind, link: LinkIndex) -> bool {
    let of_collision = |of: &Collision| of.links().any(|other| other == link);
    match kind {
        EventKind::Collisions { each, .. } => of_collision(each),
        other => other.collision().is_some_and(of_collision),
    }
}

fn body(scene: &Scene, link: LinkIndex) -> BodyCheck {
    let of = &scene.links[link];
    let given_from_link = of.link_from_given.inverse();
    let q = given_from_link.rotation.quaternion();
    let is_held = of.held.is_some();
    // Rounding of computed centres is no place.
    let plain = |m: f64| {
        let nanometres = (m * 1e9).round() / 1e6;
        if nanometres == 0.0 { 0.0 } else { nanometres }
    };
    BodyCheck {
        name: of.name.clone(),
        held: is_held,
        mass_g: (!is_held).then(|| of.body.mass_kg() * 1e3),
        centre_mm: given_from_link.translation.vector.map(plain).into(),
        moments_kg_m2: (!is_held).then(|| of.body.moments_kg_m2().into()),
        turn_deg: given_from_link.rotation.angle().to_degrees(),
        orientation_wxyz: [q.w, q.i, q.j, q.k],
        features: of.features.iter().map(|of| of.name.clone()).collect(),
    }
}

fn topics(scene: &Scene) -> Vec<TopicCheck> {
    let mut topics = Vec::new();
    for (track, of) in scene.tracks.iter_enumerated() {
        let link = &scene.links[of.link].name;
        let sees = match of.sees {
            Sees::Pose => "poses".to_owned(),
            Sees::Point => "places of a point".to_owned(),
            Sees::Orientation => "orientations".to_owned(),
            Sees::Direction(_) => "directions of an axis".to_owned(),
        };
        let streams = scene.streams(track);
        for stream in 0..streams {
            let flight = match streams {
                1 => String::new(),
                _ => format!(", flight {}", stream + 1),
            };
            topics.push(TopicCheck {
                topic: scene.stream_topic(track, stream),
                carries: format!("{sees} of {link}{flight}"),
            });
        }
    }
    if scene.timing != Timing::Edited {
        topics.push(TopicCheck {
            topic: scene.marks_topic.clone(),
            carries: "marks".into(),
        });
    }
    topics
}

fn event(scene: &Scene, at: usize) -> EventCheck {
    let event = &scene.events[at];
    let time = match (scene.timing, scene.time_is_free(at)) {
        (Timing::Edited, _) => "no mark: the flights say it",
        (_, true) => "its time is estimated near the mark",
        (_, false) => "its time is that of the mark",
    };
    let (what, marks) = match &event.kind {
        EventKind::Start => ("the motion begins".to_owned(), [1, 1]),
        EventKind::End => ("the motion ends".to_owned(), [1, 1]),
        EventKind::Change(link) => (change(scene, *link, at), [1, 1]),
        EventKind::Waypoint(link) => (format!("{} flies by", scene.links[*link].name), [1, 1]),
        EventKind::Collision(of) => (collision(scene, of), [1, 1]),
        EventKind::Collisions { each, least, most } => (collision(scene, each), [*least, *most]),
    };
    EventCheck {
        name: event.name.clone(),
        kind: event.kind.as_str(),
        means: format!("{what}; {time}"),
        marks: if scene.timing == Timing::Edited {
            [0, 0]
        } else {
            marks
        },
        goals: scene.goals.iter().filter(|goal| goal.event == at).count(),
    }
}

fn change(scene: &Scene, link: LinkIndex, event: usize) -> String {
    let mechanism = scene.mechanism_of(link);
    let of = |is_after: bool| {
        let phase = scene.phase_beside(mechanism, event, is_after);
        phase.map_or("flies", SupportPhase::verb)
    };
    let name = &scene.links[link].name;
    if let Some(pair) = scene.stuck_at(event) {
        let [one, other] = pair.links.map(|link| &scene.links[link].name);
        return format!("{one} and {other} fly as one from then on");
    }
    format!("{name}, which {}, {} from then on", of(false), of(true))
}

fn collision(scene: &Scene, of: &Collision) -> String {
    let link = &scene.links[of.link];
    let own: Vec<String> = of
        .contacts
        .iter()
        .map(|touching| match touching.feature {
            Some(feature) => link.features[feature].name.clone(),
            None => "some part".into(),
        })
        .collect();
    let other = of.contacts.first().and_then(|touching| touching.other);
    let other = match (of.partner, other) {
        (Partner::World, Some(surface)) => scene.surfaces[surface].name.clone(),
        (Partner::World, None) => "some surface".into(),
        (Partner::Link(other), Some(feature)) => {
            let other = &scene.links[other];
            format!("{} of {}", other.features[feature].name, other.name)
        }
        (Partner::Link(other), None) => format!("some part of {}", scene.links[other].name),
    };
    let law = scene.law_of(of);
    let friction = match law.friction > 0.0 {
        true => format!(", friction {}", law.friction),
        false => String::new(),
    };
    let tangential = match law.tangential_restitution > 0.0 {
        true => format!(", tangential restitution {}", law.tangential_restitution),
        false => String::new(),
    };
    format!(
        "{} of {} hits {other}, restitution {}{friction}{tangential}",
        own.join(", "),
        link.name,
        law.restitution
    )
}
