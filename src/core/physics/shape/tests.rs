use super::*;
use crate::math::Pose;
use crate::physics::body::{BodyError, Symmetry};
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;

fn close(a: f64, b: f64) {
    assert!(
        (a - b).abs() <= 1e-13 * b.abs().max(1e-12),
        "{a:e} against {b:e}"
    );
}

fn cylinder() -> Shape {
    Shape::Cylinder {
        half_length_m: 0.095,
        radius_m: 0.00375,
    }
}

fn box_points(half: [f64; 3], about: Vector3<f64>) -> Vec<Vector3<f64>> {
    (0..8)
        .map(|corner| {
            let sign = |axis: usize| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 };
            about + Vector3::new(sign(0) * half[0], sign(1) * half[1], sign(2) * half[2])
        })
        .collect()
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_parts(Translation3::new(x, y, z), UnitQuaternion::identity())
}

#[test]
fn moments_of_every_solid_agree_with_the_closed_formulas() {
    use std::f64::consts::PI;
    let (a, b, c) = (0.03, 0.05, 0.07);
    let cases: [(Shape, f64, [f64; 3]); 5] = [
        (
            Shape::Cuboid {
                half_extents_m: Vector3::new(a, b, c),
            },
            8.0 * a * b * c,
            [
                (b * b + c * c) / 3.0,
                (a * a + c * c) / 3.0,
                (a * a + b * b) / 3.0,
            ],
        ),
        (
            Shape::Sphere { radius_m: a },
            4.0 / 3.0 * PI * a.powi(3),
            [0.4 * a * a; 3],
        ),
        (
            Shape::Cylinder {
                half_length_m: c,
                radius_m: a,
            },
            2.0 * c * PI * a * a,
            {
                let transverse = a * a / 4.0 + c * c / 3.0;
                [transverse, transverse, a * a / 2.0]
            },
        ),
        (
            Shape::Capsule {
                half_length_m: c,
                radius_m: a,
            },
            2.0 * c * PI * a * a + 4.0 / 3.0 * PI * a.powi(3),
            {
                let (tube, caps) = (2.0 * c * PI * a * a, 4.0 / 3.0 * PI * a.powi(3));
                // Two half balls, each with its centre of mass 3/8 of the radius out.
                let transverse = tube * (a * a / 4.0 + c * c / 3.0)
                    + caps * (0.4 * a * a + c * c + 0.75 * c * a);
                let axial = tube * a * a / 2.0 + caps * 0.4 * a * a;
                let mass = tube + caps;
                [transverse / mass, transverse / mass, axial / mass]
            },
        ),
        (
            Shape::Cone {
                half_height_m: c,
                radius_m: a,
            },
            2.0 * c * PI * a * a / 3.0,
            {
                let transverse = 3.0 / 20.0 * a * a + 3.0 / 80.0 * 4.0 * c * c;
                [transverse, transverse, 0.3 * a * a]
            },
        ),
    ];
    for (shape, volume_m3, moments_m2) in cases {
        let uniform = shape.uniform_mass().unwrap();
        close(uniform.volume_m3, volume_m3);
        for (computed, formula) in uniform.moments_per_mass_m2.iter().zip(moments_m2) {
            close(*computed, formula);
        }
    }
}

#[test]
fn transverse_moments_are_equal_exactly() {
    for shape in [
        cylinder(),
        Shape::Capsule {
            half_length_m: 0.0123,
            radius_m: 0.00457,
        },
        Shape::Cone {
            half_height_m: 0.0123,
            radius_m: 0.0777,
        },
    ] {
        let moments = shape.uniform_mass().unwrap().moments_per_mass_m2;
        assert_eq!(moments.x, moments.y);
        assert_eq!(
            shape.body_of_mass_kg(0.006).unwrap().symmetry(),
            Symmetry::Axial { axis: 2 }
        );
    }
}

