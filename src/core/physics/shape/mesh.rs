//! Closed surfaces of triangles: exact mass properties, and convex pieces by parry's decomposition (V-HACD).

use std::collections::BTreeMap;

use nalgebra::Vector3;
use parry3d::transformation::vhacd::{VHACD, VHACDParameters};

use super::error::ShapeError;
use super::hull::{check_hull, from_parry, hull_of, to_parry};
use super::inside;
use super::kind::{Compound, Part, Shape};
use super::mass::MassDistribution;
use crate::math::Pose;

/// Corners nearer than this are one, relative to the size: meshes repeat them where colours change.
const WELD: f64 = 1e-6;

/// A mesh is convex whose hull has no more volume than this beside its own, relative.
const CONVEX: f64 = 1e-3;

/// Voxels along the longest side of a mesh that is decomposed.
const RESOLUTION: u32 = 64;

/// Most convex pieces.
const PIECES: u32 = 24;

/// Most points of a piece.
const PIECE_POINTS: usize = 40;

/// Directions in which a hull's farthest points are kept where it has too many.
const DIRECTIONS: usize = 200;

/// A closed surface.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleMesh {
    /// Corners.
    corners_m: Vec<Vector3<f64>>,
    /// Indices of corners, counter-clockwise from outside.
    triangles: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// From corners and triangles between them. Corners that coincide become one, triangles without an area are
    /// left out. A surface that is inside out is turned, and so are triangles that run the other way round than
    /// their neighbours: exporters do not always mind.
    ///
    /// Fails where a corner is not finite or missing, where the surface is not closed, where it encloses
    /// no volume, and where parts of it overlap.
    pub fn new(corners_m: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Result<Self, ShapeError> {
        check_hull(corners_m)?;
        let (lower, upper) = corners_m
            .iter()
            .fold((corners_m[0], corners_m[0]), |(l, u), p| {
                (l.inf(p), u.sup(p))
            });
        let cell_m = WELD * (upper - lower).norm();
        let mut cells: BTreeMap<[i64; 3], u32> = BTreeMap::new();
        let mut welded: Vec<Vector3<f64>> = Vec::new();
        let number = corners_m.iter().map(|p| {
            let key = ((p - lower) / cell_m).map(|x| x.round() as i64);
            *cells.entry(key.into()).or_insert_with(|| {
                welded.push(*p);
                welded.len() as u32 - 1
            })
        });
        let number: Vec<u32> = number.collect();
        let mut kept = Vec::new();
        for triangle in triangles {
            let mut new = [0; 3];
            for (to, from) in new.iter_mut().zip(triangle) {
                let found = number.get(*from as usize);
                *to = *found.ok_or(ShapeError::Point {
                    index: *from as usize,
                })?;
            }
            let [a, b, c] = new;
            if a != b && b != c && c != a {
                kept.push(new);
            }
        }
        let mut mesh = Self {
            corners_m: welded,
            triangles: kept,
        };
        if mesh.is_closed() {
            if mesh.signed_volume_m3() < 0.0 {
                mesh.triangles.iter_mut().for_each(|of| of.swap(1, 2));
            }
        } else {
            mesh.orient()?;
        }
        mesh.mass()?;
        inside::check(&mesh.faces().collect::<Vec<_>>())?;
        Ok(mesh)
    }

    /// The hull of points: what to do with a surface that is not closed.
    pub fn hull(corners_m: &[Vector3<f64>]) -> Result<Self, ShapeError> {
        check_hull(corners_m)?;
        let (points, triangles) = hull_of(corners_m)?;
        let corners_m: Vec<Vector3<f64>> = points.into_iter().map(from_parry).collect();
        Self::new(&corners_m, &triangles)
    }

    /// Whether every edge lies between triangles that run along it in opposite directions.
    fn is_closed(&self) -> bool {
        let mut passes: BTreeMap<(u32, u32), i64> = BTreeMap::new();
        for triangle in &self.triangles {
            for (edge, is_forward) in edges(triangle) {
                *passes.entry(edge).or_insert(0) += if is_forward { 1 } else { -1 };
            }
        }
        !passes.is_empty() && passes.values().all(|sum| *sum == 0)
    }

    /// Turns triangles until neighbours run along their edge in opposite directions and every connected surface
    /// has its inside inside. Fails where an edge has not two triangles, and where a surface has one side only.
    fn orient(&mut self) -> Result<(), ShapeError> {
        let mut beside: BTreeMap<(u32, u32), Vec<(usize, bool)>> = BTreeMap::new();
        for (index, triangle) in self.triangles.iter().enumerate() {
            for (edge, is_forward) in edges(triangle) {
                beside.entry(edge).or_default().push((index, is_forward));
            }
        }
        let open = |open: usize| ShapeError::Open {
            open,
            edges: beside.len(),
        };
        let loose = beside.values().filter(|of| of.len() != 2).count();
        if loose > 0 || beside.is_empty() {
            return Err(open(loose));
        }
        let mut is_turned: Vec<Option<bool>> = vec![None; self.triangles.len()];
        for first in 0..self.triangles.len() {
            if is_turned[first].is_some() {
                continue;
            }
            is_turned[first] = Some(false);
            let mut surface = vec![first];
            let mut next = 0;
            while let Some(&at) = surface.get(next) {
                next += 1;
                for (edge, is_forward) in edges(&self.triangles[at]) {
                    for &(other, other_is_forward) in &beside[&edge] {
                        if other == at {
                            continue;
                        }
                        let turned = is_turned[at] == Some(true);
                        let wanted = turned ^ (is_forward == other_is_forward);
                        match is_turned[other] {
                            None => {
                                is_turned[other] = Some(wanted);
                                surface.push(other);
                            }
                            Some(found) if found != wanted => return Err(open(1)),
                            Some(_) => {}
                        }
                    }
                }
            }
            let corner = |i: u32| self.corners_m[i as usize];
            let volumes = surface.iter().map(|at| {
                let [a, b, c] = self.triangles[*at].map(corner);
                let volume = a.dot(&b.cross(&c));
                if is_turned[*at] == Some(true) {
                    -volume
                } else {
                    volume
                }
            });
            let is_inside_out = volumes.sum::<f64>() < 0.0;
            for at in surface {
                is_turned[at] = is_turned[at].map(|of| of ^ is_inside_out);
            }
        }
        for (triangle, turned) in self.triangles.iter_mut().zip(is_turned) {
            if turned == Some(true) {
                triangle.swap(1, 2);
            }
        }
        Ok(())
    }

    fn faces(&self) -> impl Iterator<Item = [Vector3<f64>; 3]> + '_ {
        let corners = |of: &[u32; 3]| of.map(|index| self.corners_m[index as usize]);
        self.triangles.iter().map(corners)
    }

    fn signed_volume_m3(&self) -> f64 {
        self.faces()
            .map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0)
            .sum()
    }

    /// Its corners \[m\].
    pub fn corners_m(&self) -> &[Vector3<f64>] {
        &self.corners_m
    }

    /// How many triangles it has.
    pub fn triangles(&self) -> usize {
        self.triangles.len()
    }

    /// How mass is distributed in it: exact.
    pub fn mass(&self) -> Result<MassDistribution, ShapeError> {
        MassDistribution::of_triangles(self.faces()).ok_or(ShapeError::Flat {
            count: self.corners_m.len(),
        })
    }

    /// As convex pieces, without features: one where it is convex, else those of V-HACD, whose hulls reach over
    /// the surface by up to about a voxel, a 64th of the length. A piece with many points keeps those that are
    /// farthest in some direction.
    ///
    /// Fails where no piece has a volume.
    pub fn pieces(&self) -> Result<Compound, ShapeError> {
        let (hull, triangles) = hull_of(&self.corners_m)?;
        let faces = triangles
            .iter()
            .map(|of| of.map(|i| from_parry(hull[i as usize])));
        let hull_m3 = MassDistribution::of_triangles(faces).map_or(0.0, |of| of.volume_m3);
        let is_convex = hull_m3 <= self.mass()?.volume_m3 * (1.0 + CONVEX);
        let hulls: Vec<Vec<Vector3<f64>>> = if is_convex {
            vec![hull.into_iter().map(from_parry).collect()]
        } else {
            let corners: Vec<_> = self.corners_m.iter().map(to_parry).collect();
            let parameters = VHACDParameters {
                resolution: RESOLUTION,
                max_convex_hulls: PIECES,
                ..VHACDParameters::default()
            };
            let found = VHACD::decompose(&parameters, &corners, &self.triangles, true);
            let hulls = found.compute_exact_convex_hulls(&corners, &self.triangles);
            let points = |(points, _): (Vec<_>, _)| points.into_iter().map(from_parry).collect();
            hulls.into_iter().map(points).collect()
        };
        let parts = hulls.into_iter().filter_map(|points_m| {
            let points_m = fewer(&points_m, PIECE_POINTS);
            let shape = Shape::Hull { points_m };
            shape.solid().ok()?;
            Some(Part {
                shape,
                compound_from_shape: Pose::identity(),
            })
        });
        let compound = Compound {
            parts: parts.collect(),
            features: Vec::new(),
        };
        compound.check()?;
        Ok(compound)
    }

    /// Corners of its hull by which it may touch a plane, at most so many \[m\].
    pub fn hull_corners_m(&self, most: usize) -> Result<Vec<Vector3<f64>>, ShapeError> {
        let (points, _) = hull_of(&self.corners_m)?;
        let points: Vec<Vector3<f64>> = points.into_iter().map(from_parry).collect();
        Ok(fewer(&points, most))
    }
}

