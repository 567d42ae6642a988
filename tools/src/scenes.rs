//! Right performances drawn at random: what is thrown, among what, by which hand, before which tracker, with what marks.
//!
//! Nothing is left out because it is hard: a die of 5 mm acted by a hand that wanders by 8 cm is among them.

use enact::math::Pose;
use enact::motion::{Goal, GoalTarget, LinkIndex, Obstacle, Surface};
use enact::physics::{Shape, contact};
use nalgebra::{UnitQuaternion, Vector3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::case::Case;
use crate::perform::{Acting, Polyhedron, Throw, Truth, thrown};

/// Least and greatest length of what is thrown \[m\].
const SIDES_M: [f64; 2] = [0.005, 1.0];
/// About how fast it is thrown [m/s], as far as the spins below go with its length.
const SPEEDS_M_S: [f64; 2] = [0.3, 3.0];
const SPINS_RAD_S: [f64; 2] = [5.0, 200.0];
/// Of the tracker \[Hz\].
const RATES_HZ: [f64; 2] = [30.0, 1000.0];
/// Factor on the hand's wander.
const HANDS: [f64; 2] = [0.5, 4.0];
/// Seconds of the hand's wander per second acted.
const PACES: [f64; 2] = [0.4, 2.5];
/// How a hand rounds kinks [s, acted].
const KINKS_S: [f64; 2] = [0.004, 0.02];
/// Greatest number of bounces.
const BOUNCES: f64 = 10.0;
/// How near the true motion comes to what is beside it, in lengths of the body, and at least.
const CLEARANCE: f64 = 0.05;
/// Times at which distances are looked at \[s\].
const LOOK_S: f64 = 2e-3;

/// What is beside the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Beside {
    /// The table alone.
    Nothing,
    /// A wall.
    Wall,
    /// A box.
    Box,
    /// A bar.
    Bar,
}

/// What is asked of the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asked {
    /// Nothing.
    Nothing,
    /// That the centre of mass is where it truly is.
    Position,
    /// That the whole pose is the true one.
    Pose,
}

/// A performance drawn at random.
pub struct DrawnScene {
    /// Length of what is thrown \[m\].
    side_m: f64,
    /// Who acts it.
    acting: Acting,
    /// Whether marks are as people make them.
    pub has_rough_marks: bool,
    truth: Truth,
    seed: u64,
}

impl DrawnScene {
    /// The scene of a seed; `None` where no such motion was found.
    pub fn new(seed: u64, is_timing_known: bool) -> Option<Self> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x5CE7E);
        let solids = [
            Polyhedron::Cube,
            Polyhedron::Tetrahedron,
            Polyhedron::Brick,
            Polyhedron::Stick,
        ];
        let solid = one_of(&solids, &mut rng);
        let side_m = log_uniform(SIDES_M, &mut rng);
        let speed_m_s = log_uniform(SPEEDS_M_S, &mut rng);
        let [least, most] = SPINS_RAD_S;
        let spin_rad_s = (speed_m_s / (0.3 * side_m)).clamp(least, most);
        let bounces = log_uniform([1.0, BOUNCES + 1.0], &mut rng) as usize;
        let besides = [Beside::Nothing, Beside::Wall, Beside::Box, Beside::Bar];
        let beside = one_of(&besides, &mut rng);
        let has_rough_marks = rng.random();
        let kink_s = rng.random_range(KINKS_S[0]..KINKS_S[1]);
        let [rate_hz, distortion, wander_pace] =
            [RATES_HZ, HANDS, PACES].map(|of| log_uniform(of, &mut rng));
        let of_stamps = match is_timing_known {
            true => Acting::timing_known(),
            false => Acting::default(),
        };
        let acting = Acting {
            rate_hz,
            distortion,
            wander_pace,
            kink_s,
            stamp_jitter_s: of_stamps.stamp_jitter_s.min(0.1 / rate_hz),
            mark_error_s: match has_rough_marks {
                true => Acting::default().mark_error_s,
                false => 0.5 / rate_hz,
            },
            ..of_stamps
        };
        let throw = Throw::sized(side_m, spin_rad_s);
        let mut truth = thrown(solid, &throw, bounces, seed).ok()?;
        stand(&mut truth, beside, side_m, &mut rng)?;
        Some(Self {
            side_m,
            acting,
            has_rough_marks,
            truth,
            seed,
        })
    }

    /// The same, acted by a hand that wanders by no more than a share of the body's length.
    pub fn with_hand_up_to(mut self, share: f64) -> Self {
        let most = share * self.side_m / self.acting.wander_position_m;
        self.acting.distortion = self.acting.distortion.min(most);
        self
    }

    /// Its performance, with what is asked of its end.
    pub fn case(&self, asked: Asked) -> Case {
        let mut truth = self.truth.clone();
        let pose = truth.world_from_body(LinkIndex(0), truth.duration_s);
        let target = match asked {
            Asked::Nothing => None,
            Asked::Position => Some(GoalTarget::PositionWithin {
                lower_m: pose.translation.vector,
                upper_m: pose.translation.vector,
            }),
            Asked::Pose => Some(GoalTarget::Pose {
                world_from_body: pose,
            }),
        };
        truth.scene.goals.extend(target.map(|target| Goal {
            event: truth.scene.events.len() - 1,
            link: LinkIndex(0),
            target,
        }));
        Case::new(&truth, &self.acting, self.seed)
    }
}

