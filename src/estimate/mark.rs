//! Marks as measurements of their events' times.
//!
//! A performer, or an annotator, says when an event was, with an error of standard deviation σ in
//! acted time. Where stamps are physical times that is a pull of the event's time τ to the mark's.
//! Where they are not, the event's acted time is read off the samples about it, between two nodes of
//! which the time map is linear:
//!
//! ```text
//! r = (a₁ + (τ − t₁) (a₂ − a₁)/(t₂ − t₁) − mark) / σ
//! ```

use super::point::Point;
use super::problem::Problem;

/// The mark of an event whose time is an unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EventMark {
    /// Index into [`Problem::event_is_free`].
    pub event: usize,
    /// As it was made \[s, acted\].
    pub acted_s: f64,
    /// Its standard deviation \[s, acted\].
    pub sd_s: f64,
    /// The nodes about the event, where sample times are unknown.
    pub nodes: Option<[usize; 2]>,
}

/// The residual of a mark and its derivatives by the event's time and those of both nodes.
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

    /// The nodes about an acted time: the last before and the first after, or the two that are
    /// nearest at an end of the stream. `None` where there are fewer than two.
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
