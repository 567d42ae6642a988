//! Frames in which poses are given: how those that stand still lie in others, and which are a camera's.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::motion::{Covariance, Holds, PoseSample};
use crate::wire::FramedPose;

/// Number of frames of which it is known how they lie: every message may name another.
const FRAMES_KEPT: usize = 1000;

/// Greatest deviation of a norm from 1 for a transform to be used.
const NORM_LIMIT: f64 = 0.1;

/// How a frame lies in another.
#[derive(Clone, Debug, PartialEq)]
struct Relation {
    parent: String,
    position_m: Vector3<f64>,
    quaternion_xyzw: [f64; 4],
    /// Whether every message says the same.
    is_fixed: bool,
}

/// How frames lie in others, by the messages that say so.
#[derive(Clone, Debug, Default)]
pub(super) struct Frames {
    known: BTreeMap<String, Relation>,
}

/// A frame as seen from the one in which it stands, over others that stand still.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rooted {
    /// The last frame that stands still in no other.
    pub(super) root: String,
    /// Where the frame is in it; `None` where both are one.
    pub(super) root_from_frame: Option<Isometry3<f64>>,
    /// In what that last one moves, if it does.
    pub(super) moves_in: Option<String>,
}

/// The name of a frame: ROS 1 wrote some with a slash before them.
pub(super) fn frame_name(name: &str) -> &str {
    name.strip_prefix('/').unwrap_or(name)
}

impl Frames {
    /// Notes where a message says that a frame is.
    pub(super) fn note(&mut self, pose: &FramedPose) {
        let (child, parent) = (frame_name(&pose.child), frame_name(&pose.parent));
        if child.is_empty() || child == parent {
            return;
        }
        let has_place = self.known.len() < FRAMES_KEPT;
        match self.known.get_mut(child) {
            Some(known) => {
                known.is_fixed &= known.parent == parent
                    && known.position_m == pose.position_m
                    && known.quaternion_xyzw == pose.quaternion_xyzw;
            }
            None if has_place => {
                let relation = Relation {
                    parent: parent.to_owned(),
                    position_m: pose.position_m,
                    quaternion_xyzw: pose.quaternion_xyzw,
                    is_fixed: true,
                };
                self.known.insert(child.to_owned(), relation);
            }
            None => {}
        }
    }

    /// The frame from which another is seen, over as many as stand still.
    pub(super) fn rooted(&self, frame: &str) -> Rooted {
        let mut root = frame_name(frame);
        let mut root_from_frame = Isometry3::identity();
        let mut passed = BTreeSet::from([root]);
        while let Some(relation) = self.known.get(root)
            && relation.is_fixed
            && !passed.contains(relation.parent.as_str())
            && let Some(parent_from_child) = relation.pose()
        {
            root = &relation.parent;
            root_from_frame = parent_from_child * root_from_frame;
            passed.insert(root);
        }
        let above = self.known.get(root).filter(|of| !of.is_fixed);
        Rooted {
            root: root.to_owned(),
            root_from_frame: (passed.len() > 1).then_some(root_from_frame),
            moves_in: above.map(|of| of.parent.clone()),
        }
    }
}

impl Relation {
    /// `None` where its numbers are no pose.
    fn pose(&self) -> Option<Isometry3<f64>> {
        let [x, y, z, w] = self.quaternion_xyzw;
        let turn = Quaternion::new(w, x, y, z);
        let is_pose = self.position_m.iter().all(|of| of.is_finite())
            && (turn.norm() - 1.0).abs() <= NORM_LIMIT;
        is_pose.then(|| {
            Isometry3::from_parts(
                Translation3::from(self.position_m),
                UnitQuaternion::from_quaternion(turn),
            )
        })
    }
}

/// A reading in the frame in which its own stands. A quaternion keeps its norm.
pub(super) fn seen_from(root_from_frame: &Isometry3<f64>, sample: PoseSample) -> PoseSample {
    let rotation = root_from_frame.rotation;
    let position_m = match sample.holds {
        Holds::Pose | Holds::Position => {
            rotation * sample.position_m + root_from_frame.translation.vector
        }
        Holds::Direction => rotation * sample.position_m,
        Holds::Orientation => sample.position_m,
    };
    let [x, y, z, w] = sample.quaternion_xyzw;
    let turned = match sample.holds {
        Holds::Pose | Holds::Orientation => rotation.into_inner() * Quaternion::new(w, x, y, z),
        Holds::Position | Holds::Direction => Quaternion::new(w, x, y, z),
    };
    PoseSample {
        position_m,
        quaternion_xyzw: [turned.i, turned.j, turned.k, turned.w],
        covariance: sample
            .covariance
            .map(|of| turned_covariance(&rotation, &of)),
        ..sample
    }
}

