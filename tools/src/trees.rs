//! Performances of bodies joined in trees: true motions of chains and pendulums, and how a hand acts them.

use std::path::Path;

use enact::config::scene_from_toml;
use enact::estimate::tree::part::Part;
use enact::estimate::tree::program::TreeProgram;
use enact::estimate::tree::{TreePoint, TreeProblem};
use enact::motion::{
    Holds, JointTree, Mark, PoseSample, Scene, Sees, Stamp, TakeEvent, TrackIndex,
};
use enact::optimise::Program;
use enact::physics::State;
use enact::physics::tree::{Flow, Snapshot, Tree, TreeState, tableau};
use enact::segment::clean::clean;
use enact::write::WriteError;
use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::perform::recording;
use crate::perform::tempo::Tempo;
use crate::perform::wander::{HAND_POSITION, Wander};

/// A kind of joint in scene files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Jointed {
    /// Pins about one axis.
    Pin,
    /// Universal joints.
    Universal,
    /// Balls.
    Ball,
}

impl Jointed {
    fn toml(self) -> &'static str {
        match self {
            Self::Pin => "kind = \"pin\"\naxis = [1, 0, 0]",
            Self::Universal => "kind = \"universal\"\naxes = [[1, 0, 0], [0, 1, 0]]",
            Self::Ball => "kind = \"ball\"",
        }
    }
}

/// What moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kind {
    /// Number of rods.
    pub links: usize,
    /// How they are joined.
    pub joints: Jointed,
    /// Whether the first hangs from the world.
    pub is_clamped: bool,
    /// Duration \[s\].
    pub duration_s: f64,
}

impl Kind {
    /// The paper's chain: three rods that fly, with universal joints.
    pub const CHAIN: Kind = Kind {
        links: 3,
        joints: Jointed::Universal,
        is_clamped: false,
        duration_s: 0.9,
    };

    /// A pendulum of some rods.
    pub const fn pendulum(links: usize, joints: Jointed) -> Self {
        Self {
            links,
            joints,
            is_clamped: true,
            duration_s: 0.9,
        }
    }
}

/// Length of a rod \[m\].
pub const ROD_M: f64 = 0.2;

/// Samples per second.
pub const RATE_HZ: f64 = 120.0;

/// A performance of a tree.
#[derive(Clone)]
pub struct TreePerformance {
    /// Its scene file.
    pub scene_toml: String,
    /// The scene.
    pub scene: Scene,
    /// What was recorded.
    pub events: Vec<TakeEvent>,
    /// The true state at the beginning.
    pub truth: TreeState,
    /// Its duration \[s\].
    pub duration_s: f64,
    /// The true physical time of each sample \[s\].
    pub sample_times_s: Vec<f64>,
    /// The hidden tempo of slow motion.
    pub tempo: Option<Tempo>,
}

/// How it is acted.
#[derive(Clone, Copy, Debug)]
pub struct TreeActing {
    /// Smooth wander: rms distance \[m\].
    pub wander_m: f64,
    /// White noise per axis \[m\].
    pub noise_m: f64,
    /// Samples per second.
    pub rate_hz: f64,
    /// Whether the whole configuration at the start is a goal.
    pub asks_start: bool,
    /// Slow motion: acted per physical time on the whole, and the standard deviation of the logarithm of the tempo. None:
    /// stamps are physical times.
    pub slowly: Option<[f64; 2]>,
}

impl TreeActing {
    /// A hand whose wander is so many times a usual one's.
    pub fn of(distortion: f64) -> Self {
        Self {
            wander_m: 0.02 * distortion,
            noise_m: 0.001,
            rate_hz: RATE_HZ,
            asks_start: true,
            slowly: None,
        }
    }

    /// The same, acted in slow motion as a usual hand does.
    pub fn slowly(self) -> Self {
        Self {
            slowly: Some([2.5, 0.3]),
            ..self
        }
    }
}

/// A moment of a performance \[s\].
#[derive(Clone, Copy, Debug)]
struct Instant {
    /// Since the start, by the tracker's clock,
    stamp_s: f64,
    /// in the motion,
    physical_s: f64,
    /// and for the hand.
    acted_s: f64,
}

impl TreeActing {
    /// The tempo of a performance.
    fn tempo(&self, duration_s: f64, seed: u64) -> Option<Tempo> {
        let [slowdown, variation] = self.slowly?;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(1);
        Some(Tempo::draw(duration_s, slowdown, variation, &mut random))
    }

