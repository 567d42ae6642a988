//! What is seen of a solid: its outline, its lit parts and its edges, on a picture.
//!
//! Of triangles that look to the viewer those of about one brightness become one part: where two of them
//! meet the edge is passed in both directions and goes, and what is left are the part's borders. So a box has
//! three parts and a cylinder some strips, however many triangles there are.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::camera::Camera;
use super::mesh::Triangle;
use crate::math::Pose;

/// How many brightnesses there are.
pub const SHADES: usize = 6;

/// Two sides that meet at a greater angle have an edge that is drawn, as the cosine.
const CREASE: f64 = 0.85;

/// A closed line on a picture \[m\].
pub type Loop = Vec<[f64; 2]>;

/// What is seen of a solid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    /// Its border.
    pub silhouette: Vec<Loop>,
    /// Parts of it by their brightness, 0 the darkest, `SHADES - 1` the brightest.
    pub parts: Vec<(usize, Vec<Loop>)>,
    /// Edges between parts that look in different directions.
    pub creases: Vec<[[f64; 2]; 2]>,
}

/// A corner by its exact place.
type Corner = [u64; 3];

/// What is seen of the closed surface of a solid at that pose. Light comes from above the viewer's left.
/// Nothing is seen of a surface without triangles.
pub fn outline(surface: &[Triangle], world_from_shape: &Pose, camera: &Camera) -> Outline {
    let light = (camera.back + camera.up * 0.8 - camera.right * 0.55).normalize();
    let mut places: BTreeMap<Corner, [f64; 2]> = BTreeMap::new();
    let mut all = Border::default();
    let mut parts: BTreeMap<usize, Border> = BTreeMap::new();
    // Seen sides of each edge: their directions.
    let mut sides: BTreeMap<[Corner; 2], Vec<Vector3<f64>>> = BTreeMap::new();
    for triangle in surface {
        let [a, b, c] = triangle.map(|corner| world_from_shape.transform_vector(&corner));
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(1e-15) else {
            continue;
        };
        if normal.dot(&camera.back) <= 1e-6 {
            continue;
        }
        let corners = triangle.map(|corner| {
            // Zeros of either sign are one number.
            let key = [corner.x + 0.0, corner.y + 0.0, corner.z + 0.0].map(f64::to_bits);
            places.entry(key).or_insert_with(|| {
                let at = world_from_shape.transform_point(&corner.into());
                camera.project(&at.coords)
            });
            key
        });
        let shade = shade(normal.dot(&light));
        for (from, to) in [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (corners[i], corners[j])) {
            all.pass(from, to);
            parts.entry(shade).or_default().pass(from, to);
            let edge = if from < to { [from, to] } else { [to, from] };
            sides.entry(edge).or_default().push(normal);
        }
    }
    let creases = sides
        .iter()
        .filter_map(|([from, to], sides)| match sides[..] {
            [a, b] if a.dot(&b) < CREASE => Some([places[from], places[to]]),
            _ => None,
        });
    Outline {
        creases: creases.collect(),
        silhouette: all.loops(&places),
        parts: parts
            .into_iter()
            .map(|(shade, border)| (shade, border.loops(&places)))
            .collect(),
    }
}

/// The brightness of a side whose direction makes an angle of that cosine with the light's.
fn shade(cosine: f64) -> usize {
    let lit = (0.5 + 0.5 * cosine).clamp(0.0, 1.0);
    // What is seen is rarely turned from the light: the upper half has all brightnesses but one.
    let level = ((lit - 0.4) / 0.6 * SHADES as f64).floor();
    level.clamp(0.0, (SHADES - 1) as f64) as usize
}

/// Edges that were passed in one direction only.
#[derive(Default)]
struct Border {
    edges: BTreeMap<Corner, Vec<Corner>>,
}

impl Border {
    fn pass(&mut self, from: Corner, to: Corner) {
        if let Some(back) = self.edges.get_mut(&to)
            && let Some(at) = back.iter().position(|end| *end == from)
        {
            back.swap_remove(at);
            if back.is_empty() {
                self.edges.remove(&to);
            }
            return;
        }
        self.edges.entry(from).or_default().push(to);
    }

    /// The edges as closed lines.
    fn loops(mut self, places: &BTreeMap<Corner, [f64; 2]>) -> Vec<Loop> {
        let mut loops = Vec::new();
        while let Some((&first, _)) = self.edges.first_key_value() {
            let mut line = Vec::new();
            let mut at = first;
            while let Some(ends) = self.edges.get_mut(&at) {
                line.push(places[&at]);
                let next = ends.pop();
                if ends.is_empty() {
                    self.edges.remove(&at);
                }
                match next {
                    Some(next) => at = next,
                    None => break,
                }
                if at == first {
                    break;
                }
            }
            if line.len() > 2 {
                loops.push(line);
            }
        }
        loops
    }
}

/// A closed line without points that are nearer to the line between others than that \[m\].
pub fn simplified(line: &Loop, tolerance_m: f64) -> Loop {
    if line.len() < 4 {
        return line.clone();
    }
    // From the point that is farthest from the first, both ways.
    let distance = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let far = (0..line.len())
        .max_by(|i, j| distance(&line[*i], &line[0]).total_cmp(&distance(&line[*j], &line[0])))
        .unwrap_or(0);
    let there = &line[..=far];
    let back: Vec<[f64; 2]> = line[far..].iter().chain(&line[..1]).copied().collect();
    let mut kept = chain(there, tolerance_m);
    kept.pop();
    kept.extend(chain(&back, tolerance_m));
    kept.pop();
    kept
}

