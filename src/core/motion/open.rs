//! What a scene leaves open: features that touch at a collision, and how often one repeats.
//!
//! A collision that names no feature, or no surface, is open: its contacts are inferred from the
//! performance (paper §5.1). Candidates are the features that the scene declares for a link; for a
//! link without any, all features of its shape.

use std::collections::BTreeSet;

use super::index::LinkIndex;
use super::scene::{Collision, Event, EventKind, Link, Partner, Scene, Touching};

/// A choice of contacts at a collision: one [`Touching`] per contact.
pub type Contacts = Vec<Touching>;

impl Link {
    /// Features that the scene declares besides the shape's own (indices into `features`).
    pub fn declared_features(&self) -> Vec<usize> {
        let own = self.shape.features().unwrap_or_default();
        let own: BTreeSet<&str> = own.iter().map(|(name, _)| name.as_str()).collect();
        let is_declared = |index: &usize| !own.contains(self.features[*index].name.as_str());
        (0..self.features.len()).filter(is_declared).collect()
    }

    /// Candidates where a scene leaves the feature open (indices into `features`): the declared
    /// ones, or all if there are none.
    pub fn candidate_features(&self) -> Vec<usize> {
        let declared = self.declared_features();
        if declared.is_empty() {
            (0..self.features.len()).collect()
        } else {
            declared
        }
    }
}

impl Scene {
    /// Whether a collision leaves its contacts open.
    pub fn is_open(&self, event: usize) -> bool {
        let collision = self.events[event].kind.collision();
        collision.is_some_and(|collision| {
            let is_open =
                |touching: &Touching| touching.feature.is_none() || touching.other.is_none();
            collision.contacts.iter().any(is_open)
        })
    }

    /// Collisions that leave their contacts open (indices into `events`).
    pub fn open_events(&self) -> Vec<usize> {
        (0..self.events.len())
            .filter(|event| self.is_open(*event))
            .collect()
    }

    /// The candidates at an open collision that its goals permit, in the order of the features: pairs whose contact and
    /// impact are supported. Several contacts are all with the same surface.
    pub fn candidates(&self, event: usize) -> Vec<Contacts> {
        let mut candidates = self.all_candidates(event);
        candidates.retain(|contacts| self.may_touch(event, contacts));
        candidates
    }

    /// [`Scene::candidates`], whatever goals are at the collision.
    pub(super) fn all_candidates(&self, event: usize) -> Vec<Contacts> {
        let Some(collision) = self.events[event].kind.collision() else {
            return Vec::new();
        };
        let features = |given: Option<usize>, link: LinkIndex| match given {
            Some(feature) => vec![feature],
            None => self.links[link].candidate_features(),
        };
        let others = match (collision.contacts[0].other, collision.partner) {
            (Some(other), _) => vec![other],
            (None, Partner::World) => (0..self.surfaces.len()).collect(),
            (None, Partner::Link(link)) => features(None, link),
        };
        let mut choices: Vec<Contacts> = vec![Vec::new()];
        for touching in &collision.contacts {
            let features = features(touching.feature, collision.link);
            choices = choices
                .iter()
                .flat_map(|chosen| {
                    features
                        .iter()
                        .map(|f| [&chosen[..], &[touch(*f)]].concat())
                })
                .collect();
        }
        let with = |other: usize| {
            choices.iter().map(move |chosen| {
                let set = |touching: &Touching| Touching {
                    other: Some(other),
                    ..*touching
                };
                chosen.iter().map(set).collect()
            })
        };
        let all = others.into_iter().flat_map(with);
        all.filter(|contacts: &Contacts| {
            let is_new = |index: usize| !contacts[..index].contains(&contacts[index]);
            (0..contacts.len()).all(is_new)
                && matches!(self.contact_set_of(event, contacts), Ok(Some(_)))
        })
        .collect()
    }

