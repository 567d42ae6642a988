//! Variances at an optimum.

mod joint;

use std::cell::OnceCell;

use nalgebra::{DMatrix, DVector};

use super::in_time::InTime;
use super::timing::Moment;
use super::vague::VagueErrors;
use crate::estimate::terms::context::SolveContext;
use crate::estimate::terms::held;
use crate::estimate::unknowns::point::Point;
use crate::motion::Variance;
use crate::optimise::active::ActiveSet;
use crate::optimise::envelope::Envelope;
use crate::optimise::kkt::{DAMPING, Kkt};
use crate::optimise::{Program, System};

/// Covariances at an optimum.
pub struct Covariance<'a> {
    context: &'a SolveContext<'a>,
    system: &'a System,
    point: &'a Point,
    multipliers: &'a [f64],
    kkt: Kkt,
    /// The Hessian with curvature, where that is in it.
    curved: Option<Envelope>,
    /// Gradient of the Lagrangian without the pulls of bounds: where these act, it is not zero.
    slope: DVector<f64>,
    /// The samples' own part of the Hessian.
    of_samples: Envelope,
    /// What samples err by, where weights are not those of their errors.
    in_time: Option<&'a InTime>,
    /// What residuals leave open of errors with whose weights the motion was found.
    vague: OnceCell<Option<VagueErrors>>,
}

impl<'a> Covariance<'a> {
    /// The covariances at an optimum; `None` where the matrix cannot be factorised. Where nothing is known of what samples err
    /// by, weights are those of their errors.
    pub fn new(
        context: &'a SolveContext<'a>,
        point: &'a Point,
        system: &'a System,
        multipliers: &'a [f64],
        in_time: Option<&'a InTime>,
    ) -> Option<Self> {
        let curved = curved(context, (point, system), multipliers);
        let kkt = with_soft_bounds(context, system, curved.as_ref(), multipliers)?;
        let slope = slope_without_bounds(context, system, multipliers);
        Some(Self {
            context,
            system,
            point,
            multipliers,
            kkt,
            curved,
            slope,
            of_samples: context.of_samples(point),
            in_time,
            vague: OnceCell::new(),
        })
    }

    /// `(H + w CᵀC)⁻¹` of the unknowns `at`: their covariance if the weights were those of the
    /// errors.
    pub fn of(&self, at: &[usize]) -> DMatrix<f64> {
        self.with_all(at).select_rows(at)
    }

    /// The columns `at` of `(H + w CᵀC)⁻¹`: their covariances with all unknowns in that case.
    pub fn with_all(&self, at: &[usize]) -> DMatrix<f64> {
        let columns = at.iter().map(|unknown| self.answer(&[(*unknown, 1.0)]));
        DMatrix::from_columns(&columns.collect::<Vec<_>>())
    }

    /// Standard deviations of linear combinations of unknowns; `None` where one is empty, or where
    /// the performance does not determine it.
    pub fn sds(&self, sums: &[Moment]) -> Vec<Option<f64>> {
        let answers: Vec<DVector<f64>> = sums.iter().map(|sum| self.answer(sum)).collect();
        let errors = self.spread(&answers);
        let each = sums.iter().zip(&answers).enumerate();
        let each = each.map(|(at, (sum, answer))| {
            let own: f64 = sum.iter().map(|(at, factor)| factor * answer[*at]).sum();
            let errors = errors.as_ref().map(|of| of[(at, at)]);
            (!sum.is_empty()).then(|| self.sd(own, answer, errors))
        });
        each.map(Option::flatten).collect()
    }

    /// How far a linear combination of unknowns would move if bounds let it go and counted as
    /// priors about where they are: what the performance asks for beyond them, to first order.
    pub fn beyond_bounds(&self, sum: &Moment) -> f64 {
        -self.answer(sum).dot(&self.slope)
    }

    /// Standard deviation of the quantity `mᵀu` with `answer = P m` and `own = mᵀ P m`; `None`
    /// where the performance does not determine it.
    pub fn sd_of_answer(&self, own: f64, answer: &DVector<f64>) -> Option<f64> {
        let errors = self.spread(std::slice::from_ref(answer));
        self.sd(own, answer, errors.map(|of| of[(0, 0)]))
    }

    fn sd(&self, own: f64, answer: &DVector<f64>, errors: Option<f64>) -> Option<f64> {
        let seen = self.seen(answer);
        let (marks, beyond) = self.marks(answer);
        // Curvature leads errors on to what it holds; it is not known better for that.
        let known = own - self.curvature(answer);
        let variance = Variance {
            whole: own,
            damped: self.kkt.damped(answer),
            informed: seen + marks + self.wished(answer),
            known,
            errors: errors.unwrap_or(seen),
            priors: known - seen + beyond,
        };
        variance.sd()
    }

    /// What the errors of samples make of answers, where weights are not those of errors, or are not known exactly.
    fn spread(&self, answers: &[DVector<f64>]) -> Option<DMatrix<f64>> {
        if answers.is_empty() {
            return None;
        }
        let columns = DMatrix::from_columns(answers);
        match self.in_time {
            Some(in_time) => in_time.spread(self.context, self.point, &columns),
            None => Some(self.seen_jointly(answers) + self.vague()?.more(&columns)),
        }
    }

    fn vague(&self) -> Option<&VagueErrors> {
        let told = || VagueErrors::of(self.context, self.point, self.system, self.multipliers);
        self.vague.get_or_init(told).as_ref()
    }

