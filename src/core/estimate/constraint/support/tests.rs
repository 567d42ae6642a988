use nalgebra::UnitQuaternion;

use super::*;
use crate::math::differentiate;
use crate::physics::state::StateTangent;

fn state() -> State {
    State {
        position_m: Vector3::new(0.1, -0.2, 0.9),
        orientation: UnitQuaternion::from_euler_angles(0.4, -1.1, 2.0),
        velocity_m_s: Vector3::new(1.5, 0.7, 0.1),
        angular_velocity_rad_s: Vector3::new(3.0, -7.0, 5.0),
    }
}

/// The rows of every kind of support.
fn all(state: &State) -> Vec<Vec<SupportRow>> {
    let normal = Vector3::new(0.1, -0.2, 1.0).normalize();
    let point_m = Vector3::new(0.3, 0.1, -0.2);
    let face = OnPlane::Face {
        point_m: Vector3::new(0.02, -0.01, -0.1),
        normal: Vector3::new(0.2, 0.1, -1.0).normalize(),
    };
    let side = OnPlane::Side {
        radius_m: 0.03,
        axis: Vector3::new(0.1, 0.9, -0.2).normalize(),
    };
    let mut found = Vec::new();
    for sustained in Sustained::ALL {
        for touching in [OnPlane::Ball { radius_m: 0.03 }, face, side] {
            let plane = PlaneSupport {
                normal,
                sustained,
                friction: 0.3,
                touching,
            };
            let mut rows = SupportRows::of(state);
            rows.on_plane(&plane, &point_m);
            found.push(rows.rows);
        }
    }
    let axis = Vector3::new(0.3, -0.8, 0.2).normalize();
    for axes in [PivotAxes::All, PivotAxes::One(axis), PivotAxes::None] {
        let pivot = Pivot {
            at_m: Vector3::new(0.02, -0.05, 0.31),
            axes,
            damping_n_m_s: 0.0,
        };
        let place_m = (axes != PivotAxes::None).then_some(point_m);
        let mut rows = SupportRows::of(state);
        let along = Vector3::new(0.1, 0.9, 0.4).normalize();
        rows.placed(&pivot, place_m, Some(along));
        rows.turning(&pivot);
        found.push(rows.rows);
    }
    found
}

#[test]
fn derivatives_are_those_of_differences() {
    let counts: Vec<usize> = all(&state()).iter().map(Vec::len).collect();
    assert_eq!(counts, [2, 6, 3, 4, 6, 7, 7, 9, 8, 6, 10, 6]);
    for (kind, rows) in all(&state()).iter().enumerate() {
        let numeric = differentiate::jacobian(rows.len(), STATE, |x| {
            let moved = state().retract(&StateTangent::from_column_slice(x));
            all(&moved)[kind].iter().map(|row| row.value).collect()
        });
        for (row, numeric) in rows.iter().zip(&numeric) {
            for (exact, found) in row.by_state.iter().zip(numeric) {
                assert!((exact - found).abs() < 1e-6, "{kind}: {exact} for {found}");
            }
        }
    }
}
