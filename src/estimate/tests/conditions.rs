//! Conditions: every quantity in every set, hard and with a weight.

use super::*;
use crate::motion::{Axes, BodyPoint, Condition, GoalQuantity, GoalSet, Moment};

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

/// Sets about which the quantities are: inside, outside and at the flattened middle of balls.
fn sets(dimension: usize, about: Vector3<f64>) -> Vec<GoalSet> {
    let beside = Vector3::new(0.013, -0.02, 0.017);
    let free = |axis: usize| axis >= dimension;
    let only = |vector: Vector3<f64>| {
        Vector3::from_fn(|axis, _| if free(axis) { 0.0 } else { vector[axis] })
    };
    let (about, beside) = (only(about), only(beside));
    let mut upper = about + beside.map(|b| b + 0.01);
    upper[0] = f64::INFINITY;
    vec![
        GoalSet::point(about + beside),
        GoalSet::Box {
            lower: about + beside,
            upper: upper.zip_map(&(about + beside), f64::max),
        },
        GoalSet::Ball {
            centre: about + beside,
            radius: 0.011,
        },
        GoalSet::Ball {
            centre: about + beside,
            radius: 0.2,
        },
        GoalSet::HalfSpace {
            normal: only(Vector3::new(0.6, 0.64, -0.48)).normalize(),
            least: 0.3,
        },
    ]
}

/// A scene with conditions in place of its goals: every quantity in a set about where it is, hard and
/// with a weight in turn.
pub(super) fn wished(mut scene: Scene, is_soft_wanted: bool) -> Scene {
    let is_meeting = scene.links.len() > 1;
    scene.goals.clear();
    let mut number = 0;
    for (event, link, moment, quantity) in quantities(is_meeting) {
        let about = match quantity {
            GoalQuantity::Time { .. } => Vector3::new(0.3, 0.0, 0.0),
            _ => Vector3::new(0.05, 0.02, 0.1),
        };
        for set in sets(quantity.dimension(), about) {
            number += 1;
            let sd = (number % 3 == 0).then_some(0.02);
            if sd.is_some() && !is_soft_wanted {
                continue;
            }
            let condition = Condition {
                quantity,
                set,
                moment,
                sd,
            };
            scene.goals.push(Goal {
                event,
                link,
                target: GoalTarget::Condition(condition),
            });
        }
    }
    scene
}

fn wished_cases(check: impl Fn(&Scene, &SolveContext, &Guess)) {
    let unknown = Timing::Unknown {
        tempo_sd_per_sqrt_s: 0.5,
    };
    for timing in [Timing::Known, unknown] {
        let plain = [scene(timing), meeting(timing, 0.05)];
        let general = plain.clone().map(modelled);
        for of in plain.into_iter().chain(general) {
            let scene = wished(of, true);
            let (sketch, segments, guess) = sketch(&scene, 1.0);
            let problem = Problem::new(&scene, &sketch, &segments);
            assert_eq!(problem.conditions.len(), scene.goals.len());
            let layout = Layout::new(&problem);
            let point = Point::new(&problem, &guess);
            let context = SolveContext::new(&problem, &layout, recipe::epochs_s(&guess), &point);
            check(&scene, &context, &guess);
        }
    }
}

#[test]
fn rows_of_conditions_have_exact_derivatives() {
    wished_cases(|_, context, guess| {
        let point = Point::new(context.problem, guess);
        let guidance = Guidance::none();
        let lengths = lengths(context.layout);
        let size = context.layout.size();
        let first = context.problem.collisions.len() + context.problem.goals.len();
        let count = context.problem.conditions.len();
        let all = |system: &System| -> Vec<f64> {
            let blocks = system.blocks.iter().zip(&system.priced);
            let of_conditions = blocks.skip(first).take(count);
            let rows =
                of_conditions.flat_map(|(hard, soft)| hard.values.iter().chain(&soft.values));
            rows.copied().collect()
        };
        let system = moved(context, &guidance, &point, &lengths, &vec![0.0; size]);
        let numeric = differentiate::jacobian(all(&system).len(), size, |d| {
            all(&moved(context, &guidance, &point, &lengths, d))
        });
        let structure = context.structure();
        let mut row_of_all = 0;
        for index in first..first + count {
            for (block, pattern) in [
                (&system.blocks[index], &structure.blocks[index]),
                (&system.priced[index], &structure.priced[index]),
            ] {
                for row in 0..block.values.len() {
                    let (unknowns, by) = (pattern.unknowns(row), block.derivatives(pattern, row));
                    for at in 0..size {
                        let column = unknowns.iter().position(|unknown| *unknown == at);
                        let expected = column.map_or(0.0, |column| by[column] * lengths[at]);
                        let found = numeric[row_of_all][at];
                        assert!(
                            (found - expected).abs() < 1e-6 * (1.0 + expected.abs()),
                            "{:?}, row {row}, unknown {at}: {found} {expected}",
                            context.problem.conditions[index - first].condition
                        );
                    }
                    row_of_all += 1;
                }
            }
        }
    });
}
