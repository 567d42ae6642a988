//! Poses as text: CSV, and trajectories as the tools of SLAM's benchmarks read them (TUM).

use std::fmt::Write;

use super::super::keyframes::{quoted, seconds};
use super::frames::{ExportedBody, Key, deviation_at};
use super::motion::WrittenMotion;
use crate::motion::{PoseSample, Scene, Stamp};
use crate::report::ExportProvenance;

/// The columns of [`csv`].
const HEADER: &str = "t_s,stamp_ns,body,motion,event,x_m,y_m,z_m,qw,qx,qy,qz,\
     sd_x_m,sd_y_m,sd_z_m,sd_turn_x_rad,sd_turn_y_rad,sd_turn_z_rad,\
     sd_vx_m_s,sd_vy_m_s,sd_vz_m_s,sd_wx_rad_s,sd_wy_rad_s,sd_wz_rad_s";

/// A row per key and body in order of time, below comments on where it is from and a header.
///
/// `t_s` is physical time, `stamp_ns` the same as the recording counts it; `motion` is `estimate`,
/// `simulated` or `acted`; `event` is empty where none happens. Places are in world axes, of the
/// origins of the frames in which the scene gives the bodies, and quaternions turn those frames into them. Standard
/// deviations follow, of place and velocity in world axes, of turns and angular velocity about the frame's own; empty where
/// none is told.
pub fn csv(
    scene: &Scene,
    bodies: &[ExportedBody],
    motion: &WrittenMotion,
    provenance: &ExportProvenance,
) -> String {
    let mut rows: Vec<(Stamp, usize, &str, &Key)> = Vec::new();
    for (place, body) in bodies.iter().enumerate() {
        for key in &body.keys {
            let stamp = key.sample.stamp;
            let is_simulated = motion.simulated_from.is_some_and(|from| stamp > from);
            let kind = match is_simulated {
                true => "simulated",
                false => "estimate",
            };
            rows.push((stamp, place, kind, key));
        }
        let acted = body.acted.iter();
        rows.extend(acted.map(|key| (key.sample.stamp, place, "acted", key)));
    }
    rows.sort_by_key(|(stamp, place, kind, _)| (*stamp, *place, *kind == "acted"));
    let mut text = comment(provenance);
    text += HEADER;
    text.push('\n');
    for (stamp, place, kind, key) in rows {
        let PoseSample {
            position_m,
            quaternion_xyzw: [qx, qy, qz, qw],
            ..
        } = &key.sample;
        let since = seconds(Stamp(stamp.0.saturating_sub(motion.zero.0)));
        let body = quoted(&scene.links[bodies[place].link].name);
        let event = quoted(key.event.as_deref().unwrap_or_default());
        let [x, y, z] = [position_m.x, position_m.y, position_m.z];
        let _ = write!(
            text,
            "{since},{},{body},{kind},{event},{x},{y},{z},{qw},{qx},{qy},{qz}",
            stamp.0
        );
        let told = match kind {
            "estimate" => deviation_at(motion, bodies[place].link, stamp),
            _ => None,
        };
        for sd in told.unwrap_or_default().all().into_iter().flatten() {
            let _ = match sd {
                Some(sd) => write!(text, ",{sd}"),
                None => write!(text, ","),
            };
        }
        text.push('\n');
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
pub(super) fn comment(of: &ExportProvenance) -> String {
    let lines = of.lines().into_iter();
    lines.map(|line| format!("# {line}\n")).collect()
}
