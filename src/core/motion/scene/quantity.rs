//! The quantities that an estimation may change besides the motion.

use super::joint::JointEnd;
use crate::motion::index::{ContactLawIndex, LinkIndex, TrackIndex};

/// A quantity that may be free.
///
/// Values are in SI units ([`Quantity::unit`]). Those that a scene gives are themselves the value
/// (gravity, restitution, friction, force, drag, lift); the others correct what the scene gives and are 0
/// where it is right, or 1 for a factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A component of gravity [m/s²]: axis 0, 1, 2.
    Gravity {
        /// World axis.
        axis: usize,
    },
    /// Restitution of a contact law [–].
    Restitution {
        /// The law.
        law: ContactLawIndex,
    },
    /// Friction of a contact law [–].
    Friction {
        /// The law.
        law: ContactLawIndex,
    },
    /// Tangential restitution of a contact law [–].
    TangentialRestitution {
        /// The law.
        law: ContactLawIndex,
    },
    /// Tilt of the surface's normal at a collision \[rad\] about one of two tangents: the normal
    /// that the impact sees. Where the surface is does not change.
    Tilt {
        /// Index into `Scene::events`.
        event: usize,
        /// Tangent, 0 or 1.
        tangent: usize,
    },
    /// A component of a constant force on a link per mass [m/s², world].
    Force {
        /// The link.
        link: LinkIndex,
        /// World axis.
        axis: usize,
    },
    /// Drag of a link that grows with its speed, per mass [1/s].
    LinearDrag {
        /// The link.
        link: LinkIndex,
    },
    /// Drag of a link that grows with its speed squared, per mass [1/m].
    QuadraticDrag {
        /// The link.
        link: LinkIndex,
    },
    /// Lift of a ball that spins, dimensionless ([`Body::with_lift`](crate::physics::Body::with_lift)).
    Lift {
        /// The link.
        link: LinkIndex,
    },
    /// Factor of a link's principal moment about a body axis, at fixed mass [–]. Equal moments move
    /// together and are named by the first of their axes.
    Moment {
        /// The link.
        link: LinkIndex,
        /// Body axis, the first of those with an equal moment.
        axis: usize,
    },
    /// Factor of a link's mass, its moments along with it [–].
    Mass {
        /// The link.
        link: LinkIndex,
    },
    /// Where a link's centre of mass is, in the axes that it has in the scene \[m\]: the moments
    /// stay as they are, but about the moved centre; shape, features and trackers stay where they
    /// are on the object, and so does a goal's pose.
    Centre {
        /// The link.
        link: LinkIndex,
        /// Body axis.
        axis: usize,
    },
    /// Correction of a tracker's position on its link [m, link axes].
    TrackerPosition {
        /// The track.
        track: TrackIndex,
        /// Link axis.
        axis: usize,
    },
    /// Correction of a tracker's orientation on its link [rad, tracker axes]: all three components
    /// are one rotation vector `θ`, `R ⊞ θ = R·Exp(θ)`.
    TrackerOrientation {
        /// The track.
        track: TrackIndex,
        /// Tracker axis.
        axis: usize,
    },
    /// By how much a track's clock is slow [s/s]: a physical interval is `1 + rate` times the
    /// interval of its stamps.
    ClockRate {
        /// The track.
        track: TrackIndex,
    },
    /// What is to be added to a track's stamps \[s\].
    ClockOffset {
        /// The track.
        track: TrackIndex,
    },
    /// What is to be added to the times of one flight of an edited sketch \[s\], whose stamps count
    /// from a zero of their own, where each flight is put one sampling interval after the one before.
    FlightClock {
        /// The track.
        track: TrackIndex,
        /// The flight, counted from 0; the first has none.
        flight: usize,
    },
    /// What is to be added to the stamp of a sample whose time is not known \[s\].
    SampleTime {
        /// The track.
        track: TrackIndex,
        /// Index into the track's samples.
        sample: usize,
    },
    /// How long the contact of a collision lasts \[s\]: what takes part in it leaves from where it came so much later than
    /// the impact, which is one moment, has it.
    ContactDuration {
        /// Index into `Scene::events`.
        event: usize,
    },
    /// How far a surface is from where the scene has it, along its normal there \[m\].
    SurfaceHeight {
        /// Index into `Scene::surfaces`.
        surface: usize,
    },
    /// Rotation of a surface about its point \[rad\]. Both components are one rotation vector, along
    /// [`tilt_axes`](crate::physics::contact::Contact::tilt_axes) of the scene's surface.
    SurfaceTilt {
        /// Index into `Scene::surfaces`.
        surface: usize,
        /// Tangent, 0 or 1.
        tangent: usize,
    },
    /// How far a joint is from where the scene has it, in the axes of one of the two that it ties \[m\].
    JointPlace {
        /// What hangs on the joint.
        child: LinkIndex,
        /// In whose axes.
        end: JointEnd,
        /// Axis.
        axis: usize,
    },
    /// Turn of a joint's axes, in both that it ties, about one of [`Joint::turns`](super::Joint::turns) \[rad\]: how both
    /// are turned where all angles are zero does not change.
    JointTurn {
        /// What hangs on the joint.
        child: LinkIndex,
        /// Index into those axes.
        about: usize,
    },
}

