//! How a tracker is turned on a body that stands as the scene says.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use super::spread::Measured;
use crate::math::so3::{between, hat};

/// Axes that are less than this apart are one \[rad\].
const PARALLEL_RAD: f64 = 0.2;

/// A body that stood still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    /// The body's axis that was up: unit, body axes.
    pub body_up: Vector3<f64>,
    /// What was up in the tracker's axes: unit.
    pub tracker_up: Vector3<f64>,
}

/// The tracker's orientation on the body.
#[derive(Clone, Debug, PartialEq)]
pub struct Mounted {
    /// The rotation.
    pub body_from_tracker: UnitQuaternion<f64>,
    /// Rotation vector by which the scene's is wrong: `scene · Exp(θ)` is right \[rad, tracker axes\].
    pub correction_rad: Vector3<f64>,
    /// Its interval about body axes \[rad\]; infinite about what one standing leaves open.
    pub interval_rad: Measured,
    /// Root mean square angle between what was up and what should have been \[rad\], each degree of freedom counted
    /// once; `None` of one standing.
    pub residual_rad: Option<f64>,
    /// Whether all of it was found. Of one standing, the turn about the axis that was up is the scene's.
    pub is_whole: bool,
}

/// The rotation that turns what was up in the tracker's axes to what was up in the body's: of one standing the
/// least change of the scene's, of more the one that fits best (Wahba's problem, by singular values).
/// `None` without any standing.
pub fn mount(standings: &[Standing], scene: &UnitQuaternion<f64>) -> Option<Mounted> {
    let first = standings.first()?;
    let is_other = |of: &Standing| {
        let angle = of.body_up.cross(&first.body_up).norm();
        angle > PARALLEL_RAD.sin()
    };
    let is_whole = standings.iter().any(is_other);
    let body_from_tracker = if is_whole {
        let scatter: Matrix3<f64> = standings
            .iter()
            .map(|of| of.body_up * of.tracker_up.transpose())
            .sum();
        let svd = scatter.svd(true, true);
        let (u, v_t) = (svd.u?, svd.v_t?);
        let handed = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, (u * v_t).determinant()));
        let turn = Rotation3::from_matrix_unchecked(u * handed * v_t);
        UnitQuaternion::from_rotation_matrix(&turn)
    } else {
        let tracker_up: Vector3<f64> = standings
            .iter()
            .map(|of| {
                let is_same = of.body_up.dot(&first.body_up) > 0.0;
                of.tracker_up * if is_same { 1.0 } else { -1.0 }
            })
            .sum();
        between(&(scene * tracker_up.normalize()), &first.body_up) * scene
    };
    let errors = standings.iter().map(|of| {
        (body_from_tracker * of.tracker_up)
            .cross(&of.body_up)
            .norm_squared()
    });
    let square: f64 = errors.sum();
    let unknown = if is_whole { 3 } else { 2 };
    let freedom = (2 * standings.len()).saturating_sub(unknown) as f64;
    let residual_rad = (freedom > 0.0).then(|| (square / freedom).sqrt());
    let information: Matrix3<f64> = standings
        .iter()
        .map(|of| hat(&of.body_up).transpose() * hat(&of.body_up))
        .sum();
    let covariance = information.try_inverse().filter(|_| is_whole);
    let sd = |axis: usize| match (covariance, residual_rad) {
        (Some(covariance), Some(residual_rad)) => residual_rad * covariance[(axis, axis)].sqrt(),
        _ => f64::INFINITY,
    };
    let correction_rad = crate::math::so3::log(&(scene.inverse() * body_from_tracker));
    Some(Mounted {
        body_from_tracker,
        correction_rad,
        interval_rad: Measured::new(vec![0.0; 3], (0..3).map(sd).collect(), freedom),
        residual_rad,
        is_whole,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::so3::exp;

    #[test]
    fn two_sides_give_all_of_it_and_one_the_least_change() {
        let truth = exp(&Vector3::new(0.4, -1.1, 0.7));
        let scene = truth * exp(&Vector3::new(0.1, 0.05, -0.08));
        let standing = |body_up: Vector3<f64>| Standing {
            body_up,
            tracker_up: truth.inverse() * body_up,
        };
        let both = [standing(Vector3::z()), standing(Vector3::x())];
        let whole = mount(&both, &scene).unwrap();
        assert!(whole.is_whole && whole.body_from_tracker.angle_to(&truth) < 1e-9);
        assert!((scene * exp(&whole.correction_rad)).angle_to(&truth) < 1e-9);
        let one = mount(&both[..1], &scene).unwrap();
        let up = one.body_from_tracker * both[0].tracker_up;
        assert!(!one.is_whole && (up - Vector3::z()).norm() < 1e-9);
        // The least change: no more than that of the whole correction.
        assert!(one.correction_rad.norm() <= whole.correction_rad.norm());
        assert_eq!(one.residual_rad, None);
        assert!(mount(&[], &scene).is_none());
        // Upside down is the same line, and leaves the same open.
        let flipped = [standing(Vector3::z()), standing(-Vector3::z())];
        let line = mount(&flipped, &scene).unwrap();
        assert!(!line.is_whole && line.body_from_tracker.angle_to(&one.body_from_tracker) < 1e-9);
    }
}
