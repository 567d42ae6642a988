//! The one vocabulary for what was not seen: words, numbers and habits with which programs say that a row has
//! no pose.

use std::collections::BTreeMap;

use crate::motion::PoseSample;

/// Words of cells that say that there is nothing, in lower case.
const WORDS: [&str; 33] = [
    "nan",
    "-nan",
    "+nan",
    "nan(ind)",
    "-nan(ind)",
    "nan(snan)",
    "-nan(snan)",
    "1.#qnan",
    "-1.#qnan",
    "1.#ind",
    "-1.#ind",
    "1.#inf",
    "-1.#inf",
    "inf",
    "-inf",
    "+inf",
    "infinity",
    "-infinity",
    "na",
    "n/a",
    "#n/a",
    "#n/d",
    "<na>",
    "null",
    "nil",
    "none",
    "-",
    "--",
    "?",
    "missing",
    "lost",
    "undefined",
    "invalid",
];
/// Sizes from which on equal numbers of a position are a sign for nothing, whatever their digits.
const HUGE: f64 = 1e9;
/// Least number of nines of such a sign.
const NINES_MIN: usize = 4;
/// A pose jumps to the origin where it goes there by more than so many usual steps,
const JUMP_STEPS: f64 = 10.0;
/// and by more than this in the unit of the file's poses \[m\].
const JUMP_MIN_M: f64 = 1e-3;
/// So many rows at the very origin whose orientation goes on turning have no position.
const LIVE_ROWS: usize = 3;

/// Why a row has no pose of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Unseen {
    /// Cells are empty.
    Empty,
    /// Cells say so by a word such as `nan`.
    Word,
    /// Numbers stand for nothing: 9999999.
    Sentinel,
    /// All zeros.
    Zeros,
    /// A residual below zero.
    Residual,
    /// A column says that it is not tracked.
    Flag,
    /// Its matrix is no rotation.
    NoRotation,
}

impl Unseen {
    fn words(self) -> &'static str {
        match self {
            Self::Empty => "with empty cells",
            Self::Word => "with words for nothing (nan, NA, inf and the like)",
            Self::Sentinel => "with a number that stands for nothing",
            Self::Zeros => "at the very origin",
            Self::Residual => "with a residual below 0",
            Self::Flag => "that a column says are not tracked",
            Self::NoRotation => "whose matrix is no rotation",
        }
    }
}

/// How many rows have no pose, by reason.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UnseenRows {
    by_reason: BTreeMap<Unseen, usize>,
}

impl UnseenRows {
    pub(super) fn add(&mut self, reason: Unseen) {
        *self.by_reason.entry(reason).or_default() += 1;
    }

    /// All of them.
    pub fn count(&self) -> usize {
        self.by_reason.values().sum()
    }

    pub(super) fn count_of(&self, reason: Unseen) -> usize {
        self.by_reason.get(&reason).copied().unwrap_or(0)
    }

    /// What they are, in words: `3 with empty cells, 6 at the very origin`; `None` where there are none.
    pub fn words(&self) -> Option<String> {
        let each = self.by_reason.iter();
        let each: Vec<String> = each
            .map(|(reason, count)| format!("{count} {}", reason.words()))
            .collect();
        (!each.is_empty()).then(|| each.join(", "))
    }
}

/// Why a cell holds no number: it is empty, or has a word for nothing.
pub(super) fn absence(cell: &str) -> Option<Unseen> {
    if cell.is_empty() {
        return Some(Unseen::Empty);
    }
    // Numbers are most of what is looked at; those of an old runtime have a sign of their own.
    if cell.starts_with(|of: char| of.is_ascii_digit()) && !cell.contains('#') {
        return None;
    }
    let is_word = cell.len() <= 12 && WORDS.contains(&cell.to_ascii_lowercase().as_str());
    is_word.then_some(Unseen::Word)
}

/// Whether a cell says that there is nothing.
pub(super) fn is_absent(cell: &str) -> bool {
    absence(cell).is_some()
}

