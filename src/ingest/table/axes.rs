//! Axes of worlds, and what is usual for whom.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};

use super::units::TimeUnit;
use crate::motion::LengthUnit;

/// The rows of a signed permutation: world axes (x forward or right, z up) of a vendor's axes.
type Axes = [[i8; 3]; 3];

const Z_UP: Axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
/// (x, y, z) → (x, −z, y).
const Y_UP: Axes = [[1, 0, 0], [0, 0, -1], [0, 1, 0]];
/// (x, y, z) → (y, z, x).
const X_UP: Axes = [[0, 1, 0], [0, 0, 1], [1, 0, 0]];
/// x right, y down, z ahead: (x, y, z) → (x, z, −y).
const Y_DOWN: Axes = [[1, 0, 0], [0, 0, 1], [0, -1, 0]];
/// x ahead, y right, z down: (x, y, z) → (x, −y, −z).
const Z_DOWN: Axes = [[1, 0, 0], [0, -1, 0], [0, 0, -1]];
/// Left-handed, z ahead: (x, y, z) → (z, −x, y).
const UNITY: Axes = [[0, 0, 1], [-1, 0, 0], [0, 1, 0]];
/// Left-handed, y to the right: (x, y, z) → (x, −y, z).
const UNREAL: Axes = [[1, 0, 0], [0, -1, 0], [0, 0, 1]];

/// What is usual for files of one origin, where a file does not say it itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// As people write it.
    pub name: &'static str,
    /// In words.
    pub about: &'static str,
    axes: Axes,
    pub(super) length: LengthUnit,
    pub(super) time: Option<TimeUnit>,
    /// Columns of files without a head.
    pub(super) columns: Option<&'static str>,
}

const fn preset(name: &'static str, about: &'static str, axes: Axes, length: LengthUnit) -> Preset {
    Preset {
        name,
        about,
        axes,
        length,
        time: None,
        columns: None,
    }
}

const M: LengthUnit = LengthUnit::Metre;
const MM: LengthUnit = LengthUnit::Millimetre;

/// The presets; `docs/import.md` has the source of each.
pub const PRESETS: [Preset; 15] = [
    preset("z-up", "right-handed, z up, metres: ROS, Blender", Z_UP, M),
    preset("y-up", "right-handed, y up, metres: glTF, Maya", Y_UP, M),
    preset("x-up", "right-handed, x up, metres", X_UP, M),
    preset("motive-y-up", "OptiTrack Motive: y up, metres", Y_UP, M),
    preset(
        "motive-z-up",
        "OptiTrack Motive, exported with z up, metres",
        Z_UP,
        M,
    ),
    preset("vicon", "Vicon Tracker, Nexus: z up, millimetres", Z_UP, MM),
    preset(
        "qualisys",
        "Qualisys Track Manager: z up, millimetres",
        Z_UP,
        MM,
    ),
    preset("trc", "TRC of OpenSim: y up, metres", Y_UP, M),
    preset(
        "camera",
        "a camera's first view: x right, y down, z ahead, metres (KITTI, OpenCV, AprilTag)",
        Y_DOWN,
        M,
    ),
    preset(
        "ned",
        "x north, y east, z down, metres (PX4, aircraft)",
        Z_DOWN,
        M,
    ),
    preset("openvr", "SteamVR, OpenVR, OpenXR: y up, metres", Y_UP, M),
    preset(
        "unity",
        "Unity, Rokoko: left-handed, y up, metres",
        UNITY,
        M,
    ),
    preset(
        "unreal",
        "Unreal: left-handed, z up, centimetres",
        UNREAL,
        LengthUnit::Centimetre,
    ),
    Preset {
        time: Some(TimeUnit::Second),
        columns: Some("t,x,y,z,qx,qy,qz,qw"),
        ..preset("tum", "TUM: t [s], x, y, z [m], qx, qy, qz, qw", Z_UP, M)
    },
    Preset {
        time: Some(TimeUnit::Nanosecond),
        columns: Some("t,x,y,z,qw,qx,qy,qz"),
        ..preset(
            "euroc",
            "EuRoC: t [ns], x, y, z [m], qw, qx, qy, qz",
            Z_UP,
            M,
        )
    },
];

