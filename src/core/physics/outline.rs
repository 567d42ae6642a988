//! Solids as convex parts with their features, and which features of two solids are nearest.
//!
//! Distances of solids are piecewise those of two features, in closed form and with exact derivatives
//! ([`Contact`]). Which two they are, where solids are apart or in each other, is told by parry's distance: those that give
//! the same gap and normal. Where no pair does, as beside the slanted side of a cone, the nearest points stand for
//! the features: a point of one solid, and the plane through that of the other.

use nalgebra::{Point3, UnitQuaternion, Vector3};

use super::contact::{Contact, Feature, Frame};
use super::shape::{Shape, ShapeError, Solid};
use crate::math::Pose;

/// Distance \[m\] of a nearest point from a feature to which it belongs, and of gaps that are the same: beyond the errors of
/// parry's iterations between round solids.
const SAME_M: f64 = 1e-5;
/// Cosine of the angle between normals that are the same.
const SAME_DIRECTION: f64 = 0.9999;
/// Least gap \[m\] between points that tell a normal.
const LEAST_GAP_M: f64 = 1e-7;
/// Greatest number of a hull's points of which features are sought.
const HULL_POINTS: usize = 100;
/// Directions that are tried across a way, and halvings of the angle between two of them.
const TURNS: usize = 72;
const HALVINGS: usize = 20;

/// A solid as its convex parts.
#[derive(Clone)]
pub struct SolidOutline {
    parts: Vec<OutlinePart>,
}

#[derive(Clone)]
struct OutlinePart {
    solid: Solid,
    features: Vec<Feature>,
}

/// How two solids are nearest to each other, or deepest in each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// The features that are nearest.
    pub contact: Contact,
    /// Distance \[m\], negative inside.
    pub gap_m: f64,
    /// Out of the other solid towards the first \[world\].
    pub normal: Vector3<f64>,
}

impl SolidOutline {
    /// The outline of a shape that lies along the axes, its origin at `at_m` \[m\]. Fails where it is no solid.
    pub fn new(shape: &Shape, at_m: &Vector3<f64>) -> Result<Self, ShapeError> {
        let solids = shape.solid()?.parts_alone().into_iter();
        let one = [(shape, Pose::identity())];
        let placed: Vec<(&Shape, Pose)> = match shape {
            Shape::Compound(of) => of
                .parts
                .iter()
                .map(|part| (&part.shape, part.compound_from_shape))
                .collect(),
            _ => one.to_vec(),
        };
        let parts = solids.zip(placed).map(|(solid, (shape, pose))| {
            let is_large =
                matches!(shape, Shape::Hull { points_m } if points_m.len() > HULL_POINTS);
            let features = match is_large {
                true => Vec::new(),
                false => shape.features()?,
            };
            let features = features.into_iter();
            Ok(OutlinePart {
                solid: solid.moved(at_m),
                features: features
                    .map(|(_, of)| of.placed(&pose).shifted(at_m))
                    .collect(),
            })
        });
        Ok(Self {
            parts: parts.collect::<Result<_, ShapeError>>()?,
        })
    }

    /// The features of this solid and another that are nearest; `None` where poses are not finite, or no normal is told
    /// because they just touch.
    pub fn nearest(&self, at: &Frame, other: &SolidOutline, other_at: &Frame) -> Option<Nearest> {
        let (one, another, closest) = self.deepest(at, other, other_at)?;
        if !(closest.gap_m.abs() > LEAST_GAP_M) {
            return None;
        }
        let here = Point3::from(closest.point_m);
        let apart_m = (pose(at) * here).coords - closest.other_point_m;
        let there = pose(other_at).inverse_transform_point(&closest.other_point_m.into());
        let seen = SeenNearest {
            frames: [at, other_at],
            points_m: [here.coords, there.coords],
            gap_m: closest.gap_m,
            normal: apart_m / closest.gap_m,
        };
        seen.nearest(&one.features, &another.features)
    }

