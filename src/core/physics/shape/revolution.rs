//! Solids of revolution about z: volume and moments in closed form, and convex pieces that cover them.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix3, Vector2, Vector3};

use super::error::ShapeError;
use super::hull::check_hull;
use super::kind::{Compound, Part, Shape};
use super::mass::MassDistribution;
use crate::math::Pose;
use crate::physics::contact::Feature;

/// How far pieces may be from the round surface \[m\]: half of what overlap checks tolerate.
const SAGITTA_M: f64 = 5e-4;

/// Least and greatest number of pieces around.
const SIDES: std::ops::RangeInclusive<usize> = 12..=48;

/// Lengths that count as none, relative to the size: rounding.
const ROUNDING: f64 = 1e-9;

/// A point of a half plane: distance from the axis, and height \[m\].
type Point = Vector2<f64>;

/// What a profile in a half plane sweeps when it turns about z.
#[derive(Clone, Debug, PartialEq)]
pub struct Revolution {
    /// The outer side, as it is given.
    profile_m: Vec<Point>,
    /// The inner side, point by point; none of a solid without a cavity.
    inside_m: Option<Vec<Point>>,
}

impl Revolution {
    /// Of a profile of distances from the axis and heights \[m\]: filled between profile and axis, which takes
    /// heights that rise; or with a wall of that thickness on the left of the profile as it is written, which
    /// is inside where it runs outwards below, then up, then inwards.
    ///
    /// Fails where a point is not finite or left of the axis, points coincide, heights fall of a filled one,
    /// or the wall is too thick for a bend of the profile.
    pub fn new(profile_m: &[[f64; 2]], wall_m: Option<f64>) -> Result<Self, ShapeError> {
        let profile_m: Vec<Point> = profile_m.iter().map(|of| Point::from(*of)).collect();
        let size_m = profile_m.iter().map(|p| p.norm()).fold(0.0, f64::max);
        for (index, point) in profile_m.iter().enumerate() {
            if !(point.x >= 0.0 && point.iter().all(|x| x.is_finite())) {
                return Err(ShapeError::Profile {
                    index,
                    why: "is no distance from the axis, zero or more, and height",
                });
            }
        }
        for index in 1..profile_m.len() {
            let step = profile_m[index] - profile_m[index - 1];
            if step.norm() <= ROUNDING * size_m {
                let why = "is the one before again";
                return Err(ShapeError::Profile { index, why });
            }
            if wall_m.is_none() && step.y < 0.0 {
                let why = "is lower than the one before, which takes wall_mm";
                return Err(ShapeError::Profile { index, why });
            }
        }
        if profile_m.len() < 2 {
            let (index, why) = (profile_m.len(), "is missing: a profile has two at least");
            return Err(ShapeError::Profile { index, why });
        }
        let inside_m = match wall_m {
            Some(wall_m) => Some(inside(&profile_m, wall_m)?),
            None => None,
        };
        let made = Self {
            profile_m,
            inside_m,
        };
        let cells = made.cells();
        let is_sound = |cell: &[Point]| is_convex(cell, size_m);
        if let Some(index) = cells.iter().position(|cell| !is_sound(cell)) {
            let why = "begins a bend that the wall is too thick for, or a wall that leaves the right side of the axis";
            return Err(ShapeError::Profile { index, why });
        }
        made.mass()?;
        Ok(made)
    }

    /// Convex polygons, counter-clockwise, that fill the profile: one for each of its steps.
    fn cells(&self) -> Vec<Vec<Point>> {
        let steps = self.profile_m.windows(2).enumerate();
        let cells = steps.filter_map(|(index, step)| {
            let [from, to] = [step[0], step[1]];
            let [inner_to, inner_from] = match &self.inside_m {
                Some(inside_m) => [inside_m[index + 1], inside_m[index]],
                // A step straight in or out bounds nothing by itself.
                None if from.y == to.y => return None,
                None => [Point::new(0.0, to.y), Point::new(0.0, from.y)],
            };
            let mut cell: Vec<Point> = Vec::new();
            for point in [from, to, inner_to, inner_from] {
                if cell.iter().all(|known| (known - point).norm() > 0.0) {
                    cell.push(point);
                }
            }
            Some(cell)
        });
        cells.collect()
    }

