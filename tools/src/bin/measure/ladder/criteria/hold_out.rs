//! Prediction of samples that are held out.
//!
//! Each flight's samples are cut into [`FOLDS`] blocks; a fold is one block of every flight, which an
//! estimate without it predicts. The score of a sample is the square of its error in units of the scene's
//! weights.

use std::collections::BTreeMap;

use enact::motion::{Scene, Stamp};
use enact::pipeline::Outcome;
use enact_tools::case::estimated;
use enact_tools::nonsense::Asked;

use super::super::predict::{difference, poses};
use super::super::split::Split;
use super::super::step::{closed, pose_of};
use crate::statistics::mean;

/// Parts of the samples that are held out in turn.
const FOLDS: usize = 5;

/// The scene that predicts best, if one does better than the take's own by more than a standard error.
pub fn best(asked: &Asked, scenes: &[Scene]) -> Option<usize> {
    if scenes.is_empty() {
        return None;
    }
    let folds = folds(&estimated(&asked.scene, &asked.events, &mut ()).ok()?);
    let own = scores(asked, &asked.scene, &folds);
    let gains = scenes.iter().enumerate().filter_map(|(index, scene)| {
        let others = scores(asked, scene, &folds);
        let differences = own
            .iter()
            .map(|(stamp, own)| Some(own - others.get(stamp)?));
        // A fold that only the narrower scene predicts speaks against the wider.
        let differences: Vec<f64> = differences.collect::<Option<_>>()?;
        let count = differences.len() as f64;
        let middle = mean(&differences);
        let squares = differences.iter().map(|d| (d - middle).powi(2));
        let variance = squares.sum::<f64>() / (count - 1.0);
        (middle > (variance / count).sqrt()).then_some((index, middle))
    });
    gains
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(index, _)| index)
}

/// The fold of every sample that is used.
fn folds(outcome: &Outcome) -> BTreeMap<Stamp, usize> {
    let estimate = &outcome.estimate;
    let mut samples = estimate.sample_times.iter();
    let mut folds = BTreeMap::new();
    for flight in &estimate.residuals {
        for (index, sample) in samples.by_ref().take(flight.samples).enumerate() {
            folds.insert(sample.stamp, index * FOLDS / flight.samples);
        }
    }
    folds
}

/// Scores of the samples of all folds that a scene predicts.
fn scores(asked: &Asked, scene: &Scene, folds: &BTreeMap<Stamp, usize>) -> BTreeMap<Stamp, f64> {
    let mut scores = BTreeMap::new();
    let weights = scene.weights;
    for fold in 0..FOLDS {
        let split = Split::of(asked, |sample| folds.get(&sample.stamp) == Some(&fold));
        let found = estimated(scene, &split.kept.events, &mut ());
        let Some(outcome) = closed(&found) else {
            continue;
        };
        let stamps: Vec<Stamp> = split.held.iter().map(|sample| sample.stamp).collect();
        for (sample, pose) in split.held.iter().zip(poses(outcome, &stamps)) {
            let error = difference(&pose, &pose_of(sample));
            let units = [weights.position_m, weights.orientation_rad];
            let squares = error
                .iter()
                .enumerate()
                .map(|(i, e)| (e / units[i / 3]).powi(2));
            scores.insert(sample.stamp, squares.sum());
        }
    }
    scores
}
