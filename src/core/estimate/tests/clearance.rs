//! Clearances: rows of distances whose moment is found anew at every point.

use super::*;
use crate::estimate::constraint::At;
use crate::estimate::problem::clearance::{
    ClearSolids, Clearance, ClearanceTouches, FlightEnd, KeptFrom,
};
use crate::motion::Against;
use crate::physics::contact::{Contact, Frame};

/// A point of the rod.
const POINT_M: Vector3<f64> = Vector3::new(0.01, 0.02, -0.08);
/// How far from the middle of a flight it is nearest \[s\].
const LATER_S: f64 = 0.02;

/// How a point of the rod passes something that stands still, or flies.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pass {
    /// A ball that it passes by.
    Ball,
    /// An edge: it leaves one face for another.
    Edge,
    /// A face that it nears until its flight ends.
    End,
}

/// A clearance of a point on an arc; from what flies on another arc if one is given.
fn clearance(
    context: &SolveContext,
    point: &Point,
    arc: usize,
    other: Option<usize>,
    pass: Pass,
) -> Clearance {
    let problem = context.problem;
    let around_s = context.epochs_s[arc] + LATER_S;
    let gravity_m_s2 = problem.gravity(&point.parameters);
    let state_of = |arc: usize| {
        let body = problem.body_at(arc, &point.parameters).expect("a body");
        let state = &point.arcs[arc];
        flow::advance(
            &body,
            &gravity_m_s2,
            state,
            around_s - context.epochs_s[arc],
        )
    };
    let (own, met) = (state_of(arc), other.map(state_of));
    let there = own.position_m + own.orientation * POINT_M;
    let mut way = own.velocity_m_s + own.orientation * own.angular_velocity_rad_s.cross(&POINT_M);
    let frame = met.as_ref().map_or_else(Frame::world, Frame::of);
    let seen = |place: &Vector3<f64>| frame.orientation.inverse() * (place - frame.position_m);
    if let Some(met) = &met {
        let spin = met.orientation * met.angular_velocity_rad_s;
        way -= met.velocity_m_s + spin.cross(&(there - met.position_m));
    }
    let way = way.normalize();
    let [across, _] = contact::Feature::tangents(&way);
    let corner = contact::Feature::corner(POINT_M);
    let face = |normal: Vector3<f64>| {
        let normal = normal.normalize();
        let on_it = there + normal * 0.004;
        let face = contact::Feature::face(seen(&on_it), frame.orientation.inverse() * normal);
        Contact::new(corner, face).expect("a corner and a face")
    };
    let touches = match pass {
        Pass::Ball => {
            let ball = contact::Feature::Point {
                point_m: seen(&(there - across * 0.03)),
                radius_m: 0.032,
            };
            ClearanceTouches::One(Box::new(
                Contact::new(corner, ball).expect("a corner and a ball"),
            ))
        }
        Pass::Edge => {
            ClearanceTouches::Switching(Box::new([face(across * 0.8 - way), face(across + way)]))
        }
        Pass::End => ClearanceTouches::One(Box::new(face(across * 0.4 - way))),
    };
    let end = problem.arcs[arc]
        .end
        .map_or(FlightEnd::At(around_s + 0.01), FlightEnd::Event);
    let arcs: Vec<usize> = [arc].into_iter().chain(other).collect();
    Clearance {
        solids: ClearSolids {
            link: LinkIndex(0),
            against: Against::Surface(0),
            from: match other {
                Some(_) => KeptFrom::Flying,
                None => KeptFrom::Still(frame),
            },
            touches,
            around_s,
            reach_s: if pass == Pass::End { 1.0 } else { 0.01 },
            depth_m: 0.0,
            least_m: 0.0,
        },
        ends: [FlightEnd::At(around_s - 0.05), end],
        acting: crate::estimate::posing::conditions::acting(
            &problem.arcs,
            &arcs,
            &problem.gravity_parameters,
            &[],
        ),
        arcs,
    }
}

