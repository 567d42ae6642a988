//! Performances of bodies joined in trees that hit something: true motions through impacts on a table, and how a hand
//! acts them.

use std::path::Path;

use enact::config::scene_from_toml;
use enact::math::Pose;
use enact::motion::{Estimate, Holds, Mark, PoseSample, Scene, Sees, Stamp, TakeEvent, TrackIndex};
use enact::physics::contact::{Contact, Feature};
use enact::physics::impact::{ContactSet, Law};
use enact::physics::tree::{Flow, ForestSnapshot, LinkContact, Snapshot, Tree, TreeState, tableau};
use enact::pipeline::{Outcome, Pipeline};
use enact::write::WriteError;
use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::perform::recording;
use crate::perform::wander::{HAND_ORIENTATION, HAND_POSITION, Wander};
use crate::trees::{Jointed, RATE_HZ, ROD_M, joint_toml};

/// What the links are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Thin rods, of which the ends touch.
    Rod,
    /// Planks, of which the corners do: cuboids of [`PLANK_M`] across.
    Plank,
}

/// Sides of a plank across its length \[m\].
pub const PLANK_M: [f64; 2] = [0.06, 0.04];

/// What hits the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Struck {
    /// What its links are.
    pub form: Form,
    /// Number of rods.
    pub links: usize,
    /// How they are joined.
    pub joints: Jointed,
    /// Height at which the first hangs \[m\]; none: they fly.
    pub hangs_m: Option<f64>,
    /// Number of impacts.
    pub impacts: usize,
    /// Coefficients of restitution and friction.
    pub law: [f64; 2],
}

/// How it is acted: every body has a tracker.
#[derive(Clone, Copy, Debug)]
pub struct Acted {
    /// Wander of a usual hand, times this.
    pub distortion: f64,
    /// White noise of a tracker, times this.
    pub noise: f64,
    /// Standard deviation of the marks of impacts \[s\].
    pub mark_sd_s: f64,
}

impl Acted {
    /// The motion itself, with marks where it has its impacts.
    pub const EXACT: Self = Self {
        distortion: 0.0,
        noise: 0.0,
        mark_sd_s: 0.0,
    };

    /// A usual hand, whose wander is so many times as wide.
    pub fn of(distortion: f64) -> Self {
        Self {
            distortion,
            noise: 1.0,
            mark_sd_s: 0.008,
        }
    }
}

/// A performance of trees that hit something.
#[derive(Clone)]
pub struct Strike {
    /// Its scene file.
    pub scene_toml: String,
    /// The scene.
    pub scene: Scene,
    /// What was recorded.
    pub events: Vec<TakeEvent>,
    /// True times of its impacts \[s after the start\].
    pub impacts_s: Vec<f64>,
    /// True states of all that moves at the samples.
    pub states: Vec<TreeState>,
}

impl Strike {
    /// What the program makes of it.
    pub fn finished(&self) -> Outcome {
        let events = self.events.iter().cloned();
        let outcome = Pipeline::of(self.scene.clone(), events).finish(&mut ());
        outcome.expect("an estimate")
    }

    /// Marks an event, so many seconds after the start.
    pub fn mark(&mut self, event: &str, time_s: f64) {
        let stamp = stamp_at(time_s);
        let after = self.events.iter().position(|of| stamp_of(of) > stamp);
        let mark = TakeEvent::Mark(Mark {
            stamp,
            event: Some(event.into()),
        });
        self.events.insert(after.unwrap_or(self.events.len()), mark);
    }

    /// Greatest difference of any coordinate from the true motion, at all samples [m, or rad]; infinite where the
    /// estimate has no motion.
    pub fn coordinates_off(&self, estimate: &Estimate) -> f64 {
        let forest = self.scene.forest();
        let mut most = 0.0_f64;
        for (index, truth) in self.states.iter().enumerate() {
            let time_s = index as f64 / RATE_HZ;
            let Some(found) = self.scene.forest_state(estimate, &forest, time_s) else {
                return f64::INFINITY;
            };
            for off in &forest.minus(&found, truth)[..forest.freedoms()] {
                most = most.max(if off.is_nan() {
                    f64::INFINITY
                } else {
                    off.abs()
                });
            }
        }
        most
    }

    /// Root mean square distance of all bodies' centres from the true ones, at all samples \[m\].
    pub fn off_m(&self, estimate: &Estimate) -> f64 {
        let forest = self.scene.forest();
        let mut snapshot = ForestSnapshot::new(&forest, &estimate.gravity_m_s2);
        let mut centres = |state: &TreeState| -> Vec<Vector3<f64>> {
            snapshot.set(state);
            let links = 0..forest.link_count();
            links
                .map(|place| snapshot.link_state(place).position_m)
                .collect()
        };
        let (mut sum, mut count) = (0.0, 0.0);
        for (index, truth) in self.states.iter().enumerate() {
            let time_s = index as f64 / RATE_HZ;
            let found = self.scene.forest_state(estimate, &forest, time_s);
            let found = found.expect("a motion");
            for (a, b) in centres(truth).iter().zip(centres(&found)) {
                sum += (a - b).norm_squared();
                count += 1.0;
            }
        }
        f64::sqrt(sum / count)
    }

