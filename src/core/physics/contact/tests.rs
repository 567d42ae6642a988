use nalgebra::{UnitQuaternion, Vector3};

use super::*;
use crate::math::{differentiate, so3};

fn point(x: f64, y: f64, z: f64, radius_m: f64) -> Feature {
    Feature::Point {
        point_m: Vector3::new(x, y, z),
        radius_m,
    }
}

fn line(at: [f64; 3], along: [f64; 3], radius_m: f64) -> Feature {
    Feature::Line {
        point_m: at.into(),
        direction: Vector3::from(along).normalize(),
        radius_m,
    }
}

fn face(at: [f64; 3], normal: [f64; 3]) -> Feature {
    Feature::Face {
        point_m: at.into(),
        normal: Vector3::from(normal).normalize(),
    }
}

fn rim(at: [f64; 3], axis: [f64; 3], radius_m: f64) -> Feature {
    Feature::Rim {
        centre_m: at.into(),
        axis: Vector3::from(axis).normalize(),
        radius_m,
    }
}

/// Every supported pair, sharp and rounded, of a size of about one metre.
fn pairs() -> Vec<(&'static str, Contact)> {
    let flat = face([0.2, -0.1, 0.3], [0.2, -0.3, 1.0]);
    let ring = rim([0.1, 0.2, -0.8], [0.1, -0.2, -1.0], 0.4);
    let (sharp, ball) = (point(0.3, -0.4, -0.9, 0.0), point(-0.2, 0.1, -0.7, 0.3));
    let edge = line([0.5, 0.1, -0.6], [0.8, 0.3, 0.1], 0.0);
    let side = line([0.02, 0.01, 0.1], [0.4, -0.7, 0.5], 0.2);
    let other = line([-0.3, 0.2, 0.7], [0.1, 0.9, -0.2], 0.0);
    [
        ("point–face", sharp, flat),
        ("ball–face", ball, flat),
        ("face–point", flat, sharp),
        ("face–ball", flat, ball),
        ("rim–face", ring, flat),
        ("face–rim", flat, ring),
        ("ball–point", ball, sharp),
        ("ball–ball", ball, point(0.1, 0.3, 0.4, 0.25)),
        ("ball–edge", ball, other),
        ("point–side", sharp, side),
        ("edge–ball", other, ball),
        ("edge–edge", edge, other),
        ("side–edge", side, other),
        (
            "side–side",
            side,
            line([0.1, 0.0, 0.2], [0.9, 0.2, 0.3], 0.15),
        ),
    ]
    .map(|(name, a, b)| (name, Contact::new(a, b).expect(name)))
    .into()
}

fn frames() -> [(Frame, Frame); 2] {
    let frame = |x: f64, y, z, r, p, w| Frame {
        position_m: Vector3::new(x, y, z),
        orientation: UnitQuaternion::from_euler_angles(r, p, w),
    };
    [
        (
            frame(0.4, -0.2, 2.1, 0.3, -0.4, 1.0),
            frame(-0.1, 0.3, -0.2, -0.2, 0.5, -0.6),
        ),
        (
            frame(-1.4, 0.9, 1.6, -0.7, 0.6, 2.5),
            frame(0.3, -0.5, 0.1, 0.4, 0.2, 0.9),
        ),
    ]
}

fn moved(frame: &Frame, d: &[f64]) -> Frame {
    Frame {
        position_m: frame.position_m + Vector3::new(d[0], d[1], d[2]),
        orientation: frame.orientation * so3::exp(&Vector3::new(d[3], d[4], d[5])),
    }
}

