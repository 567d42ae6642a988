//! Figures and tables of what grew.

use enact::motion::{Phase, Verdict};

use super::size::PHASES;
use super::{Grown, Swept};
use crate::figure::{Axis, Curve, Figure, Mark};
use crate::statistics::exponent;
use crate::table::{Table, number};

fn failed(grown: &Grown) -> bool {
    grown.size.verdict != Verdict::Physical.as_str()
}

/// The exponent over the upper half of what succeeded, where what does not grow no longer hides what does.
pub fn upper(swept: &Swept, value: impl Fn(&Grown) -> f64) -> f64 {
    let good: Vec<&Grown> = swept.sizes.iter().filter(|size| !failed(size)).collect();
    let upper = &good[good.len() / 2..];
    let x: Vec<f64> = upper.iter().map(|size| size.count as f64).collect();
    let y: Vec<f64> = upper.iter().map(|size| value(size)).collect();
    exponent(&x, &y)
}

/// Time of an estimate and of an iteration.
pub fn times(name: &str, label: &str, title: &str, all: &[&Swept]) -> Figure {
    let mut curves = Vec::new();
    for (index, swept) in all.iter().enumerate() {
        let mark = |grown: &Grown, y: f64| Mark {
            failed: failed(grown),
            ..Mark::at(grown.count as f64, y)
        };
        let total = swept.sizes.iter().map(|grown| Mark {
            spread: Some([grown.size.fastest_s, grown.size.total_s]),
            ..mark(grown, grown.size.fastest_s)
        });
        let power = upper(swept, |grown| grown.size.fastest_s);
        let whole = format!("{}: whole estimate, power {power:.2}", swept.curve);
        curves.push(match index {
            0 => Curve::ours(whole, total.collect()),
            _ => Curve::new(whole, total.collect()),
        });
        let each = swept
            .sizes
            .iter()
            .map(|grown| mark(grown, grown.size.per_iteration_s));
        let power = upper(swept, |grown| grown.size.per_iteration_s);
        let one = format!("{}: one iteration, power {power:.2}", swept.curve);
        curves.push(Curve::new(one, each.collect()));
    }
    Figure {
        name: format!("cost_{name}"),
        title: title.to_owned(),
        note: "Fastest of up to five runs, bars to their median. Powers are fitted over the upper half of \
               the sizes. A cross: the estimate did not end as a physical motion."
            .to_owned(),
        x: Axis::logarithmic(label),
        y: Axis::logarithmic("time [s]"),
        curves,
    }
}

/// Memory of an estimate.
pub fn memory(name: &str, label: &str, all: &[&Swept]) -> Figure {
    let curve = |swept: &&Swept| {
        let marks = swept.sizes.iter().filter_map(|grown| {
            let bytes = grown.memory_bytes.filter(|bytes| *bytes > 0)?;
            Some(Mark {
                failed: failed(grown),
                ..Mark::at(grown.count as f64, bytes as f64 / 1e6)
            })
        });
        Curve::new(swept.curve, marks.collect())
    };
    Figure {
        name: format!("cost_{name}_memory"),
        title: format!(
            "Most memory in use during an estimate, beyond what was before it, against {name}"
        ),
        note: "As the system counts it (VmHWM), each in a process of its own.".to_owned(),
        x: Axis::logarithmic(label),
        y: Axis::logarithmic("memory [MB]"),
        curves: all.iter().map(curve).collect(),
    }
}

/// Every size of a sweep.
pub fn sizes(swept: &Swept) -> Table {
    let header = [
        "samples",
        "flights",
        "verdict",
        "iterations",
        "per iteration ms",
        "solver ms",
        "total ms",
        "total per sample µs",
    ];
    let name = swept.curve.replace([',', ' '], "_").replace("__", "_");
    let mut table = Table::new(&name, &format!("Cost against {}", swept.curve), &header);
    for Grown { size, .. } in &swept.sizes {
        table.row([
            size.samples.to_string(),
            size.flights.to_string(),
            size.verdict.to_owned(),
            size.iterations.to_string(),
            number(1e3 * size.per_iteration_s),
            number(1e3 * size.solver_s),
            number(1e3 * size.total_s),
            number(1e6 * size.total_s / size.samples as f64),
        ]);
    }
    table
}

/// Fitted powers, over all sizes and over the upper half.
pub fn exponents(all: &[Swept]) -> Table {
    let header = [
        "what grows",
        "range",
        "power of the whole time (of the upper half)",
        "of the solver's",
        "of an iteration's",
        "of the iterations",
        "the largest took",
    ];
    let mut table = Table::new("exponents", "", &header);
    for swept in all {
        let counts: Vec<f64> = swept.sizes.iter().map(|grown| grown.count as f64).collect();
        let power = |value: &dyn Fn(&Grown) -> f64| {
            let values: Vec<f64> = swept.sizes.iter().map(value).collect();
            format!(
                "{:.2} ({:.2})",
                exponent(&counts, &values),
                upper(swept, value)
            )
        };
        let Some((first, last)) = swept.sizes.first().zip(swept.sizes.last()) else {
            continue;
        };
        table.row([
            swept.curve.to_owned(),
            format!("{} to {}", first.count, last.count),
            power(&|grown| grown.size.fastest_s),
            power(&|grown| grown.size.solver_s),
            power(&|grown| grown.size.per_iteration_s),
            power(&|grown| grown.size.iterations as f64),
            format!("{:.3} s, {}", last.size.fastest_s, last.size.verdict),
        ]);
    }
    table
}

/// The phases of the largest size of each sweep.
pub fn largest(all: &[Swept]) -> Table {
    let mut header = vec!["what grows", "samples", "flights"];
    header.extend(PHASES.map(Phase::as_str));
    let mut table = Table::new("largest", "Phases of the largest size [ms]", &header);
    for swept in all {
        let Some(Grown { size, .. }) = swept.sizes.last() else {
            continue;
        };
        let head = [
            swept.curve.to_owned(),
            size.samples.to_string(),
            size.flights.to_string(),
        ];
        table.row(
            head.into_iter()
                .chain(size.phases_s.map(|s| number(1e3 * s))),
        );
    }
    table
}
