//! Makes a page and a picture for people of the motion that a recording has.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use serde::Serialize;

use super::guard::Inputs;
use super::output::write_file_of;
use super::read_back::ReadBack;
use super::working::Working;
use crate::motion::{PoseSample, Sees, TakeEvent, TrackIndex};
use crate::page::{Page, View, html, strobe_of};
#[cfg(feature = "live")]
use crate::write::export::{exported_bodies, glb};

/// The input of [`report`].
#[derive(Clone, Debug)]
pub struct ReportJob {
    /// A recording with an estimate.
    pub input: PathBuf,
    /// Where the page goes, a file or [stdout](crate::service::is_pipe); none: no page is made.
    pub page: Option<PathBuf>,
    /// Where the picture goes, likewise, and from where it is seen.
    pub picture: Option<(PathBuf, View)>,
    /// The command line, to be noted in the files.
    pub command: String,
}

/// The result of [`report`].
#[derive(Clone, Debug, Serialize)]
pub struct ReportMade {
    /// The file that was read.
    pub input: String,
    /// The files that were written.
    pub outputs: Vec<String>,
    /// Name of the scene.
    pub scene: String,
    /// `physical`, `plausible` or `failed`.
    pub verdict: String,
    /// Parts of the recording that could not be read.
    pub lost: Vec<String>,
    /// What to know.
    pub warnings: Vec<String>,
}

/// Makes them. Both are made before anything is written.
pub fn report(job: &ReportJob) -> anyhow::Result<ReportMade> {
    let path = job.input.display();
    let working = Working::begin("reading");
    let read = ReadBack::open(&job.input)?;
    working.now("drawing");
    let provenance = read.provenance(&job.command);
    let (readings, unread) = readings(&read);
    let mut made = ReportMade {
        input: path.to_string(),
        outputs: Vec::new(),
        scene: read.scene.name.clone(),
        verdict: read.motion.verdict.clone(),
        lost: read.lost(),
        warnings: unread.into_iter().collect(),
    };
    let page = Page {
        scene: &read.scene,
        motion: &read.motion,
        readings: &readings,
        provenance: &provenance,
        lost: &read.lost(),
    };
    let mut files: Vec<(&Path, String)> = Vec::new();
    if let Some(to) = &job.page {
        files.push((to, html(&page).with_context(|| path.to_string())?));
    }
    if let Some((to, view)) = &job.picture {
        let Some(strobe) = strobe_of(&page).with_context(|| path.to_string())? else {
            bail!(
                "{path}: the estimate has no motion to draw; its verdict is {}",
                made.verdict
            );
        };
        files.push((to, strobe.file(*view)));
    }
    check(&job.input, &files)?;
    for (to, text) in files {
        write_file_of(to, text.as_bytes(), &[&job.input])?;
        made.outputs.push(to.display().to_string());
    }
    Ok(made)
}

/// Frames a second of a motion that pages play.
#[cfg(feature = "live")]
const PLAYED_HZ: f64 = 60.0;

/// What pages show of the motion of an estimate: first it as glTF, with what was acted, for who plays it; then the picture, as
/// an SVG file. `None`, and nothing to play, where it has no motion.
#[cfg(feature = "live")]
pub(super) fn shown(input: &Path, play: impl FnOnce(Vec<u8>)) -> anyhow::Result<Option<String>> {
    let read = ReadBack::open(input)?;
    let bodies = exported_bodies(&read.scene, &read.motion, PLAYED_HZ, true);
    if !bodies.is_empty() {
        let provenance = read.provenance("enact capture");
        let zero = read.motion.zero;
        play(glb(&read.scene, &bodies, zero, PLAYED_HZ, &provenance));
    }
    let (readings, _) = readings(&read);
    let page = Page {
        scene: &read.scene,
        motion: &read.motion,
        readings: &readings,
        provenance: &read.provenance("enact capture"),
        lost: &read.lost(),
    };
    let strobe = strobe_of(&page).with_context(|| input.display().to_string())?;
    Ok(strobe.map(|strobe| strobe.file_that_plays(View::ThreeQuarter)))
}

/// Refuses files of one name, and the recording as one of them.
fn check(input: &Path, files: &[(&Path, String)]) -> anyhow::Result<()> {
    let inputs = Inputs::of([input]);
    for (index, (to, _)) in files.iter().enumerate() {
        if files[..index].iter().any(|(other, _)| other == to) {
            bail!(
                "page and picture would go to the same place, expected another name for one of them"
            );
        }
        inputs.keep_from(to)?;
    }
    Ok(())
}

/// What trackers read that see points alone, and why not if that cannot be read: the page does without.
fn readings(read: &ReadBack) -> (Vec<(TrackIndex, PoseSample)>, Option<String>) {
    let scene = &read.scene;
    if scene.tracks.iter().all(|track| track.sees != Sees::Point) {
        return (Vec::new(), None);
    }
    let take = match read.recording.take(scene) {
        Ok(take) => take,
        Err(error) => {
            return (
                Vec::new(),
                Some(format!("distances of points are not drawn: {error}")),
            );
        }
    };
    let readings = take.events.into_iter().filter_map(|event| match event {
        TakeEvent::Pose { track, sample, .. } if scene.tracks[track].sees == Sees::Point => {
            Some((track, sample))
        }
        _ => None,
    });
    (readings.collect(), None)
}
