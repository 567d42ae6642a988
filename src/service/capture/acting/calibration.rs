//! Calibrations that a page asks for, step by step: takes that it has recorded go through those of `enact calibrate`.
//!
//! What a step has found counts in the next ones: the place of the tracker follows from how it is turned, and the
//! table from where the tip is. Nothing that is there is written over: a step leaves a calibration and a scene with it
//! beside its recording, and the page shows the keys to be put into the scene by hand.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use anyhow::{Context, bail};
use serde::Deserialize;
use serde_json::json;

use crate::config::scene_calibrated;
use crate::ingest::live::StreamTopic;
use crate::service::output::write_new_file;
use crate::service::panics::guarded;
use crate::service::words;
use crate::service::{CalibrateChoice, CalibrateJob, CalibrateKind, TouchingPoint, calibrate};

/// Most takes of one step: the sides of a box.
const TAKES: usize = 6;

/// For how long a tip stays about each mark, to each side \[s\].
const WINDOW_S: f64 = 0.05;

/// What is calibrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum CalibrationStep {
    /// The object stands still on one side or several: how its tracker is turned.
    Rest,
    /// Its tip stays where it is and it swings: where its tracker is.
    Pivot,
    /// Its tip touches the table: where that is.
    Plane,
}

impl CalibrationStep {
    fn name(self) -> &'static str {
        match self {
            Self::Rest => "rest",
            Self::Pivot => "pivot",
            Self::Plane => "plane",
        }
    }
}

/// A step that a page asks for.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CalibrationWish {
    pub(super) step: CalibrationStep,
    /// Index of the tracker's stream.
    pub(super) stream: usize,
    /// Numbers of the takes.
    pub(super) takes: Vec<u64>,
    /// The scene's name of the tip.
    #[serde(default)]
    pub(super) feature: Option<String>,
    /// The scene's name of the plane.
    #[serde(default)]
    pub(super) surface: Option<String>,
    /// What of the body is up, one for each take.
    #[serde(default)]
    pub(super) stands: Vec<String>,
}

/// The scene with what was found.
#[derive(Debug)]
struct CalibratedSoFar {
    toml: String,
    /// Its file; none as long as nothing was found.
    scene: Option<PathBuf>,
    /// The calibration of the tip.
    tip: Option<PathBuf>,
}

/// What pages have calibrated since the daemon began.
#[derive(Debug)]
pub(super) struct Calibrations {
    topics: Vec<String>,
    so_far: Mutex<CalibratedSoFar>,
}

impl Calibrations {
    pub(super) fn new(scene_toml: &str, topics: &[StreamTopic]) -> Self {
        Self {
            topics: topics.iter().map(|of| of.topic.clone()).collect(),
            so_far: Mutex::new(CalibratedSoFar {
                toml: scene_toml.to_owned(),
                scene: None,
                tip: None,
            }),
        }
    }

    /// Makes a step of the recordings of its takes; what the page is told. Fails, in words, where nothing is found, or
    /// while another step is made.
    pub(super) fn make(
        &self,
        wish: &CalibrationWish,
        recordings: Vec<PathBuf>,
    ) -> Result<String, String> {
        let Ok(mut so_far) = self.so_far.try_lock() else {
            return Err("another calibration is being made".to_owned());
        };
        let made = guarded(|| so_far.make(wish, &self.topics, recordings));
        made.map_err(|error| words(&error))
    }
}

impl CalibratedSoFar {
    fn make(
        &mut self,
        wish: &CalibrationWish,
        topics: &[String],
        recordings: Vec<PathBuf>,
    ) -> anyhow::Result<String> {
        let Some(topic) = topics.get(wish.stream) else {
            bail!(
                "no stream {} in the scene, which has {}",
                wish.stream,
                topics.len()
            );
        };
        // A step that is made again has one take more, whose name no calibration has yet.
        let newest = recordings.last().filter(|_| recordings.len() <= TAKES);
        let Some(newest) = newest else {
            bail!("{} takes, expected 1 to {TAKES}", recordings.len());
        };
        let name = wish.step.name();
        let file = newest.with_extension(format!("{name}.toml"));
        let job = CalibrateJob {
            inputs: recordings.clone(),
            output: Some(file.clone()),
            choice: CalibrateChoice {
                topics: vec![topic.clone()],
                scene: self.scene.clone(),
                ..CalibrateChoice::default()
            },
            kind: self.kind(wish)?,
        };
        let found = calibrate(&job)?;
        let keys = keys_of(&found.toml);
        // What something speaks against is shown, and made anew.
        let is_good = found.calibration.against.is_empty() && found.lost.is_empty();
        let scene = newest.with_extension(format!("{name}.scene.toml"));
        if is_good && !keys.is_empty() {
            let of = [(
                crate::service::provenance::file_name(&file),
                found.calibration.clone(),
            )];
            let toml = scene_calibrated(&self.toml, &of)
                .map_err(|error| error.in_file("the scene with this calibration".to_owned()))?
                .toml;
            let made_of: Vec<&Path> = recordings.iter().map(PathBuf::as_path).collect();
            write_new_file(&scene, toml.as_bytes(), &made_of).context("the scene with it")?;
            (self.toml, self.scene) = (toml, Some(scene));
        }
        if is_good && wish.step == CalibrationStep::Pivot {
            self.tip = Some(file.clone());
        }
        let against = [found.calibration.against, found.lost].concat();
        Ok(json!({
            "what": "calibrated",
            "step": name,
            "is_good": is_good,
            "quantity": found.calibration.quantity,
            "against": against,
            "notes": found.calibration.notes,
            "keys": keys,
            "file": file,
            "scene": self.scene.as_ref().filter(|_| is_good),
        })
        .to_string())
    }

    fn kind(&self, wish: &CalibrationWish) -> anyhow::Result<CalibrateKind> {
        Ok(match wish.step {
            CalibrationStep::Rest => CalibrateKind::Rest {
                stands: wish.stands.clone(),
            },
            CalibrationStep::Pivot => CalibrateKind::Pivot {
                feature: wish.feature.clone(),
            },
            CalibrationStep::Plane => CalibrateKind::Plane {
                point: match (&wish.feature, &self.tip) {
                    (Some(feature), _) => TouchingPoint::Feature(feature.clone()),
                    (None, Some(tip)) => TouchingPoint::Pivot(tip.clone()),
                    (None, None) => bail!(
                        "where the tip is in the tracker's axes is not known, expected a feature of the body, or its \
                         tip found first by turning about it"
                    ),
                },
                at_s: Vec::new(),
                window_s: WINDOW_S,
                surface: wish.surface.clone().unwrap_or_else(|| "table".to_owned()),
            },
        })
    }
}

/// The keys for a scene in the text of a calibration, which ends with them.
fn keys_of(toml: &str) -> String {
    let is_key = |line: &&str| line.starts_with("[scene.") || line.starts_with("[[scene.");
    let lines = toml.lines().skip_while(|line| !is_key(line));
    let keys: Vec<String> = lines
        .map(|line| match is_key(&line) {
            true => line.replacen("scene.", "", 1),
            false => line.to_owned(),
        })
        .collect();
    keys.join("\n")
}
