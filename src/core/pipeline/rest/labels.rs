//! Labels that are free: a body that looks and moves the same after a turn may have its faces'
//! labels turned, and then performs the same motion with another face up. To the estimation that is
//! another mount of its tracker.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::math::Pose;
use crate::motion::{EventKind, Feature, Link, LinkIndex, Partner, Scene};
use crate::physics::contact;

/// Greatest distance of features that count as one \[m\].
const SAME_M: f64 = 1e-7;
/// Greatest difference of moments that count as equal, relative to the largest.
const SAME_MOMENT: f64 = 1e-9;

/// The turns of a link, identity left out, after which its moments and all of its features are where
/// they were: of those that permute its axes.
pub(super) fn turns(link: &Link) -> Vec<UnitQuaternion<f64>> {
    let all = axis_permutations();
    let kept = all.into_iter().filter(|turn| is_symmetry(link, turn));
    kept.collect()
}

/// The scene with the labels of a link turned: what it calls `p` is where `turn·p` was. `None` where
/// a feature has no counterpart.
pub(super) fn relabelled(
    scene: &Scene,
    link: LinkIndex,
    turn: &UnitQuaternion<f64>,
) -> Option<Scene> {
    let mut relabelled = scene.clone();
    for track in &mut relabelled.tracks {
        if track.link == link {
            track.link_from_tracker = turned(&turn.inverse()) * track.link_from_tracker;
        }
    }
    let features = &scene.links[link].features;
    let new = |feature: &mut Option<usize>| {
        let Some(old) = *feature else { return true };
        *feature = counterpart(features, old, &turn.inverse());
        feature.is_some()
    };
    for event in &mut relabelled.events {
        let (EventKind::Collision(collision)
        | EventKind::Collisions {
            each: collision, ..
        }) = &mut event.kind
        else {
            continue;
        };
        let (is_own, is_other) = (
            collision.link == link,
            collision.partner == Partner::Link(link),
        );
        for touching in &mut collision.contacts {
            let is_known =
                (!is_own || new(&mut touching.feature)) && (!is_other || new(&mut touching.other));
            if !is_known {
                return None;
            }
        }
    }
    Some(relabelled)
}

fn is_symmetry(link: &Link, turn: &UnitQuaternion<f64>) -> bool {
    let moments = link.body.moments_kg_m2();
    let matrix = turn.to_rotation_matrix();
    let tensor = matrix * Matrix3::from_diagonal(&moments) * matrix.transpose();
    let is_inert =
        (tensor - Matrix3::from_diagonal(&moments)).amax() <= SAME_MOMENT * moments.amax();
    let shape = link.shape.features().unwrap_or_default();
    let shape = shape
        .into_iter()
        .map(|(name, geometry)| Feature { name, geometry });
    let shape: Vec<Feature> = shape.collect();
    let is_whole = |features: &[Feature]| {
        (0..features.len()).all(|at| counterpart(features, at, turn).is_some())
    };
    is_inert && is_whole(&shape) && is_whole(&link.features)
}

/// The feature that lies where a turn brings one.
fn counterpart(features: &[Feature], at: usize, turn: &UnitQuaternion<f64>) -> Option<usize> {
    let placed = features[at].geometry.placed(&turned(turn));
    let mut all = features.iter();
    all.position(|feature| coincide(&feature.geometry, &placed))
}

