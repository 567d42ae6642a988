//! A hat catches a box in mid-air; and the same with more wanted than physics can do.
//!
//! Built backward from the goals: from the poses on the table and chosen landing velocities back
//! to the meeting, through the inverted impact, back to the board, through that, to the start.
//! Then it is simulated forward.

use enact::math::Pose;
use enact::motion::{GoalTarget, LinkIndex, Scene};
use enact::physics::State;
use nalgebra::Vector3;

use super::encounter::{Encounter, still};
use super::truth::{Flight, SCAN_S, Truth, TruthError, crossing_s, simulate};

/// Its scene file.
pub const SCENE_TOML: &str = include_str!("../../../config/hat_box.toml");
/// The scene file with more goals than physics meets.
pub const BENT_TOML: &str = include_str!("../../../config/hat_box_bent.toml");

/// The hat.
pub const HAT: LinkIndex = LinkIndex(0);
/// The box.
pub const BOX: LinkIndex = LinkIndex(1);
const BOUNCE: usize = 0;
const MEETING: usize = 1;
const LANDING: usize = 2;

/// How far back a collision is looked for \[s\].
const LONGEST_ARC_S: f64 = 0.5;
/// From the start to the bounce \[s\].
const BEFORE_BOUNCE_S: f64 = 0.27;

/// Landing velocities [m/s], [rad/s, body]. Found by a random search for a motion in which the
/// box comes through the hat's opening, touches nothing but what it should, and neither turns
/// faster than two turns a second before they meet.
const HAT_VELOCITY_M_S: Vector3<f64> = Vector3::new(-0.06, 0.17, -4.67);
const HAT_ANGULAR_VELOCITY_RAD_S: Vector3<f64> = Vector3::new(-2.22, 0.74, 1.1);
const BOX_VELOCITY_M_S: Vector3<f64> = Vector3::new(0.05, 0.21, -4.74);
const BOX_ANGULAR_VELOCITY_RAD_S: Vector3<f64> = Vector3::new(-1.48, 0.16, 4.13);

/// True values of the scene's free parameters: restitutions of bounce and meeting, within 10 %
/// of 0.1, and the meeting's tilt, 3.3° of the 6° allowed.
fn parameters() -> Vec<f64> {
    vec![0.094, 0.106, 2_f64.to_radians(), (-2.6_f64).to_radians()]
}

/// The true motion.
///
/// # Panics
/// If the scene file in this repository is broken.
pub fn truth() -> Truth {
    let scene = enact::config::scene_from_toml(SCENE_TOML).expect("a valid scene file");
    truth_in(&scene).expect("a scene of a hat and a box that bounces, meets and lands")
}

/// The true motion in such a scene.
pub fn truth_in(scene: &Scene) -> Result<Truth, TruthError> {
    let lacks = |what| TruthError::Lacks { what };
    let parameters = parameters();
    let meeting = Encounter::of(scene, &parameters, MEETING).ok_or(lacks("a meeting"))?;
    let bounce = Encounter::of(scene, &parameters, BOUNCE).ok_or(lacks("a bounce"))?;
    let landing = |link, velocity_m_s, angular_velocity_rad_s| {
        let pose = pose_goal(scene, LANDING, link).ok_or(lacks("poses at the landing"))?;
        Ok(State {
            position_m: pose.translation.vector,
            orientation: pose.rotation,
            velocity_m_s,
            angular_velocity_rad_s,
        })
    };
    let hat = landing(HAT, HAT_VELOCITY_M_S, HAT_ANGULAR_VELOCITY_RAD_S)?;
    let cube = landing(BOX, BOX_VELOCITY_M_S, BOX_ANGULAR_VELOCITY_RAD_S)?;
    let (hat_flight, box_flight) = (Flight::of(scene, HAT), Flight::of(scene, BOX));

    let after_meeting_s = crossing_s(SCAN_S, LONGEST_ARC_S, |ago_s| {
        let cube = box_flight.advance(&cube, -ago_s);
        meeting.gap_m(&cube, &hat_flight.advance(&hat, -ago_s))
    })
    .ok_or(lacks("a meeting before the landing"))?;
    let (cube, hat) = meeting.before(
        &box_flight.advance(&cube, -after_meeting_s),
        &hat_flight.advance(&hat, -after_meeting_s),
    );
    let after_bounce_s = crossing_s(SCAN_S, LONGEST_ARC_S, |ago_s| {
        bounce.gap_m(&box_flight.advance(&cube, -ago_s), &still())
    })
    .ok_or(lacks("a bounce before the meeting"))?;
    let (cube, _) = bounce.before(&box_flight.advance(&cube, -after_bounce_s), &still());
    let initial = [
        hat_flight.advance(&hat, -(after_bounce_s + BEFORE_BOUNCE_S)),
        box_flight.advance(&cube, -BEFORE_BOUNCE_S),
    ];
    let duration_s = BEFORE_BOUNCE_S + after_bounce_s + after_meeting_s;
    simulate(scene, &parameters, &initial, duration_s)
}

/// What the performer of the bent scene has in mind: the hat flies as in the true motion, the box
/// from goal to goal.
///
/// # Panics
/// If the scene files in this repository are broken.
pub fn bent_reference() -> Truth {
    let scene = enact::config::scene_from_toml(BENT_TOML).expect("a valid scene file");
    let goal = |event| pose_goal(&scene, event, BOX).expect("a pose of the box at every event");
    let mut truth = truth();
    let poses = [
        truth.world_from_body(BOX, 0.0),
        goal(BOUNCE),
        goal(MEETING),
        goal(LANDING),
    ];
    let times_s = &truth.event_times_s;
    let flights = [
        (times_s[BOUNCE], 0.0),
        (times_s[MEETING] - times_s[BOUNCE], 0.0),
        (times_s[LANDING] - times_s[MEETING], 0.0),
    ];
    let moved = truth.scene.mechanism_of(BOX);
    truth.arcs.retain(|arc| arc.mechanism != moved);
    truth.scene = scene;
    truth.is_physical = false;
    truth.fly_through(BOX, &poses, &flights);
    truth
}

fn pose_goal(scene: &Scene, event: usize, link: LinkIndex) -> Option<Pose> {
    let mut goals = scene.goals.iter();
    let goal = goals.find(|goal| goal.event == event && goal.link == link)?;
    match goal.target {
        GoalTarget::Pose { world_from_body } => Some(world_from_body),
        GoalTarget::PositionWithin { .. } | GoalTarget::Condition(_) => None,
    }
}
