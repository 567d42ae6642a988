//! The features of a shape by which it may touch others, each with a name.
//!
//! Names are readable and the same for the same shape: `corner +x -y +z`, `edge +x +y` (the one
//! between those faces), `face -z`, `rim +z` and `end +z` of a cylinder, `end +z` of a capsule,
//! `side`, `apex`, `ball`; of a hull `corner 3`, `edge 1-3` and `face 0-1-3`, by the places of
//! its points in their list. A compound has the features that it was made with.

use nalgebra::Vector3;

use super::contact::Feature;
use super::shape::{Shape, ShapeError, hull_triangles};

/// Greatest distance of points of a hull from a plane on which they count as lying, relative to the
/// hull's size: the error of coordinates typed with six digits.
const FLATNESS: f64 = 1e-6;

/// A feature and its name.
pub type NamedFeature = (String, Feature);

impl Shape {
    /// Its features in its own axes: corners, edges and rims, faces, in this order.
    ///
    /// The slanted side of a cone is no supported feature and left out. Fails where the
    /// shape is no solid.
    pub fn features(&self) -> Result<Vec<NamedFeature>, ShapeError> {
        self.check()?;
        Ok(match self {
            Shape::Cuboid { half_extents_m } => of_box(half_extents_m, 0.0),
            Shape::RoundedCuboid {
                half_extents_m,
                radius_m,
            } => of_box(half_extents_m, *radius_m),
            Shape::Sphere { radius_m } => vec![("ball".into(), point(Vector3::zeros(), *radius_m))],
            Shape::Cylinder {
                half_length_m,
                radius_m,
            } => {
                let ends = [(1.0, "+z"), (-1.0, "-z")];
                let mut features = Vec::new();
                for (sign, name) in ends {
                    let centre = Vector3::z() * (sign * half_length_m);
                    let rim = rim(centre, sign, *radius_m);
                    features.push((format!("rim {name}"), rim));
                }
                features.push(("side".into(), side(*radius_m)));
                for (sign, name) in ends {
                    let centre = Vector3::z() * (sign * half_length_m);
                    let end = face(centre, Vector3::z() * sign);
                    features.push((format!("end {name}"), end));
                }
                features
            }
            Shape::Capsule {
                half_length_m,
                radius_m,
            } => vec![
                (
                    "end +z".into(),
                    point(Vector3::z() * *half_length_m, *radius_m),
                ),
                (
                    "end -z".into(),
                    point(Vector3::z() * -half_length_m, *radius_m),
                ),
                ("side".into(), side(*radius_m)),
            ],
            Shape::Cone {
                half_height_m,
                radius_m,
            } => {
                // The origin is a quarter of the height above the base.
                let base = Vector3::z() * (-0.5 * half_height_m);
                let apex = Vector3::z() * (1.5 * half_height_m);
                vec![
                    ("apex".into(), point(apex, 0.0)),
                    ("rim -z".into(), rim(base, -1.0, *radius_m)),
                    ("end -z".into(), face(base, -Vector3::z())),
                ]
            }
            Shape::Hull { points_m } => of_hull(points_m)?,
            Shape::Compound(compound) => compound.features.clone(),
        })
    }
}

fn point(point_m: Vector3<f64>, radius_m: f64) -> Feature {
    Feature::Point { point_m, radius_m }
}

fn face(point_m: Vector3<f64>, normal: Vector3<f64>) -> Feature {
    Feature::Face { point_m, normal }
}

fn rim(centre_m: Vector3<f64>, sign: f64, radius_m: f64) -> Feature {
    Feature::Rim {
        centre_m,
        axis: Vector3::z() * sign,
        radius_m,
    }
}

fn side(radius_m: f64) -> Feature {
    Feature::Line {
        point_m: Vector3::zeros(),
        direction: Vector3::z(),
        radius_m,
    }
}

/// Eight corners, twelve edges, six faces; with a radius, corners and edges are balls and tubes of
/// that radius inside the box.
fn of_box(half_extents_m: &Vector3<f64>, radius_m: f64) -> Vec<NamedFeature> {
    const AXES: [&str; 3] = ["x", "y", "z"];
    let core = half_extents_m.add_scalar(-radius_m);
    let sign_name = |sign: f64| if sign > 0.0 { "+" } else { "-" };
    let mut features = Vec::new();
    for corner in 0..8 {
        let sign = Vector3::from_fn(|axis, _| if corner >> axis & 1 == 0 { 1.0 } else { -1.0 });
        let [x, y, z] = [0, 1, 2].map(|axis| sign_name(sign[axis]));
        let name = format!("corner {x}x {y}y {z}z");
        features.push((name, point(core.component_mul(&sign), radius_m)));
    }
    for along in (0..3).rev() {
        let (first, second) = [(1, 2), (0, 2), (0, 1)][along];
        for (s, t) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
            let mut point_m = Vector3::zeros();
            point_m[first] = s * core[first];
            point_m[second] = t * core[second];
            let name = format!(
                "edge {}{} {}{}",
                sign_name(s),
                AXES[first],
                sign_name(t),
                AXES[second]
            );
            let edge = Feature::Line {
                point_m,
                direction: Vector3::ith(along, 1.0),
                radius_m,
            };
            features.push((name, edge));
        }
    }
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let normal = Vector3::ith(axis, sign);
            let name = format!("face {}{}", sign_name(sign), AXES[axis]);
            features.push((name, face(normal * half_extents_m[axis], normal)));
        }
    }
    features
}

