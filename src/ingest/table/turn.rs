//! What the numbers of an orientation mean.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// Greatest entry by which a matrix times its transpose may be off the identity: numbers of files are rounded.
const ROTATION_LIMIT: f64 = 0.02;

/// What three angles mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Turn {
    /// As people write it.
    pub name: &'static str,
    /// In words.
    pub about: &'static str,
    kind: TurnKind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TurnKind {
    /// Axis times angle.
    Vector,
    /// Turns about the body's own axes, one after the other: the product of the matrices in this order.
    Axes([usize; 3]),
}

/// What three angles may mean.
pub const TURNS: [Turn; 8] = [
    Turn {
        name: "vector",
        about: "rotation vector: axis times angle (Vicon Nexus: helical)",
        kind: TurnKind::Vector,
    },
    Turn {
        name: "rpy",
        about: "roll, pitch, yaw about x, y, z: Rz(yaw)·Ry(pitch)·Rx(roll) (ROS, PX4, QTM, rpy_deg of scenes)",
        kind: TurnKind::Axes([2, 1, 0]),
    },
    Turn {
        name: "euler-xyz",
        about: "about the body's x, then y, then z: Rx·Ry·Rz (Motive: XYZ)",
        kind: TurnKind::Axes([0, 1, 2]),
    },
    Turn {
        name: "euler-xzy",
        about: "Rx·Rz·Ry",
        kind: TurnKind::Axes([0, 2, 1]),
    },
    Turn {
        name: "euler-yxz",
        about: "Ry·Rx·Rz (Unity, three.js YXZ)",
        kind: TurnKind::Axes([1, 0, 2]),
    },
    Turn {
        name: "euler-yzx",
        about: "Ry·Rz·Rx",
        kind: TurnKind::Axes([1, 2, 0]),
    },
    Turn {
        name: "euler-zxy",
        about: "Rz·Rx·Ry",
        kind: TurnKind::Axes([2, 0, 1]),
    },
    Turn {
        name: "euler-zyx",
        about: "Rz·Ry·Rx, the same as rpy",
        kind: TurnKind::Axes([2, 1, 0]),
    },
];

impl Turn {
    /// Roll, pitch, yaw.
    pub(super) const RPY: &'static Self = &TURNS[1];
    /// Axis times angle.
    pub(super) const VECTOR: &'static Self = &TURNS[0];

    /// The meaning with a name.
    pub fn named(name: &str) -> Option<&'static Self> {
        TURNS.iter().find(|turn| turn.name == name)
    }

    /// The names of all, for messages.
    pub(super) fn names() -> String {
        TURNS.map(|turn| turn.name).join(", ")
    }

    /// The quaternion `[x, y, z, w]` of angles about x, y, z \[rad\].
    pub(super) fn quaternion(&self, angles_rad: [f64; 3]) -> [f64; 4] {
        let turned = match self.kind {
            TurnKind::Vector => UnitQuaternion::from_scaled_axis(Vector3::from(angles_rad)),
            TurnKind::Axes(axes) => axes
                .iter()
                .fold(UnitQuaternion::identity(), |turned, axis| {
                    let mut about = Vector3::zeros();
                    about[*axis] = angles_rad[*axis];
                    turned * UnitQuaternion::from_scaled_axis(about)
                }),
        };
        [turned.i, turned.j, turned.k, turned.w]
    }
}

/// The quaternion `[x, y, z, w]` of a matrix given row by row; `None` where it is no rotation.
pub(super) fn quaternion_of_matrix(rows: &[f64; 9]) -> Option<[f64; 4]> {
    let matrix = Matrix3::from_row_slice(rows);
    let off = (matrix * matrix.transpose() - Matrix3::identity()).amax();
    if !(off <= ROTATION_LIMIT) || matrix.determinant() < 0.0 {
        return None;
    }
    let rotation = Rotation3::from_matrix_unchecked(matrix);
    let turned = UnitQuaternion::from_rotation_matrix(&rotation);
    Some([turned.i, turned.j, turned.k, turned.w])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn about(axis: usize, angle_rad: f64) -> Matrix3<f64> {
        let mut of = Vector3::zeros();
        of[axis] = angle_rad;
        Rotation3::from_scaled_axis(of).into_inner()
    }

    #[test]
    fn each_turn_is_the_product_that_it_says() {
        let angles = [0.3, -0.7, 1.9];
        let [x, y, z] = [0, 1, 2].map(|axis| about(axis, angles[axis]));
        for (name, expected) in [
            ("rpy", z * y * x),
            ("euler-xyz", x * y * z),
            ("euler-xzy", x * z * y),
            ("euler-yxz", y * x * z),
            ("euler-yzx", y * z * x),
            ("euler-zxy", z * x * y),
            ("euler-zyx", z * y * x),
        ] {
            let turn = Turn::named(name).expect("a turn");
            let rows: Vec<f64> = expected.transpose().iter().copied().collect();
            let of_matrix =
                quaternion_of_matrix(&rows.try_into().expect("nine")).expect("a rotation");
            let found = turn.quaternion(angles);
            let cosine: f64 = found.iter().zip(of_matrix).map(|(a, b)| a * b).sum();
            assert!(1.0 - cosine.abs() < 1e-12, "{name}");
        }
        assert!(Turn::named("euler").is_none());
        assert_eq!(
            quaternion_of_matrix(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0]),
            None
        );
        assert_eq!(quaternion_of_matrix(&[f64::NAN; 9]), None);
    }
}