/// The edges of a triangle, the lower corner first, and whether it runs along them so.
fn edges([a, b, c]: &[u32; 3]) -> [((u32, u32), bool); 3] {
    [(*a, *b), (*b, *c), (*c, *a)].map(|(from, to)| match from < to {
        true => ((from, to), true),
        false => ((to, from), false),
    })
}

/// Points that are farthest in directions spread over a sphere (a Fibonacci lattice): all that are so, up to a
/// number, those that are farthest out most often first, in the order in which they come.
fn fewer(points_m: &[Vector3<f64>], most: usize) -> Vec<Vector3<f64>> {
    if points_m.len() <= most {
        return points_m.to_vec();
    }
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let mut times = vec![0; points_m.len()];
    for index in 0..DIRECTIONS {
        let z = 1.0 - 2.0 * (index as f64 + 0.5) / DIRECTIONS as f64;
        let (sin, cos) = (golden * index as f64).sin_cos();
        let across = (1.0 - z * z).sqrt();
        let way = Vector3::new(across * cos, across * sin, z);
        let farthest = (0..points_m.len())
            .max_by(|a, b| points_m[*a].dot(&way).total_cmp(&points_m[*b].dot(&way)));
        if let Some(farthest) = farthest {
            times[farthest] += 1;
        }
    }
    let mut order: Vec<usize> = (0..points_m.len()).filter(|at| times[*at] > 0).collect();
    order.sort_by_key(|at| std::cmp::Reverse(times[*at]));
    order.truncate(most);
    order.sort_unstable();
    order.into_iter().map(|at| points_m[at]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An L of three cubes with sides of 20 mm, its corner at the origin.
    fn corner_piece() -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
        let outline = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]];
        let level = |z: f64| {
            outline.map(|[x, y]| Vector3::new(f64::from(x) * 0.02, f64::from(y) * 0.02, z))
        };
        let corners = [level(0.0), level(0.02)].concat();
        let mut triangles = Vec::new();
        for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
            triangles.push([a, c, b]);
            triangles.push([a + 6, b + 6, c + 6]);
        }
        for at in 0..6 {
            let next = (at + 1) % 6;
            triangles.push([at, next, next + 6]);
            triangles.push([at, next + 6, at + 6]);
        }
        (corners, triangles)
    }

    #[test]
    fn a_mesh_has_the_mass_of_its_boxes_and_pieces_that_leave_its_notch() {
        let (corners, triangles) = corner_piece();
        let mesh = TriangleMesh::new(&corners, &triangles).unwrap();
        let mass = mesh.mass().unwrap();
        assert!((mass.volume_m3 - 3.0 * 0.02_f64.powi(3)).abs() < 1e-18);
        let expected = Vector3::new(0.05 / 3.0, 0.05 / 3.0, 0.01);
        assert!((mass.centre_m - expected).norm() < 1e-12, "{mass:?}");
        // Each cube has s²/6 about its own middle.
        let side = 0.02_f64;
        let middles = [[0.5, 0.5], [1.5, 0.5], [0.5, 1.5]];
        let about_z: f64 = middles
            .iter()
            .map(|[x, y]| {
                let apart = Vector3::new(x * side, y * side, 0.01) - expected;
                side * side / 6.0 + apart.norm_squared()
            })
            .sum();
        assert!((mass.tensor_m2[(2, 2)] - about_z / 3.0).abs() < 1e-15);
        let pieces = mesh.pieces().unwrap();
        assert!(pieces.parts.len() >= 2);
        let solid = Shape::Compound(pieces).solid().unwrap();
        let ball = Shape::Sphere { radius_m: 0.004 }.solid().unwrap();
        let gap = |x: f64, y: f64| {
            let at = Pose::translation(x, y, 0.01);
            solid.distance_m(&Pose::identity(), &ball, &at).unwrap()
        };
        assert!(gap(0.03, 0.03) > 0.003, "{}", gap(0.03, 0.03));
        assert!(gap(0.01, 0.03) < 0.0);
    }

    #[test]
    fn seams_and_surfaces_that_are_inside_out_are_mended_and_holes_refused() {
        let (corners, triangles) = corner_piece();
        let whole = TriangleMesh::new(&corners, &triangles).unwrap();
        // Every triangle with corners of its own, the other way round.
        let loose: Vec<Vector3<f64>> = triangles
            .iter()
            .flat_map(|[a, b, c]| [a, c, b].map(|i| corners[*i as usize]))
            .collect();
        let numbers: Vec<[u32; 3]> = (0..triangles.len() as u32)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect();
        let mended = TriangleMesh::new(&loose, &numbers).unwrap();
        assert_eq!(mended.corners_m().len(), 12);
        let [a, b] = [&whole, &mended].map(|of| of.mass().unwrap());
        assert!((a.volume_m3 / b.volume_m3 - 1.0).abs() < 1e-12);
        let open = TriangleMesh::new(&corners, &triangles[1..]);
        assert!(
            matches!(open, Err(ShapeError::Open { open: 3, .. })),
            "{open:?}"
        );
        // Every third triangle the other way round.
        let mut mixed = triangles.clone();
        mixed.iter_mut().step_by(3).for_each(|of| of.swap(0, 1));
        let mended = TriangleMesh::new(&corners, &mixed).unwrap().mass().unwrap();
        assert!((a.volume_m3 / mended.volume_m3 - 1.0).abs() < 1e-12);
        assert!((a.centre_m - mended.centre_m).norm() < 1e-12);
        let hull = TriangleMesh::hull(&corners).unwrap();
        assert!((hull.mass().unwrap().volume_m3 / a.volume_m3 - 3.5 / 3.0).abs() < 1e-9);
        let missing = TriangleMesh::new(&corners, &[[0, 1, 99]]);
        assert!(matches!(missing, Err(ShapeError::Point { index: 99 })));
    }
}
