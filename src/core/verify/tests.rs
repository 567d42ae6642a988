//! Hand-made motions with known results.

use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;

use super::verify;
use crate::config::scene_from_toml;
use crate::motion::{
    About, Against, ArcEstimate, Counters, DurationEstimate, End, Estimate, EventEstimate,
    FitUntold, Gap, LinkIndex, MechanismIndex, Penetration, Place, Progress, Scene, Verdict,
};
use crate::physics::impact::{Law, Side};
use crate::physics::{Drag, State, flow};

mod meetings;

const TABLE: &str = r#"
[[surface]]
name = "table"
point_mm = [0, 0, 0]
normal = [0, 0, 1]
"#;

const DROP: &str = r#"
[[event]]
name = "bounce"
kind = "collision"
body = "thing"
feature = "tip"
surface = "table"
restitution = 0.6
[[event]]
name = "end"
kind = "end"
"#;

const BALL: &str = "{ kind = \"sphere\", radius_mm = 20 }";
const PENCIL: &str = "{ kind = \"cylinder\", length_mm = 190, radius_mm = 3.75 }";
const CUBE: &str = "{ kind = \"cuboid\", size_mm = [100, 100, 100] }";

/// A scene with gravity, one body called `thing`, and more.
fn scene(gravity_z: f64, shape: &str, features: &str, more: &str) -> Scene {
    let text = format!(
        "name = \"test\"\ngravity_m_s2 = [0, 0, {gravity_z:?}]\n[timing]\nstamps = \"physical\"\n\
         [[body]]\nname = \"thing\"\nshape = {shape}\nmass_g = 50\nfeatures_mm = {{ {features} }}\n{more}"
    );
    scene_from_toml(&text).unwrap()
}

fn at_rest(x: f64, y: f64, z: f64) -> State {
    State {
        position_m: Vector3::new(x, y, z),
        orientation: UnitQuaternion::identity(),
        velocity_m_s: Vector3::zeros(),
        angular_velocity_rad_s: Vector3::zeros(),
    }
}

fn arc(mechanism: MechanismIndex, state: State, start_s: f64, end_s: f64) -> ArcEstimate {
    ArcEstimate {
        mechanism,
        epoch_s: start_s,
        state,
        start_s,
        end_s,
        support: None,
        certainty: None,
    }
}

