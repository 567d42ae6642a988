//! A chain or flail of which the last link, a plank, comes down on several corners at once.

use enact::motion::Scene;
use enact::physics::State;
use enact::physics::tree::{ForestSnapshot, TreeState};
use nalgebra::{UnitQuaternion, Vector3};

use crate::tree_impacts::PLANK_M;
use crate::trees::ROD_M;

/// Corners of its lower end: of an edge two, of the whole face three of four.
pub(super) const CORNERS: [&str; 3] = ["corner -x -y -z", "corner +x -y -z", "corner -x +y -z"];
/// Least speed at which each comes down [m/s].
const SPEED_M_S: f64 = 0.4;

/// A plank's corner of that name \[m, plank\].
fn corner_m(at: usize) -> Vector3<f64> {
    let [x, y] = PLANK_M.map(|side| 0.5 * side);
    let signs = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)];
    Vector3::new(signs[at].0 * x, signs[at].1 * y, -0.5 * ROD_M)
}

/// The rods as they are drawn, turned and moved as a whole so that so many corners of the last are on the table, and
/// come down; none where one comes too slowly.
pub(super) fn landed(
    scene: &Scene,
    mut rods: TreeState,
    corners: usize,
    signed: &mut impl FnMut(f64) -> f64,
) -> Option<TreeState> {
    let forest = scene.forest();
    let last = forest.link_count() - 1;
    let mut snapshot = ForestSnapshot::new(&forest, &scene.gravity_m_s2);
    snapshot.set(&rods);
    let (base, plank) = (snapshot.link_state(0), snapshot.link_state(last));
    // On an edge it leans over; on its face it stands.
    let lean = if corners == 2 {
        0.4 + signed(0.25)
    } else {
        0.0
    };
    let leant = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), lean);
    let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), signed(3.0));
    let turn = yaw * leant * plank.orientation.inverse();
    let turned = |state: &State| State {
        position_m: turn * state.position_m,
        orientation: turn * state.orientation,
        velocity_m_s: turn * state.velocity_m_s,
        ..*state
    };
    let (mut base, plank) = (turned(&base), turned(&plank));
    let place_m = |at: usize| plank.position_m + plank.orientation * corner_m(at);
    let speed_m_s = |at: usize| {
        let spin = plank.orientation * plank.angular_velocity_rad_s;
        (plank.velocity_m_s + spin.cross(&(plank.orientation * corner_m(at)))).z
    };
    let speeds = (0..corners).map(speed_m_s);
    let mean_m_s = speeds.clone().sum::<f64>() / corners as f64;
    let sunk_m_s = 1.3 + signed(0.3) + mean_m_s;
    if speeds.fold(f64::NEG_INFINITY, f64::max) - sunk_m_s > -SPEED_M_S {
        return None;
    }
    base.velocity_m_s.z -= sunk_m_s;
    base.position_m.z -= place_m(0).z;
    let base = TreeState::of_body(&base);
    rods.coordinates[..7].copy_from_slice(&base.coordinates);
    rods.rates[..6].copy_from_slice(&base.rates);
    Some(rods)
}
