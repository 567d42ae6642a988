//! Conditions: every quantity in every set, hard and with a weight.

use super::*;
use crate::estimate::constraint::{At, Constraint};
use crate::estimate::problem::arc_condition::Rows;
use crate::motion::{Axes, BodyPoint, Condition, GoalQuantity, GoalSet, Moment};
use crate::optimise::block::{Block, BlockPattern};
use crate::physics::flow;

/// Quantities at the bounce and at the end, of one body and of two.
fn quantities(is_meeting: bool) -> Vec<(usize, LinkIndex, Moment, GoalQuantity)> {
    use GoalQuantity::{Direction, Position, Spin, Time, Turn, Velocity};
    let (rod, board) = (LinkIndex(0), LinkIndex(1));
    let (before, after) = (Moment::Before, Moment::After);
    let fixed = BodyPoint::Fixed(Vector3::new(0.02, -0.01, 0.07));
    let contact = BodyPoint::Contact(0);
    let position = |point, seen_from| Position { point, seen_from };
    let turn = |seen_from| Turn {
        from: UnitQuaternion::from_euler_angles(0.1, 0.5, -0.4),
        seen_from,
    };
    let direction = |seen_from| Direction {
        axis: Vector3::new(0.6, 0.0, 0.8),
        towards: Vector3::new(0.0, 0.28, 0.96),
        seen_from,
    };
    let mut all = vec![
        (1, rod, before, position(BodyPoint::Centre, None)),
        (1, rod, before, position(fixed, None)),
        (0, rod, before, position(contact, None)),
        (0, rod, after, position(fixed, None)),
        (1, rod, before, turn(None)),
        (1, rod, before, direction(None)),
        (0, rod, before, Velocity { point: fixed }),
        (
            0,
            rod,
            after,
            Velocity {
                point: BodyPoint::Centre,
            },
        ),
        (0, rod, after, Spin { axes: Axes::World }),
        (1, rod, before, Spin { axes: Axes::Body }),
        (1, rod, before, Time { since: None }),
        (1, rod, before, Time { since: Some(0) }),
    ];
    if is_meeting {
        all.extend([
            (0, board, before, position(contact, None)),
            (0, rod, before, position(contact, Some(board))),
            (0, board, before, position(contact, Some(rod))),
            (1, rod, before, position(fixed, Some(board))),
            (1, board, before, position(BodyPoint::Centre, Some(rod))),
            (1, rod, before, turn(Some(board))),
            (1, board, before, direction(Some(rod))),
        ]);
    }
    all
}

/// Sets about a point that is `apart` from where the quantity is: a point, a box, balls with the quantity
/// outside, inside and in the flattened middle, a half-space.
fn sets(dimension: usize, about: Vector3<f64>, apart: f64) -> Vec<GoalSet> {
    let mut upper = about.add_scalar(0.01);
    upper[0] = f64::INFINITY;
    let ball = |share: f64| GoalSet::Ball {
        centre: about,
        radius: share * apart,
    };
    let mut normal = Vector3::new(0.6, 0.64, -0.48);
    (dimension..3).for_each(|axis| normal[axis] = 0.0);
    vec![
        GoalSet::point(about),
        GoalSet::Box {
            lower: about,
            upper,
        },
        ball(0.8),
        ball(1.3),
        ball(4.0),
        GoalSet::HalfSpace {
            normal: normal.normalize(),
            least: 0.3,
        },
    ]
}

/// A scene with conditions in place of its goals: every quantity in sets about where it is in the guess
/// of its flights, hard and with a weight in turn; one in so many of them.
pub(super) fn wished(mut scene: Scene, one_in: usize) -> Scene {
    let is_meeting = scene.links.len() > 1;
    scene.goals.clear();
    let (_, segments, guess) = sketch(&scene, 0.0);
    let mut number = 0;
    for (event, link, moment, quantity) in quantities(is_meeting) {
        let goal = |set, sd| Goal {
            event,
            link,
            target: GoalTarget::Condition(Condition {
                quantity,
                set,
                moment,
                sd,
            }),
        };
        let mut about = Vector3::new(0.05, 0.02, 0.1);
        (quantity.dimension()..3).for_each(|axis| about[axis] = 0.0);
        let apart = distance(
            &scene,
            (&segments, &guess),
            &goal(GoalSet::point(about), None),
        );
        for set in sets(quantity.dimension(), about, apart) {
            number += 1;
            // A hard orientation would leave nothing to do for the others.
            let is_turn = matches!(quantity, GoalQuantity::Turn { .. }) && set.is_point(3);
            let sd = (number % 3 == 0 || is_turn).then_some(0.02);
            if number % one_in == 0 {
                scene.goals.push(goal(set, sd));
            }
        }
    }
    scene
}

