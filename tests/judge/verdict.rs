//! What a solver's end is called: order of events, gaps of positions and of velocities, and bent
//! physics that was not finished.

use enact::estimate::Recipe;
use enact::estimate::outcome;
use enact::estimate::problem::Problem;
use enact::estimate::schedule::recipe::{self, Solution};
use enact::estimate::terms::context::{Guidance, SolveContext};
use enact::estimate::unknowns::layout::Layout;
use enact::motion::{Counters, End, Estimate, Sketch, Verdict};
use enact::optimise::Program;
use enact::report::reason_text;
use enact::segment;
use enact_tools::case::{Case, Posed};
use enact_tools::perform::{Acting, Style};
use nalgebra::{UnitQuaternion, Vector3};

/// A solved pencil, to be tampered with.
struct Solved {
    case: Case,
    sketch: Sketch,
    posed: Posed,
    problem: Problem,
    layout: Layout,
    solution: Solution,
}

impl Solved {
    fn new(is_bent: bool) -> Self {
        let case = Case::pencil(Style::Tip, &Acting::timing_known(), 3);
        let (mut sketch, _) =
            segment::clean::clean(case.scene(), &case.performance.events).expect("clean");
        segment::refine(case.scene(), &mut sketch);
        let posed = Posed::new(case.scene(), &sketch);
        let exact = Problem::new(case.scene(), &sketch, &posed.segments);
        let problem = if is_bent {
            exact.with_velocity_gaps()
        } else {
            exact
        };
        let layout = Layout::new(&problem);
        let recipe = Recipe::default();
        let guess = &posed.guesses[0];
        let solution = recipe::solve(&problem, &layout, guess, &recipe, &mut ());
        assert!(solution.finished.converged);
        Self {
            case,
            sketch,
            posed,
            problem,
            layout,
            solution,
        }
    }

    /// What is said of a point that was changed, with the gaps that it has.
    fn said(&self, change: impl Fn(&mut Solution)) -> Estimate {
        let mut solution = self.solution.clone();
        change(&mut solution);
        let context = self.context();
        let system = context.evaluated(&Guidance::none(), &solution.point);
        solution.system = system;
        self.called(&solution)
    }

    /// What is said of a solution as it stands.
    fn called(&self, solution: &Solution) -> Estimate {
        let scene = self.case.scene();
        let context = self.context();
        let errors = outcome::errors(&self.problem, &context, &solution.point);
        outcome::estimate(
            scene,
            &self.sketch,
            &context,
            solution,
            &errors,
            Counters::default(),
        )
    }

    fn context(&self) -> SolveContext<'_> {
        let epochs_s = recipe::epochs_s(&self.posed.guesses[0]);
        SolveContext::new(&self.problem, &self.layout, epochs_s, &self.solution.point)
    }
}

#[test]
fn gaps_of_positions_are_no_motion_however_small_they_look() {
    let solved = Solved::new(false);
    assert_eq!(solved.said(|_| {}).verdict, Verdict::Physical);
    for (shift_m, turn_rad, expected) in [
        (0.0, 0.0, Verdict::Physical),
        (2e-10, 2e-10, Verdict::Physical),
        (1e-8, 0.0, Verdict::Failed),
        (1e-5, 0.0, Verdict::Failed),
        (0.0, 1e-8, Verdict::Failed),
        (0.0, 1e-5, Verdict::Failed),
    ] {
        let said = solved.said(|solution| {
            let arc = &mut solution.point.arcs[1];
            arc.position_m.x += shift_m;
            arc.orientation *= UnitQuaternion::from_scaled_axis(Vector3::x() * turn_rad);
        });
        assert_eq!(
            said.verdict, expected,
            "{shift_m} m, {turn_rad} rad: {:?}",
            said.reason
        );
    }
}

/// Velocities after the bounce are changed so that the bounce's own pose stays: at its time, about
/// its place.
#[test]
fn gaps_of_velocities_are_no_motion_where_nobody_priced_them() {
    let solved = Solved::new(false);
    // The end's goal moves too; what is asked is of the gap at the bounce.
    for (change_m_s, change_rad_s) in [(1e-6, 0.0), (1e-4, 0.0), (0.0, 1e-5), (0.0, 1e-3)] {
        let mut system_only = solved.solution.clone();
        let gaps = solved.said(|solution| {
            let arc = &mut solution.point.arcs[1];
            arc.velocity_m_s.x += change_m_s;
            arc.angular_velocity_rad_s.z += change_rad_s;
        });
        assert_eq!(gaps.verdict, Verdict::Failed, "{change_m_s} {change_rad_s}");
        // Rows of the collision: the last six of its block are of velocities.
        let block = &mut system_only.system.blocks[0];
        let rows = block.values.len();
        block.values[rows - 6] += change_m_s / 0.1;
        block.values[rows - 1] += change_rad_s;
        let said = solved.called(&system_only);
        assert_eq!(said.verdict, Verdict::Failed, "{change_m_s} {change_rad_s}");
        let gap = &said.events[0].gap;
        assert!(
            gap.position_m <= 1e-9 && gap.orientation_rad <= 1e-9,
            "{gap:?}"
        );
    }
}

#[test]
fn events_in_the_wrong_order_are_no_motion_even_without_gaps() {
    let solved = Solved::new(false);
    let mut solution = solved.solution.clone();
    assert_eq!(solved.called(&solution).verdict, Verdict::Physical);
    solution.point.event_times_s.swap(0, 1);
    let said = solved.called(&solution);
    assert_eq!(said.verdict, Verdict::Failed);
    let text = reason_text(solved.case.scene(), &said.reason);
    assert!(
        text.starts_with("`landing` would come before `bounce`"),
        "{text}"
    );
    let End::EventsReversed {
        first,
        last,
        interval_s,
    } = said.reason.end
    else {
        panic!("{:?}", said.reason);
    };
    assert!((first, last) == (0, 1) && interval_s < 0.0, "{interval_s}");
}

#[test]
fn bent_physics_is_plausible_only_when_it_is_finished() {
    let solved = Solved::new(true);
    let mut solution = solved.solution.clone();
    let said = solved.called(&solution);
    assert_eq!(said.verdict, Verdict::Plausible, "{:?}", said.reason);
    solution.finished.converged = false;
    let said = solved.called(&solution);
    assert_eq!(said.verdict, Verdict::Failed, "{:?}", said.reason);
}
