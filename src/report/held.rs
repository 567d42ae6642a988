//! Bodies in the hand, and those that tumble.

use serde::{Deserialize, Serialize};

use super::read::unknown;
use super::reported::Reported;
use crate::motion::HeldMotion;
use crate::motion::held::HeldEstimate;

/// A body in the hand, throughout or in a phase, or one that tumbles: its motion is what its tracker saw, smoothed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct HeldLine {
    /// Name of the body.
    pub body: String,
    /// `held`, or `tumble` where contacts move it that nothing explains.
    pub motion: String,
    /// Name of the phase in which it is so; none of what is held throughout.
    pub phase: Option<String>,
    /// Physical time at which that begins.
    pub start_s: Option<f64>,
    /// Physical time at which it ends.
    pub end_s: Option<f64>,
    /// Samples that were smoothed.
    pub samples: usize,
    /// Standard deviation of the tracker's positions per axis, as given or as the stream shows.
    #[serde(default = "unknown")]
    pub noise_mm: f64,
    /// Standard deviation of its orientations per axis.
    #[serde(default = "unknown")]
    pub noise_deg: f64,
    /// Number of collisions with it, or of changes at which it is taken or let go.
    pub collisions: usize,
    /// Greatest distance of the motion from the smoothed one there.
    #[serde(default = "unknown")]
    pub moved_mm: f64,
    /// Greatest angle between both.
    #[serde(default = "unknown")]
    pub moved_deg: f64,
}

/// The bodies in the hand.
pub(super) fn held_lines(of: &Reported) -> Vec<HeldLine> {
    let throughout = of.estimate.held.iter().map(|held| {
        let tracks = of.scene.tracks.iter().zip(&of.sketch.tracks);
        let mut own = tracks.filter(|(track, _)| track.link == held.link);
        let motion = own.find_map(|(_, seen)| seen.held.as_ref());
        held_line(of, held, motion)
    });
    let for_a_while = of.estimate.grips.iter().map(|grip| HeldLine {
        motion: match of.scene.phases[grip.phase].tumbles() {
            true => "tumble".to_owned(),
            false => "held".to_owned(),
        },
        phase: Some(of.scene.phases[grip.phase].name.clone()),
        start_s: Some(grip.span_s[0]),
        end_s: Some(grip.span_s[1]),
        ..held_line(of, &grip.motion, of.sketch.grip(grip.phase))
    });
    throughout.chain(for_a_while).collect()
}

fn held_line(of: &Reported, held: &HeldEstimate, motion: Option<&HeldMotion>) -> HeldLine {
    let noise_sd = motion.map_or([f64::NAN; 2], |motion| motion.noise_sd);
    let largest = |kind: usize| {
        let passed = held.passed.iter().map(|passed| passed.off[kind]);
        passed.fold(0.0, f64::max)
    };
    HeldLine {
        body: of.scene.links[held.link].name.clone(),
        motion: "held".to_owned(),
        phase: None,
        start_s: None,
        end_s: None,
        samples: held.sample_times.len(),
        noise_mm: noise_sd[0] * 1e3,
        noise_deg: noise_sd[1].to_degrees(),
        collisions: held.passed.len(),
        moved_mm: largest(0) * 1e3,
        moved_deg: largest(1).to_degrees(),
    }
}