    /// Information of samples about an answer.
    fn seen(&self, answer: &DVector<f64>) -> f64 {
        let mut product = DVector::zeros(answer.len());
        let pattern = &self.context.structure().pattern;
        self.of_samples.multiply_add(pattern, answer, &mut product);
        answer.dot(&product)
    }

    /// The part of `xᵀ P⁻¹ x` from curvature.
    fn curvature(&self, x: &DVector<f64>) -> f64 {
        let pattern = &self.context.structure().pattern;
        let square = |matrix: &Envelope| {
            let mut y = DVector::zeros(x.len());
            matrix.multiply_add(pattern, x, &mut y);
            y.dot(x)
        };
        let added = self
            .curved
            .as_ref()
            .map_or(0.0, |curved| square(curved) - square(&self.system.hessian));
        added + self.kkt.curved(x)
    }

    /// Information of goals that have a weight about an answer: what they determine is not undetermined.
    fn wished(&self, answer: &DVector<f64>) -> f64 {
        let problem = self.context.problem;
        let priced = self.system.priced.iter();
        let blocks = priced.zip(&self.context.structure().priced);
        let wishes = problem.constraints().zip(blocks);
        let wishes = wishes.filter(|(constraint, _)| constraint.is_soft_goal());
        let each = wishes.map(|(constraint, (block, pattern))| {
            let mut change = vec![0.0; block.values.len()];
            block.along(pattern, answer, &mut change);
            let acting = change
                .iter()
                .enumerate()
                .filter(|(row, _)| block.acts(*row));
            let square: f64 = acting.map(|(_, change)| change * change).sum();
            constraint.price(problem, f64::INFINITY) * square
        });
        each.sum()
    }

    /// `P m` for a linear combination `m`.
    fn answer(&self, sum: &[(usize, f64)]) -> DVector<f64> {
        let mut x = DVector::zeros(self.context.layout.size());
        for (at, factor) in sum {
            x[*at] += factor;
        }
        self.kkt.solve(self.context.structure(), &mut x);
        x
    }

    /// Information of marks and held bodies about an answer, `Σ (J_mark x)²`, and what it adds to the
    /// variance beyond that of a prior: `Σ (counted − 1)(J_mark x)²`, since their residuals have the
    /// variance `counted`.
    fn marks(&self, answer: &DVector<f64>) -> (f64, f64) {
        let (problem, layout) = (self.context.problem, self.context.layout);
        let (mut squares, mut beyond) = (0.0, 0.0);
        for mark in &problem.marks {
            let by = mark.term(problem, self.point).jacobian;
            let by = layout.of_mark(mark).into_iter().zip(by);
            let seen: f64 = by.filter_map(|(at, by)| Some(by * answer[at?])).sum();
            squares += seen * seen;
            beyond += (mark.counted - 1.0) * seen * seen;
        }
        for (of, change) in held::changes(self.context, self.point, answer) {
            let square = change.norm_squared();
            squares += square;
            beyond += (of.counted() - 1.0) * square;
        }
        (squares, beyond)
    }
}

/// The Hessian with all curvature, where a row pulls that has its own in closed form: at an apex, that
/// of the constraint alone would be too much or too little.
fn curved(context: &SolveContext, at: (&Point, &System), multipliers: &[f64]) -> Option<Envelope> {
    at.1.has_pulled_curvature(multipliers).then(|| {
        let mut curved = at.1.hessian.clone();
        context.add_curvature(at, multipliers, &mut curved);
        curved
    })
}

/// The factorised `H + w CᵀC`, in which an active bound of a parameter has the weight of a prior
/// with a standard deviation of half the width between the bounds, or none where there is only one
/// bound.
fn with_soft_bounds(
    context: &SolveContext,
    system: &System,
    curved: Option<&Envelope>,
    multipliers: &[f64],
) -> Option<Kkt> {
    let (_, information) = context.information();
    let active = ActiveSet::of(system, multipliers, information);
    let (mut weights, violations) = active.weights_and_violations(system, information);
    let mut multipliers = multipliers.to_vec();
    let mut row = 0;
    for (constraint, block) in context.problem.constraints().zip(&system.blocks) {
        if let Some(half_width) = constraint.half_width(block)
            && weights[row] > 0.0
        {
            multipliers[row] = 0.0;
            weights[row] = half_width.powi(-2);
        }
        row += block.values.len();
    }
    // Samples determine the times of nodes. Damping in proportion to the diagonal, which the tempo
    // prior makes large, would fix all of them.
    let mut damping = vec![DAMPING; context.layout.size()];
    for node in context.layout.nodes.iter().flatten() {
        damping[*node] = 0.0;
    }
    Kkt::weighed(
        context.structure(),
        system,
        curved,
        multipliers,
        weights,
        violations,
        damping,
    )
}

/// `g + Jᵀν` without the rows that bound parameters and times.
fn slope_without_bounds(
    context: &SolveContext,
    system: &System,
    multipliers: &[f64],
) -> DVector<f64> {
    let mut pulls = multipliers.to_vec();
    let mut row = 0;
    for (constraint, block) in context.problem.constraints().zip(&system.blocks) {
        if constraint.half_width(block).is_some() {
            pulls[row] = 0.0;
        }
        row += block.values.len();
    }
    let mut slope = system.gradient.clone();
    system.add_pull(context.structure(), |row| pulls[row], &mut slope);
    slope
}
