//! Features that the scene expects to touch, and the feature to which a point of a body belongs.

use nalgebra::Vector3;

use crate::motion::{Against, Collision, Link, LinkIndex, Partner, Scene};
use crate::physics::contact::Feature;

/// A point belongs to a feature that is nearer than this share of the body's radius: a feature may
/// simplify the shape by so much, as a pencil's tip represents the rim around it.
const NEAR: f64 = 0.1;

/// Distance below which a point lies on a feature \[m\]: a corner lies on its faces.
const ON_M: f64 = 1e-6;

/// The features of `link` that are expected to touch at a collision, by partner.
pub(super) fn expected(
    scene: &Scene,
    collision: &Collision,
    link: LinkIndex,
) -> Vec<(Against, Vec<usize>)> {
    let mut groups: Vec<(Against, Vec<usize>)> = Vec::new();
    for contact in &collision.contacts {
        let (against, feature) = match collision.partner {
            Partner::World => {
                let Some(surface) = contact.other else {
                    continue;
                };
                let against = match scene.surfaces[surface].obstacle {
                    Some(obstacle) => Against::Obstacle(obstacle),
                    None => Against::Surface(surface),
                };
                (against, contact.feature)
            }
            Partner::Link(other) if collision.link == link => {
                (Against::Link(other), contact.feature)
            }
            Partner::Link(_) => (Against::Link(collision.link), contact.other),
        };
        let Some(feature) = feature else { continue };
        match groups.iter_mut().find(|(known, _)| *known == against) {
            Some((_, features)) => features.push(feature),
            None => groups.push((against, vec![feature])),
        }
    }
    groups
}

/// Whether a point lies on a feature's surface [m, its axes].
pub(super) fn is_on(feature: &Feature, point_m: &Vector3<f64>) -> bool {
    feature.distance_m(point_m) < ON_M
}

/// The feature to which a point of the body's surface belongs: the nearest of those that are
/// declared or expected, else the nearest of the shape's own; an expected one where several are
/// equally near; `None` where none is within [`NEAR`].
pub(super) fn owner(
    link: &Link,
    is_declared: &[bool],
    expected: &[usize],
    point_m: &Vector3<f64>,
) -> Option<usize> {
    let near_m = NEAR * link.shape.radius_m();
    (0..link.features.len())
        .map(|feature| {
            let distance_m = link.features[feature].geometry.distance_m(point_m);
            let distance_m = if distance_m < ON_M { 0.0 } else { distance_m };
            let is_expected = expected.contains(&feature);
            let is_own = !is_expected && !is_declared[feature];
            (is_own, distance_m, !is_expected, feature)
        })
        .filter(|(_, distance_m, _, _)| *distance_m <= near_m)
        .min_by(|a, b| {
            let nearer = a.0.cmp(&b.0).then(a.1.total_cmp(&b.1));
            nearer.then(a.2.cmp(&b.2))
        })
        .map(|(_, _, _, feature)| feature)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_from_features_are_those_of_their_surfaces() {
        let z = Vector3::z();
        for (feature, point, expected) in [
            (Feature::corner(z), Vector3::new(0.0, 3.0, 5.0), 5.0),
            (
                Feature::Point {
                    point_m: z,
                    radius_m: 2.0,
                },
                Vector3::new(0.0, 0.0, 6.0),
                3.0,
            ),
            (
                Feature::Line {
                    point_m: Vector3::x(),
                    direction: z,
                    radius_m: 1.0,
                },
                Vector3::new(4.0, 0.0, 77.0),
                2.0,
            ),
            (
                Feature::Rim {
                    centre_m: z,
                    axis: z,
                    radius_m: 2.0,
                },
                Vector3::new(0.0, 5.0, 5.0),
                5.0,
            ),
            (
                Feature::Rim {
                    centre_m: z,
                    axis: z,
                    radius_m: 2.0,
                },
                z,
                2.0,
            ),
            (
                Feature::face(Vector3::z(), Vector3::z()),
                Vector3::new(9.0, 9.0, 4.0),
                3.0,
            ),
        ] {
            assert!((feature.distance_m(&point) - expected).abs() < 1e-14);
        }
    }
}
