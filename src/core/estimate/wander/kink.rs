//! Which samples tell how a hand errs: a hand rounds the kink that a motion has at an impact, which is no error of the process.

/// Samples are left out so near to an impact \[s\],
const KINK_S: f64 = 0.06;
/// but no more of a flight at either end than this share.
const KINK_SHARE: f64 = 0.2;
/// Samples of a tracker that are nearer to one another tell next to nothing more \[s\].
pub const APART_S: f64 = 0.0035;

/// How near to an impact samples of a flight of this length are left out \[s\].
pub fn kink_s(flight_s: f64) -> f64 {
    KINK_S.min(KINK_SHARE * flight_s)
}