    /// When samples are taken, the end last.
    fn instants(&self, duration_s: f64, tempo: Option<&Tempo>) -> Vec<Instant> {
        let Some(tempo) = tempo else {
            let count = (duration_s * self.rate_hz).round() as usize;
            let at = |index: usize| {
                let physical_s = index as f64 / self.rate_hz;
                // A hand acts at a third of the motion's speed.
                let acted_s = 3.0 * index as f64 / self.rate_hz;
                Instant {
                    stamp_s: physical_s,
                    physical_s,
                    acted_s,
                }
            };
            return (0..=count).map(at).collect();
        };
        let lasts_s = tempo.acted_duration_s();
        let at = |acted_s: f64| Instant {
            stamp_s: acted_s,
            physical_s: tempo.physical_s(acted_s),
            acted_s,
        };
        let count = (lasts_s * self.rate_hz).ceil() as usize;
        let steps = (0..count).map(|index| at(index as f64 / self.rate_hz));
        steps.chain([at(lasts_s)]).collect()
    }
}

impl TreePerformance {
    /// The equations of motion.
    pub fn tree(&self) -> Tree {
        let (_, joined) = self.scene.joint_trees().next().expect("a tree");
        self.scene.tree_model(joined)
    }

    /// Writes it with its scene.
    pub fn write(&self, path: &Path) -> Result<(), WriteError> {
        recording::write_events_of(&self.scene, &self.scene_toml, &self.events, path)
    }

    /// The objective of the true motion.
    pub fn truth_cost(&self) -> f64 {
        let (sketch, _) = clean(&self.scene, &self.events).expect("a sketch");
        let mut problem = TreeProblem::new(&self.scene, &sketch);
        problem.step_s = 1.0 / RATE_HZ;
        let mut point = TreePoint::new(&problem, vec![self.truth.clone()]);
        if let (Some(of), Some(tempo)) = (&problem.tempo, &self.tempo) {
            let pieces = of.knots_s.windows(2);
            let pace = |ends_s: &[f64]| {
                let [from_s, to_s] =
                    [ends_s[0], ends_s[1]].map(|acted_s| tempo.physical_s(acted_s));
                (to_s - from_s) / (ends_s[1] - ends_s[0])
            };
            point.log_paces = pieces.map(|ends_s| pace(ends_s).ln()).collect();
        }
        let program = TreeProgram::new(&problem, point.clone());
        2.0 * program.evaluated(&Part::whole(), &point).cost
    }
}

/// The recording that the repository keeps, in the scene of `config/chain.toml`.
pub fn kept() -> (&'static str, TreePerformance) {
    const SEED: u64 = 7001;
    let mut performance = perform(&Kind::CHAIN, &TreeActing::of(1.0), SEED);
    performance.scene_toml = include_str!("../../config/chain.toml").into();
    performance.scene = scene_from_toml(&performance.scene_toml).expect("a valid scene");
    ("chain.mcap", performance)
}

/// Acts a motion.
pub fn perform(kind: &Kind, acting: &TreeActing, seed: u64) -> TreePerformance {
    perform_as(kind, acting, seed, str::to_owned)
}

