//! Gap, normal and points of a contact in given poses (paper §5.2).

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::error::Degenerate;
use super::pair::{Ball, Circle, Contact, Outward, Pair, Plane, Tube};
use crate::math::so3;
use crate::physics::state::State;

/// Sine of an angle below which a rim counts as flat on a face, and two lines as parallel.
const LEAST_SINE: f64 = 1e-9;

/// Distance \[m\] of centres below which they coincide.
const LEAST_DISTANCE_M: f64 = 1e-12;

/// Pose of a body's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Centre of mass [m, world].
    pub position_m: Vector3<f64>,
    /// World from body.
    pub orientation: UnitQuaternion<f64>,
}

impl Frame {
    /// The frame of the static world.
    pub fn world() -> Self {
        Self {
            position_m: Vector3::zeros(),
            orientation: UnitQuaternion::identity(),
        }
    }

    /// The frame of a body in a state.
    pub fn of(state: &State) -> Self {
        Self {
            position_m: state.position_m,
            orientation: state.orientation,
        }
    }
}

/// How two features touch, or nearly touch, in given poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Signed distance `φ` along the normal \[m\]; negative is penetration.
    pub gap_m: f64,
    /// Unit normal `n`, out of B towards A \[world\].
    pub normal: Vector3<f64>,
    /// The contact point on A's surface [m, A's axes].
    pub on_a_m: Vector3<f64>,
    /// The contact point on B's surface [m, B's axes].
    pub on_b_m: Vector3<f64>,
}

impl Touch {
    pub(super) fn mirrored(self) -> Self {
        Self {
            gap_m: self.gap_m,
            normal: -self.normal,
            on_a_m: self.on_b_m,
            on_b_m: self.on_a_m,
        }
    }
}

/// A frame with its rotation as a matrix.
#[derive(Clone, Copy)]
pub(super) struct Placed {
    pub(super) origin_m: Vector3<f64>,
    pub(super) rotation: Matrix3<f64>,
}

impl Placed {
    pub(super) fn new(frame: &Frame) -> Self {
        Self {
            origin_m: frame.position_m,
            rotation: so3::matrix(&frame.orientation),
        }
    }

    pub(super) fn point(&self, in_body: &Vector3<f64>) -> Vector3<f64> {
        self.origin_m + self.rotation * in_body
    }

    pub(super) fn to_body(self, point: &Vector3<f64>) -> Vector3<f64> {
        self.rotation.tr_mul(&(point - self.origin_m))
    }
}

impl Contact {
    /// The contact of two lines with the normal, in these poses, on the side of the given one \[world\], and always
    /// on that side of both lines: their gap is then smooth, and negative as deep as they go through each other. Other
    /// contacts stay.
    pub fn towards(mut self, a: &Frame, b: &Frame, normal: &Vector3<f64>) -> Self {
        if let Pair::LineLine(p, q, outward) = &mut self.pair {
            let cross = (a.orientation * p.direction).cross(&(b.orientation * q.direction));
            *outward = Outward::Crossed(cross.dot(normal).signum());
        }
        self
    }

    /// Gap, normal and points in these poses (B's is [`Frame::world`] for the static world).
    ///
    /// The gap is smooth in the poses except where the contact is degenerate, which is refused:
    /// a rim flat on a face, parallel lines, centres that coincide. Two lines touch with the
    /// normal on that side of both on which A's centre of mass lies; where that lies within the
    /// radius of A's line (the side of a cylinder), with the normal out of B's line towards
    /// A's. Rounded points and lines are then as deep as their radii at most.
    pub fn touch(&self, a: &Frame, b: &Frame) -> Result<Touch, Degenerate> {
        let (a, b) = (Placed::new(a), Placed::new(b));
        let touch = if self.mirrored {
            self.pair.touch(&b, &a)?.0.mirrored()
        } else {
            self.pair.touch(&a, &b)?.0
        };
        Ok(touch)
    }
}

/// Intermediate results that the derivative of a touch needs.
#[derive(Clone, Copy)]
pub(super) enum Measure {
    /// Nothing.
    None,
    /// Distance of the centres, or of a centre from a line \[m\], before the radii.
    Distance(f64),
    /// Sine between a rim's axis and the face's normal, and the way from the rim's centre to
    /// its lowest point [A's axes].
    Rim(f64, Vector3<f64>),
    /// `±(dA × dB)`, and how far along the lines they touch \[m\].
    Lines(Vector3<f64>, f64, f64),
}

impl Pair {
    pub(super) fn touch(&self, a: &Placed, b: &Placed) -> Result<(Touch, Measure), Degenerate> {
        match self {
            Pair::PointFace(ball, plane) => Ok((point_face(ball, plane, a, b), Measure::None)),
            Pair::RimFace(circle, plane) => rim_face(circle, plane, a, b),
            Pair::PointPoint(p, q) => point_point(p, q, a, b),
            Pair::PointLine(ball, tube) => point_line(ball, tube, a, b),
            Pair::LineLine(p, q, outward) => line_line(p, q, *outward, a, b),
        }
    }
}