/// The points of an open line that are needed to be within a distance of all (Douglas and Peucker).
pub fn chain(line: &[[f64; 2]], tolerance_m: f64) -> Vec<[f64; 2]> {
    let (Some(first), Some(last)) = (line.first(), line.last()) else {
        return Vec::new();
    };
    let along = [last[0] - first[0], last[1] - first[1]];
    let length = along[0].hypot(along[1]);
    let off = |point: &[f64; 2]| {
        let to = [point[0] - first[0], point[1] - first[1]];
        match length > 0.0 {
            true => (along[0] * to[1] - along[1] * to[0]).abs() / length,
            false => to[0].hypot(to[1]),
        }
    };
    let inner = 1..line.len().saturating_sub(1);
    let far = inner.max_by(|i, j| off(&line[*i]).total_cmp(&off(&line[*j])));
    match far {
        Some(far) if off(&line[far]) > tolerance_m => {
            let mut kept = chain(&line[..=far], tolerance_m);
            kept.pop();
            kept.extend(chain(&line[far..], tolerance_m));
            kept
        }
        _ if line.len() > 1 => vec![*first, *last],
        _ => vec![*first],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::Shape;
    use crate::visual::{View, mesh};

    fn area_m2(loops: &[Loop]) -> f64 {
        let of = |line: &Loop| {
            let next = line.iter().cycle().skip(1);
            let sum = line
                .iter()
                .zip(next)
                .map(|(a, b)| a[0] * b[1] - a[1] * b[0]);
            0.5 * sum.sum::<f64>()
        };
        loops.iter().map(of).sum()
    }

    fn camera(view: View) -> Camera {
        Camera::new(view, &-Vector3::z(), &[])
    }

    #[test]
    fn a_box_has_three_sides_and_their_parts_make_up_its_outline() {
        let half_extents_m = Vector3::new(0.1, 0.2, 0.3);
        let surface = mesh(&Shape::Cuboid { half_extents_m });
        let seen = outline(&surface, &Pose::identity(), &camera(View::ThreeQuarter));
        assert_eq!(seen.silhouette.len(), 1);
        assert_eq!(simplified(&seen.silhouette[0], 1e-9).len(), 6);
        // Three edges meet at the nearest corner.
        assert_eq!(seen.creases.len(), 3);
        let whole_m2 = area_m2(&seen.silhouette);
        let parts_m2: f64 = seen.parts.iter().map(|(_, loops)| area_m2(loops)).sum();
        assert!(whole_m2 > 0.0 && (parts_m2 / whole_m2 - 1.0).abs() < 1e-12);
        // Seen from the front a side hides all others.
        let front = outline(&surface, &Pose::identity(), &camera(View::Front));
        assert!((area_m2(&front.silhouette) - 0.2 * 0.6).abs() < 1e-12);
        assert!(front.creases.is_empty() && front.parts.len() == 1);
        // From above brightest.
        let shades: Vec<usize> = seen.parts.iter().map(|(shade, _)| *shade).collect();
        assert!(
            shades.last().is_some_and(|shade| *shade >= SHADES - 2),
            "{shades:?}"
        );
    }

    #[test]
    fn round_solids_have_the_outlines_of_their_meshes() {
        let radius_m = 0.1;
        let ball = outline(
            &mesh(&Shape::Sphere { radius_m }),
            &Pose::translation(1.0, 2.0, 3.0),
            &camera(View::Front),
        );
        let disc_m2 = std::f64::consts::PI * radius_m * radius_m;
        let ratio = area_m2(&ball.silhouette) / disc_m2;
        assert!((0.98..1.0).contains(&ratio), "{ratio}");
        assert!(ball.creases.is_empty(), "a ball has no edge");
        assert!(ball.silhouette[0].iter().all(|[x_m, z_m]| {
            ((x_m - 1.0).hypot(z_m - 3.0) - radius_m).abs() < 0.01 * radius_m
        }));
        let (half_length_m, radius_m) = (0.3, 0.1);
        let cylinder = mesh(&Shape::Cylinder {
            half_length_m,
            radius_m,
        });
        let seen = outline(&cylinder, &Pose::identity(), &camera(View::Front));
        let ratio = area_m2(&seen.silhouette) / (0.6 * 0.2);
        assert!((ratio - 1.0).abs() < 1e-3, "{ratio}");
        assert!(outline(&[], &Pose::identity(), &camera(View::Top)) == Outline::default());
    }

    #[test]
    fn a_line_keeps_the_points_that_make_it() {
        let square: Loop = vec![
            [0.0, 0.0],
            [0.5, 0.0],
            [1.0, 0.0],
            [1.0, 1.0],
            [0.5, 1.0],
            [0.0, 1.0],
        ];
        let kept = simplified(&square, 1e-9);
        assert_eq!(kept.len(), 4);
        assert!((area_m2(&[kept]) - 1.0).abs() < 1e-12);
        assert_eq!(chain(&[[0.0, 0.0], [1.0, 0.1], [2.0, 0.0]], 0.05).len(), 3);
        assert_eq!(chain(&[[0.0, 0.0], [1.0, 0.1], [2.0, 0.0]], 0.2).len(), 2);
        assert!(chain(&[], 1.0).is_empty());
    }
}
