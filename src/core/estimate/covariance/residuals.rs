//! Residuals of samples, and how great they are.

/// A residual, position then orientation in body axes, in the problem's units; or its change.
pub type Six = [f64; 6];

/// The residuals of one view's samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Residuals {
    /// Whether the view sees positions, and whether orientations or directions: the others are zero.
    pub kinds: [bool; 2],
    /// Sample by sample.
    pub each: Vec<Six>,
}

/// Mean square residuals of positions and of orientations, per axis; zero where none are seen.
pub(in crate::estimate) fn mean_squares(residuals: &[Residuals]) -> [f64; 2] {
    let of_each = residuals.iter().map(|of| (of.kinds, of.each.iter()));
    mean_of_squares(of_each)
}

/// Variance of white noise: a sixth of the mean square of second differences along the views, or the
/// mean square residual where none has three samples.
pub(in crate::estimate) fn white(residuals: &[Residuals]) -> [f64; 2] {
    let second = |three: &[Six]| -> Six {
        std::array::from_fn(|axis| three[0][axis] - 2.0 * three[1][axis] + three[2][axis])
    };
    let differences = residuals.iter();
    let differences = differences.map(|of| (of.kinds, of.each.windows(3).map(second)));
    let of_differences = mean_of_squares(differences).map(|square| square / 6.0);
    let of_all = mean_squares(residuals);
    [0, 1].map(|kind| {
        let has_three = |of: &Residuals| of.kinds[kind] && of.each.len() >= 3;
        if residuals.iter().any(has_three) {
            of_differences[kind]
        } else {
            of_all[kind]
        }
    })
}

fn mean_of_squares<S: std::borrow::Borrow<Six>>(
    series: impl Iterator<Item = ([bool; 2], impl Iterator<Item = S>)>,
) -> [f64; 2] {
    let (mut counts, mut sums) = ([0_usize; 2], [0.0; 2]);
    for (kinds, each) in series {
        for six in each {
            for kind in 0..2 {
                counts[kind] += usize::from(kinds[kind]);
            }
            for (axis, value) in six.borrow().iter().enumerate() {
                sums[axis / 3] += value * value;
            }
        }
    }
    [0, 1].map(|kind| sums[kind] / (3 * counts[kind].max(1)) as f64)
}
