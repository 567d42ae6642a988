//! Performances of joined bodies that meet a body by itself, another tree, a link of their own or, at several corners at
//! once, a table: true motions through one impact, drawn at that and followed to both sides, and how a hand acts them.

mod landed;

use enact::config::scene_from_toml;
use enact::math::Pose;
use enact::motion::{EventKind, LinkIndex, Scene};
use enact::physics::State;
use enact::physics::contact::Frame;
use enact::physics::shape::Solid;
use enact::physics::tree::{Forest, ForestFlow, ForestSnapshot, Tree, TreeState, tableau};
use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::tree_impacts::{Acted, PLANK_M, Strike, acted_out, drawn};
use crate::trees::{Jointed, RATE_HZ, ROD_M, joint_toml};

/// What the last rod's end hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Met {
    /// A face of a box that flies.
    Box,
    /// A ball that flies.
    Ball,
    /// The end of a rod that hangs by itself from a ball joint.
    Pendulum,
    /// The first rod's side: of three with pins.
    Own,
    /// The table, with so many corners at once of a plank in the last rod's place: two or three.
    Table(usize),
}

/// What meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meet {
    /// Number of rods.
    pub links: usize,
    /// How they are joined.
    pub joints: Jointed,
    /// Height at which the first hangs \[m\]; none: they fly.
    pub hangs_m: Option<f64>,
    /// What they hit.
    pub met: Met,
    /// Coefficients of restitution and friction.
    pub law: [f64; 2],
}

/// Radius of the rods \[m\],
const ROUND_M: f64 = 0.005;
/// and of the ball.
const BALL_M: f64 = 0.04;
/// Half the box's sides \[m\].
const BOX_M: Vector3<f64> = Vector3::new(0.05, 0.06, 0.04);
/// Least speed of the impact, and greatest [m/s].
const SPEED_M_S: [f64; 2] = [0.6, 3.0];
/// Least times before and after it, and how much longer they may be \[s\].
const AROUND_S: f64 = 0.25;
const LONGER_S: f64 = 0.15;
/// How long what meets is near each other, before and after \[s\].
const NEAR_S: f64 = 0.03;
/// Least distance of bodies else \[m\].
const CLEAR_M: f64 = 0.003;
/// Looks per second at their distances, and steps of the integrator.
const LOOKS_HZ: f64 = 1000.0;
const STEPS: usize = 4;

/// Acts a motion: the first of the seed's draws that meets clearly.
pub fn meet(meet: &Meet, acted: &Acted, seed: u64) -> Strike {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (toml, hit_s, states) = loop {
        if let Some(drawn) = motion(meet, &mut random) {
            break drawn;
        }
    };
    acted_out(toml, (vec![hit_s], states), acted, &mut random)
}

/// A scene file, when what it says meets \[s after the start\], and the states at the samples; none where a draw gives
/// no clear motion.
fn motion(meet: &Meet, random: &mut ChaCha8Rng) -> Option<(String, f64, Vec<TreeState>)> {
    let nail_m = Vector3::zeros();
    let bare = scene_from_toml(&scene_toml(meet, &nail_m, "")).expect("a valid scene");
    let forest = bare.forest();
    let rods = drawn(&forest.trees()[0], random);
    let mut signed = |most: f64| most * (2.0 * random.random::<f64>() - 1.0);
    let (state, nail_m) = match meet.met {
        Met::Own => (folded(&bare, &forest, rods, &mut signed)?, nail_m),
        Met::Table(corners) => (landed::landed(&bare, rods, corners, &mut signed)?, nail_m),
        Met::Pendulum => {
            let hanging = swung(&forest.trees()[1], &mut signed);
            let state = forest.whole([rods, hanging]);
            // The nail is where the ends touch.
            let (end_m, way) = end_of(&forest, &state, meet.links - 1);
            let (other_m, _) = end_of(&forest, &state, meet.links);
            (state, end_m + way * (2.0 * ROUND_M) - other_m)
        }
        Met::Box | Met::Ball => {
            let place = placed(meet, &bare, &rods, &mut signed)?;
            (forest.whole([rods, TreeState::of_body(&place)]), nail_m)
        }
    };
    let [before_s, mut after_s] = [(); 2].map(|()| AROUND_S + LONGER_S * random.random::<f64>());
    if let Met::Table(_) = meet.met {
        // Then what is above comes down too.
        after_s *= 0.5;
    }
    let scene = scene_from_toml(&scene_toml(meet, &nail_m, "")).expect("a valid scene");
    let (states, end_m) = followed(meet, &scene, &state, [before_s, after_s])?;
    let end_mm = end_m * 1e3;
    let goals = format!(
        "\n[[goal]]\nevent = \"end\"\nbody = \"rod {}\"\npoint_mm = [0, 0, {:?}]\nposition_mm = [{:?}, {:?}, {:?}]\n",
        meet.links,
        -500.0 * ROD_M,
        end_mm.x,
        end_mm.y,
        end_mm.z
    );
    Some((scene_toml(meet, &nail_m, &goals), before_s, states))
}

