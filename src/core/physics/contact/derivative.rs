//! Derivatives of a touch by the poses.
//!
//! In this file a body moves by `(δx, ψ)`, displacement [m, world] and rotation [rad, world], so
//! that a point `q` of it moves by `δx + ψ × (q − x)` and a direction `d` by `ψ × d`. Substituting
//! `ψ = R θ` gives the derivatives by the right perturbation `θ`.

use nalgebra::{RowSVector, SMatrix, Vector3};

use super::error::Degenerate;
use super::pair::{Ball, Circle, Contact, Pair, Plane, Tube};
use super::touch::{Frame, Measure, Placed, Touch};
use crate::math::so3;

/// Derivatives of a [`Touch`], by twelve columns: position [m, world] and orientation [rad,
/// body, right] of A, then of B.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchDerivative {
    /// Of the gap: `n`, `pA × RAᵀn`, `−n`, `−pB × RBᵀn`, with the contact points `p` in body axes.
    pub gap: RowSVector<f64, 12>,
    /// Of the normal \[world\].
    pub normal: SMatrix<f64, 3, 12>,
    /// Of A's point [A's axes].
    pub on_a: SMatrix<f64, 3, 12>,
    /// Of B's point [B's axes].
    pub on_b: SMatrix<f64, 3, 12>,
}

/// Derivative of a vector by `(δxA, ψA, δxB, ψB)`.
type Rate = SMatrix<f64, 3, 12>;

/// Derivatives of normal, A's point and B's point.
type Rates = (Rate, Rate, Rate);

impl Contact {
    /// [`Contact::touch`] and its derivatives by the poses.
    pub fn touch_derivative(
        &self,
        a: &Frame,
        b: &Frame,
    ) -> Result<(Touch, TouchDerivative), Degenerate> {
        let (a, b) = (Placed::new(a), Placed::new(b));
        let (touch, (normal, on_a, on_b)) = if self.mirrored {
            let (touch, (normal, on_b, on_a)) = self.pair.rates(&b, &a)?;
            let rates = (-swapped(&normal), swapped(&on_a), swapped(&on_b));
            (touch.mirrored(), rates)
        } else {
            self.pair.rates(&a, &b)?
        };
        let mut gap = RowSVector::<f64, 12>::zeros();
        for (column, placed, point, normal) in [
            (0, &a, &touch.on_a_m, touch.normal),
            (6, &b, &touch.on_b_m, -touch.normal),
        ] {
            gap.fixed_columns_mut::<3>(column).tr_copy_from(&normal);
            gap.fixed_columns_mut::<3>(column + 3)
                .tr_copy_from(&point.cross(&placed.rotation.tr_mul(&normal)));
        }
        let by_right = |rate: Rate| {
            let mut result = rate;
            for (column, placed) in [(3, &a), (9, &b)] {
                let turned = rate.fixed_columns::<3>(column) * placed.rotation;
                result.fixed_columns_mut::<3>(column).copy_from(&turned);
            }
            result
        };
        let derivative = TouchDerivative {
            gap,
            normal: by_right(normal),
            on_a: by_right(on_a),
            on_b: by_right(on_b),
        };
        Ok((touch, derivative))
    }
}

/// Columns of A and B exchanged.
fn swapped(rate: &Rate) -> Rate {
    let mut result = *rate;
    result
        .fixed_columns_mut::<6>(0)
        .copy_from(&rate.fixed_columns::<6>(6));
    result
        .fixed_columns_mut::<6>(6)
        .copy_from(&rate.fixed_columns::<6>(0));
    result
}

/// Where a side's columns begin.
#[derive(Clone, Copy)]
enum FirstColumn {
    A = 0,
    B = 6,
}

/// Derivative of a point fixed to a body, `arm` from its centre of mass [m, world].
fn carried(side: FirstColumn, arm: &Vector3<f64>) -> Rate {
    let mut rate = turned(side, arm);
    rate.fixed_view_mut::<3, 3>(0, side as usize)
        .fill_diagonal(1.0);
    rate
}

/// Derivative of a direction [world] fixed to a body.
fn turned(side: FirstColumn, direction: &Vector3<f64>) -> Rate {
    let mut rate = Rate::zeros();
    rate.fixed_view_mut::<3, 3>(0, side as usize + 3)
        .copy_from(&-so3::hat(direction));
    rate
}

/// Derivative, in a body's axes, of a direction [world] with the derivative `rate` [world].
fn seen(side: FirstColumn, placed: &Placed, direction: &Vector3<f64>, rate: &Rate) -> Rate {
    placed.rotation.tr_mul(&(rate - turned(side, direction)))
}

/// The part of a derivative perpendicular to a unit vector.
fn across(unit: &Vector3<f64>, rate: &Rate) -> Rate {
    rate - unit * unit.tr_mul(rate)
}

impl Pair {
    fn rates(&self, a: &Placed, b: &Placed) -> Result<(Touch, Rates), Degenerate> {
        let (touch, measure) = self.touch(a, b)?;
        let rates = match (self, measure) {
            (Pair::PointFace(ball, plane), _) => point_face(ball, plane, &touch, a, b),
            (Pair::RimFace(circle, plane), Measure::Rim(sine, down)) => {
                rim_face(circle, plane, &touch, sine, &down, a, b)
            }
            (Pair::PointPoint(p, q), Measure::Distance(distance_m)) => {
                point_point(p, q, &touch, distance_m, a, b)
            }
            (Pair::PointLine(ball, tube), Measure::Distance(distance_m)) => {
                point_line(ball, tube, &touch, distance_m, a, b)
            }
            (Pair::LineLine(p, q, _), Measure::Lines(cross, along_a_m, along_b_m)) => {
                line_line(p, q, &touch, &cross, (along_a_m, along_b_m), a, b)
            }
            _ => unreachable!("every pair comes with its own measure"),
        };
        Ok((touch, rates))
    }
}

