//! The rungs: what is freed, one thing after another.

use enact::motion::{Quantity, Scene};

/// One more thing that is free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rung {
    Restitution,
    Friction,
    Moments,
    Centre,
    TrackerPosition,
    TrackerOrientation,
    Table,
    Gravity,
    Drag,
}

impl Rung {
    /// In their order: what a scene knows worst first, what is the same for all scenes last.
    pub const ALL: [Self; 9] = [
        Self::Restitution,
        Self::Friction,
        Self::Moments,
        Self::Centre,
        Self::TrackerPosition,
        Self::TrackerOrientation,
        Self::Table,
        Self::Gravity,
        Self::Drag,
    ];

    /// In a table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Restitution => "restitution",
            Self::Friction => "friction",
            Self::Moments => "moments",
            Self::Centre => "centre of mass",
            Self::TrackerPosition => "tracker's position",
            Self::TrackerOrientation => "tracker's orientation",
            Self::Table => "table's height and tilt",
            Self::Gravity => "gravity",
            Self::Drag => "drag",
        }
    }

    /// Below an axis.
    pub fn short_name(self) -> &'static str {
        match self {
            Self::Restitution => "bounce",
            Self::Centre => "centre",
            Self::TrackerPosition => "tracker",
            Self::TrackerOrientation => "its turn",
            Self::Table => "table",
            other => other.name(),
        }
    }

    fn holds(self, quantity: Quantity) -> bool {
        match quantity {
            Quantity::Restitution { .. } => self == Self::Restitution,
            Quantity::Friction { .. } => self == Self::Friction,
            Quantity::Moment { .. } => self == Self::Moments,
            Quantity::Centre { .. } => self == Self::Centre,
            Quantity::TrackerPosition { .. } => self == Self::TrackerPosition,
            Quantity::TrackerOrientation { .. } => self == Self::TrackerOrientation,
            Quantity::SurfaceHeight { .. } | Quantity::SurfaceTilt { .. } => self == Self::Table,
            Quantity::Gravity { .. } => self == Self::Gravity,
            Quantity::QuadraticDrag { .. } => self == Self::Drag,
            _ => false,
        }
    }
}

/// The scene with all of these free, from the values that it gives.
pub fn freed(scene: &Scene, rungs: &[Rung]) -> Scene {
    let mut wider = scene.clone();
    for rung in rungs {
        let quantities = scene.quantities().into_iter();
        let quantities = quantities.filter(|quantity| rung.holds(*quantity));
        let told = quantities.filter(|quantity| scene.untold(*quantity).is_none());
        let free = told.map(|quantity| scene.freed(quantity, scene.value_of(quantity)));
        wider.parameters.extend(free);
    }
    wider
}