    /// The feature that is lowest over a plane through a point \[m\] with that unit normal \[world\].
    pub fn lowest(
        &self,
        at: &Frame,
        point_m: &Vector3<f64>,
        normal: &Vector3<f64>,
    ) -> Option<Nearest> {
        let each = self.parts.iter().filter_map(|part| {
            let closest = part.solid.lowest(&pose(at), point_m, normal).ok()?;
            Some((part, closest))
        });
        let (part, closest) = each.min_by(|a, b| a.1.gap_m.total_cmp(&b.1.gap_m))?;
        let seen = SeenNearest {
            frames: [at, &Frame::world()],
            points_m: [closest.point_m, closest.other_point_m],
            gap_m: closest.gap_m,
            normal: *normal,
        };
        seen.nearest(&part.features, &[Feature::face(*point_m, *normal)])
    }

    /// The plane that keeps this solid and another apart across a way \[world\] along which they go through each
    /// other: the one that they are least behind. `None` where the way has no direction.
    pub fn aside(
        &self,
        at: &Frame,
        other: &SolidOutline,
        other_at: &Frame,
        way: &Vector3<f64>,
    ) -> Option<Nearest> {
        let (one, another, _) = self.deepest(at, other, other_at)?;
        let [first, second] = Feature::tangents(&way.try_normalize(f64::MIN_POSITIVE)?);
        let direction = |angle: f64| first * angle.cos() + second * angle.sin();
        let supports = |normal: &Vector3<f64>| {
            let in_one = at.orientation.inverse() * -normal;
            let in_other = other_at.orientation.inverse() * normal;
            let (here, there) = (
                one.solid.support_m(&in_one),
                another.solid.support_m(&in_other),
            );
            let apart_m = pose(at) * Point3::from(here) - pose(other_at) * Point3::from(there);
            (normal.dot(&apart_m), here, there)
        };
        let step = std::f64::consts::TAU / TURNS as f64;
        let gap_m = |angle: f64| supports(&direction(angle)).0;
        let tried = (0..TURNS).map(|turn| turn as f64 * step);
        let mut best = tried.max_by(|a, b| gap_m(*a).total_cmp(&gap_m(*b)))?;
        let mut reach = step;
        for _ in 0..HALVINGS {
            reach *= 0.5;
            let beside = [best - reach, best + reach].into_iter();
            let better = beside.max_by(|a, b| gap_m(*a).total_cmp(&gap_m(*b)))?;
            if gap_m(better) > gap_m(best) {
                best = better;
            }
        }
        let normal = direction(best);
        let (gap_m, here, there) = supports(&normal);
        let face = Feature::face(there, other_at.orientation.inverse() * normal);
        Some(Nearest {
            contact: Contact::new(Feature::corner(here), face).ok()?,
            gap_m,
            normal,
        })
    }

    /// The two parts that are nearest or deepest in each other.
    fn deepest<'o>(
        &'o self,
        at: &Frame,
        other: &'o SolidOutline,
        other_at: &Frame,
    ) -> Option<(&'o OutlinePart, &'o OutlinePart, super::shape::Closest)> {
        let (here, there) = (pose(at), pose(other_at));
        let pairs = self.parts.iter();
        let pairs = pairs.flat_map(|one| other.parts.iter().map(move |another| (one, another)));
        let found = pairs.filter_map(|(one, another)| {
            let closest = one.solid.closest(&here, &another.solid, &there).ok()?;
            Some((one, another, closest))
        });
        found.min_by(|a, b| a.2.gap_m.total_cmp(&b.2.gap_m))
    }
}

/// Nearest points of two parts, as parry finds them.
struct SeenNearest<'a> {
    frames: [&'a Frame; 2],
    /// On each, in its own axes \[m\].
    points_m: [Vector3<f64>; 2],
    gap_m: f64,
    normal: Vector3<f64>,
}

