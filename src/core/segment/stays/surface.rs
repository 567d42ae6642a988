//! Where a body stays on a surface: what of it is there keeps its height, to what noise and a hand leave of it.
//!
//! A ball is there by its lowest point, the side of a cylinder by its lowest line where its axis is level, and a face where it is
//! level, by the foot of the centre of mass on it.

use std::ops::Range;

use nalgebra::{Point3, UnitQuaternion, Vector3};

use super::local::{LocalMotion, LocalMotions, median};
use crate::math::Pose;
use crate::motion::{Link, LinkIndex, Scene, Timing};
use crate::physics::OnPlane;
use crate::physics::body::Symmetry;
use crate::physics::contact::{Contact, Feature, Frame};
use crate::physics::shape::Solid;

/// A surface may be so far from where the scene has it, as a share of the body's radius, least and most \[m\],
const OFF: [f64; 3] = [0.2, 0.004, 0.012];
/// and the height of what stays on it may change by so much.
const CHANGE: [f64; 3] = [0.1, 0.002, 0.006];
/// In an unknown tempo a low hop may be as slow as a hand: both are at most \[m\].
const SLOW_M: f64 = 0.003;
/// Greatest tilt of a face, or of an axis \[rad\].
const TILT_RAD: f64 = 0.1;
/// So many deviations are noise.
pub(super) const NOISE: f64 = 4.0;
/// What is slower than this is still, where noise is less [m/s], [rad/s].
pub(super) const STILL: [f64; 2] = [0.01, 0.1];
/// Greatest speed along the normal [m/s]; in an unknown tempo, with the share of the speed along the surface.
const LIFT_M_S: f64 = 0.07;
const SLOW_LIFT_M_S: f64 = 0.01;
const SLOW_LIFT_SHARE: f64 = 0.1;
/// A stretch is as long as this \[s\], and of so many samples.
pub(super) const LONG_S: f64 = 0.15;
pub(super) const LONG_SAMPLES: usize = 5;
/// Beyond its moments, samples that are at its height belong to a stretch for so long at most \[s\].
const BESIDE_S: f64 = 0.1;
/// Greatest distance of a ball's middle, or an axis, from the centre of mass \[m\].
const CENTRED_M: f64 = 1e-6;

/// What of a body may be on which surface.
pub(super) struct Footing {
    pub(super) surface: usize,
    pub(super) feature: usize,
    /// Unit normal of the surface \[world\].
    pub(super) normal: Vector3<f64>,
    pub(super) touching: OnPlane,
    contact: Contact,
    /// The solid of which the surface is a side, with its pose.
    of: Option<(Solid, Pose)>,
}

/// A stretch in which a body stays on a surface.
pub(super) struct Stay {
    /// Index into the footings.
    pub(super) footing: usize,
    /// The moments.
    pub(super) moments: Range<usize>,
    /// When it begins and ends \[s\].
    pub(super) span_s: [f64; 2],
}

/// All ways in which gravity may press a body onto a surface.
pub(super) fn footings(scene: &Scene, link: LinkIndex) -> Vec<Footing> {
    let of = &scene.links[link];
    let pull = of.body.pull_m_s2(&scene.gravity_m_s2);
    let mut found = Vec::new();
    for (surface, plane) in scene.surfaces.iter().enumerate() {
        let Feature::Face { normal, .. } = plane.geometry else {
            continue;
        };
        if pull.dot(&normal) >= 0.0 {
            continue;
        }
        for feature in 0..of.features.len() {
            let Some(touching) = touching(of, feature) else {
                continue;
            };
            let probe = match touching {
                OnPlane::Ball { radius_m } | OnPlane::Side { radius_m, .. } => Feature::Point {
                    point_m: Vector3::zeros(),
                    radius_m,
                },
                OnPlane::Face { point_m, normal } => Feature::corner(normal * normal.dot(&point_m)),
            };
            let Ok(contact) = Contact::new(probe, plane.geometry) else {
                continue;
            };
            let solid = plane.obstacle.and_then(|obstacle| {
                let obstacle = &scene.obstacles[obstacle];
                Some((obstacle.shape.solid().ok()?, obstacle.world_from_shape))
            });
            found.push(Footing {
                surface,
                feature,
                normal,
                touching,
                contact,
                of: solid,
            });
        }
    }
    found
}