/// Derivative, in B's axes, of the projection on B's face of a point of A. The point is `arm` from
/// A's centre of mass [m, world]; `slide` [world] is its motion relative to A.
fn foot(plane: &Plane, arm: &Vector3<f64>, slide: &Rate, a: &Placed, b: &Placed) -> Rate {
    let from_b = a.origin_m + arm - b.origin_m;
    let relative = carried(FirstColumn::A, arm) + slide - carried(FirstColumn::B, &from_b);
    across(&plane.normal, &b.rotation.tr_mul(&relative))
}

fn point_face(ball: &Ball, plane: &Plane, touch: &Touch, a: &Placed, b: &Placed) -> Rates {
    let normal = turned(FirstColumn::B, &touch.normal);
    let on_a = seen(FirstColumn::A, a, &touch.normal, &normal) * -ball.radius_m;
    let on_b = foot(plane, &(a.rotation * ball.centre_m), &Rate::zeros(), a, b);
    (normal, on_a, on_b)
}

fn rim_face(
    circle: &Circle,
    plane: &Plane,
    touch: &Touch,
    sine: f64,
    down: &Vector3<f64>,
    a: &Placed,
    b: &Placed,
) -> Rates {
    let normal = turned(FirstColumn::B, &touch.normal);
    let in_a = seen(FirstColumn::A, a, &touch.normal, &normal);
    let on_a = across(down, &across(&circle.axis, &in_a)) * (-circle.radius_m / sine);
    let arm = a.rotation * touch.on_a_m;
    let on_b = foot(plane, &arm, &(a.rotation * on_a), a, b);
    (normal, on_a, on_b)
}

fn point_point(
    p: &Ball,
    q: &Ball,
    touch: &Touch,
    distance_m: f64,
    a: &Placed,
    b: &Placed,
) -> Rates {
    let apart = carried(FirstColumn::A, &(a.rotation * p.centre_m))
        - carried(FirstColumn::B, &(b.rotation * q.centre_m));
    let normal = across(&touch.normal, &apart) / distance_m;
    let on_a = seen(FirstColumn::A, a, &touch.normal, &normal) * -p.radius_m;
    let on_b = seen(FirstColumn::B, b, &touch.normal, &normal) * q.radius_m;
    (normal, on_a, on_b)
}

fn point_line(
    ball: &Ball,
    tube: &Tube,
    touch: &Touch,
    distance_m: f64,
    a: &Placed,
    b: &Placed,
) -> Rates {
    let along = b.rotation * tube.direction;
    let from_line = a.point(&ball.centre_m) - b.point(&tube.point_m);
    let moved = carried(FirstColumn::A, &(a.rotation * ball.centre_m))
        - carried(FirstColumn::B, &(b.rotation * tube.point_m));
    let along_moved = turned(FirstColumn::B, &along);
    let slid = from_line.tr_mul(&along_moved) + along.tr_mul(&moved);
    let off_line = moved - along * slid - along_moved * along.dot(&from_line);
    let normal = across(&touch.normal, &off_line) / distance_m;
    let on_a = seen(FirstColumn::A, a, &touch.normal, &normal) * -ball.radius_m;
    let on_b =
        tube.direction * slid + seen(FirstColumn::B, b, &touch.normal, &normal) * tube.radius_m;
    (normal, on_a, on_b)
}

fn line_line(
    p: &Tube,
    q: &Tube,
    touch: &Touch,
    cross: &Vector3<f64>,
    (along_a_m, along_b_m): (f64, f64),
    a: &Placed,
    b: &Placed,
) -> Rates {
    let (along_a, along_b) = (a.rotation * p.direction, b.rotation * q.direction);
    let (turned_a, turned_b) = (
        turned(FirstColumn::A, &along_a),
        turned(FirstColumn::B, &along_b),
    );
    let crossed = so3::hat(&along_a) * turned_b - so3::hat(&along_b) * turned_a;
    let sign = along_a.cross(&along_b).dot(cross).signum();
    let square = cross.norm_squared();
    let normal = across(&touch.normal, &crossed) * (sign / square.sqrt());
    // Differentiate apart + tA dA − tB dB = (n·apart) n. Cross products with dB and dA isolate δtA
    // and δtB.
    let apart = a.point(&p.point_m) - b.point(&q.point_m);
    let moved = carried(FirstColumn::A, &(a.rotation * p.point_m))
        - carried(FirstColumn::B, &(b.rotation * q.point_m))
        + turned_a * along_a_m
        - turned_b * along_b_m
        - normal * touch.normal.dot(&apart);
    let signed = cross * (sign / square);
    let slid_a = -along_b.cross(&signed).tr_mul(&moved);
    let slid_b = -along_a.cross(&signed).tr_mul(&moved);
    let on_a = p.direction * slid_a - seen(FirstColumn::A, a, &touch.normal, &normal) * p.radius_m;
    let on_b = q.direction * slid_b + seen(FirstColumn::B, b, &touch.normal, &normal) * q.radius_m;
    (normal, on_a, on_b)
}