    /// Writes it with its scene.
    pub fn write(&self, path: &Path) -> Result<(), WriteError> {
        recording::write_events_of(&self.scene, &self.scene_toml, &self.events, path)
    }
}

/// Corners of a plank: the first side is the lowest bit.
const CORNERS: [&str; 8] = [
    "corner -x -y -z",
    "corner +x -y -z",
    "corner -x +y -z",
    "corner +x +y -z",
    "corner -x -y +z",
    "corner +x -y +z",
    "corner -x +y +z",
    "corner +x +y +z",
];
/// Steps of the integrator per second, about.
const STEPS_HZ: f64 = 4000.0;
/// Least time from the start to an impact, between two, and from one to the end \[s\].
const APART_S: f64 = 0.12;
/// Least speed of an impact [m/s].
const SPEED_M_S: f64 = 0.6;
/// Least height of all ends at the end \[m\].
const CLEAR_M: f64 = 0.04;
/// Longest motion \[s\].
const LONGEST_S: f64 = 1.2;

/// What may touch: ends of rods, or corners of planks; their places in the tree, their names and where they are on them.
fn ends(struck: &Struck) -> Vec<(usize, &'static str, Vector3<f64>)> {
    let half = Vector3::new(0.0, 0.0, 0.5 * ROD_M);
    if struck.form == Form::Plank {
        let corners = |link: usize| {
            CORNERS.iter().enumerate().map(move |(at, name)| {
                let sign = |axis: usize| if at >> axis & 1 == 0 { -0.5 } else { 0.5 };
                let [x, y] = PLANK_M;
                (
                    link,
                    *name,
                    Vector3::new(sign(0) * x, sign(1) * y, sign(2) * ROD_M),
                )
            })
        };
        return (0..struck.links).flat_map(corners).collect();
    }
    let top = struck.hangs_m.is_none().then_some((0, "top", half));
    let bottoms = (0..struck.links).map(|link| (link, "end", -half));
    top.into_iter().chain(bottoms).collect()
}

/// Which rods' ends hit when, and the states at samples.
type Truth = (Vec<(f64, usize)>, Vec<TreeState>);

/// A motion in which as many ends hit as are asked for; none where a draw gives no clear one.
fn struck_motion(
    struck: &Struck,
    scene: &Scene,
    tree: &Tree,
    random: &mut ChaCha8Rng,
) -> Option<Truth> {
    let ends = ends(struck);
    let mut snapshot = Snapshot::new(tree, &scene.gravity_m_s2);
    let mut heights = |state: &TreeState| -> Vec<f64> {
        snapshot.set(state);
        ends.iter()
            .map(|(link, _, at)| snapshot.point(*link, at).z)
            .collect()
    };
    let mut state = drawn(tree, random);
    if heights(&state).iter().any(|height_m| *height_m < 0.05) {
        return None;
    }
    let mut flow = Flow::new(tree, &scene.gravity_m_s2, tableau::DORMAND_PRINCE);
    let (mut steps, mut impacts, mut states) = (0_usize, Vec::new(), vec![state.clone()]);
    let mut last_s = 0.0;
    let per_sample = (STEPS_HZ / RATE_HZ).ceil() as usize;
    let step_s = 1.0 / (RATE_HZ * per_sample as f64);
    loop {
        let now_s = steps as f64 * step_s;
        flow.begin(&state, false);
        flow.advance(step_s, 1);
        let next = flow.state();
        let heights_m = heights(&next);
        if heights_m.iter().any(|height_m| height_m.is_nan()) {
            return None;
        }
        let low = heights_m.iter().position(|height_m| *height_m < 0.0);
        let is_done = impacts.len() == struck.impacts;
        match low {
            Some(_) if is_done => {
                // Until something else comes near.
                let mut clear = |state: &TreeState| heights(state).iter().all(|of| *of > CLEAR_M);
                while states.last().is_some_and(|state| !clear(state)) {
                    states.pop();
                }
                let whole = (states.len() as f64 - 1.0) / RATE_HZ - last_s >= APART_S;
                return whole.then_some((impacts, states));
            }
            Some(end) => {
                let (mut from_s, mut to_s) = (0.0, step_s);
                for _ in 0..60 {
                    let middle_s = 0.5 * (from_s + to_s);
                    flow.begin(&state, false);
                    flow.advance(middle_s, 1);
                    match heights(&flow.state())[end] < 0.0 {
                        true => to_s = middle_s,
                        false => from_s = middle_s,
                    }
                }
                flow.begin(&state, false);
                flow.advance(from_s, 1);
                let before = flow.state();
                if now_s + from_s - last_s < APART_S {
                    return None;
                }
                let (link, _, point_m) = ends[end];
                let point = Feature::Point {
                    point_m,
                    radius_m: 0.0,
                };
                let face = Feature::Face {
                    point_m: Vector3::zeros(),
                    normal: Vector3::z(),
                };
                let contact = Contact::new(point, face).expect("a point on a face");
                let contacts = ContactSet::with_friction(&[contact]).expect("one contact");
                let law = Law {
                    restitution: struck.law[0],
                    friction: struck.law[1],
                    tangential_restitution: 0.0,
                    tilt_rad: [0.0; 2],
                };
                let forest = scene.forest();
                let mut at = ForestSnapshot::new(&forest, &scene.gravity_m_s2);
                at.set(&before);
                let touching = LinkContact {
                    place: link,
                    other: None,
                    contacts,
                };
                let impact = at.impact(&before, &touching, &law).ok()?;
                if impact.speeds_m_s[0] > -SPEED_M_S {
                    return None;
                }
                last_s = now_s + from_s;
                impacts.push((last_s, end));
                flow.begin(
                    &TreeState {
                        rates: impact.rates,
                        ..before
                    },
                    false,
                );
                flow.advance(step_s - from_s, 1);
                state = flow.state();
                if heights(&state).iter().any(|height_m| *height_m < 0.0) {
                    return None;
                }
            }
            None => state = next,
        }
        steps += 1;
        if steps.is_multiple_of(per_sample) {
            states.push(state.clone());
        }
        if now_s >= LONGEST_S || is_done && now_s - last_s > 3.0 * APART_S {
            return is_done.then_some((impacts, states));
        }
    }
}