#[test]
fn derivatives_are_exact() {
    for (name, contact) in pairs() {
        for (a, b) in frames() {
            let (touch, exact) = contact.touch_derivative(&a, &b).expect(name);
            assert_eq!(touch, contact.touch(&a, &b).expect(name));
            let numeric = differentiate::jacobian(10, 12, |d| {
                // A quarter of the step: the curvature of unit scale is felt at 0.02.
                let d: Vec<f64> = d.iter().map(|x| 0.25 * x).collect();
                let touch = contact
                    .touch(&moved(&a, &d[..6]), &moved(&b, &d[6..]))
                    .expect(name);
                [touch.gap_m]
                    .iter()
                    .chain(&touch.normal)
                    .chain(&touch.on_a_m)
                    .chain(&touch.on_b_m)
                    .map(|x| 4.0 * x)
                    .collect()
            });
            for column in 0..12 {
                let expected: Vec<f64> = [exact.gap[column]]
                    .into_iter()
                    .chain(exact.normal.column(column).iter().copied())
                    .chain(exact.on_a.column(column).iter().copied())
                    .chain(exact.on_b.column(column).iter().copied())
                    .collect();
                for row in 0..10 {
                    let difference = (numeric[row][column] - expected[row]).abs();
                    assert!(
                        difference < 1e-8 * (1.0 + expected[row].abs()),
                        "{name}: {row} {column}: {} against {}",
                        numeric[row][column],
                        expected[row]
                    );
                }
            }
        }
    }
}

#[test]
fn the_points_are_a_gap_apart_along_the_normal() {
    for (name, contact) in pairs() {
        for (a, b) in frames() {
            let touch = contact.touch(&a, &b).expect(name);
            let on_a = a.position_m + a.orientation * touch.on_a_m;
            let on_b = b.position_m + b.orientation * touch.on_b_m;
            assert!((touch.normal.norm() - 1.0).abs() < 1e-14, "{name}");
            let apart = on_a - on_b - touch.normal * touch.gap_m;
            assert!(apart.norm() < 1e-13, "{name}: {apart}");
        }
    }
}

#[test]
fn exchanged_bodies_touch_the_same() {
    for (name, contact) in pairs() {
        // Two lines take the side of A's centre of mass, which is B's other side only where the
        // bodies lie as solids can: the next test.
        if name == "edge–edge" || name == "side–edge" {
            continue;
        }
        for (a, b) in frames() {
            let here = contact.touch(&a, &b).expect(name);
            let exchanged = Contact::new(*contact.b(), *contact.a()).expect(name);
            let there = exchanged.touch(&b, &a).expect(name);
            assert!((here.normal + there.normal).norm() < 1e-14, "{name}");
            assert!((here.gap_m - there.gap_m).abs() < 1e-14, "{name}");
            assert!((here.on_a_m - there.on_b_m).norm() < 1e-13, "{name}");
            assert!((here.on_b_m - there.on_a_m).norm() < 1e-13, "{name}");
        }
    }
}

/// An edge of a box above crosses an edge of a box below, at depths from −3 to 3 mm.
#[test]
fn the_gap_of_two_edges_goes_smoothly_through_zero() {
    let upper = line([0.0, 0.01, -0.01], [1.0, 0.0, 0.0], 0.0);
    let lower = line([0.02, 0.0, 0.03], [0.0, 1.0, 0.0], 0.0);
    for (a, b, sign) in [(upper, lower, 1.0), (lower, upper, -1.0)] {
        let contact = Contact::new(a, b).expect("edges");
        for step in -3..=3 {
            let height = 0.04 + 1e-3 * f64::from(step);
            let above = Frame {
                position_m: Vector3::new(0.0, 0.0, height),
                ..Frame::world()
            };
            let (a, b) = if sign > 0.0 {
                (above, Frame::world())
            } else {
                (Frame::world(), above)
            };
            let touch = contact.touch(&a, &b).expect("crossed");
            assert!((touch.gap_m - 1e-3 * f64::from(step)).abs() < 1e-15);
            assert!((touch.normal.z - sign).abs() < 1e-15);
        }
    }
}

#[test]
fn degenerate_poses_are_refused_by_name() {
    let here = Frame::world();
    let contact = |a, b| Contact::new(a, b).expect("known");
    let up = face([0.0; 3], [0.0, 0.0, 1.0]);
    let along_x = line([0.0, 0.1, 0.2], [1.0, 0.0, 0.0], 0.0);
    for (contact, reason) in [
        (
            contact(rim([0.0, 0.0, 0.1], [0.0, 0.0, -1.0], 0.1), up),
            Degenerate::FlatRim,
        ),
        (
            contact(along_x, line([0.3, 0.0, 0.0], [-1.0, 0.0, 0.0], 0.0)),
            Degenerate::ParallelLines,
        ),
        (
            contact(point(0.7, 0.1, 0.2, 0.1), along_x),
            Degenerate::Coincident,
        ),
        (
            contact(point(0.1, 0.2, 0.3, 0.1), point(0.1, 0.2, 0.3, 0.0)),
            Degenerate::Coincident,
        ),
    ] {
        assert_eq!(contact.touch(&here, &here), Err(reason));
        assert_eq!(contact.touch_derivative(&here, &here), Err(reason));
    }
}

