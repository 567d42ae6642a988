//! `enact.Keyframe`: one row of a written sketch as a message, JSON with this schema.
//!
//! A message says of a body, not of a tracker, what is known of it at one instant. Its topic is that
//! of the body's track; in an edited sketch with `/1`, `/2`, … after it, flight by flight.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::decode::DecodeError;
use crate::motion::{Keyframe, KeyframeTime, Stamp};

/// Name of the schema.
pub const KEYFRAME_SCHEMA: &str = "enact.Keyframe";

/// The schema, `jsonschema`.
pub(super) const SCHEMA: &str = r#"{
 "title": "enact.Keyframe",
 "description": "What of a body is known at one instant. Its time is stamp_ns, or between earliest_ns and latest_ns, or unknown where all are null.",
 "type": "object",
 "properties": {
  "stamp_ns": { "type": ["integer", "null"], "description": "Time [ns]." },
  "earliest_ns": { "type": ["integer", "null"], "description": "Earliest time [ns]." },
  "latest_ns": { "type": ["integer", "null"], "description": "Latest time [ns]." },
  "position_m": { "type": ["array", "null"], "items": { "type": "number" }, "description": "Centre of mass [m, world]." },
  "orientation_wxyz": { "type": ["array", "null"], "items": { "type": "number" }, "description": "World from body, unit quaternion." },
  "position_sd_m": { "type": ["number", "null"], "description": "Standard deviation of the position per axis [m]." },
  "orientation_sd_deg": { "type": ["number", "null"], "description": "Standard deviation of the orientation per axis [deg]." }
 },
 "additionalProperties": false
}
"#;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyframeMessage {
    stamp_ns: Option<i64>,
    earliest_ns: Option<i64>,
    latest_ns: Option<i64>,
    position_m: Option<[f64; 3]>,
    orientation_wxyz: Option<[f64; 4]>,
    position_sd_m: Option<f64>,
    orientation_sd_deg: Option<f64>,
}

/// A keyframe as a message.
pub fn encode_keyframe(keyframe: &Keyframe) -> Vec<u8> {
    let (known, earliest, latest) = match keyframe.time {
        KeyframeTime::Known(stamp) => (Some(stamp.0), None, None),
        KeyframeTime::Within(earliest, latest) => (None, Some(earliest.0), Some(latest.0)),
        KeyframeTime::Unknown => (None, None, None),
    };
    let message = KeyframeMessage {
        stamp_ns: known,
        earliest_ns: earliest,
        latest_ns: latest,
        position_m: keyframe.position_m.map(Into::into),
        orientation_wxyz: keyframe.orientation_wxyz,
        position_sd_m: keyframe.position_sd_m,
        orientation_sd_deg: keyframe.orientation_sd_deg,
    };
    // Numbers and nothing else: it always has a text.
    serde_json::to_vec(&message).unwrap_or_default()
}

/// The keyframe of a message.
pub fn decode_keyframe(data: &[u8]) -> Result<Keyframe, DecodeError> {
    let message: KeyframeMessage =
        serde_json::from_slice(data).map_err(|error| DecodeError::Json(error.to_string()))?;
    let time = match (message.stamp_ns, message.earliest_ns, message.latest_ns) {
        (Some(stamp), None, None) => KeyframeTime::Known(Stamp(stamp)),
        (None, Some(earliest), Some(latest)) if earliest <= latest => {
            KeyframeTime::Within(Stamp(earliest), Stamp(latest))
        }
        (None, None, None) => KeyframeTime::Unknown,
        _ => {
            let what = "expected stamp_ns, or earliest_ns and latest_ns in order, or none";
            return Err(DecodeError::Json(what.to_owned()));
        }
    };
    if message.position_m.is_none() && message.orientation_wxyz.is_none() {
        return Err(DecodeError::Missing("position_m or orientation_wxyz"));
    }
    Ok(Keyframe {
        time,
        position_m: message.position_m.map(Vector3::from),
        orientation_wxyz: message.orientation_wxyz,
        position_sd_m: message.position_sd_m,
        orientation_sd_deg: message.orientation_sd_deg,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keyframe(time: KeyframeTime) -> Keyframe {
        Keyframe {
            time,
            position_m: Some(Vector3::new(0.1, -0.2, 1.0 / 3.0)),
            orientation_wxyz: Some([0.5, 0.5, -0.5, 0.5]),
            position_sd_m: Some(1e-3),
            orientation_sd_deg: None,
        }
    }

    #[test]
    fn a_keyframe_comes_back_bit_for_bit() {
        let within = KeyframeTime::Within(Stamp(1), Stamp(3));
        for time in [KeyframeTime::Known(Stamp(7)), within, KeyframeTime::Unknown] {
            for part in 0..3 {
                let mut keyframe = keyframe(time);
                if part == 1 {
                    keyframe.position_m = None;
                } else if part == 2 {
                    keyframe.orientation_wxyz = None;
                }
                let back = decode_keyframe(&encode_keyframe(&keyframe)).expect("ours");
                assert_eq!(back, keyframe);
            }
        }
    }

    #[test]
    fn what_is_no_keyframe_is_refused() {
        for text in [
            "",
            "{}",
            "{\"stamp_ns\": 1}",
            "{\"stamp_ns\": 1, \"earliest_ns\": 0, \"latest_ns\": 2, \"position_m\": [0, 0, 0]}",
            "{\"earliest_ns\": 5, \"latest_ns\": 2, \"position_m\": [0, 0, 0]}",
            "{\"stamp_ns\": 1, \"position_m\": [0, 0]}",
            "{\"stamp_ns\": 1, \"position_m\": [0, 0, 0], \"place\": 1}",
        ] {
            assert!(decode_keyframe(text.as_bytes()).is_err(), "{text}");
        }
    }
}
