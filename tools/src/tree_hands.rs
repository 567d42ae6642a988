//! Performances of pendulums that hang from a handle: a hand swings it, and a tracker sees the handle, another the tip.

use std::path::Path;

use enact::config::scene_from_toml;
use enact::math::Pose;
use enact::motion::held::Driven;
use enact::motion::{Holds, Mark, PoseSample, Scene, Stamp, TakeEvent, TrackIndex};
use enact::physics::State;
use enact::physics::tree::{
    Carrier, Flow, Forest, ForestSnapshot, Hand, Snapshot, Tree, TreeState, tableau,
};
use enact::write::WriteError;
use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::perform::recording;
use crate::perform::wander::{HAND_POSITION, Wander};
use crate::trees::{Jointed, ROD_M, joint_toml};

/// Number of rods that hang from the handle.
const RODS: usize = 2;
/// Where the first joint is below the handle's centre \[m\].
const BELOW_M: f64 = 0.06;
/// Samples per second.
pub const RATE_HZ: f64 = 120.0;
/// Duration \[s\].
pub const LASTS_S: f64 = 0.9;
/// How fast a tip falls at least that hits a table [m/s].
const FALLS_M_S: f64 = 0.4;
/// What the handle's tracker sees, and that of the tip.
const HAND: TrackIndex = TrackIndex(0);
const TIP: TrackIndex = TrackIndex(1);
/// First stamp \[ns\].
const BEGINS_NS: i64 = 1_000_000_000;

/// How it is acted and seen.
#[derive(Clone, Copy, Debug)]
pub struct HandActing {
    /// Smooth wander of the tip: rms distance \[m\].
    pub wander_m: f64,
    /// White noise of the tip per axis \[m\].
    pub noise_m: f64,
    /// White noise of the handle's tracker per axis, of places \[m\] and of turns \[rad\].
    pub hand: [f64; 2],
}

impl HandActing {
    /// A usual hand, seen by usual trackers.
    pub const USUAL: Self = Self {
        wander_m: 0.02,
        noise_m: 0.001,
        hand: [0.001, 0.003],
    };
    /// As it was.
    pub const EXACT: Self = Self {
        wander_m: 0.0,
        noise_m: 0.0,
        hand: [0.0; 2],
    };
}

/// A performance.
#[derive(Clone, Debug)]
pub struct HandPerformance {
    /// Its scene file,
    pub scene_toml: String,
    /// and scene.
    pub scene: Scene,
    /// What was recorded.
    pub events: Vec<TakeEvent>,
    /// The true equations of motion, in the hand that truly moves so.
    pub tree: Tree,
    /// The true states at every sample.
    pub states: Vec<TreeState>,
}

impl HandPerformance {
    /// When an event is marked, from the first sample \[s\].
    ///
    /// # Panics
    /// Where it is not.
    pub fn marked_s(&self, event: &str) -> f64 {
        let mut marks = self.events.iter().filter_map(TakeEvent::mark);
        let mark = marks.find(|mark| mark.event.as_deref() == Some(event));
        1e-9 * (mark.expect("it is marked").stamp.0 - BEGINS_NS) as f64
    }

    /// Writes it with its scene.
    pub fn write(&self, path: &Path) -> Result<(), WriteError> {
        recording::write_events_of(&self.scene, &self.scene_toml, &self.events, path)
    }
}

/// A hand that swings: along and about every axis, in some rhythm.
#[derive(Clone, Copy, Debug)]
struct Swing {
    /// Per axis amplitude \[m\], frequency [rad/s], phase \[rad\].
    places: [[f64; 3]; 3],
    /// The same of turns about two axes, one after the other \[rad\].
    turns: [[f64; 3]; 2],
}

