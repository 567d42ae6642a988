//! Doubts about a motion whose gaps are closed: a measured value is beyond its bound.

use super::index::{LinkIndex, MechanismIndex};
use super::scene::{Against, Scene};
use super::verdict::Verdict;

/// One doubt about a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Doubt {
    /// The measured quantity.
    pub about: About,
    /// Its place in the motion.
    pub place: Place,
    /// Measured value, in the unit of `about`; infinite where the performance does not determine
    /// it.
    pub value: f64,
    /// Greatest accepted value, in the same unit.
    pub bound: f64,
}

/// A quantity measured of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    /// Depth of an overlap of solids.
    Overlap,
    /// Depth to which solids would overlap that are kept out of each other, and only just pass.
    KeptOut,
    /// How long before its mark the motion ends, since there it touches something of which no event tells.
    EndTouches,
    /// How much nearer another part is than the one that is expected to touch.
    WrongFeature,
    /// Speed of a body's fastest point.
    Speed,
    /// Angular speed.
    Spin,
    /// Way of a flight over the way that was acted.
    Way,
    /// Acted over physical duration.
    Slowness,
    /// Physical over acted duration.
    Haste,
    /// Root mean square residual of a flight, in units of the scene's weights.
    Residual,
    /// Root mean square angle of a flight's orientations from those acted.
    Orientation,
    /// Root mean square residual of flights fitted alone, in units of the scene's weights.
    Alone,
    /// Root mean square residual of the motion, over that of flights fitted alone.
    Misfit,
    /// Root mean square residual of free flights, over that of flights with a free acceleration.
    Fall,
    /// Angle between gravity and the acceleration that the flights show.
    FallDirection,
    /// How much later than its mark an event is, in acted time.
    AfterMark,
    /// How much earlier than its mark an event is, in acted time.
    BeforeMark,
    /// How many times as far from its samples a motion is as without its goals, which ask for another one than was
    /// acted.
    Led,
    /// Relative deviation of an estimated gravity from the scene's.
    Gravity,
    /// Standard deviation of an estimated gravity, relative to the scene's.
    GravitySpread,
    /// Time of a sample beyond the end of the flight with which it is compared.
    Outside,
    /// A parameter at the end of its range.
    AtBound,
    /// Root mean square residual of the whole motion, in units of the scene's weights; beyond its
    /// bound several motions may fit.
    Ambiguity,
    /// Root mean square residual of keyframes, in units of the scene's weights; so few poses cannot
    /// tell a rough one from a wrong motion.
    Keyframes,
    /// How many more keyframes of a flight should have times that are known.
    OpenTimes,
    /// Number of other motions that are as near to the keyframes.
    Rivals,
    /// How far the motion of joined bodies is from one integrated with steps of half the length.
    Steps,
    /// How far what hits is from touching at its impact.
    Gap,
    /// How fast what hits recedes before its impact.
    Receding,
    /// Share of its kinetic energy that a motion gains at an impact.
    Energy,
    /// Impulse by which one of several contacts pulls at an impact, of the greatest there.
    Pull,
    /// How far beyond its outline a body on a surface would have to be pressed not to tip.
    Tips,
    /// Speed of what is said to rest, or slip of what is said to roll.
    Slips,
    /// Energy per weight that what tumbles has more than when it began to: a height.
    Driven,
    /// How far what tumbles is from all that it might touch.
    Untouched,
    /// Angle by which a joint is beyond its limits.
    Limit,
    /// Angle of a body's axis from where it should point at rest.
    Rest,
}

impl About {
    /// All of them, in this order.
    pub const ALL: [Self; 37] = [
        Self::Overlap,
        Self::KeptOut,
        Self::EndTouches,
        Self::WrongFeature,
        Self::Speed,
        Self::Spin,
        Self::Way,
        Self::Slowness,
        Self::Haste,
        Self::Residual,
        Self::Orientation,
        Self::Alone,
        Self::Misfit,
        Self::Fall,
        Self::FallDirection,
        Self::AfterMark,
        Self::BeforeMark,
        Self::Led,
        Self::Gravity,
        Self::GravitySpread,
        Self::Outside,
        Self::AtBound,
        Self::Ambiguity,
        Self::Keyframes,
        Self::OpenTimes,
        Self::Rivals,
        Self::Steps,
        Self::Gap,
        Self::Receding,
        Self::Energy,
        Self::Pull,
        Self::Tips,
        Self::Slips,
        Self::Driven,
        Self::Untouched,
        Self::Limit,
        Self::Rest,
    ];

