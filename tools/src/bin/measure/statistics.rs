//! Medians, spreads and fitted powers.

/// The value below which a share of the others lies, between neighbours linearly; NaN of none.
pub fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let place = share * last as f64;
    let below = (place.floor() as usize).min(last);
    let above = (below + 1).min(last);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

/// The middle of the values.
pub fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

/// The largest, NaN counting as larger than all; zero of none.
pub fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, |a, b| {
        if a.is_nan() || b.is_nan() {
            f64::NAN
        } else {
            a.max(b)
        }
    })
}

/// Root of the mean square; NaN of none.
pub fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

/// The arithmetic mean; NaN of none.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Half the width of the middle half, scaled to the standard deviation of a normal distribution:
/// what a few outliers do not change.
pub fn robust_sd(values: &[f64]) -> f64 {
    (quantile(values, 0.75) - quantile(values, 0.25)) / 1.349
}

/// The exponent `p` of `y = c xᵖ` by least squares in logarithms.
pub fn exponent(x: &[f64], y: &[f64]) -> f64 {
    let log = |values: &[f64]| values.iter().map(|v| v.ln()).collect::<Vec<f64>>();
    let (x, y) = (log(x), log(y));
    let (mean_x, mean_y) = (mean(&x), mean(&y));
    let cross: f64 = x
        .iter()
        .zip(&y)
        .map(|(x, y)| (x - mean_x) * (y - mean_y))
        .sum();
    let square: f64 = x.iter().map(|x| (x - mean_x) * (x - mean_x)).sum();
    cross / square
}
