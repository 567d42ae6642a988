//! Contacts must approach: a constraint of every collision, stricter during the sweep.

use super::*;
use crate::estimate::schedule::recipe::Lead;
use crate::optimise::Stage;
use crate::optimise::block::Block;

/// The rows of approach speeds, each with its value, its limit and its violation.
fn approaches(block: &Block) -> Vec<(f64, f64, f64)> {
    let row = |row: usize| (block.values[row], block.bounds[row].1, block.violation(row));
    block.leads.clone().map(row).collect()
}

#[test]
fn contacts_that_approach_too_slowly_break_their_condition() {
    each_case(0.0, |context, guidance, point, _| {
        // What sticks together does not approach.
        if context.problem.collisions.is_empty() {
            return;
        }
        let system = context.evaluated(guidance, point);
        for block in &system.blocks[..context.problem.collisions.len()] {
            let rows = approaches(block);
            assert!(!rows.is_empty());
            for (speed, limit, broken) in rows {
                assert!(
                    speed < 0.0 && limit == 0.0 && broken == 0.0,
                    "{speed} {limit}"
                );
            }
        }
        let faster = Guidance {
            approach_limits_m_s: vec![-100.0; context.problem.event_is_free.len()],
            ..guidance.clone()
        };
        let asked = context.evaluated(&faster, point);
        for block in &asked.blocks[..context.problem.collisions.len()] {
            for (speed, limit, broken) in approaches(block) {
                assert!(limit < speed && broken == speed - limit, "{speed} {limit}");
            }
        }
        assert!(asked.violation() > system.violation());
    });
}

#[test]
fn what_leads_the_sweep_asks_for_an_approach_that_the_start_has() {
    each_case(0.0, |context, _, point, _| {
        let lead = Lead::new(context, point, &Recipe::default());
        let leading = lead.guidance(Stage::Sweep { weight: 1.0 });
        let system = context.evaluated(&leading, point);
        for block in &system.blocks[..context.problem.collisions.len()] {
            let fastest = approaches(block).into_iter();
            let fastest = fastest
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .expect("contacts");
            assert!(fastest.1 < 0.0, "{fastest:?} may stand still");
            assert_eq!(fastest.2, 0.0, "{fastest:?}");
        }
    });
}
