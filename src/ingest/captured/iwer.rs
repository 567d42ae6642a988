//! Recordings of WebXR sessions by iwer: a schema of input sources, and rows of numbers.
//!
//! A row is a time, the viewer's position and quaternion, and of each source that was there its number, its ray, and as
//! its schema says its grip, its hand and its gamepad.

use serde_json::Value;

use super::{CapturedPose, CapturedSession};

/// Numbers of a row before its sources, and of a pose.
const VIEWER: usize = 8;
const POSE: usize = 7;

/// The first buttons of a controller: WebXR's `xr-standard` mapping.
const BUTTONS: [&str; 4] = ["trigger", "grip", "touchpad", "thumbstick"];

/// What a source has, and what was seen of it.
#[derive(Debug, Default)]
struct InputSource {
    name: String,
    has_grip: bool,
    has_hand: bool,
    has_gamepad: bool,
    /// How many buttons that has, of which some may be missing.
    buttons: usize,
    poses: Vec<CapturedPose>,
    /// Whether each of its buttons is down.
    are_pressed: Vec<bool>,
}

/// The session; `None` where the JSON is none.
pub(super) fn session(value: &Value) -> Option<Result<CapturedSession, String>> {
    let (schema, frames) = (value.get("schema")?, value.get("frames")?.as_array()?);
    let schema = schema.as_array()?;
    Some(read(schema, frames))
}

fn read(schema: &[Value], frames: &[Value]) -> Result<CapturedSession, String> {
    let mut sources: Vec<(u64, InputSource)> = Vec::new();
    for (index, entry) in schema.iter().enumerate() {
        let number = entry.get(0).and_then(Value::as_u64);
        let number =
            number.ok_or_else(|| format!("schema[{index}]: expected a number and a source"))?;
        sources.push((number, source(number, &entry[1])));
    }
    let mut session = CapturedSession::new("a WebXR session, recorded by iwer");
    let mut viewer = Vec::new();
    for (index, frame) in frames.iter().enumerate() {
        let row = frame.as_array().map_or(&[][..], Vec::as_slice);
        let no_row = || {
            format!(
                "frames[{index}]: expected a time, seven numbers of the viewer, and the sources"
            )
        };
        let [time_ms, at @ ..] = numbers::<VIEWER>(row).ok_or_else(no_row)?;
        viewer.push(pose(time_ms, at));
        for input in &row[VIEWER..] {
            let input = input.as_array().map_or(&[][..], Vec::as_slice);
            let number = input.first().and_then(Value::as_u64);
            let known = sources.iter_mut().find(|(of, _)| Some(*of) == number);
            let (_, source) =
                known.ok_or_else(|| format!("frames[{index}]: a source that the schema lacks"))?;
            let presses = source.take(time_ms, &input[1..]).ok_or_else(|| {
                format!("frames[{index}]: expected seven numbers of the ray of {}, and what its schema says", source.name)
            })?;
            for button in presses {
                session.press(time_ms, button_name(button));
            }
        }
    }
    session.add("head", &viewer);
    for (_, source) in &sources {
        session.add(&source.name, &source.poses);
    }
    Ok(session.sort())
}

fn source(number: u64, of: &Value) -> InputSource {
    let has = |name: &str| of.get(name).and_then(Value::as_bool) == Some(true);
    let hand = of.get("handedness").and_then(Value::as_str);
    InputSource {
        name: match hand {
            Some(hand) if hand != "none" => hand.to_owned(),
            _ => format!("source {number}"),
        },
        has_grip: has("hasGrip"),
        has_hand: has("hasHand"),
        has_gamepad: has("hasGamepad"),
        buttons: of.get("numButtons").and_then(Value::as_u64).unwrap_or(0) as usize,
        ..InputSource::default()
    }
}

