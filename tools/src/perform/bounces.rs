//! A cube, a regular tetrahedron, a brick or a stick that bounces along a table, as often as one likes: for studies
//! of cost and scaling.
//!
//! A free run of a cube soon has flights of a few milliseconds, when corner after corner hits.
//! So each bounce's restitution is chosen, from a few values, such that the flight after it is a
//! good one: depth-first search. Most choices are near 1, so that the energy lasts. With friction the
//! law is the estimator's own.

mod scene_file;

pub use scene_file::scene_toml;

use enact::math::Pose;
use enact::motion::{
    ArcEstimate, Collision, ContactLaw, ContactLawIndex, Event, EventKind, Feature, FreeBody,
    LinkIndex, MechanismIndex, Performer, Scene, Surface, Timing, VelocityGaps, Weights,
};
use enact::physics::contact::Contact;
use enact::physics::impact::{ContactSet, Law, Side};
use enact::physics::{Body, Drag, Shape, State, contact};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use typed_index_collections::TiVec;

use super::encounter::{Encounter, still};
use super::truth::{Flight, Truth, TruthError, crossing_s};

/// Mass of the solid [kg].
const MASS_KG: f64 = 1.0;
/// The least restitution is 1 minus this.
const WORST_LOSS: f64 = 0.15;
/// Values of restitution to choose from at a bounce.
const CHOICES: usize = 8;
/// Arcs looked at per bounce before giving up.
const TRIES_PER_BOUNCE: usize = 2000;
/// Contacts are looked for at this spacing \[s\],
const SCAN_S: f64 = 1e-3;
/// or at a finer one, so that the body turns by no more than this in between \[rad\].
const SCAN_RAD: f64 = 0.03;

/// What is thrown, and what makes a flight of it a good one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Throw {
    /// Half the side of the cube, or of the one about the other solid \[m\].
    pub half_m: f64,
    /// Height from which it is thrown \[m\].
    pub height_m: f64,
    /// About how fast it is thrown, up and along [m/s].
    pub speed_m_s: f64,
    /// Standard deviation of the first angular velocity, per axis [rad/s].
    pub spin_rad_s: f64,
    /// A good flight turns no faster than this [rad/s],
    pub fastest_rad_s: f64,
    /// lasts no shorter than this \[s\],
    pub shortest_s: f64,
    /// nor longer \[s\],
    pub longest_s: f64,
    /// ends with a corner that approaches at least this fast [m/s],
    pub slowest_approach_m_s: f64,
    /// and the next corner at least this far off \[m\].
    pub clearest_m: f64,
    /// The motion ends after this share of its last flight.
    pub last_share: f64,
    /// Coefficient of friction at every bounce.
    pub friction: f64,
    /// Quadratic drag of the air \[1/m\].
    pub quadratic_drag_per_m: f64,
}

impl Throw {
    /// A cube of 30 cm that turns slowly.
    pub const BOX: Self = Self {
        half_m: 0.15,
        height_m: 0.5,
        speed_m_s: 1.0,
        spin_rad_s: 4.0,
        fastest_rad_s: 25.0,
        shortest_s: 0.1,
        longest_s: 1.0,
        slowest_approach_m_s: 0.5,
        clearest_m: 0.002,
        last_share: 0.5,
        friction: 0.0,
        quadratic_drag_per_m: 0.0,
    };

    /// A die of 16 mm, as people roll them.
    pub const DIE: Self = Self::sized(0.016, 60.0);

    /// A cube of that side \[m\] that turns about as fast as said [rad/s] and never faster. How fast it
    /// flies follows: an impact at a corner turns what flew into what spins.
    pub const fn sized(side_m: f64, fastest_rad_s: f64) -> Self {
        let speed_m_s = 0.3 * fastest_rad_s * side_m;
        let rises_s = speed_m_s / 9.80665;
        Self {
            half_m: 0.5 * side_m,
            height_m: side_m + 0.5 * speed_m_s * rises_s,
            speed_m_s,
            spin_rad_s: 0.3 * fastest_rad_s,
            fastest_rad_s,
            shortest_s: 1.5 * rises_s,
            longest_s: 8.0 * rises_s,
            slowest_approach_m_s: 0.3 * speed_m_s,
            clearest_m: 0.006 * side_m,
            last_share: 0.95,
            friction: 0.0,
            quadratic_drag_per_m: 0.0,
        }
    }
}