#[test]
fn density_gives_mass() {
    let cube = Shape::Cuboid {
        half_extents_m: Vector3::repeat(0.05),
    };
    let body = cube.body_of_density_kg_m3(500.0).unwrap();
    close(body.mass_kg(), 0.5);
    close(body.moments_kg_m2().x, 0.5 * 0.01 / 6.0);
    assert_eq!(body.symmetry(), Symmetry::Spherical);
    assert!(matches!(
        cube.body_of_density_kg_m3(-1.0),
        Err(ShapeError::Body(BodyError::Mass { .. }))
    ));
}

#[test]
fn a_hull_of_a_box_is_the_box() {
    let hull = Shape::Hull {
        points_m: box_points([0.03, 0.03, 0.07], Vector3::zeros()),
    };
    let cuboid = Shape::Cuboid {
        half_extents_m: Vector3::new(0.03, 0.03, 0.07),
    };
    let (h, c) = (hull.uniform_mass().unwrap(), cuboid.uniform_mass().unwrap());
    close(h.volume_m3, c.volume_m3);
    for axis in 0..3 {
        assert!(
            (h.moments_per_mass_m2[axis] / c.moments_per_mass_m2[axis] - 1.0).abs() < 1e-12,
            "{h:?} {c:?}"
        );
    }
    close(hull.radius_m(), cuboid.radius_m());
}

#[test]
fn a_hexagonal_prism_typed_to_six_digits_is_axially_symmetric() {
    let points_m = (0..12)
        .map(|i| {
            let angle = f64::from(i % 6) * std::f64::consts::FRAC_PI_3;
            let typed = |x: f64| (x * 4e3 * 1e3).round() * 1e-6;
            Vector3::new(
                typed(angle.cos()),
                typed(angle.sin()),
                if i < 6 { -0.09 } else { 0.09 },
            )
        })
        .collect();
    let body = Shape::Hull { points_m }.body_of_mass_kg(0.005).unwrap();
    assert_eq!(body.symmetry(), Symmetry::Axial { axis: 2 });
}

#[test]
fn a_hull_off_centre_says_by_how_much() {
    let shape = Shape::Hull {
        points_m: box_points([0.03; 3], Vector3::new(0.0, 0.0, 0.012)),
    };
    let error = shape.uniform_mass().unwrap_err();
    let ShapeError::OffCentre { offset_m } = &error else {
        panic!("{error}");
    };
    assert!((offset_m - Vector3::new(0.0, 0.0, 0.012)).norm() < 1e-12);
    assert!(error.to_string().contains("mm, expected the origin"));
}

#[test]
fn a_hull_off_its_principal_axes_says_so() {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.1);
    let points_m = box_points([0.02, 0.05, 0.03], Vector3::zeros())
        .iter()
        .map(|p| turn * p)
        .collect();
    let error = Shape::Hull { points_m }.uniform_mass().unwrap_err();
    let ShapeError::NotPrincipal { products_m2 } = error else {
        panic!("{error}");
    };
    // Turned by φ, the product is sin 2φ (a² − b²)/6.
    let expected = 0.5 * 0.2_f64.sin() * (0.05_f64.powi(2) - 0.02_f64.powi(2)) / 3.0;
    assert!((products_m2.z.abs() - expected).abs() < 1e-12);
    assert!(products_m2.x.abs() < 1e-12 && products_m2.y.abs() < 1e-12);
}

