//! What paths tell of the tracker: readings that are missing, jumps, and poses that are the very one before.

use crate::ingest::table::{held_poses, rounded_m};
use crate::motion::PoseSample;

/// An interval of so many usual ones has readings missing in it.
const GAP: f64 = 1.75;

/// A step is a jump where it is faster than this \[m/s\],
const JUMP_M_S: f64 = 3.0;
/// longer than this \[m\],
const JUMP_M: f64 = 0.02;
/// and so many times as fast as the steps beside it: what is thrown or struck goes on as fast.
const JUMP_TIMES: f64 = 4.0;

/// So many poses in a row that are the very one before are held,
const HELD_SAMPLES: usize = 10;
/// and more than this share of all.
const HELD_SHARE: f64 = 0.3;
/// No hand stays within the step of a rounding for longer \[s\].
const STILL_S: f64 = 0.5;

/// What a path tells of its tracker.
#[derive(Clone, Debug, Default)]
pub(super) struct ToldTracker {
    pub(super) notes: Vec<String>,
    pub(super) against: Vec<String>,
}

/// What the samples of a body tell of its tracker, which are in order of time; so many a second are usual.
pub(super) fn tracked(name: &str, samples: &[&PoseSample], rate_hz: Option<f64>) -> ToldTracker {
    let mut told = ToldTracker::default();
    if let Some(rate_hz) = rate_hz {
        gaps(name, samples, 1.0 / rate_hz, &mut told);
    }
    jumps(name, samples, &mut told);
    held(name, samples, &mut told);
    told
}

/// Time of a sample since the first one \[s\].
fn time_s(samples: &[&PoseSample], at: usize) -> f64 {
    samples[at].stamp.seconds_since(samples[0].stamp)
}

/// Readings that are missing, by intervals that are longer than usual.
fn gaps(name: &str, samples: &[&PoseSample], usual_s: f64, told: &mut ToldTracker) {
    let interval_s = |at: usize| time_s(samples, at + 1) - time_s(samples, at);
    let long: Vec<usize> = (0..samples.len().saturating_sub(1))
        .filter(|at| interval_s(*at) > GAP * usual_s)
        .collect();
    let longest = long
        .iter()
        .copied()
        .max_by(|one, other| interval_s(*one).total_cmp(&interval_s(*other)));
    let Some(longest) = longest else {
        return;
    };
    let missing: f64 = long
        .iter()
        .map(|at| (interval_s(*at) / usual_s).round() - 1.0)
        .sum();
    told.notes.push(format!(
        "{name}: some {missing:.0} readings are missing, in {} gaps, the longest of {:.3} s (from {:.3} s)",
        long.len(),
        interval_s(longest),
        time_s(samples, longest)
    ));
}

/// Steps that no hand makes: the tracker has found it anew elsewhere.
fn jumps(name: &str, samples: &[&PoseSample], told: &mut ToldTracker) {
    let step_m = |at: usize| (samples[at + 1].position_m - samples[at].position_m).norm();
    let steps: Vec<usize> = (0..samples.len().saturating_sub(1))
        .filter(|at| samples[*at].stamp < samples[at + 1].stamp)
        .collect();
    let speed_m_s = |at: usize| step_m(at) / (time_s(samples, at + 1) - time_s(samples, at));
    let is_jump = |of: &&[usize]| {
        let [before, at, after] = [speed_m_s(of[0]), speed_m_s(of[1]), speed_m_s(of[2])];
        at > JUMP_M_S && at > JUMP_TIMES * before.max(after) && step_m(of[1]) > JUMP_M
    };
    let jumps: Vec<usize> = steps.windows(3).filter(is_jump).map(|of| of[1]).collect();
    let greatest = jumps
        .iter()
        .copied()
        .max_by(|one, other| speed_m_s(*one).total_cmp(&speed_m_s(*other)));
    if let Some(at) = greatest {
        told.against.push(format!(
            "{name}: jumps {} times, by up to {:.0} mm at {:.1} m/s (at {:.3} s), and goes on slowly: the tracker had lost \
             it. They are kept; expected a part without them by --start and --end",
            jumps.len(),
            1e3 * step_m(at),
            speed_m_s(at),
            time_s(samples, at)
        ));
    }
}

/// What poses tell that are the very one before.
fn held(name: &str, samples: &[&PoseSample], told: &mut ToldTracker) {
    let held = held_poses(samples);
    if held.count == 0 {
        return;
    }
    let [from, to] = [held.longest_from, held.longest_from + held.longest];
    let from_s = time_s(samples, from);
    let longest_s = time_s(samples, to) - from_s;
    let said = format!(
        "{name}: {} of {} poses are exactly the one before, up to {} in a row (from {from_s:.3} s)",
        held.count,
        samples.len(),
        held.longest
    );
    let rounded = rounded_m(samples);
    if let Some(step_m) = rounded {
        let said = format!(
            "{said}: positions are rounded to {} mm, and a hand that moves by less repeats",
            1e3 * step_m
        );
        match longest_s > STILL_S {
            false => told.notes.push(said),
            true => told.against.push(format!(
                "{said}, but not for {longest_s:.1} s: it was put down there, or out of sight. They are kept; expected a \
                 part without them by --start and --end"
            )),
        }
        return;
    }
    let is_many = held.count as f64 > HELD_SHARE * samples.len() as f64;
    if is_many || held.longest >= HELD_SAMPLES {
        told.against.push(format!(
            "{said}: a tracker that holds what it lost, or rows that are more than its readings? They are kept; expected \
             rows without them, or a part without them by --start and --end"
        ));
    } else {
        told.notes.push(said);
    }
}