/// A rod's end, and the direction out of it.
fn end_of(forest: &Forest, state: &TreeState, place: usize) -> (Vector3<f64>, Vector3<f64>) {
    let mut snapshot = ForestSnapshot::new(forest, &Vector3::zeros());
    snapshot.set(state);
    let rod = snapshot.link_state(place);
    let way = rod.orientation * -Vector3::z();
    (rod.position_m + way * (0.5 * ROD_M), way)
}

/// A box or a ball that the end of the last rod touches, and that flies against it.
fn placed(
    meet: &Meet,
    scene: &Scene,
    rods: &TreeState,
    signed: &mut impl FnMut(f64) -> f64,
) -> Option<State> {
    let only_rods = Forest::new(vec![scene.forest().trees()[0].clone()]);
    let (end_m, way) = end_of(&only_rods, rods, meet.links - 1);
    let aside = Vector3::new(signed(0.6), signed(0.6), signed(0.6));
    // Out of what is hit, towards the rod.
    let normal = (aside - way).normalize();
    let touched_m = end_m - normal * ROUND_M;
    let turn =
        UnitQuaternion::from_scaled_axis(Vector3::new(signed(2.0), signed(2.0), signed(2.0)));
    let (orientation, lever_m) = match meet.met {
        Met::Ball => (turn, turn.inverse() * normal * BALL_M),
        _ => {
            let up = UnitQuaternion::rotation_between(&(turn * Vector3::z()), &normal)?;
            let at = Vector3::new(signed(0.5) * BOX_M.x, signed(0.5) * BOX_M.y, BOX_M.z);
            (up * turn, at)
        }
    };
    let mut snapshot = ForestSnapshot::new(&only_rods, &scene.gravity_m_s2);
    snapshot.set(rods);
    let rod = snapshot.link_state(meet.links - 1);
    let spin = rod.orientation * rod.angular_velocity_rad_s;
    let end_m_s = rod.velocity_m_s + spin.cross(&(touched_m - rod.position_m));
    let spin = Vector3::new(signed(3.0), signed(3.0), signed(3.0));
    let aside_m_s = Vector3::new(signed(0.4), signed(0.4), signed(0.4));
    let velocity_m_s =
        end_m_s + normal * (1.3 + signed(0.5)) + aside_m_s - orientation * spin.cross(&lever_m);
    Some(State {
        position_m: touched_m - orientation * lever_m,
        orientation,
        velocity_m_s,
        angular_velocity_rad_s: spin,
    })
}

/// A pendulum that moves.
fn swung(tree: &Tree, signed: &mut impl FnMut(f64) -> f64) -> TreeState {
    let freedoms = tree.freedoms();
    let delta: Vec<f64> = (0..2 * freedoms)
        .map(|at| signed(if at < freedoms { 0.6 } else { 4.0 }))
        .collect();
    tree.retract(&tree.at_rest(), &delta)
}

/// Three rods with pins, folded so that the last one's end touches the first one's side.
fn folded(
    scene: &Scene,
    forest: &Forest,
    mut rods: TreeState,
    signed: &mut impl FnMut(f64) -> f64,
) -> Option<TreeState> {
    let angles = [1, 2].map(|place| forest.angles_of(place).expect("pins")[1].start);
    let side = if signed(1.0) > 0.0 { 1.0 } else { -1.0 };
    rods.coordinates[angles[0]] = side * (1.88 + signed(0.12));
    // Where the end is off the first rod's axis, on the side of the second rod, and along it \[m\].
    let mut place = |angle: f64| {
        rods.coordinates[angles[1]] = side * angle;
        let (end_m, _) = end_of(forest, &rods, 2);
        let mut snapshot = ForestSnapshot::new(forest, &scene.gravity_m_s2);
        snapshot.set(&rods);
        let [first, second] = [0, 1].map(|place| snapshot.link_state(place));
        let of = |at_m: Vector3<f64>| first.orientation.inverse() * (at_m - first.position_m);
        (of(end_m).y * of(second.position_m).y.signum(), of(end_m).z)
    };
    let (mut out, mut inside) = (1.2, 2.95);
    if place(out).0 < 2.0 * ROUND_M || place(inside).0 > 2.0 * ROUND_M {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (out + inside);
        match place(middle).0 > 2.0 * ROUND_M {
            true => out = middle,
            false => inside = middle,
        }
    }
    let along_m = place(out).1;
    (along_m.abs() < 0.4 * ROD_M).then_some(rods)
}