/// How a feature of a body may be on a plane, if it may for a while.
fn touching(link: &Link, feature: usize) -> Option<OnPlane> {
    let symmetry = link.body.symmetry();
    match link.features[feature].geometry {
        Feature::Face { point_m, normal } => Some(OnPlane::Face { point_m, normal }),
        Feature::Point { point_m, radius_m } => {
            let is_ball =
                radius_m > 0.0 && point_m.norm() <= CENTRED_M && symmetry == Symmetry::Spherical;
            is_ball.then_some(OnPlane::Ball { radius_m })
        }
        Feature::Line {
            point_m,
            direction,
            radius_m,
        } => {
            let is_round = match symmetry {
                Symmetry::Spherical => true,
                Symmetry::Axial { axis } => direction[axis].abs() > 1.0 - CENTRED_M,
                Symmetry::Asymmetric => false,
            };
            let is_side = is_round && radius_m > 0.0;
            let is_centred = point_m.cross(&direction).norm() <= CENTRED_M;
            (is_side && is_centred).then_some(OnPlane::Side {
                radius_m,
                axis: direction,
            })
        }
        Feature::Rim { .. } => None,
    }
}

impl Footing {
    /// Height over the surface \[m\].
    fn height_m(&self, pose: &Pose) -> Option<f64> {
        let frame = Frame {
            position_m: pose.translation.vector,
            orientation: pose.rotation,
        };
        Some(self.contact.touch(&frame, &Frame::world()).ok()?.gap_m)
    }

    /// By how much it is tilted \[rad\].
    fn tilt_rad(&self, turn: &UnitQuaternion<f64>) -> f64 {
        match self.touching {
            OnPlane::Ball { .. } => 0.0,
            OnPlane::Face { normal, .. } => (turn * normal).angle(&-self.normal),
            OnPlane::Side { axis, .. } => {
                let rise = (turn * axis).dot(&self.normal);
                rise.abs().min(1.0).asin()
            }
        }
    }

    /// Whether the centre of mass is over the surface, which ends.
    fn is_over(&self, pose: &Pose, reach_m: f64) -> bool {
        let Some((solid, world_from_solid)) = &self.of else {
            return true;
        };
        let Some(height_m) = self.height_m(pose) else {
            return false;
        };
        let centre_m = pose.translation.vector;
        let arm_m = match self.touching {
            OnPlane::Ball { radius_m } | OnPlane::Side { radius_m, .. } => radius_m,
            OnPlane::Face { point_m, normal } => normal.dot(&point_m),
        };
        let foot = Pose::from(Point3::from(centre_m - self.normal * (arm_m + height_m)).coords);
        let point = Solid::ball(0.0);
        let closest = point.closest(&foot, solid, world_from_solid);
        closest.is_ok_and(|of| of.gap_m <= reach_m)
    }

    /// The velocity of what touches, along the surface [m/s].
    pub(super) fn slip_m_s(&self, of: &LocalMotion) -> Vector3<f64> {
        let turned = match self.touching {
            OnPlane::Ball { radius_m } | OnPlane::Side { radius_m, .. } => {
                of.spin_rad_s.cross(&(self.normal * -radius_m))
            }
            OnPlane::Face { .. } => Vector3::zeros(),
        };
        self.along(of.velocity_m_s + turned)
    }

    /// The part of a vector along the surface.
    pub(super) fn along(&self, of: Vector3<f64>) -> Vector3<f64> {
        of - self.normal * self.normal.dot(&of)
    }

    /// The stretches in which a body stays there.
    pub(super) fn stays(
        &self,
        scene: &Scene,
        link: &Link,
        motions: &LocalMotions,
    ) -> Vec<(Range<usize>, [f64; 2])> {
        let is_slow = matches!(scene.timing, Timing::Unknown { .. });
        let noise_m = NOISE * motions.noise_m;
        let limit_m = |[share, least_m, most_m]: [f64; 3]| {
            let limit_m = (share * link.radius_m()).clamp(least_m, most_m);
            let limit_m = if is_slow {
                limit_m.min(SLOW_M)
            } else {
                limit_m
            };
            limit_m.max(scene.tolerance_m) + noise_m
        };
        let (off_m, change_m) = (limit_m(OFF), limit_m(CHANGE));
        let tilt_rad = TILT_RAD + NOISE * motions.noise_rad;
        let height_m = |of: &LocalMotion| {
            if self.tilt_rad(&of.pose.rotation) > tilt_rad {
                return None;
            }
            let height_m = self.height_m(&of.pose)?;
            let lift_m_s = self.normal.dot(&of.velocity_m_s).abs();
            let along_m_s = self.along(of.velocity_m_s).norm();
            let most_m_s = match is_slow {
                true => SLOW_LIFT_M_S + SLOW_LIFT_SHARE * along_m_s,
                false => LIFT_M_S,
            };
            let is_there = height_m.abs() <= off_m
                && lift_m_s <= most_m_s + NOISE * motions.velocity_sd_m_s
                && self.is_over(&of.pose, off_m);
            is_there.then_some(height_m)
        };
        let heights_m: Vec<Option<f64>> = motions.each.iter().map(height_m).collect();
        let mut found = Vec::new();
        let mut begin = 0;
        while begin < heights_m.len() {
            let is_next = |at: &usize| {
                let is_gap =
                    *at > begin && motions.each[*at].time_s - motions.each[at - 1].time_s > LONG_S;
                heights_m[*at].is_some() && !is_gap
            };
            let end = (begin..heights_m.len())
                .find(|at| !is_next(at))
                .unwrap_or(heights_m.len());
            let usual_m = median(heights_m[begin..end].iter().flatten().copied());
            if let Some(usual_m) = usual_m {
                let kept = longest(begin..end, |at| {
                    heights_m[at].is_some_and(|height_m| (height_m - usual_m).abs() <= change_m)
                });
                let span_s = self.span_s(motions, &kept, usual_m);
                if span_s[1] - span_s[0] >= LONG_S && motions.count(span_s) >= LONG_SAMPLES {
                    found.push((kept, span_s));
                }
            }
            begin = end.max(begin + 1);
        }
        found
    }