/// `φ = n·(c − s) − r` with the ball's centre `c`, its radius `r` and a point `s` of the face; B's
/// point is the projection of A's on the face.
fn point_face(ball: &Ball, plane: &Plane, a: &Placed, b: &Placed) -> Touch {
    let normal = b.rotation * plane.normal;
    let centre = b.to_body(&a.point(&ball.centre_m));
    let height_m = plane.normal.dot(&(centre - plane.point_m));
    Touch {
        gap_m: height_m - ball.radius_m,
        normal,
        on_a_m: ball.centre_m - a.rotation.tr_mul(&normal) * ball.radius_m,
        on_b_m: centre - plane.normal * height_m,
    }
}

/// The rim's lowest point over the face: `c + r w`, `w = −(n − (n·a) a)/|n − (n·a) a|`, with its
/// centre `c` and axis `a`.
fn rim_face(
    circle: &Circle,
    plane: &Plane,
    a: &Placed,
    b: &Placed,
) -> Result<(Touch, Measure), Degenerate> {
    let normal = b.rotation * plane.normal;
    let in_a = a.rotation.tr_mul(&normal);
    let across = circle.axis * circle.axis.dot(&in_a) - in_a;
    let sine = across.norm();
    if !(sine >= LEAST_SINE) {
        return Err(Degenerate::FlatRim);
    }
    let down = across / sine;
    let on_a_m = circle.centre_m + down * circle.radius_m;
    let point = b.to_body(&a.point(&on_a_m));
    let gap_m = plane.normal.dot(&(point - plane.point_m));
    let touch = Touch {
        gap_m,
        normal,
        on_a_m,
        on_b_m: point - plane.normal * gap_m,
    };
    Ok((touch, Measure::Rim(sine, down)))
}

/// `φ = |cA − cB| − rA − rB` with centres `c` and radii `r`.
fn point_point(p: &Ball, q: &Ball, a: &Placed, b: &Placed) -> Result<(Touch, Measure), Degenerate> {
    let (normal, distance_m) = direction(a.point(&p.centre_m) - b.point(&q.centre_m))?;
    let touch = Touch {
        gap_m: distance_m - p.radius_m - q.radius_m,
        normal,
        on_a_m: p.centre_m - a.rotation.tr_mul(&normal) * p.radius_m,
        on_b_m: q.centre_m + b.rotation.tr_mul(&normal) * q.radius_m,
    };
    Ok((touch, Measure::Distance(distance_m)))
}

/// `φ = |d − (d·e) e| − rA − rB`, with the line's direction `e` and `d` from its point to the
/// centre.
fn point_line(
    ball: &Ball,
    tube: &Tube,
    a: &Placed,
    b: &Placed,
) -> Result<(Touch, Measure), Degenerate> {
    let along = b.rotation * tube.direction;
    let from_line = a.point(&ball.centre_m) - b.point(&tube.point_m);
    let along_m = along.dot(&from_line);
    let (normal, distance_m) = direction(from_line - along * along_m)?;
    let touch = Touch {
        gap_m: distance_m - ball.radius_m - tube.radius_m,
        normal,
        on_a_m: ball.centre_m - a.rotation.tr_mul(&normal) * ball.radius_m,
        on_b_m: tube.point_m
            + tube.direction * along_m
            + b.rotation.tr_mul(&normal) * tube.radius_m,
    };
    Ok((touch, Measure::Distance(distance_m)))
}

/// `φ = n·(pA − pB) − rA − rB` with `n = ±(dA × dB)/|dA × dB|`, points `p` and directions `d`.
fn line_line(
    p: &Tube,
    q: &Tube,
    outward: Outward,
    a: &Placed,
    b: &Placed,
) -> Result<(Touch, Measure), Degenerate> {
    let (along_a, along_b) = (a.rotation * p.direction, b.rotation * q.direction);
    let apart = a.point(&p.point_m) - b.point(&q.point_m);
    let cross = along_a.cross(&along_b);
    let sine = cross.norm();
    if !(sine >= LEAST_SINE) {
        return Err(Degenerate::ParallelLines);
    }
    let outward = match outward {
        Outward::Centre => -(a.rotation * p.point_m),
        Outward::Apart => apart,
        Outward::Crossed(sign) => cross * sign,
    };
    let cross = if cross.dot(&outward) < 0.0 {
        -cross
    } else {
        cross
    };
    let normal = cross / sine;
    // Solve for tA, tB: apart + tA dA − tB dB is along the normal. The normal's sign cancels.
    let signed = along_a.cross(&along_b) / (sine * sine);
    let along_a_m = -apart.cross(&along_b).dot(&signed);
    let along_b_m = -apart.cross(&along_a).dot(&signed);
    let touch = Touch {
        gap_m: normal.dot(&apart) - p.radius_m - q.radius_m,
        normal,
        on_a_m: p.point_m + p.direction * along_a_m - a.rotation.tr_mul(&normal) * p.radius_m,
        on_b_m: q.point_m + q.direction * along_b_m + b.rotation.tr_mul(&normal) * q.radius_m,
    };
    Ok((touch, Measure::Lines(cross, along_a_m, along_b_m)))
}

fn direction(apart: Vector3<f64>) -> Result<(Vector3<f64>, f64), Degenerate> {
    let distance_m = apart.norm();
    if !(distance_m >= LEAST_DISTANCE_M) {
        return Err(Degenerate::Coincident);
    }
    Ok((apart / distance_m, distance_m))
}