/// Least factor of a mass or of a moment: a body that is a hundred times lighter is another one.
const LEAST_FACTOR: f64 = 0.01;

impl Quantity {
    /// Whether it and another are components of one vector, or the same.
    pub fn is_of_one_thing_with(self, other: Self) -> bool {
        let thing = |quantity: Quantity| match quantity {
            Quantity::Gravity { .. } => Quantity::Gravity { axis: 0 },
            Quantity::Force { link, .. } => Quantity::Force { link, axis: 0 },
            Quantity::Centre { link, .. } => Quantity::Centre { link, axis: 0 },
            Quantity::TrackerPosition { track, .. } => Quantity::TrackerPosition { track, axis: 0 },
            Quantity::TrackerOrientation { track, .. } => {
                Quantity::TrackerOrientation { track, axis: 0 }
            }
            Quantity::Tilt { event, .. } => Quantity::Tilt { event, tangent: 0 },
            Quantity::SurfaceTilt { surface, .. } => Quantity::SurfaceTilt {
                surface,
                tangent: 0,
            },
            Quantity::JointPlace { child, end, .. } => Quantity::JointPlace {
                child,
                end,
                axis: 0,
            },
            Quantity::JointTurn { child, .. } => Quantity::JointTurn { child, about: 0 },
            other => other,
        };
        thing(self) == thing(other)
    }

    /// Quantities thing by thing: the components of a vector together, in the order of the first.
    pub fn by_thing(quantities: impl Iterator<Item = Self>) -> Vec<Vec<Self>> {
        let mut things: Vec<Vec<Self>> = Vec::new();
        for quantity in quantities {
            let mut known = things.iter_mut();
            match known.find(|thing| thing[0].is_of_one_thing_with(quantity)) {
                Some(thing) => thing.push(quantity),
                None => things.push(vec![quantity]),
            }
        }
        things
    }

