//! A falling body comes to rest where it should, and begins where the estimate ends.

use nalgebra::UnitQuaternion;

use super::*;
use crate::config::scene_from_toml;
use crate::motion::{ArcEstimate, Counters, DurationEstimate, End, FitUntold, Progress, Verdict};
use crate::physics::{Drag, flow};

const TABLE_AND_WALL: &str = r#"
name = "drop"
[timing]
stamps = "physical"
[[body]]
name = "brick"
shape = { kind = "cuboid", size_mm = [60, 60, 40] }
mass_g = 300
moments_kg_m2 = [1.3e-4, 1.3e-4, 1.8e-4]
[[surface]]
name = "table"
point_mm = [0, 0, 0]
normal = [0, 0, 1]
[[obstacle]]
name = "wall"
shape = { kind = "cuboid", size_mm = [20, 400, 400] }
position_mm = [-60, 0, 200]
"#;

pub(super) fn brick(z: f64) -> State {
    State {
        position_m: Vector3::new(0.0, 0.0, z),
        orientation: UnitQuaternion::from_euler_angles(0.3, 0.2, 0.5),
        velocity_m_s: Vector3::new(0.4, -0.2, -1.0),
        angular_velocity_rad_s: Vector3::new(3.0, -2.0, 4.0),
    }
}

pub(super) fn estimate(scene: &Scene, state: State) -> Estimate {
    Estimate {
        verdict: Verdict::Physical,
        reason: End::Converged(Progress::default()).into(),
        doubts: Vec::new(),
        fit: Err(FitUntold::NotAsked),
        suspects: Vec::new(),
        objective: 0.0,
        gravity_m_s2: scene.gravity_m_s2,
        arcs: vec![ArcEstimate {
            mechanism: MechanismIndex(0),
            epoch_s: 0.8,
            state,
            start_s: 0.2,
            end_s: 0.8,
            support: None,
            certainty: None,
        }],
        held: Vec::new(),
        grips: Vec::new(),
        trees: Vec::new(),
        events: Vec::new(),
        duration: DurationEstimate {
            duration_s: 0.6,
            sd_s: Some(0.0),
        },
        parameters: Vec::new(),
        residuals: Vec::new(),
        sample_times: Vec::new(),
        rivals: 0,
        contact_rivals: Vec::new(),
        undetermined: Vec::new(),
        counters: Counters::default(),
    }
}

#[test]
fn a_brick_comes_to_rest_flat_on_the_table() {
    let scene = scene_from_toml(TABLE_AND_WALL).unwrap();
    let settled = settle(&scene, &estimate(&scene, brick(0.2)), 5.0).unwrap();
    assert!(settled.at_rest && settled.end_s() < 5.0, "{settled:?}");
    let last = settled.links[LinkIndex(0)].poses.last().unwrap();
    // On one of its faces: the height of its centre is half a side, less rapier's slop.
    let lowest = scene.links[LinkIndex(0)].shape.solid().unwrap();
    let closest = lowest
        .lowest(last, &Vector3::zeros(), &Vector3::z())
        .unwrap();
    assert!(closest.gap_m.abs() < 5e-4, "{closest:?}");
    let up = last.rotation.inverse() * Vector3::z();
    assert!(up.amax() > 1.0 - 1e-4, "{up}");
}

#[test]
fn the_seam_is_continuous() {
    let scene = scene_from_toml(TABLE_AND_WALL).unwrap();
    let state = brick(0.5);
    let estimate = estimate(&scene, state);
    let states = [last_state(&scene, &estimate, MechanismIndex(0), 0.8)];
    assert_eq!(states, [Some(state)]);
    let simulation = Simulation::new(&scene, &estimate, TiSlice::from_ref(&states)).unwrap();
    let body = &simulation.world.bodies[simulation.links[LinkIndex(0)].unwrap()];
    assert_eq!(from_rapier(body.linvel()), state.velocity_m_s);
    let spin = state.orientation * state.angular_velocity_rad_s;
    assert_eq!(from_rapier(body.angvel()), spin);
    let settled = settle(&scene, &estimate, 0.1).unwrap();
    let poses = &settled.links[LinkIndex(0)].poses;
    assert_eq!((settled.from_s, poses[0]), (0.8, state.world_from_body()));
    // The first steps are free flight, but for the order of the integration.
    for (step, pose) in poses.iter().enumerate().take(12) {
        let duration_s = step as f64 * INTERVAL_S;
        let body = scene.body_of(MechanismIndex(0));
        let free = flow::advance(body, &scene.gravity_m_s2, &state, duration_s);
        let off_m = (free.position_m - pose.translation.vector).norm();
        assert!(off_m <= 10.0 * duration_s * INTERVAL_S + 1e-12, "{off_m}");
        let off_rad = free.orientation.angle_to(&pose.rotation);
        assert!(
            off_rad <= 60.0 * duration_s * INTERVAL_S + 1e-9,
            "{off_rad}"
        );
    }
}

