//! What the piece before a node lacks to the state that is held there.

use enact::estimate::terms::context::SolveContext;
use enact::estimate::unknowns::point::Point;
use enact::math::so3;
use enact::optimise::block::{Block, BlockPattern};
use enact::physics::flow;
use enact::physics::state::DIMENSION as STATE;
use enact::physics::state::part;
use nalgebra::{DMatrix, Matrix3, SMatrix, Vector3};

use super::chain::Chains;
use super::parts::{Part, gravity};
use super::rows::fill_derivatives;
use super::simulate::units;

/// Twelve rows, in units, and their derivatives by both pieces' states and by gravity.
pub struct Join {
    values: Vec<f64>,
    by: DMatrix<f64>,
    gravity: Vec<Part>,
}

/// The gap between a piece flown to its end and the state of the next one.
pub fn between(context: &SolveContext, point: &Point, left: usize, right: usize) -> Join {
    let problem = context.problem;
    let acceleration = problem.gravity(&point.parameters);
    let body = problem.body_of(left);
    let s = context.epochs_s[right] - context.epochs_s[left];
    let from = &point.arcs[left];
    let end = flow::advance(body, &acceleration, from, s);
    let turn = flow::turn(body, &from.orientation, &from.angular_velocity_rad_s, s);
    let gap = end.minus(&point.arcs[right]);
    let logarithm: Vector3<f64> = gap.fixed_rows::<3>(part::ORIENTATION).into();
    let by_turn = so3::right_jacobian_inverse(&logarithm);

    let mut by_left = SMatrix::<f64, STATE, STATE>::identity();
    let mut set = |row: usize, column: usize, value: &Matrix3<f64>| {
        by_left.fixed_view_mut::<3, 3>(row, column).copy_from(value);
    };
    let identity = Matrix3::identity();
    set(part::POSITION, part::VELOCITY, &(identity * s));
    let (r, w) = (part::ORIENTATION, part::ANGULAR_VELOCITY);
    set(r, r, &(by_turn * turn.orientation_by_orientation));
    set(r, w, &(by_turn * turn.orientation_by_angular_velocity));
    set(w, w, &turn.angular_velocity_by_angular_velocity);
    let mut by_right = -SMatrix::<f64, STATE, STATE>::identity();
    by_right
        .fixed_view_mut::<3, 3>(r, r)
        .copy_from(&-by_turn.transpose());

    let free: Vec<Part> = gravity(problem).collect();
    let axes = (0..3).filter(|axis| problem.gravity_parameters[*axis].is_some());
    let units = units();
    let mut by = DMatrix::zeros(STATE, 2 * STATE + free.len());
    by.columns_mut(0, STATE).copy_from(&by_left);
    by.columns_mut(STATE, STATE).copy_from(&by_right);
    for (index, axis) in axes.enumerate() {
        by[(part::POSITION + axis, 2 * STATE + index)] = 0.5 * s * s;
        by[(part::VELOCITY + axis, 2 * STATE + index)] = s;
    }
    for row in 0..STATE {
        by.row_mut(row).scale_mut(1.0 / units[row]);
    }
    Join {
        values: gap.component_div(&units).iter().copied().collect(),
        by,
        gravity: free,
    }
}

impl Join {
    /// Its rows by the unknowns `target`.
    pub fn fill(
        &self,
        chains: &Chains,
        (left, right): (usize, usize),
        target: &[usize],
        (block, pattern): (&mut Block, &BlockPattern),
    ) {
        let mut parts = vec![Part::Piece(left), Part::Piece(right)];
        parts.extend(&self.gravity);
        let by = chains.chained(&self.by, &parts, target);
        block.reset(pattern);
        block.values.clone_from(&self.values);
        fill_derivatives(&by, (block, pattern));
    }
}
