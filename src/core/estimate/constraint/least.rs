//! The least distance of a pair of features over a short time, `min_t φ(t) ≥ φ_least`.
//!
//! With the moment `t*` of the least distance, the envelope theorem says that it does not matter how `t*` moves:
//!
//! ```text
//! φ'(t*) = 0:                         δφ = φ_q δq
//! φ₁(t*) = φ₂(t*), φ₁' < 0 < φ₂':     δφ = λ₁ φ₁_q δq + λ₂ φ₂_q δq,   λ₁ = φ₂'/(φ₂' − φ₁'),  λ₂ = 1 − λ₁
//! t* = τ, the end of the flight:      δφ = φ_q δq + φ' δτ
//! ```
//!
//! The second is where the distance passes from one pair of features to the next; it is the greater of both.

use nalgebra::{RowSVector, Vector6};

use crate::estimate::problem::clearance::{ClearSolids, ClearanceTouches, KeptFrom};
use crate::motion::held::HeldEstimate;
use crate::physics::State;
use crate::physics::contact::{Contact, Frame};

/// Intervals among whose ends the least distance is looked for first.
const INTERVALS: usize = 8;
/// Greatest number of steps to a root, and the share of an interval that is a root's error.
const ROOT_STEPS: usize = 60;
const ROOT_ERROR: f64 = 1e-13;

/// When a clearance is least, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::estimate) struct LeastMoment {
    /// \[s\].
    pub(in crate::estimate) time_s: f64,
    /// Share of each pair of features in the derivative.
    shares: [f64; 2],
    /// The end of the motion at which it is, if it is there.
    pub(in crate::estimate) end: Option<usize>,
}

/// A pose, and how it goes on.
#[derive(Clone, Copy, Debug)]
pub(in crate::estimate) struct MovingFrame {
    pub(in crate::estimate) frame: Frame,
    /// Of its tangent.
    pub(in crate::estimate) rate: Vector6<f64>,
}

/// The distance of a pair of features at a time.
pub(in crate::estimate) struct FeatureGap {
    pub(in crate::estimate) gap_m: f64,
    /// [m/s].
    pub(in crate::estimate) rate_m_s: f64,
    /// By the poses of both.
    pub(in crate::estimate) by: RowSVector<f64, 12>,
}

impl MovingFrame {
    /// That of a body.
    pub(in crate::estimate) fn of(state: &State) -> Self {
        let mut rate = Vector6::zeros();
        rate.fixed_rows_mut::<3>(0).copy_from(&state.velocity_m_s);
        rate.fixed_rows_mut::<3>(3)
            .copy_from(&state.angular_velocity_rad_s);
        Self {
            frame: Frame::of(state),
            rate,
        }
    }

    fn still(frame: Frame) -> Self {
        Self {
            frame,
            rate: Vector6::zeros(),
        }
    }

    fn held(held: &HeldEstimate, time_s: f64) -> Self {
        Self::of(&held.state(time_s))
    }

    /// That of what a body must stay out of; what moves as the unknowns say is asked.
    pub(in crate::estimate) fn of_other(
        from: &KeptFrom,
        time_s: f64,
        moving: impl FnOnce() -> Self,
    ) -> Self {
        match from {
            KeptFrom::Still(frame) => Self::still(*frame),
            KeptFrom::Held(held) => Self::held(held, time_s),
            KeptFrom::Flying => moving(),
        }
    }
}

impl FeatureGap {
    /// Between two bodies; `None` where the features have no distance.
    pub(in crate::estimate) fn new(contact: &Contact, both: &[MovingFrame; 2]) -> Option<Self> {
        let [own, other] = both;
        let (touch, derivative) = contact.touch_derivative(&own.frame, &other.frame).ok()?;
        let along = |side: usize, of: &MovingFrame| {
            let by = derivative.gap.fixed_columns::<6>(6 * side);
            (by * of.rate)[0]
        };
        Some(Self {
            gap_m: touch.gap_m,
            rate_m_s: along(0, own) + along(1, other),
            by: derivative.gap,
        })
    }
}

impl LeastMoment {
    /// When features are nearest between both ends of the motion \[s\], by the distance of each pair at any time; `None` where
    /// they have none.
    pub(in crate::estimate) fn of(
        solids: &ClearSolids,
        ends_s: [f64; 2],
        gap: &mut dyn FnMut(&Contact, f64) -> Option<FeatureGap>,
    ) -> Option<Self> {
        let ends_s = [ends_s[0], ends_s[1].max(ends_s[0])];
        let within_s = solids.window_s(ends_s);
        let mut search = LeastSearch {
            solids,
            ends_s,
            gap,
        };
        match &solids.touches {
            ClearanceTouches::One(_) => search.of_one(0, within_s),
            ClearanceTouches::Switching(_) => search.of_two(within_s),
        }
    }