/// Acts a motion in the scene that `said` makes of the usual one.
pub fn perform_as(
    kind: &Kind,
    acting: &TreeActing,
    seed: u64,
    said: impl Fn(&str) -> String,
) -> TreePerformance {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let bare = scene_from_toml(&said(&scene_toml(kind, acting, ""))).expect("a valid scene");
    let (_, joined) = bare.joint_trees().next().expect("a tree");
    let tree = bare.tree_model(joined);
    let truth = drawn(kind, &tree, &mut random);
    let tempo = acting.tempo(kind.duration_s, seed);
    let instants = acting.instants(kind.duration_s, tempo.as_ref());
    let states = match acting.slowly {
        None => motion(&bare, &tree, &truth, kind.duration_s, acting.rate_hz),
        Some(_) => states_at(&bare, &tree, &truth, &instants),
    };
    let last = states.last().expect("samples");
    let mut snapshot = Snapshot::new(&tree, &bare.gravity_m_s2);
    snapshot.set(last);
    let end_m = snapshot.point(kind.links - 1, &Vector3::new(0.0, 0.0, -0.5 * ROD_M));
    let asked = Asked {
        links: kind.links,
        last_m: ROD_M,
        asks_start: acting.asks_start,
    };
    let goals = goals(&asked, (&bare, joined, &tree), &truth, &end_m);
    let scene_toml = said(&scene_toml(kind, acting, &goals));
    let scene = scene_from_toml(&scene_toml).expect("a valid scene");
    let wanders: Vec<Wander> = (0..3)
        .map(|_| Wander::draw(&HAND_POSITION, &mut random))
        .collect();
    let track = TrackIndex(0);
    let (place, point_m) = (
        joined
            .place_of(scene.tracks[track].link)
            .expect("of the tree"),
        scene.tracks[track].point_m(),
    );
    assert_eq!(scene.tracks[track].sees, Sees::Point);
    let start = 1_000_000_000;
    let stamp = |index: usize| Stamp(start + (1e9 * instants[index].stamp_s).round() as i64);
    let mut events: Vec<TakeEvent> = Vec::new();
    for (index, state) in states.iter().enumerate() {
        snapshot.set(state);
        let at_m = snapshot.point(place, &point_m);
        let per_axis = acting.wander_m / 3.0_f64.sqrt();
        let acted_s = instants[index].acted_s;
        let off = Vector3::from_fn(|axis, _| {
            let noise: f64 = StandardNormal.sample(&mut random);
            per_axis * wanders[axis].at(acted_s) + acting.noise_m * noise
        });
        let mut sample = PoseSample::from_pose(
            stamp(index),
            &enact::math::Pose::from_parts((at_m + off).into(), UnitQuaternion::identity()),
        );
        sample.holds = Holds::Position;
        events.push(TakeEvent::Pose {
            track,
            stream: 0,
            sample,
        });
    }
    let mark = |name: &str, index: usize| {
        TakeEvent::Mark(Mark {
            stamp: stamp(index),
            event: Some(name.into()),
        })
    };
    events.push(mark("start", 0));
    events.push(mark("end", states.len() - 1));
    TreePerformance {
        scene_toml,
        scene,
        events,
        truth,
        duration_s: kind.duration_s,
        sample_times_s: instants.iter().map(|at| at.physical_s).collect(),
        tempo,
    }
}

/// States at instants.
fn states_at(
    scene: &Scene,
    tree: &Tree,
    start: &TreeState,
    instants: &[Instant],
) -> Vec<TreeState> {
    const STEP_S: f64 = 1e-3;
    let mut flow = Flow::new(tree, &scene.gravity_m_s2, tableau::DORMAND_PRINCE);
    flow.begin(start, false);
    let at = |instant: &Instant| {
        flow.reach(instant.physical_s, STEP_S);
        flow.state()
    };
    instants.iter().map(at).collect()
}

/// States at every sample of a motion.
pub fn motion(
    scene: &Scene,
    tree: &Tree,
    start: &TreeState,
    duration_s: f64,
    rate_hz: f64,
) -> Vec<TreeState> {
    const STEPS: usize = 8;
    let mut flow = Flow::new(tree, &scene.gravity_m_s2, tableau::DORMAND_PRINCE);
    flow.begin(start, false);
    let mut states = vec![flow.state()];
    for _ in 0..(duration_s * rate_hz).round() as usize {
        flow.advance(1.0 / rate_hz, STEPS);
        states.push(flow.state());
    }
    states
}

fn drawn(kind: &Kind, tree: &Tree, random: &mut ChaCha8Rng) -> TreeState {
    let mut signed = |most: f64| most * (2.0 * random.random::<f64>() - 1.0);
    let mut state = tree.at_rest();
    let flight = tree.translations();
    let mut delta = vec![0.0; 2 * tree.freedoms()];
    for entry in &mut delta[flight..tree.freedoms()] {
        *entry = signed(0.8);
    }
    for entry in &mut delta[tree.freedoms() + flight..] {
        *entry = signed(4.0);
    }
    if !kind.is_clamped {
        delta[2] = 1.0;
        let up_m_s = 0.5 * 9.80665 * kind.duration_s;
        let first = tree.freedoms();
        (delta[first], delta[first + 1], delta[first + 2]) = (signed(1.0), signed(1.0), up_m_s);
    }
    state = tree.retract(&state, &delta);
    state
}

/// The joint from which a rod hangs: from the rod before it, the first from a place so high above the origin \[m\].
pub(crate) fn joint_toml(joints: Jointed, link: usize, hangs_m: f64) -> String {
    joint_between(joints, link, hangs_m, [ROD_M; 2])
}

