//! What of a scene may be free: its quantities, their names, and the values that it gives them.

use super::event::Event;
use super::joint::{Joint, JointEnd};
use super::link::Link;
use super::parameter::FreeParameter;
use super::quantity::Quantity;
use super::whole::Scene;
use crate::motion::index::{ContactLawIndex, LinkIndex, TrackIndex};
use crate::physics::contact;

/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

impl Joint {
    /// What of it may be elsewhere than the scene says: its places in both that it ties, and its axes.
    pub fn quantities(&self) -> impl Iterator<Item = Quantity> + use<> {
        let child = self.child;
        let ends = [JointEnd::Parent, JointEnd::Child].into_iter();
        let places = ends
            .flat_map(move |end| (0..3).map(move |axis| Quantity::JointPlace { child, end, axis }));
        let turns = 0..self.turns().len();
        places.chain(turns.map(move |about| Quantity::JointTurn { child, about }))
    }
}

impl Link {
    /// The first axis whose moment equals that about `axis`: it names them.
    pub fn moment_axis(&self, axis: usize) -> usize {
        let moments = self.body.moments_kg_m2();
        (0..axis)
            .find(|other| moments[*other] == moments[axis])
            .unwrap_or(axis)
    }

    /// The axes that name its different moments.
    pub fn moment_axes(&self) -> impl Iterator<Item = usize> + '_ {
        (0..3).filter(|axis| self.moment_axis(*axis) == *axis)
    }
}

impl Scene {
    /// The quantities of the scene that an estimation may free, in the order of its lists: places and axes of
    /// joints are none of them. Not
    /// every one of them is told by a performance: see [`Scene::untold`].
    pub fn quantities(&self) -> Vec<Quantity> {
        let gravity = (0..3).map(|axis| Quantity::Gravity { axis });
        let laws = self.contact_laws.keys();
        let laws = laws.flat_map(|law| {
            [
                Quantity::Restitution { law },
                Quantity::Friction { law },
                Quantity::TangentialRestitution { law },
            ]
        });
        let is_collision = |(_, event): &(usize, &Event)| event.kind.collision().is_some();
        let events = self.events.iter().enumerate().filter(is_collision);
        let at_collisions = events.flat_map(|(event, _)| {
            let tilts = [0, 1].map(|tangent| Quantity::Tilt { event, tangent });
            tilts
                .into_iter()
                .chain([Quantity::ContactDuration { event }])
        });
        let links = self.links.keys().flat_map(|link| self.quantities_of(link));
        let tracks = self.tracks.keys().flat_map(|track| {
            let places = (0..3).map(move |axis| Quantity::TrackerPosition { track, axis });
            let turns = (0..3).map(move |axis| Quantity::TrackerOrientation { track, axis });
            let clock = [
                Quantity::ClockRate { track },
                Quantity::ClockOffset { track },
            ];
            places.chain(turns).chain(clock)
        });
        let surfaces = self.surfaces.iter().enumerate();
        let faces = surfaces.filter(|(_, s)| matches!(s.geometry, contact::Feature::Face { .. }));
        let faces = faces.flat_map(|(surface, _)| {
            let tilt = |tangent| Quantity::SurfaceTilt { surface, tangent };
            [Quantity::SurfaceHeight { surface }, tilt(0), tilt(1)]
        });
        let world = gravity.chain(laws).chain(at_collisions);
        let joints = self.joint_trees().flat_map(|(_, tree)| &tree.joints);
        // Their axes may be suspected, not freed: from axes that are off few motions are found.
        let joints = joints
            .flat_map(Joint::quantities)
            .filter(|quantity| matches!(quantity, Quantity::JointPlace { .. }));
        let all = world.chain(links).chain(tracks).chain(faces);
        all.chain(joints).collect()
    }

    fn quantities_of(&self, link: LinkIndex) -> Vec<Quantity> {
        let force = (0..3).map(|axis| Quantity::Force { link, axis });
        let drag = [
            Quantity::LinearDrag { link },
            Quantity::QuadraticDrag { link },
            Quantity::Lift { link },
        ];
        let axes = self.links[link].moment_axes();
        let moments = axes.map(|axis| Quantity::Moment { link, axis });
        let centre = (0..3).map(|axis| Quantity::Centre { link, axis });
        let mass = [Quantity::Mass { link }];
        let inertia = moments.chain(mass).chain(centre);
        force.chain(drag).chain(inertia).collect()
    }

