//! What the estimation may change besides the motion (paper §6).

/// A free parameter `u`: a quantity that the estimation may change, within bounds (paper §6).
#[derive(Clone, Debug, PartialEq)]
pub struct FreeParameter {
    /// Unique name, as in the scene file: `gravity.z`, `bounce.restitution`.
    pub name: String,
    /// The quantity.
    pub quantity: Quantity,
    /// Value to start from, in the quantity's unit.
    pub initial: f64,
    /// Least value allowed (may be −∞).
    pub lower: f64,
    /// Greatest value allowed (may be +∞).
    pub upper: f64,
    /// Standard deviation of a prior about `initial`, if there is one.
    pub prior_sd: Option<f64>,
}

impl FreeParameter {
    /// A typical change of it: its prior's standard deviation or the width of its bounds, whichever
    /// is less; one where it has neither.
    pub fn length(&self) -> f64 {
        let width = self.upper - self.lower;
        let width = if width > 0.0 && width.is_finite() {
            width
        } else {
            1.0
        };
        self.prior_sd.unwrap_or(width).min(width)
    }
}

/// The quantities that may be free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A component of gravity [m/s²]: axis 0, 1, 2.
    Gravity {
        /// World axis.
        axis: usize,
    },
    /// Restitution at a collision [–].
    Restitution {
        /// Index into `Scene::events`.
        event: usize,
    },
    /// Friction at a collision [–].
    Friction {
        /// Index into `Scene::events`.
        event: usize,
    },
    /// Tilt of the surface's normal at a collision \[rad\] about one of two tangents.
    Tilt {
        /// Index into `Scene::events`.
        event: usize,
        /// Tangent, 0 or 1.
        tangent: usize,
    },
}

impl Quantity {
    /// The event to which it belongs (index into `Scene::events`); `None` for gravity.
    pub fn event(self) -> Option<usize> {
        match self {
            Quantity::Gravity { .. } => None,
            Quantity::Restitution { event }
            | Quantity::Friction { event }
            | Quantity::Tilt { event, .. } => Some(event),
        }
    }

    /// The quantity at another event; gravity is unchanged.
    pub fn at_event(self, moved: impl Fn(usize) -> usize) -> Self {
        match self {
            Quantity::Gravity { .. } => self,
            Quantity::Restitution { event } => Quantity::Restitution {
                event: moved(event),
            },
            Quantity::Friction { event } => Quantity::Friction {
                event: moved(event),
            },
            Quantity::Tilt { event, tangent } => Quantity::Tilt {
                event: moved(event),
                tangent,
            },
        }
    }
}

/// Two parameters within a circle about zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Indices into `Scene::parameters`.
    pub parameters: [usize; 2],
    /// Radius of the circle, in the parameters' unit.
    pub limit: f64,
}
