//! A cube, or a regular tetrahedron, that bounces along a table, as often as one likes: for studies
//! of cost and scaling.
//!
//! A free run of a cube soon has flights of a few milliseconds, when corner after corner hits.
//! So each bounce's restitution is chosen, from a few values, such that the flight after it is a
//! good one: depth-first search. Most choices are near 1, so that the energy lasts.

use enact::math::Pose;
use enact::motion::{
    ArcEstimate, Collision, Event, EventKind, Feature, Scene, SceneBody, Surface, Timing,
    VelocityGaps, Weights,
};
use enact::physics::{Body, Shape, State, contact};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::encounter::{Encounter, still};
use super::truth::{Flight, Truth, TruthError, crossing_s};

/// Half the cube's side, and half that of the cube about the tetrahedron [m].
const HALF_M: f64 = 0.15;
/// Mass of the cube [kg].
const MASS_KG: f64 = 1.0;
/// A good flight: not shorter than this [s],
const SHORTEST_S: f64 = 0.1;
/// nor longer [s],
const LONGEST_S: f64 = 1.0;
/// turning no faster than this [rad/s],
const FASTEST_RAD_S: f64 = 25.0;
/// ending with a corner that approaches at least this fast [m/s],
const SLOWEST_APPROACH_M_S: f64 = 0.5;
/// and the next corner at least this far off [m].
const CLEAREST_M: f64 = 0.002;
/// The least restitution is 1 minus this.
const WORST_LOSS: f64 = 0.15;
/// Values of restitution to choose from at a bounce.
const CHOICES: usize = 8;
/// Arcs looked at per bounce before giving up.
const TRIES_PER_BOUNCE: usize = 2000;
/// Contacts are looked for at this spacing [s]; no corner turns by more than 1° within it.
const SCAN_S: f64 = 1e-3;

/// A flight and the corner that ends it.
#[derive(Clone, Copy)]
struct Hop {
    state: State,
    duration_s: f64,
    corner: usize,
    restitution: f64,
    choice: usize,
}

/// What bounces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Polyhedron {
    Cube,
    /// Every other corner of the cube.
    Tetrahedron,
}

/// A motion of a cube with `count` bounces, each on a corner, then a last flight. No goals.
pub fn bounces(count: usize, seed: u64) -> Result<Truth, TruthError> {
    bounces_of(Polyhedron::Cube, count, seed)
}