/// A state at the beginning.
pub(crate) fn drawn(tree: &Tree, random: &mut ChaCha8Rng) -> TreeState {
    let mut signed = |most: f64| most * (2.0 * random.random::<f64>() - 1.0);
    let flight = tree.translations();
    let mut delta = vec![0.0; 2 * tree.freedoms()];
    for entry in &mut delta[flight..tree.freedoms()] {
        *entry = signed(1.2);
    }
    for entry in &mut delta[tree.freedoms() + flight..] {
        *entry = signed(4.0);
    }
    if flight > 0 {
        delta[2] = 0.5 + signed(0.1);
        let first = tree.freedoms();
        (delta[first], delta[first + 1], delta[first + 2]) =
            (signed(0.5), signed(0.5), signed(1.0));
    }
    tree.retract(&tree.at_rest(), &delta)
}

fn scene_toml(struck: &Struck, hits: &[(f64, usize)], goals: &str) -> String {
    let mut text = String::from(
        "name = \"rods that hit\"\n\n[timing]\nstamps = \"physical\"\n\n[weights]\nposition_mm = 10\norientation_deg = 5\n\n[[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n",
    );
    let half_mm = 500.0 * ROD_M;
    for link in 0..struck.links {
        if struck.form == Form::Plank {
            text += &format!(
                "\n[[body]]\nname = \"rod {}\"\nshape = {{ kind = \"cuboid\", size_mm = [{:?}, {:?}, {:?}] }}\nmass_g = 100\n",
                link + 1,
                1e3 * PLANK_M[0],
                1e3 * PLANK_M[1],
                1e3 * ROD_M,
            );
            continue;
        }
        text += &format!(
            "\n[[body]]\nname = \"rod {}\"\nshape = {{ kind = \"cylinder\", length_mm = {:?}, radius_mm = 2 }}\nmass_g = 100\nfeatures_mm = {{ top = [0, 0, {half_mm:?}], end = [0, 0, {:?}] }}\n",
            link + 1,
            1e3 * ROD_M,
            -half_mm,
        );
    }
    for link in 0..struck.links {
        text += &match (link, struck.hangs_m) {
            (0, None) => continue,
            (_, hangs_m) => joint_toml(struck.joints, link, hangs_m.unwrap_or_default()),
        };
    }
    text += "\n[[event]]\nname = \"start\"\nkind = \"start\"\n";
    let ends = ends(struck);
    for (index, (_, end)) in hits.iter().enumerate() {
        let (link, feature, _) = ends[*end];
        let [restitution, friction] = struck.law;
        text += &format!(
            "\n[[event]]\nname = \"hit {}\"\nkind = \"collision\"\nbody = \"rod {}\"\nfeature = \"{feature}\"\nsurface = \"table\"\nrestitution = {restitution:?}\nfriction = {friction:?}\nbumper = {}\n",
            index + 1,
            link + 1,
            restitution > 1.0,
        );
    }
    text += "\n[[event]]\nname = \"end\"\nkind = \"end\"\n";
    text + goals
}

