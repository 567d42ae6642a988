//! Poses as text: CSV, and trajectories as the tools of SLAM's benchmarks read them (TUM).

use std::fmt::Write;

use super::super::keyframes::{quoted, seconds};
use super::frames::{ExportedBody, Key};
use crate::motion::{PoseSample, Scene, Stamp};
use crate::report::ExportProvenance;

/// The columns of [`csv`].
const HEADER: &str = "t_s,stamp_ns,body,motion,event,x_m,y_m,z_m,qw,qx,qy,qz";

/// A row per key and body in order of time, below comments on where it is from and a header.
///
/// `t_s` is physical time, `stamp_ns` the same as the recording counts it; `motion` is `estimate`,
/// `simulated` or `acted`; `event` is empty where none happens. Places are in world axes, of the
/// origins of the frames in which the scene gives the bodies, and quaternions turn those frames into them.
pub fn csv(
    scene: &Scene,
    bodies: &[ExportedBody],
    zero: Stamp,
    simulated_from: Option<Stamp>,
    provenance: &ExportProvenance,
) -> String {
    let mut rows: Vec<(Stamp, usize, &str, &Key)> = Vec::new();
    for (place, body) in bodies.iter().enumerate() {
        for key in &body.keys {
            let stamp = key.sample.stamp;
            let is_simulated = simulated_from.is_some_and(|from| stamp > from);
            let motion = match is_simulated {
                true => "simulated",
                false => "estimate",
            };
            rows.push((stamp, place, motion, key));
        }
        let acted = body.acted.iter();
        rows.extend(acted.map(|key| (key.sample.stamp, place, "acted", key)));
    }
    rows.sort_by_key(|(stamp, place, motion, _)| (*stamp, *place, *motion == "acted"));
    let mut text = comment(provenance);
    text += HEADER;
    text.push('\n');
    for (stamp, place, motion, key) in rows {
        let PoseSample {
            position_m,
            quaternion_xyzw: [qx, qy, qz, qw],
            ..
        } = &key.sample;
        let since = seconds(Stamp(stamp.0.saturating_sub(zero.0)));
        let body = quoted(&scene.links[bodies[place].link].name);
        let event = quoted(key.event.as_deref().unwrap_or_default());
        let [x, y, z] = [position_m.x, position_m.y, position_m.z];
        let _ = writeln!(
            text,
            "{since},{},{body},{motion},{event},{x},{y},{z},{qw},{qx},{qy},{qz}",
            stamp.0
        );
    }
    text
}

/// A trajectory in TUM's format, `t x y z qx qy qz qw` with blanks between, times as the recording
/// counts them.
pub fn tum(keys: &[Key], provenance: &ExportProvenance) -> String {
    let mut text = comment(provenance);
    for key in keys {
        let PoseSample {
            stamp,
            position_m,
            quaternion_xyzw: [qx, qy, qz, qw],
            ..
        } = &key.sample;
        let [x, y, z] = [position_m.x, position_m.y, position_m.z];
        let at = seconds(*stamp);
        let _ = writeln!(text, "{at} {x} {y} {z} {qx} {qy} {qz} {qw}");
    }
    text
}

/// Lines for people that readers of tables leave out.
fn comment(of: &ExportProvenance) -> String {
    let lines = of.lines().into_iter();
    lines.map(|line| format!("# {line}\n")).collect()
}
