//! A ball that bounces once, and a lamp that hangs still beside it: nothing ties one to the other.

use enact::config::scene_from_toml;
use enact::math::Pose;
use enact::motion::{Mark, PoseSample, Scene, Stamp, TakeEvent, TrackIndex};
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

const RADIUS_M: f64 = 0.02;
const FALL_M_S2: f64 = -9.80665;
/// The lamp's length \[m\].
const LAMP_M: f64 = 0.2;
/// How far a hand wanders \[m\].
const WANDER_M: f64 = 0.003;
/// Standard deviation of a tracker's positions \[m\].
const NOISE_M: f64 = 0.0005;

/// What was performed.
#[derive(Clone, Debug)]
pub struct Beside {
    /// Restitution of the ball.
    restitution: f64,
    /// Where the lamp hangs \[mm\].
    pub nail_mm: [f64; 3],
    /// Kind of its joint, with its keys.
    joint: &'static str,
    rate_hz: f64,
    from_m: Vector3<f64>,
    thrown_m_s: Vector3<f64>,
    bounce_s: f64,
    end_s: f64,
    phases: [f64; 2],
    seed: u64,
}

impl Beside {
    /// A throw and a lamp, some metres away.
    pub fn of(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut within = |from: f64, to: f64| random.random_range(from..to);
        let (bounce_s, restitution) = (within(0.3, 0.5), within(0.6, 0.9));
        let from_m = Vector3::new(within(-0.2, 0.2), within(-0.2, 0.2), within(0.3, 0.6));
        let way_m = RADIUS_M - from_m.z - 0.5 * FALL_M_S2 * bounce_s * bounce_s;
        let thrown_m_s = Vector3::new(within(-1.0, 1.0), within(-1.0, 1.0), way_m / bounce_s);
        let leaves_m_s = -restitution * (thrown_m_s.z + FALL_M_S2 * bounce_s);
        let flies_s = -2.0 * leaves_m_s / FALL_M_S2;
        let joints = [
            "kind = \"ball\"",
            "kind = \"pin\"\naxis = [1, 0, 0]",
            "kind = \"universal\"\naxes = [[1, 0, 0], [0, 1, 0]]",
        ];
        Self {
            restitution,
            nail_mm: [within(3e3, 6e3), within(-2e3, 2e3), within(1e3, 2e3)],
            joint: joints[within(0.0, 3.0) as usize],
            rate_hz: within(60.0, 240.0),
            from_m,
            thrown_m_s,
            bounce_s,
            end_s: bounce_s + 0.85 * flies_s,
            phases: [within(0.0, 6.0), within(0.0, 6.0)],
            seed,
        }
    }

    /// The scene of the ball, with further keys of it and further tables.
    pub fn ball_toml(&self, of_ball: &str, further: &str) -> String {
        format!(
            "name = \"ball\"\n[timing]\nstamps = \"physical\"\n[weights]\nposition_mm = 10\n\
             [[body]]\nname = \"ball\"\nshape = {{ kind = \"sphere\", radius_mm = {} }}\nmass_g = 50\n{of_ball}\n\
             [[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
             [[event]]\nname = \"start\"\nkind = \"start\"\n\
             [[event]]\nname = \"bounce\"\nkind = \"collision\"\nbody = \"ball\"\nsurface = \"table\"\n\
             restitution = {}\nfriction = 0\n\
             [[event]]\nname = \"end\"\nkind = \"end\"\n{further}",
            1e3 * RADIUS_M,
            self.restitution
        )
    }

    /// The same with the lamp.
    pub fn toml(&self, of_ball: &str, further: &str) -> String {
        let ball = self.ball_toml(of_ball, further);
        let (length_mm, nail_mm, joint) = (1e3 * LAMP_M, self.nail_mm, self.joint);
        format!(
            "{ball}[[body]]\nname = \"lamp\"\nshape = {{ kind = \"cylinder\", length_mm = {length_mm}, radius_mm = 10 }}\nmass_g = 200\n\
             [[joint]]\nname = \"hook\"\n{joint}\nparent_at_mm = {nail_mm:?}\nchild = \"lamp\"\nchild_at_mm = [0, 0, {}]\n",
            0.5 * length_mm
        )
    }

    /// The scene of both.
    ///
    /// # Panics
    /// Where the scene is none: it is.
    pub fn scene(&self) -> Scene {
        scene_from_toml(&self.toml("", "")).expect("a valid scene")
    }

    /// Where the ball's centre is at a time \[m\].
    pub fn ball_m(&self, time_s: f64) -> Vector3<f64> {
        let fall = Vector3::new(0.0, 0.0, FALL_M_S2);
        let flown = |from_m: Vector3<f64>, speed_m_s: Vector3<f64>, for_s: f64| {
            from_m + speed_m_s * for_s + fall * (0.5 * for_s * for_s)
        };
        let after_s = time_s - self.bounce_s;
        if after_s <= 0.0 {
            return flown(self.from_m, self.thrown_m_s, time_s);
        }
        let mut leaves_m_s = self.thrown_m_s + fall * self.bounce_s;
        leaves_m_s.z *= -self.restitution;
        let at_m = flown(self.from_m, self.thrown_m_s, self.bounce_s);
        flown(at_m, leaves_m_s, after_s)
    }

    /// What a hand records of the ball.
    pub fn take_of_ball(&self) -> Vec<TakeEvent> {
        let mut events = self.poses(0, |time_s| self.ball_m(time_s));
        let marks = [
            ("start", 0.0),
            ("bounce", self.bounce_s),
            ("end", self.end_s),
        ];
        events.extend(marks.map(|(name, time_s)| {
            TakeEvent::Mark(Mark {
                stamp: stamp(time_s),
                event: Some(name.to_owned()),
            })
        }));
        events
    }

    /// What hands record of both.
    pub fn take(&self) -> Vec<TakeEvent> {
        let nail_m = Vector3::from(self.nail_mm) * 1e-3;
        let centre_m = nail_m - Vector3::new(0.0, 0.0, 0.5 * LAMP_M);
        let mut events = self.take_of_ball();
        events.extend(self.poses(1, |_| centre_m));
        events
    }

    fn poses(&self, track: usize, at_m: impl Fn(f64) -> Vector3<f64>) -> Vec<TakeEvent> {
        let phase = self.phases[track];
        let wander_m = |time_s: f64| {
            let of = |rate: f64, off: f64| WANDER_M * (rate * time_s + off + phase).sin();
            Vector3::new(of(5.0, 0.0), of(7.0, 1.0), of(4.0, 2.0))
        };
        let counts = 0..=(self.end_s * self.rate_hz) as usize;
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(1 + track as u64);
        let poses = counts.map(|count| {
            let time_s = count as f64 / self.rate_hz;
            let mut noise_m = || NOISE_M * random.sample::<f64, _>(StandardNormal);
            let noise_m = Vector3::from_fn(|_, _| noise_m());
            let at_m = Translation3::from(at_m(time_s) + wander_m(time_s) + noise_m);
            let pose = Pose::from_parts(at_m, UnitQuaternion::identity());
            TakeEvent::Pose {
                track: TrackIndex(track),
                stream: 0,
                sample: PoseSample::from_pose(stamp(time_s), &pose),
            }
        });
        poses.collect()
    }
}

fn stamp(time_s: f64) -> Stamp {
    Stamp((time_s * 1e9).round() as i64)
}