/// Runs `check` on each case with clearances of the rod on its first arc.
fn each_kept(check: impl Fn(&SolveContext, &Point, &[f64])) {
    each_case(1.0, |context, _, point, _| {
        let mut problem = context.problem.clone();
        // Where flights have clocks of their own there are none.
        if problem.arcs.iter().any(|arc| arc.clock.is_some()) {
            return;
        }
        let flies = |mechanism: usize| {
            let mut arcs = problem.arcs.iter();
            arcs.position(|arc| usize::from(arc.mechanism) == mechanism)
        };
        let own = flies(0).expect("the rod flies");
        let others: Vec<Option<usize>> = [None].into_iter().chain(flies(1).map(Some)).collect();
        let each = others.iter().flat_map(|other| {
            [Pass::Ball, Pass::Edge, Pass::End]
                .map(|pass| clearance(context, point, own, *other, pass))
        });
        problem.clearances = each.collect();
        let layout = Layout::new(&problem);
        let context = SolveContext::new(&problem, &layout, context.epochs_s.clone(), point);
        // The features are those of short times.
        let lengths: Vec<f64> = lengths(&layout)
            .iter()
            .map(|length| 0.02 * length)
            .collect();
        check(&context, point, &lengths);
    });
}

#[test]
fn derivatives_are_exact_though_the_moment_moves() {
    each_kept(|context, point, lengths| {
        assert_exact_rows(context, &Guidance::none(), point, lengths);
    });
}

#[test]
fn the_moment_is_that_of_the_least_distance() {
    each_kept(|context, point, _| {
        let problem = context.problem;
        let at = At::new(problem, point, &context.epochs_s);
        for of in &problem.clearances {
            let time_s = of.least(&at).expect("a moment").time_s;
            if of.solids.reach_s == 1.0 {
                let FlightEnd::Event(event) = of.ends[1] else {
                    panic!("its flight ends at an event");
                };
                assert!(time_s <= point.event_times_s[event]);
            } else {
                assert!(
                    (time_s - of.solids.around_s).abs() < 0.6 * of.solids.reach_s,
                    "{time_s} {of:?}"
                );
            }
        }
    });
}

/// Half the squared violation falls along its own gradient as its derivative says, also far from where it began.
#[test]
fn a_row_holds_a_flight_out_of_a_ball() {
    let mut scene = scene(Timing::Known);
    scene.goals.clear();
    scene.parameters.clear();
    let (sketch, segments, guess) = sketch(&scene, 0.05);
    let free = Problem::new(&scene, &sketch, &segments);
    let layout = Layout::new(&free);
    let solution = recipe::solve(&free, &layout, &guess, &Recipe::default(), &mut ());
    assert!(solution.finished.converged);
    let epochs_s = recipe::epochs_s(&guess);
    let context = SolveContext::new(&free, &layout, epochs_s.clone(), &solution.point);
    let mut kept = free.clone();
    let first = (0..free.arcs.len()).find(|arc| free.arcs[*arc].start.is_none());
    for pass in [Pass::Ball, Pass::Edge] {
        kept.clearances = vec![clearance(
            &context,
            &solution.point,
            first.expect("a first flight"),
            None,
            pass,
        )];
        let layout = Layout::new(&kept);
        let again = recipe::solve_from(
            &kept,
            &layout,
            solution.point.clone(),
            epochs_s.clone(),
            &Recipe::default().from_the_last(),
            &mut (),
        );
        assert!(again.finished.converged, "{pass:?} {:?}", again.finished);
        assert!(again.system.cost > solution.system.cost);
        let pull = again.multipliers.last().expect("a row");
        assert!(*pull < 0.0, "it holds the flight: {pull}");
        let row = again.system.blocks.last().expect("a row");
        assert!(row.values[0].abs() < 1e-8, "{}", row.values[0]);
    }
}
