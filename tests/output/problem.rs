//! An exported problem can be read back, and what is in it suffices to say what the objective and
//! the constraints are.

use enact_tools::export;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use enact::estimate::schedule::recipe::{self, Recipe};

use enact_tools::case::{Case, Posed};
use enact_tools::export::{Flight, Motion, Named, Problem};
use enact_tools::perform::{Acting, bounces, hat_box};

fn exported(case: &Case) -> Problem {
    let outcome = case.estimated(&mut ()).expect("an estimate");
    let posed = Posed::without_marks(case.scene(), &outcome.sketch);
    let guess = &posed.guesses[0];
    let (problem, layout) = (&posed.problem, &posed.layout);
    let solution = recipe::solve(problem, layout, guess, &Recipe::default(), &mut ());
    assert!(solution.finished.converged);
    let others = [("solution", &solution.point)];
    let made = export::problem("a name", problem, layout, guess, &others);
    let text = serde_json::to_string(&made).expect("JSON");
    let read: Problem = serde_json::from_str(&text).expect("the format");
    assert_eq!(read, made);
    read
}

fn rotation([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z))
}

/// Pose of a body with three equal moments.
fn flown(
    problem: &Problem,
    arc: &Flight,
    state: &Motion,
    time_s: f64,
) -> (Vector3<f64>, UnitQuaternion<f64>) {
    let s = time_s - arc.epoch_s;
    let [x, v, omega] = [
        state.position_m,
        state.velocity_m_s,
        state.angular_velocity_rad_s,
    ]
    .map(Vector3::from);
    let gravity = Vector3::from(problem.gravity_m_s2);
    let turn = UnitQuaternion::from_scaled_axis(omega * s);
    (
        x + v * s + gravity * (0.5 * s * s),
        rotation(state.orientation_wxyz) * turn,
    )
}

fn objective(problem: &Problem, point: &Named) -> f64 {
    let mut sum = 0.0;
    for (arc, state) in problem.arcs.iter().zip(&point.states) {
        for sample in &arc.samples {
            let (x, r) = flown(problem, arc, state, point.node_times_s[sample.node]);
            let off_m = (x - Vector3::from(sample.position_m)).norm();
            let off_rad = r.angle_to(&rotation(sample.orientation_wxyz));
            sum += (off_m / problem.position_unit_m).powi(2)
                + (off_rad / problem.orientation_unit_rad).powi(2);
        }
    }
    sum
}

#[test]
fn what_is_exported_suffices_for_objective_and_contacts() {
    let truth = bounces(2, 0).expect("a bouncing cube");
    let problem = exported(&Case::new(&truth, &Acting::timing_known(), 0));
    assert_eq!(problem.format, export::FORMAT);
    assert_eq!((problem.arcs.len(), problem.collisions.len()), (3, 2));
    assert_eq!(problem.points.len(), 2);
    for point in &problem.points {
        let sum = objective(&problem, point);
        assert!((sum / point.objective - 1.0).abs() < 1e-9, "{sum}");
        // Contact, approach, continuity of twelve numbers.
        assert_eq!(point.rows.len(), 14 * problem.collisions.len());
        for (collision, rows) in problem.collisions.iter().zip(point.rows.chunks(14)) {
            let pair = &collision.contacts[0];
            let kinds = (pair.a.kind.as_str(), pair.b.kind.as_str());
            assert_eq!(kinds, ("point", "face"));
            let arc = collision.sides[0].before;
            let time_s = point.event_times_s[collision.event];
            let (x, r) = flown(&problem, &problem.arcs[arc], &point.states[arc], time_s);
            let corner_m = x + r * Vector3::from(pair.a.point_m);
            let gap_m = corner_m.z / problem.constraint_units.position_m;
            assert!((rows[0].value - gap_m).abs() < 1e-9);
            assert_eq!((rows[0].lower, rows[0].upper), (Some(0.0), Some(0.0)));
            assert_eq!((rows[1].lower, rows[1].upper), (None, Some(0.0)));
        }
    }
    let solution = &problem.points[1];
    assert!(solution.rows.iter().all(|row| {
        let below = row.lower.is_some_and(|lower| row.value < lower - 1e-8);
        let above = row.upper.is_some_and(|upper| row.value > upper + 1e-8);
        !below && !above
    }));
}

#[test]
fn free_parameters_goals_and_two_bodies_are_in_it() {
    let problem = exported(&Case::new(&hat_box::truth(), &Acting::timing_known(), 0));
    let free: Vec<&str> = problem.parameters.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(free.len(), 4);
    assert_eq!(problem.bounded.len(), 2);
    for index in &problem.bounded {
        let restitution = &problem.parameters[*index];
        assert_eq!(
            (restitution.lower, restitution.upper),
            (Some(0.09), Some(0.11))
        );
    }
    assert_eq!(problem.cones.len(), 1);
    assert!((problem.cones[0].limit - 6_f64.to_radians()).abs() < 1e-12);
    let [bounce, meeting] = &problem.collisions[..] else {
        panic!("{} collisions", problem.collisions.len());
    };
    assert_eq!((bounce.sides.len(), meeting.sides.len()), (1, 2));
    assert!(bounce.restitution_parameter.is_some() && meeting.restitution_parameter.is_some());
    assert!(meeting.tilt_parameters.iter().all(Option::is_some));
    assert_eq!(problem.bodies[0].symmetry, "axial");
    assert_eq!(problem.bodies[1].symmetry, "spherical");
    // The hat's place at the meeting, axis by axis; both poses at the landing.
    let poses = problem.goals.iter().filter(|goal| goal.pose.is_some());
    assert_eq!((problem.goals.len(), poses.count()), (5, 2));
    // Bounce 14, meeting 26, goals 3 + 12, bounds 2, cone 1.
    for point in &problem.points {
        assert_eq!(point.rows.len(), 58);
        assert!(point.rows.iter().all(|row| row.value.is_finite()));
    }
}
