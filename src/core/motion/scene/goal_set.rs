//! Where the vector of a goal's quantity must be, with its signed distance.

use nalgebra::Vector3;

/// A set of vectors, in the unit of the quantity that must be in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GoalSet {
    /// Between two corners, axis by axis; equal bounds fix a number, infinite ones leave it free.
    Box {
        /// Lower corner.
        lower: Vector3<f64>,
        /// Upper corner.
        upper: Vector3<f64>,
    },
    /// No farther from a centre than a radius above zero.
    Ball {
        /// Its centre.
        centre: Vector3<f64>,
        /// Its radius.
        radius: f64,
    },
    /// `normal · x ≥ least`.
    HalfSpace {
        /// Unit vector into it.
        normal: Vector3<f64>,
        /// Where it begins along the normal.
        least: f64,
    },
}

impl GoalSet {
    /// One vector alone.
    pub fn point(at: Vector3<f64>) -> Self {
        Self::Box {
            lower: at,
            upper: at,
        }
    }

    /// No farther from zero than a radius; at zero where there is no radius.
    pub fn about_zero(radius: Option<f64>) -> Self {
        match radius {
            Some(radius) => Self::Ball {
                centre: Vector3::zeros(),
                radius,
            },
            None => Self::point(Vector3::zeros()),
        }
    }

    /// Whether it is one vector alone, as to its first `dimension` numbers.
    pub fn is_point(&self, dimension: usize) -> bool {
        match self {
            Self::Box { lower, upper } => {
                (0..dimension).all(|axis| lower[axis] == upper[axis] && lower[axis].is_finite())
            }
            _ => false,
        }
    }

    /// Signed distance from it: positive outside, and inside minus the way to its boundary. On what
    /// it fixes, inside is at distance zero.
    pub fn distance(&self, x: &Vector3<f64>) -> f64 {
        match self {
            Self::Box { lower, upper } => {
                let outside =
                    x - x.zip_zip_map(lower, upper, |x, lower, upper| x.clamp(lower, upper));
                let beyond = outside.norm();
                if beyond > 0.0 {
                    return beyond;
                }
                let room =
                    x.zip_zip_map(lower, upper, |x, lower, upper| (x - lower).min(upper - x));
                -room.min()
            }
            Self::Ball { centre, radius } => (x - centre).norm() - radius,
            Self::HalfSpace { normal, least } => least - normal.dot(x),
        }
    }

    /// The set moved.
    pub fn shifted(self, by: &Vector3<f64>) -> Self {
        match self {
            Self::Box { lower, upper } => Self::Box {
                lower: lower + by,
                upper: upper + by,
            },
            Self::Ball { centre, radius } => Self::Ball {
                centre: centre + by,
                radius,
            },
            Self::HalfSpace { normal, least } => Self::HalfSpace {
                normal,
                least: least + normal.dot(by),
            },
        }
    }

    /// The set with all lengths multiplied.
    pub fn scaled(self, factor: f64) -> Self {
        match self {
            Self::Box { lower, upper } => Self::Box {
                lower: lower * factor,
                upper: upper * factor,
            },
            Self::Ball { centre, radius } => Self::Ball {
                centre: centre * factor,
                radius: radius * factor,
            },
            Self::HalfSpace { normal, least } => Self::HalfSpace {
                normal,
                least: least * factor,
            },
        }
    }

    /// How far two sets are apart at least: positive where no vector is in both, as far as a pair of
    /// kinds tells it.
    pub fn gap(&self, other: &Self) -> f64 {
        match (self, other) {
            (Self::Box { lower, upper }, Self::Box { lower: l, upper: u }) => {
                let gap = Vector3::from_fn(|axis, _| {
                    (lower[axis] - u[axis]).max(l[axis] - upper[axis]).max(0.0)
                });
                gap.norm()
            }
            (Self::Ball { centre, radius }, other) | (other, Self::Ball { centre, radius }) => {
                other.distance(centre) - radius
            }
            (Self::HalfSpace { normal, least }, Self::Box { lower, upper })
            | (Self::Box { lower, upper }, Self::HalfSpace { normal, least }) => {
                let farthest: f64 = (0..3)
                    .filter(|axis| normal[*axis] != 0.0)
                    .map(|axis| {
                        let bound = if normal[axis] > 0.0 { upper } else { lower };
                        normal[axis] * bound[axis]
                    })
                    .sum();
                least - farthest
            }
            (
                Self::HalfSpace { normal, least },
                Self::HalfSpace {
                    normal: n,
                    least: l,
                },
            ) => {
                // Only opposite half-spaces can be apart.
                if (normal + n).norm() < 1e-9 {
                    least + l
                } else {
                    f64::NEG_INFINITY
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sets() -> [GoalSet; 4] {
        [
            GoalSet::Box {
                lower: Vector3::new(1.0, f64::NEG_INFINITY, -1.0),
                upper: Vector3::new(2.0, 0.5, f64::INFINITY),
            },
            GoalSet::point(Vector3::new(1.5, 0.2, 0.3)),
            GoalSet::Ball {
                centre: Vector3::new(1.0, -1.0, 0.5),
                radius: 0.7,
            },
            GoalSet::HalfSpace {
                normal: Vector3::new(0.6, 0.0, 0.8),
                least: 0.9,
            },
        ]
    }

    #[test]
    fn distances_are_signed() {
        let [cuboid, point, ball, half] = sets();
        assert_eq!(cuboid.distance(&Vector3::new(4.0, 2.0, 0.0)), 2.5);
        assert_eq!(cuboid.distance(&Vector3::new(1.25, 0.0, 9.0)), -0.25);
        assert_eq!(point.distance(&Vector3::new(1.5, 0.2, 0.3)), 0.0);
        assert!((ball.distance(&Vector3::new(1.0, -1.0, 2.5)) - 1.3).abs() < 1e-15);
        assert!((half.distance(&Vector3::new(0.0, 5.0, 1.0)) - 0.1).abs() < 1e-15);
    }

    /// Vectors in both sets are found wherever no gap is told, and none where one is.
    #[test]
    fn sets_apart_have_nothing_in_common() {
        let mut random = crate::math::random::Random::default();
        for first in sets() {
            for second in sets() {
                for _ in 0..200 {
                    let by = Vector3::from_fn(|_, _| 2.0 * random.normal());
                    let second = second.shifted(&by);
                    let gap = first.gap(&second);
                    assert_eq!(gap, second.gap(&first));
                    // The nearest of many points of the first to the second.
                    let mut least = f64::INFINITY;
                    for _ in 0..50 {
                        let x = Vector3::from_fn(|_, _| 3.0 * random.normal());
                        if first.distance(&x) <= 0.0 {
                            least = least.min(second.distance(&x));
                        }
                    }
                    assert!(
                        gap <= 0.0 || least > 0.0,
                        "{first:?} {second:?}: {gap} {least}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_set_moves_with_its_distances() {
        let by = Vector3::new(0.3, -0.2, 0.9);
        let x = Vector3::new(2.2, 0.7, -0.4);
        for set in sets() {
            let error = set.shifted(&by).distance(&(x + by)) - set.distance(&x);
            assert!(error.abs() < 1e-12, "{set:?}");
            let error = set.scaled(2.0).distance(&(x * 2.0)) - 2.0 * set.distance(&x);
            assert!(error.abs() < 1e-12, "{set:?}");
        }
    }
}