impl SeenNearest<'_> {
    fn nearest(&self, features: &[Feature], others: &[Feature]) -> Option<Nearest> {
        let near = |side: usize, features: &[Feature]| -> Vec<Feature> {
            let point_m = &self.points_m[side];
            let near = features.iter();
            let near = near.filter(|of| of.distance_m(point_m) < SAME_M);
            near.copied().collect()
        };
        let (own, others) = (near(0, features), near(1, others));
        let inward = self.frames[0].orientation.inverse() * -self.normal;
        let outward = self.frames[1].orientation.inverse() * self.normal;
        let points = [0, 1].map(|side| vec![Feature::corner(self.points_m[side])]);
        let own_plane = vec![Feature::face(self.points_m[0], inward)];
        let other_plane = vec![Feature::face(self.points_m[1], outward)];
        let lines = [(0, &own), (1, &others)].map(|(side, of)| self.tangents(side, of));
        let faces = |of: &[Feature]| -> Vec<Feature> {
            let faces = of.iter().filter(|of| matches!(of, Feature::Face { .. }));
            faces.copied().collect()
        };
        let tries = [
            (own.clone(), others.clone()),
            (points[0].clone(), faces(&others)),
            (faces(&own), points[1].clone()),
            (lines[0].clone(), lines[1].clone()),
            (points[0].clone(), other_plane),
            (own_plane, points[1].clone()),
        ];
        let contact = tries.iter().find_map(|(a, b)| self.agreeing(a, b))?;
        Some(Nearest {
            contact,
            gap_m: self.gap_m,
            normal: self.normal,
        })
    }

    /// Lines, and the tangents of rims at the nearest point.
    fn tangents(&self, side: usize, features: &[Feature]) -> Vec<Feature> {
        let point_m = self.points_m[side];
        let lines = features.iter().filter_map(|of| match *of {
            Feature::Line { .. } => Some(*of),
            Feature::Rim { centre_m, axis, .. } => Some(Feature::Line {
                point_m,
                direction: axis.cross(&(point_m - centre_m)).try_normalize(1e-9)?,
                radius_m: 0.0,
            }),
            _ => None,
        });
        lines.collect()
    }

    /// The pair that gives the same gap and normal, best.
    fn agreeing(&self, own: &[Feature], others: &[Feature]) -> Option<Contact> {
        let [at, other_at] = self.frames;
        let mut best: Option<(f64, Contact)> = None;
        for (a, b) in own.iter().flat_map(|a| others.iter().map(move |b| (a, b))) {
            let Ok(contact) = Contact::new(*a, *b) else {
                continue;
            };
            let contact = contact.towards(at, other_at, &self.normal);
            let Ok(touch) = contact.touch(at, other_at) else {
                continue;
            };
            let off_m = (touch.gap_m - self.gap_m).abs();
            let is_same = off_m < SAME_M && touch.normal.dot(&self.normal) > SAME_DIRECTION;
            if is_same && best.as_ref().is_none_or(|(least_m, _)| off_m < *least_m) {
                best = Some((off_m, contact));
            }
        }
        best.map(|(_, contact)| contact)
    }
}