    /// When a stretch begins and ends \[s\]: samples beside its moments belong to it as long as they are at its height.
    fn span_s(&self, motions: &LocalMotions, moments: &Range<usize>, usual_m: f64) -> [f64; 2] {
        if moments.is_empty() {
            return [0.0, 0.0];
        }
        let inner_s = [moments.start, moments.end - 1].map(|at| motions.each[at].time_s);
        let poses = &motions.poses;
        let within = motions.within(inner_s);
        let off_m = |at: usize| {
            self.height_m(&poses[at].1)
                .map_or(f64::INFINITY, |of| (of - usual_m).abs())
        };
        let scatter_m = median(within.clone().map(off_m)).unwrap_or(0.0);
        let reach_m = (NOISE * motions.noise_m).max(NOISE * scatter_m).max(1e-5);
        let is_there = |at: &usize, from_s: f64| {
            (poses[*at].0 - from_s).abs() <= BESIDE_S && off_m(*at) <= reach_m
        };
        let before = (0..within.start)
            .rev()
            .take_while(|at| is_there(at, inner_s[0]));
        let after = (within.end..poses.len()).take_while(|at| is_there(at, inner_s[1]));
        let first = before.last().unwrap_or(within.start);
        let last = after.last().unwrap_or(within.end.saturating_sub(1));
        let begin_s = match first.checked_sub(1) {
            Some(before) => 0.5 * (poses[before].0 + poses[first].0),
            None => poses[first].0,
        };
        let end_s = match poses.get(last + 1) {
            Some(after) => 0.5 * (poses[last].0 + after.0),
            None => poses[last].0,
        };
        // Beside a gap of the stream nothing is known.
        [
            begin_s.max(poses[first].0 - BESIDE_S),
            end_s.min(poses[last].0 + BESIDE_S),
        ]
    }
}

/// The longest part of a range in which something holds.
fn longest(range: Range<usize>, holds: impl Fn(usize) -> bool) -> Range<usize> {
    let mut best = range.start..range.start;
    let mut begin = range.start;
    for at in range.start..=range.end {
        if at == range.end || !holds(at) {
            if at - begin > best.len() {
                best = begin..at;
            }
            begin = at + 1;
        }
    }
    best
}

/// The stretches in which a body stays on surfaces, in order of time; where there are several at one time, the longest.
pub(super) fn stays(
    scene: &Scene,
    link: LinkIndex,
    footings: &[Footing],
    motions: &LocalMotions,
) -> Vec<Stay> {
    let mut all: Vec<Stay> = Vec::new();
    for (footing, of) in footings.iter().enumerate() {
        let each = of.stays(scene, &scene.links[link], motions).into_iter();
        all.extend(each.map(|(moments, span_s)| Stay {
            footing,
            moments,
            span_s,
        }));
    }
    all.sort_by(|a, b| {
        let long_s = |of: &Stay| of.span_s[1] - of.span_s[0];
        long_s(b).total_cmp(&long_s(a))
    });
    let mut kept: Vec<Stay> = Vec::new();
    for stay in all {
        let overlaps = |other: &Stay| {
            other.moments.start < stay.moments.end && stay.moments.start < other.moments.end
        };
        if !kept.iter().any(overlaps) {
            kept.push(stay);
        }
    }
    kept.sort_by_key(|stay| stay.moments.start);
    for at in 1..kept.len() {
        let [end_s, begin_s] = [kept[at - 1].span_s[1], kept[at].span_s[0]];
        if end_s > begin_s {
            let between_s = 0.5 * (end_s + begin_s);
            kept[at - 1].span_s[1] = between_s;
            kept[at].span_s[0] = between_s;
        }
    }
    kept
}
