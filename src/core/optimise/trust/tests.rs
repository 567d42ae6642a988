//! Steps in a trust region against optima that are known.

use nalgebra::{DMatrix, DVector, Vector3};

use super::model::within;
use super::{Nearness, approach};
use crate::math::random::Random;
use crate::optimise::block::BlockPattern;
use crate::optimise::envelope::{Envelope, Pattern};
use crate::optimise::{Program, Structure, System};

/// The point of the unit sphere, not above a height, that is nearest to a given one in weighted axes.
struct Nearest {
    structure: Structure,
    to: Vector3<f64>,
    weights: Vector3<f64>,
    highest: f64,
}

impl Nearest {
    fn new(to: Vector3<f64>, weights: Vector3<f64>, highest: f64) -> Self {
        let couplings = (0..3).flat_map(|row| (0..=row).map(move |column| (row, column)));
        Self {
            structure: Structure {
                pattern: Pattern::new(3, couplings),
                blocks: vec![BlockPattern::dense(2, vec![0, 1, 2])],
                priced: vec![BlockPattern::default()],
            },
            to,
            weights,
            highest,
        }
    }

    fn from(&self, start: Vector3<f64>) -> (Vector3<f64>, usize) {
        let nearness = Nearness {
            steps: 60,
            decrease: 1e-10,
            violation: 1e-9,
        };
        let near = approach(self, start, &(), &nearness, &mut |_| false);
        (near.point, near.work.iterations)
    }
}

impl Program for Nearest {
    type Point = Vector3<f64>;
    type Guidance = ();

    fn structure(&self) -> &Structure {
        &self.structure
    }

    fn evaluate(&self, (): &(), point: &Vector3<f64>, system: &mut System) {
        let off = point - self.to;
        system.cost = 0.5 * off.component_mul(&self.weights).dot(&off);
        system.hessian.clear();
        for axis in 0..3 {
            system.gradient[axis] = self.weights[axis] * off[axis];
            let pattern = &self.structure.pattern;
            system.hessian.add(pattern, axis, axis, self.weights[axis]);
        }
        let (pattern, block) = (&self.structure.blocks[0], &mut system.blocks[0]);
        block.reset(pattern);
        block.values[0] = point.norm_squared() - 1.0;
        let by = 2.0 * point;
        block
            .derivatives_mut(pattern, 0)
            .copy_from_slice(by.as_slice());
        block.values[1] = point.z;
        block.bounds[1] = (f64::NEG_INFINITY, self.highest);
        block
            .derivatives_mut(pattern, 1)
            .copy_from_slice(&[0.0, 0.0, 1.0]);
    }

    fn retract(&self, from: &Vector3<f64>, step: &DVector<f64>, to: &mut Vector3<f64>) {
        *to = from + step.fixed_rows::<3>(0);
    }

    fn damping(&self) -> DVector<f64> {
        DVector::repeat(3, 10.0)
    }

    fn is_curved(&self) -> bool {
        true
    }

    fn information(&self) -> (f64, f64) {
        (1.0, 1.0)
    }

    fn add_curvature(
        &self,
        _: (&Vector3<f64>, &System),
        multipliers: &[f64],
        hessian: &mut Envelope,
    ) {
        for axis in 0..3 {
            hessian.add(&self.structure.pattern, axis, axis, 2.0 * multipliers[0]);
        }
    }
}

/// From anywhere on the sphere, and far off it, to the nearest point.
#[test]
fn the_nearest_point_of_a_sphere_is_found() {
    let mut random = Random::default();
    for case in 0..50 {
        let to = Vector3::from_fn(|_, _| 3.0 * random.signed());
        let of = Nearest::new(to, Vector3::repeat(1.0), 10.0);
        let start = Vector3::from_fn(|_, _| 5.0 * random.signed());
        let (found, steps) = of.from(start);
        assert!((found - to.normalize()).norm() < 1e-4, "{case}: {found}");
        assert!(steps < 40, "{case}: {steps}");
    }
}

/// Two axes that hardly weigh: the way leads round the sphere, and the model without curvature knows nothing of it.
#[test]
fn weak_directions_are_followed_round_a_curve() {
    let weights = Vector3::new(1e-3, 1e-3, 1.0);
    let of = Nearest::new(Vector3::new(2.0, 0.0, 0.0), weights, 10.0);
    let (found, steps) = of.from(Vector3::new(-0.6, 0.8, 0.0));
    assert!((found - Vector3::x()).norm() < 1e-3, "{found}");
    assert!(steps < 40, "{steps}");
}

/// A bound that is in the way is kept.
#[test]
fn a_bound_that_is_violated_acts() {
    let of = Nearest::new(Vector3::new(1.0, 0.0, 3.0), Vector3::repeat(1.0), 0.6);
    let (found, _) = of.from(Vector3::new(0.1, -0.2, 0.9));
    assert!(
        (found - Vector3::new(0.8, 0.0, 0.6)).norm() < 1e-3,
        "{found}"
    );
}

/// No point within the radius is lower, of definite matrices and of others.
#[test]
fn the_least_within_a_radius_is_least() {
    let mut random = Random::default();
    for case in 0..100 {
        let mut draw = |_: usize, _: usize| random.signed();
        let half = DMatrix::from_fn(4, 4, &mut draw);
        let hessian = match case % 2 {
            0 => half.tr_mul(&half),
            _ => &half + half.transpose(),
        };
        let gradient = DVector::from_fn(4, &mut draw);
        let value = |z: &DVector<f64>| 0.5 * (&hessian * z).dot(z) + gradient.dot(z);
        let (least, is_at_border) = within(hessian.clone(), &gradient, 0.7);
        assert!(least.norm() < 0.7 * (1.0 + 1e-6), "{case}");
        assert!(!is_at_border || least.norm() > 0.7 * (1.0 - 1e-6), "{case}");
        for _ in 0..200 {
            let mut other = DVector::from_fn(4, &mut draw);
            let length = other.norm();
            if length > 0.7 {
                other *= 0.7 / length;
            }
            assert!(value(&least) <= value(&other) + 1e-9, "{case}");
        }
    }
}

/// Of numbers that are not finite no decomposition ends: no step is taken.
#[test]
fn what_is_not_finite_is_left() {
    let of = Nearest::new(Vector3::x(), Vector3::repeat(1.0), 10.0);
    for unknown in [f64::NAN, f64::INFINITY] {
        let (_, steps) = of.from(Vector3::new(0.3, unknown, 0.1));
        assert_eq!(steps, 0, "{unknown}");
    }
}