fn pose(frame: &Frame) -> Pose {
    let orientation: UnitQuaternion<f64> = frame.orientation;
    Pose::from_parts(frame.position_m.into(), orientation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;

    fn shapes() -> Vec<Shape> {
        let half = Vector3::new(0.05, 0.08, 0.03);
        let box_of = |half_extents_m| Shape::Cuboid { half_extents_m };
        let points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
        let points_m = points.map(|p| Vector3::from(p).map(|x: i32| 0.12 * f64::from(x) - 0.03));
        let (half_length_m, radius_m) = (0.09, 0.02);
        let beside = Pose::translation(0.1, 0.0, 0.02);
        vec![
            box_of(half),
            Shape::RoundedCuboid {
                half_extents_m: half,
                radius_m: 0.01,
            },
            Shape::Sphere { radius_m: 0.06 },
            Shape::Cylinder {
                half_length_m,
                radius_m,
            },
            Shape::Capsule {
                half_length_m,
                radius_m,
            },
            Shape::Cone {
                half_height_m: 0.05,
                radius_m: 0.04,
            },
            Shape::Hull {
                points_m: points_m.to_vec(),
            },
            Shape::Compound(super::super::shape::Compound {
                parts: [(Pose::identity(), half), (beside, half * 0.6)]
                    .map(|(compound_from_shape, half)| super::super::shape::Part {
                        shape: box_of(half),
                        compound_from_shape,
                    })
                    .to_vec(),
                features: Vec::new(),
            }),
        ]
    }

    fn frame(random: &mut Random, reach_m: f64) -> Frame {
        let turn = Vector3::from_fn(|_, _| random.normal());
        Frame {
            position_m: Vector3::from_fn(|_, _| random.normal()).normalize() * reach_m,
            orientation: UnitQuaternion::from_scaled_axis(turn),
        }
    }

    /// The features have the solids' distance and its derivative by the poses, apart and in each other.
    #[test]
    fn the_nearest_features_are_as_far_as_the_solids() {
        let mut random = Random::default();
        let shapes = shapes();
        let (mut told, mut all) = (0, 0);
        for (one, another) in shapes
            .iter()
            .flat_map(|a| shapes.iter().map(move |b| (a, b)))
        {
            let own = SolidOutline::new(one, &Vector3::zeros()).expect("a solid");
            let other = SolidOutline::new(another, &Vector3::zeros()).expect("a solid");
            let (solid, other_solid) = (
                one.solid().expect("a solid"),
                another.solid().expect("a solid"),
            );
            for reach_m in [0.05, 0.08, 0.1, 0.12, 0.15, 0.2] {
                let (at, other_at) = (frame(&mut random, reach_m), frame(&mut random, 0.0));
                let distance_m = |at: &Frame| {
                    let distance = solid.distance_m(&pose(at), &other_solid, &pose(&other_at));
                    distance.expect("finite poses")
                };
                all += 1;
                let Some(nearest) = own.nearest(&at, &other, &other_at) else {
                    continue;
                };
                told += 1;
                let touch = nearest.contact.touch(&at, &other_at).expect("regular");
                let error_m = (touch.gap_m - distance_m(&at)).abs();
                assert!(error_m < 2e-5, "{one:?} {another:?}: {error_m}");
                let (_, by) = nearest
                    .contact
                    .touch_derivative(&at, &other_at)
                    .expect("regular");
                let push = Vector3::from_fn(|_, _| random.normal()) * 1e-4;
                let turn = Vector3::from_fn(|_, _| random.normal()) * 1e-3;
                let moved = |sign: f64| Frame {
                    position_m: at.position_m + push * sign,
                    orientation: at.orientation * UnitQuaternion::from_scaled_axis(turn * sign),
                };
                let change_m = 0.5 * (distance_m(&moved(1.0)) - distance_m(&moved(-1.0)));
                let expected_m = (by.gap.fixed_columns::<3>(0) * push)[0]
                    + (by.gap.fixed_columns::<3>(3) * turn)[0];
                // Where another pair of features is as near the distance bends.
                let error_m = (change_m - expected_m).abs();
                let is_bent = error_m > 2e-5;
                assert!(
                    error_m < 2e-4,
                    "{one:?} {another:?}: {change_m} {expected_m}"
                );
                told -= usize::from(is_bent);
            }
        }
        assert!(10 * told >= 9 * all, "{told} of {all}");
    }

    #[test]
    fn what_goes_straight_through_is_led_aside() {
        let plate = Shape::Cuboid {
            half_extents_m: Vector3::new(0.1, 0.002, 0.1),
        };
        let ball = Shape::Sphere { radius_m: 0.01 };
        let [plate, ball] =
            [plate, ball].map(|of| SolidOutline::new(&of, &Vector3::zeros()).expect("a solid"));
        let at = Frame {
            position_m: Vector3::new(0.08, 0.0, 0.02),
            orientation: UnitQuaternion::identity(),
        };
        let aside = ball
            .aside(&at, &plate, &Frame::world(), &Vector3::y())
            .expect("a way out");
        assert!((aside.normal - Vector3::x()).norm() < 1e-3, "{aside:?}");
        assert!((aside.gap_m + 0.03).abs() < 1e-4, "{aside:?}");
    }
}