#[test]
fn what_is_no_solid_is_refused() {
    let points = |count: usize| {
        [
            Vector3::new(0.0, 0.0, 0.0),
            Vector3::new(0.1, 0.0, 0.0),
            Vector3::new(0.0, 0.1, 0.0),
            Vector3::new(0.1, 0.1, 1e-9),
            Vector3::new(0.03, 0.07, -1e-9),
        ][..count]
            .to_vec()
    };
    for count in 0..=5 {
        let shape = Shape::Hull {
            points_m: points(count),
        };
        assert_eq!(shape.check(), Err(ShapeError::Flat { count }));
        assert_eq!(shape.uniform_mass(), Err(ShapeError::Flat { count }));
        assert!(shape.solid().is_err());
    }
    let line = Shape::Hull {
        points_m: (0..6).map(|i| Vector3::repeat(f64::from(i))).collect(),
    };
    assert_eq!(line.check(), Err(ShapeError::Flat { count: 6 }));
    let nan = Shape::Hull {
        points_m: vec![Vector3::zeros(), Vector3::new(0.0, f64::NAN, 0.0)],
    };
    assert_eq!(nan.check(), Err(ShapeError::Point { index: 1 }));
    for value_m in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            Shape::Sphere { radius_m: value_m }.check(),
            Err(ShapeError::Length { name: "radius", .. })
        ));
        assert!(matches!(
            Shape::Cylinder {
                half_length_m: value_m,
                radius_m: 1.0
            }
            .uniform_mass(),
            Err(ShapeError::Length { name: "length", .. })
        ));
    }
}

#[test]
fn distances_are_signed_and_axes_are_z() {
    let table = Shape::Cuboid {
        half_extents_m: Vector3::new(0.5, 0.5, 0.01),
    };
    let under = at(0.0, 0.0, -0.01);
    let pencil = cylinder();
    let measure = |z: f64| pencil.distance_m(&at(0.0, 0.0, z), &table, &under).unwrap();
    assert!((measure(0.195) - 0.1).abs() < 1e-9, "{}", measure(0.195));
    assert!((measure(0.093) + 0.002).abs() < 1e-9, "{}", measure(0.093));
    let cone = Shape::Cone {
        half_height_m: 0.05,
        radius_m: 0.03,
    };
    // The base is a quarter of the height below the origin, the apex three quarters above.
    let standing = cone.distance_m(&at(0.0, 0.0, 0.1), &table, &under).unwrap();
    assert!((standing - 0.075).abs() < 1e-9, "{standing}");
    let lid = cone
        .distance_m(&at(0.0, 0.0, -0.12), &table, &under)
        .unwrap();
    assert!((lid - 0.025).abs() < 1e-9, "{lid}");
    let capsule = Shape::Capsule {
        half_length_m: 0.05,
        radius_m: 0.01,
    };
    let upright = capsule
        .distance_m(&at(0.1, 0.0, 0.1), &table, &under)
        .unwrap();
    assert!((upright - 0.04).abs() < 1e-9, "{upright}");
    let hull = Shape::Hull {
        points_m: box_points([0.02; 3], Vector3::zeros()),
    };
    let sphere = Shape::Sphere { radius_m: 0.01 };
    let apart = hull
        .distance_m(&at(0.0, 0.0, 0.0), &sphere, &at(0.05, 0.0, 0.0))
        .unwrap();
    assert!((apart - 0.02).abs() < 1e-9, "{apart}");
}

/// Every kind of solid.
fn kinds() -> Vec<Shape> {
    vec![
        Shape::Cuboid {
            half_extents_m: Vector3::new(0.02, 0.03, 0.05),
        },
        Shape::Sphere { radius_m: 0.03 },
        cylinder(),
        Shape::Capsule {
            half_length_m: 0.04,
            radius_m: 0.01,
        },
        Shape::Cone {
            half_height_m: 0.05,
            radius_m: 0.03,
        },
        Shape::Hull {
            points_m: box_points([0.02, 0.01, 0.03], Vector3::zeros()),
        },
    ]
}

fn turned(x: f64, roll: f64) -> Pose {
    Pose::from_parts(
        Translation3::new(x, 0.4 * x, -0.3 * x),
        UnitQuaternion::from_euler_angles(roll, 0.7 - roll, 2.0 * roll),
    )
}

