//! Two bodies that are one from an event on.

use super::*;
use crate::motion::{StuckTo, SupportPhase, SupportedBy};

/// The rod sticks to a board that flies.
pub(super) fn sticking(timing: Timing) -> Scene {
    let mut scene = meeting(timing, 0.0);
    let [rod, board] = [0, 1].map(LinkIndex);
    scene.parameters.truncate(1);
    scene.cones.clear();
    scene.events[0].kind = EventKind::Change(rod);
    for (link, other) in [(rod, board), (board, rod)] {
        scene.phases.push(SupportPhase {
            name: "stuck".into(),
            link,
            by: SupportedBy::Body(StuckTo { other, part: None }),
            events: [0, 1],
        });
    }
    let pair = scene.stuck_at(0).expect("a pair");
    let turn = UnitQuaternion::from_euler_angles(0.3, 0.8, -0.4);
    scene.stick(
        &pair,
        &Pose::from_parts(Vector3::new(0.05, -0.02, 0.06).into(), turn),
    );
    scene
}

#[test]
fn what_both_keep_leaves_as_many_unknowns_as_two_flights_and_a_time() {
    let scene = sticking(Timing::Known);
    let (sketch, segments, _) = sketch(&scene, 0.0);
    let problem = Problem::new(&scene, &sketch, &segments);
    assert_eq!(problem.arcs.len(), 4);
    assert_eq!((problem.changes.len(), problem.stickings.len()), (2, 1));
    assert!(problem.changes.iter().all(|of| !of.keeps_velocities));
    let supports = problem.arcs.iter().map(|arc| arc.body.support().is_some());
    assert_eq!(supports.filter(|is_stuck| *is_stuck).count(), 2);
}
