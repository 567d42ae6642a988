//! Results of the checks that are independent of the estimation.

use nalgebra::Vector3;

use super::doubt::{About, Doubt, Place};
use super::index::LinkIndex;
use super::scene::Against;

/// The deepest overlap of two solids that no expected contact explains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penetration {
    /// The link.
    pub link: LinkIndex,
    /// The solid in which it is.
    pub against: Against,
    /// Physical time \[s\].
    pub time_s: f64,
    /// Depth \[m\], positive.
    pub depth_m: f64,
    /// The link's deepest point [m, link].
    pub point_m: Vector3<f64>,
}

impl Penetration {
    /// The deeper of two; the first of two that are as deep.
    pub fn deeper(one: Option<Self>, other: Option<Self>) -> Option<Self> {
        let both = [one, other].into_iter().flatten();
        both.reduce(|a, b| if b.depth_m > a.depth_m { b } else { a })
    }

    /// The doubt that it casts, where so much is tolerated \[m\].
    pub fn doubt(&self, tolerance_m: f64) -> Doubt {
        Doubt {
            about: About::Overlap,
            place: Place::Inside {
                link: self.link,
                against: self.against,
                time_s: self.time_s,
            },
            value: self.depth_m,
            bound: tolerance_m,
        }
    }
}

/// The first touch of a link at a collision, by its whole shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Touch {
    /// Index into `Scene::events`.
    pub event: usize,
    /// The link.
    pub link: LinkIndex,
    /// What it hits.
    pub against: Against,
    /// The features that are expected to touch (indices into `Link::features`).
    pub expected: Vec<usize>,
    /// The link's point that is nearest, or deepest, when the expected features touch [m, link].
    pub found_point_m: Vector3<f64>,
    /// The named feature to which that point belongs, an expected one where there are several;
    /// `None` where the scene names none there.
    pub found: Option<usize>,
    /// How much nearer that point is than the expected features \[m\]: its depth when they touch.
    pub lead_m: f64,
    /// Time at which that point would have touched \[s\]; the event's time where nothing leads.
    pub found_time_s: f64,
    /// Deepest overlap of the shape about expected features in the flights before and after
    /// \[m\], zero or more. Where a feature represents more than a point of the shape, as a tip
    /// the rim around it, this is the error of the simplification.
    pub overlap_m: f64,
    /// Whether another part than expected leads by more than the tolerance.
    pub is_wrong: bool,
}

impl Touch {
    /// The doubt that it casts where it is wrong, and so much is tolerated \[m\].
    pub fn doubt(&self, tolerance_m: f64) -> Doubt {
        Doubt {
            about: About::WrongFeature,
            place: Place::Touch {
                event: self.event,
                link: self.link,
                expected: self.expected.clone(),
                found: self.found,
            },
            value: self.lead_m,
            bound: tolerance_m,
        }
    }
}

/// A contact that pulls at a collision at several contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pull {
    /// Index into `Scene::events`.
    pub event: usize,
    /// Its impulse, of the greatest of that collision.
    pub share: f64,
}

impl Pull {
    /// Greatest share that is attributed to rounding.
    pub const MOST: f64 = 1e-6;

    /// The doubt that it casts, if it is more than rounding.
    pub fn doubt(&self) -> Option<Doubt> {
        let place = Place::Event(self.event);
        Doubt::beyond(About::Pull, place, self.share, Self::MOST)
    }
}

/// Difference between the single shot and the estimate at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// The link.
    pub link: LinkIndex,
    /// The collision that is about to happen (index into `Scene::events`); `None`: the end.
    pub event: Option<usize>,
    /// Difference of the instants themselves \[s\].
    pub time_s: f64,
    /// Distance of the centres of mass \[m\].
    pub position_m: f64,
    /// Angle between the orientations \[rad\].
    pub orientation_rad: f64,
    /// Difference of the velocities [m/s].
    pub velocity_m_s: f64,
    /// Difference of the angular velocities [rad/s].
    pub angular_velocity_rad_s: f64,
}

/// A simulation from the first states alone, compared with the estimate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SingleShot {
    /// Deviations just before every collision of every link, and at its end.
    pub deviations: Vec<Deviation>,
    /// Collisions after which the simulation restarted from the estimate's state: those with
    /// velocity gaps (indices into `Scene::events`).
    pub restarts: Vec<usize>,
    /// Collisions that were not found near their time (indices into `Scene::events`).
    pub missed: Vec<usize>,
}

