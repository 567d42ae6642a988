//! When the corners of a real toss touch the table, read off its samples.

/// A corner nearer to the table than this touches it: less than a sample before \[m\].
const NEAR_M: f64 = 0.0015;
/// Samples of a flight that is long enough to show how the impacts before it ended.
const LONG: f64 = 5.0;
/// Greatest number of impacts that are estimated together.
const MOST: usize = 4;
/// Contacts closer than this may have come in the other order, in samples.
const TOGETHER: f64 = 1.0;

/// A corner that comes down to the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touched {
    /// Time in samples.
    pub place: f64,
    /// Index of the corner.
    pub corner: usize,
}

/// The contacts of a toss in order of time, from the corners' heights at every sample: where a
/// corner comes within reach of the table, when it would be at the table at the speed of the
/// samples before.
pub fn contacts(heights_m: &[Vec<f64>]) -> Vec<Touched> {
    let mut touched = Vec::new();
    for (index, three) in heights_m.windows(3).enumerate() {
        for (corner, now_m) in three[2].iter().enumerate() {
            let [before_m, last_m] = [three[0][corner], three[1][corner]];
            if *now_m < NEAR_M && last_m >= NEAR_M {
                let fall_m = (before_m - last_m).max(last_m - now_m);
                touched.push(Touched {
                    place: (index + 1) as f64 + last_m / fall_m,
                    corner,
                });
            }
        }
    }
    touched.sort_by(|a, b| a.place.total_cmp(&b.place));
    touched
}

/// The impacts to be estimated together: the first and those that follow before a long flight; with
/// the place at which that ends, in samples.
pub fn first_impacts(all: &[Touched], count: usize) -> Option<(Vec<Touched>, f64)> {
    let ends = |index: usize| all.get(index + 1).map_or(count as f64, |next| next.place);
    let is_last = |index: &usize| ends(*index) - all[*index].place >= LONG;
    let last = (0..all.len().min(MOST)).find(is_last)?;
    Some((all[..=last].to_vec(), ends(last)))
}

/// The same impacts in other orders that the samples cannot tell from it, itself first.
pub fn orders(impacts: &[Touched]) -> Vec<Vec<Touched>> {
    let mut orders = vec![impacts.to_vec()];
    for first in 0..impacts.len().saturating_sub(1) {
        let [a, b] = [impacts[first], impacts[first + 1]];
        if b.place - a.place < TOGETHER {
            let mut other = impacts.to_vec();
            other[first].corner = b.corner;
            other[first + 1].corner = a.corner;
            orders.push(other);
        }
    }
    orders
}