impl Swing {
    fn drawn(random: &mut ChaCha8Rng) -> Self {
        let mut wave = |most: f64| {
            let amplitude = most * (0.5 + 0.5 * random.random::<f64>());
            let frequency = 5.0 + 4.0 * random.random::<f64>();
            [
                amplitude,
                frequency,
                std::f64::consts::TAU * random.random::<f64>(),
            ]
        };
        Self {
            places: [wave(0.08), wave(0.08), wave(0.05)],
            turns: [wave(0.4), wave(0.4)],
        }
    }
}

/// Value, rate and acceleration.
fn wave([amplitude, frequency, phase]: [f64; 3], time_s: f64) -> [f64; 3] {
    let (sin, cos) = (frequency * time_s + phase).sin_cos();
    [
        amplitude * sin,
        amplitude * frequency * cos,
        -amplitude * frequency * frequency * sin,
    ]
}

impl Carrier for Swing {
    fn at(&self, time_s: f64) -> Driven {
        let along = self.places.map(|of| wave(of, time_s));
        let place = |of: usize| Vector3::new(along[0][of], along[1][of], along[2][of]);
        let [outer, inner] = self.turns.map(|of| wave(of, time_s));
        let (first, second) = (Vector3::y(), Vector3::x());
        let turn = |axis: Vector3<f64>, by: f64| UnitQuaternion::from_scaled_axis(axis * by);
        let back = turn(second, inner[0]).inverse() * first;
        Driven {
            state: State {
                position_m: Vector3::new(0.0, 0.0, 1.5) + place(0),
                orientation: turn(first, outer[0]) * turn(second, inner[0]),
                velocity_m_s: place(1),
                angular_velocity_rad_s: back * outer[1] + second * inner[1],
            },
            acceleration_m_s2: place(2),
            angular_acceleration_rad_s2: back * outer[2]
                - second.cross(&back) * (inner[1] * outer[1])
                + second * inner[2],
        }
    }
}

/// The scene file of two rods that hang from a handle.
pub fn scene_toml(joints: Jointed) -> String {
    let mut text = String::from(
        "name = \"pendulum in the hand\"\n\n[timing]\nstamps = \"physical\"\n\n[weights]\nposition_mm = 10\n\n\
         [[body]]\nname = \"handle\"\nheld = true\n\
         shape = { kind = \"cylinder\", length_mm = 100, radius_mm = 15 }\ntracker = { position_mm = [0, 20, 0] }\n",
    );
    for link in 1..=RODS {
        text += &format!(
            "\n[[body]]\nname = \"rod {link}\"\nshape = {{ kind = \"cylinder\", length_mm = {:?}, radius_mm = 5 }}\nmass_g = 100\n",
            1e3 * ROD_M,
        );
        text += &match link == RODS {
            true => format!(
                "\n[[body.track]]\nsees = \"point\"\ntracker = {{ position_mm = [0, 0, {:?}] }}\n",
                -500.0 * ROD_M
            ),
            false => "tracked = false\n".to_owned(),
        };
    }
    for link in 0..RODS {
        let joint = joint_toml(joints, link, -BELOW_M);
        text += &match link {
            0 => joint.replace("parent_at_mm", "parent = \"handle\"\nparent_at_mm"),
            _ => joint,
        };
    }
    text + "\n[[event]]\nname = \"start\"\nkind = \"start\"\n\n[[event]]\nname = \"end\"\nkind = \"end\"\n"
}

/// A hand with what hangs from it, and how that begins.
struct Begun {
    swing: Swing,
    tree: Tree,
    start: TreeState,
}

impl Begun {
    fn drawn(scene: &Scene, random: &mut ChaCha8Rng) -> Self {
        let (_, joined) = scene.joint_trees().next().expect("a tree");
        let swing = Swing::drawn(random);
        let model = joined.model(|link| scene.links[link].body);
        let tree = model.expect("a tree").in_hand(Hand::new(swing));
        let mut delta = vec![0.0; 2 * tree.freedoms()];
        for (at, entry) in delta.iter_mut().enumerate() {
            let most = if at < tree.freedoms() { 0.6 } else { 3.0 };
            *entry = most * (2.0 * random.random::<f64>() - 1.0);
        }
        let start = TreeState {
            time_s: 0.0,
            ..tree.retract(&tree.at_rest(), &delta)
        };
        Self { swing, tree, start }
    }