/// A flat side of a hull.
struct Flat {
    normal: Vector3<f64>,
    /// Indices of the points on it, in order.
    points: Vec<usize>,
}

/// Corners, edges and faces of a hull; coplanar triangles form one face.
fn of_hull(points_m: &[Vector3<f64>]) -> Result<Vec<NamedFeature>, ShapeError> {
    let flats = flats(points_m)?;
    let mut edges = Vec::new();
    for (index, flat) in flats.iter().enumerate() {
        for other in &flats[..index] {
            let shared: Vec<usize> = flat
                .points
                .iter()
                .copied()
                .filter(|point| other.points.contains(point))
                .collect();
            edges.extend(farthest_pair(points_m, &shared));
        }
    }
    edges.sort_unstable();
    edges.dedup();
    let mut corners: Vec<usize> = edges.iter().flat_map(|(i, j)| [*i, *j]).collect();
    corners.sort_unstable();
    corners.dedup();
    let corners = corners
        .into_iter()
        .map(|i| (format!("corner {i}"), point(points_m[i], 0.0)));
    let edges = edges.into_iter().map(|(i, j)| {
        let edge = Feature::Line {
            point_m: points_m[i],
            direction: (points_m[j] - points_m[i]).normalize(),
            radius_m: 0.0,
        };
        (format!("edge {i}-{j}"), edge)
    });
    let faces = flats.iter().map(|flat| {
        let names: Vec<String> = flat.points.iter().map(usize::to_string).collect();
        let on_it = points_m[flat.points[0]];
        (
            format!("face {}", names.join("-")),
            face(on_it, flat.normal),
        )
    });
    Ok(corners.chain(edges).chain(faces).collect())
}

/// The flat faces of a hull, found from its largest triangles down: slivers determine a plane
/// worst.
fn flats(points_m: &[Vector3<f64>]) -> Result<Vec<Flat>, ShapeError> {
    let size_m = points_m.iter().map(|p| p.norm()).fold(0.0, f64::max);
    let index_of = |corner: &Vector3<f64>| {
        let distance_m = |i: &usize| (points_m[*i] - corner).norm();
        (0..points_m.len()).min_by(|i, j| distance_m(i).total_cmp(&distance_m(j)))
    };
    let mut triangles: Vec<(f64, Vector3<f64>, Vec<usize>)> = hull_triangles(points_m)?
        .iter()
        .map(|[a, b, c]| {
            let across = (b - a).cross(&(c - a));
            let corners = [a, b, c].into_iter().filter_map(index_of).collect();
            (across.norm(), across, corners)
        })
        .filter(|(area, ..)| *area > 0.0)
        .collect();
    triangles.sort_by(|s, t| t.0.total_cmp(&s.0).then_with(|| s.2.cmp(&t.2)));
    let mut flats: Vec<Flat> = Vec::new();
    for (area, across, corners) in triangles {
        let is_known = |flat: &Flat| corners.iter().all(|i| flat.points.contains(i));
        if flats.iter().any(is_known) {
            continue;
        }
        let normal = across / area;
        let height_m = normal.dot(&points_m[corners[0]]);
        let points = (0..points_m.len())
            .filter(|i| (normal.dot(&points_m[*i]) - height_m).abs() <= FLATNESS * size_m)
            .collect();
        flats.push(Flat { normal, points });
    }
    flats.sort_by(|s, t| s.points.cmp(&t.points));
    Ok(flats)
}

