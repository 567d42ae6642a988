//! A joined problem as the file in which it goes to peers (`tools/peers/README.md`), and what the program finds at
//! any state of it.

use anyhow::{Result, bail};
use enact::estimate::problem::arc_condition::Rows;
use enact::estimate::tree::goal::TreeGoal;
use enact::estimate::tree::part::Part;
use enact::estimate::tree::program::TreeProgram;
use enact::estimate::tree::sample::TreeSample;
use enact::estimate::tree::{TreePoint, TreeProblem, problem::RATE_SD_RAD_S};
use enact::initialise;
use enact::motion::{BodyPoint, GoalQuantity, GoalSet};
use enact::optimise::Program;
use enact::physics::tree::{Snapshot, TreeState};
use enact::segment::clean::clean;
use enact_tools::mechanism_file;
use enact_tools::trees::{RATE_HZ, TreePerformance};
use nalgebra::Vector3;
use serde_json::{Value, json};

/// The problem of a performance.
pub struct Posed<'p> {
    performance: &'p TreePerformance,
    pub problem: TreeProblem,
    /// The program's first guess of the state at the start.
    pub start: TreeState,
}

/// What a state at the start comes to, by the program's own formulas.
pub struct Found {
    /// Sum of squares.
    pub objective: f64,
    /// Rows of the goals, how far they are off \[units\].
    rows: Vec<f64>,
}

impl Found {
    /// Largest violation \[units\].
    pub fn violation(&self) -> f64 {
        let off = self.rows.iter().map(|row| row.abs());
        off.fold(
            0.0,
            |a, b| if b.is_nan() { f64::INFINITY } else { a.max(b) },
        )
    }
}

impl<'p> Posed<'p> {
    /// As the program poses it.
    pub fn of(performance: &'p TreePerformance) -> Result<Self> {
        let scene = &performance.scene;
        let (sketch, _) = clean(scene, &performance.events)?;
        let problem = TreeProblem::new(scene, &sketch);
        let (_, start) = initialise::tree::starts(scene, &sketch, &problem.forest).swap_remove(0);
        Ok(Self {
            performance,
            problem,
            start,
        })
    }

    /// What a state at the start comes to: the motion from it in four steps between samples, however it was found.
    pub fn found(&self, state: &TreeState) -> Found {
        let mut problem = self.problem.clone();
        problem.step_s = 0.25 / RATE_HZ;
        let point = TreePoint::new(&problem, vec![state.clone()]);
        let program = TreeProgram::new(&problem, point.clone());
        let system = program.evaluated(&Part::whole(), &point);
        let rows = system.bounded();
        Found {
            objective: 2.0 * system.cost,
            rows: rows
                .map(|(value, (lower, upper))| value - value.clamp(lower, upper))
                .collect(),
        }
    }

    /// The file, with what the program finds at the named states.
    pub fn file(&self, points: &[(&str, &TreeState)]) -> Result<Value> {
        let (problem, scene) = (&self.problem, &self.performance.scene);
        let joined = scene.joint_trees().next().map(|(_, joined)| joined);
        let links = joined.map(|joined| joined.model_links(|link| scene.links[link].body));
        let samples: Result<Vec<Value>> = problem.samples.iter().map(sample).collect();
        let goals: Result<Vec<Value>> = problem.goals.iter().map(goal).collect();
        let points = points.iter().map(|(name, state)| {
            let found = self.found(state);
            let mut snapshot = Snapshot::new(&problem.forest.trees()[0], &problem.gravity_m_s2);
            snapshot.set(state);
            let mut accelerations = vec![0.0; problem.forest.freedoms()];
            snapshot.accelerations(&mut accelerations);
            json!({
                "name": name,
                "state": {"coordinates": state.coordinates, "rates": state.rates},
                "accelerations": accelerations,
                "objective": found.objective,
                "rows": found.rows,
            })
        });
        Ok(json!({
            "format": "enact joined problem 1",
            "gravity_m_s2": problem.gravity_m_s2.as_slice(),
            "links": mechanism_file::links(&links.unwrap_or_default()),
            "span_s": problem.span_s,
            "rate_sd_rad_s": RATE_SD_RAD_S,
            "samples": samples?,
            "goals": goals?,
            "points": points.collect::<Vec<_>>(),
        }))
    }
}

