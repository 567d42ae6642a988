//! Sessions that pages in browsers captured, as JSON: A-Frame's motion capture, and recordings of WebXR by iwer.
//!
//! Both are y up, in metres and milliseconds. Their poses are written as a table, which is read as any other; a trigger
//! that is pressed is a mark.

mod aframe;
mod iwer;

use std::fmt::Write;

use serde_json::Value;

/// A session.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CapturedSession {
    /// What wrote it, in words.
    pub kind: String,
    /// A table of its poses: `time_ms`, `body`, `x` … `qw`.
    pub table: String,
    /// When a trigger was pressed \[ms\], on the clock of the table.
    pub presses_ms: Vec<f64>,
    /// What was read how, and what is left aside.
    pub notes: Vec<String>,
}

/// A pose of a session.
#[derive(Clone, Copy, Debug, PartialEq)]
struct CapturedPose {
    time_ms: f64,
    position_m: [f64; 3],
    quaternion_xyzw: [f64; 4],
}

/// The columns of the table.
const HEAD: &str = "time_ms,body,x,y,z,qx,qy,qz,qw\n";

impl CapturedSession {
    /// The session in a JSON text; `None` of another JSON. Fails, in words, where it is one and cannot be read.
    pub fn of_json(text: &str) -> Result<Option<Self>, String> {
        let value: Value =
            serde_json::from_str(text).map_err(|error| format!("is no whole JSON: {error}"))?;
        if let Some(session) = iwer::session(&value) {
            return session.map(Some);
        }
        aframe::session(&value).transpose()
    }

    fn new(kind: &str) -> Self {
        Self {
            kind: kind.to_owned(),
            table: HEAD.to_owned(),
            ..Self::default()
        }
    }

    /// Adds a body; of one without poses nothing is known.
    fn add(&mut self, name: &str, poses: &[CapturedPose]) {
        // A name is one cell.
        let name: String = name
            .chars()
            .map(|c| match c {
                ',' | '"' | '\n' | '\r' | ';' | '\t' => '_',
                c => c,
            })
            .collect();
        for pose in poses {
            let _ = write!(self.table, "{},{name}", pose.time_ms);
            for number in pose.position_m.iter().chain(&pose.quaternion_xyzw) {
                let _ = write!(self.table, ",{number}");
            }
            self.table.push('\n');
        }
    }

    /// The presses in order, and a note of them.
    fn sort(mut self) -> Self {
        self.presses_ms.sort_by(f64::total_cmp);
        let count = self.presses_ms.len();
        if count > 0 {
            self.notes
                .push(format!("a trigger was pressed {count} times: a mark each"));
        }
        self
    }
}

/// A number of an object.
fn number(of: &Value, name: &str) -> Option<f64> {
    of.get(name)?.as_f64()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn other_json_is_none_and_broken_json_is_said() {
        for other in [
            "{}",
            "[]",
            "3",
            r#"{"a": 1}"#,
            r#"{"poses": 3}"#,
            r#"[{"t": 1}]"#,
        ] {
            assert_eq!(CapturedSession::of_json(other), Ok(None), "{other}");
        }
        let broken = CapturedSession::of_json(r#"{"camera": {"poses": ["#);
        assert!(broken.expect_err("broken").contains("line 1"));
    }

    #[test]
    fn a_name_stays_one_cell() {
        let mut session = CapturedSession::new("x");
        let pose = CapturedPose {
            time_ms: 1.0,
            position_m: [0.0; 3],
            quaternion_xyzw: [0.0, 0.0, 0.0, 1.0],
        };
        session.add("a,b\"c\nd", &[pose]);
        assert_eq!(session.table, format!("{HEAD}1,a_b_c_d,0,0,0,0,0,0,1\n"));
    }

    proptest! {
        /// Whatever a JSON says, it is a session, none, or refused.
        #[test]
        fn any_session_is_answered(text in "\\{\"(schema|camera|poses|frames)\":[\\[\\]{}\"a-z0-9:,. ]{0,60}\\}") {
            let _ = CapturedSession::of_json(&text);
        }
    }
}