#[test]
fn bodies_have_the_mass_and_moments_of_the_scene() {
    let scene = scene_from_toml(TABLE_AND_WALL).unwrap();
    let estimate = estimate(&scene, brick(0.5));
    let mut simulation =
        Simulation::new(&scene, &estimate, TiSlice::from_ref(&[Some(brick(0.5))])).unwrap();
    simulation.step();
    let body = &simulation.world.bodies[simulation.links[LinkIndex(0)].unwrap()];
    let properties = &body.mass_properties().local_mprops;
    assert!((properties.mass() - 0.3).abs() < 1e-15);
    let moments = from_rapier(properties.principal_inertia());
    let expected = scene.links[LinkIndex(0)].body.moments_kg_m2();
    assert!((moments - expected).norm() < 1e-18, "{moments}");
    assert_eq!(from_rapier(properties.local_com), Vector3::zeros());
}

#[test]
fn the_same_estimate_settles_to_the_same_bits() {
    let scene = scene_from_toml(TABLE_AND_WALL).unwrap();
    let estimate = estimate(&scene, brick(0.2));
    assert_eq!(
        settle(&scene, &estimate, 1.0),
        settle(&scene, &estimate, 1.0)
    );
}

#[test]
fn what_ends_inside_of_something_is_not_shot_out() {
    let scene = scene_from_toml(TABLE_AND_WALL).unwrap();
    // Three millimetres inside of the table, two of the wall.
    let state = State {
        position_m: Vector3::new(-0.022, 0.0, 0.017),
        orientation: UnitQuaternion::identity(),
        velocity_m_s: Vector3::zeros(),
        angular_velocity_rad_s: Vector3::zeros(),
    };
    let settled = settle(&scene, &estimate(&scene, state), 3.0).unwrap();
    assert!(
        settled.at_rest && settled.largest_speed_m_s < 0.1,
        "{}",
        settled.largest_speed_m_s
    );
    let last = settled.links[LinkIndex(0)].poses.last().unwrap();
    assert!((last.translation.vector - state.position_m).norm() < 5e-3);
}

/// A pencil flies at a wall thinner than its way in a step, turning, tip or side first.
#[test]
fn a_thin_body_does_not_pass_through_a_thin_wall() {
    let text = r#"
name = "throw"
[timing]
stamps = "physical"
[[body]]
name = "pencil"
shape = { kind = "cylinder", length_mm = 190, radius_mm = 3.75 }
mass_g = 6
[[surface]]
name = "table"
point_mm = [0, 0, 0]
normal = [0, 0, 1]
[[obstacle]]
name = "wall"
shape = { kind = "cuboid", size_mm = [4, 2000, 4000] }
position_mm = [0, 0, 0]
"#;
    let scene = scene_from_toml(text).unwrap();
    let mut passed = Vec::new();
    for speed_m_s in [0.5, 3.0, 5.0] {
        for spin_rad_s in [0.0, 15.0, -40.0] {
            for lean_rad in [0.0, 0.7, 1.5] {
                let state = State {
                    position_m: Vector3::new(0.2, 0.0, 0.5),
                    orientation: UnitQuaternion::from_euler_angles(0.0, lean_rad, 0.3),
                    velocity_m_s: Vector3::new(-speed_m_s, 0.1, 0.0),
                    angular_velocity_rad_s: Vector3::new(1.0, spin_rad_s, 10.0),
                };
                let settled = settle(&scene, &estimate(&scene, state), 2.0).unwrap();
                let poses = settled.links[LinkIndex(0)].poses.iter();
                let least_x = poses.fold(f64::INFINITY, |least, pose| {
                    least.min(pose.translation.vector.x)
                });
                let case = (speed_m_s, spin_rad_s, lean_rad);
                if least_x < 0.003 {
                    passed.push((case, least_x));
                }
            }
        }
    }
    assert!(passed.is_empty(), "{passed:?}");
}