#[test]
fn nearest_points_are_as_far_apart_as_the_solids() {
    for a in kinds() {
        for b in kinds() {
            let (one, other) = (a.solid().unwrap(), b.solid().unwrap());
            for (x, roll) in [(0.3, 0.1), (0.12, 0.9), (0.02, 0.4), (-0.2, 2.0)] {
                let (here, there) = (turned(x, roll), turned(0.0, -roll));
                let closest = one.closest(&here, &other, &there).unwrap();
                let gap_m = one.distance_m(&here, &other, &there).unwrap();
                assert!((closest.gap_m - gap_m).abs() < 1e-6, "{a:?} {b:?} {gap_m}");
                let point_m = (here * nalgebra::Point3::from(closest.point_m)).coords;
                let apart_m = (point_m - closest.other_point_m).norm();
                assert!(
                    (apart_m - gap_m.abs()).abs() < 1e-6,
                    "{a:?} {b:?}: {apart_m} {gap_m}"
                );
            }
        }
    }
}

#[test]
fn the_lowest_point_touches_a_plane_that_is_lifted_to_it() {
    let normal = Vector3::new(0.3, -0.5, 0.8).normalize();
    // A slab so wide that it is the half-space, with its upper face at the origin.
    let half_m = Vector3::new(20.0, 20.0, 1.0);
    let slab = Shape::Cuboid {
        half_extents_m: half_m,
    };
    let rotation = UnitQuaternion::rotation_between(&Vector3::z(), &normal).unwrap();
    let world_from_slab = Pose::from_parts((-normal).into(), rotation);
    for shape in kinds() {
        for (x, roll) in [(0.3, 0.1), (-0.4, 0.9), (0.05, 0.4)] {
            let (solid, pose) = (shape.solid().unwrap(), turned(x, roll));
            let lowest = solid.lowest(&pose, &Vector3::zeros(), &normal).unwrap();
            let distance_m = shape.distance_m(&pose, &slab, &world_from_slab).unwrap();
            assert!(
                (lowest.gap_m - distance_m).abs() < 1e-6,
                "{shape:?} {lowest:?} {distance_m}"
            );
            let point_m = (pose * nalgebra::Point3::from(lowest.point_m)).coords;
            assert!((normal.dot(&point_m) - lowest.gap_m).abs() < 1e-15);
            assert!(lowest.other_point_m.dot(&normal).abs() < 1e-15);
        }
    }
}

#[test]
fn a_ball_of_no_radius_is_a_point() {
    let point = Solid::ball(0.0);
    let cuboid = kinds()[0].solid().unwrap();
    for (z, gap_m) in [(0.08, 0.03), (0.05, 0.0), (0.045, -0.005)] {
        let closest = point
            .closest(&at(0.0, 0.0, z), &cuboid, &at(0.0, 0.0, 0.0))
            .unwrap();
        assert!((closest.gap_m - gap_m).abs() < 1e-12, "{closest:?}");
    }
}

#[test]
fn poses_that_are_not_finite_are_refused() {
    let sphere = Shape::Sphere { radius_m: 0.01 };
    for bad in [at(f64::NAN, 0.0, 0.0), at(0.0, f64::INFINITY, 0.0)] {
        assert_eq!(
            sphere.distance_m(&bad, &sphere, &at(0.0, 0.0, 1.0)),
            Err(ShapeError::Pose)
        );
        assert_eq!(
            sphere.distance_m(&at(0.0, 0.0, 1.0), &sphere, &bad),
            Err(ShapeError::Pose)
        );
    }
}

#[test]
fn the_ball_about_the_origin_holds_the_shape() {
    // The distance from far away along any direction is at least what the radius says.
    let speck = Shape::Sphere { radius_m: 1e-6 };
    for shape in [
        cylinder(),
        Shape::Cone {
            half_height_m: 0.01,
            radius_m: 0.07,
        },
        Shape::Capsule {
            half_length_m: 0.05,
            radius_m: 0.01,
        },
    ] {
        let mut nearest = f64::INFINITY;
        for i in 0..400 {
            let (lift, turn) = (f64::from(i % 20) / 19.0, f64::from(i / 20) * 0.33);
            let z = 2.0 * lift - 1.0;
            let r = (1.0 - z * z).max(0.0).sqrt();
            let from = at(r * turn.cos(), r * turn.sin(), z);
            let distance = shape.distance_m(&at(0.0, 0.0, 0.0), &speck, &from).unwrap();
            nearest = nearest.min(distance);
        }
        let reach = 1.0 - 1e-6 - nearest;
        assert!(reach <= shape.radius_m() + 1e-9, "{reach} {shape:?}");
        assert!(reach > 0.9 * shape.radius_m(), "{reach} {shape:?}");
    }
}

