//! Several cubes side by side, each with a bounce of its own, in one scene.

use enact::motion::{Event, EventKind, FreeBody, LinkIndex, TrackIndex};
use enact::physics::{State, flow};
use nalgebra::Vector3;

use enact_tools::case::Case;
use enact_tools::perform::{Acting, Truth, bounces, simulate};

/// When all of it ends \[s\].
const END_S: f64 = 0.6;
/// No cube bounces a second time before the end and this \[s\].
const CLEAR_S: f64 = 0.02;
/// The bounces are evenly between these \[s\].
const FIRST_S: f64 = 0.22;
const LAST_S: f64 = 0.45;
/// Nothing touches the table with its centre as high as this, more than half a diagonal \[m\].
const HIGH_M: f64 = 0.27;
/// From cube to cube \[m\].
const SPACING_M: f64 = 1.0;

/// So many cubes; the tracker's noise and no wander, marks with names.
pub fn crowd(count: usize) -> Case {
    let mut cubes: Vec<(Truth, State)> = Vec::new();
    for seed in 1.. {
        if cubes.len() == count {
            break;
        }
        let bounce_s = FIRST_S + (LAST_S - FIRST_S) * cubes.len() as f64 / count as f64;
        let cube = bounces(1, seed).ok();
        cubes.extend(cube.and_then(|cube| {
            let state = begun(&cube, bounce_s)?;
            Some((cube, state))
        }));
    }
    let mut scene = cubes[0].0.scene.clone();
    scene.name = format!("{count} cubes");
    scene.links.clear();
    scene.mechanisms.clear();
    scene.tracks.clear();
    scene.events.clear();
    let mut initial = Vec::new();
    for (index, (cube, state)) in cubes.iter().enumerate() {
        let link = &cube.scene.links[LinkIndex(0)];
        let link = scene.add(FreeBody {
            name: format!("cube {index}"),
            topic: format!("/tracker/cube_{index}/pose"),
            body: link.body,
            shape: link.shape.clone(),
            body_from_tracker: cube.scene.tracks[TrackIndex(0)].link_from_tracker,
            features: link.features.clone(),
        });
        let bounce = cube.scene.events[0].kind.collision();
        let mut bounce = bounce.expect("a bounce comes first").clone();
        bounce.link = link;
        let name = format!("bounce {index}");
        let kind = EventKind::Collision(bounce);
        scene.events.push(Event::new(name, kind));
        let mut state = *state;
        state.position_m += Vector3::x() * (SPACING_M * index as f64);
        initial.push(state);
    }
    scene.events.push(Event::new("end", EventKind::End));
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

/// The state in which a cube begins whose first bounce is at that time, if it then is clear of the
/// table and bounces no second time; its record ends half-way to the next bounce.
fn begun(cube: &Truth, bounce_s: f64) -> Option<State> {
    let own_s = cube.event_times_s[0];
    let next_s = bounce_s + 2.0 * (cube.duration_s - own_s);
    let body = &cube.scene.links[LinkIndex(0)].body;
    let gravity_m_s2 = &cube.scene.gravity_m_s2;
    let first = &cube.arcs[0].state;
    let state = flow::advance(body, gravity_m_s2, first, own_s - bounce_s);
    (next_s > END_S + CLEAR_S && state.position_m.z > HIGH_M).then_some(state)
}