    /// The name of a quantity in scene files and reports: `gravity.z`, `bounce.restitution`,
    /// `pencil.tracker.turn.x`.
    pub fn name_of_quantity(&self, quantity: Quantity) -> String {
        let law = |law: ContactLawIndex| &self.contact_laws[law].name;
        let link = |link: LinkIndex| &self.links[link].name;
        let seen = |track: TrackIndex| &self.tracks[track].name;
        let surface = |surface: usize| &self.surfaces[surface].name;
        let joint = |child: LinkIndex| self.joint_of(child).map_or("", |joint| &joint.name);
        match quantity {
            Quantity::Gravity { axis } => format!("gravity.{}", AXES[axis]),
            Quantity::Restitution { law: of } => format!("{}.restitution", law(of)),
            Quantity::Friction { law: of } => format!("{}.friction", law(of)),
            Quantity::TangentialRestitution { law: of } => {
                format!("{}.tangential_restitution", law(of))
            }
            Quantity::Tilt { event, tangent } => {
                format!("{}.tilt.{tangent}", self.events[event].name)
            }
            Quantity::Force { link: of, axis } => format!("{}.force.{}", link(of), AXES[axis]),
            Quantity::LinearDrag { link: of } => format!("{}.drag.linear", link(of)),
            Quantity::QuadraticDrag { link: of } => format!("{}.drag.quadratic", link(of)),
            Quantity::Lift { link: of } => format!("{}.lift", link(of)),
            Quantity::Moment { link: of, axis } => format!("{}.moment.{}", link(of), AXES[axis]),
            Quantity::Mass { link: of } => format!("{}.mass", link(of)),
            Quantity::Centre { link: of, axis } => format!("{}.centre.{}", link(of), AXES[axis]),
            Quantity::TrackerPosition { track, axis } => {
                format!("{}.tracker.{}", seen(track), AXES[axis])
            }
            Quantity::TrackerOrientation { track, axis } => {
                format!("{}.tracker.turn.{}", seen(track), AXES[axis])
            }
            Quantity::ClockRate { track } => format!("{}.clock.rate", seen(track)),
            Quantity::ClockOffset { track } => format!("{}.clock.offset", seen(track)),
            Quantity::FlightClock { track, flight } => {
                format!("{}.clock.flight.{}", seen(track), flight + 1)
            }
            Quantity::SampleTime { track, sample } => {
                format!("{}.keyframe.{}.time", seen(track), sample + 1)
            }
            Quantity::ContactDuration { event } => {
                format!("{}.contact_duration", self.events[event].name)
            }
            Quantity::SurfaceHeight { surface: of } => format!("{}.height", surface(of)),
            Quantity::SurfaceTilt {
                surface: of,
                tangent,
            } => format!("{}.tilt.{tangent}", surface(of)),
            Quantity::JointPlace { child, end, axis } => {
                let end = match end {
                    JointEnd::Child => "child",
                    JointEnd::Parent => "parent",
                };
                format!("{}.{end}.{}", joint(child), AXES[axis])
            }
            Quantity::JointTurn { child, about } => format!("{}.turn.{about}", joint(child)),
        }
    }

    /// The parameter that frees a quantity (index into [`Scene::parameters`]); `None` where none does.
    pub fn parameter_of(&self, quantity: Quantity) -> Option<usize> {
        let mut parameters = self.parameters.iter();
        parameters.position(|free| free.quantity == quantity)
    }

    /// Whether a parameter frees the quantity.
    pub fn frees(&self, quantity: Quantity) -> bool {
        self.parameter_of(quantity).is_some()
    }

    /// A parameter that frees a quantity from a value on: with the quantity's name, within what is
    /// physical, without a prior.
    pub fn freed(&self, quantity: Quantity, initial: f64) -> FreeParameter {
        let [lower, upper] = self.limits_of(quantity);
        FreeParameter {
            name: self.name_of_quantity(quantity),
            quantity,
            initial,
            lower,
            upper,
            prior_sd: None,
        }
    }

    /// The widest bounds that a quantity may have here: a bumper's restitution exceeds that of others.
    pub fn limits_of(&self, quantity: Quantity) -> [f64; 2] {
        match quantity {
            Quantity::Restitution { law } => [0.0, self.contact_laws[law].most_restitution()],
            other => other.limits(),
        }
    }

    /// The scene with quantities free, each from its value on.
    pub fn with_free(&self, values: &[(Quantity, f64)]) -> Self {
        let mut wider = self.clone();
        let values = values.iter();
        let free = values.map(|(quantity, value)| self.freed(*quantity, *value));
        wider.parameters.extend(free);
        wider
    }

    /// The value that the scene gives a quantity, in its unit: 0 for a correction, 1 for a factor.
    pub fn value_of(&self, quantity: Quantity) -> f64 {
        match quantity {
            Quantity::Gravity { axis } => self.gravity_m_s2[axis],
            Quantity::Restitution { law } => self.contact_laws[law].restitution,
            Quantity::Friction { law } => self.contact_laws[law].friction,
            Quantity::TangentialRestitution { law } => {
                self.contact_laws[law].tangential_restitution
            }
            Quantity::Tilt { event, tangent } => {
                let collision = self.events[event].kind.collision();
                collision.map_or(0.0, |collision| collision.tilt_rad[tangent])
            }
            Quantity::Force { link, axis } => self.links[link].body.force_m_s2()[axis],
            Quantity::LinearDrag { link } => self.links[link].body.drag().linear_per_s,
            Quantity::QuadraticDrag { link } => self.links[link].body.drag().quadratic_per_m,
            Quantity::Lift { link } => self.links[link].body.lift(),
            Quantity::Moment { .. } | Quantity::Mass { .. } => 1.0,
            Quantity::Centre { .. }
            | Quantity::TrackerPosition { .. }
            | Quantity::TrackerOrientation { .. }
            | Quantity::ClockRate { .. }
            | Quantity::ClockOffset { .. }
            | Quantity::FlightClock { .. }
            | Quantity::SampleTime { .. }
            | Quantity::ContactDuration { .. }
            | Quantity::SurfaceHeight { .. }
            | Quantity::SurfaceTilt { .. }
            | Quantity::JointPlace { .. }
            | Quantity::JointTurn { .. } => 0.0,
        }
    }
}
