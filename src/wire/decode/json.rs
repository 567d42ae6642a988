//! Decodes foxglove's messages as JSON: the same fields, stamps as `{"sec", "nsec"}`.

use serde::Deserialize;

use super::error::DecodeError;
use super::message::{FoxglovePose, FramedPose, StampedMark, stamp};
use crate::motion::{Holds, Stamp};
use crate::wire::encode::MARK_EVENT_KEY;

#[derive(Clone, Copy, Deserialize)]
struct JsonTime {
    sec: i64,
    nsec: u32,
}

#[derive(Deserialize)]
struct Xyz {
    x: f64,
    y: f64,
    z: f64,
}

#[derive(Deserialize)]
struct Xyzw {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

#[derive(Deserialize)]
struct JsonPose {
    position: Xyz,
    orientation: Xyzw,
}

#[derive(Deserialize)]
struct PoseInFrame {
    timestamp: Option<JsonTime>,
    #[serde(default)]
    frame_id: String,
    pose: JsonPose,
}

#[derive(Deserialize)]
struct PosesInFrame {
    timestamp: Option<JsonTime>,
    #[serde(default)]
    frame_id: String,
    poses: Vec<JsonPose>,
}

#[derive(Deserialize)]
struct Point3InFrame {
    timestamp: Option<JsonTime>,
    #[serde(default)]
    frame_id: String,
    point: Xyz,
}

#[derive(Deserialize)]
struct Odometry {
    timestamp: Option<JsonTime>,
    #[serde(default)]
    frame_id: String,
    #[serde(default)]
    body_frame_id: String,
    pose: JsonPose,
    #[serde(default)]
    pose_covariance: Vec<f64>,
}

#[derive(Deserialize)]
struct FrameTransform {
    timestamp: Option<JsonTime>,
    #[serde(default)]
    parent_frame_id: String,
    #[serde(default)]
    child_frame_id: String,
    translation: Xyz,
    rotation: Xyzw,
}

#[derive(Deserialize)]
struct FrameTransforms {
    transforms: Vec<FrameTransform>,
}

#[derive(Deserialize)]
struct JsonEvent {
    start_time: Option<JsonTime>,
    #[serde(default)]
    metadata: Vec<JsonPair>,
}

#[derive(Deserialize)]
struct JsonPair {
    key: String,
    value: String,
}

pub(super) fn poses(
    message: FoxglovePose,
    data: &[u8],
    poses: &mut Vec<FramedPose>,
) -> Result<(), DecodeError> {
    match message {
        FoxglovePose::PoseInFrame => {
            let message: PoseInFrame = parsed(data)?;
            let at = time(message.timestamp)?;
            poses.push(framed(message.frame_id, String::new(), at, message.pose));
        }
        FoxglovePose::PosesInFrame => {
            let message: PosesInFrame = parsed(data)?;
            let at = time(message.timestamp)?;
            for (index, pose) in message.poses.into_iter().enumerate() {
                poses.push(framed(
                    message.frame_id.clone(),
                    index.to_string(),
                    at,
                    pose,
                ));
            }
        }
        FoxglovePose::Point3InFrame => {
            let message: Point3InFrame = parsed(data)?;
            let at = time(message.timestamp)?;
            let Xyz { x, y, z } = message.point;
            let position_m = nalgebra::Vector3::new(x, y, z);
            let holds = Holds::Position;
            poses.push(FramedPose::vector(message.frame_id, at, position_m, holds));
        }
        FoxglovePose::Odometry => {
            let message: Odometry = parsed(data)?;
            let at = time(message.timestamp)?;
            let pose = framed(message.frame_id, message.body_frame_id, at, message.pose);
            poses.push(pose.with_covariance(&message.pose_covariance));
        }
        FoxglovePose::FrameTransform => poses.push(transform(parsed(data)?)?),
        FoxglovePose::FrameTransforms => {
            let message: FrameTransforms = parsed(data)?;
            for child in message.transforms {
                poses.push(transform(child)?);
            }
        }
    }
    Ok(())
}

pub(super) fn mark(data: &[u8]) -> Result<StampedMark, DecodeError> {
    let message: JsonEvent = parsed(data)?;
    Ok(StampedMark {
        stamp: time(message.start_time)?,
        event: message
            .metadata
            .into_iter()
            .find(|pair| pair.key == MARK_EVENT_KEY && !pair.value.is_empty())
            .map(|pair| pair.value),
    })
}

fn parsed<'de, T: Deserialize<'de>>(data: &'de [u8]) -> Result<T, DecodeError> {
    serde_json::from_slice(data).map_err(|error| DecodeError::Json(error.to_string()))
}

fn transform(message: FrameTransform) -> Result<FramedPose, DecodeError> {
    let at = time(message.timestamp)?;
    let pose = JsonPose {
        position: message.translation,
        orientation: message.rotation,
    };
    Ok(framed(
        message.parent_frame_id,
        message.child_frame_id,
        at,
        pose,
    ))
}

fn framed(parent: String, child: String, stamp: Option<Stamp>, pose: JsonPose) -> FramedPose {
    let JsonPose {
        position: p,
        orientation: q,
    } = pose;
    let position_m = nalgebra::Vector3::new(p.x, p.y, p.z);
    FramedPose::new(parent, child, stamp, position_m, [q.x, q.y, q.z, q.w])
}

fn time(time: Option<JsonTime>) -> Result<Option<Stamp>, DecodeError> {
    time.map_or(Ok(None), |at| stamp(at.sec, at.nsec))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_as_foxglove_writes_it() {
        let text = br#"{"timestamp": {"sec": 1700000000, "nsec": 5}, "frame_id": "map",
            "pose": {"position": {"x": 1, "y": 2.5, "z": -3},
                     "orientation": {"x": 0, "y": 0, "z": 0.6, "w": 0.8}}}"#;
        let mut found = Vec::new();
        poses(FoxglovePose::PoseInFrame, text, &mut found).expect("decode");
        assert_eq!(
            found,
            [FramedPose::new(
                "map".to_owned(),
                String::new(),
                Some(Stamp(1_700_000_000_000_000_005)),
                nalgebra::Vector3::new(1.0, 2.5, -3.0),
                [0.0, 0.0, 0.6, 0.8],
            )]
        );
    }