    /// Sets the contacts of a collision, and moves goals there into contact where they nearly are.
    ///
    /// # Panics
    /// Where the event is no collision.
    pub fn set_contacts(&mut self, event: usize, contacts: &[Touching]) {
        let EventKind::Collision(collision) = &mut self.events[event].kind else {
            panic!("only collisions have contacts");
        };
        collision.contacts = contacts.to_vec();
        for goal in 0..self.goals.len() {
            if self.goals[goal].event == event {
                // A motion that does not reach these contacts is doubted.
                let _ = self.snap_to_contact(goal);
            }
        }
    }

    /// The contacts of a collision in words: `corner +x +y -z on table`; `None` where they are
    /// open.
    pub fn contact_words(&self, event: usize) -> Option<String> {
        let collision = self.events[event].kind.collision()?;
        self.words_of(event, &collision.contacts)
    }

    /// [`Scene::contact_words`] of other contacts.
    pub fn words_of(&self, event: usize, contacts: &[Touching]) -> Option<String> {
        let collision = self.events[event].kind.collision()?;
        let words = contacts.iter().map(|touching| {
            let feature = &self.links[collision.link].features[touching.feature?].name;
            let other = match collision.partner {
                Partner::World => &self.surfaces[touching.other?].name,
                Partner::Link(link) => &self.links[link].features[touching.other?].name,
            };
            Some(format!("{feature} on {other}"))
        });
        Some(words.collect::<Option<Vec<_>>>()?.join(", "))
    }

    /// Whether marks may name an event so: one of the scene's, or `bounce 2` of a repeated event `bounce`.
    pub fn has_event_named(&self, name: &str) -> bool {
        let has = |name: &str| self.events.iter().any(|event| event.name == name);
        let stem = name
            .trim_end_matches(|c: char| c.is_ascii_digit())
            .trim_end();
        has(name) || self.has_repeats() && stem.len() < name.len() && has(stem)
    }

    /// Whether a collision stands for several.
    pub fn has_repeats(&self) -> bool {
        let is_repeat = |event: &Event| matches!(event.kind, EventKind::Collisions { .. });
        self.events.iter().any(is_repeat)
    }

    /// The scene with its repeated collision written out, so that there are as many events as
    /// marks, as far as its range allows: `bounce` becomes `bounce 1`, `bounce 2`, ….
    pub fn with_marks(&self, marks: usize) -> Scene {
        let mut scene = self.clone();
        let Some((event, (each, least, most))) =
            self.events.iter().enumerate().find_map(|(index, event)| {
                let EventKind::Collisions { each, least, most } = &event.kind else {
                    return None;
                };
                Some((index, (each, *least, *most)))
            })
        else {
            return scene;
        };
        let count = (marks + 1)
            .saturating_sub(self.events.len())
            .clamp(least, most);
        let copies = (1..=count).map(|number| Event {
            name: repeat_name(&self.events[event].name, number),
            kind: EventKind::Collision(Collision::clone(each)),
            time: self.events[event].time,
        });
        scene.events.splice(event..=event, copies);
        scene.place_events(|other| {
            if other > event {
                other + count - 1
            } else {
                other
            }
        });
        scene
    }

    /// The same with one more event, at an index of `Scene::events`.
    pub fn with_event(mut self, index: usize, event: Event) -> Scene {
        self.events.insert(index, event);
        self.place_events(|other| other + usize::from(other >= index));
        self
    }

    /// Follows events that moved to other indices.
    fn place_events(&mut self, place: impl Fn(usize) -> usize + Copy) {
        for goal in &mut self.goals {
            goal.place_events(place);
        }
        for phase in &mut self.phases {
            phase.events = phase.events.map(place);
        }
        for free in &mut self.parameters {
            free.quantity = free.quantity.at_event(place);
        }
    }
}

/// Name of one of a repeated collision's events, counted from one.
pub fn repeat_name(name: &str, number: usize) -> String {
    format!("{name} {number}")
}

fn touch(feature: usize) -> Touching {
    Touching {
        feature: Some(feature),
        other: None,
    }
}