    /// The distance then, of each pair of features by its share.
    pub(in crate::estimate) fn shared(
        &self,
        solids: &ClearSolids,
        gap: impl Fn(&Contact) -> Option<FeatureGap>,
    ) -> Option<FeatureGap> {
        let mut all = FeatureGap {
            gap_m: 0.0,
            rate_m_s: 0.0,
            by: RowSVector::zeros(),
        };
        for (contact, share) in solids.contacts().iter().zip(self.shares) {
            if share != 0.0 {
                let of = gap(contact)?;
                all.gap_m += share * of.gap_m;
                all.rate_m_s += share * of.rate_m_s;
                all.by += of.by * share;
            }
        }
        Some(all)
    }
}

/// The search for the moment of the least distance.
struct LeastSearch<'a> {
    solids: &'a ClearSolids,
    /// Start and end of the motion \[s\].
    ends_s: [f64; 2],
    gap: &'a mut dyn FnMut(&Contact, f64) -> Option<FeatureGap>,
}

impl LeastSearch<'_> {
    /// Distance of a pair of features and its rate.
    fn gap(&mut self, contact: usize, time_s: f64) -> Option<FeatureGap> {
        (self.gap)(&self.solids.contacts()[contact], time_s)
    }

    fn at(&self, contact: usize, time_s: f64) -> LeastMoment {
        let mut shares = [0.0; 2];
        shares[contact] = 1.0;
        LeastMoment {
            time_s,
            shares,
            end: (0..2).find(|side| self.ends_s[*side] == time_s),
        }
    }

    /// Where one pair of features is nearest within a time.
    fn of_one(&mut self, contact: usize, [from_s, to_s]: [f64; 2]) -> Option<LeastMoment> {
        let step_s = (to_s - from_s) / INTERVALS as f64;
        let times_s = (0..=INTERVALS).map(|at| match at {
            INTERVALS => to_s,
            _ => from_s + at as f64 * step_s,
        });
        let times_s: Vec<f64> = times_s.collect();
        let mut gaps_m = Vec::new();
        for time_s in &times_s {
            gaps_m.push(self.gap(contact, *time_s)?.gap_m);
        }
        let least = (0..gaps_m.len()).min_by(|a, b| gaps_m[*a].total_cmp(&gaps_m[*b]))?;
        let mut slope = |time_s: f64| Some(self.gap(contact, time_s)?.rate_m_s);
        let middle_s = times_s[least];
        let here = slope(middle_s)?;
        let other = if here > 0.0 {
            least.checked_sub(1)
        } else {
            (least < INTERVALS).then_some(least + 1)
        };
        let Some(other) = other else {
            return Some(self.at(contact, middle_s));
        };
        let time_s = root([middle_s, times_s[other]], slope)?;
        Some(self.at(contact, time_s))
    }

    /// By how much the first of two pairs of features is farther than the second \[m\].
    fn ahead_m(&mut self, time_s: f64) -> Option<f64> {
        Some(self.gap(0, time_s)?.gap_m - self.gap(1, time_s)?.gap_m)
    }

    /// Where the greater distance of two pairs is least, the first before they are as far and the second after.
    fn of_two(&mut self, [from_s, to_s]: [f64; 2]) -> Option<LeastMoment> {
        match (self.ahead_m(from_s)? > 0.0, self.ahead_m(to_s)? > 0.0) {
            (true, true) => return self.of_one(0, [from_s, to_s]),
            (false, false) => return self.of_one(1, [from_s, to_s]),
            (false, true) => {
                // In the other order.
                let greater = usize::from(self.ahead_m(self.solids.around_s)? < 0.0);
                return self.of_one(greater, [from_s, to_s]);
            }
            (true, false) => {}
        }
        let time_s = root([from_s, to_s], |time_s| self.ahead_m(time_s))?;
        let [before, after] = [self.gap(0, time_s)?.rate_m_s, self.gap(1, time_s)?.rate_m_s];
        if before >= 0.0 {
            return self.of_one(0, [from_s, time_s]);
        }
        if after <= 0.0 {
            return self.of_one(1, [time_s, to_s]);
        }
        let share = after / (after - before);
        Some(LeastMoment {
            time_s,
            shares: [share, 1.0 - share],
            end: None,
        })
    }
}

/// The root of a function with other signs at the ends of an interval, by the Illinois variant of the secant method; the
/// first end where signs are alike.
fn root([mut a, mut b]: [f64; 2], mut of: impl FnMut(f64) -> Option<f64>) -> Option<f64> {
    let (mut at_a, mut at_b) = (of(a)?, of(b)?);
    if at_a * at_b > 0.0 || at_a == 0.0 {
        return Some(a);
    }
    let error = ROOT_ERROR * (b - a).abs();
    for _ in 0..ROOT_STEPS {
        if at_b == 0.0 || (b - a).abs() <= error {
            break;
        }
        let between = (a * at_b - b * at_a) / (at_b - at_a);
        let value = of(between)?;
        if value * at_b < 0.0 {
            (a, at_a) = (b, at_b);
        } else {
            at_a *= 0.5;
        }
        let is_there = (between - b).abs() <= error;
        (b, at_b) = (between, value);
        if is_there {
            break;
        }
    }
    Some(b)
}
