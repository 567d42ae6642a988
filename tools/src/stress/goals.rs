//! Goals that contradict each other, the contact, the table, or the balance of energy.

use enact::math::Pose;
use enact::motion::{
    ArcEstimate, Collision, ContactLaw, Event, EventKind, Feature, Goal, GoalTarget, LinkIndex,
    MechanismIndex, Scene, TrackIndex, VelocityGaps,
};
use enact::physics::{Body, Shape, State, contact};
use nalgebra::{UnitQuaternion, Vector3};

use super::{Trouble, add_both};
use crate::case::Case;
use crate::perform::truth::Flight;
use crate::perform::{Style, Truth};

/// Radius of the ball \[m\].
const RADIUS_M: f64 = 0.03;

/// Adds them.
pub fn add(all: &mut Vec<Trouble>) {
    add_both(all, "goals", "landing below the table", |acting, seed| {
        let mut case = Case::pencil(Style::Tip, acting, seed);
        for goal in &mut case.performance.truth.scene.goals {
            if let GoalTarget::Pose { world_from_body } = &mut goal.target {
                world_from_body.translation.vector.z = -0.2;
            }
        }
        Ok(case)
    });
    add_both(all, "goals", "two places at once", |acting, seed| {
        let mut case = Case::pencil(Style::Tip, acting, seed);
        let goals = &mut case.performance.truth.scene.goals;
        let mut other = goals[0].clone();
        if let GoalTarget::Pose { world_from_body } = &mut other.target {
            world_from_body.translation.vector.x += 0.3;
        }
        goals.push(other);
        Ok(case)
    });
    add_both(all, "goals", "a pose outside a box", |acting, seed| {
        let mut case = Case::pencil(Style::Tip, acting, seed);
        let goals = &mut case.performance.truth.scene.goals;
        goals.push(Goal {
            target: GoalTarget::PositionWithin {
                lower_m: Vector3::repeat(0.5),
                upper_m: Vector3::repeat(0.6),
            },
            ..goals[0].clone()
        });
        Ok(case)
    });
    add_both(all, "goals", "a bounce in mid-air", |acting, seed| {
        let mut case = Case::pencil(Style::Tip, acting, seed);
        let infinite = Vector3::repeat(f64::INFINITY);
        case.performance.truth.scene.goals.push(Goal {
            event: 0,
            link: LinkIndex(0),
            target: GoalTarget::PositionWithin {
                lower_m: Vector3::new(-f64::INFINITY, -f64::INFINITY, 0.5),
                upper_m: infinite,
            },
        });
        Ok(case)
    });
    for gaps in [VelocityGaps::Never, VelocityGaps::WhenNeeded] {
        let allowed = match gaps {
            VelocityGaps::Never => "no velocity gaps",
            _ => "velocity gaps allowed",
        };
        let name = format!("energy from nowhere, {allowed}");
        add_both(all, "goals", &name, move |acting, seed| {
            let mut truth = gaining_ball();
            truth.scene.velocity_gaps = gaps;
            let mut case = Case::new(&truth, acting, seed);
            // As acted the ball gains energy; the scene says that it loses half of it.
            for law in &mut case.performance.truth.scene.contact_laws {
                law.restitution = 0.7;
            }
            Ok(case)
        });
    }
}

/// A ball that hops over three marks on the table, the second hop half as long again as the
/// first: with constant speed along the table, that takes a restitution of 1.5.
fn gaining_ball() -> Truth {
    let times_s = [0.25, 0.55, 1.0];
    let along_m_s = 0.8;
    let mut scene = ball_scene();
    scene.goals = times_s
        .iter()
        .enumerate()
        .map(|(event, time_s)| {
            let x_m = along_m_s * time_s;
            Goal {
                event,
                link: LinkIndex(0),
                target: GoalTarget::PositionWithin {
                    lower_m: Vector3::new(x_m, -f64::INFINITY, -f64::INFINITY),
                    upper_m: Vector3::new(x_m, f64::INFINITY, f64::INFINITY),
                },
            }
        })
        .collect();
    let g = -scene.gravity_m_s2.z;
    let hop = |from_s: f64, to_s: f64| 0.5 * g * (to_s - from_s);
    let state = |time_s: f64, up_m_s: f64| State {
        position_m: Vector3::new(along_m_s * time_s, 0.0, RADIUS_M),
        orientation: UnitQuaternion::identity(),
        velocity_m_s: Vector3::new(along_m_s, 0.0, up_m_s),
        angular_velocity_rad_s: Vector3::new(1.0, 2.0, -1.0),
    };
    let end_s = 1.25;
    let starts = [
        state(times_s[0], -hop(times_s[0], times_s[1]) / 1.5),
        state(times_s[0], hop(times_s[0], times_s[1])),
        state(times_s[1], hop(times_s[1], times_s[2])),
        state(times_s[2], hop(times_s[1], times_s[2])),
    ];
    let spans = [
        (0.0, times_s[0]),
        (times_s[0], times_s[1]),
        (times_s[1], times_s[2]),
        (times_s[2], end_s),
    ];
    let flight = Flight::of(&scene, LinkIndex(0));
    let mut orientation = UnitQuaternion::identity();
    let mut arcs = Vec::new();
    for (index, (state, (start_s, end_s))) in starts.iter().zip(spans).enumerate() {
        let epoch_s = if index == 0 { end_s } else { start_s };
        let mut state = *state;
        state.orientation = orientation;
        if index > 0 {
            orientation = flight.advance(&state, end_s - start_s).orientation;
        }
        arcs.push(ArcEstimate {
            mechanism: MechanismIndex(0),
            epoch_s,
            state,
            start_s,
            end_s,
            support: None,
            certainty: None,
        });
    }
    Truth {
        scene,
        is_physical: false,
        parameters: Vec::new(),
        arcs,
        event_times_s: vec![times_s[0], times_s[1], times_s[2], end_s],
        duration_s: end_s,
    }
}

fn ball_scene() -> Scene {
    let mut scene = Style::Tip.truth().scene;
    scene.name = "ball, hopping".to_owned();
    scene.obstacles.clear();
    scene.tracks[TrackIndex(0)].link_from_tracker = Pose::translation(0.0, 0.0, RADIUS_M);
    let ball = &mut scene.links[LinkIndex(0)];
    ball.name = "ball".to_owned();
    ball.body = Body::new(0.05, Vector3::repeat(0.4 * 0.05 * RADIUS_M * RADIUS_M))
        .expect("a ball is a body");
    ball.shape = Shape::Sphere { radius_m: RADIUS_M };

    ball.features = vec![Feature {
        name: "surface".to_owned(),
        geometry: contact::Feature::Point {
            point_m: Vector3::zeros(),
            radius_m: RADIUS_M,
        },
    }];
    let law = scene.add_law(ContactLaw::frictionless("ball", 1.0));
    let bounce = |index: usize| {
        let bounce = Collision::bounce(LinkIndex(0), 0, 0, law);
        Event::new(format!("bounce {index}"), EventKind::Collision(bounce))
    };
    let end = Event::new("end", EventKind::End);
    scene.events = vec![bounce(1), bounce(2), bounce(3), end];
    scene
}
