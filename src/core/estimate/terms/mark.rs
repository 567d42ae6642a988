//! Marks as measurements of their events' times.
//!
//! A performer or an annotator marks an event with an error of standard deviation σ in acted time.
//! Where stamps are physical times the residual is `r = (τ − mark)/σ` with the event's time `τ`.
//! Where they are not, the time map is linear between two nodes about the event, with acted times
//! `a` and physical times `t`, and gives the event's acted time:
//!
//! ```text
//! r = (a₁ + (τ − t₁) (a₂ − a₁)/(t₂ − t₁) − mark) / σ
//! ```

use crate::estimate::problem::{EventMark, Problem};
use crate::estimate::unknowns::point::Point;

/// The residual of a mark and its derivatives by the event's time and the times of both nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarkTerm {
    /// The residual.
    pub residual: f64,
    /// Its derivatives [1/s]; those by nodes are zero where sample times are known.
    pub jacobian: [f64; 3],
}

impl EventMark {
    /// The residual at a point.
    pub fn term(&self, problem: &Problem, point: &Point) -> MarkTerm {
        let time_s = point.event_times_s[self.event];
        let Some(nodes) = self.nodes else {
            return MarkTerm {
                residual: (time_s - self.acted_s) / self.sd_s,
                jacobian: [1.0 / self.sd_s, 0.0, 0.0],
            };
        };
        let [from_s, to_s] = nodes.map(|node| point.node_times_s[node]);
        let [acted_from_s, acted_to_s] = nodes.map(|node| problem.nodes_acted_s[node]);
        let share = (time_s - from_s) / (to_s - from_s);
        let acted_s = acted_from_s + share * (acted_to_s - acted_from_s);
        let slope = (acted_to_s - acted_from_s) / (to_s - from_s) / self.sd_s;
        MarkTerm {
            residual: (acted_s - self.acted_s) / self.sd_s,
            jacobian: [slope, slope * (share - 1.0), -slope * share],
        }
    }

    /// The nodes about an acted time: the last before and the first after, or the nearest two at an
    /// end of the stream. `None` where there are fewer than two.
    pub fn nodes_about(nodes_acted_s: &[f64], acted_s: f64) -> Option<[usize; 2]> {
        let last = nodes_acted_s
            .len()
            .checked_sub(1)
            .filter(|last| *last > 0)?;
        let after = nodes_acted_s.partition_point(|node_s| *node_s <= acted_s);
        let after = after.clamp(1, last);
        Some([after - 1, after])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::tests::{scene, sketch};
    use crate::estimate::unknowns::layout::Layout;
    use crate::math::differentiate;
    use crate::motion::{MarkTime, Timing};

    const UNKNOWN: Timing = Timing::Unknown {
        tempo_sd_per_sqrt_s: 0.5,
    };

    /// A problem whose first event is marked, and where it starts.
    fn marked(timing: Timing) -> (Problem, Point) {
        let scene = scene(timing);
        let (mut sketch, segments, guess) = sketch(&scene, 0.0);
        sketch.marks[0] = Some(MarkTime {
            acted_s: sketch.marks_s[0] + 0.013,
            sd_s: 0.02,
            counted: 1.0,
        });
        let problem = Problem::new(&scene, &sketch, &segments);
        let point = Point::new(&problem, &guess);
        (problem, point)
    }

    #[test]
    fn derivatives_are_exact_with_times_known_and_unknown() {
        for timing in [Timing::Known, UNKNOWN] {
            let (problem, point) = marked(timing);
            let mark = problem.marks[0];
            assert_eq!(mark.nodes.is_some(), timing == UNKNOWN);
            let nodes = mark.nodes.unwrap_or([0, 1]);
            let numeric = differentiate::jacobian(1, 3, |d| {
                let mut point = point.clone();
                point.event_times_s[mark.event] += d[0];
                point.node_times_s[nodes[0]] += d[1];
                point.node_times_s[nodes[1]] += d[2];
                vec![mark.term(&problem, &point).residual]
            });
            let exact = mark.term(&problem, &point).jacobian;
            for k in 0..3 {
                let error = (numeric[0][k] - exact[k]).abs();
                assert!(
                    error < 1e-6 * (1.0 + exact[k].abs()),
                    "{timing:?} {k}: {error}"
                );
            }
        }
    }

    #[test]
    fn an_event_at_its_mark_costs_nothing_at_any_tempo() {
        let (problem, mut point) = marked(UNKNOWN);
        let mark = problem.marks[0];
        let [from, to] = mark.nodes.expect("between two samples");
        let [acted_from_s, acted_to_s] = [from, to].map(|node| problem.nodes_acted_s[node]);
        let share = (mark.acted_s - acted_from_s) / (acted_to_s - acted_from_s);
        for rate in [0.1, 1.0, 4.0] {
            for (time_s, acted_s) in point.node_times_s.iter_mut().zip(&problem.nodes_acted_s) {
                *time_s = 3.0 + rate * acted_s;
            }
            let [from_s, to_s] = [from, to].map(|node| point.node_times_s[node]);
            point.event_times_s[mark.event] = from_s + share * (to_s - from_s);
            assert!(mark.term(&problem, &point).residual.abs() < 1e-9);
            // Off by its deviation, it costs one.
            point.event_times_s[mark.event] += rate * mark.sd_s;
            assert!((mark.term(&problem, &point).residual - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn a_mark_pulls_in_the_problem() {
        let (problem, _) = marked(Timing::Known);
        let layout = Layout::new(&problem);
        let of = layout.of_mark(&problem.marks[0]);
        assert!(of[0].is_some() && of[1].is_none() && of[2].is_none());
        let (problem, _) = marked(UNKNOWN);
        let layout = Layout::new(&problem);
        assert!(
            layout
                .of_mark(&problem.marks[0])
                .iter()
                .all(Option::is_some)
        );
    }

    #[test]
    fn nodes_are_about_the_event_or_nearest_to_it() {
        let nodes_s = [0.0, 1.0, 2.0, 3.0];
        for (acted_s, nodes) in [(-1.0, [0, 1]), (0.5, [0, 1]), (1.5, [1, 2]), (9.0, [2, 3])] {
            assert_eq!(EventMark::nodes_about(&nodes_s, acted_s), Some(nodes));
        }
        assert_eq!(EventMark::nodes_about(&nodes_s[..1], 0.0), None);
    }
}