    /// How mass is distributed in it: exact.
    ///
    /// Over the area of the profile, `V = 2π ∫ r`, `z̄ = ∫ r z / ∫ r`, and for unit density `∫ x² = π ∫ r³`,
    /// `∫ z² = 2π ∫ r z²`. A homogeneous polynomial of degree d has over the triangle of the origin and an edge
    /// the integral `2A/(d + 2)` times its mean along the edge, for which Gauss' two points are exact up to
    /// degree 3.
    pub fn mass(&self) -> Result<MassDistribution, ShapeError> {
        let integral = |degree: f64, of: &dyn Fn(&Point) -> f64| -> f64 {
            let cells = self.cells();
            let edges = cells
                .iter()
                .flat_map(|cell| (0..cell.len()).map(|at| (cell[at], cell[(at + 1) % cell.len()])));
            edges
                .map(|(a, b)| {
                    let twice_area = a.perp(&b);
                    let mean = [-1.0, 1.0].map(|side| {
                        let share = 0.5 + side * 0.5 / 3.0_f64.sqrt();
                        0.5 * of(&(a + (b - a) * share))
                    });
                    twice_area / (degree + 2.0) * (mean[0] + mean[1])
                })
                .sum()
        };
        let area_m3 = integral(1.0, &|p| p.x);
        let volume_m3 = TAU * area_m3;
        if !(volume_m3 > 0.0 && volume_m3.is_finite()) {
            return Err(ShapeError::NoPart);
        }
        let height_m = integral(2.0, &|p| p.x * p.y) / area_m3;
        let xx_m2 = PI * integral(3.0, &|p| p.x.powi(3)) / volume_m3;
        let zz_m2 = TAU * integral(3.0, &|p| p.x * p.y * p.y) / volume_m3 - height_m * height_m;
        let moments = Vector3::new(xx_m2 + zz_m2, xx_m2 + zz_m2, 2.0 * xx_m2);
        Ok(MassDistribution {
            volume_m3,
            centre_m: Vector3::z() * height_m,
            tensor_m2: Matrix3::from_diagonal(&moments),
        })
    }

    /// As convex pieces within half a millimetre of it, with the rims and flat ends by which it may touch.
    pub fn compound(&self) -> Compound {
        let cells = self.cells();
        let pieces = cells.iter().flat_map(|cell| {
            let farthest_m = cell.iter().map(|p| p.x).fold(0.0, f64::max);
            let sides = sides(farthest_m);
            let ring = |side: usize| {
                let (sin, cos) = (TAU * side as f64 / sides as f64).sin_cos();
                cell.iter()
                    .map(move |p| Vector3::new(p.x * cos, p.x * sin, p.y))
            };
            let pieces: Vec<Vec<Vector3<f64>>> = match is_convex_around(cell) {
                true => vec![(0..sides).flat_map(ring).collect()],
                false => (0..sides)
                    .map(|side| ring(side).chain(ring((side + 1) % sides)).collect())
                    .collect(),
            };
            pieces
        });
        let parts = pieces.filter_map(|points| {
            let points_m = distinct(points);
            check_hull(&points_m).ok()?;
            Some(Part {
                shape: Shape::Hull { points_m },
                compound_from_shape: Pose::identity(),
            })
        });
        Compound {
            parts: parts.collect(),
            features: self.features(),
        }
    }

    /// Where the outline bends outwards a rim, or on the axis a tip; where it is level a face, where it is
    /// parallel to the axis a side. They are named by the places of the points in the profile, with `inside`
    /// before those of the inner side.
    fn features(&self) -> Vec<(String, Feature)> {
        let mut features = of_side(&self.profile_m, "", self.inside_m.is_none());
        if let Some(inside_m) = &self.inside_m {
            let reversed: Vec<Point> = inside_m.iter().rev().copied().collect();
            features.extend(of_side(&reversed, "inside ", false));
        }
        features
    }
}

/// Features of a side that has the solid on its left; `is_closed`: its ends go on straight to the axis.
fn of_side(side: &[Point], prefix: &str, is_closed: bool) -> Vec<(String, Feature)> {
    let last = side.len() - 1;
    let number = |at: usize| match prefix.is_empty() {
        true => at + 1,
        false => last + 1 - at,
    };
    let mut features = Vec::new();
    let axis = |height_m: f64| Vector3::z() * height_m;
    for (at, point) in side.iter().enumerate() {
        let mut before = (at > 0).then(|| point - side[at - 1]);
        let mut after = (at < last).then(|| side[at + 1] - point);
        if point.x == 0.0 {
            // On the axis the way goes on as its mirror image.
            let mirrored = |way: Option<Point>| way.map(|way| Point::new(way.x, -way.y));
            (before, after) = (before.or(mirrored(after)), after.or(mirrored(before)));
        } else if is_closed {
            before = before.or(Some(Point::x()));
            after = after.or(Some(-Point::x()));
        }
        // Outwards: the way turns left. The edge of an open wall is one too.
        let is_outwards = match (before, after) {
            (Some(before), Some(after)) => {
                before.perp(&after) > ROUNDING * before.norm() * after.norm()
            }
            _ => true,
        };
        if !is_outwards {
            continue;
        }
        let name = number(at);
        if point.x > 0.0 {
            // Its axis leads out of the solid, to the side on which the way beside it lies least.
            let way = after.or(before).unwrap_or_else(Point::y);
            let way_before = before.unwrap_or(way);
            let up = if way_before.y - way.y >= 0.0 {
                1.0
            } else {
                -1.0
            };
            let rim = Feature::Rim {
                centre_m: axis(point.y),
                axis: Vector3::z() * up,
                radius_m: point.x,
            };
            features.push((format!("{prefix}rim {name}"), rim));
        } else {
            features.push((
                format!("{prefix}tip {name}"),
                Feature::corner(axis(point.y)),
            ));
        }
    }
    let mut flat = |from: &Point, to: &Point, name: String| {
        if (from.y - to.y).abs() <= ROUNDING * (to - from).norm() && from.x != to.x {
            let up = if to.x > from.x { -1.0 } else { 1.0 };
            features.push((name, Feature::face(axis(from.y), Vector3::z() * up)));
        }
    };
    if is_closed {
        let (first, end) = (side[0], side[last]);
        flat(&Point::new(0.0, first.y), &first, "end 1".into());
        flat(&end, &Point::new(0.0, end.y), format!("end {}", last + 1));
    }
    for (at, step) in side.windows(2).enumerate() {
        let [a, b] = [number(at), number(at + 1)];
        let name = format!("{prefix}face {}-{}", a.min(b), a.max(b));
        flat(&step[0], &step[1], name);
    }
    // A straight part by which it can lie.
    let straight = side.windows(2).enumerate().filter(|(_, step)| {
        let [from, to] = [step[0], step[1]];
        prefix.is_empty() && from.x > 0.0 && (from.x - to.x).abs() <= ROUNDING * from.x
    });
    features.extend(straight.map(|(at, step)| {
        let line = Feature::Line {
            point_m: axis(0.5 * (step[0].y + step[1].y)),
            direction: Vector3::z(),
            radius_m: step[0].x,
        };
        (format!("side {}-{}", number(at), number(at + 1)), line)
    }));
    features
}

