//! What free parameters act on, apart from gravity and the law of an impact: flights, what trackers
//! see of them, and where things touch.

use nalgebra::Vector3;

use crate::motion::{FlightChange, LinkIndex, MechanismIndex, Quantity, TrackIndex};

/// How a parameter acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Influence {
    /// A component of the pull in flight: gravity's or a force's per mass.
    Pull(usize),
    /// Drag in proportion to the speed.
    LinearDrag,
    /// Drag in proportion to the speed squared.
    QuadraticDrag,
    /// Lift of a ball that spins.
    Lift,
    /// Factor of the moments about an axis and those equal to it.
    Moment([bool; 3]),
    /// Factor of the mass, with the moments.
    Mass,
    /// Where the centre of mass is.
    Centre(usize),
    /// Where the tracker is mounted.
    TrackerPosition(usize),
    /// How the tracker is mounted.
    TrackerOrientation(usize),
    /// How slow the tracker's clock is.
    ClockRate,
    /// What is added to the tracker's stamps.
    ClockOffset,
    /// What is added to the stamp of one sample.
    SampleTime,
    /// How long a contact lasts.
    ContactDuration,
    /// The friction of what supports a body.
    SupportFriction,
    /// Where a surface is along its normal.
    SurfaceHeight,
    /// How a surface is turned about a tangent.
    SurfaceTilt(usize),
}

impl Influence {
    /// Whether it changes how a body moves between events.
    pub fn is_of_motion(self) -> bool {
        matches!(
            self,
            Influence::Pull(_)
                | Influence::LinearDrag
                | Influence::QuadraticDrag
                | Influence::Lift
                | Influence::Moment(_)
                | Influence::SupportFriction
        )
    }
}

/// What a parameter belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Owner {
    /// A link that moves alone.
    Link(LinkIndex, MechanismIndex),
    /// A track.
    Track(TrackIndex),
    /// A flight of a track, counted from 0.
    Flight(TrackIndex, usize),
    /// A sample of a track (index into the track's samples).
    Sample(TrackIndex, usize),
    /// A surface (index into `Scene::surfaces`).
    Surface(usize),
    /// A collision (index into `Scene::events`).
    Contact(usize),
}

/// A parameter with what it acts on and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Role {
    /// Index into [`Scene::parameters`](crate::motion::Scene::parameters).
    pub parameter: usize,
    /// What it belongs to.
    pub owner: Owner,
    /// How it acts.
    pub influence: Influence,
}

/// A parameter that acts on an arc or at a collision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Acting {
    /// Index into [`Scene::parameters`](crate::motion::Scene::parameters).
    pub parameter: usize,
    /// How it acts.
    pub influence: Influence,
    /// At a collision, the side on which it acts; `None`: on both, or on a surface.
    pub side: Option<usize>,
    /// The track that it belongs to: it acts on nothing else.
    pub track: Option<TrackIndex>,
}

impl Acting {
    /// Whether it acts on what a track shows.
    pub fn is_on(&self, track: TrackIndex) -> bool {
        self.track.is_none_or(|of| of == track)
    }
}

/// Whether a parameter of the drag is among those that act on an arc.
pub fn drag_is_free(acting: &[Acting]) -> bool {
    let mut influences = acting.iter().map(|acting| acting.influence);
    influences.any(|of| matches!(of, Influence::LinearDrag | Influence::QuadraticDrag))
}

/// Whether the lift is among the parameters that act on an arc.
pub fn lift_is_free(acting: &[Acting]) -> bool {
    let mut influences = acting.iter().map(|acting| acting.influence);
    influences.any(|of| of == Influence::Lift)
}

impl Influence {
    /// What a parameter of the given value changes of a flight or of what flies, per unit; `None` where it acts on
    /// something else.
    pub fn on_flight(self, value: f64) -> Option<FlightChange> {
        let mut change = FlightChange::default();
        match self {
            Self::Pull(axis) => change.pull_m_s2[axis] = 1.0,
            Self::LinearDrag => change.drag[0] = 1.0,
            Self::QuadraticDrag => change.drag[1] = 1.0,
            Self::Lift => change.lift = 1.0,
            Self::Moment(axes) => {
                change.log_moments =
                    Vector3::from_fn(|axis, _| f64::from(u8::from(axes[axis])) / value);
            }
            Self::Centre(axis) => change.centre_m[axis] = 1.0,
            Self::SupportFriction => change.friction = 1.0,
            _ => return None,
        }
        Some(change)
    }
}