/// A flight and the corner that ends it.
#[derive(Clone, Copy)]
pub(super) struct Hop {
    pub(super) state: State,
    pub(super) duration_s: f64,
    pub(super) corner: usize,
    pub(super) restitution: f64,
    pub(super) choice: usize,
}

/// What bounces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Polyhedron {
    /// Eight corners.
    Cube,
    /// Every other corner of the cube.
    Tetrahedron,
    /// Flatter than the cube, so that its moments are three.
    Brick,
    /// As long as the cube, and a tenth as wide.
    Stick,
}

impl Polyhedron {
    /// Lengths of the sides of the cuboid whose corners, or every other of them, it has \[sides of the cube\].
    fn sides(self) -> Vector3<f64> {
        match self {
            Self::Cube | Self::Tetrahedron => Vector3::repeat(1.0),
            Self::Brick => Vector3::new(1.0, 0.7, 0.45),
            Self::Stick => Vector3::new(0.1, 0.1, 1.0),
        }
    }
}

/// A motion of a cube with `count` bounces, each on a corner, then a last flight. No goals.
pub fn bounces(count: usize, seed: u64) -> Result<Truth, TruthError> {
    thrown(Polyhedron::Cube, &Throw::BOX, count, seed)
}

/// The same of either solid, thrown in any way.
pub fn thrown(
    solid: Polyhedron,
    throw: &Throw,
    count: usize,
    seed: u64,
) -> Result<Truth, TruthError> {
    let cube = Bouncer::new(solid, *throw);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut path: Vec<Hop> = Vec::new();
    let tries = TRIES_PER_BOUNCE * (count + 1);
    for _ in 0..tries {
        // Go on from the last hop with its next untried restitution, or begin anew.
        let next = match path.last_mut() {
            None => Some(throw.start(&mut rng)),
            Some(last) if last.choice < CHOICES => {
                // Small losses first; random, so that no two bounces are alike.
                let share = (last.choice as f64 + rng.random::<f64>()) / CHOICES as f64;
                last.restitution = 1.0 - WORST_LOSS * share.powi(4);
                last.choice += 1;
                Some(cube.bounced(last))
            }
            Some(_) => None,
        };
        let Some(state) = next else {
            // The last choices before a dead end hardly differ: back by one hop mostly, by n hops
            // or more with chance 1/n², so that no dead end holds the search for long.
            let back = (1.0 - rng.random::<f64>()).powf(-0.5) as usize;
            path.truncate(path.len().saturating_sub(back));
            continue;
        };
        if let Some(hop) = cube.hop(&state) {
            path.push(hop);
        }
        if path.len() == count + 1 {
            return Ok(cube.truth(&path));
        }
    }
    Err(TruthError::NotFound { count, tries })
}

impl Throw {
    /// Thrown up from above the table, any way round.
    fn start(&self, rng: &mut impl Rng) -> State {
        let mut normal = || -> f64 { StandardNormal.sample(rng) };
        let quaternion = Quaternion::new(normal(), normal(), normal(), normal());
        State {
            position_m: Vector3::new(0.0, 0.0, self.height_m),
            orientation: UnitQuaternion::new_normalize(quaternion),
            velocity_m_s: Vector3::new(
                0.2 + 0.05 * normal(),
                0.05 * normal(),
                0.5 + 0.2 * normal(),
            ) * self.speed_m_s,
            angular_velocity_rad_s: Vector3::new(normal(), normal(), normal()) * self.spin_rad_s,
        }
    }
}

pub(super) struct Bouncer {
    solid: Polyhedron,
    throw: Throw,
    body: Body,
    gravity_m_s2: Vector3<f64>,
    corners_m: Vec<Vector3<f64>>,
}

