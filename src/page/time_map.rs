//! Acted time against physical time.

use super::chart::{Chart, ChartMark};
use super::input::Page;
use super::theme::class_of_track;
use crate::report::{BodyTimes, EstimateMessage, EventLine};

/// Bodies and events as a chart; `None` where no sample has a time.
pub(super) fn chart(page: &Page, said: &EstimateMessage) -> Option<String> {
    let report = &said.report;
    let bodies = said
        .time_map
        .bodies
        .iter()
        .filter(|of| !of.acted_s.is_empty());
    let bodies: Vec<&BodyTimes> = bodies.collect();
    let all =
        |of: fn(&BodyTimes) -> &Vec<f64>| bodies.iter().flat_map(move |body| of(body)).copied();
    let events = |of: fn(&EventLine) -> f64| report.events.iter().map(of);
    let across = range(all(|of| &of.acted_s).chain(events(|of| of.acted_s)))?;
    let up = range(all(|of| &of.physical_s).chain(events(|of| of.time_s)))?;
    // As fast as acted: from the first sample on.
    let first = [across[0].max(0.0), up[0].max(0.0)];
    let run_s = (across[1] - first[0]).min(up[1] - first[1]);
    let mut marks = vec![ChartMark::Guide {
        from: first,
        to: first.map(|at| at + run_s),
    }];
    marks.extend(bodies.iter().map(|of| {
        let class = class_of_track(page.scene, &of.body);
        let points = of.acted_s.iter().zip(&of.physical_s);
        ChartMark::Series {
            points: points
                .map(|(acted_s, physical_s)| [*acted_s, *physical_s])
                .collect(),
            classes: [class.clone(), class],
        }
    }));
    marks.extend(report.events.iter().map(|event| ChartMark::Ring {
        at: [event.acted_s, event.time_s],
        name: event.name.clone(),
    }));
    let chart = Chart {
        size_px: [560.0, 300.0],
        across,
        up: [up[0], up[1] + 0.04 * (up[1] - up[0])],
        axes: ["acted, s", "physical, s"],
        label: format!(
            "Acted time against physical time: {:.3} s as acted take {:.3} s",
            report.acted_s, report.duration.physical_s
        ),
        marks,
    };
    Some(chart.element())
}

/// Least and greatest.
fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let finite = values.filter(|value| value.is_finite());
    let [least, greatest] = finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], value| {
        [a.min(value), b.max(value)]
    });
    (least < greatest).then_some([least, greatest])
}
