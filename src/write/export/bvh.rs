//! The motion as a Biovision hierarchy, which animation programs read as a skeleton: a joint per body below one root
//! that stays where it is, each with a place and three angles of its own.
//!
//! It is y-up and in metres. Angles are those of `R = R_x R_y R_z` in degrees, each the nearest to that of the frame before.
//! The format has frames alone, no times: an impact between two of them is cut off.

use std::collections::BTreeSet;
use std::fmt::Write;

use nalgebra::{Point3, Quaternion, UnitQuaternion, Vector3};

use super::frames::ExportedBody;
use super::names::numbered;
use crate::math::euler::xyz_near;
use crate::motion::{PoseSample, Scene, Stamp};
use crate::physics::Body;

/// What every joint moves by.
const CHANNELS: &str = "CHANNELS 6 Xposition Yposition Zposition Xrotation Yrotation Zrotation";

/// The file. Frames are those of the grid from the first on which a body has a pose to the last; before and after its own
/// a body stays.
pub fn bvh(scene: &Scene, bodies: &[ExportedBody], zero: Stamp, frame_rate_hz: f64) -> String {
    let columns: Vec<Vec<(i64, &PoseSample)>> = bodies
        .iter()
        .map(|body| on_frames(body, zero, frame_rate_hz))
        .collect();
    let all = || columns.iter().flatten().map(|(frame, _)| *frame);
    let (first, last) = (all().min().unwrap_or(0), all().max().unwrap_or(-1));
    let mut text = format!("HIERARCHY\nROOT world\n{{\n  OFFSET 0 0 0\n  {CHANNELS}\n");
    let mut taken = BTreeSet::from(["world".to_owned()]);
    for body in bodies {
        let link = &scene.links[body.link];
        let name = free_name(&link.name, &mut taken);
        let tip_m = longest_axis(&link.body) * link.radius_m();
        let tip_m = link.link_from_given.inverse() * Point3::from(tip_m);
        let [x, y, z] = [tip_m.x, tip_m.y, tip_m.z];
        let _ = writeln!(
            text,
            "  JOINT {name}\n  {{\n    OFFSET 0 0 0\n    {CHANNELS}\n    End Site\n    {{\n      \
             OFFSET {x} {y} {z}\n    }}\n  }}"
        );
    }
    let count = last - first + 1;
    let _ = writeln!(
        text,
        "}}\nMOTION\nFrames: {count}\nFrame Time: {}",
        frame_rate_hz.recip()
    );
    let mut angles_rad = vec![[0.0; 3]; bodies.len()];
    for frame in first..=last {
        text += "0 0 0 0 0 0";
        for (column, angles_rad) in columns.iter().zip(&mut angles_rad) {
            let after = column.partition_point(|(of, _)| *of <= frame);
            let Some((_, sample)) = column.get(after.saturating_sub(1)) else {
                // It has no frame of its own: so short is it.
                text += " 0 0 0 0 0 0";
                continue;
            };
            let (place_m, turn) = y_up(sample);
            *angles_rad = xyz_near(&turn, angles_rad);
            let degrees = angles_rad.map(f64::to_degrees);
            for number in place_m.iter().chain(&degrees) {
                let _ = write!(text, " {number}");
            }
        }
        text.push('\n');
    }
    text
}

/// The keys that are at frames, by the frames' numbers.
fn on_frames(body: &ExportedBody, zero: Stamp, frame_rate_hz: f64) -> Vec<(i64, &PoseSample)> {
    /// How far a stamp may be from its frame \[s\]: both are rounded to nanoseconds.
    const SAME_S: f64 = 2e-9;
    let at_frames = body.keys.iter().filter_map(|key| {
        let at_s = key.sample.stamp.seconds_since(zero);
        let frame = (at_s * frame_rate_hz).round();
        ((frame / frame_rate_hz - at_s).abs() <= SAME_S).then_some((frame as i64, &key.sample))
    });
    at_frames.collect()
}

/// Place and orientation with the y axis up.
fn y_up(sample: &PoseSample) -> (Vector3<f64>, UnitQuaternion<f64>) {
    let upright = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -std::f64::consts::FRAC_PI_2);
    let [x, y, z, w] = sample.quaternion_xyzw;
    let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    let at_m = &sample.position_m;
    (Vector3::new(at_m.x, at_m.z, -at_m.y), upright * turn)
}

/// The principal axis about which a body turns the easiest: along what is long.
fn longest_axis(body: &Body) -> Vector3<f64> {
    Vector3::ith(body.moments_kg_m2().imin(), 1.0)
}

/// A name without blanks, which end names in this format, that none has had.
fn free_name(name: &str, taken: &mut BTreeSet<String>) -> String {
    let plain = |c: char| {
        if c.is_whitespace() || c.is_control() {
            '_'
        } else {
            c
        }
    };
    numbered(name.chars().map(plain).collect(), taken)
}
