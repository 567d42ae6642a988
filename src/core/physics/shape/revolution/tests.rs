use super::*;

fn near(a: f64, b: f64) {
    assert!(
        (a - b).abs() <= 1e-12 * b.abs().max(1e-9),
        "{a:e} against {b:e}"
    );
}

fn of(profile_m: &[[f64; 2]], wall_m: Option<f64>) -> Revolution {
    Revolution::new(profile_m, wall_m).expect("a solid")
}

#[test]
fn cylinders_and_cones_have_the_moments_of_theirs() {
    let cylinder = of(&[[0.03, 0.0], [0.03, 0.1]], None).mass().unwrap();
    let formula = Shape::Cylinder {
        half_length_m: 0.05,
        radius_m: 0.03,
    };
    let formula = formula.uniform_mass().unwrap();
    near(cylinder.volume_m3, formula.volume_m3);
    near(cylinder.centre_m.z, 0.05);
    let cone = of(&[[0.03, -0.025], [0.0, 0.075]], None).mass().unwrap();
    let of_cone = Shape::Cone {
        half_height_m: 0.05,
        radius_m: 0.03,
    };
    let of_cone = of_cone.uniform_mass().unwrap();
    near(cone.volume_m3, of_cone.volume_m3);
    assert!(cone.centre_m.norm() < 1e-15);
    for axis in 0..3 {
        near(
            cylinder.tensor_m2[(axis, axis)],
            formula.moments_per_mass_m2[axis],
        );
        near(
            cone.tensor_m2[(axis, axis)],
            of_cone.moments_per_mass_m2[axis],
        );
    }
}

#[test]
fn a_wall_is_what_is_left_between_two_cylinders() {
    // A mug: 80 mm high, 4 mm thick.
    let mug = of(&[[0.0, 0.0], [0.04, 0.0], [0.04, 0.08]], Some(0.004));
    let filled = |radius_m: f64, from_m: f64, to_m: f64| {
        let solid = of(&[[radius_m, from_m], [radius_m, to_m]], None);
        let mass = solid.mass().unwrap();
        (mass.volume_m3, mass)
    };
    let (outer, (inner_m3, inner)) = (filled(0.04, 0.0, 0.08), filled(0.036, 0.004, 0.08));
    let expected = MassDistribution::joined(&[outer, (-inner_m3, inner)]).unwrap();
    let found = mug.mass().unwrap();
    near(found.volume_m3, expected.volume_m3);
    near(found.centre_m.z, expected.centre_m.z);
    assert!((found.tensor_m2 - expected.tensor_m2).amax() < 1e-15);
}

#[test]
fn pieces_cover_the_solid_and_leave_its_cavity() {
    let mug = of(&[[0.0, 0.0], [0.04, 0.0], [0.04, 0.08]], Some(0.004));
    let compound = mug.compound();
    let mass = Shape::Compound(compound.clone()).mass().unwrap();
    let exact = mug.mass().unwrap();
    assert!(
        (mass.volume_m3 / exact.volume_m3 - 1.0).abs() < 0.03,
        "{mass:?} {exact:?}"
    );
    assert!((mass.centre_m - exact.centre_m).norm() < 5e-4);
    let solid = Shape::Compound(compound).solid().unwrap();
    let ball = Shape::Sphere { radius_m: 0.01 }.solid().unwrap();
    let at = |x: f64, z: f64| {
        let pose = Pose::translation(x, 0.0, z);
        let closest = solid.closest(&Pose::identity(), &ball, &pose).unwrap();
        let distance_m = solid.distance_m(&Pose::identity(), &ball, &pose).unwrap();
        assert!((closest.gap_m - distance_m).abs() < 1e-6);
        distance_m
    };
    // In the middle of the cavity, over its floor, and outside: 26, 16 and 20 mm away.
    assert!(
        (at(0.0, 0.05) - 0.026).abs() < SAGITTA_M,
        "{}",
        at(0.0, 0.05)
    );
    assert!((at(0.0, 0.03) - 0.016).abs() < 1e-6, "{}", at(0.0, 0.03));
    assert!(
        (at(0.07, 0.04) - 0.02).abs() < SAGITTA_M,
        "{}",
        at(0.07, 0.04)
    );
    assert!(at(0.0, 0.01) < -0.003);
}

#[test]
fn features_are_where_the_outline_bends_and_is_level() {
    let names = |of: &Revolution| -> Vec<String> {
        of.compound()
            .features
            .into_iter()
            .map(|(name, _)| name)
            .collect()
    };
    let mug = of(&[[0.0, 0.0], [0.04, 0.0], [0.04, 0.08]], Some(0.004));
    assert_eq!(
        names(&mug),
        [
            "rim 2",
            "rim 3",
            "face 1-2",
            "side 2-3",
            "inside rim 3",
            "inside face 1-2"
        ]
    );
    let top = of(
        &[[0.0, 0.0], [0.02, 0.01], [0.005, 0.05], [0.005, 0.06]],
        None,
    );
    assert_eq!(
        names(&top),
        ["tip 1", "rim 2", "rim 4", "end 4", "side 3-4"]
    );
    let features = mug.compound().features;
    let face = features
        .iter()
        .find(|(name, _)| name == "inside face 1-2")
        .unwrap()
        .1;
    assert_eq!(face, Feature::face(Vector3::z() * 0.004, Vector3::z()));
    let rim = features.iter().find(|(name, _)| name == "rim 2").unwrap().1;
    let lower = Feature::Rim {
        centre_m: Vector3::zeros(),
        axis: -Vector3::z(),
        radius_m: 0.04,
    };
    assert_eq!(rim, lower);
}

#[test]
fn profiles_that_sweep_nothing_are_refused() {
    let refused = |profile_m: &[[f64; 2]], wall_m: Option<f64>| {
        let error = Revolution::new(profile_m, wall_m).expect_err("no solid");
        assert!(
            matches!(error, ShapeError::Profile { .. } | ShapeError::NoPart),
            "{error}"
        );
    };
    refused(&[], None);
    refused(&[[0.01, 0.0]], None);
    refused(&[[-0.01, 0.0], [0.01, 0.1]], None);
    refused(&[[0.01, 0.0], [0.01, f64::NAN]], None);
    refused(&[[0.01, 0.0], [0.01, 0.1], [0.02, 0.05]], None);
    refused(&[[0.01, 0.0], [0.01, 0.0], [0.02, 0.05]], None);
    refused(&[[0.0, 0.0], [0.04, 0.0]], None);
    // A wall thicker than the radius, and one on the outside of a bottom.
    refused(&[[0.01, 0.0], [0.01, 0.1]], Some(0.02));
    refused(&[[0.0, 0.0], [0.04, 0.0], [0.04, 0.08]], Some(0.05));
    refused(&[[0.0, 0.0], [0.0, 0.1]], Some(0.01));
}
