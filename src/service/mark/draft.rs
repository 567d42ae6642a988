//! A scene that is being made: the text of one with events and phases added, which is read back each time.

use std::fmt::Write;

use crate::config::scene_from_toml;
use crate::motion::{EventKind, Mark, Scene, SeenMotion, SeenPhase, Stamp};
use crate::pipeline::SeenTake;

/// An event of the scene is where a phase begins or ends if it is so near, and one that is added \[ns\].
const NEAR_NS: u64 = 100_000_000;
const SAME_NS: u64 = 20_000_000;
/// Frictions of what slides and what rolls where nothing tells them.
const FRICTIONS: [f64; 2] = [0.3, 0.01];

/// An event of the scene that is being made.
#[derive(Clone, Debug)]
struct DraftEvent {
    name: String,
    kind: EventKind,
    /// When it is, where that is known.
    stamp: Option<Stamp>,
    /// What is added for it, and the event before which.
    added: Option<[String; 2]>,
}

/// A scene that is being made.
#[derive(Clone, Debug)]
pub(super) struct SceneDraft {
    pub(super) text: String,
    /// In the order of the text.
    events: Vec<DraftEvent>,
    /// The phases that are added.
    phases: String,
    /// Names that are taken.
    names: Vec<String>,
    /// Marks of the events that phases begin and end at.
    pub(super) marks: Vec<Mark>,
}

impl SceneDraft {
    pub(super) fn new(scene: &Scene, text: &str, seen: &SeenTake, proposed: &[Mark]) -> Self {
        let events = scene.events.iter().map(|event| {
            let is_its = |mark: &&Mark| mark.event.as_ref() == Some(&event.name);
            let mut all = seen.marks.iter().chain(proposed);
            let stamp = match event.kind {
                EventKind::Start => Some(Stamp(i64::MIN)),
                EventKind::End => Some(Stamp(i64::MAX)),
                _ => all.find(is_its).map(|mark| mark.stamp),
            };
            DraftEvent {
                name: event.name.clone(),
                kind: event.kind.clone(),
                stamp,
                added: None,
            }
        });
        let links = scene.links.iter().map(|of| &of.name);
        let names = links
            .chain(scene.surfaces.iter().map(|of| &of.name))
            .chain(scene.phases.iter().map(|of| &of.name))
            .chain(scene.events.iter().map(|of| &of.name));
        Self {
            text: text.to_owned(),
            names: names.cloned().collect(),
            events: events.collect(),
            phases: String::new(),
            marks: Vec::new(),
        }
    }

    /// The same with a phase of that name; the reason where no scene may say it. `follows`: another phase ends where it begins.
    pub(super) fn with(
        &self,
        scene: &Scene,
        of: &SeenPhase,
        follows: bool,
        next: Option<&SeenPhase>,
    ) -> Result<(Self, String), String> {
        let mut more = self.clone();
        let body = &scene.links[of.link].name;
        let from = match of.is_at_end[0] {
            true => more.edge(EventKind::Start, of.from)?,
            false => more.event(scene, of, of.from, None, |draft| match of.motion {
                SeenMotion::On(on) if !follows => {
                    let surface = &scene.surfaces[on.surface].name;
                    let mut keys = format!("surface = {surface:?}\n");
                    if is_face(scene, of) {
                        let feature = &scene.links[of.link].features[on.feature].name;
                        let _ = writeln!(keys, "feature = {feature:?}");
                    }
                    keys += &without_rebound(scene, body);
                    (draft.free_name("landing", body), "collision", keys)
                }
                _ => (draft.free_name(begins(of), body), "change", String::new()),
            })?,
        };
        let until = match of.is_at_end[1] {
            true => more.edge(EventKind::End, of.until)?,
            false => more.event(scene, of, of.until, Some(&from), |draft| {
                let name = match (next, of.motion) {
                    (Some(next), _) => begins(next),
                    (None, SeenMotion::InHand | SeenMotion::With(_) | SeenMotion::Still) => {
                        "let go"
                    }
                    (None, SeenMotion::On(_) | SeenMotion::Tumble) => "off",
                };
                (draft.free_name(name, body), "change", String::new())
            })?,
        };
        let name = more.free_name(called(of), body);
        more.names.push(name.clone());
        let phase = more.phase(scene, of, &name, [&from, &until]);
        more.phases += &phase;
        if !more.text.ends_with("\n\n") {
            more.text += "\n";
        }
        more.text += &phase;
        match scene_from_toml(&more.text) {
            Ok(_) => Ok((more, name)),
            Err(error) => Err(error.message),
        }
    }