#[test]
fn what_still_falls_at_the_limit_does_not_rest() {
    let scene = scene_from_toml(TABLE_AND_WALL).unwrap();
    let settled = settle(&scene, &estimate(&scene, brick(5.0)), 0.25).unwrap();
    assert!(!settled.at_rest);
    assert_eq!(settled.links[LinkIndex(0)].poses.len(), 61);
    assert!((settled.end_s() - 1.05).abs() < 1e-12);
}

#[test]
fn without_motion_nothing_settles() {
    let scene = scene_from_toml(TABLE_AND_WALL).unwrap();
    let mut estimate = estimate(&scene, brick(0.2));
    estimate.arcs[0].state.velocity_m_s.x = f64::NAN;
    assert_eq!(settle(&scene, &estimate, 1.0), None);
    estimate.arcs.clear();
    assert_eq!(settle(&scene, &estimate, 1.0), None);
}

#[test]
fn what_flies_on_keeps_its_drag_and_force() {
    let free = scene_from_toml(TABLE_AND_WALL).unwrap();
    let mut windy = free.clone();
    let body = &mut windy.links[LinkIndex(0)].body;
    let drag = Drag {
        linear_per_s: 2.0,
        quadratic_per_m: 0.5,
    };
    *body = body.with_drag(drag).unwrap();
    *body = body.with_force(Vector3::x()).unwrap();
    let state = brick(0.5);
    let step = 12;
    let [there, then] = [&free, &windy].map(|scene| {
        let settled = settle(scene, &estimate(scene, state), 0.1).unwrap();
        let body = scene.body_of(MechanismIndex(0));
        let duration_s = step as f64 * INTERVAL_S;
        let exact = flow::advance(body, &scene.gravity_m_s2, &state, duration_s);
        let simulated = settled.links[LinkIndex(0)].poses[step].translation.vector;
        (simulated, exact.position_m)
    });
    let (found, exact) = (then.0 - there.0, then.1 - there.1);
    assert!(exact.norm() > 3e-3, "{exact}");
    // A step in twelve is the order of the simulation's error.
    assert!(
        (found - exact).norm() < 0.15 * exact.norm(),
        "{found} {exact}"
    );
}

#[test]
fn what_flies_on_keeps_its_lift() {
    let mut still = scene_from_toml(TABLE_AND_WALL).unwrap();
    let body = &mut still.links[LinkIndex(0)].body;
    *body = Body::new(body.mass_kg(), Vector3::repeat(1.3e-4)).unwrap();
    let mut lifted = still.clone();
    let body = &mut lifted.links[LinkIndex(0)].body;
    *body = body.with_lift(0.5).unwrap();
    let state = brick(0.5);
    let step = 12;
    let [there, then] = [&still, &lifted].map(|scene| {
        let settled = settle(scene, &estimate(scene, state), 0.1).unwrap();
        let body = scene.body_of(MechanismIndex(0));
        let duration_s = step as f64 * INTERVAL_S;
        let exact = flow::advance(body, &scene.gravity_m_s2, &state, duration_s);
        let simulated = settled.links[LinkIndex(0)].poses[step].translation.vector;
        (simulated, exact.position_m)
    });
    let (found, exact) = (then.0 - there.0, then.1 - there.1);
    assert!(exact.norm() > 3e-3, "{exact}");
    assert!(
        (found - exact).norm() < 0.15 * exact.norm(),
        "{found} {exact}"
    );
}

#[test]
fn until_slow_it_is_the_same_simulation_and_shorter() {
    let scene = scene_from_toml(TABLE_AND_WALL).unwrap();
    let estimate = estimate(&scene, brick(0.2));
    let whole = settle(&scene, &estimate, 5.0).unwrap();
    let brief = settle_until_slow(&scene, &estimate, 5.0).unwrap();
    let [whole, brief] = [&whole, &brief].map(|settled| &settled.links[LinkIndex(0)].poses);
    assert!(brief.len() < whole.len());
    assert_eq!(brief[..], whole[..brief.len()]);
    let turn = brief[brief.len() - 1]
        .rotation
        .angle_to(&whole[whole.len() - 1].rotation);
    assert!(turn < 0.1, "{turn}");
}