/// States at the samples through the impact, and where the last rod's end then is \[m\]; none where it is no clear one.
fn followed(
    meet: &Meet,
    scene: &Scene,
    at_hit: &TreeState,
    [before_s, after_s]: [f64; 2],
) -> Option<(Vec<TreeState>, Vector3<f64>)> {
    let forest = scene.forest();
    let mut events = scene.events.iter();
    let hit = events.position(|of| matches!(of.kind, EventKind::Collision(_)))?;
    let touch = scene.tree_touch(hit).expect("a named contact");
    let mut snapshot = ForestSnapshot::new(&forest, &scene.gravity_m_s2);
    snapshot.set(at_hit);
    let frames = [Some(touch.at.place), touch.at.other].map(|place| match place {
        Some(place) => Frame::of(&snapshot.link_state(place)),
        None => Frame::world(),
    });
    for contact in touch.at.contacts.as_slice() {
        let gap_m = contact.touch(&frames[0], &frames[1]).ok()?.gap_m;
        assert!(gap_m.abs() < 1e-9, "drawn to touch: {gap_m}");
    }
    let impact = snapshot.impact(at_hit, &touch.at, &touch.law).ok()?;
    let is_one = impact.speeds_m_s.len() == 1;
    if is_one && !(SPEED_M_S[0]..SPEED_M_S[1]).contains(&-impact.speeds_m_s[0])
        || impact
            .normal_impulses_n_s
            .iter()
            .any(|impulse| *impulse < 0.0)
    {
        return None;
    }
    let after = TreeState {
        rates: impact.rates,
        ..at_hit.clone()
    };
    let solids: Vec<Solid> = scene.links.iter().map(|link| link.solid()).collect();
    let mut flow = ForestFlow::new(&forest, &scene.gravity_m_s2, tableau::DORMAND_PRINCE);
    // Side by side in time: whether nothing else comes near.
    for (from, sign, for_s) in [(at_hit, -1.0, before_s), (&after, 1.0, after_s)] {
        flow.begin(from, false);
        for look in 1..=(for_s * LOOKS_HZ).ceil() as usize {
            flow.advance(sign / LOOKS_HZ, STEPS);
            snapshot.set(&flow.state());
            let is_near = (look as f64) < NEAR_S * LOOKS_HZ;
            if !is_clear(scene, &solids, &snapshot, is_near.then_some(hit)) {
                return None;
            }
        }
    }
    let count = ((before_s + after_s) * RATE_HZ).floor() as usize;
    let states = (0..=count).map(|index| {
        let since_s = index as f64 / RATE_HZ - before_s;
        flow.begin(if since_s < 0.0 { at_hit } else { &after }, false);
        let steps = (since_s.abs() * LOOKS_HZ).ceil() as usize * STEPS;
        flow.advance(since_s, steps.max(1));
        flow.state()
    });
    let states: Vec<TreeState> = states.collect();
    let (end_m, _) = end_of(&forest, states.last()?, meet.links - 1);
    Some((states, end_m))
}