/// Puts something beside the motion, so near that it is just not touched.
fn stand(truth: &mut Truth, beside: Beside, side_m: f64, rng: &mut ChaCha8Rng) -> Option<()> {
    let clear_m = side_m * rng.random_range(0.1 * CLEARANCE..CLEARANCE);
    let mut normal = || -> f64 { StandardNormal.sample(rng) };
    let level = Vector3::new(normal(), normal(), 0.0).try_normalize(1e-9)?;
    let half_extents_m = match beside {
        Beside::Nothing => return Some(()),
        Beside::Wall => {
            let extent_m = |pose: &Pose| -support_m(truth, pose, &-level);
            let poses = poses(truth);
            let nearest_m = poses.iter().map(extent_m).fold(f64::INFINITY, f64::min);
            truth.scene.surfaces.push(Surface {
                name: "wall".to_owned(),
                geometry: contact::Feature::face(level * (nearest_m - clear_m), level),
                obstacle: None,
            });
            return Some(());
        }
        Beside::Box => Vector3::new(0.6, 0.4, 0.5) * side_m,
        Beside::Bar => Vector3::new(0.05, 2.0, 0.05) * side_m,
    };
    let poses = poses(truth);
    let at = &poses[poses.len() * (20 + (60.0 * normal().abs().fract()) as usize) / 100];
    let way = match beside {
        // Across the way below or above it, or level beside it.
        Beside::Bar => Vector3::new(normal(), normal(), normal()).try_normalize(1e-9)?,
        _ => level,
    };
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), normal());
    let shape = Shape::Cuboid { half_extents_m };
    let place = |far_m: f64| Pose::from_parts((at.translation.vector + way * far_m).into(), turn);
    let body = truth.scene.links[LinkIndex(0)].shape.solid().ok()?;
    let solid = shape.solid().ok()?;
    let nearest_m = |far_m: f64| {
        let distance = |pose: &Pose| body.distance_m(pose, &solid, &place(far_m)).ok();
        poses
            .iter()
            .filter_map(distance)
            .fold(f64::INFINITY, f64::min)
    };
    // The nearest place from which on it is clear, from outside.
    let (mut inside_m, mut far_m) = (0.0, 8.0 * side_m);
    while nearest_m(far_m) < clear_m {
        far_m *= 2.0;
    }
    for _ in 0..30 {
        let middle_m = 0.5 * (inside_m + far_m);
        match nearest_m(middle_m) < clear_m {
            true => inside_m = middle_m,
            false => far_m = middle_m,
        }
    }
    let world_from_shape = place(far_m);
    truth.scene.obstacles.push(Obstacle {
        name: "beside".to_owned(),
        shape,
        world_from_shape,
    });
    Some(())
}

/// Poses along the true motion.
fn poses(truth: &Truth) -> Vec<Pose> {
    let count = (truth.duration_s / LOOK_S).ceil() as usize;
    let times_s = (0..=count).map(|index| truth.duration_s * index as f64 / count as f64);
    times_s
        .map(|time_s| truth.world_from_body(LinkIndex(0), time_s))
        .collect()
}

/// How far the body reaches along a direction \[m, world\].
fn support_m(truth: &Truth, pose: &Pose, along: &Vector3<f64>) -> f64 {
    let features = truth.scene.links[LinkIndex(0)].features.iter();
    let reaches_m = features.filter_map(|of| match of.geometry {
        contact::Feature::Point { point_m, .. } => {
            Some((pose * nalgebra::Point3::from(point_m)).coords.dot(along))
        }
        _ => None,
    });
    reaches_m.fold(f64::NEG_INFINITY, f64::max)
}

fn one_of<T: Copy>(choices: &[T], rng: &mut impl Rng) -> T {
    choices[rng.random_range(0..choices.len())]
}

fn log_uniform([least, most]: [f64; 2], rng: &mut impl Rng) -> f64 {
    rng.random_range(least.ln()..=most.ln()).exp()
}
