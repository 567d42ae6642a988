//! How much of an endless plane is drawn: as much as the motion needs.

use nalgebra::{Point3, Vector3};
use typed_index_collections::TiSlice;

use crate::math::{Pose, so3};
use crate::motion::{LinkIndex, PoseSample, Scene, Surface};

/// A plane is drawn at least this wide where nothing moves over it \[m\].
const SIDE_M: f64 = 0.5;

/// A plane whose normal is nearer to the vertical than that, as the cosine, is a floor or a table.
const LEVEL: f64 = 0.9;

/// A body is near a board where its centre is nearer than so many of its radii.
const NEAR: f64 = 1.5;

/// A rectangle of a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Where its centre is: x and y are along its sides, z is the plane's normal.
    pub world_from_patch: Pose,
    /// Its sides along x and y \[m\].
    pub sides_m: [f64; 2],
}

impl Patch {
    /// Its corners, counter-clockwise from outside \[m\].
    pub fn corners_m(&self) -> [Vector3<f64>; 4] {
        let [x_m, y_m] = self.sides_m.map(|side_m| 0.5 * side_m);
        [[-x_m, -y_m], [x_m, -y_m], [x_m, y_m], [-x_m, y_m]].map(|[x_m, y_m]| {
            let corner = Point3::new(x_m, y_m, 0.0);
            (self.world_from_patch * corner).coords
        })
    }
}

/// What is drawn of each surface of a scene; `None` of one that is no plane by itself.
///
/// Floors and tables reach as far as the motion does. Of a plane that stands otherwise, a wall or a board, only
/// what comes near it counts, or it would cut through the rest.
pub fn patches(
    scene: &Scene,
    estimates: &TiSlice<LinkIndex, Vec<PoseSample>>,
) -> Vec<Option<Patch>> {
    let of = |surface: &Surface| {
        let (point_m, normal) = surface.plane()?;
        Some(patch(scene, estimates, point_m, normal))
    };
    scene.surfaces.iter().map(of).collect()
}

fn patch(
    scene: &Scene,
    estimates: &TiSlice<LinkIndex, Vec<PoseSample>>,
    point_m: Vector3<f64>,
    normal: Vector3<f64>,
) -> Patch {
    let turn = so3::between(&Vector3::z(), &normal);
    let up = (-scene.gravity_m_s2).try_normalize(1e-6);
    let is_level = up.is_none_or(|up| up.dot(&normal).abs() > LEVEL);
    let mut reach: Option<[Vector3<f64>; 2]> = None;
    for (link, samples) in estimates.iter_enumerated() {
        let radius_m = scene.links[link].shape.radius_m();
        for sample in samples {
            let seen_m = turn.inverse_transform_vector(&(sample.position_m - point_m));
            if is_level || seen_m.z.abs() <= NEAR * radius_m {
                let [lower_m, upper_m] = reach.unwrap_or([seen_m, seen_m]);
                let around_m = Vector3::repeat(NEAR * radius_m);
                reach = Some([
                    lower_m.inf(&(seen_m - around_m)),
                    upper_m.sup(&(seen_m + around_m)),
                ]);
            }
        }
    }
    let [lower_m, upper_m] = reach.unwrap_or_else(|| {
        let half_m = Vector3::repeat(0.5 * SIDE_M);
        [-half_m, half_m]
    });
    let centre_m = (0.5 * (lower_m + upper_m)).component_mul(&Vector3::new(1.0, 1.0, 0.0));
    let sides_m = upper_m - lower_m;
    Patch {
        world_from_patch: Pose::from_parts((point_m + turn * centre_m).into(), turn),
        sides_m: [sides_m.x, sides_m.y],
    }
}

#[cfg(test)]
mod tests {
    use typed_index_collections::TiVec;

    use super::*;
    use crate::fixture::scene;
    use crate::motion::{Stamp, Surface};
    use crate::physics::contact::Feature;

    fn poses(at_m: &[[f64; 3]]) -> TiVec<LinkIndex, Vec<PoseSample>> {
        let samples = at_m.iter().enumerate().map(|(step, at_m)| {
            PoseSample::new(
                Stamp(step as i64),
                Vector3::from(*at_m),
                [0.0, 0.0, 0.0, 1.0],
            )
        });
        [samples.collect()].into_iter().collect()
    }

    fn board(normal: [f64; 3], point_m: [f64; 3]) -> Surface {
        Surface {
            name: "board".to_owned(),
            geometry: Feature::Face {
                point_m: point_m.into(),
                normal: Vector3::from(normal).normalize(),
            },
            obstacle: None,
        }
    }

    #[test]
    fn a_table_reaches_below_all_of_the_motion() {
        let scene = scene();
        let estimates = poses(&[[0.0, 0.0, 1.0], [3.0, -1.0, 0.2]]);
        let patch = patches(&scene, &estimates)[0].expect("a plane");
        let corners_m = patch.corners_m();
        assert!(corners_m.iter().all(|corner_m| corner_m.z.abs() < 1e-12));
        let radius_m = scene.links[LinkIndex(0)].shape.radius_m();
        let beyond_m = NEAR * radius_m;
        assert!((corners_m[0] - Vector3::new(-beyond_m, -1.0 - beyond_m, 0.0)).norm() < 1e-12);
        assert!((corners_m[2] - Vector3::new(3.0 + beyond_m, beyond_m, 0.0)).norm() < 1e-12);
        // Nothing moves: it is there all the same.
        let still = patches(&scene, &poses(&[]))[0].expect("a plane");
        assert_eq!(still.sides_m, [SIDE_M; 2]);
    }

    #[test]
    fn a_board_is_where_something_comes_near_it_and_no_larger() {
        let mut scene = scene();
        scene.surfaces = vec![board([1.0, 0.0, 0.2], [2.0, 0.0, 1.0])];
        let radius_m = scene.links[LinkIndex(0)].shape.radius_m();
        let near_m = [2.0 + 0.5 * radius_m, 0.3, 1.0];
        let patch = patches(&scene, &poses(&[[-3.0, 4.0, 5.0], near_m]))[0].expect("a plane");
        assert!(
            patch
                .sides_m
                .iter()
                .all(|side_m| (side_m - 2.0 * NEAR * radius_m).abs() < 1e-9)
        );
        let centre_m = patch.world_from_patch.translation.vector;
        assert!((centre_m - Vector3::from(near_m)).norm() < radius_m);
        let normal = Vector3::new(1.0, 0.0, 0.2).normalize();
        let from_plane_m = (centre_m - Vector3::new(2.0, 0.0, 1.0)).dot(&normal);
        assert!(from_plane_m.abs() < 1e-12);
    }
}