proptest! {
    #[test]
    fn any_points_make_a_hull_or_an_error(
        points in prop::collection::vec(
            prop::array::uniform3(prop_oneof![
                -1.0..1.0_f64,
                Just(0.0),
                Just(0.5),
                Just(-0.5),
                -1e-7..1e-7_f64,
                any::<f64>(),
            ]),
            0..12,
        )
    ) {
        let shape = Shape::Hull { points_m: points.into_iter().map(Vector3::from).collect() };
        let uniform = shape.uniform_mass();
        if let Ok(uniform) = &uniform {
            prop_assert!(uniform.volume_m3 > 0.0);
            prop_assert!(uniform.moments_per_mass_m2.min() > 0.0);
        }
        if let Ok(solid) = shape.solid() {
            let far = at(3.0, 0.0, 0.0);
            prop_assert!(solid.distance_m(&far, &solid, &far).is_ok());
        }
    }
}

#[test]
fn a_rounded_box_lies_between_a_box_and_a_ball() {
    let rounded = |half_extents_m, radius_m| Shape::RoundedCuboid {
        half_extents_m,
        radius_m,
    };
    let mass = |shape: &Shape| shape.uniform_mass().expect("a solid");
    let half = Vector3::new(0.02, 0.03, 0.05);
    let sharp = mass(&Shape::Cuboid {
        half_extents_m: half,
    });
    let hardly = mass(&rounded(half, 1e-9));
    assert!((hardly.volume_m3 / sharp.volume_m3 - 1.0).abs() < 1e-7);
    assert!((hardly.moments_per_mass_m2 - sharp.moments_per_mass_m2).norm() < 1e-9);
    let radius_m = 0.02;
    let ball = mass(&Shape::Sphere { radius_m });
    let nearly = mass(&rounded(Vector3::repeat(radius_m + 1e-10), radius_m));
    assert!((nearly.volume_m3 / ball.volume_m3 - 1.0).abs() < 1e-7);
    assert!((nearly.moments_per_mass_m2 - ball.moments_per_mass_m2).norm() < 1e-10);
    assert_eq!(
        rounded(half, 0.02).check(),
        Err(ShapeError::Rounding {
            radius_m: 0.02,
            half_m: 0.02
        })
    );
}

/// Against sums over a grid of midpoints.
#[test]
fn a_rounded_box_has_the_mass_of_its_points() {
    const STEPS: usize = 60;
    let (half, radius_m) = (Vector3::new(0.4, 0.5, 0.7), 0.25);
    let core = half.add_scalar(-radius_m);
    let (mut volume_m3, mut second_m5) = (0.0, Vector3::zeros());
    let cell_m3 = half.product() / (STEPS as f64).powi(3);
    for index in 0..STEPS.pow(3) {
        let at = Vector3::new(index % STEPS, index / STEPS % STEPS, index / STEPS / STEPS);
        let p = at
            .map(|i| (i as f64 + 0.5) / STEPS as f64)
            .component_mul(&half);
        if (p - core).map(|x| x.max(0.0)).norm() <= radius_m {
            volume_m3 += 8.0 * cell_m3;
            second_m5 += p.component_mul(&p) * (8.0 * cell_m3);
        }
    }
    let moments_m2 = second_m5.map(|own| second_m5.sum() - own) / volume_m3;
    let exact = Shape::RoundedCuboid {
        half_extents_m: half,
        radius_m,
    }
    .uniform_mass()
    .expect("a solid");
    assert!((exact.volume_m3 / volume_m3 - 1.0).abs() < 1e-3);
    assert!((exact.moments_per_mass_m2 - moments_m2).norm() < 1e-3 * moments_m2.norm());
}