/// How far a goal is from its set in the guess, by the scene's own account.
fn distance(scene: &Scene, (segments, guess): (&[Segment], &Guess), goal: &Goal) -> f64 {
    let GoalTarget::Condition(condition) = &goal.target else {
        panic!("a condition");
    };
    let time_of = |event: usize| Some(guess.event_times_s[event]);
    let state_of = |link: LinkIndex| {
        let mechanism = scene.mechanism_of(link);
        let mut all = segments.iter().zip(&guess.arcs);
        let (_, arc) = all.find(|(segment, _)| {
            let event = match condition.moment {
                Moment::Before => segment.end_event,
                Moment::After => segment.start_event,
            };
            segment.mechanism == mechanism && event == Some(goal.event)
        })?;
        let since_s = guess.event_times_s[goal.event] - arc.epoch_s;
        Some(flow::advance(
            scene.body_of(mechanism),
            &scene.gravity_m_s2,
            &arc.state,
            since_s,
        ))
    };
    let found = scene.condition_distance(goal, condition, &time_of, &state_of);
    found.expect("a flight and a touch")
}

/// Runs `check` on context, point and the blocks of conditions: for one body and for two, with and
/// without parameters that act on flights, bodies and surfaces, with known and unknown times.
pub(in crate::estimate) fn wished_cases(one_in: usize, check: impl Fn(&SolveContext, &Point)) {
    let unknown = Timing::Unknown {
        tempo_sd_per_sqrt_s: 0.5,
    };
    for of in [
        scene(Timing::Known),
        meeting(unknown, 0.05),
        modelled(scene(Timing::Known)),
        modelled(meeting(Timing::Known, 0.05)),
    ] {
        let scene = wished(of, one_in);
        let (sketch, segments, guess) = sketch(&scene, 1.0);
        let problem = Problem::new(&scene, &sketch, &segments);
        assert_eq!(problem.conditions.len(), scene.goals.len());
        let layout = Layout::new(&problem);
        let point = Point::new(&problem, &guess);
        let context = SolveContext::new(&problem, &layout, recipe::epochs_s(&guess), &point);
        check(&context, &point);
    }
}

/// The filled rows of all conditions, each with its pattern.
fn filled<'a>(context: &'a SolveContext, point: &Point) -> Vec<(Block, &'a BlockPattern)> {
    let (problem, structure) = (context.problem, &context.layout.structure);
    let first = problem.collisions.len() + problem.goals.len();
    let mut at = At::new(problem, point, &context.epochs_s);
    let of = problem.conditions.iter().enumerate();
    of.map(|(index, of)| {
        let [hard, soft] = [&structure.blocks, &structure.priced].map(|of| &of[first + index]);
        let (mut rows, mut priced) = (Block::default(), Block::default());
        of.fill(&mut at, [(hard, &mut rows), (soft, &mut priced)]);
        if of.is_soft() {
            (priced, soft)
        } else {
            (rows, hard)
        }
    })
    .collect()
}

#[test]
fn rows_of_conditions_have_exact_derivatives() {
    wished_cases(1, |context, point| {
        let size = context.layout.size();
        let lengths: Vec<f64> = lengths(context.layout).iter().map(|l| 0.1 * l).collect();
        let at = |d: &[f64]| {
            let delta = DVector::from_iterator(size, d.iter().zip(&lengths).map(|(d, l)| d * l));
            let mut there = point.clone();
            context.retract(point, &delta, &mut there);
            there
        };
        let values = |d: &[f64]| -> Vec<f64> {
            let blocks = filled(context, &at(d));
            blocks
                .into_iter()
                .flat_map(|(block, _)| block.values)
                .collect()
        };
        let blocks = filled(context, point);
        let count = blocks.iter().map(|(block, _)| block.values.len()).sum();
        let numeric = differentiate::jacobian(count, size, values);
        let mut numeric = numeric.into_iter();
        for (of, (block, pattern)) in context.problem.conditions.iter().zip(&blocks) {
            for row in 0..block.values.len() {
                let (unknowns, by) = (pattern.unknowns(row), block.derivatives(pattern, row));
                for (at, found) in numeric.next().unwrap().into_iter().enumerate() {
                    let column = unknowns.iter().position(|unknown| *unknown == at);
                    let expected = column.map_or(0.0, |column| by[column] * lengths[at]);
                    assert!(
                        (found - expected).abs() < 1e-8 * (1.0 + expected.abs()),
                        "{:?}, row {row}, unknown {at}: {found} {expected}",
                        of.condition
                    );
                }
            }
        }
    });
}

