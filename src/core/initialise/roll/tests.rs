use super::*;
use crate::motion::ArcGuess;
use crate::physics::contact::{Contact, Feature};
use crate::physics::flow;
use crate::physics::impact::{ContactSet, Law, Side};

const SCENE: &str = include_str!("../../../../config/die.toml");
const AXIS: Vector3<f64> = Vector3::new(0.6, 0.0, -0.8);

fn scene() -> Scene {
    let mut scene = crate::config::scene_from_toml(SCENE).expect("a valid scene file");
    // They tell it too.
    scene.goals.clear();
    scene
}

/// Two flights of the first body that meet at an event, and a guess of them.
fn met<'a>(
    scene: &'a Scene,
    segments: &'a [Segment],
    arcs: Vec<ArcGuess>,
) -> (Pointing<'a>, Guess) {
    let mechanism = MechanismIndex(0);
    let link = scene.free_link(mechanism);
    let body = &scene.links[link].body;
    let guess = Guess {
        arcs,
        event_times_s: vec![0.0; scene.events.len()],
        parameters: Vec::new(),
    };
    let own = vec![0, 1];
    let flights = Flights {
        scene,
        segments,
        own,
    };
    let pointing = Pointing {
        mechanism,
        body,
        axis: AXIS,
        alike: Alike::of(body, &AXIS),
        whole: None,
        flights,
    };
    (pointing, guess)
}

fn segments(event: usize) -> [Segment; 2] {
    [[None, Some(event)], [Some(event), None]].map(|[start_event, end_event]| Segment {
        mechanism: MechanismIndex(0),
        start_event,
        end_event,
        views: Vec::new(),
    })
}

fn bounce(scene: &Scene) -> (usize, Rebound<'_>) {
    let of = |event| Some((event, Rebound::of(scene, MechanismIndex(0), event)?));
    (0..scene.events.len()).find_map(of).expect("a bounce")
}

#[test]
fn a_flight_goes_on_as_the_one_before_and_shows_the_same() {
    let scene = scene();
    let (event, _) = bounce(&scene);
    let segments = segments(event);
    let state = State {
        orientation: UnitQuaternion::from_euler_angles(0.3, 1.0, -2.0),
        angular_velocity_rad_s: Vector3::new(5.0, -3.0, 6.0),
        ..State::at_rest()
    };
    let body = scene.body_of(MechanismIndex(0));
    let arc = |epoch_s: f64| ArcGuess {
        epoch_s,
        state: flow::advance(body, &scene.gravity_m_s2, &state, epoch_s),
        sample_times_s: Vec::new(),
    };
    let mut arcs = vec![arc(-0.3), arc(0.4)];
    let right = arcs[1].state;
    roll(&mut arcs[1].state, &AXIS, 1.1);
    let shown = arcs[1].state.orientation * AXIS;
    assert!((shown - right.orientation * AXIS).norm() < 1e-12);
    assert!(arcs[1].state.orientation.angle_to(&right.orientation) > 1.0);
    let (pointing, mut guess) = met(&scene, &segments, arcs);
    pointing.carry(&mut guess);
    let turned = guess.arcs[1].state;
    assert!(turned.orientation.angle_to(&right.orientation) < 1e-9);
    let off_rad_s = turned.angular_velocity_rad_s - right.angular_velocity_rad_s;
    assert!(off_rad_s.norm() < 1e-9);
}

#[test]
fn a_bounce_tells_how_all_flights_are_turned() {
    let scene = scene();
    let (event, rebound) = bounce(&scene);
    let segments = segments(event);
    let collision = scene.events[event].kind.collision().expect("a bounce");
    let (touching, link) = (collision.contacts[0], collision.link);
    let feature = scene.links[link].features[touching.feature.expect("a point")].geometry;
    let surface = scene.surfaces[touching.other.expect("a plane")].geometry;
    let orientation = UnitQuaternion::from_euler_angles(0.3, 1.0, -2.0);
    let below_m = rebound.off_m(
        &[State {
            orientation,
            ..State::at_rest()
        }; 2],
    )[0];
    let normal = scene.surfaces[touching.other.expect("a plane")]
        .plane()
        .expect("a plane")
        .1;
    let above_m = -normal * below_m;
    let came = State {
        position_m: above_m,
        orientation,
        velocity_m_s: Vector3::new(0.3, -0.2, -2.0),
        angular_velocity_rad_s: Vector3::new(2.0, -1.0, 1.5),
    };
    let Feature::Point { point_m, .. } = feature else {
        panic!("a corner");
    };
    let corner = Feature::corner(point_m);
    let contact = Contact::new(corner, surface).expect("a corner and a plane");
    let contacts = ContactSet::frictionless(&[contact]).expect("one contact");
    let side = Side {
        body: &scene.links[link].body,
        state: &came,
    };
    let impact = contacts.impact(&side, None, &Law::frictionless(0.7));
    let after = impact.expect("it approaches").after[0];
    let left = State {
        velocity_m_s: after.velocity_m_s,
        angular_velocity_rad_s: after.angular_velocity_rad_s,
        ..came
    };
    let mut arcs = Vec::new();
    for mut state in [came, left] {
        roll(&mut state, &AXIS, 1.9);
        arcs.push(ArcGuess {
            epoch_s: 0.0,
            state,
            sample_times_s: Vec::new(),
        });
    }
    let (pointing, guess) = met(&scene, &segments, arcs);
    let turned = pointing.turned(guess);
    let best = turned.iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let (_, best) = best.expect("at least one");
    let half_step_rad = 0.5 * TAU / TURNS as f64;
    for arc in &best.arcs {
        let off_rad = arc.state.orientation.angle_to(&orientation);
        assert!(off_rad < 1.01 * half_step_rad, "{off_rad}");
    }
}
