//! Joined bodies go on as their equations of motion say, stay joined, keep to their limits and rest.

use nalgebra::{Matrix3, Vector3};
use typed_index_collections::TiSlice;

use crate::config::scene_from_toml;
use crate::math::{Pose, so3};
use crate::motion::{Estimate, LinkIndex, Scene, Settled, TreeEstimate, TreeKnot};
use crate::physics::tree::{Flow, JointKind, Snapshot, tableau};
use crate::settle::tests::{brick, estimate};
use crate::settle::{INTERVAL_S, Simulation, settle, trees};

const PIN: &str = "kind = \"pin\"\naxis = [1, 0, 0]";
/// Its second axis is not across the first.
const UNIVERSAL: &str = "kind = \"universal\"\naxes = [[1, 0, 0], [0.3, 1, 0]]";
const BALL: &str = "kind = \"ball\"";

/// Three rods of 0.2 m, the first from a nail at a height, or flying; one joint above the other.
fn rods(hangs_m: Option<f64>, joint: &str, more: &str) -> Scene {
    let mut text = format!(
        "name = \"rods\"\nsettle_s = 1\n[timing]\nstamps = \"physical\"\n{more}\n\
         [[event]]\nname = \"start\"\nkind = \"start\"\n[[event]]\nname = \"end\"\nkind = \"end\"\n"
    );
    for link in 0..3 {
        text += &format!(
            "[[body]]\nname = \"rod {link}\"\nmass_g = 100\n\
             shape = {{ kind = \"cuboid\", size_mm = [20, 30, 200] }}\n"
        );
        let from = match (link, hangs_m) {
            (0, None) => continue,
            (0, Some(hangs_m)) => format!("parent_at_mm = [0, 0, {:?}]", 1e3 * hangs_m),
            _ => format!("parent = \"rod {}\"\nparent_at_mm = [0, 0, -100]", link - 1),
        };
        text += &format!(
            "[[joint]]\nname = \"joint {link}\"\n{joint}\n{from}\nchild = \"rod {link}\"\n\
             child_at_mm = [0, 0, 100]\n"
        );
    }
    scene_from_toml(&text).unwrap()
}

/// An estimate of joined bodies that ends in a state: tangents of coordinates and of rates, repeated.
fn ending(scene: &Scene, turns_rad: &[f64], rates_rad_s: &[f64]) -> Estimate {
    let (mechanism, joined) = scene.joint_trees().next().unwrap();
    let tree = scene.tree_model(joined);
    let freedoms = tree.freedoms();
    let flight = tree.translations();
    let mut delta = vec![0.0; 2 * freedoms];
    for index in flight..freedoms {
        delta[index] = turns_rad[(index - flight) % turns_rad.len()];
        delta[freedoms + index] = rates_rad_s[(index - flight) % rates_rad_s.len()];
    }
    if flight > 0 {
        (delta[2], delta[freedoms], delta[freedoms + 2]) = (1.0, 0.5, 1.5);
    }
    let state = tree.retract(&tree.at_rest(), &delta);
    let mut made = estimate(scene, brick(0.0));
    made.arcs.clear();
    made.trees = vec![TreeEstimate {
        mechanism,
        knots: vec![TreeKnot { time_s: 0.8, state }],
        step_s: 1e-3,
        residuals: Vec::new(),
        rate_sd_rad_s: 10.0,
    }];
    made
}

/// A lively state, of which no two joints move alike.
fn lively(scene: &Scene) -> Estimate {
    let turns_rad = [0.6, -0.4, 0.2, -0.7, 0.5];
    ending(scene, &turns_rad, &[4.0, -3.0, 1.0, 5.0, -2.0, 3.0, -4.0])
}

/// Where each joint is by its parent, and where by its child, at a step.
fn joints_at(scene: &Scene, settled: &Settled, step: usize) -> Vec<(JointKind, [Pose; 2])> {
    let (_, joined) = scene.joint_trees().next().unwrap();
    let pose = |link: LinkIndex| settled.links[link].poses[step];
    let joints = joined.joints.iter();
    let joints = joints.map(|of| {
        let parent = of.parent.map_or(Pose::identity(), pose);
        let by_parent = parent * of.joint.parent_from_joint;
        (
            of.joint.kind,
            [by_parent, pose(of.child) * of.joint.link_from_joint],
        )
    });
    joints.collect()
}

/// The angle of a pin from its links' poses \[rad\], within half a turn.
fn angle_rad(axis: &Vector3<f64>, [parent, child]: &[Pose; 2]) -> f64 {
    so3::log(&(parent.rotation.inverse() * child.rotation)).dot(&axis.normalize())
}