    /// The start or the end.
    fn edge(&mut self, kind: EventKind, stamp: Stamp) -> Result<String, String> {
        match self.events.iter().find(|event| event.kind == kind) {
            Some(event) => {
                let name = event.name.clone();
                self.mark(&name, stamp);
                Ok(name)
            }
            None => {
                let name = kind.as_str();
                Err(format!("the scene has no event of kind {name:?}"))
            }
        }
    }

    /// The event at which a phase may begin or end that is near, but not the one that is another already, or one that is added: its name,
    /// its kind and its other keys.
    fn event(
        &mut self,
        scene: &Scene,
        of: &SeenPhase,
        stamp: Stamp,
        other: Option<&String>,
        add: impl Fn(&Self) -> (String, &'static str, String),
    ) -> Result<String, String> {
        let link = of.link;
        let may_hit = of.motion != SeenMotion::Tumble;
        let concerns = |event: &&DraftEvent| match &event.kind {
            EventKind::Collision(of) => may_hit && of.links().any(|other| other == link),
            EventKind::Change(of) => *of == link,
            _ => false,
        };
        let apart_ns = |event: &DraftEvent| event.stamp.map(|of| of.0.abs_diff(stamp.0));
        let near = self.events.iter().filter(concerns);
        let near = near.filter(|event| {
            let most_ns = match event.added {
                Some(_) => SAME_NS,
                None => NEAR_NS,
            };
            apart_ns(event).is_some_and(|apart| apart <= most_ns) && other != Some(&event.name)
        });
        if let Some(event) = near.min_by_key(|event| apart_ns(event)) {
            let name = event.name.clone();
            self.mark(&name, stamp);
            return Ok(name);
        }
        let (name, kind, keys) = add(self);
        let body = &scene.links[link].name;
        let block =
            format!("[[event]]\nname = {name:?}\nkind = {kind:?}\nbody = {body:?}\n{keys}\n");
        let is_later = |event: &DraftEvent| event.stamp.is_some_and(|of| of > stamp);
        let at = self
            .events
            .iter()
            .position(is_later)
            .unwrap_or(self.events.len());
        let heads = heads(&self.text);
        if heads.len() != self.events.len() {
            return Err("its events are not all under [[event]]".into());
        }
        match heads.get(at) {
            Some(head) => self.text.insert_str(*head, &block),
            None => {
                self.text += "\n";
                self.text += &block;
            }
        }
        let mut later = self.events[at..]
            .iter()
            .filter(|event| event.added.is_none());
        let before = later
            .next()
            .map_or_else(String::new, |event| event.name.clone());
        self.events.insert(
            at,
            DraftEvent {
                name: name.clone(),
                kind: EventKind::Change(link),
                stamp: Some(stamp),
                added: Some([block, before]),
            },
        );
        self.names.push(name.clone());
        self.mark(&name, stamp);
        Ok(name)
    }

    fn mark(&mut self, event: &str, stamp: Stamp) {
        let event = Some(event.to_owned());
        if !self.marks.iter().any(|mark| mark.event == event) {
            self.marks.push(Mark { stamp, event });
        }
    }

    fn free_name(&self, wanted: &str, body: &str) -> String {
        let numbered = (2..).map(|number| format!("{wanted} {number}"));
        let names = [wanted.to_owned(), format!("{wanted} {body}")].into_iter();
        let mut names = names.chain(numbered);
        let free = names.find(|name| !self.names.contains(name));
        free.unwrap_or_default()
    }

    fn phase(&self, scene: &Scene, of: &SeenPhase, name: &str, ends: [&str; 2]) -> String {
        let link = &scene.links[of.link];
        let mut text = format!("[[phase]]\nname = {name:?}\n");
        let mut free = String::new();
        match of.motion {
            SeenMotion::On(on) => {
                let surface = &scene.surfaces[on.surface].name;
                let motion = on.sustained.as_str();
                let _ = write!(
                    text,
                    "motion = {motion:?}\nbody = {:?}\nsurface = {surface:?}\n",
                    link.name
                );
                if !is_ball(scene, of) {
                    let _ = writeln!(text, "feature = {:?}", link.features[on.feature].name);
                }
                let own = format!("{}.friction", link.name);
                let is_slide = motion == "slide";
                let mut laws = scene.contact_laws.iter();
                let has_own =
                    is_slide && laws.any(|law| law.name == link.name && law.friction > 0.0);
                let is_free = scene.parameters.iter().any(|of| of.name == own)
                    || self.text.contains(&format!("quantity = {own:?}"));
                // Its impacts have the same.
                if has_own && !is_free && on.friction.is_some() {
                    let _ = write!(free, "\n[[free]]\nquantity = {own:?}\n");
                }
                if motion != "rest" && !has_own {
                    let usual = FRICTIONS[usize::from(!is_slide)];
                    let friction = on.friction.unwrap_or(usual);
                    let _ = writeln!(text, "friction = {}", digits(friction));
                    if on.friction.is_some() {
                        let quantity = format!("{name}.friction");
                        let _ = write!(free, "\n[[free]]\nquantity = {quantity:?}\n");
                    }
                }
            }
            SeenMotion::Still => {
                let _ = write!(text, "motion = \"rest\"\nbody = {:?}\n", link.name);
            }
            SeenMotion::With(_) | SeenMotion::InHand => {
                let _ = write!(text, "motion = \"held\"\nbody = {:?}\n", link.name);
            }
            SeenMotion::Tumble => {
                let _ = write!(text, "motion = \"tumble\"\nbody = {:?}\n", link.name);
            }
        }
        let _ = writeln!(text, "from = {:?}\nuntil = {:?}", ends[0], ends[1]);
        text + &free + "\n"
    }

    /// What is to be put into the scene.
    pub(super) fn fragment(&self) -> String {
        let mut text = String::new();
        let mut place = None;
        for [block, before] in self.events.iter().filter_map(|event| event.added.as_ref()) {
            if place.replace(before) != Some(before) {
                match before.as_str() {
                    "" => text += "# after all [[event]]\n",
                    name => {
                        let _ = writeln!(text, "# before the [[event]] {name:?}");
                    }
                }
            }
            text += block;
        }
        if place.is_some() {
            text += "# at the end\n";
        }
        text += self.phases.trim_end();
        text + "\n"
    }
}

/// Where the tables of events begin in the text of a scene.
fn heads(text: &str) -> Vec<usize> {
    let mut at = 0;
    let mut found = Vec::new();
    for line in text.split_inclusive('\n') {
        if line.trim_start().starts_with("[[event]]") {
            found.push(at);
        }
        at += line.len();
    }
    found
}

/// What an event is called at which that begins.
fn begins(of: &SeenPhase) -> &'static str {
    match of.motion {
        SeenMotion::On(on) => match on.sustained.as_str() {
            "slide" => "slides",
            "roll" => "no slip",
            _ => "still",
        },
        SeenMotion::Still => "held still",
        SeenMotion::With(_) | SeenMotion::InHand => "taken",
        SeenMotion::Tumble => "tumbles",
    }
}