/// The same with the lengths of the rod before it and of the rod itself \[m\].
pub(crate) fn joint_between(
    joints: Jointed,
    link: usize,
    hangs_m: f64,
    [before_m, own_m]: [f64; 2],
) -> String {
    let half_mm = 500.0 * own_m;
    let parent = match link.checked_sub(1) {
        Some(parent) => format!(
            "parent = \"rod {}\"\nparent_at_mm = [0, 0, {:?}]\n",
            parent + 1,
            -500.0 * before_m
        ),
        None => format!("parent_at_mm = [0, 0, {:?}]\n", 1e3 * hangs_m),
    };
    format!(
        "\n[[joint]]\nname = \"joint {}\"\n{}\n{parent}child = \"rod {}\"\nchild_at_mm = [0, 0, {half_mm:?}]\n",
        link + 1,
        joints.toml(),
        link + 1,
    )
}

fn scene_toml(kind: &Kind, acting: &TreeActing, goals: &str) -> String {
    let stamps = match acting.slowly {
        None => "physical",
        Some(_) => "tempo",
    };
    let mut text = format!(
        "name = \"rods\"\n\n[timing]\nstamps = \"{stamps}\"\n\n[weights]\nposition_mm = 10\n",
    );
    let tracked = if kind.is_clamped { kind.links - 1 } else { 0 };
    for link in 0..kind.links {
        text += &format!(
            "\n[[body]]\nname = \"rod {}\"\nshape = {{ kind = \"cylinder\", length_mm = {:?}, radius_mm = 5 }}\nmass_g = 100\n",
            link + 1,
            1e3 * ROD_M,
        );
        if link == tracked {
            let at_mm = if kind.is_clamped { -500.0 * ROD_M } else { 0.0 };
            text += &format!(
                "\n[[body.track]]\nsees = \"point\"\ntracker = {{ position_mm = [0, 0, {at_mm:?}] }}\n"
            );
        } else {
            text += "tracked = false\n";
        }
    }
    for link in 0..kind.links {
        if link == 0 && !kind.is_clamped {
            continue;
        }
        text += &joint_toml(kind.joints, link, 1.5);
    }
    text += "\n[[event]]\nname = \"start\"\nkind = \"start\"\n\n[[event]]\nname = \"end\"\nkind = \"end\"\n";
    text + goals
}

/// Of which rods goals are.
pub(crate) struct Asked {
    /// Number of rods.
    pub links: usize,
    /// Length of the last one \[m\].
    pub last_m: f64,
    /// Whether the whole configuration at the start is a goal.
    pub asks_start: bool,
}

/// The whole configuration at the start, where that is asked, and the place of the last rod's end at the end.
pub(crate) fn goals(
    asked: &Asked,
    (scene, joined, tree): (&Scene, &JointTree, &Tree),
    truth: &TreeState,
    end_m: &Vector3<f64>,
) -> String {
    let mut text = String::new();
    let list = |numbers: &[f64], factor: f64| {
        let numbers = numbers
            .iter()
            .map(|number| format!("{:?}", number * factor));
        numbers.collect::<Vec<_>>().join(", ")
    };
    if asked.asks_start {
        let mut snapshot = Snapshot::new(tree, &scene.gravity_m_s2);
        snapshot.set(truth);
        let states: Vec<State> = (0..asked.links)
            .map(|link| snapshot.link_state(link))
            .collect();
        for (place, state) in states.iter().enumerate() {
            if let Some([_, angles]) = tree.angles_of(place) {
                let angles = list(&truth.coordinates[angles], 180.0 / std::f64::consts::PI);
                text += &format!(
                    "\n[[goal]]\nevent = \"start\"\njoint = \"joint {}\"\nangles_deg = [{angles}]\n",
                    place + 1
                );
                continue;
            }
            let q = state.orientation.coords;
            let wxyz = list(&[q.w, q.x, q.y, q.z], 1.0);
            let at = match place == 0 && joined.base.is_some() {
                true => format!(
                    "position_mm = [{}]\n",
                    list(state.position_m.as_slice(), 1e3)
                ),
                false => String::new(),
            };
            text += &format!(
                "\n[[goal]]\nevent = \"start\"\nbody = \"rod {}\"\n{at}orientation_wxyz = [{wxyz}]\n",
                place + 1
            );
        }
    }
    text += &format!(
        "\n[[goal]]\nevent = \"end\"\nbody = \"rod {}\"\npoint_mm = [0, 0, {:?}]\nposition_mm = [{}]\n",
        asked.links,
        -500.0 * asked.last_m,
        list(end_m.as_slice(), 1e3)
    );
    text
}