    /// States from one on at samples' times, of those after it until that of an index.
    fn flown(&self, scene: &Scene, from: &TreeState, until: usize) -> Vec<TreeState> {
        let mut flow = Flow::new(&self.tree, &scene.gravity_m_s2, tableau::DORMAND_PRINCE);
        flow.begin(from, false);
        let first = (from.time_s * RATE_HZ - 1e-9).ceil().max(0.0) as usize;
        let states = (first..=until).map(|index| {
            flow.reach(index as f64 / RATE_HZ - from.time_s, 5e-4);
            flow.state()
        });
        states.collect()
    }

    /// Place and velocity of the tip along z [m, m/s].
    fn tip(&self, scene: &Scene, state: &TreeState) -> [f64; 2] {
        let mut snapshot = Snapshot::new(&self.tree, &scene.gravity_m_s2);
        snapshot.set(state);
        let tip_m = scene.tracks[TIP].point_m();
        [
            snapshot.point(RODS - 1, &tip_m).z,
            snapshot.point_velocity(RODS - 1, &tip_m).z,
        ]
    }
}

/// The same above a table, on which the tip bounces.
fn struck_toml(joints: Jointed, table_m: f64) -> String {
    let hit = format!(
        "[[surface]]\nname = \"table\"\npoint_mm = [0, 0, {:?}]\nnormal = [0, 0, 1]\n\n\
         [[event]]\nname = \"hit\"\nkind = \"collision\"\nbody = \"rod {RODS}\"\nfeature = \"tip\"\nsurface = \"table\"\n\
         restitution = 0.6\nfriction = 0.1\n\n",
        1e3 * table_m
    );
    let tip = format!(
        "mass_g = 100\nfeatures_mm = {{ tip = [0, 0, {:?}] }}\n",
        -500.0 * ROD_M
    );
    let end = "[[event]]\nname = \"end\"";
    let text = scene_toml(joints).replace("mass_g = 100\n", &tip);
    text.replace(end, &(hit + end))
}

/// Acts a motion.
pub fn perform(joints: Jointed, acting: &HandActing, seed: u64) -> HandPerformance {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let scene_toml = scene_toml(joints);
    let scene = scene_from_toml(&scene_toml).expect("a valid scene");
    let begun = Begun::drawn(&scene, &mut random);
    let last = (LASTS_S * RATE_HZ).round() as usize;
    let states = begun.flown(&scene, &begun.start, last);
    let marks = [("start", 0.0), ("end", LASTS_S)];
    seen((scene, scene_toml), begun, states, acting, &marks, random)
}