/// Whether all bodies that no joint ties are apart, and above the table if there is one; those that meet at an event
/// only just.
fn is_clear(
    scene: &Scene,
    solids: &[Solid],
    snapshot: &ForestSnapshot,
    hit: Option<usize>,
) -> bool {
    let hit = hit.and_then(|event| scene.events[event].kind.collision());
    let meeting: Vec<LinkIndex> = hit.into_iter().flat_map(|of| of.links()).collect();
    let poses = |link: LinkIndex| -> Pose {
        let state = snapshot.link_state(scene.place_of(link));
        Pose::from_parts(state.position_m.into(), state.orientation)
    };
    let is_above = |link: LinkIndex| {
        let solid = &solids[usize::from(link)];
        let lowest = solid.lowest(&poses(link), &Vector3::zeros(), &Vector3::z());
        let gap_m = lowest.expect("finite").gap_m;
        gap_m
            > if meeting.contains(&link) {
                -1e-5
            } else {
                CLEAR_M
            }
    };
    if !scene.surfaces.is_empty() && !scene.links.keys().all(is_above) {
        return false;
    }
    let pairs = scene.links.keys().flat_map(|one| {
        let others = scene.links.keys().skip(usize::from(one) + 1);
        others.map(move |other| (one, other))
    });
    let mut apart = pairs.filter(|(one, other)| !scene.are_joined(*one, *other));
    apart.all(|(one, other)| {
        let [a, b] = [one, other].map(|link| &solids[usize::from(link)]);
        let closest = a.closest(&poses(one), b, &poses(other));
        let gap_m = closest.expect("finite").gap_m;
        let is_meeting = meeting.contains(&one) && meeting.contains(&other);
        gap_m > if is_meeting { -1e-5 } else { CLEAR_M }
    })
}

fn scene_toml(meet: &Meet, nail_m: &Vector3<f64>, goals: &str) -> String {
    let mut text = String::from(
        "name = \"rods that meet\"\n\n[timing]\nstamps = \"physical\"\n\n[weights]\nposition_mm = 10\norientation_deg = 5\n",
    );
    let rod = |name: &str| {
        format!(
            "\n[[body]]\nname = \"{name}\"\nshape = {{ kind = \"capsule\", length_mm = {:?}, radius_mm = {:?} }}\nmass_g = 100\n",
            1e3 * ROD_M,
            1e3 * ROUND_M,
        )
    };
    let cuboid = |name: &str, mass_g: &str, size_mm: Vector3<f64>| {
        format!(
            "\n[[body]]\nname = \"{name}\"\nshape = {{ kind = \"cuboid\", size_mm = [{:?}, {:?}, {:?}] }}\nmass_g = {mass_g}\n",
            size_mm.x, size_mm.y, size_mm.z,
        )
    };
    let plank_mm = Vector3::new(PLANK_M[0], PLANK_M[1], ROD_M) * 1e3;
    for link in 0..meet.links {
        let name = format!("rod {}", link + 1);
        text += &match meet.met {
            Met::Table(_) if link + 1 == meet.links => cuboid(&name, "100", plank_mm),
            _ => rod(&name),
        };
    }
    text += &match meet.met {
        Met::Box => cuboid("box", "150", BOX_M * 2e3),
        Met::Table(_) => {
            "\n[[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n".into()
        }
        Met::Ball => format!(
            "\n[[body]]\nname = \"ball\"\nshape = {{ kind = \"sphere\", radius_mm = {:?} }}\nmass_g = 80\n",
            1e3 * BALL_M,
        ),
        Met::Pendulum => rod("pendulum"),
        Met::Own => String::new(),
    };
    for link in 0..meet.links {
        text += &match (link, meet.hangs_m) {
            (0, None) => continue,
            (_, hangs_m) => joint_toml(meet.joints, link, hangs_m.unwrap_or_default()),
        };
    }
    if meet.met == Met::Pendulum {
        text += &format!(
            "\n[[joint]]\nname = \"nail\"\nkind = \"ball\"\nparent_at_mm = [{:?}, {:?}, {:?}]\nchild = \"pendulum\"\nchild_at_mm = [0, 0, {:?}]\n",
            1e3 * nail_m.x,
            1e3 * nail_m.y,
            1e3 * nail_m.z,
            500.0 * ROD_M,
        );
    }
    let with = |other: &str, feature: &str| {
        format!("feature = \"end -z\"\nother = \"{other}\"\nother_feature = \"{feature}\"")
    };
    let with = match meet.met {
        Met::Box => with("box", "face +z"),
        Met::Ball => with("ball", "ball"),
        Met::Pendulum => with("pendulum", "end -z"),
        Met::Own => with("rod 1", "side"),
        Met::Table(corners) => {
            format!(
                "features = {:?}\nsurface = \"table\"",
                &landed::CORNERS[..corners]
            )
        }
    };
    let [restitution, friction] = meet.law;
    text += &format!(
        "\n[[event]]\nname = \"start\"\nkind = \"start\"\n\n[[event]]\nname = \"hit 1\"\nkind = \"collision\"\nbody = \"rod {}\"\n{with}\nrestitution = {restitution:?}\nfriction = {friction:?}\n\n[[event]]\nname = \"end\"\nkind = \"end\"\n",
        meet.links,
    );
    text + goals
}
