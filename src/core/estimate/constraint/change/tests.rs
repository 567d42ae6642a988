use nalgebra::UnitQuaternion;

use super::*;
use crate::math::differentiate;
use crate::physics::support::{Pivot, PivotAxes};

fn states() -> [State; 2] {
    let before = State {
        position_m: Vector3::new(0.1, -0.2, 0.9),
        orientation: UnitQuaternion::from_euler_angles(0.4, -1.1, 2.0),
        velocity_m_s: Vector3::new(1.5, 0.7, 0.1),
        angular_velocity_rad_s: Vector3::new(3.0, -7.0, 5.0),
    };
    let after = State {
        orientation: UnitQuaternion::from_euler_angles(0.5, -1.0, 1.9),
        velocity_m_s: Vector3::new(-0.4, 0.2, 0.6),
        ..before
    };
    [before, after]
}

fn pivoted(axes: PivotAxes) -> Caught {
    let pivot = Pivot {
        at_m: Vector3::new(0.02, -0.05, 0.31),
        axes,
        damping_n_m_s: 0.0,
    };
    pivot.catch(&Vector3::new(1.5e-3, 2e-3, 3e-3))
}

fn kinds() -> [PivotAxes; 3] {
    let axis = Vector3::new(0.3, -0.8, 0.2).normalize();
    [PivotAxes::All, PivotAxes::One(axis), PivotAxes::None]
}

fn rows(caught: &Caught, ends: [&State; 2]) -> (StateTangent, [ByStates; 2]) {
    let mut gap = StateTangent::zeros();
    let mut by = [ByStates::zeros(), ByStates::identity()];
    let [before, after] = &mut by;
    caught.set(ends, &mut gap, [before, after]);
    (gap, by)
}

#[test]
fn derivatives_are_those_of_differences() {
    for axes in kinds() {
        let caught = pivoted(axes);
        let [before, after] = states();
        let (_, by) = rows(&caught, [&before, &after]);
        let numeric = differentiate::jacobian(STATE, 2 * STATE, |x| {
            let [one, other] = [&x[..STATE], &x[STATE..]].map(StateTangent::from_column_slice);
            let moved = [before.retract(&one), after.retract(&other)];
            rows(&caught, [&moved[0], &moved[1]])
                .0
                .iter()
                .copied()
                .collect()
        });
        for row in part::VELOCITY..STATE {
            for column in 0..2 * STATE {
                let exact = by[column / STATE][(row, column % STATE)];
                let found = numeric[row][column];
                assert!(
                    (exact - found).abs() < 1e-6,
                    "{axes:?} {row} {column}: {exact} for {found}"
                );
            }
        }
    }
}
