//! What happens: starts, collisions, changes of phase, waypoints, ends.

use crate::motion::index::{ContactLawIndex, LinkIndex};

/// Something that happens at one instant and is marked by the performer.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// Unique name; marks may refer to it.
    pub name: String,
    /// What happens.
    pub kind: EventKind,
    /// What is known of its time.
    pub time: EventTime,
}

impl Event {
    /// An event of whose time nothing is known but its mark.
    pub fn new(name: impl Into<String>, kind: EventKind) -> Self {
        Self {
            name: name.into(),
            kind,
            time: EventTime::default(),
        }
    }
}

/// What is known of the time of an event, beside its mark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EventTime {
    /// Whether it is estimated; `None`: as [`Scene::time_is_free`](super::Scene::time_is_free) says
    /// of its kind.
    pub is_free: Option<bool>,
    /// Standard deviation of its mark, in acted time \[s\]; `None`: that of the scene's marks.
    pub mark_sd_s: Option<f64>,
    /// Earliest and latest time, in acted time after the mark \[s\]; infinite where unbounded.
    pub window_s: [f64; 2],
}

impl EventTime {
    /// Whether it has an earliest or a latest time.
    pub fn is_bounded(&self) -> bool {
        self.window_s.iter().any(|bound_s| bound_s.is_finite())
    }
}

impl Default for EventTime {
    fn default() -> Self {
        Self {
            is_free: None,
            mark_sd_s: None,
            window_s: [f64::NEG_INFINITY, f64::INFINITY],
        }
    }
}

/// The kinds of event.
#[derive(Clone, Debug, PartialEq)]
pub enum EventKind {
    /// The performance begins; samples before it are not used. Only as the first event.
    Start,
    /// A body hits something.
    Collision(Collision),
    /// A collision that repeats as often as there are marks; each becomes an event of its own
    /// before a take is read ([`with_marks`](super::Scene::with_marks)).
    Collisions {
        /// Each of the collisions.
        each: Collision,
        /// Least number, one or more.
        least: usize,
        /// Greatest number.
        most: usize,
    },
    /// A phase of a body ends or begins without an impact: what slides begins to roll, or comes to rest.
    Change(LinkIndex),
    /// A moment of a flight, which goes on unchanged: goals hold there. It costs one unknown, its time,
    /// which stays within the flight.
    ///
    /// A flight has a closed form, or a flow that is exact to rounding, from any of its moments: to split
    /// it there would add a state and as many rows that say it is the same one.
    Waypoint(LinkIndex),
    /// The performance ends; samples after it are not used. Only as the last event.
    End,
}

impl EventKind {
    /// Its name in files and reports.
    pub fn as_str(&self) -> &'static str {
        match self {
            EventKind::Start => "start",
            EventKind::Collision(_) | EventKind::Collisions { .. } => "collision",
            EventKind::Change(_) => "change",
            EventKind::Waypoint(_) => "waypoint",
            EventKind::End => "end",
        }
    }

    /// What flies through it, if it is a waypoint.
    pub fn waypoint(&self) -> Option<LinkIndex> {
        match self {
            EventKind::Waypoint(link) => Some(*link),
            _ => None,
        }
    }

    /// Whose phase changes there, if it is a change.
    pub fn change(&self) -> Option<LinkIndex> {
        match self {
            EventKind::Change(link) => Some(*link),
            _ => None,
        }
    }

    /// The collision, if it is one.
    pub fn collision(&self) -> Option<&Collision> {
        match self {
            EventKind::Collision(collision) => Some(collision),
            EventKind::Start
            | EventKind::Collisions { .. }
            | EventKind::Change(_)
            | EventKind::Waypoint(_)
            | EventKind::End => None,
        }
    }
}

/// A link hits the static world or a link of another mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct Collision {
    /// What hits something.
    pub link: LinkIndex,
    /// What it hits.
    pub partner: Partner,
    /// Their contacts, one to three at once.
    pub contacts: Vec<Touching>,
    /// Restitution and friction, which other collisions may share.
    pub law: ContactLawIndex,
    /// Tilt of the normal that the impact sees \[rad\], about two tangents: see
    /// [`Law::tilt_rad`](crate::physics::impact::Law::tilt_rad).
    pub tilt_rad: [f64; 2],
}

impl Collision {
    /// A bounce of one feature off one surface.
    pub fn bounce(link: LinkIndex, feature: usize, surface: usize, law: ContactLawIndex) -> Self {
        Self {
            link,
            partner: Partner::World,
            contacts: vec![Touching {
                feature: Some(feature),
                other: Some(surface),
            }],
            law,
            tilt_rad: [0.0; 2],
        }
    }

    /// The links that touch in it.
    pub fn links(&self) -> impl Iterator<Item = LinkIndex> + use<> {
        let other = match self.partner {
            Partner::World => None,
            Partner::Link(other) => Some(other),
        };
        [self.link].into_iter().chain(other)
    }
}

/// What a link hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partner {
    /// The static world.
    World,
    /// Another link.
    Link(LinkIndex),
}

/// Which feature touches which; what a scene leaves open is inferred from the performance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Touching {
    /// Index into the body's features.
    pub feature: Option<usize>,
    /// Index into `Scene::surfaces`, or into the other body's features.
    pub other: Option<usize>,
}