/// Both blocks are in the axes of the frame.
fn turned_covariance(rotation: &UnitQuaternion<f64>, covariance: &Covariance) -> Covariance {
    let turn = rotation.to_rotation_matrix();
    let mut both = nalgebra::Matrix6::zeros();
    for at in [0, 3] {
        both.fixed_view_mut::<3, 3>(at, at).copy_from(turn.matrix());
    }
    let turned = both * covariance.matrix() * both.transpose();
    let rows: [f64; 36] = std::array::from_fn(|at| turned[(at / 6, at % 6)]);
    Covariance::of_rows(&rows)
}

/// Whether a frame is that of a camera's picture by its name, in which z looks ahead.
pub(super) fn is_optical(frame: &str) -> bool {
    frame.to_ascii_lowercase().contains("optical")
}

/// Whether a frame may be a camera's by its name.
pub(super) fn may_be_camera(frame: &str) -> bool {
    let lower = frame.to_ascii_lowercase();
    // What is linked to a camera's housing has z up.
    !lower.ends_with("_link")
        && lower.split(['_', '/', '-', ' ']).any(|part| {
            part.trim_end_matches(|c: char| c.is_ascii_digit()) == "cam"
                || part.starts_with("camera")
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Stamp;

    fn pose(parent: &str, child: &str, position_m: [f64; 3], xyzw: [f64; 4]) -> FramedPose {
        FramedPose {
            parent: parent.to_owned(),
            child: child.to_owned(),
            stamp: None,
            position_m: position_m.into(),
            quaternion_xyzw: xyzw,
            holds: Holds::Pose,
            covariance: None,
        }
    }

    /// A quarter turn about z.
    const QUARTER: [f64; 4] = [
        0.0,
        0.0,
        std::f64::consts::FRAC_1_SQRT_2,
        std::f64::consts::FRAC_1_SQRT_2,
    ];
    const NONE: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

    #[test]
    fn chains_that_stand_still_are_one_transform_and_others_end_it() {
        let mut frames = Frames::default();
        frames.note(&pose("/world", "room", [1.0, 0.0, 0.0], QUARTER));
        frames.note(&pose("room", "table", [0.0, 2.0, 0.5], NONE));
        frames.note(&pose("map", "world", [0.0; 3], NONE));
        frames.note(&pose("map", "world", [0.1, 0.0, 0.0], NONE));
        let rooted = frames.rooted("table");
        assert_eq!(rooted.root, "world");
        assert_eq!(rooted.moves_in.as_deref(), Some("map"));
        let given = PoseSample::new(Stamp(0), Vector3::new(0.3, 0.0, 0.0), NONE);
        let seen = seen_from(&rooted.root_from_frame.expect("another frame"), given);
        // By hand: (0.3, 2, 0.5) in the room, a quarter turn, and 1 along x.
        assert!((seen.position_m - Vector3::new(-1.0, 0.3, 0.5)).norm() < 1e-12);
        for (found, expected) in seen.quaternion_xyzw.iter().zip(QUARTER) {
            assert!((found - expected).abs() < 1e-12);
        }
        let alone = frames.rooted("elsewhere");
        assert_eq!(
            (alone.root.as_str(), alone.root_from_frame),
            ("elsewhere", None)
        );
    }

    #[test]
    fn circles_and_broken_transforms_end() {
        let mut frames = Frames::default();
        frames.note(&pose("a", "b", [0.0; 3], NONE));
        frames.note(&pose("b", "a", [0.0; 3], NONE));
        frames.note(&pose("a", "a", [0.0; 3], NONE));
        frames.note(&pose("a", "c", [f64::NAN, 0.0, 0.0], NONE));
        frames.note(&pose("a", "d", [0.0; 3], [0.0; 4]));
        assert_eq!(frames.rooted("a").root, "b");
        assert_eq!(frames.rooted("c").root, "c");
        assert_eq!(frames.rooted("d").root, "d");
    }

    #[test]
    fn covariances_turn_with_what_they_are_of() {
        let mut rows = [0.0; 36];
        for (at, variance) in [1.0, 4.0, 9.0, 16.0, 25.0, 36.0].into_iter().enumerate() {
            rows[7 * at] = variance;
        }
        let given = PoseSample {
            covariance: Some(Covariance::of_rows(&rows)),
            ..PoseSample::new(Stamp(0), Vector3::zeros(), NONE)
        };
        let [x, y, z, w] = QUARTER;
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let seen = seen_from(&Isometry3::from_parts(Vector3::zeros().into(), turn), given);
        let matrix = seen.covariance.expect("a covariance").matrix();
        for (at, variance) in [4.0, 1.0, 9.0, 25.0, 16.0, 36.0].into_iter().enumerate() {
            assert!((matrix[(at, at)] - variance).abs() < 1e-5, "{matrix}");
        }
    }

    #[test]
    fn cameras_are_told_by_name() {
        assert!(is_optical("camera_color_optical_frame"));
        for camera in ["camera", "cam0", "left_camera", "usb_cam", "head_camera"] {
            assert!(may_be_camera(camera) && !is_optical(camera), "{camera}");
        }
        for other in ["world", "map", "campus", "camera_link", "lab"] {
            assert!(!may_be_camera(other), "{other}");
        }
    }
}