/// Links do not come apart in any frame, and move about the axes of their joints alone.
fn stay_joined(scene: &Scene, settled: &Settled) {
    let frames = settled.links[LinkIndex(0)].poses.len();
    assert!(frames > 100, "{frames}");
    for step in 0..frames {
        for (kind, [parent, child]) in joints_at(scene, settled, step) {
            let apart_m = (parent.translation.vector - child.translation.vector).norm();
            assert!(apart_m < 1e-12, "{kind:?} {step}: {apart_m}");
            let turn = parent.rotation.inverse() * child.rotation;
            let off = match kind {
                JointKind::Pin { axis } => (turn * axis - axis).norm(),
                JointKind::Universal { axes: [a, b] } => {
                    let [a, b] = [a.normalize(), b.normalize()];
                    a.dot(&(turn * b)) - a.dot(&b)
                }
                JointKind::Fixed => turn.angle(),
                JointKind::Ball | JointKind::Free => 0.0,
            };
            assert!(off.abs() < 1e-12, "{kind:?} {step}: {off}");
        }
    }
}

/// Places and turns of all links after so many steps: simulated, and as the equations of motion say.
fn both_after(scene: &Scene, estimate: &Estimate, steps: usize) -> [Vec<Pose>; 2] {
    let settled = settle(scene, estimate, 1.0).unwrap();
    let (_, joined) = scene.joint_trees().next().unwrap();
    let tree = scene.tree_model(joined);
    let mut flow = Flow::new(&tree, &scene.gravity_m_s2, tableau::DORMAND_PRINCE);
    flow.begin(&estimate.trees[0].knots[0].state, false);
    flow.advance(steps as f64 * INTERVAL_S, 20 * steps);
    let mut snapshot = Snapshot::new(&tree, &scene.gravity_m_s2);
    snapshot.set(&flow.state());
    let places = 0..tree.link_count();
    [
        joined
            .links()
            .map(|link| settled.links[link].poses[steps])
            .collect(),
        places
            .map(|place| snapshot.world_from_link(place))
            .collect(),
    ]
}

/// How far poses are from others, link by link: places \[m\], and turns of a tenth of a metre.
fn off(from: &[Pose], to: &[Pose]) -> Vec<f64> {
    let pairs = from.iter().zip(to);
    let off = pairs.flat_map(|(from, to)| {
        let place = to.translation.vector - from.translation.vector;
        let turn = 0.1 * so3::log(&(to.rotation * from.rotation.inverse()));
        [place, turn]
    });
    off.flat_map(|of| [of.x, of.y, of.z]).collect()
}