/// The two ends of the line that some points lie on.
fn farthest_pair(points_m: &[Vector3<f64>], among: &[usize]) -> Option<(usize, usize)> {
    let length_m = |(i, j): &(usize, usize)| (points_m[*i] - points_m[*j]).norm();
    among
        .iter()
        .flat_map(|i| among.iter().map(move |j| (*i, *j)))
        .filter(|(i, j)| i < j)
        .max_by(|s, t| length_m(s).total_cmp(&length_m(t)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Pose;
    use crate::physics::contact::{Contact, Frame};

    fn names(features: &[NamedFeature]) -> Vec<&str> {
        features.iter().map(|(name, _)| name.as_str()).collect()
    }

    fn find(features: &[NamedFeature], name: &str) -> Feature {
        let found = features.iter().find(|(known, _)| known == name);
        found
            .unwrap_or_else(|| panic!("no {name} in {:?}", names(features)))
            .1
    }

    #[test]
    fn a_box_has_corners_edges_and_faces() {
        let half_extents_m = Vector3::new(0.1, 0.2, 0.3);
        let features = Shape::Cuboid { half_extents_m }.features().expect("box");
        assert_eq!(features.len(), 8 + 12 + 6);
        let mut unique = names(&features);
        unique.sort_unstable();
        unique.dedup();
        assert_eq!(unique.len(), features.len());
        assert_eq!(
            find(&features, "corner +x -y +z"),
            point(Vector3::new(0.1, -0.2, 0.3), 0.0)
        );
        assert_eq!(
            find(&features, "edge -x +z"),
            Feature::Line {
                point_m: Vector3::new(-0.1, 0.0, 0.3),
                direction: Vector3::y(),
                radius_m: 0.0
            }
        );
        assert_eq!(
            find(&features, "face -z"),
            face(Vector3::new(0.0, 0.0, -0.3), -Vector3::z())
        );
    }

    #[test]
    fn round_solids_have_what_their_names_say() {
        let of = |shape: Shape| shape.features().expect("a solid");
        let radius_m = 0.02;
        let cylinder = of(Shape::Cylinder {
            half_length_m: 0.1,
            radius_m,
        });
        let expected = ["rim +z", "rim -z", "side", "end +z", "end -z"];
        assert_eq!(names(&cylinder), expected);
        let capsule = of(Shape::Capsule {
            half_length_m: 0.1,
            radius_m,
        });
        assert_eq!(names(&capsule), ["end +z", "end -z", "side"]);
        assert_eq!(names(&of(Shape::Sphere { radius_m })), ["ball"]);
        let cone = of(Shape::Cone {
            half_height_m: 0.5,
            radius_m,
        });
        assert_eq!(names(&cone), ["apex", "rim -z", "end -z"]);
        assert_eq!(
            find(&cone, "apex"),
            point(Vector3::new(0.0, 0.0, 0.75), 0.0)
        );
    }

    #[test]
    fn a_hull_of_a_box_with_points_on_its_sides_is_the_box() {
        let half = Vector3::new(0.1, 0.2, 0.3);
        let mut points_m: Vec<Vector3<f64>> = Shape::Cuboid {
            half_extents_m: half,
        }
        .features()
        .expect("box")
        .iter()
        .filter_map(|(_, feature)| match feature {
            Feature::Point { point_m, .. } => Some(*point_m),
            _ => None,
        })
        .collect();
        // In the middle of an edge, and of a face.
        points_m.push(Vector3::new(0.1, 0.2, 0.0));
        points_m.push(Vector3::new(0.1, 0.0, 0.0));
        let features = Shape::Hull { points_m }.features().expect("hull");
        let count = |kind: &str| features.iter().filter(|(_, f)| f.kind() == kind).count();
        assert_eq!((count("point"), count("line"), count("face")), (8, 12, 6));
        for (name, feature) in &features {
            assert_eq!(feature.check(), Ok(()), "{name}");
            if let Feature::Face { point_m, normal } = feature {
                assert!(normal.dot(point_m) > 0.0, "{name} looks inward");
                assert!((normal.amax() - 1.0).abs() < 1e-12, "{name}");
            }
        }
    }

    #[test]
    fn a_tetrahedron_has_the_names_of_its_points() {
        let points_m = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
            .map(|p| Vector3::from(p).map(f64::from))
            .to_vec();
        let features = Shape::Hull { points_m }.features().expect("hull");
        assert_eq!(
            names(&features),
            [
                "corner 0",
                "corner 1",
                "corner 2",
                "corner 3",
                "edge 0-1",
                "edge 0-2",
                "edge 0-3",
                "edge 1-2",
                "edge 1-3",
                "edge 2-3",
                "face 0-1-2",
                "face 0-1-3",
                "face 0-2-3",
                "face 1-2-3",
            ]
        );
    }

    /// The nearest corner's gap to a table is parry's distance of the rounded box.
    #[test]
    fn a_rounded_corner_is_as_far_as_the_rounded_box() {
        let shape = Shape::RoundedCuboid {
            half_extents_m: Vector3::new(0.1, 0.2, 0.3),
            radius_m: 0.03,
        };
        let table = Shape::Cuboid {
            half_extents_m: Vector3::new(2.0, 2.0, 0.5),
        };
        let below = Pose::translation(0.0, 0.0, -0.5);
        let top = face(Vector3::zeros(), Vector3::z());
        for (z, tolerance) in [(0.5, 1e-9), (0.375, 1e-6)] {
            let pose = Pose::new(Vector3::new(0.1, 0.0, z), Vector3::new(0.5, 0.3, 0.2));
            let frame = Frame {
                position_m: pose.translation.vector,
                orientation: pose.rotation,
            };
            let gap_m = shape
                .features()
                .expect("box")
                .iter()
                .filter(|(name, _)| name.starts_with("corner"))
                .map(|(_, corner)| {
                    let contact = Contact::new(*corner, top).expect("known");
                    let touch = contact.touch(&frame, &Frame::world()).expect("regular");
                    touch.gap_m
                })
                .fold(f64::INFINITY, f64::min);
            let distance_m = shape.distance_m(&pose, &table, &below).expect("solids");
            assert!(
                (gap_m - distance_m).abs() < tolerance,
                "{gap_m} {distance_m}"
            );
        }
    }
}
