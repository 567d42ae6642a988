//! The motion of all, mechanism by mechanism: states of trees, flights of bodies by themselves, and how far they are
//! from what each track saw.

use super::problem::{RATE_SD_RAD_S, TreeProblem};
use super::time_line::TimeLine;
use crate::estimate::constraint::quantity;
use crate::motion::{
    ArcEstimate, EventEstimate, GoalUnit, Mechanism, MechanismIndex, Scene, SegmentResidual,
    TrackIndex, TrackResidual, TreeEstimate, TreeKnot,
};
use crate::physics::tree::ForestSnapshot;

/// All motions of an estimate.
#[derive(Default)]
pub(super) struct Motions {
    pub(super) trees: Vec<TreeEstimate>,
    pub(super) arcs: Vec<ArcEstimate>,
    pub(super) residuals: Vec<SegmentResidual>,
}

/// The motions that states of all say, with events at these times.
pub(super) fn motions(
    problem: &TreeProblem,
    line: &TimeLine,
    scene: &Scene,
    knots: &[TreeKnot],
    events: &[EventEstimate],
) -> Motions {
    let mut motions = Motions::default();
    for (index, (mechanism, of)) in scene.moving().enumerate() {
        match of {
            Mechanism::Free(_) => {
                let arcs = arcs(problem, line, scene, mechanism, knots, events);
                motions.arcs.extend(arcs);
            }
            Mechanism::Apart(_) => {}
            Mechanism::Tree(_) => motions.trees.push(TreeEstimate {
                mechanism,
                knots: own_knots(problem, index, knots),
                step_s: problem.step_s,
                residuals: Vec::new(),
                rate_sd_rad_s: RATE_SD_RAD_S,
            }),
        }
    }
    for sum in sums(problem, line, scene, knots, &motions.arcs) {
        let ([position, turn], track) = (sum.kinds, sum.track);
        let samples = position.0.max(turn.0);
        let rms =
            |(count, square): (usize, f64)| (count > 0).then(|| (square / count as f64).sqrt());
        let (position_rms_m, orientation_rms_rad) = (rms(position), rms(turn));
        match sum.arc {
            Some(arc) => motions.residuals.push(SegmentResidual {
                arc,
                track,
                samples,
                position_rms_m,
                orientation_rms_rad,
            }),
            None => {
                let mechanism = scene.mechanism_seen_by(track);
                let mut trees = motions.trees.iter_mut();
                let tree = trees.find(|of| of.mechanism == mechanism);
                tree.expect("no body by itself")
                    .residuals
                    .push(TrackResidual {
                        track,
                        samples,
                        position_rms_m,
                        orientation_rms_rad,
                    });
            }
        }
    }
    motions.residuals.sort_by_key(|of| of.arc);
    motions
}

/// A tree's own part of states of all.
fn own_knots(problem: &TreeProblem, index: usize, knots: &[TreeKnot]) -> Vec<TreeKnot> {
    let own = knots.iter().map(|knot| TreeKnot {
        time_s: knot.time_s,
        state: problem.forest.part(&knot.state, index).into_owned(),
    });
    own.collect()
}

/// The flights of a body by itself, from collision to collision.
fn arcs(
    problem: &TreeProblem,
    line: &TimeLine,
    scene: &Scene,
    mechanism: MechanismIndex,
    knots: &[TreeKnot],
    events: &[EventEstimate],
) -> Vec<ArcEstimate> {
    let hits = events.iter().filter(|of| {
        let mut hits = scene.events[of.event].kind.collision().into_iter();
        hits.any(|of| scene.takes_part(mechanism, of))
    });
    let [start_s, end_s] = line.physical_span_s();
    let hits_s = hits.map(|of| of.time_s);
    let ends_s: Vec<f64> = [start_s].into_iter().chain(hits_s).chain([end_s]).collect();
    let place = scene.place_of(scene.free_link(mechanism));
    let mut snapshot = ForestSnapshot::new(&problem.forest, &problem.gravity_m_s2);
    let flights = ends_s.windows(2).map(|ends_s| {
        // At a collision the state after it.
        let after = knots.partition_point(|knot| knot.time_s <= ends_s[0]);
        snapshot.set(&knots[after.max(1) - 1].state);
        ArcEstimate {
            mechanism,
            epoch_s: ends_s[0],
            state: snapshot.link_state(place),
            start_s: ends_s[0],
            end_s: ends_s[1],
            support: None,
            certainty: None,
        }
    });
    flights.collect()
}

/// What a track saw of a tree, or of one flight of a body by itself.
struct TrackSum {
    track: TrackIndex,
    arc: Option<usize>,
    /// Number and sum of squares of places, and of turns.
    kinds: [(usize, f64); 2],
}

fn sums(
    problem: &TreeProblem,
    line: &TimeLine,
    scene: &Scene,
    knots: &[TreeKnot],
    arcs: &[ArcEstimate],
) -> Vec<TrackSum> {
    let mut sums: Vec<TrackSum> = Vec::new();
    let mut snapshot = ForestSnapshot::new(&problem.forest, &problem.gravity_m_s2);
    for sample in &problem.samples {
        let time_s = line.time_s(sample.acted_s);
        let at = knots.partition_point(|knot| knot.time_s < time_s);
        snapshot.set(&knots[at.min(knots.len() - 1)].state);
        let link = snapshot.link_state(sample.place);
        let valued = quantity::valued(&sample.quantity, &link, None, &sample.point_m);
        let square = (valued.value - sample.seen).norm_squared();
        let kind = usize::from(sample.quantity.unit() != GoalUnit::Metre);
        let mechanism = scene.mechanism_seen_by(sample.track);
        let arc = arcs
            .iter()
            .rposition(|arc| arc.mechanism == mechanism && arc.start_s <= time_s);
        let is_its = |sum: &TrackSum| (sum.track, sum.arc) == (sample.track, arc);
        let place = sums.iter().position(is_its).unwrap_or_else(|| {
            sums.push(TrackSum {
                track: sample.track,
                arc,
                kinds: [(0, 0.0); 2],
            });
            sums.len() - 1
        });
        let of_kind = &mut sums[place].kinds[kind];
        of_kind.0 += 1;
        of_kind.1 += square;
    }
    sums
}