    /// Its SI unit; empty for ratios and factors.
    pub fn unit(self) -> &'static str {
        match self {
            Quantity::Gravity { .. } | Quantity::Force { .. } => "m/s²",
            Quantity::Restitution { .. }
            | Quantity::Friction { .. }
            | Quantity::TangentialRestitution { .. }
            | Quantity::Lift { .. }
            | Quantity::Moment { .. }
            | Quantity::Mass { .. } => "",
            Quantity::ClockRate { .. } => "s/s",
            Quantity::Tilt { .. }
            | Quantity::TrackerOrientation { .. }
            | Quantity::SurfaceTilt { .. }
            | Quantity::JointTurn { .. } => "rad",
            Quantity::LinearDrag { .. } => "1/s",
            Quantity::QuadraticDrag { .. } => "1/m",
            Quantity::Centre { .. }
            | Quantity::TrackerPosition { .. }
            | Quantity::SurfaceHeight { .. }
            | Quantity::JointPlace { .. } => "m",
            Quantity::ClockOffset { .. }
            | Quantity::FlightClock { .. }
            | Quantity::SampleTime { .. }
            | Quantity::ContactDuration { .. } => "s",
        }
    }

    /// The widest bounds that it may have: the least and the greatest physical value, of what is no bumper
    /// ([`Scene::limits_of`](super::Scene::limits_of)).
    pub fn limits(self) -> [f64; 2] {
        match self {
            Quantity::Restitution { .. } | Quantity::TangentialRestitution { .. } => [0.0, 1.0],
            Quantity::Friction { .. }
            | Quantity::LinearDrag { .. }
            | Quantity::QuadraticDrag { .. }
            | Quantity::ContactDuration { .. } => [0.0, f64::INFINITY],
            Quantity::Moment { .. } | Quantity::Mass { .. } => [LEAST_FACTOR, f64::INFINITY],
            // A clock that runs backwards or stands still orders nothing.
            Quantity::ClockRate { .. } => [LEAST_FACTOR - 1.0, f64::INFINITY],
            Quantity::Gravity { .. }
            | Quantity::Tilt { .. }
            | Quantity::Force { .. }
            | Quantity::Lift { .. }
            | Quantity::Centre { .. }
            | Quantity::TrackerPosition { .. }
            | Quantity::TrackerOrientation { .. }
            | Quantity::ClockOffset { .. }
            | Quantity::FlightClock { .. }
            | Quantity::SampleTime { .. }
            | Quantity::SurfaceHeight { .. }
            | Quantity::SurfaceTilt { .. }
            | Quantity::JointPlace { .. }
            | Quantity::JointTurn { .. } => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// A change of it that matters for things that a hand can act with.
    pub fn typical(self) -> f64 {
        match self {
            Quantity::Gravity { .. }
            | Quantity::Restitution { .. }
            | Quantity::Friction { .. }
            | Quantity::TangentialRestitution { .. }
            | Quantity::Tilt { .. }
            | Quantity::Force { .. }
            | Quantity::LinearDrag { .. } => 1.0,
            Quantity::QuadraticDrag { .. } | Quantity::Moment { .. } | Quantity::Mass { .. } => 0.3,
            Quantity::TrackerOrientation { .. }
            | Quantity::SurfaceTilt { .. }
            | Quantity::JointTurn { .. }
            | Quantity::FlightClock { .. }
            | Quantity::SampleTime { .. } => 0.1,
            Quantity::ClockRate { .. } => 0.03,
            Quantity::Lift { .. }
            | Quantity::Centre { .. }
            | Quantity::TrackerPosition { .. }
            | Quantity::SurfaceHeight { .. }
            | Quantity::JointPlace { .. }
            | Quantity::ClockOffset { .. }
            | Quantity::ContactDuration { .. } => 0.01,
        }
    }

    /// The event at which, or from which on, it acts (index into `Scene::events`), if there is one.
    pub fn event(self) -> Option<usize> {
        match self {
            Quantity::Tilt { event, .. } | Quantity::ContactDuration { event } => Some(event),
            _ => None,
        }
    }

    /// The quantity where events have moved to other indices.
    pub fn at_event(self, moved: impl Fn(usize) -> usize) -> Self {
        match self {
            Quantity::Tilt { event, tangent } => Quantity::Tilt {
                event: moved(event),
                tangent,
            },
            Quantity::ContactDuration { event } => Quantity::ContactDuration {
                event: moved(event),
            },
            _ => self,
        }
    }
}
