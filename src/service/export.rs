//! Makes files for other programs of the motion that a recording has.

mod files;
mod job;

use anyhow::bail;

use self::files::{files, write};
pub use self::job::{ExportFormat, ExportJob, Exported};
use super::read_back::ReadBack;
use super::working::Working;
use crate::motion::Scene;
use crate::write::export::{ExportedBody, WrittenMotion, exported_bodies, fastest_turn_rad_s};

/// Frames a second at which a motion is exported, unless others are asked for: those of films.
pub const DEFAULT_EXPORT_RATE_HZ: f64 = 24.0;

/// Frames a second that can be asked for; beyond them nothing is between the poses of a file.
const RATES_HZ: std::ops::RangeInclusive<f64> = 1e-3..=1e5;

/// Most frames that are made, of all bodies.
const FRAME_LIMIT: f64 = 5e5;

/// Exports the motion of a recording. All of it is made before anything is written.
pub fn export(job: &ExportJob) -> anyhow::Result<Exported> {
    if !RATES_HZ.contains(&job.frame_rate_hz) {
        bail!(
            "frame rate {} Hz, expected {} to {}",
            job.frame_rate_hz,
            RATES_HZ.start(),
            RATES_HZ.end()
        );
    }
    let path = job.input.display();
    let working = Working::begin("reading");
    let read = ReadBack::open(&job.input)?;
    working.now("exporting");
    let (scene, motion) = (&read.scene, &read.motion);
    if job.with_acted && job.format == ExportFormat::Bvh {
        bail!(
            "--ghost: a BVH has keys at frames alone, expected glb, csv or tum for the performance"
        );
    }
    check_span(job, motion)?;
    let bodies = exported_bodies(scene, motion, job.frame_rate_hz, job.with_acted);
    if bodies.is_empty() {
        bail!(
            "{path}: the estimate has no motion; its verdict is {}",
            motion.verdict
        );
    }
    let provenance = read.provenance(&job.command);
    let mut exported = Exported {
        input: path.to_string(),
        outputs: Vec::new(),
        scene: scene.name.clone(),
        verdict: motion.verdict.clone(),
        bodies: bodies.len(),
        keys: bodies.iter().map(|body| body.keys.len()).sum(),
        lost: read.lost(),
        warnings: warnings(job, scene, motion, &bodies),
    };
    let files = files(job, &read, &bodies, &provenance)?;
    write(job, files, &provenance, &mut exported)?;
    Ok(exported)
}

/// Refuses motions whose frames would fill memory and disk.
fn check_span(job: &ExportJob, motion: &WrittenMotion) -> anyhow::Result<()> {
    let spans_s = motion.estimates.iter().map(|samples| {
        let ends = samples.first().zip(samples.last());
        ends.map_or(0.0, |(first, last)| last.stamp.seconds_since(first.stamp))
    });
    let span_s: f64 = spans_s.sum();
    if span_s * job.frame_rate_hz > FRAME_LIMIT {
        bail!(
            "{}: {span_s} s of all bodies at {} Hz are more than {FRAME_LIMIT} frames, expected a \
             lower rate",
            job.input.display(),
            job.frame_rate_hz
        );
    }
    Ok(())
}

fn warnings(
    job: &ExportJob,
    scene: &Scene,
    motion: &WrittenMotion,
    bodies: &[ExportedBody],
) -> Vec<String> {
    let mut warnings = Vec::new();
    let still = scene.links.iter_enumerated();
    let still = still.filter(|(link, _)| bodies.iter().all(|body| body.link != *link));
    for (_, link) in still {
        warnings.push(format!(
            "body {:?} has no motion and is left out",
            link.name
        ));
    }
    for body in bodies
        .iter()
        .filter(|of| job.with_acted && of.acted.is_empty())
    {
        let name = &scene.links[body.link].name;
        warnings.push(format!(
            "body {name:?} has no acted poses: no tracker sees its pose"
        ));
    }
    // Between two keys every reader takes the shorter way.
    let fastest = motion
        .estimates
        .iter()
        .map(|samples| fastest_turn_rad_s(samples));
    let between_rad = fastest.fold(0.0, f64::max) / job.frame_rate_hz;
    if between_rad > std::f64::consts::PI {
        let needed_hz = (job.frame_rate_hz * between_rad / std::f64::consts::PI).ceil();
        warnings.push(format!(
            "a body turns by more than half a turn between frames, and would seem to turn the other way: \
             expected --fps {needed_hz} or more"
        ));
    }
    if job.format == ExportFormat::Glb && !motion.parameters.is_empty() {
        warnings.push(format!(
            "surfaces and obstacles are where the scene has them, whatever is estimated: {}",
            motion.parameters.join(", ")
        ));
    }
    warnings
}