/// Acts a motion: the first of the seed's draws that hits clearly.
pub fn strike(struck: &Struck, acted: &Acted, seed: u64) -> Strike {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let bare = scene_from_toml(&scene_toml(struck, &[], "")).expect("a valid scene");
    let (_, joined) = bare.joint_trees().next().expect("a tree");
    let tree = bare.tree_model(joined);
    let (hits, states) = loop {
        let drawn = struck_motion(struck, &bare, &tree, &mut random);
        if let Some(drawn) = drawn {
            break drawn;
        }
    };
    let mut snapshot = Snapshot::new(&tree, &bare.gravity_m_s2);
    snapshot.set(states.last().expect("samples"));
    let last_link = struck.links - 1;
    let half_m = Vector3::new(0.0, 0.0, -0.5 * ROD_M);
    let end_mm = snapshot.point(last_link, &half_m) * 1e3;
    let goals = format!(
        "\n[[goal]]\nevent = \"end\"\nbody = \"rod {}\"\npoint_mm = [0, 0, {:?}]\nposition_mm = [{:?}, {:?}, {:?}]\n",
        struck.links,
        -500.0 * ROD_M,
        end_mm.x,
        end_mm.y,
        end_mm.z
    );
    let scene_toml = scene_toml(struck, &hits, &goals);
    let impacts_s = hits.iter().map(|(time_s, _)| *time_s).collect();
    acted_out(scene_toml, (impacts_s, states), acted, &mut random)
}

/// How a hand acts a motion: impacts at these times, in the order of the scene's events, and states of all at samples.
pub(crate) fn acted_out(
    scene_toml: String,
    (impacts_s, states): (Vec<f64>, Vec<TreeState>),
    acted: &Acted,
    random: &mut ChaCha8Rng,
) -> Strike {
    let scene = scene_from_toml(&scene_toml).expect("a valid scene");
    let forest = scene.forest();
    let mut snapshot = ForestSnapshot::new(&forest, &scene.gravity_m_s2);
    let mut events: Vec<TakeEvent> = Vec::new();
    for (number, track) in scene.tracks.iter().enumerate() {
        let place = scene.place_of(track.link);
        let wanders: Vec<Wander> = [HAND_POSITION; 3]
            .iter()
            .chain(&[HAND_ORIENTATION; 3])
            .map(|kind| Wander::draw(kind, random))
            .collect();
        for (index, state) in states.iter().enumerate() {
            snapshot.set(state);
            let link = snapshot.link_state(place);
            // A hand acts at a third of the motion's speed.
            let acted_s = 3.0 * index as f64 / RATE_HZ;
            let mut off = |first: usize, wander: f64, noise: f64| {
                Vector3::from_fn(|axis, _| {
                    let white: f64 = StandardNormal.sample(random);
                    wander / 3.0_f64.sqrt() * wanders[first + axis].at(acted_s) + noise * white
                })
            };
            let at_m = link.position_m
                + link.orientation * track.point_m()
                + off(0, 0.02 * acted.distortion, 0.001 * acted.noise);
            let turn = off(3, 0.1 * acted.distortion, 0.003 * acted.noise);
            let turned = link.orientation * UnitQuaternion::from_scaled_axis(turn);
            let seen = Pose::from_parts(at_m.into(), turned);
            let mut sample = PoseSample::from_pose(stamp_at(index as f64 / RATE_HZ), &seen);
            if track.sees == Sees::Point {
                sample.holds = Holds::Position;
            }
            events.push(TakeEvent::Pose {
                track: TrackIndex(number),
                stream: 0,
                sample,
            });
        }
    }
    let end_s = (states.len() - 1) as f64 / RATE_HZ;
    events.sort_by_key(stamp_of);
    let mut strike = Strike {
        scene_toml,
        scene,
        events,
        impacts_s: impacts_s.clone(),
        states,
    };
    strike.mark("start", 0.0);
    for (index, time_s) in impacts_s.into_iter().enumerate() {
        let off: f64 = StandardNormal.sample(random);
        strike.mark(
            &format!("hit {}", index + 1),
            time_s + acted.mark_sd_s * off,
        );
    }
    strike.mark("end", end_s);
    strike
}

/// When the motion begins.
const START: Stamp = Stamp(1_000_000_000);

fn stamp_at(time_s: f64) -> Stamp {
    Stamp(START.0 + (1e9 * time_s).round() as i64)
}

fn stamp_of(event: &TakeEvent) -> Stamp {
    match event {
        TakeEvent::Pose { sample, .. } => sample.stamp,
        TakeEvent::Mark(mark) => mark.stamp,
    }
}