#[test]
fn pairs_that_are_not_known_say_what_to_use() {
    let flat = face([0.0; 3], [0.0, 0.0, 1.0]);
    let edge = line([0.0, 0.1, 0.0], [1.0, 0.0, 0.0], 0.0);
    let ring = rim([0.0; 3], [0.0, 0.0, 1.0], 0.1);
    let sharp = point(0.1, 0.1, 0.1, 0.0);
    let refusal = |a, b| {
        let there = Contact::new(a, b).expect_err("refused").to_string();
        let back = Contact::new(b, a).expect_err("refused").to_string();
        assert_eq!(there.split(": ").nth(1), back.split(": ").nth(1));
        there
    };
    assert_eq!(
        refusal(edge, flat),
        "a line against a face is not supported: use one end of the line as a point, or both ends at once where it lands flat"
    );
    assert_eq!(
        refusal(flat, flat),
        "a face against a face is not supported: use one corner of a face as a point, or three corners at once where it lands flat"
    );
    for other in [sharp, edge, ring] {
        assert!(refusal(ring, other).ends_with(
            "use the face that the rim bounds, or the side beside it as a line with a radius"
        ));
    }
    for other in [sharp, edge] {
        assert!(refusal(sharp, other).ends_with(
            "has no normal: give one of them a radius, or use the face or the edge beside it"
        ));
    }
    let through = line([0.5, 0.0, 0.0], [1.0, 0.0, 0.0], 0.0);
    assert_eq!(
        Contact::new(through, edge),
        Err(ContactError::LineThroughCentre)
    );
    assert!(matches!(
        Contact::new(point(f64::NAN, 0.0, 0.0, 0.0), flat),
        Err(ContactError::NotFinite { kind: "point" })
    ));
    assert!(matches!(
        Contact::new(point(0.0, 0.0, 0.0, -1.0), flat),
        Err(ContactError::Radius { .. })
    ));
    let long = Feature::Face {
        point_m: Vector3::zeros(),
        normal: Vector3::new(0.0, 0.0, 2.0),
    };
    assert!(matches!(
        Contact::new(sharp, long),
        Err(ContactError::NotUnit { kind: "face", .. })
    ));
}

/// Solids against a large table, and against each other, measured by parry.
mod against_parry {
    use nalgebra::Translation3;

    use super::*;
    use crate::math::Pose;
    use crate::physics::Shape;

    fn pose(frame: &Frame) -> Pose {
        Pose::from_parts(Translation3::from(frame.position_m), frame.orientation)
    }

    fn table() -> (Shape, Frame, Feature) {
        let shape = Shape::Cuboid {
            half_extents_m: Vector3::new(2.0, 2.0, 0.5),
        };
        let frame = Frame {
            position_m: Vector3::new(0.1, -0.2, 0.3),
            orientation: UnitQuaternion::from_euler_angles(0.2, -0.1, 0.4),
        };
        (shape, frame, face([0.0, 0.0, 0.5], [0.0, 0.0, 1.0]))
    }

    /// A body over the table, tilted, its centre `height` above it.
    fn over(table: &Frame, height: f64) -> Frame {
        Frame {
            position_m: table.position_m
                + table.orientation * Vector3::new(0.05, 0.1, 0.5 + height),
            orientation: UnitQuaternion::from_euler_angles(0.5, 0.3, 1.1),
        }
    }

    fn agree(shape: &Shape, feature: Feature, heights: &[f64], tolerance: f64) {
        let (slab, frame, top) = table();
        for height in heights {
            let body = over(&frame, *height);
            let touch = Contact::new(feature, top)
                .map(|contact| contact.touch(&body, &frame))
                .expect("known")
                .expect("regular");
            let distance_m = shape
                .distance_m(&pose(&body), &slab, &pose(&frame))
                .expect("solids");
            assert!(
                (touch.gap_m - distance_m).abs() < tolerance,
                "{shape:?} at {height}: {} against {distance_m}",
                touch.gap_m
            );
        }
    }