impl SingleShot {
    /// The largest deviation of each kind at the ends of the links; `None` without any.
    pub fn at_end(&self) -> Option<Deviation> {
        let ends = self.deviations.iter().filter(|d| d.event.is_none());
        ends.copied().reduce(|a, b| Deviation {
            time_s: a.time_s.max(b.time_s),
            position_m: a.position_m.max(b.position_m),
            orientation_rad: a.orientation_rad.max(b.orientation_rad),
            velocity_m_s: a.velocity_m_s.max(b.velocity_m_s),
            angular_velocity_rad_s: a.angular_velocity_rad_s.max(b.angular_velocity_rad_s),
            ..a
        })
    }
}

/// Largest relative violations of the conservation laws.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance {
    /// Energy over flights, relative to the largest energy in them.
    pub flight_energy: f64,
    /// Momentum over flights.
    pub flight_momentum: f64,
    /// Angular momentum over flights.
    pub flight_angular_momentum: f64,
    /// Kinetic energy over impacts, except the loss by restitution and friction, relative to that
    /// before.
    pub impact_energy: f64,
    /// Momentum over impacts: of two bodies together, and of each perpendicular to the normals.
    pub impact_momentum: f64,
    /// Angular momentum of each body about the contact over impacts.
    pub impact_angular_momentum: f64,
}

/// The results of all checks.
#[derive(Clone, Debug, PartialEq)]
pub struct Verification {
    /// Overlaps up to this depth are attributed to the scene's inaccuracy \[m\]; no deeper one is
    /// missed.
    pub tolerance_m: f64,
    /// The deepest overlap beyond the tolerance, if there is one.
    pub deepest: Option<Penetration>,
    /// The first touches, collision by collision.
    pub touches: Vec<Touch>,
    /// Contacts that pull.
    pub pulls: Vec<Pull>,
    /// What surfaces would have to do to what is on them, and cannot; and what does not touch where it hits.
    pub of_contacts: Vec<Doubt>,
    /// The forward simulation.
    pub single_shot: SingleShot,
    /// Energy and momentum.
    pub balance: Balance,
}

impl Balance {
    /// The larger violation of each law.
    fn max(&self, other: &Self) -> Self {
        Self {
            flight_energy: self.flight_energy.max(other.flight_energy),
            flight_momentum: self.flight_momentum.max(other.flight_momentum),
            flight_angular_momentum: self
                .flight_angular_momentum
                .max(other.flight_angular_momentum),
            impact_energy: self.impact_energy.max(other.impact_energy),
            impact_momentum: self.impact_momentum.max(other.impact_momentum),
            impact_angular_momentum: self
                .impact_angular_momentum
                .max(other.impact_angular_momentum),
        }
    }
}

impl Verification {
    /// The results of the checks of two motions of one scene.
    pub fn with(mut self, other: Self) -> Self {
        self.deepest = Penetration::deeper(self.deepest, other.deepest);
        self.touches.extend(other.touches);
        self.touches.sort_by_key(|touch| touch.event);
        self.pulls.extend(other.pulls);
        self.of_contacts.extend(other.of_contacts);
        let shot = &mut self.single_shot;
        shot.deviations.extend(other.single_shot.deviations);
        shot.restarts.extend(other.single_shot.restarts);
        shot.missed.extend(other.single_shot.missed);
        self.balance = self.balance.max(&other.balance);
        self
    }

    /// The touches where another part than expected would have touched first.
    pub fn wrong_features(&self) -> impl Iterator<Item = &Touch> {
        self.touches.iter().filter(|touch| touch.is_wrong)
    }

    /// The deepest overlap, every touch of another part than expected, every contact that pulls, and what no surface does.
    pub fn doubts(&self) -> Vec<Doubt> {
        let wrong = self.wrong_features();
        let wrong = wrong.map(|touch| touch.doubt(self.tolerance_m));
        let deepest = self.deepest.iter();
        let deepest = deepest.map(|deepest| deepest.doubt(self.tolerance_m));
        let pulls = self.pulls.iter().filter_map(Pull::doubt);
        let of_contacts = self.of_contacts.iter().cloned();
        deepest
            .chain(wrong)
            .chain(pulls)
            .chain(of_contacts)
            .collect()
    }
}
