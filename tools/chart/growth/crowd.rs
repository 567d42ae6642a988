//! Several cubes side by side, each with a bounce of its own, in one scene.

use enact::motion::{Event, EventKind, SceneBody};
use nalgebra::Vector3;

use crate::case::Case;
use crate::perform::{Acting, Truth, bounces, simulate};

/// When all of it ends [s].
const END_S: f64 = 0.6;
/// A cube bounces within this [s],
const BOUNCE_S: std::ops::Range<f64> = 0.2..0.45;
/// and not again before the end and this [s].
const CLEAR_S: f64 = 0.02;
/// Bounces are further apart than this [s].
const APART_S: f64 = 0.001;
/// From cube to cube [m].
const SPACING_M: f64 = 1.0;

/// So many cubes; the tracker's noise and no wander, marks with names.
pub fn crowd(count: usize) -> Case {
    let mut cubes: Vec<Truth> = Vec::new();
    for seed in 1.. {
        if cubes.len() == count {
            break;
        }
        let is_apart = |cube: &Truth| {
            let bounce_s = cube.event_times_s[0];
            let mut others = cubes.iter().map(|other| other.event_times_s[0]);
            others.all(|other_s| (other_s - bounce_s).abs() > APART_S)
        };
        let cube = bounces(1, seed).ok().filter(fits);
        cubes.extend(cube.filter(is_apart));
    }
    // In the order of their bounces.
    cubes.sort_by(|a, b| a.event_times_s[0].total_cmp(&b.event_times_s[0]));
    let mut scene = cubes[0].scene.clone();
    scene.name = format!("{count} cubes");
    scene.bodies.clear();
    scene.events.clear();
    let mut initial = Vec::new();
    for (index, cube) in cubes.iter().enumerate() {
        scene.bodies.push(SceneBody {
            name: format!("cube {index}"),
            topic: format!("/tracker/cube_{index}/pose"),
            ..cube.scene.bodies[0].clone()
        });
        let bounce = cube.scene.events[0].kind.collision();
        let mut bounce = bounce.expect("a bounce comes first").clone();
        bounce.body = index;
        scene.events.push(Event {
            name: format!("bounce {index}"),
            kind: EventKind::Collision(bounce),
        });
        let mut state = cube.arcs[0].state;
        state.position_m += Vector3::x() * (SPACING_M * index as f64);
        initial.push(state);
    }
    scene.events.push(Event {
        name: "end".to_owned(),
        kind: EventKind::End,
    });
    let truth = simulate(&scene, &[], &initial, END_S).expect("they bounced before");
    let acting = Acting {
        // Bounces are milliseconds apart, marks and estimates are to be in their order.
        distortion: 0.0,
        mark_error_s: 0.0,
        marks_named: true,
        ..Acting::timing_known()
    };
    Case::new(&truth, &acting, 1)
}

/// Whether a cube bounces once, and in time; its record ends half-way to the next bounce.
fn fits(cube: &Truth) -> bool {
    let bounce_s = cube.event_times_s[0];
    let next_s = bounce_s + 2.0 * (cube.duration_s - bounce_s);
    BOUNCE_S.contains(&bounce_s) && next_s > END_S + CLEAR_S
}