impl Bouncer {
    pub(super) fn new(solid: Polyhedron, throw: Throw) -> Self {
        let half_m = throw.half_m;
        let square_m2 = (2.0 * half_m) * (2.0 * half_m);
        let moments_kg_m2 = match solid {
            Polyhedron::Cube => Vector3::repeat(MASS_KG * square_m2 / 6.0),
            // m s²/20 with an edge that is a diagonal of a face.
            Polyhedron::Tetrahedron => Vector3::repeat(MASS_KG * square_m2 / 10.0),
            Polyhedron::Brick | Polyhedron::Stick => {
                let squares = solid.sides().map(|side| side * side);
                squares.map(|own| MASS_KG * square_m2 * (squares.sum() - own) / 12.0)
            }
        };
        let is_corner = |corner: &usize| match solid {
            Polyhedron::Tetrahedron => corner.count_ones().is_multiple_of(2),
            _ => true,
        };
        let halves_m = solid.sides() * half_m;
        let sign = |corner: usize, axis: usize| {
            if corner >> axis & 1 == 0 {
                -halves_m[axis]
            } else {
                halves_m[axis]
            }
        };
        let drag = Drag {
            quadratic_per_m: throw.quadratic_drag_per_m,
            ..Drag::default()
        };
        Self {
            solid,
            throw,
            body: Body::new(MASS_KG, moments_kg_m2)
                .and_then(|body| body.with_drag(drag))
                .expect("it is a body"),
            gravity_m_s2: Vector3::new(0.0, 0.0, -9.80665),
            corners_m: (0..8)
                .filter(is_corner)
                .map(|c| Vector3::from_fn(|axis, _| sign(c, axis)))
                .collect(),
        }
    }