fn norm(of: &[f64]) -> f64 {
    of.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// What dampers and springs do in a while is what the equations of motion say that they do.
#[test]
fn dampers_and_springs_act_as_the_scene_says() {
    let steps = 12;
    for joint in [PIN, UNIVERSAL] {
        let bare = rods(Some(1.5), joint, "");
        let free = both_after(&bare, &lively(&bare), steps);
        for passive in ["damping_n_m_s = 0.001", "stiffness_n_m = 0.005"] {
            let scene = rods(Some(1.5), &format!("{joint}\n{passive}"), "");
            let [simulated, exact] = both_after(&scene, &lively(&scene), steps);
            let found = off(&free[0], &simulated);
            let right = off(&free[1], &exact);
            let apart: Vec<f64> = found.iter().zip(&right).map(|(a, b)| a - b).collect();
            let (apart, right) = (norm(&apart), norm(&right));
            assert!(right > 1e-4, "{joint} {passive}: {right}");
            assert!(apart < 0.2 * right, "{joint} {passive}: {apart} of {right}");
        }
    }
}

#[test]
fn links_stay_joined_about_their_axes_alone() {
    for joint in [PIN, UNIVERSAL, BALL] {
        let scene = rods(Some(1.5), joint, "");
        let settled = settle(&scene, &lively(&scene), 1.0).unwrap();
        stay_joined(&scene, &settled);
    }
}

/// Kinetic and potential energy at a step \[J\], by differences of poses over two intervals.
fn energy_j(scene: &Scene, settled: &Settled, step: usize) -> f64 {
    let of_link = |link: LinkIndex| {
        let poses = &settled.links[link].poses;
        let [before, now, after] = [step - 1, step, step + 1].map(|at| poses[at]);
        let velocity = (after.translation.vector - before.translation.vector) / (2.0 * INTERVAL_S);
        let turn = so3::log(&(before.rotation.inverse() * after.rotation));
        let spin = turn / (2.0 * INTERVAL_S);
        let body = scene.links[link].body;
        let moments = Matrix3::from_diagonal(&body.moments_kg_m2());
        let fallen = scene.gravity_m_s2.dot(&now.translation.vector);
        body.mass_kg() * (0.5 * velocity.norm_squared() - fallen)
            + 0.5 * spin.dot(&(moments * spin))
    };
    scene.links.keys().map(of_link).sum()
}

/// Without springs nothing gains energy, in the air and on the table; of flying rods with universal joints it is kept
/// to a few hundredths.
#[test]
fn energy_never_grows() {
    let table = "[[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]";
    for (hangs_m, joint, more, share) in [
        (Some(1.5), PIN, "", 0.0),
        (Some(1.5), UNIVERSAL, "", 0.0),
        (Some(1.5), BALL, "", 0.0),
        (Some(0.45), PIN, table, 0.0),
        (Some(0.45), UNIVERSAL, table, 0.0),
        (Some(0.45), BALL, table, 0.0),
        (None, PIN, table, 0.0),
        (None, UNIVERSAL, table, 0.04),
    ] {
        let scene = rods(hangs_m, joint, more);
        let settled = settle(&scene, &lively(&scene), 2.0).unwrap();
        let steps = settled.links[LinkIndex(0)].poses.len() - 1;
        let energies = (1..steps).map(|step| energy_j(&scene, &settled, step));
        let energies: Vec<f64> = energies.collect();
        let (mut least, mut grown) = (energies[0], 0.0_f64);
        for energy in &energies {
            grown = grown.max(energy - least);
            least = least.min(*energy);
        }
        let bound_j = share * energies[0] + 1e-3;
        assert!(
            grown < bound_j,
            "{joint} {hangs_m:?}: {grown} of {bound_j} J"
        );
    }
}

/// A chain falls on a table and lies there, none of it inside.
#[test]
fn a_chain_comes_to_rest_on_the_table() {
    let table = "[[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]";
    for joint in [PIN, UNIVERSAL, BALL] {
        let scene = rods(None, joint, table);
        let settled = settle(&scene, &lively(&scene), 20.0).unwrap();
        assert!(settled.at_rest, "{joint}: {}", settled.end_s());
        stay_joined(&scene, &settled);
        let mut lowest_m = f64::INFINITY;
        for link in scene.links.keys() {
            let solid = scene.links[link].shape.solid().unwrap();
            let last = settled.links[link].poses.last().unwrap();
            let closest = solid
                .lowest(last, &Vector3::zeros(), &Vector3::z())
                .unwrap();
            lowest_m = lowest_m.min(closest.gap_m);
        }
        assert!(lowest_m.abs() < 1e-3, "{joint}: {lowest_m}");
    }
}

#[test]
fn a_damped_pendulum_ends_hanging_down() {
    for joint in [PIN, UNIVERSAL, BALL] {
        let scene = rods(Some(1.5), &format!("{joint}\ndamping_n_m_s = 0.02"), "");
        let settled = settle(&scene, &lively(&scene), 30.0).unwrap();
        assert!(settled.at_rest, "{joint}: {}", settled.end_s());
        for (link, of) in settled.links.iter_enumerated() {
            let last = of.poses.last().unwrap();
            let hangs_m = Vector3::new(0.0, 0.0, 1.4 - 0.2 * usize::from(link) as f64);
            let off_m = (last.translation.vector - hangs_m).norm();
            assert!(off_m < 2e-3, "{joint}: {off_m}");
        }
    }
}

/// What swings against a stop stays there without a rebound; what is beyond one goes no further.
#[test]
fn limits_hold() {
    let beyond_rad = 0.5_f64.to_radians();
    let limited = format!("{PIN}\nlimits_deg = [[-10, 40]]\ndamping_n_m_s = 0.005");
    let scene = rods(Some(1.5), &limited, "");
    let angles = |settled: &Settled, joint: usize| -> Vec<f64> {
        let frames = 0..settled.links[LinkIndex(0)].poses.len();
        let at = |step| {
            let (kind, poses) = joints_at(&scene, settled, step)[joint];
            let JointKind::Pin { axis } = kind else {
                panic!("a pin")
            };
            angle_rad(&axis, &poses)
        };
        frames.map(at).collect()
    };
    let [least, greatest] = [-10.0_f64, 40.0].map(f64::to_radians);
    let bounds = |angles: &[f64]| {
        let most = angles.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (angles.iter().copied().fold(f64::INFINITY, f64::min), most)
    };
    let settled = settle(
        &scene,
        &ending(&scene, &[0.5, 0.1, -0.1], &[6.0, -5.0, 4.0]),
        3.0,
    );
    let settled = settled.unwrap();
    for joint in 0..3 {
        let (low, high) = bounds(&angles(&settled, joint));
        assert!(
            low > least - beyond_rad && high < greatest + beyond_rad,
            "{joint}: {low} {high}"
        );
    }
    let (_, high) = bounds(&angles(&settled, 0));
    assert!(
        high > greatest - beyond_rad,
        "it comes to its limit: {high}"
    );

    // Twenty degrees beyond.
    let from = 60.0_f64.to_radians();
    let settled = settle(
        &scene,
        &ending(&scene, &[from, 0.0, 0.0], &[3.0, 0.0, 0.0]),
        3.0,
    );
    let settled = settled.unwrap();
    let (low, high) = bounds(&angles(&settled, 0));
    assert!(
        high < from + beyond_rad && low > least - beyond_rad,
        "{low} {high}"
    );
}

/// Rods that no joint ties do not pass through each other; those that one ties overlap where they meet.
#[test]
fn links_touch_each_other_where_no_joint_ties_them() {
    let mut scene = rods(None, PIN, "");
    scene.gravity_m_s2 = Vector3::zeros();
    // The second leans back against the first, and the third swings through where the first is.
    let estimate = ending(
        &scene,
        &[0.0, 0.0, 0.0, 2.6, 1.5],
        &[0.0, 0.0, 0.0, 0.0, 8.0],
    );
    let settled = settle(&scene, &estimate, 0.5).unwrap();
    let frames = settled.links[LinkIndex(0)].poses.len();
    let mut nearest = f64::INFINITY;
    for step in 0..frames {
        let [first, last] = [0, 2].map(|link| settled.links[LinkIndex(link)].poses[step]);
        for along in 0..=20 {
            let point = last * nalgebra::Point3::new(0.0, 0.0, 0.01 * f64::from(along) - 0.1);
            let seen = first.inverse_transform_point(&point);
            let out = (seen.y.abs() - 0.015).max(seen.z.abs() - 0.1);
            nearest = nearest.min(out);
        }
    }
    assert!(nearest > 0.0, "{nearest}");
}

#[test]
fn the_same_motion_settles_to_the_same_bits() {
    let scene = rods(None, UNIVERSAL, "");
    let estimate = lively(&scene);
    assert_eq!(
        settle(&scene, &estimate, 0.5),
        settle(&scene, &estimate, 0.5)
    );
}

#[test]
fn the_first_poses_are_those_of_the_end() {
    let scene = rods(None, UNIVERSAL, "");
    let estimate = lively(&scene);
    let settled = settle(&scene, &estimate, 0.1).unwrap();
    assert_eq!(settled.from_s, 0.8);
    let [simulated, exact] = both_after(&scene, &estimate, 0);
    for (simulated, exact) in simulated.iter().zip(&exact) {
        let off = exact.inv_mul(simulated);
        assert!(off.translation.vector.norm() < 1e-14, "{off}");
        assert!(off.rotation.angle() < 1e-7, "{off}");
    }
    let mut unknown = estimate;
    unknown.trees[0].knots[0].state.rates[0] = f64::NAN;
    assert_eq!(settle(&scene, &unknown, 0.1), None);
}

/// Rods that end three millimetres inside of the table are pushed out slowly.
#[test]
fn what_ends_inside_of_the_table_is_not_shot_out() {
    let table = "[[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]";
    let scene = rods(None, PIN, table);
    let lying = [std::f64::consts::FRAC_PI_2, 0.0, 0.0, 0.0, 0.0];
    let mut estimate = ending(&scene, &lying, &[0.0]);
    let state = &mut estimate.trees[0].knots[0].state;
    state.coordinates[2] = 0.012;
    state.rates.fill(0.0);
    let settled = settle(&scene, &estimate, 5.0).unwrap();
    assert!(
        settled.at_rest && settled.largest_speed_m_s < 0.1,
        "{}",
        settled.largest_speed_m_s
    );
    for of in &settled.links {
        let height_m = of.poses.last().unwrap().translation.z;
        assert!((height_m - 0.015).abs() < 1e-3, "{height_m}");
    }
}

/// A simulation in which energy comes from nowhere, or is no number, has failed.
#[test]
fn what_gains_energy_has_burst() {
    let scene = rods(None, UNIVERSAL, "");
    let estimate = lively(&scene);
    let trees = trees(&scene, &estimate, 0.8);
    let mut snapshot = Snapshot::new(&trees[0].model, &scene.gravity_m_s2);
    snapshot.set(&trees[0].state);
    let states = [0, 1, 2].map(|place| Some(snapshot.link_state(place)));
    let states = TiSlice::from_ref(&states);
    let mut simulation = Simulation::new(&scene, &estimate, states).unwrap();
    simulation.join(&trees, states);
    assert!(!simulation.has_burst());
    simulation.step();
    assert!(!simulation.has_burst());
    let link = simulation.links[LinkIndex(2)].unwrap();
    for speed_m_s in [50.0, f64::NAN] {
        let velocity = crate::settle::to_rapier(&Vector3::new(speed_m_s, 0.0, 0.0));
        simulation.world.bodies[link].set_linvel(velocity, false);
        assert!(simulation.has_burst(), "{speed_m_s}");
    }
}