    #[test]
    fn balls_corners_and_rims_on_a_table() {
        let radius_m = 0.1;
        let ball = point(0.0, 0.0, 0.0, radius_m);
        agree(&Shape::Sphere { radius_m }, ball, &[0.3, 0.11, 0.09], 1e-12);
        let cylinder = Shape::Cylinder {
            half_length_m: 0.2,
            radius_m,
        };
        let down = rim([0.0, 0.0, -0.2], [0.0, 0.0, -1.0], radius_m);
        agree(&cylinder, down, &[0.6, 0.3], 1e-6);
        let capsule = Shape::Capsule {
            half_length_m: 0.2,
            radius_m,
        };
        agree(&capsule, point(0.0, 0.0, -0.2, radius_m), &[0.6, 0.3], 1e-9);
        let cone = Shape::Cone {
            half_height_m: 0.2,
            radius_m,
        };
        let base = rim([0.0, 0.0, -0.1], [0.0, 0.0, -1.0], radius_m);
        agree(&cone, base, &[0.6, 0.3], 1e-6);
    }

    #[test]
    fn a_side_against_a_ball_and_against_a_side() {
        let (half_length_m, radius_m) = (0.6, 0.1);
        let capsule = Shape::Capsule {
            half_length_m,
            radius_m,
        };
        let side = line([0.0; 3], [0.0, 0.0, 1.0], radius_m);
        let ball = Shape::Sphere { radius_m: 0.2 };
        let lying = Frame {
            position_m: Vector3::zeros(),
            orientation: UnitQuaternion::from_euler_angles(1.4, 0.1, 0.3),
        };
        let across = Frame {
            position_m: Vector3::new(0.05, -0.1, 0.4),
            orientation: UnitQuaternion::from_euler_angles(0.1, 1.5, 0.2),
        };
        for (shape, feature) in [(&ball, point(0.0, 0.0, 0.0, 0.2)), (&capsule, side)] {
            let touch = Contact::new(feature, side)
                .expect("known")
                .touch(&across, &lying)
                .expect("regular");
            let distance_m = shape
                .distance_m(&pose(&across), &capsule, &pose(&lying))
                .expect("solids");
            assert!((touch.gap_m - distance_m).abs() < 1e-9, "{shape:?}");
        }
    }

    #[test]
    fn an_edge_across_an_edge() {
        let cube = Shape::Cuboid {
            half_extents_m: Vector3::repeat(0.1),
        };
        let quarter = std::f64::consts::FRAC_PI_4;
        let below = Frame {
            position_m: Vector3::zeros(),
            orientation: UnitQuaternion::from_axis_angle(&Vector3::x_axis(), quarter),
        };
        let above = Frame {
            position_m: Vector3::new(0.01, 0.02, 0.3),
            orientation: UnitQuaternion::from_euler_angles(0.05, quarter, 0.1),
        };
        // Uppermost edge of the lower cube, along x; lowest of the upper one, along y.
        let upper = line([0.1, 0.0, -0.1], [0.0, 1.0, 0.0], 0.0);
        let lower = line([0.0, 0.1, 0.1], [1.0, 0.0, 0.0], 0.0);
        let touch = Contact::new(upper, lower)
            .expect("known")
            .touch(&above, &below)
            .expect("crossed");
        let distance_m = cube
            .distance_m(&pose(&above), &cube, &pose(&below))
            .expect("solids");
        assert!(touch.gap_m > 0.0);
        assert!((touch.gap_m - distance_m).abs() < 1e-9, "{distance_m}");
    }
}

#[test]
fn a_face_that_is_turned_by_no_number_is_none() {
    let contact = Contact::new(
        point(0.3, -0.4, -0.9, 0.0),
        face([0.2, -0.1, 0.3], [0.2, -0.3, 1.0]),
    );
    let contact = contact.expect("a supported pair");
    assert!(contact.with_surface(0.01, [0.1, -0.2]).is_some());
    for tilt_rad in [[f64::NAN, 0.0], [0.0, f64::INFINITY], [1e300, 1e300]] {
        assert!(
            contact.with_surface(0.0, tilt_rad).is_none(),
            "{tilt_rad:?}"
        );
    }
}