    #[test]
    fn arrays_are_numbered_and_transforms_named() {
        let pose = r#"{"position": {"x": 0, "y": 0, "z": 0},
                       "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}"#;
        let transform = r#"{"parent_frame_id": "map", "child_frame_id": "die",
            "translation": {"x": 0, "y": 0, "z": 0},
            "rotation": {"x": 0, "y": 0, "z": 0, "w": 1}}"#;
        let mut found = Vec::new();
        for (message, text) in [
            (
                FoxglovePose::PosesInFrame,
                format!(r#"{{"frame_id": "map", "poses": [{pose}, {pose}]}}"#),
            ),
            (FoxglovePose::FrameTransform, transform.to_owned()),
            (
                FoxglovePose::FrameTransforms,
                format!(r#"{{"transforms": [{transform}]}}"#),
            ),
        ] {
            poses(message, text.as_bytes(), &mut found).expect("decode");
        }
        let children: Vec<_> = found.iter().map(|pose| pose.child.as_str()).collect();
        assert_eq!(children, ["0", "1", "die", "die"]);
        assert!(
            found
                .iter()
                .all(|pose| pose.parent == "map" && pose.stamp.is_none())
        );
    }

    #[test]
    fn marks_need_no_end_and_no_metadata() {
        let bare = mark(br#"{"start_time": {"sec": 2, "nsec": 0}}"#).expect("decode");
        assert_eq!((bare.stamp, bare.event), (Some(Stamp(2_000_000_000)), None));
        let named =
            mark(br#"{"start_time": null, "metadata": [{"key": "event", "value": "end"}]}"#)
                .expect("decode");
        assert_eq!((named.stamp, named.event.as_deref()), (None, Some("end")));
    }

    #[test]
    fn what_is_missing_or_out_of_range_is_named() {
        let mut found = Vec::new();
        let error = poses(FoxglovePose::PoseInFrame, b"{}", &mut found).expect_err("no pose");
        assert!(
            error.to_string().contains("missing field `pose`"),
            "{error}"
        );
        let error = mark(br#"{"start_time": {"sec": 9223372036854775807, "nsec": 0}}"#);
        assert_eq!(error, Err(DecodeError::Stamp(i64::MAX)));
    }
}