/// The profile moved to its left by the thickness of the wall, its bends mitred. An end on the axis stays on it.
fn inside(profile_m: &[Point], wall_m: f64) -> Result<Vec<Point>, ShapeError> {
    let left = |at: usize| {
        let way = (profile_m[at + 1] - profile_m[at]).normalize();
        Point::new(-way.y, way.x)
    };
    let last = profile_m.len() - 1;
    let points = profile_m.iter().enumerate().map(|(at, point)| {
        let fault = |why| ShapeError::Profile { index: at, why };
        if at > 0 && at < last {
            // The point that is so far from both lines: p + w (a + b)/(1 + a·b).
            let (a, b) = (left(at - 1), left(at));
            let spread = 1.0 + a.dot(&b);
            if spread < 1e-3 {
                return Err(fault("turns back on the way to it"));
            }
            return Ok(point + (a + b) * (wall_m / spread));
        }
        let normal = left(at.min(last - 1));
        let moved = point + normal * wall_m;
        if point.x > 0.0 {
            return Ok(moved);
        }
        // Along the moved line to the axis.
        let way = Point::new(normal.y, -normal.x);
        if way.x.abs() < 1e-3 {
            return Err(fault("is on the axis and the profile runs along that"));
        }
        Ok(Point::new(0.0, moved.y - way.y * moved.x / way.x))
    });
    points.collect()
}

/// Whether a polygon is convex, counter-clockwise, and on the right side of the axis.
fn is_convex(cell: &[Point], size_m: f64) -> bool {
    let none = ROUNDING * size_m;
    let count = cell.len();
    let bend = |at: usize| {
        let [a, b, c] = [0, 1, 2].map(|next| cell[(at + next) % count]);
        (b - a).perp(&(c - b))
    };
    count >= 3
        && cell.iter().all(|p| p.x >= -none)
        && (0..count).all(|at| bend(at) > -none * size_m)
        && (0..count).any(|at| bend(at) > none * none)
}

/// Whether a convex polygon stays convex when it turns about the axis: the polygon and its mirror image are so
/// together, which is where they have all of the area of their hull.
fn is_convex_around(cell: &[Point]) -> bool {
    let area = |points: &[Point]| -> f64 {
        let edges = (0..points.len()).map(|at| points[at].perp(&points[(at + 1) % points.len()]));
        0.5 * edges.sum::<f64>()
    };
    let mirrored = cell.iter().map(|p| Point::new(-p.x, p.y));
    let hull = hull(cell.iter().copied().chain(mirrored).collect());
    area(&hull) <= 2.0 * area(cell) * (1.0 + 1e-9)
}

/// The convex hull of points in a plane, counter-clockwise (Andrew's monotone chain).
fn hull(mut points: Vec<Point>) -> Vec<Point> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let chain = |points: &mut dyn Iterator<Item = Point>| {
        let mut chain: Vec<Point> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && (b - a).perp(&(point - b)) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut points.iter().copied());
    hull.extend(chain(&mut points.iter().rev().copied()));
    hull
}

/// How many sides around keep chords near to a circle: `r (1 − cos(π/n))` is the most that they miss.
fn sides(radius_m: f64) -> usize {
    let cosine = 1.0 - SAGITTA_M / radius_m.max(SAGITTA_M);
    let sides = (PI / cosine.acos()).ceil() as usize;
    sides.clamp(*SIDES.start(), *SIDES.end())
}

/// Points without those that are there already.
fn distinct(points: Vec<Vector3<f64>>) -> Vec<Vector3<f64>> {
    let mut kept: Vec<Vector3<f64>> = Vec::new();
    for point in points {
        if kept.iter().all(|known| (known - point).norm() > 1e-9) {
            kept.push(point);
        }
    }
    kept
}

#[cfg(test)]
mod tests;