/// What goals with a weight cost has the gradient that is said.
#[test]
fn wishes_pull_as_their_cost_falls() {
    wished_cases(9, |context, point| {
        let size = context.layout.size();
        let lengths: Vec<f64> = lengths(context.layout).iter().map(|l| 0.1 * l).collect();
        let cost = |d: &[f64], guidance: &Guidance| {
            let system = moved(context, guidance, point, &lengths, d);
            (system.cost, system.gradient)
        };
        let without = Guidance::without_wishes();
        let wish = |d: &[f64]| cost(d, &Guidance::none()).0 - cost(d, &without).0;
        let zero = vec![0.0; size];
        let gradient = cost(&zero, &Guidance::none()).1 - cost(&zero, &without).1;
        let numeric = differentiate::jacobian(1, size, |d| vec![wish(d)]);
        assert!(wish(&zero) > 1.0);
        for at in 0..size {
            let (found, expected) = (numeric[0][at], gradient[at] * lengths[at]);
            let error = (found - expected).abs();
            assert!(
                error < 1e-6 * (1.0 + expected.abs()),
                "{at}: {found} {expected}"
            );
        }
    });
}

/// Where rows hardly change with the time of the event, their second derivatives by it are there and
/// are right.
#[test]
fn rows_that_time_leaves_say_how_it_bends_them() {
    let mut bent = 0;
    let bent = std::cell::RefCell::new(&mut bent);
    wished_cases(1, |context, point| {
        let time = context.layout.events[1].expect("a free end");
        let mut point = point.clone();
        // The bodies rise and fall: somewhere each row turns back.
        for step in 0..12 {
            point.event_times_s[1] = 0.3 + 0.025 * f64::from(step);
            let slopes = |d: &[f64]| -> Vec<f64> {
                let mut there = point.clone();
                there.event_times_s[1] += 1e-3 * d[0];
                let blocks = filled(context, &there);
                let slopes = blocks.iter().flat_map(|(block, pattern)| {
                    (0..block.values.len()).map(|row| {
                        let unknowns = pattern.unknowns(row);
                        let column = unknowns.iter().position(|unknown| *unknown == time);
                        column.map_or(0.0, |column| block.derivatives(pattern, row)[column])
                    })
                });
                slopes.collect()
            };
            let blocks = filled(context, &point);
            let here = slopes(&[0.0]);
            let numeric = differentiate::jacobian(here.len(), 1, slopes);
            let mut first = 0;
            for (of, (block, _)) in context.problem.conditions.iter().zip(&blocks) {
                for second in &block.second {
                    let expected = 1e3 * numeric[first + second.row][0];
                    let scale = 1.0 + expected.abs();
                    // Where a ball's row is flattened, its second derivative jumps.
                    let is_single = matches!(of.rows, Rows::Single);
                    if !is_single && of.event == 1 {
                        let error = (second.value - expected).abs();
                        assert!(error < 1e-4 * scale, "{of:?}: {} {expected}", second.value);
                        **bent.borrow_mut() += 1;
                    }
                }
                first += block.values.len();
            }
        }
    });
    assert!(**bent.borrow() > 20, "{}", bent.borrow());
}

#[test]
fn rows_are_as_far_from_their_bounds_as_the_scene_says() {
    for of in [scene(Timing::Known), meeting(Timing::Known, 0.05)] {
        let mut scene = wished(of, 1);
        // The guess's values of what is free are those of the scene.
        scene.parameters.clear();
        scene.cones.clear();
        let (sketch, segments, guess) = sketch(&scene, 0.0);
        let problem = Problem::new(&scene, &sketch, &segments);
        let layout = Layout::new(&problem);
        let point = Point::new(&problem, &guess);
        let context = SolveContext::new(&problem, &layout, recipe::epochs_s(&guess), &point);
        let system = context.evaluated(&Guidance::none(), &point);
        let first = problem.collisions.len() + problem.goals.len();
        for (index, of) in problem.conditions.iter().enumerate() {
            let (hard, soft) = (&system.blocks[first + index], &system.priced[first + index]);
            let block = if of.is_soft() { soft } else { hard };
            let squares = (0..block.values.len()).map(|row| block.violation(row).powi(2));
            let found = squares.sum::<f64>().sqrt() * of.unit();
            let expected = distance(&scene, (&segments, &guess), &scene.goals[index]).max(0.0);
            // What touches a face is held there by its contact alone.
            let is_on_face = matches!(of.rows, Rows::OnFace(_));
            let is_of_contact = of.touched.is_some() && matches!(of.rows, Rows::Axes(_));
            if !is_on_face && !is_of_contact {
                assert!(
                    (found - expected).abs() < 1e-9,
                    "{of:?}: {found} {expected}"
                );
            }
        }
    }
}
