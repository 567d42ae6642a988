//! A-Frame's motion capture: an object of entities, each with `poses` and `events`, or of one without a name.

use serde_json::Value;

use super::{CapturedPose, CapturedSession, number};

/// A controller's buttons by their numbers, as A-Frame tells them of controllers of two hands.
const BUTTONS: [&str; 5] = ["trackpad", "trigger", "grip", "menu", "system"];

/// The session; `None` where the JSON is none.
pub(super) fn session(value: &Value) -> Option<Result<CapturedSession, String>> {
    let has_poses = |of: &Value| {
        let poses = of.get("poses").and_then(Value::as_array);
        poses.is_some_and(|poses| poses.iter().all(|pose| pose.get("timestamp").is_some()))
    };
    let entities: Vec<(&str, &Value)> = match value {
        Value::Object(_) if has_poses(value) => vec![("controller", value)],
        Value::Object(all) => {
            let named = all.iter().filter(|(_, of)| has_poses(of));
            named.map(|(name, of)| (name.as_str(), of)).collect()
        }
        _ => return None,
    };
    (!entities.is_empty()).then(|| read(&entities))
}

fn read(entities: &[(&str, &Value)]) -> Result<CapturedSession, String> {
    let mut session = CapturedSession::new("A-Frame's motion capture");
    session
        .notes
        .push("angles are those of A-Frame: degrees, about y, then x, then z".to_owned());
    for (name, entity) in entities {
        let poses = entity["poses"].as_array().map_or(&[][..], Vec::as_slice);
        let mut read = Vec::new();
        for (index, pose) in poses.iter().enumerate() {
            let pose = pose_of(pose).ok_or_else(|| {
                format!(
                    "{name}.poses[{index}]: expected \"timestamp\", and \"position\" and \"rotation\" with x, y and z"
                )
            })?;
            read.push(pose);
        }
        session.add(name, &read);
        let events = entity.get("events").and_then(Value::as_array);
        for event in events.into_iter().flatten() {
            if let (Some(time_ms), Some(button)) = (number(event, "timestamp"), pressed(event)) {
                session.press(time_ms, button);
            }
        }
    }
    Ok(session.sort())
}

fn pose_of(of: &Value) -> Option<CapturedPose> {
    let three = |name: &str| -> Option<[f64; 3]> {
        let of = of.get(name)?;
        Some([number(of, "x")?, number(of, "y")?, number(of, "z")?])
    };
    Some(CapturedPose {
        time_ms: number(of, "timestamp")?,
        position_m: three("position")?,
        quaternion_xyzw: quaternion_xyzw(three("rotation")?),
    })
}

/// The button that goes down: `triggerdown` says its name, `buttondown` its number.
fn pressed(event: &Value) -> Option<String> {
    let name = event.get("name")?.as_str()?.strip_suffix("down")?;
    if name != "button" {
        return Some(name.to_owned());
    }
    let number = number(event.get("detail")?, "id")?;
    let known = BUTTONS.get(number as usize).filter(|_| number >= 0.0);
    Some(known.map_or_else(|| format!("button {number}"), |name| (*name).to_owned()))
}

/// The turn `Ry·Rx·Rz` by angles in degrees about x, y and z.
fn quaternion_xyzw(angles_deg: [f64; 3]) -> [f64; 4] {
    let halves = angles_deg.map(|angle_deg| 0.5 * angle_deg.to_radians());
    let [[sx, cx], [sy, cy], [sz, cz]] = halves.map(|half| [half.sin(), half.cos()]);
    [
        cy * sx * cz + sy * cx * sz,
        sy * cx * cz - cy * sx * sz,
        cy * cx * sz - sy * sx * cz,
        cy * cx * cz + sy * sx * sz,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_of_entities_are_rows_and_triggers_are_marks() {
        let text = r#"{"camera":{"poses":[],"events":[]},
            "right":{"poses":[{"position":{"x":1,"y":2,"z":3},"rotation":{"x":0,"y":90,"z":0},"timestamp":10.5}],
            "events":[{"name":"buttondown","detail":{"id":1},"timestamp":12},{"name":"buttondown","detail":{"id":2},"timestamp":13},
            {"name":"buttonup","detail":{"id":1},"timestamp":14},{"name":"triggerdown","timestamp":11}],"gamepad":{}}}"#;
        let session = CapturedSession::of_json(text)
            .expect("JSON")
            .expect("a session");
        let rows: Vec<&str> = session.table.lines().skip(1).collect();
        assert_eq!(rows.len(), 1);
        assert!(
            rows[0].starts_with("10.5,right,1,2,3,0,0.707"),
            "{}",
            rows[0]
        );
        let of = |names: &[&str]| session.clone().presses_of(names);
        assert_eq!(of(&[]), Ok(vec![11.0, 12.0]));
        assert_eq!(of(&["grip"]), Ok(vec![13.0]));
        assert_eq!(of(&["Grip", "trigger"]), Ok(vec![11.0, 12.0, 13.0]));
        let why = of(&["menu"]).expect_err("none");
        assert!(why.contains("expected one of grip, trigger"), "{why}");
        // One entity alone has no name.
        let alone = r#"{"poses":[{"position":{"x":1,"y":2,"z":3},"rotation":{"x":0,"y":0,"z":0},"timestamp":1}]}"#;
        let session = CapturedSession::of_json(alone)
            .expect("JSON")
            .expect("a session");
        assert!(session.table.contains("1,controller,1,2,3,0,0,0,1"));
        let wrong = alone.replace("\"y\":2,", "");
        let why = CapturedSession::of_json(&wrong).expect_err("no y");
        assert!(why.contains("controller.poses[0]"), "{why}");
    }

    #[test]
    fn the_turn_is_about_y_then_x_then_z() {
        // Column by column the product of the three turns, of which each turns one basis vector into another.
        for (angles_deg, turned, expected) in [
            ([90.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]),
            ([0.0, 90.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]),
            ([0.0, 0.0, 90.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
            // x to y by z, y to z by x, z to x by y.
            ([90.0, 90.0, 90.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
            ([90.0, 0.0, 90.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        ] {
            let [x, y, z, w] = quaternion_xyzw(angles_deg);
            let turn =
                nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
            let found = turn * nalgebra::Vector3::from(turned);
            let off = (found - nalgebra::Vector3::from(expected)).norm();
            assert!(off < 1e-12, "{angles_deg:?}: {found}");
        }
    }
}
