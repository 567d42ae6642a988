//! What speaks against a motion whose gaps are closed: a measured value beyond its bound.

use super::index::{LinkIndex, MechanismIndex};
use super::scene::{Against, Scene};
use super::verdict::Verdict;

/// One thing that speaks against a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Doubt {
    /// What was measured.
    pub about: About,
    /// Where.
    pub place: Place,
    /// What it is, in the unit of `about`; infinite where the performance does not determine it.
    pub value: f64,
    /// What it may be, in the same unit.
    pub bound: f64,
}

/// What is measured of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    /// How deep a solid is inside another.
    Overlap,
    /// How much nearer another part is than the one that is expected to touch.
    WrongFeature,
    /// Speed of a body's fastest point.
    Speed,
    /// Angular speed.
    Spin,
    /// Way of a flight over the way that was acted.
    Way,
    /// Acted over physical duration: at most.
    Slowness,
    /// Physical over acted duration: at most.
    Haste,
    /// Root mean square residual of a flight, in units of the scene's weights.
    Residual,
    /// Root mean square angle of a flight's orientations from those acted.
    Orientation,
    /// Root mean square of what free flights alone leave, in units of the scene's weights.
    Alone,
    /// Root mean square of what the motion leaves, over that of each flight alone.
    Misfit,
    /// Root mean square of what free flights leave, over that of flights whose acceleration is free.
    Fall,
    /// Angle between gravity and the acceleration that the flights show.
    FallDirection,
    /// How much later than its mark an event is, in acted time.
    AfterMark,
    /// How much earlier than its mark an event is, in acted time.
    BeforeMark,
    /// How far an estimated gravity is from the scene's, as a part of that.
    Gravity,
    /// Standard deviation of an estimated gravity, as a part of the scene's.
    GravitySpread,
    /// How far beyond the end of a flight a sample is that is compared with it.
    Outside,
    /// A parameter at the end of its range.
    AtBound,
    /// Root mean square residual of the whole, in units of the scene's weights, beyond which several
    /// motions may fit.
    Ambiguity,
}

impl About {
    /// The word for it in files and reports.
    pub fn as_str(self) -> &'static str {
        match self {
            About::Overlap => "overlap",
            About::WrongFeature => "wrong_feature",
            About::Speed => "speed",
            About::Spin => "spin",
            About::Way => "way",
            About::Slowness => "slowness",
            About::Haste => "haste",
            About::Residual => "residual",
            About::Orientation => "orientation",
            About::Alone => "alone",
            About::Misfit => "misfit",
            About::Fall => "fall",
            About::FallDirection => "fall_direction",
            About::AfterMark => "after_mark",
            About::BeforeMark => "before_mark",
            About::Gravity => "gravity",
            About::GravitySpread => "gravity_spread",
            About::Outside => "outside",
            About::AtBound => "at_bound",
            About::Ambiguity => "ambiguity",
        }
    }

    /// Its unit; empty for ratios, and for a parameter, which has its own.
    pub fn unit(self) -> &'static str {
        match self {
            About::Overlap | About::WrongFeature => "m",
            About::Speed => "m/s",
            About::Spin => "rad/s",
            About::Orientation | About::FallDirection => "rad",
            About::AfterMark | About::BeforeMark | About::Outside => "s",
            About::Way
            | About::Slowness
            | About::Haste
            | About::Residual
            | About::Alone
            | About::Misfit
            | About::Fall
            | About::Gravity
            | About::GravitySpread
            | About::AtBound
            | About::Ambiguity => "",
        }
    }

    /// The best verdict that it leaves: `physical` where it is only to be said, `failed` where no
    /// hand does such a thing.
    pub fn best(self) -> Verdict {
        match self {
            About::Outside | About::AtBound | About::Ambiguity => Verdict::Physical,
            About::Overlap
            | About::WrongFeature
            | About::Residual
            | About::Orientation
            | About::Alone
            | About::Misfit
            | About::Fall
            | About::FallDirection
            | About::AfterMark
            | About::BeforeMark
            | About::Gravity
            | About::GravitySpread => Verdict::Plausible,
            About::Speed | About::Spin | About::Way | About::Slowness | About::Haste => {
                Verdict::Failed
            }
        }
    }
}

/// Where of a motion.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// All of it.
    Motion,
    /// One flight.
    Flight {
        /// What flies.
        mechanism: MechanismIndex,
        /// When it begins \[s\].
        start_s: f64,
    },
    /// An event (index into `Scene::events`).
    Event(usize),
    /// A free parameter (index into `Scene::parameters`).
    Parameter(usize),
    /// A link inside of something.
    Inside {
        /// The link.
        link: LinkIndex,
        /// What it is inside of.
        against: Against,
        /// When \[s\].
        time_s: f64,
    },
    /// A link's parts at a collision.
    Touch {
        /// Index into `Scene::events`.
        event: usize,
        /// The link.
        link: LinkIndex,
        /// What should touch (indices into `Link::features`).
        expected: Vec<usize>,
        /// What is nearer, if the scene names it.
        found: Option<usize>,
    },
}

impl Place {
    /// The scene's name for it; `None` for all of the motion.
    pub fn name<'a>(&self, scene: &'a Scene) -> Option<&'a str> {
        match self {
            Place::Motion => None,
            Place::Flight { mechanism, .. } => Some(scene.name_of_mechanism(*mechanism)),
            Place::Inside { link, .. } => Some(&scene.links[*link].name),
            Place::Event(event) | Place::Touch { event, .. } => Some(&scene.events[*event].name),
            Place::Parameter(parameter) => Some(&scene.parameters[*parameter].name),
        }
    }

    /// When it is, where it is at one time: the beginning of a flight \[s\].
    pub fn time_s(&self) -> Option<f64> {
        match self {
            Place::Flight {
                start_s: time_s, ..
            }
            | Place::Inside { time_s, .. } => Some(*time_s),
            Place::Motion | Place::Event(_) | Place::Parameter(_) | Place::Touch { .. } => None,
        }
    }
}

impl Doubt {
    /// A doubt where the value is beyond its bound; `None` elsewhere. A value that is no number is
    /// beyond all bounds.
    pub fn beyond(about: About, place: Place, value: f64, bound: f64) -> Option<Self> {
        (!(value <= bound)).then_some(Self {
            about,
            place,
            value,
            bound,
        })
    }
}
