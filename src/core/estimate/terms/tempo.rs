//! The tempo prior (timing unknown, paper §4.3): a performer's rate changes smoothly.
//!
//! Between neighbouring nodes the physical time advances at the rate `g/Δa`, physical over acted
//! interval. Its logarithm is modelled as Brownian motion of strength σ [1/√s], so that half and
//! double the rate have equal weight at any tempo:
//!
//! ```text
//! r = (ln(g₂/Δa₂) − ln(g₁/Δa₁)) / (σ √½(Δa₁ + Δa₂))
//! ```
//!
//! The prior is part of the objective to the end. It determines timing where the motion alone does
//! not (a straight drop), and keeps intervals positive, so that the order of times (paper eq. 7)
//! needs no constraint.

/// One residual and its derivatives by the times of its three nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TempoTerm {
    /// The residual.
    pub residual: f64,
    /// Its derivatives [1/s].
    pub jacobian: [f64; 3],
}

/// The residual at three neighbouring nodes.
pub fn term(times_s: &[f64; 3], acted_s: &[f64; 3], sd_per_sqrt_s: f64) -> TempoTerm {
    let gaps = [times_s[1] - times_s[0], times_s[2] - times_s[1]];
    let acted = [acted_s[1] - acted_s[0], acted_s[2] - acted_s[1]];
    let scale = 1.0 / (sd_per_sqrt_s * (0.5 * (acted[0] + acted[1])).sqrt());
    let slope = [scale / gaps[0], scale / gaps[1]];
    TempoTerm {
        residual: scale * ((gaps[1] / acted[1]).ln() - (gaps[0] / acted[0]).ln()),
        jacobian: [slope[0], -(slope[0] + slope[1]), slope[1]],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::differentiate;

    #[test]
    fn derivative_is_exact() {
        let (times, acted) = ([0.3, 1.1, 1.6], [0.0, 1.7, 3.9]);
        let numeric = differentiate::jacobian(1, 3, |d| {
            vec![
                term(
                    &[times[0] + d[0], times[1] + d[1], times[2] + d[2]],
                    &acted,
                    0.5,
                )
                .residual,
            ]
        });
        let exact = term(&times, &acted, 0.5);
        for k in 0..3 {
            assert!((numeric[0][k] - exact.jacobian[k]).abs() < 1e-9);
        }
    }

    #[test]
    fn a_steady_tempo_costs_nothing_at_any_rate() {
        for rate in [0.1, 0.4, 3.0] {
            let acted = [0.0, 0.2, 0.7];
            assert!(
                term(&acted.map(|a| 5.0 + rate * a), &acted, 0.5)
                    .residual
                    .abs()
                    < 1e-12
            );
        }
    }
}
