//! Vectors and poses of rapier, to and fro.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rapier3d::math::{Pose as RapierPose, Rotation as RapierRotation, Vector as RapierVector};
use rapier3d::prelude::RigidBody;

use crate::math::Pose;

pub(super) fn to_rapier(v: &Vector3<f64>) -> RapierVector {
    RapierVector::new(v.x, v.y, v.z)
}

pub(super) fn from_rapier(v: RapierVector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

pub(super) fn to_rapier_pose(pose: &Pose) -> RapierPose {
    let q = pose.rotation.coords;
    RapierPose::from_parts(
        to_rapier(&pose.translation.vector),
        RapierRotation::from_xyzw(q.x, q.y, q.z, q.w),
    )
}

pub(super) fn pose_of(body: &RigidBody) -> Pose {
    let (position, q) = (body.translation(), body.rotation());
    Pose::from_parts(
        from_rapier(position).into(),
        UnitQuaternion::new_normalize(Quaternion::new(q.w, q.x, q.y, q.z)),
    )
}
