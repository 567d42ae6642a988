//! How far a prediction may be off: where drawn motions come to rest.

use nalgebra::Vector3;

use super::index::LinkIndex;
use crate::math::Pose;

/// Draws are alike in how a body is turned up to this angle \[rad\].
const LIKE_RAD: f64 = 20.0 * std::f64::consts::PI / 180.0;
/// Share of the draws that the stated distance covers.
const COVERED: f64 = 0.9;

/// Where simulations from drawn states, with drawn materials, come to rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// Number of draws that could be simulated.
    pub draws: usize,
    /// Number of them in which all came to rest.
    pub at_rest: usize,
    /// Names of materials of which the scene states no deviation: all draws have the same.
    pub exact: Vec<String>,
    /// Of each link that moves.
    pub links: Vec<LinkSpread>,
}

/// Where a link comes to rest.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkSpread {
    /// The link.
    pub link: LinkIndex,
    /// Median of each coordinate of its centre of mass \[m\].
    pub median_m: Vector3<f64>,
    /// Distance from there within which nine in ten predictions fall \[m\].
    pub radius_m: f64,
    /// What is up, with the share of the draws, the likeliest first.
    pub up: Vec<(String, f64)>,
    /// The draw to whose orientation most others are near, world from link.
    pub likely: Pose,
    /// The share that are, within 20°.
    pub likely_share: f64,
}

impl LinkSpread {
    /// Of the last poses of the draws, and what is up in each; `None` of no draws.
    pub fn new(link: LinkIndex, ends: &[Pose], up: &[String]) -> Option<Self> {
        let count = ends.len() as f64;
        let median_m = Vector3::from_fn(|axis, _| {
            let mut along: Vec<f64> = ends
                .iter()
                .map(|end| end.translation.vector[axis])
                .collect();
            along.sort_by(f64::total_cmp);
            let (low, high) = (along.len().saturating_sub(1) / 2, along.len() / 2);
            match along.get(low).zip(along.get(high)) {
                Some((low, high)) => 0.5 * (low + high),
                None => f64::NAN,
            }
        });
        let far = |end: &Pose| (end.translation.vector - median_m).norm();
        let mut far_m: Vec<f64> = ends.iter().map(far).collect();
        far_m.sort_by(f64::total_cmp);
        // Of n draws and the truth each is as likely to be the farthest.
        let rank = (COVERED * (count + 1.0)).ceil() as usize;
        let radius_m = *far_m.get(rank.clamp(1, far_m.len().max(1)) - 1)?;
        let like = |end: &Pose| {
            let turn = |other: &&Pose| end.rotation.angle_to(&other.rotation) <= LIKE_RAD;
            ends.iter().filter(turn).count()
        };
        let likely = ends.iter().max_by(|a, b| {
            let near = |end: &Pose| -far(end);
            like(a).cmp(&like(b)).then(near(a).total_cmp(&near(b)))
        })?;
        let mut shares: Vec<(String, f64)> = Vec::new();
        for name in up {
            match shares.iter_mut().find(|(of, _)| of == name) {
                Some((_, share)) => *share += 1.0 / count,
                None => shares.push((name.clone(), 1.0 / count)),
            }
        }
        shares.sort_by(|a, b| b.1.total_cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
        Some(Self {
            link,
            median_m,
            radius_m,
            up: shares,
            likely: *likely,
            likely_share: like(likely) as f64 / count,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Translation3, UnitQuaternion};

    #[test]
    fn the_middle_the_distance_and_the_likeliest_are_those_of_the_draws() {
        let end = |x_m: f64, turn_deg: f64| {
            let turn = UnitQuaternion::from_scaled_axis(Vector3::x() * turn_deg.to_radians());
            Pose::from_parts(Translation3::new(x_m, 0.0, 0.0), turn)
        };
        // 0, 1, … 19 mm; most lie about 90°, the one nearest to the middle among them at 8 mm.
        let ends: Vec<Pose> = (0..20)
            .map(|at| {
                end(
                    1e-3 * f64::from(at),
                    if at < 9 {
                        180.0
                    } else {
                        90.0 + f64::from(at % 2)
                    },
                )
            })
            .collect();
        let up: Vec<String> = (0..20)
            .map(|at| ["-z", "+y"][usize::from(at >= 9)].into())
            .collect();
        let spread = LinkSpread::new(LinkIndex(0), &ends, &up).unwrap();
        assert!((spread.median_m - Vector3::new(9.5e-3, 0.0, 0.0)).norm() < 1e-12);
        // The 19th of 20: at 9.5 mm from the middle are two.
        assert!((spread.radius_m - 9.5e-3).abs() < 1e-12, "{spread:?}");
        assert_eq!(spread.up[0].0, "+y");
        assert!(
            (spread.up[0].1 - 0.55).abs() < 1e-12 && (spread.likely_share - 0.55).abs() < 1e-12
        );
        // Of those that lie so one of the two nearest to the middle.
        let off_m = (spread.likely.translation.vector - spread.median_m).norm();
        let turn = spread.likely.rotation.angle_to(&ends[9].rotation);
        assert!(off_m < 0.51e-3 && turn < 0.02, "{spread:?}");
        assert!(LinkSpread::new(LinkIndex(0), &[], &[]).is_none());
    }
}
