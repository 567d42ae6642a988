//! Where a search begins, from what each take says by itself.

use nalgebra::DVector;

use super::parameter::{JointParameter, NORMAL_MEDIAN, lengths};
use super::part::PlainPart;
use crate::motion::TakeShare;

/// Where a search begins, in lengths.
pub(super) struct JointBegin {
    /// Of each parameter the median of what takes say, each with the weight of its information.
    pub(super) mean: DVector<f64>,
    /// Of what is drawn.
    pub(super) variances: DVector<f64>,
    /// Where each take is asked: at its own values of what is drawn, since from the mean it may be led to another optimum.
    pub(super) asked: Vec<DVector<f64>>,
}

impl JointBegin {
    pub(super) fn of(parameters: &[JointParameter], own: &[Option<TakeShare>]) -> Self {
        let mean = DVector::from_iterator(
            parameters.len(),
            parameters.iter().enumerate().map(|(at, parameter)| {
                let values = own.iter().flatten().map(|share| {
                    let value = share.values[at] / parameter.length;
                    (value, told(parameters, share, at))
                });
                let median = median(values.collect());
                parameter.inside(median.unwrap_or(parameter.initial / parameter.length))
            }),
        );
        let mut variances = DVector::zeros(parameters.len());
        let mut asked = vec![mean.clone(); own.len()];
        let drawn = parameters.iter().enumerate();
        for (at, parameter) in drawn.filter(|(_, of)| of.is_drawn) {
            let [lower, upper] = parameter.bounds();
            let value =
                |share: &TakeShare| (share.values[at] / parameter.length).clamp(lower, upper);
            for (asked, share) in asked.iter_mut().zip(own) {
                asked[at] = share.as_ref().map_or(asked[at], value);
            }
            let offs = own
                .iter()
                .flatten()
                .map(|of| ((value(of) - mean[at]).abs(), 1.0));
            let off = median(offs.collect()).unwrap_or(0.0);
            variances[at] = (off / NORMAL_MEDIAN).powi(2);
        }
        Self {
            mean,
            variances,
            asked,
        }
    }
}

/// How much a take's own share tells of one parameter, with next to nothing known beforehand.
fn told(parameters: &[JointParameter], share: &TakeShare, at: usize) -> f64 {
    let mean = share.values.component_div(&lengths(parameters));
    let part = PlainPart::new(parameters, share, &mean);
    let variance = part.alone().map_or(1.0, |of| of[(at, at)]);
    (variance.max(1e-12).recip() - 1.0).max(1e-9)
}

/// The value with half of the weight on each side.
fn median(mut weighed: Vec<(f64, f64)>) -> Option<f64> {
    weighed.retain(|(value, _)| value.is_finite());
    weighed.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * weighed.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut below = 0.0;
    let mut least = weighed.iter().filter(|(_, weight)| {
        below += weight;
        below >= half
    });
    least.next().map(|(value, _)| *value)
}