impl Preset {
    /// The preset with a name.
    pub fn named(name: &str) -> Option<&'static Self> {
        PRESETS.iter().find(|preset| preset.name == name)
    }

    /// Whether axes stay as they are.
    pub(super) fn keeps_axes(&self) -> bool {
        self.axes == Z_UP
    }

    /// A vector in world axes, of one in the vendor's.
    pub fn vector(&self, of: [f64; 3]) -> [f64; 3] {
        self.axes.map(|row| {
            let terms = row.iter().zip(of);
            // A sum with `-0.0` would lose the sign of zero, which is all the same.
            terms.map(|(sign, of)| f64::from(*sign) * of).sum()
        })
    }

    /// The way back: a vector in the vendor's axes, of one in world axes.
    pub fn undone(&self, of: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|column| {
            let terms = self.axes.iter().zip(of);
            terms.map(|(row, of)| f64::from(row[column]) * of).sum()
        })
    }

    /// A quaternion `[x, y, z, w]` in world axes.
    ///
    /// With `M` the axes: where both worlds are right-handed the body keeps its axes, `R' = M R`. Where the
    /// vendor's is left-handed its bodies are as well, and have mirrored axes too, `R' = M R Mᵀ`, of which
    /// the quaternion's vector is `det(M) M v`.
    pub(super) fn quaternion(&self, of: [f64; 4]) -> [f64; 4] {
        let [x, y, z, w] = of;
        if self.keeps_axes() {
            return of;
        }
        if self.is_mirrored() {
            let [x, y, z] = self.vector([x, y, z]);
            return [-x, -y, -z, w];
        }
        let [a, b, c, d] = self.rotation();
        [
            d * x + a * w + b * z - c * y,
            d * y + b * w + c * x - a * z,
            d * z + c * w + a * y - b * x,
            d * w - a * x - b * y - c * z,
        ]
    }

    fn is_mirrored(&self) -> bool {
        let [a, b, c] = self.axes.map(|row| row.map(i32::from));
        let det = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0]);
        det < 0
    }

    /// The quaternion `[x, y, z, w]` of the axes, which are those of a rotation.
    fn rotation(&self) -> [f64; 4] {
        let axes = Matrix3::from_fn(|row, column| f64::from(self.axes[row][column]));
        let turned = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        [turned.i, turned.j, turned.k, turned.w]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Quaternion, Vector3};

    fn rotated([x, y, z, w]: [f64; 4], v: [f64; 3]) -> Vector3<f64> {
        UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)) * Vector3::from(v)
    }

    #[test]
    fn points_of_bodies_come_where_the_axes_say() {
        let q = UnitQuaternion::from_euler_angles(0.3, -0.7, 1.9);
        let q = [q.i, q.j, q.k, q.w];
        for preset in PRESETS {
            let axes = Matrix3::from_fn(|r, c| f64::from(preset.axes[r][c]));
            assert_eq!(
                axes.determinant() < 0.0,
                preset.is_mirrored(),
                "{}",
                preset.name
            );
            let point = [0.1, -0.4, 0.2];
            // A point of a body of a left-handed world has mirrored coordinates in ours.
            let ours = if preset.is_mirrored() {
                preset.vector(point)
            } else {
                point
            };
            // The same formula makes the rotation in either handedness.
            let expected = axes * rotated(q, point);
            let found = rotated(preset.quaternion(q), ours);
            assert!(
                (found - expected).norm() < 1e-12,
                "{}: {found} {expected}",
                preset.name
            );
        }
    }

    #[test]
    fn up_is_up() {
        for (name, up) in [
            ("z-up", [0.0, 0.0, 1.0]),
            ("motive-y-up", [0.0, 1.0, 0.0]),
            ("openvr", [0.0, 1.0, 0.0]),
            ("x-up", [1.0, 0.0, 0.0]),
            ("camera", [0.0, -1.0, 0.0]),
            ("ned", [0.0, 0.0, -1.0]),
            ("unity", [0.0, 1.0, 0.0]),
            ("unreal", [0.0, 0.0, 1.0]),
        ] {
            let preset = Preset::named(name).expect("a preset");
            assert_eq!(preset.vector(up), [0.0, 0.0, 1.0], "{name}");
        }
        assert!(Preset::named("upside-down").is_none());
    }
}