/// The same where the tip hits a table, from which it bounces; `None` where it does not come down on one.
pub fn strike(joints: Jointed, acting: &HandActing, seed: u64) -> Option<HandPerformance> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let free = scene_from_toml(&scene_toml(joints)).expect("a valid scene");
    let begun = Begun::drawn(&free, &mut random);
    let last = (LASTS_S * RATE_HZ).round() as usize;
    let before = begun.flown(&free, &begun.start, last);
    // It falls on the table from above all that it was until then.
    let hit = (last / 3..2 * last / 3).find(|at| {
        let [z_m, speed_m_s] = begun.tip(&free, &before[*at]);
        let mut earlier = before[..*at].iter();
        speed_m_s < -FALLS_M_S && earlier.all(|state| begun.tip(&free, state)[0] > z_m)
    })?;
    let mut flow = Flow::new(&begun.tree, &free.gravity_m_s2, tableau::DORMAND_PRINCE);
    flow.begin(&begun.start, false);
    let hit_s = (hit as f64 + 0.4) / RATE_HZ;
    flow.reach(hit_s, 5e-4);
    let touching = flow.state();
    let [table_m, _] = begun.tip(&free, &touching);
    let scene_toml = struck_toml(joints, table_m);
    let scene = scene_from_toml(&scene_toml).expect("a valid scene");
    let forest = Forest::new(vec![begun.tree.clone()]);
    let mut snapshot = ForestSnapshot::new(&forest, &scene.gravity_m_s2);
    snapshot.set(&touching);
    let touch = scene.tree_touch(1).expect("what touches");
    let impact = snapshot.impact(&touching, &touch.at, &touch.law).ok()?;
    let after = TreeState {
        rates: impact.rates,
        ..touching
    };
    let mut states = before[..=hit].to_vec();
    let bounced = begun.flown(&scene, &after, last);
    // Until it comes down again.
    let above = |state: &&TreeState| begun.tip(&scene, state)[0] > table_m;
    states.extend(bounced.iter().take_while(above).cloned());
    let end_s = (states.len() - 1) as f64 / RATE_HZ;
    let marks = [("start", 0.0), ("hit", hit_s), ("end", end_s)];
    let is_seen = states.len() > hit + 10;
    is_seen.then(|| seen((scene, scene_toml), begun, states, acting, &marks, random))
}

/// What trackers see of states at samples' times.
fn seen(
    (scene, scene_toml): (Scene, String),
    Begun { swing, tree, .. }: Begun,
    states: Vec<TreeState>,
    acting: &HandActing,
    marks: &[(&str, f64)],
    mut random: ChaCha8Rng,
) -> HandPerformance {
    let wanders: Vec<Wander> = (0..3)
        .map(|_| Wander::draw(&HAND_POSITION, &mut random))
        .collect();
    let stamp = |index: usize| Stamp(BEGINS_NS + (1e9 * index as f64 / RATE_HZ).round() as i64);
    let mut snapshot = Snapshot::new(&tree, &scene.gravity_m_s2);
    let mut events: Vec<TakeEvent> = Vec::new();
    let mounted = scene.tracks[HAND].link_from_tracker;
    for (index, state) in states.iter().enumerate() {
        let mut white = |sd: f64| {
            Vector3::from_fn(|_, _| {
                let noise: f64 = StandardNormal.sample(&mut random);
                sd * noise
            })
        };
        let held = swing.at(state.time_s).state.world_from_body() * mounted;
        let off = Pose::from_parts(
            white(acting.hand[0]).into(),
            UnitQuaternion::from_scaled_axis(white(acting.hand[1])),
        );
        let seen = Pose::from_parts(
            (held.translation.vector + off.translation.vector).into(),
            held.rotation * off.rotation,
        );
        let mut send = |track: TrackIndex, sample: PoseSample| {
            events.push(TakeEvent::Pose {
                track,
                stream: 0,
                sample,
            });
        };
        send(HAND, PoseSample::from_pose(stamp(index), &seen));
        snapshot.set(state);
        let at_m = snapshot.point(RODS - 1, &scene.tracks[TIP].point_m());
        // A hand acts at a third of the motion's speed.
        let astray = wanders.iter().map(|wander| wander.at(3.0 * state.time_s));
        let astray = Vector3::from_iterator(astray) * (acting.wander_m / 3.0_f64.sqrt());
        let at_m = at_m + astray + white(acting.noise_m);
        let pose = Pose::from_parts(at_m.into(), UnitQuaternion::identity());
        let mut sample = PoseSample::from_pose(stamp(index), &pose);
        sample.holds = Holds::Position;
        send(TIP, sample);
    }
    for (name, time_s) in marks {
        events.push(TakeEvent::Mark(Mark {
            stamp: Stamp(BEGINS_NS + (1e9 * time_s).round() as i64),
            event: Some((*name).into()),
        }));
    }
    HandPerformance {
        scene_toml,
        scene,
        events,
        tree,
        states,
    }
}