/// The same of either.
pub fn bounces_of(solid: Polyhedron, count: usize, seed: u64) -> Result<Truth, TruthError> {
    let cube = Bouncer::new(solid);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut path: Vec<Hop> = Vec::new();
    let tries = TRIES_PER_BOUNCE * (count + 1);
    for _ in 0..tries {
        // Go on from the last hop with its next untried restitution, or begin anew.
        let next = match path.last_mut() {
            None => Some(thrown(&mut rng)),
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

/// A cube thrown up from above the table, any way round.
fn thrown(rng: &mut impl Rng) -> State {
    let mut normal = || -> f64 { StandardNormal.sample(rng) };
    let quaternion = Quaternion::new(normal(), normal(), normal(), normal());
    State {
        position_m: Vector3::new(0.0, 0.0, 0.5),
        orientation: UnitQuaternion::new_normalize(quaternion),
        velocity_m_s: Vector3::new(0.2 + 0.05 * normal(), 0.05 * normal(), 0.5 + 0.2 * normal()),
        angular_velocity_rad_s: Vector3::new(normal(), normal(), normal()) * 4.0,
    }
}

/// The scene file of such a motion.
pub fn scene_toml(truth: &Truth) -> String {
    let size_mm = 2e3 * HALF_M;
    let scene = &truth.scene;
    let cube = &scene.bodies[0];
    let tracker_mm = cube.body_from_tracker.translation.vector * 1e3;
    let moment_kg_m2 = cube.body.moments_kg_m2().x;
    let mut text = format!(
        "name = {:?}\n[timing]\nstamps = \"tempo\"\n[[body]]\nname = \"cube\"\n\
         shape = {{ kind = \"cuboid\", size_mm = [{size_mm:?}, {size_mm:?}, {size_mm:?}] }}\n\
         mass_kg = {MASS_KG:?}\nmoments_kg_m2 = [{moment_kg_m2:?}, {moment_kg_m2:?}, {moment_kg_m2:?}]\n\
         tracker = {{ position_mm = [{:?}, {:?}, {:?}] }}\n[body.features_mm]\n",
        scene.name, tracker_mm.x, tracker_mm.y, tracker_mm.z,
    );
    for feature in &cube.features {
        let contact::Feature::Point { point_m, .. } = feature.geometry else {
            continue;
        };
        let at_mm = point_m * 1e3;
        text += &format!(
            "{} = [{:?}, {:?}, {:?}]\n",
            feature.name, at_mm.x, at_mm.y, at_mm.z
        );
    }
    text += "[[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n";
    for event in &scene.events {
        text += &format!(
            "[[event]]\nname = {:?}\nkind = {:?}\n",
            event.name,
            event.kind.word()
        );
        if let Some(collision) = event.kind.collision()
            && let Some(feature) = collision.contacts[0].feature
        {
            let restitution = collision.restitution;
            text += &format!(
                "body = \"cube\"\nfeature = {:?}\nsurface = \"table\"\nrestitution = {restitution:?}\n",
                cube.features[feature].name,
            );
        }
    }
    text
}

struct Bouncer {
    solid: Polyhedron,
    body: Body,
    gravity_m_s2: Vector3<f64>,
    corners_m: Vec<Vector3<f64>>,
}

impl Bouncer {
    fn new(solid: Polyhedron) -> Self {
        let square_m2 = (2.0 * HALF_M) * (2.0 * HALF_M);
        let moment_kg_m2 = match solid {
            Polyhedron::Cube => MASS_KG * square_m2 / 6.0,
            // m s²/20 with an edge that is a diagonal of a face.
            Polyhedron::Tetrahedron => MASS_KG * square_m2 / 10.0,
        };
        let is_corner = |corner: &usize| match solid {
            Polyhedron::Cube => true,
            Polyhedron::Tetrahedron => corner.count_ones().is_multiple_of(2),
        };
        let sign = |corner: usize, axis: usize| {
            if corner >> axis & 1 == 0 {
                -HALF_M
            } else {
                HALF_M
            }
        };
        Self {
            solid,
            body: Body::new(MASS_KG, Vector3::repeat(moment_kg_m2)).expect("it is a body"),
            gravity_m_s2: Vector3::new(0.0, 0.0, -9.80665),
            corners_m: (0..8)
                .filter(is_corner)
                .map(|c| Vector3::from_fn(|axis, _| sign(c, axis)))
                .collect(),
        }
    }

    fn flight(&self) -> Flight<'_> {
        Flight {
            body: &self.body,
            gravity_m_s2: &self.gravity_m_s2,
        }
    }

    fn encounter(&self, corner: usize, restitution: f64) -> Encounter {
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
    fn heights_m(&self, state: &State) -> Vec<(f64, usize)> {
        let mut heights: Vec<_> = (0..self.corners_m.len())
            .map(|corner| {
                let height_m = self.encounter(corner, 1.0).gap_m(state, &still());
                (height_m, corner)
            })
            .collect();
        heights.sort_by(|a, b| a.0.total_cmp(&b.0));
        heights
    }

    fn bounced(&self, hop: &Hop) -> State {
        let before = self.flight().advance(&hop.state, hop.duration_s);
        let bounce = self.encounter(hop.corner, hop.restitution);
        bounce.after(&before, &still()).0
    }

    /// The flight from a state, if it is a good one.
    fn hop(&self, state: &State) -> Option<Hop> {
        if state.angular_velocity_rad_s.norm() > FASTEST_RAD_S {
            return None;
        }
        let flight = self.flight();
        let lowest_m = |time_s: f64| {
            let state = flight.advance(state, time_s);
            let turned = state.orientation.inverse_transform_vector(&Vector3::z());
            let below_m = match self.solid {
                Polyhedron::Cube => HALF_M * turned.abs().sum(),
                Polyhedron::Tetrahedron => {
                    let depths_m = self.corners_m.iter().map(|corner_m| -turned.dot(corner_m));
                    depths_m.fold(f64::NEG_INFINITY, f64::max)
                }
            };
            state.position_m.z - below_m
        };
        if lowest_m(SCAN_S) <= 0.0 {
            return None;
        }
        let duration_s = crossing_s(SCAN_S, LONGEST_S, lowest_m)?;
        let before = flight.advance(state, duration_s);
        let heights = self.heights_m(&before);
        let (corner, next_m) = (heights[0].1, heights[1].0);
        let approach_m_s = -self.encounter(corner, 1.0).speed_m_s(&before, &still());
        let is_good = duration_s >= SHORTEST_S
            && approach_m_s >= SLOWEST_APPROACH_M_S
            && next_m >= CLEAREST_M;
        is_good.then_some(Hop {
            state: *state,
            duration_s,
            corner,
            restitution: 1.0,
            choice: 0,
        })
    }

    /// The record of a path; it ends half-way through its last flight.
    fn truth(&self, path: &[Hop]) -> Truth {
        let mut arcs = Vec::new();
        let mut event_times_s = Vec::new();
        let mut events = Vec::new();
        let mut start_s = 0.0;
        for (index, hop) in path.iter().enumerate() {
            let is_last = index + 1 == path.len();
            let end_s = start_s + if is_last { 0.5 } else { 1.0 } * hop.duration_s;
            let (name, kind) = if is_last {
                ("end".to_owned(), EventKind::End)
            } else {
                let kind =
                    EventKind::Collision(Collision::bounce(0, hop.corner, 0, hop.restitution));
                (format!("bounce {}", index + 1), kind)
            };
            events.push(Event { name, kind });
            event_times_s.push(end_s);
            arcs.push(ArcEstimate {
                body: 0,
                epoch_s: start_s,
                state: hop.state,
                start_s,
                end_s,
            });
            start_s = end_s;
        }
        Truth {
            scene: self.scene(events),
            is_physical: true,
            parameters: Vec::new(),
            arcs,
            event_times_s,
            duration_s: start_s,
        }
    }

    fn scene(&self, events: Vec<Event>) -> Scene {
        let feature = |(corner, point_m): (usize, &Vector3<f64>)| Feature {
            name: format!("corner_{corner}"),
            geometry: contact::Feature::corner(*point_m),
        };
        let cube = SceneBody {
            name: "cube".to_owned(),
            topic: "/tracker/cube/pose".to_owned(),
            body: self.body,
            shape: match self.solid {
                Polyhedron::Cube => Shape::Cuboid {
                    half_extents_m: Vector3::repeat(HALF_M),
                },
                Polyhedron::Tetrahedron => Shape::Hull {
                    points_m: self.corners_m.clone(),
                },
            },
            body_from_tracker: Pose::translation(0.02, -0.03, HALF_M),
            features: self.corners_m.iter().enumerate().map(feature).collect(),
        };
        let table = Surface {
            name: "table".to_owned(),
            geometry: contact::Feature::face(Vector3::zeros(), Vector3::z()),
            obstacle: None,
        };
        Scene {
            name: "cube, bouncing".to_owned(),
            gravity_m_s2: self.gravity_m_s2,
            timing: Timing::Unknown {
                tempo_sd_per_sqrt_s: 0.5,
            },
            marks_topic: "/marks".to_owned(),
            bodies: vec![cube],
            surfaces: vec![table],
            obstacles: Vec::new(),
            events,
            goals: Vec::new(),
            parameters: Vec::new(),
            cones: Vec::new(),
            velocity_gaps: VelocityGaps::WhenNeeded,
            settle_s: None,
            weights: Weights {
                position_m: 0.01,
                orientation_rad: 0.1,
            },
        }
    }
}
