//! Whether a closed surface lies inside of itself: shells that overlap enclose what is in both twice.

use nalgebra::Vector3;

use super::error::ShapeError;

/// Fewest and most places that are looked at, and how many pairs of a place and a triangle together.
const PLACES: (usize, usize) = (60, 400);
const PAIRS: usize = 4_000_000;

/// Distance of the points beside a place of the surface from it, relative to the size.
const BESIDE: f64 = 1e-5;

/// Share of the surface that may be inside of it: folds of a hand-made mesh hold nearly no volume.
const SHARE: f64 = 0.01;

/// Fails where beside more than a hundredth of a closed surface, triangles counter-clockwise from outside, a point is
/// enclosed more than once, or less than not at all. A cavity, whose triangles run the other way round, is right, and so
/// are parts that touch.
pub(super) fn check(triangles: &[[Vector3<f64>; 3]]) -> Result<(), ShapeError> {
    let areas = triangles
        .iter()
        .map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm());
    let mut until = Vec::with_capacity(triangles.len());
    let mut sum = 0.0;
    for area in areas {
        sum += area;
        until.push(sum);
    }
    let corners = || triangles.iter().flatten();
    let Some(first) = corners().next() else {
        return Ok(());
    };
    let (lower, upper) = corners().fold((*first, *first), |(l, u), p| (l.inf(p), u.sup(p)));
    let beside_m = BESIDE * (upper - lower).norm();
    let places = (PAIRS / triangles.len()).clamp(PLACES.0, PLACES.1);
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let mut wrong = 0;
    for place in 0..places {
        // Spread evenly over the surface, and over the triangles by the golden ratio.
        let at = sum * (place as f64 + 0.5) / places as f64;
        let index = until
            .partition_point(|until| *until < at)
            .min(triangles.len() - 1);
        let [a, b, c] = triangles[index];
        let Some(outward) = (b - a).cross(&(c - a)).try_normalize(0.0) else {
            continue;
        };
        let (one, other) = (
            (golden * place as f64).fract(),
            (golden * golden * place as f64 + 0.31).fract(),
        );
        let (across, along) = (1.0 - one.sqrt(), one.sqrt() * other);
        let point = a * across + b * along + c * (1.0 - across - along);
        let times = |side: f64| winding(triangles, &(point + outward * (side * beside_m)));
        let is_right = |times: i64| times == 0 || times == 1;
        wrong += usize::from(!(is_right(times(-1.0)) && is_right(times(1.0))));
    }
    let share = wrong as f64 / places as f64;
    match share > SHARE {
        true => Err(ShapeError::Overlapping { share }),
        false => Ok(()),
    }
}

/// How often the surface goes round a point: the sum of the solid angles of its triangles (van Oosterom and
/// Strackee), in whole spheres.
fn winding(triangles: &[[Vector3<f64>; 3]], point: &Vector3<f64>) -> i64 {
    let angles = triangles.iter().map(|corners| {
        let [a, b, c] = corners.map(|corner| corner - point);
        let [l, m, n] = [a, b, c].map(|of| of.norm());
        let volume = a.dot(&b.cross(&c));
        let across = l * m * n + a.dot(&b) * n + b.dot(&c) * l + c.dot(&a) * m;
        2.0 * volume.atan2(across)
    });
    (angles.sum::<f64>() / (4.0 * std::f64::consts::PI)).round() as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cuboid between two corners, inside out if it is a cavity.
    fn cuboid(lower: [f64; 3], upper: [f64; 3], is_cavity: bool) -> Vec<[Vector3<f64>; 3]> {
        let corner = |index: usize| {
            let at = |axis: usize| [lower, upper][index >> axis & 1][axis];
            Vector3::new(at(0), at(1), at(2))
        };
        let sides = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let of_side = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
        let triangles = sides.into_iter().flat_map(of_side);
        let turned = triangles.map(|[a, b, c]| if is_cavity { [a, c, b] } else { [a, b, c] });
        turned.map(|of| of.map(corner)).collect()
    }

    #[test]
    fn what_lies_in_another_part_counts_once_or_is_refused() {
        let whole = || cuboid([0.0; 3], [1.0; 3], false);
        let cavity = cuboid([0.3; 3], [0.7; 3], true);
        let beside = cuboid([2.0; 3], [3.0; 3], false);
        let touching = cuboid([1.0, 0.0, 0.0], [2.0, 1.0, 1.0], false);
        for right in [
            whole(),
            [whole(), cavity.clone()].concat(),
            [whole(), beside].concat(),
            [whole(), touching].concat(),
        ] {
            assert_eq!(check(&right), Ok(()));
        }
        // Two bars that cross, neither with a corner in the other.
        let crossing = [
            cuboid([-3.0, 0.0, 0.0], [3.0, 1.0, 1.0], false),
            cuboid([0.0, -3.0, 0.2], [1.0, 3.0, 0.8], false),
        ];
        for wrong in [
            [whole(), cuboid([0.3; 3], [0.7; 3], false)].concat(),
            [whole(), cuboid([0.2; 3], [1.2; 3], false)].concat(),
            [whole(), cuboid([0.2, 0.0, 0.0], [1.2, 1.0, 1.0], false)].concat(),
            [whole(), whole()].concat(),
            [cavity, whole(), whole()].concat(),
            crossing.concat(),
        ] {
            let checked = check(&wrong);
            assert!(
                matches!(checked, Err(ShapeError::Overlapping { share }) if share > SHARE),
                "{checked:?}"
            );
        }
    }
}