/// Whether the coordinates of a position are one number that stands for nothing.
pub(super) fn is_sentinel(position: [f64; 3]) -> bool {
    let [x, y, z] = position.map(f64::abs);
    if x != y || y != z {
        return false;
    }
    let digits = format!("{x}");
    let digits: Vec<u8> = digits.bytes().filter(u8::is_ascii_digit).collect();
    let nines = digits.iter().take_while(|digit| **digit == b'9').count();
    let are_nines = nines >= NINES_MIN && digits[nines..].iter().all(|digit| *digit == b'0');
    x >= HUGE || (are_nines && x > 900.0)
}

/// Samples that are at the very origin without having come there: as far from their neighbours as no step
/// of the path, or several in a row that go on turning. Samples are in the order of the file.
pub(super) fn stray_zeros(samples: &[PoseSample]) -> Vec<bool> {
    let is_zero = |sample: &PoseSample| sample.position_m.iter().all(|of| *of == 0.0);
    let mut stray = vec![false; samples.len()];
    if !samples.iter().any(is_zero) {
        return stray;
    }
    let mut steps_m: Vec<f64> = samples
        .windows(2)
        .filter(|pair| !is_zero(&pair[0]) && !is_zero(&pair[1]))
        .map(|pair| (pair[1].position_m - pair[0].position_m).norm())
        .filter(|step_m| *step_m > 0.0)
        .collect();
    steps_m.sort_by(f64::total_cmp);
    let usual_m = steps_m.get(steps_m.len() / 2).copied().unwrap_or(0.0);
    let limit_m = (JUMP_STEPS * usual_m).max(JUMP_MIN_M);
    let mut at = 0;
    while at < samples.len() {
        if !is_zero(&samples[at]) {
            at += 1;
            continue;
        }
        let run = samples[at..].iter().take_while(|of| is_zero(of)).count();
        let end = at + run;
        let neighbours = [at.checked_sub(1), (end < samples.len()).then_some(end)];
        let jumps = neighbours.into_iter().flatten();
        let is_jump = { jumps }.any(|other| samples[other].position_m.norm() > limit_m);
        let turns = samples[at..end].windows(2);
        let turns = turns.filter(|pair| pair[0].quaternion_xyzw != pair[1].quaternion_xyzw);
        let is_live = run >= LIVE_ROWS
            && samples[at].quaternion_xyzw.iter().all(|of| of.is_finite())
            && 2 * turns.count() >= run;
        stray[at..end].fill(is_jump || is_live);
        at = end;
    }
    stray
}

/// Poses that are the very one before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HeldPoses {
    /// How many.
    pub count: usize,
    /// Most of them in a row,
    pub longest: usize,
    /// which begin after this sample.
    pub longest_from: usize,
}

/// Counts poses that are held: equal to the last digit to the one before. Samples are in order.
pub fn held_poses(samples: &[&PoseSample]) -> HeldPoses {
    let parts = |sample: &PoseSample| {
        let [x, y, z] = sample.position_m.into();
        let [a, b, c, d] = sample.quaternion_xyzw;
        [x, y, z, a, b, c, d].map(f64::to_bits)
    };
    let mut held = HeldPoses::default();
    let mut run = 0;
    for (index, pair) in samples.windows(2).enumerate() {
        if parts(pair[0]) != parts(pair[1]) {
            run = 0;
            continue;
        }
        run += 1;
        held.count += 1;
        if run > held.longest {
            held.longest = run;
            held.longest_from = index + 1 - run;
        }
    }
    held
}

/// Steps to which positions are rounded, the coarsest first \[m\].
const ROUNDED_M: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// Fewer positions are of any step by chance.
const ROUNDED_SAMPLES: usize = 30;

/// What is held is explained by rounding where the path goes on within so many steps.
const ROUNDED_STEPS: f64 = 3.0;