/// What a phase is called.
fn called(of: &SeenPhase) -> &'static str {
    match of.motion {
        SeenMotion::On(on) => match on.sustained.as_str() {
            "slide" => "sliding",
            "roll" => "rolling",
            _ => "resting",
        },
        SeenMotion::Still => "kept",
        SeenMotion::With(_) | SeenMotion::InHand => "carried",
        SeenMotion::Tumble => "tumbling",
    }
}

fn feature_kind(scene: &Scene, of: &SeenPhase) -> &'static str {
    match of.motion {
        SeenMotion::On(on) => scene.links[of.link].features[on.feature].geometry.kind(),
        SeenMotion::Still | SeenMotion::With(_) | SeenMotion::InHand | SeenMotion::Tumble => "",
    }
}

fn is_face(scene: &Scene, of: &SeenPhase) -> bool {
    feature_kind(scene, of) == "face"
}

fn is_ball(scene: &Scene, of: &SeenPhase) -> bool {
    feature_kind(scene, of) == "point"
}

/// The keys of an event at which a body hits something and does not rebound.
fn without_rebound(scene: &Scene, body: &str) -> String {
    match scene.contact_laws.iter().find(|law| law.name == body) {
        Some(law) if law.restitution == 0.0 => String::new(),
        Some(law) if law.friction > 0.0 => {
            format!("restitution = 0.0\nfriction = {}\n", digits(law.friction))
        }
        _ => "restitution = 0.0\n".to_owned(),
    }
}

/// A number to two digits.
fn digits(number: f64) -> String {
    let size = 10_f64.powf(number.abs().log10().floor() - 1.0);
    let places = (-size.log10()).clamp(1.0, 6.0).round() as usize;
    format!("{:.places$}", (number / size).round() * size)
}