    /// Its name in files and reports.
    pub fn as_str(self) -> &'static str {
        match self {
            About::Overlap => "overlap",
            About::KeptOut => "kept_out",
            About::EndTouches => "end_touches",
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
            About::Led => "led",
            About::Gravity => "gravity",
            About::GravitySpread => "gravity_spread",
            About::Outside => "outside",
            About::AtBound => "at_bound",
            About::Ambiguity => "ambiguity",
            About::Keyframes => "keyframes",
            About::OpenTimes => "open_times",
            About::Rivals => "rivals",
            About::Steps => "steps",
            About::Gap => "gap",
            About::Receding => "receding",
            About::Energy => "energy",
            About::Pull => "pull",
            About::Tips => "tips",
            About::Slips => "slips",
            About::Driven => "driven",
            About::Untouched => "untouched",
            About::Limit => "limit",
            About::Rest => "rest",
        }
    }

    /// Its unit; empty for ratios, and for a parameter, which has its own.
    pub fn unit(self) -> &'static str {
        match self {
            About::Overlap
            | About::KeptOut
            | About::WrongFeature
            | About::Steps
            | About::Gap
            | About::Tips
            | About::Driven
            | About::Untouched => "m",
            About::Speed | About::Receding | About::Slips => "m/s",
            About::Spin => "rad/s",
            About::Orientation | About::FallDirection | About::Rest | About::Limit => "rad",
            About::EndTouches | About::AfterMark | About::BeforeMark | About::Outside => "s",
            About::Way
            | About::Slowness
            | About::Haste
            | About::Residual
            | About::Alone
            | About::Misfit
            | About::Fall
            | About::Led
            | About::Gravity
            | About::GravitySpread
            | About::AtBound
            | About::Ambiguity
            | About::Keyframes
            | About::OpenTimes
            | About::Rivals
            | About::Energy
            | About::Pull => "",
        }
    }

    /// Whether it says how far the motion is from its samples.
    pub fn is_distance(self) -> bool {
        matches!(
            self,
            About::Residual
                | About::Orientation
                | About::Alone
                | About::Misfit
                | About::Ambiguity
                | About::Keyframes
        )
    }

    /// The best verdict that it permits: `physical` where it is only reported, `failed` where no
    /// hand moves so.
    pub fn best(self) -> Verdict {
        match self {
            About::KeptOut
            | About::EndTouches
            | About::Outside
            | About::AtBound
            | About::Ambiguity
            | About::Led => Verdict::Physical,
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
            | About::GravitySpread
            | About::Keyframes
            | About::OpenTimes
            | About::Rivals
            | About::Steps
            | About::Receding
            | About::Energy
            | About::Pull
            | About::Tips
            | About::Slips
            | About::Driven
            | About::Untouched
            | About::Limit => Verdict::Plausible,
            About::Gap
            | About::Speed
            | About::Spin
            | About::Way
            | About::Slowness
            | About::Haste
            | About::Rest => Verdict::Failed,
        }
    }
}

/// A place in a motion.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// The whole motion.
    Motion,
    /// One flight.
    Flight {
        /// What flies.
        mechanism: MechanismIndex,
        /// Beginning of the flight \[s\].
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
        /// Physical time \[s\].
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
        /// The feature that is nearer, if the scene names it.
        found: Option<usize>,
    },
    /// A joint.
    Joint {
        /// What hangs on it.
        child: LinkIndex,
        /// Physical time \[s\].
        time_s: f64,
    },
    /// A link at rest.
    Rest {
        /// Index into `Scene::rest_goals`.
        goal: usize,
        /// What points there instead; `None` where the link still moves.
        shown: Option<String>,
        /// Number of motions near the performance that were tried.
        tried: usize,
    },
}

impl Place {
    /// Its name in the scene; `None` for the whole motion.
    pub fn name<'a>(&self, scene: &'a Scene) -> Option<&'a str> {
        match self {
            Place::Motion => None,
            Place::Flight { mechanism, .. } => Some(scene.name_of_mechanism(*mechanism)),
            Place::Inside { link, .. } => Some(&scene.links[*link].name),
            Place::Joint { child, .. } => {
                let tree = scene.joint_tree(scene.mechanism_of(*child))?;
                let mut joints = tree.joints.iter();
                let joint = joints.find(|joint| joint.child == *child)?;
                Some(&joint.name)
            }
            Place::Rest { goal, .. } => Some(&scene.links[scene.rest_goals[*goal].link].name),
            Place::Event(event) | Place::Touch { event, .. } => Some(&scene.events[*event].name),
            Place::Parameter(parameter) => Some(&scene.parameters[*parameter].name),
        }
    }

    /// Its time \[s\], for a place at one time; for a flight, its beginning.
    pub fn time_s(&self) -> Option<f64> {
        match self {
            Place::Flight {
                start_s: time_s, ..
            }
            | Place::Inside { time_s, .. }
            | Place::Joint { time_s, .. } => Some(*time_s),
            Place::Motion
            | Place::Event(_)
            | Place::Parameter(_)
            | Place::Touch { .. }
            | Place::Rest { .. } => None,
        }
    }
}

impl Doubt {
    /// A doubt where the value is beyond its bound; `None` otherwise. NaN is beyond all bounds.
    pub fn beyond(about: About, place: Place, value: f64, bound: f64) -> Option<Self> {
        (!(value <= bound)).then_some(Self {
            about,
            place,
            value,
            bound,
        })
    }
}