impl Quantity {
    /// The role of a parameter that holds it; `None` for gravity and laws, which have places of
    /// their own, and for joints, which no free parameter moves.
    fn influence(self) -> Option<Influence> {
        Some(match self {
            Quantity::Gravity { .. }
            | Quantity::Restitution { .. }
            | Quantity::Friction { .. }
            | Quantity::TangentialRestitution { .. }
            | Quantity::Tilt { .. }
            | Quantity::JointPlace { .. }
            | Quantity::JointTurn { .. } => return None,
            Quantity::Force { axis, .. } => Influence::Pull(axis),
            Quantity::LinearDrag { .. } => Influence::LinearDrag,
            Quantity::QuadraticDrag { .. } => Influence::QuadraticDrag,
            Quantity::Lift { .. } => Influence::Lift,
            Quantity::Moment { axis, .. } => {
                Influence::Moment([0, 1, 2].map(|other| other == axis))
            }
            Quantity::Mass { .. } => Influence::Mass,
            Quantity::Centre { axis, .. } => Influence::Centre(axis),
            Quantity::TrackerPosition { axis, .. } => Influence::TrackerPosition(axis),
            Quantity::TrackerOrientation { axis, .. } => Influence::TrackerOrientation(axis),
            Quantity::ClockRate { .. } => Influence::ClockRate,
            Quantity::ClockOffset { .. } | Quantity::FlightClock { .. } => Influence::ClockOffset,
            Quantity::SampleTime { .. } => Influence::SampleTime,
            Quantity::ContactDuration { .. } => Influence::ContactDuration,
            Quantity::SurfaceHeight { .. } => Influence::SurfaceHeight,
            Quantity::SurfaceTilt { tangent, .. } => Influence::SurfaceTilt(tangent),
        })
    }
}

impl Role {
    /// The role at an arc or at a side of a collision.
    pub(in crate::estimate) fn acting(&self, side: Option<usize>) -> Acting {
        Acting {
            parameter: self.parameter,
            influence: self.influence,
            side,
            track: match self.owner {
                Owner::Track(track) | Owner::Flight(track, _) | Owner::Sample(track, _) => {
                    Some(track)
                }
                Owner::Link(..) | Owner::Surface(_) | Owner::Contact(_) => None,
            },
        }
    }

    /// The role of each parameter that is neither gravity nor part of a law. `mechanism_of` says
    /// with what a link moves.
    pub fn all(
        quantities: impl Iterator<Item = Quantity>,
        mechanism_of: impl Fn(LinkIndex) -> MechanismIndex,
        moments_kg_m2: impl Fn(LinkIndex) -> Vector3<f64>,
    ) -> Vec<Self> {
        let roles = quantities.enumerate().filter_map(|(parameter, quantity)| {
            let mut influence = quantity.influence()?;
            let owner = match quantity {
                Quantity::Force { link, .. }
                | Quantity::LinearDrag { link }
                | Quantity::QuadraticDrag { link }
                | Quantity::Lift { link }
                | Quantity::Moment { link, .. }
                | Quantity::Mass { link }
                | Quantity::Centre { link, .. } => Owner::Link(link, mechanism_of(link)),
                Quantity::TrackerPosition { track, .. }
                | Quantity::TrackerOrientation { track, .. }
                | Quantity::ClockRate { track }
                | Quantity::ClockOffset { track } => Owner::Track(track),
                Quantity::FlightClock { track, flight } => Owner::Flight(track, flight),
                Quantity::SampleTime { track, sample } => Owner::Sample(track, sample),
                Quantity::ContactDuration { event } => Owner::Contact(event),
                Quantity::SurfaceHeight { surface } | Quantity::SurfaceTilt { surface, .. } => {
                    Owner::Surface(surface)
                }
                _ => return None,
            };
            if let Quantity::Moment { link, axis } = quantity {
                let moments = moments_kg_m2(link);
                influence = Influence::Moment([0, 1, 2].map(|i| moments[i] == moments[axis]));
            }
            Some(Self {
                parameter,
                owner,
                influence,
            })
        });
        roles.collect()
    }
}