fn estimate(scene: &Scene, arcs: Vec<ArcEstimate>, events_s: &[f64]) -> Estimate {
    let event = |(event, time_s): (usize, &f64)| EventEstimate {
        contact_s: 0.0,
        event,
        time_s: *time_s,
        sd_s: None,
        is_fixed: false,
        at_bound: None,
        acted_s: *time_s,
        gap: Gap::default(),
        leaning: None,
    };
    Estimate {
        verdict: Verdict::Physical,
        reason: End::Converged(Progress::default()).into(),
        doubts: Vec::new(),
        fit: Err(FitUntold::NotAsked),
        suspects: Vec::new(),
        objective: 0.0,
        gravity_m_s2: scene.gravity_m_s2,
        arcs,
        held: Vec::new(),
        grips: Vec::new(),
        trees: Vec::new(),
        events: events_s.iter().enumerate().map(event).collect(),
        duration: DurationEstimate {
            duration_s: 1.0,
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

/// The deepest overlap of a flight of one second.
fn deepest_of(scene: &Scene, states: &[State]) -> Option<Penetration> {
    let arcs = scene.mechanisms.keys().zip(states);
    let arcs = arcs.map(|(mechanism, state)| arc(mechanism, *state, 0.0, 1.0));
    verify(scene, &estimate(scene, arcs.collect(), &[])).deepest
}

/// A ball that dives under gravity turned upwards; its lowest point comes to `−depth_m`.
fn dive(depth_m: f64) -> (Scene, State) {
    let mut state = at_rest(0.0, 0.0, 0.3);
    // v²/2g = height of the lowest point + depth.
    state.velocity_m_s.z = -(2.0 * 8.0 * (0.28 + depth_m)).sqrt();
    (scene(8.0, BALL, "", TABLE), state)
}

#[test]
fn a_dive_through_the_table_is_found_with_its_depth() {
    for depth_m in [1.1e-3, 0.012, 0.2] {
        let (scene, state) = dive(depth_m);
        let found = deepest_of(&scene, &[state]).unwrap();
        assert!((found.depth_m - depth_m).abs() < 1e-10, "{found:?}");
        assert!((found.time_s + state.velocity_m_s.z / 8.0).abs() < 1e-6);
        assert_eq!(
            (found.link, found.against),
            (LinkIndex(0), Against::Surface(0))
        );
        assert!((found.point_m - Vector3::new(0.0, 0.0, -0.02)).norm() < 1e-12);
    }
}

#[test]
fn a_graze_is_no_overlap() {
    let tolerance_m = dive(0.0).0.tolerance_m;
    for depth_m in [-0.1, -1e-4, 0.0, 0.9 * tolerance_m] {
        let (scene, state) = dive(depth_m);
        assert_eq!(deepest_of(&scene, &[state]), None, "{depth_m}");
    }
}

#[test]
fn a_flight_through_a_thin_wall_and_through_another_body_is_found() {
    let wall = "[[obstacle]]\nname = \"wall\"\nposition_mm = [500, 0, 0]\n\
                shape = { kind = \"cuboid\", size_mm = [4, 300, 300] }\n";
    let other = format!("[[body]]\nname = \"other\"\nshape = {BALL}\nmass_g = 50\n");
    let scene = scene(0.0, BALL, "", &format!("{other}{wall}"));
    let mut state = at_rest(0.0, 0.0, 0.01);
    state.velocity_m_s.x = 3.0;
    let far = at_rest(0.0, 5.0, 0.0);
    let found = deepest_of(&scene, &[state, far]).unwrap();
    // Half the ball and half the wall: it is inside by the way out.
    assert!((found.depth_m - 0.022).abs() < 1e-6, "{found:?}");
    assert!((found.time_s - 0.5 / 3.0).abs() < 1e-3, "{found:?}");
    assert_eq!(found.against, Against::Obstacle(0));
    // Nearest approach of the centres is 10 mm, of balls of 20 mm each.
    let mut crossing = at_rest(0.3, -0.3, 0.0);
    crossing.velocity_m_s.y = 3.0;
    let found = deepest_of(&scene, &[state, crossing]).unwrap();
    assert_eq!(
        (found.link, found.against),
        (LinkIndex(0), Against::Link(LinkIndex(1)))
    );
    assert!((found.depth_m - 0.03).abs() < 1e-9, "{found:?}");
    assert!((found.time_s - 0.1).abs() < 1e-6, "{found:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Compares with ten thousand distance queries on each flight of a spinning pencil over a table
    /// and a post.
    #[test]
    fn nothing_deeper_than_the_tolerance_is_missed(
        height in 0.1..0.6f64,
        velocity in prop::array::uniform3(-1.5..1.5f64),
        spin in prop::array::uniform3(-25.0..25.0f64),
    ) {
        let post = "[[obstacle]]\nname = \"post\"\nposition_mm = [200, 0, 100]\n\
                    shape = { kind = \"capsule\", length_mm = 200, radius_mm = 15 }\n";
        let scene = scene(-9.81, PENCIL, "", &format!("{TABLE}{post}"));
        let state = State {
            velocity_m_s: Vector3::from(velocity),
            angular_velocity_rad_s: Vector3::from(spin),
            ..at_rest(0.0, 0.0, height)
        };
        // Up to where the whole pencil is below the table at most.
        let end_s = 0.35;
        let (body, gravity) = (&scene.links[LinkIndex(0)], &scene.gravity_m_s2);
        let (solid, post) = (body.shape.solid().unwrap(), &scene.obstacles[0]);
        let post_solid = post.shape.solid().unwrap();
        let looks = (0..=10_000).map(|k| {
            let at = flow::advance(&body.body, gravity, &state, end_s * k as f64 / 1e4);
            let pose = at.world_from_body();
            let table = solid.lowest(&pose, &Vector3::zeros(), &Vector3::z()).unwrap();
            let post = solid.closest(&pose, &post_solid, &post.world_from_shape).unwrap();
            (-table.gap_m).max(-post.gap_m)
        });
        let expected_m = looks.fold(f64::NEG_INFINITY, f64::max);
        let checked = verify(&scene, &estimate(&scene, vec![arc(MechanismIndex(0), state, 0.0, end_s)], &[]));
        let found_m = checked.deepest.map_or(0.0, |deepest| deepest.depth_m);
        if expected_m > scene.tolerance_m {
            prop_assert!(found_m > expected_m - 2.5e-4, "{found_m} {expected_m}");
        }
        prop_assert!(found_m <= expected_m.max(0.0) + 1e-5, "{found_m} {expected_m}");
    }
}

/// The motion about a bounce of a point of the body, in a state with its height adjusted.
fn bounced(scene: &Scene, before: State, tip: Vector3<f64>) -> Estimate {
    let time_s = 0.4;
    let mut before = before;
    before.position_m.z = -(before.orientation * tip).z;
    let body = &scene.links[LinkIndex(0)].body;
    let start = flow::advance(body, &scene.gravity_m_s2, &before, -time_s);
    let after = struck(scene, 0, &Law::frictionless(0.6), &[before]).remove(0);
    let arcs = vec![
        arc(MechanismIndex(0), start, 0.0, time_s),
        arc(MechanismIndex(0), after, time_s, 0.7),
    ];
    estimate(scene, arcs, &[time_s, 0.7])
}

/// The states after the collision that an event is.
fn struck(scene: &Scene, event: usize, law: &Law, before: &[State]) -> Vec<State> {
    let meeting = scene.contact_set(event).unwrap().unwrap();
    let collision = scene.events[event].kind.collision().unwrap();
    let links = collision.links().zip(before);
    let sides: Vec<Side> = links
        .map(|(link, state)| Side {
            body: &scene.links[link].body,
            state,
        })
        .collect();
    let impact = meeting.impact(&sides[0], sides.get(1), law).unwrap();
    assert!(impact.speeds_m_s[0] < -0.1 && !impact.pulls(), "{impact:?}");
    let after = before.iter().zip(impact.after);
    after
        .map(|(state, after)| State {
            velocity_m_s: after.velocity_m_s,
            angular_velocity_rad_s: after.angular_velocity_rad_s,
            ..*state
        })
        .collect()
}

/// Two points of a bar that are near each other come down at once: where one is slower by a third, it would have to be
/// drawn back.
#[test]
fn contacts_that_pull_are_doubted() {
    let scene = scene(
        -9.81,
        "{ kind = \"cuboid\", size_mm = [300, 40, 20] }",
        "a = [-30, 0, -10], b = [30, 0, -10]",
        &format!(
            "{TABLE}{}",
            DROP.replace("feature = \"tip\"", "features = [\"a\", \"b\"]")
        ),
    );
    let set = scene.contact_set(0).unwrap().unwrap();
    for (spin_rad_s, pulls) in [(1.0, false), (6.5, true)] {
        let before = State {
            velocity_m_s: Vector3::new(0.0, 0.0, -0.8),
            angular_velocity_rad_s: Vector3::new(0.0, spin_rad_s, 0.0),
            ..at_rest(0.0, 0.0, 0.01)
        };
        let side = Side {
            body: &scene.links[LinkIndex(0)].body,
            state: &before,
        };
        let impact = set.impact(&side, None, &Law::frictionless(0.6)).unwrap();
        assert_eq!(impact.pulls(), pulls, "{impact:?}");
        let after = State {
            velocity_m_s: impact.after[0].velocity_m_s,
            angular_velocity_rad_s: impact.after[0].angular_velocity_rad_s,
            ..before
        };
        let start = flow::advance(side.body, &scene.gravity_m_s2, &before, -0.1);
        let arcs = vec![
            arc(MechanismIndex(0), start, 0.0, 0.1),
            arc(MechanismIndex(0), after, 0.1, 0.15),
        ];
        let verification = verify(&scene, &estimate(&scene, arcs, &[0.1, 0.15]));
        let doubts = verification.doubts();
        let mut told = doubts.iter().filter(|doubt| doubt.about == About::Pull);
        assert_eq!(told.next().is_some(), pulls, "{doubts:?}");
        if pulls {
            let [one, other, _] = impact.normal_impulses_n_s;
            let share = -one.min(other) / one.max(other);
            let off = verification.pulls[0].share - share;
            assert!(off.abs() < 1e-9 && share > 0.1, "{share} {off}");
        }
    }
}

fn leaning(angle_rad: f64) -> State {
    State {
        orientation: UnitQuaternion::from_euler_angles(angle_rad, 0.0, 0.0),
        velocity_m_s: Vector3::new(0.3, 0.1, -2.0),
        angular_velocity_rad_s: Vector3::new(1.0, 0.0, 3.0),
        ..at_rest(0.0, 0.0, 0.0)
    }
}

#[test]
fn the_rim_about_a_tip_is_the_tip_and_its_lead_is_told() {
    let scene = scene(
        -9.81,
        PENCIL,
        "tip = [0, 0, -95]",
        &format!("{TABLE}{DROP}"),
    );
    let mut motion = bounced(&scene, leaning(0.5), Vector3::new(0.0, 0.0, -0.095));
    // Before it falls through the table.
    motion.arcs[1].end_s = 0.42;
    let checked = verify(&scene, &motion);
    let [touch] = &checked.touches[..] else {
        panic!("{:?}", checked.touches)
    };
    let lead_m = 0.00375 * 0.5f64.sin();
    assert!((touch.lead_m - lead_m).abs() < 1e-12, "{touch:?}");
    assert!(touch.overlap_m >= lead_m - 1e-12 && touch.overlap_m < 0.00375);
    assert_eq!((touch.found, touch.is_wrong), (Some(0), false));
    assert!(touch.found_time_s < 0.4 && touch.found_time_s > 0.395);
    assert_eq!(checked.deepest, None);
    assert!(checked.doubts().is_empty());
}

#[test]
fn a_corner_that_leads_is_named_with_its_time() {
    let features = "tip = [50, 50, -50], under = [50, -50, -50]";
    let scene = scene(-9.81, CUBE, features, &format!("{TABLE}{DROP}"));
    // Turned about x by a negative angle, the corner at −y is the lower one.
    let mut state = leaning(0.2);
    state.angular_velocity_rad_s = Vector3::zeros();
    let checked = verify(
        &scene,
        &bounced(&scene, state, Vector3::new(0.05, 0.05, -0.05)),
    );
    let touch = checked.wrong_features().next().unwrap();
    assert_eq!(
        (touch.expected.as_slice(), touch.found),
        (&[0][..], Some(1))
    );
    let lead_m = 0.1 * 0.2f64.sin();
    assert!((touch.lead_m - lead_m).abs() < 1e-12, "{touch:?}");
    // ½ g s² + 2 s back from the event is how far it was above.
    let earlier_s = 0.4 - touch.found_time_s;
    let way_m = (2.0 - 0.5 * 9.81 * earlier_s) * earlier_s;
    assert!((way_m - lead_m).abs() < 1e-9, "{way_m} {lead_m}");
    // It is an overlap, too: no feature that is expected explains it.
    let deepest = checked.deepest.unwrap();
    assert!(deepest.depth_m >= lead_m - 1e-9 && !checked.doubts().is_empty());
}

#[test]
fn a_part_that_is_not_declared_is_wrong_too() {
    let scene = scene(
        -9.81,
        CUBE,
        "tip = [50, 50, -50]",
        &format!("{TABLE}{DROP}"),
    );
    let checked = verify(
        &scene,
        &bounced(&scene, leaning(0.2), Vector3::new(0.05, 0.05, -0.05)),
    );
    let touch = checked.wrong_features().next().unwrap();
    let found = touch
        .found
        .map(|found| scene.links[LinkIndex(0)].features[found].name.as_str());
    assert_eq!(found, Some("corner +x -y -z"));
    assert!((touch.found_point_m.y + 0.05).abs() < 1e-12, "{touch:?}");
}

/// What is off in the single shot and the balances of a motion about a bounce.
fn off_in(scene: &Scene, motion: &Estimate) -> (f64, f64) {
    let checked = verify(scene, motion);
    let shot = &checked.single_shot;
    let deviations = shot.deviations.iter();
    let off = deviations.map(|d| d.position_m + d.velocity_m_s + d.time_s);
    let balance = &checked.balance;
    (
        off.fold(0.0, f64::max),
        balance.flight_energy.max(balance.flight_momentum),
    )
}

#[test]
fn a_bounce_in_wind_and_air_is_that_of_its_drag_and_force() {
    let air = scene(
        -9.81,
        PENCIL,
        "tip = [0, 0, -95]",
        &format!("{TABLE}{DROP}"),
    );
    let mut windy = air.clone();
    let body = &mut windy.links[LinkIndex(0)].body;
    let drag = Drag {
        linear_per_s: 0.3,
        quadratic_per_m: 0.2,
    };
    *body = body.with_drag(drag).unwrap();
    *body = body.with_force(Vector3::new(0.4, 0.0, 0.1)).unwrap();
    let tip = Vector3::new(0.0, 0.0, -0.095);
    let (off, unbalanced) = off_in(&windy, &bounced(&windy, leaning(0.3), tip));
    assert!(off < 1e-10 && unbalanced < 1e-10, "{off:e} {unbalanced:e}");
    // The motion of a body that feels no air does not meet its own impact in it.
    let (off, _) = off_in(&windy, &bounced(&air, leaning(0.3), tip));
    assert!(off > 1e-2, "{off:e}");
}

#[test]
fn a_single_shot_of_an_exact_motion_ends_where_it_does() {
    for (shape, tip) in [
        (PENCIL, Vector3::new(0.0, 0.0, -0.095)),
        (CUBE, Vector3::new(-0.05, 0.05, -0.05)),
    ] {
        let named = tip * 1e3;
        let features = format!("tip = [{}, {}, {}]", named.x, named.y, named.z);
        let scene = scene(-9.81, shape, &features, &format!("{TABLE}{DROP}"));
        let mut state = leaning(0.3);
        state.angular_velocity_rad_s = Vector3::new(11.0, -4.0, 20.0);
        let motion = bounced(&scene, state, tip);
        let checked = verify(&scene, &motion);
        let shot = &checked.single_shot;
        assert_eq!(shot.deviations.len(), 2);
        assert!(shot.restarts.is_empty() && shot.missed.is_empty());
        for deviation in &shot.deviations {
            assert!(deviation.time_s < 1e-13, "{deviation:?}");
            assert!(deviation.position_m < 1e-12, "{deviation:?}");
            assert!(deviation.orientation_rad < 1e-11, "{deviation:?}");
            assert!(deviation.velocity_m_s < 1e-11, "{deviation:?}");
            assert!(deviation.angular_velocity_rad_s < 1e-9, "{deviation:?}");
        }
        let balance = checked.balance;
        assert!(balance.flight_energy < 1e-13 && balance.flight_momentum < 1e-13);
        assert!(balance.flight_angular_momentum < 1e-12);
        assert!(balance.impact_energy < 1e-12 && balance.impact_angular_momentum < 1e-12);
        assert_eq!(verify(&scene, &motion), checked);
    }
}

#[test]
fn what_is_bent_after_an_impact_is_measured_or_begun_anew() {
    let scene = scene(
        -9.81,
        PENCIL,
        "tip = [0, 0, -95]",
        &format!("{TABLE}{DROP}"),
    );
    let mut motion = bounced(&scene, leaning(0.1), Vector3::new(0.0, 0.0, -0.095));
    motion.arcs[1].state.velocity_m_s.x += 0.05;
    // Nobody said that there is a gap: the shot goes on as physics would.
    let checked = verify(&scene, &motion);
    let end = checked.single_shot.at_end().unwrap();
    assert!((end.position_m - 0.05 * 0.3).abs() < 1e-9, "{end:?}");
    assert!((end.velocity_m_s - 0.05).abs() < 1e-9, "{end:?}");
    assert!(checked.balance.impact_energy > 1e-3);
    motion.events[0].gap.velocity_m_s = 0.05;
    let checked = verify(&scene, &motion);
    assert_eq!(checked.single_shot.restarts, [0]);
    assert!(checked.single_shot.at_end().unwrap().position_m < 1e-12);
}

#[test]
fn a_collision_that_does_not_happen_is_missed() {
    let scene = scene(
        -9.81,
        PENCIL,
        "tip = [0, 0, -95]",
        &format!("{TABLE}{DROP}"),
    );
    let mut motion = bounced(&scene, leaning(0.1), Vector3::new(0.0, 0.0, -0.095));
    let apart = |motion: &Estimate| {
        let doubts = verify(&scene, motion).doubts();
        doubts.into_iter().find(|of| of.about == About::Gap)
    };
    assert_eq!(apart(&motion), None);
    motion.arcs[0].state.position_m.z += 1.0;
    let shot = verify(&scene, &motion).single_shot;
    assert_eq!((shot.missed, shot.restarts), (vec![0], vec![0]));
    let apart = apart(&motion).unwrap();
    assert!((apart.value - 1.0).abs() < 1e-9 && apart.place == Place::Event(0));
    assert_eq!(apart.about.best(), Verdict::Failed);
}

/// A pencil falls tip down on a box that rests; then its flight goes on into it.
#[test]
fn contact_of_two_bodies_explains_their_features_and_nothing_else() {
    let more = format!(
        "[[body]]\nname = \"box\"\nshape = {CUBE}\nmass_g = 50\n\
         [[body.face]]\nname = \"lid\"\npoint_mm = [0, 0, 50]\nnormal = [0, 0, 1]\n\
         [[event]]\nname = \"hit\"\nkind = \"collision\"\nbody = \"thing\"\nfeature = \"tip\"\n\
         other = \"box\"\nother_feature = \"lid\"\nrestitution = 0.5\n"
    );
    let scene = scene(0.0, PENCIL, "tip = [0, 0, -95]", &more);
    let lean = 0.2f64;
    let motion = |lead_m: f64, end_s: f64| {
        let tip = UnitQuaternion::from_euler_angles(lean, 0.0, 0.0) * Vector3::z() * 0.095;
        let mut state = leaning(lean);
        state.angular_velocity_rad_s = Vector3::zeros();
        state.velocity_m_s = Vector3::new(0.0, 0.0, -1.0);
        // The tip's centre is on the lid at 0.4 s.
        state.position_m = tip + Vector3::new(0.0, 0.0, 0.05 + 0.4 - lead_m);
        let still = at_rest(0.0, 0.0, 0.0);
        let arcs = vec![
            arc(MechanismIndex(0), state, 0.0, 0.4),
            arc(MechanismIndex(0), flow_by(&scene, &state, 0.4), 0.4, end_s),
            arc(MechanismIndex(1), still, 0.0, 0.4),
            arc(MechanismIndex(1), still, 0.4, end_s),
        ];
        verify(&scene, &estimate(&scene, arcs, &[0.4]))
    };
    let rim_m = 0.00375 * lean.sin();
    let touching = motion(0.0, 0.4 + 5e-4);
    assert_eq!(touching.deepest, None);
    let [of_pencil, of_box] = &touching.touches[..] else {
        panic!("{:?}", touching.touches)
    };
    assert!((of_pencil.lead_m - rim_m).abs() < 1e-6, "{of_pencil:?}");
    assert_eq!(
        (of_box.link, of_box.against),
        (LinkIndex(1), Against::Link(LinkIndex(0)))
    );
    // Twenty millimetres on, the tip is inside, though it was expected at the lid.
    let through = motion(0.0, 0.42).deepest.unwrap();
    assert!((through.depth_m - 0.02).abs() < rim_m, "{through:?}");
    assert_eq!(through.against, Against::Link(LinkIndex(1)));
}

fn flow_by(scene: &Scene, state: &State, duration_s: f64) -> State {
    flow::advance(
        &scene.links[LinkIndex(0)].body,
        &scene.gravity_m_s2,
        state,
        duration_s,
    )
}