    pub(super) fn flight(&self) -> Flight<'_> {
        Flight {
            body: &self.body,
            gravity_m_s2: &self.gravity_m_s2,
        }
    }

    pub(super) fn encounter(&self, corner: usize, restitution: f64) -> Encounter {
        let (on_table_m, up) = (Vector3::zeros(), Vector3::z());
        Encounter::of_corner(
            &self.body,
            self.corners_m[corner],
            on_table_m,
            up,
            restitution,
        )
    }

    /// Heights of the corners and their indices, lowest first.
    pub(super) fn heights_m(&self, state: &State) -> Vec<(f64, usize)> {
        let mut heights: Vec<_> = (0..self.corners_m.len())
            .map(|corner| {
                let height_m = self.encounter(corner, 1.0).gap_m(state, &still());
                (height_m, corner)
            })
            .collect();
        heights.sort_by(|a, b| a.0.total_cmp(&b.0));
        heights
    }

    pub(super) fn bounced(&self, hop: &Hop) -> State {
        let before = self.flight().advance(&hop.state, hop.duration_s);
        if self.throw.friction == 0.0 {
            let bounce = self.encounter(hop.corner, hop.restitution);
            return bounce.after(&before, &still()).0;
        }
        let corner = contact::Feature::corner(self.corners_m[hop.corner]);
        let table = contact::Feature::face(Vector3::zeros(), Vector3::z());
        let contact = Contact::new(corner, table).expect("a corner touches a face");
        let contacts = ContactSet::with_friction(&[contact]).expect("one has friction");
        let side = Side {
            body: &self.body,
            state: &before,
        };
        let law = Law {
            friction: self.throw.friction,
            ..Law::frictionless(hop.restitution)
        };
        let impact = contacts.impact(&side, None, &law).expect("it touches");
        State {
            velocity_m_s: impact.after[0].velocity_m_s,
            angular_velocity_rad_s: impact.after[0].angular_velocity_rad_s,
            ..before
        }
    }

    /// The flight from a state, if it is a good one.
    fn hop(&self, state: &State) -> Option<Hop> {
        let throw = &self.throw;
        let spin_rad_s = state.angular_velocity_rad_s.norm();
        if spin_rad_s > throw.fastest_rad_s {
            return None;
        }
        let scan_s = SCAN_S.min(SCAN_RAD / spin_rad_s);
        let flight = self.flight();
        let lowest_m = |time_s: f64| {
            let state = flight.advance(state, time_s);
            let turned = state.orientation.inverse_transform_vector(&Vector3::z());
            let below_m = match self.solid {
                Polyhedron::Cube => throw.half_m * turned.abs().sum(),
                Polyhedron::Brick | Polyhedron::Stick => {
                    throw.half_m * turned.abs().dot(&self.solid.sides())
                }
                Polyhedron::Tetrahedron => {
                    let depths_m = self.corners_m.iter().map(|corner_m| -turned.dot(corner_m));
                    depths_m.fold(f64::NEG_INFINITY, f64::max)
                }
            };
            state.position_m.z - below_m
        };
        if lowest_m(scan_s) <= 0.0 {
            return None;
        }
        let duration_s = crossing_s(scan_s, throw.longest_s, lowest_m)?;
        let before = flight.advance(state, duration_s);
        let heights = self.heights_m(&before);
        let (corner, next_m) = (heights[0].1, heights[1].0);
        let approach_m_s = -self.encounter(corner, 1.0).speed_m_s(&before, &still());
        let is_good = duration_s >= throw.shortest_s
            && approach_m_s >= throw.slowest_approach_m_s
            && next_m >= throw.clearest_m;
        is_good.then_some(Hop {
            state: *state,
            duration_s,
            corner,
            restitution: 1.0,
            choice: 0,
        })
    }

    /// The record of a path; it ends within its last flight.
    pub(super) fn truth(&self, path: &[Hop]) -> Truth {
        let mut arcs = Vec::new();
        let mut event_times_s = Vec::new();
        let mut events = Vec::new();
        let mut laws = TiVec::new();
        let mut start_s = 0.0;
        for (index, hop) in path.iter().enumerate() {
            let is_last = index + 1 == path.len();
            let share = if is_last { self.throw.last_share } else { 1.0 };
            let end_s = start_s + share * hop.duration_s;
            let (name, kind) = if is_last {
                ("end".to_owned(), EventKind::End)
            } else {
                let name = format!("bounce {}", index + 1);
                let law = ContactLaw {
                    friction: self.throw.friction,
                    ..ContactLaw::frictionless(name.clone(), hop.restitution)
                };
                let law = laws.push_and_get_key(law);
                let bounce = Collision::bounce(LinkIndex(0), hop.corner, 0, law);
                (name, EventKind::Collision(bounce))
            };
            events.push(Event::new(name, kind));
            event_times_s.push(end_s);
            arcs.push(ArcEstimate {
                mechanism: MechanismIndex(0),
                epoch_s: start_s,
                state: hop.state,
                start_s,
                end_s,
                support: None,
                certainty: None,
            });
            start_s = end_s;
        }
        Truth {
            scene: self.scene(events, laws),
            is_physical: true,
            parameters: Vec::new(),
            arcs,
            event_times_s,
            duration_s: start_s,
        }
    }

    fn scene(&self, events: Vec<Event>, contact_laws: TiVec<ContactLawIndex, ContactLaw>) -> Scene {
        let feature = |(corner, point_m): (usize, &Vector3<f64>)| Feature {
            name: format!("corner_{corner}"),
            geometry: contact::Feature::corner(*point_m),
        };
        let cube = FreeBody {
            name: "cube".to_owned(),
            topic: "/tracker/cube/pose".to_owned(),
            body: self.body,
            shape: match self.solid {
                Polyhedron::Tetrahedron => Shape::Hull {
                    points_m: self.corners_m.clone(),
                },
                _ => Shape::Cuboid {
                    half_extents_m: self.solid.sides() * self.throw.half_m,
                },
            },
            body_from_tracker: Pose::translation(0.02, -0.03, self.throw.half_m),
            features: self.corners_m.iter().enumerate().map(feature).collect(),
        };
        let table = Surface {
            name: "table".to_owned(),
            geometry: contact::Feature::face(Vector3::zeros(), Vector3::z()),
            obstacle: None,
        };
        let mut scene = Scene {
            name: "cube, bouncing".to_owned(),
            gravity_m_s2: self.gravity_m_s2,
            timing: Timing::Unknown {
                tempo_sd_per_sqrt_s: 0.5,
            },
            mark_sd_s: None,
            marks_topic: "/marks".to_owned(),
            links: TiVec::new(),
            mechanisms: TiVec::new(),
            tracks: TiVec::new(),
            surfaces: vec![table],
            obstacles: Vec::new(),
            phases: Vec::new(),
            contact_laws,
            events,
            goals: Vec::new(),
            parameters: Vec::new(),
            cones: Vec::new(),
            velocity_gaps: VelocityGaps::WhenNeeded,
            settle_s: None,
            rest_goals: Vec::new(),
            weights: Weights {
                position_m: 0.01,
                orientation_rad: 0.1,
            },
            performer: Performer::Unsaid,
            tolerance_m: Scene::TOLERANCE_M,
        };
        scene.add(cube);
        scene.tolerance_m = scene.usual_tolerance_m();
        scene
    }
}