impl InputSource {
    /// Takes in what a row says of it; which buttons went down. `None` where it is not what its schema says.
    fn take(&mut self, time_ms: f64, of: &[Value]) -> Option<Vec<usize>> {
        let mut rest = of.get(POSE..)?.iter();
        let mut at = numbers::<POSE>(of)?;
        if self.has_grip {
            at = numbers(rest.next()?.as_array()?)?;
        }
        if self.has_hand {
            rest.next()?;
        }
        self.poses.push(pose(time_ms, at));
        let mut presses = Vec::new();
        if self.has_gamepad {
            // Of a button: whether it is pressed, whether it is touched, and how far it is down. Axes are plain numbers.
            let gamepad = rest.next()?.as_array().map_or(&[][..], Vec::as_slice);
            let buttons = gamepad.iter().take(self.buttons);
            let is_down = |button: &Value| button.get(0).and_then(Value::as_f64) == Some(1.0);
            let are_pressed: Vec<bool> = buttons.map(is_down).collect();
            let was_down = |at: usize| self.are_pressed.get(at).copied().unwrap_or(false);
            presses = (0..are_pressed.len())
                .filter(|at| are_pressed[*at] && !was_down(*at))
                .collect();
            self.are_pressed = are_pressed;
        }
        Some(presses)
    }
}

/// A button of a gamepad by its number, as WebXR maps them.
fn button_name(number: usize) -> String {
    let known = BUTTONS.get(number);
    known.map_or_else(|| format!("button {number}"), |name| (*name).to_owned())
}

fn pose(time_ms: f64, [x, y, z, a, b, c, d]: [f64; POSE]) -> CapturedPose {
    CapturedPose {
        time_ms,
        position_m: [x, y, z],
        quaternion_xyzw: [a, b, c, d],
    }
}

/// The first numbers of a list; `None` where there are not so many.
fn numbers<const N: usize>(of: &[Value]) -> Option<[f64; N]> {
    let mut numbers = [0.0; N];
    for (number, value) in numbers.iter_mut().zip(of.get(..N)?) {
        *number = value.as_f64()?;
    }
    Some(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grips_are_rows_and_the_trigger_marks_once_it_goes_down() {
        let frame = |time: i32, pressed: u8| {
            format!(
                "[{time},0,1.6,0,0,0,0,1,[0,9,9,9,0,0,0,1,[0.1,0.2,0.3,0,0,0,1],[[{pressed},0,1],[0,0,0],0,0]]]"
            )
        };
        let frames = [
            frame(0, 0),
            frame(11, 1),
            frame(22, 1),
            frame(33, 0),
            frame(44, 1),
        ]
        .join(",");
        let text = format!(
            r#"{{"schema":[[0,{{"handedness":"left","hasGrip":true,"hasHand":false,"hasGamepad":true,"numButtons":2,"numAxes":2}}]],"frames":[{frames}]}}"#
        );
        let session = CapturedSession::of_json(&text)
            .expect("JSON")
            .expect("a session");
        assert!(session.table.contains("\n0,head,0,1.6,0,0,0,0,1\n"));
        assert!(session.table.contains("\n44,left,0.1,0.2,0.3,0,0,0,1\n"));
        assert_eq!(session.table.lines().count(), 11);
        assert_eq!(session.clone().presses_of(&[]), Ok(vec![11.0, 44.0]));
        let none = session.clone().presses_of(&["grip"]);
        assert!(none.expect_err("none").contains("expected one of trigger"));
        for (from, to, place) in [
            ("[11,0,", "[0,", "frames[1]"),
            (
                "[0,9,9,9,0,0,0,1",
                "[7,9,9,9,0,0,0,1",
                "frames[0]: a source",
            ),
            ("[0.1,0.2", "[0.2", "frames[0]: expected seven"),
            ("[[0,{", "[[{", "schema[0]"),
        ] {
            let why = CapturedSession::of_json(&text.replacen(from, to, 1)).expect_err("wrong");
            assert!(why.starts_with(place), "{why}");
        }
    }
}