fn sample(sample: &TreeSample) -> Result<Value> {
    let GoalQuantity::Position { .. } = sample.quantity else {
        bail!("no peer is told of samples but positions");
    };
    Ok(json!({
        "time_s": sample.acted_s,
        "link": sample.place,
        "point_m": sample.point_m.as_slice(),
        "seen_m": sample.seen.as_slice(),
        "unit_m": sample.unit,
    }))
}

fn goal(goal: &TreeGoal) -> Result<Value> {
    let condition = &goal.condition;
    let value = match (&condition.set, &goal.rows) {
        (GoalSet::Box { lower, upper }, Rows::Axes(axes)) if condition.sd.is_none() => {
            let fixed = axes.iter().all(|axis| lower[*axis] == upper[*axis]);
            fixed.then_some(*lower)
        }
        _ => None,
    };
    let Some(value) = value else {
        bail!("no peer is told of goals but hard ones that fix a quantity");
    };
    let (kind, value) = match &condition.quantity {
        GoalQuantity::Angles { count } => ("angles", value.as_slice()[..*count].to_vec()),
        GoalQuantity::Turn {
            from,
            seen_from: None,
        } if value == Vector3::zeros() => {
            let q = from.coords;
            ("orientation", vec![q.w, q.x, q.y, q.z])
        }
        GoalQuantity::Position {
            point: BodyPoint::Centre | BodyPoint::Fixed(_),
            seen_from: None,
        } => ("position", value.as_slice().to_vec()),
        _ => bail!("no peer is told of such a goal"),
    };
    Ok(json!({
        "time_s": goal.acted_s,
        "kind": kind,
        "link": goal.places[0],
        "point_m": goal.point_m.as_slice(),
        "value": value,
        "unit": goal.unit(),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use enact_tools::trees::{Jointed, Kind, TreeActing, perform};

    const KINDS: [Kind; 3] = [
        Kind::pendulum(2, Jointed::Ball),
        Kind::pendulum(2, Jointed::Universal),
        Kind::CHAIN,
    ];

    /// The true motion meets the goals, at its own objective; another one does not.
    #[test]
    fn the_true_motion_is_a_motion_of_its_problem() {
        for kind in KINDS {
            let performance = perform(&kind, &TreeActing::of(1.0), 7003);
            let posed = Posed::of(&performance).expect("a problem");
            let found = posed.found(&performance.truth);
            assert!(found.violation() < 1e-7, "{}", found.violation());
            let cost = performance.truth_cost();
            assert!((found.objective / cost - 1.0).abs() < 1e-8);
            let mut other = performance.truth.clone();
            other.rates[0] += 0.1;
            assert!(posed.found(&other).violation() > 0.1);
        }
    }

    /// A file holds all samples and goals; what peers would not be told rightly is refused.
    #[test]
    fn a_file_says_all_or_is_refused() {
        for kind in KINDS {
            let performance = perform(&kind, &TreeActing::of(1.0), 7003);
            let mut posed = Posed::of(&performance).expect("a problem");
            let file = posed.file(&[("truth", &performance.truth)]);
            let file = file.expect("all can be told");
            assert_eq!(file["samples"].as_array().map(Vec::len), Some(109));
            assert_eq!(file["links"].as_array().map(Vec::len), Some(kind.links));
            let goals = file["goals"].as_array().expect("goals");
            assert_eq!(goals.len(), posed.problem.goals.len());
            posed.problem.goals[0].condition.sd = Some(1.0);
            let refused = posed.file(&[]).expect_err("a wish is no equation");
            assert!(refused.to_string().contains("hard ones"), "{refused}");
        }
    }
}