/// The step to which all positions are rounded, where that explains that poses are held: the path goes on from each by a
/// few steps. `None` where they are not rounded, or where one is left by a jump, as of a tracker that held what it lost.
pub fn rounded_m(samples: &[&PoseSample]) -> Option<f64> {
    let is_of = |step_m: f64| {
        let mut all = samples.iter().flat_map(|sample| sample.position_m.iter());
        all.all(|at_m| (at_m / step_m - (at_m / step_m).round()).abs() < 1e-6)
    };
    let step_m = ROUNDED_M.into_iter().find(|step_m| is_of(*step_m))?;
    let mut is_held = false;
    for pair in samples.windows(2) {
        let way_m = pair[1].position_m - pair[0].position_m;
        let stays = way_m.amax() == 0.0 && pair[0].quaternion_xyzw == pair[1].quaternion_xyzw;
        if is_held && !stays && way_m.amax() > (ROUNDED_STEPS + 0.5) * step_m {
            return None;
        }
        is_held = stays;
    }
    (samples.len() >= ROUNDED_SAMPLES).then_some(step_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Stamp;
    use nalgebra::Vector3;

    #[test]
    fn words_and_numbers_for_nothing_are_known() {
        for cell in [
            "",
            "nan",
            "NaN",
            "-nan(ind)",
            "NA",
            "N/A",
            "inf",
            "-Inf",
            "1.#QNAN",
            "null",
            "-",
        ] {
            assert!(is_absent(cell), "{cell}");
        }
        for cell in ["0", "-1", "1e3", "nan1", "lost and found"] {
            assert!(!is_absent(cell), "{cell}");
        }
        for value in [9_999_999.0, -9999.0, 99_999.9, 1e10, 3.4e38] {
            assert!(is_sentinel([value; 3]), "{value}");
        }
        for position in [[0.0; 3], [999.0; 3], [9999.0, 9999.0, 1.0], [1234.5; 3]] {
            assert!(!is_sentinel(position), "{position:?}");
        }
    }

    fn path(points: &[[f64; 2]]) -> Vec<PoseSample> {
        let sample = |(index, [x, turn]): (usize, &[f64; 2])| {
            let position_m = Vector3::new(*x, 0.0, 0.0);
            PoseSample::new(Stamp(index as i64), position_m, [0.0, 0.0, *turn, 1.0])
        };
        points.iter().enumerate().map(sample).collect()
    }

    #[test]
    fn zeros_are_no_poses_where_the_path_does_not_come_there() {
        let jump = path(&[
            [1.0, 0.0],
            [1.01, 0.0],
            [0.0, 0.0],
            [0.0, 0.0],
            [1.02, 0.0],
            [1.03, 0.0],
        ]);
        assert_eq!(stray_zeros(&jump), [false, false, true, true, false, false]);
        // A trajectory that begins where its world does.
        let begins = path(&[[0.0, 0.0], [0.01, 0.1], [0.02, 0.2], [0.03, 0.3]]);
        assert_eq!(stray_zeros(&begins), [false; 4]);
        // Orientation alone.
        let live = path(&[
            [0.0, 0.1],
            [0.0, 0.2],
            [0.0, 0.3],
            [0.005, 0.4],
            [0.01, 0.5],
        ]);
        assert_eq!(stray_zeros(&live), [true, true, true, false, false]);
    }

    #[test]
    fn repeats_of_what_is_rounded_are_told_from_a_tracker_that_holds() {
        let slow = |step_m: f64, jump_m: f64| {
            let at_m = |index: usize| 0.0003 * index as f64 + if index < 51 { 0.0 } else { jump_m };
            let points: Vec<[f64; 2]> = (0..100)
                .map(|index| [(at_m(index) / step_m).round() * step_m, 0.0])
                .collect();
            let samples = path(&points);
            rounded_m(&samples.iter().collect::<Vec<_>>())
        };
        assert_eq!(slow(1e-3, 0.0), Some(1e-3));
        assert_eq!(slow(1e-2, 0.0), Some(1e-2));
        assert_eq!(slow(1e-3, 0.5), None);
        assert_eq!(slow(1.7e-5, 0.0), None);
    }

    #[test]
    fn held_poses_are_counted_with_the_longest_run() {
        let all = path(&[
            [1.0, 0.0],
            [1.0, 0.0],
            [2.0, 0.0],
            [3.0, 0.0],
            [3.0, 0.0],
            [3.0, 0.0],
        ]);
        let all: Vec<&PoseSample> = all.iter().collect();
        let expected = HeldPoses {
            count: 3,
            longest: 2,
            longest_from: 3,
        };
        assert_eq!(held_poses(&all), expected);
    }
}