fn coincide(a: &contact::Feature, b: &contact::Feature) -> bool {
    use contact::Feature::{Face, Line, Point, Rim};
    let near = |a: &Vector3<f64>, b: &Vector3<f64>| (a - b).norm() <= SAME_M;
    let same = |a: f64, b: f64| (a - b).abs() <= SAME_M;
    match (a, b) {
        (
            Point {
                point_m: p,
                radius_m: r,
            },
            Point {
                point_m: q,
                radius_m: s,
            },
        ) => near(p, q) && same(*r, *s),
        (
            Line {
                point_m: p,
                direction: d,
                radius_m: r,
            },
            Line {
                point_m: q,
                direction: e,
                radius_m: s,
            },
        ) => d.cross(e).norm() <= SAME_M && (p - q).cross(d).norm() <= SAME_M && same(*r, *s),
        (
            Rim {
                centre_m: p,
                axis: d,
                radius_m: r,
            },
            Rim {
                centre_m: q,
                axis: e,
                radius_m: s,
            },
        ) => near(p, q) && near(d, e) && same(*r, *s),
        (
            Face {
                point_m: p,
                normal: d,
            },
            Face {
                point_m: q,
                normal: e,
            },
        ) => near(d, e) && same((p - q).dot(d), 0.0),
        _ => false,
    }
}

fn turned(turn: &UnitQuaternion<f64>) -> Pose {
    Pose::from_parts(Vector3::zeros().into(), *turn)
}

/// The rotations that bring axes to axes, but for the identity: 23.
fn axis_permutations() -> Vec<UnitQuaternion<f64>> {
    let axes = || (0..6).map(|k| Vector3::ith(k / 2, if k % 2 == 0 { 1.0 } else { -1.0 }));
    let pairs = axes().flat_map(|x| axes().map(move |y| (x, y)));
    let square = pairs.filter(|(x, y)| x.dot(y) == 0.0);
    let turns = square.map(|(x, y)| {
        let matrix = Matrix3::from_columns(&[x, y, x.cross(&y)]);
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix))
    });
    turns.filter(|turn| turn.angle() > 1.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::scene_from_toml;

    fn scene(shape: &str, extra: &str) -> Scene {
        let text = format!(
            "name = \"roll\"\n[timing]\nstamps = \"physical\"\n[[body]]\nname = \"die\"\n\
             shape = {shape}\nmass_g = 5\n{extra}\n[[surface]]\nname = \"table\"\n\
             point_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n[[event]]\nname = \"bounce\"\n\
             kind = \"collision\"\nbody = \"die\"\nfeature = \"corner -x -y -z\"\n\
             surface = \"table\"\nrestitution = 0.5\n"
        );
        scene_from_toml(&text).unwrap()
    }

    #[test]
    fn as_many_turns_as_the_body_is_symmetric() {
        let count = |shape, extra| {
            let scene = scene(shape, extra);
            turns(&scene.links[LinkIndex(0)]).len()
        };
        let die = "{ kind = \"cuboid\", size_mm = [16, 16, 16] }";
        assert_eq!(count(die, ""), 23);
        assert_eq!(
            count("{ kind = \"cuboid\", size_mm = [16, 16, 20] }", ""),
            7
        );
        assert_eq!(
            count("{ kind = \"cuboid\", size_mm = [12, 16, 20] }", ""),
            3
        );
        // Loaded, or with a nick in one edge.
        assert_eq!(count(die, "moments_kg_m2 = [2e-7, 2e-7, 3e-7]"), 7);
        assert_eq!(count(die, "[body.features_mm]\nnick = [8, 8, 7]"), 0);
    }

    #[test]
    fn a_relabelled_body_is_seen_and_touches_where_it_was() {
        let scene = scene("{ kind = \"cuboid\", size_mm = [16, 16, 16] }", "");
        let link = LinkIndex(0);
        for turn in turns(&scene.links[link]) {
            let other = relabelled(&scene, link, &turn).unwrap();
            let tracks = scene.tracks.iter().zip(&other.tracks);
            for (old, new) in tracks {
                let back = turned(&turn) * new.link_from_tracker;
                assert!(
                    (back.to_homogeneous() - old.link_from_tracker.to_homogeneous()).amax() < 1e-12
                );
            }
            let touching = |scene: &Scene| {
                let collision = scene.events[0].kind.collision().unwrap();
                scene.links[link].features[collision.contacts[0].feature.unwrap()].geometry
            };
            assert!(coincide(
                &touching(&other).placed(&turned(&turn)),
                &touching(&scene)
            ));
        }
    }
}
