//! Free parameters with their intervals, and what is not determined.

use std::fmt::Write;

use super::markup::{known, list, shown_in, table};
use super::svg::{escaped, px};
use crate::report::units::{bound, decimals, deviation_ms, for_people};
use crate::report::{EstimateReport, ParameterLine};

/// A standard normal deviate is within so many deviations with a probability of 95 %.
const INTERVAL: f64 = 1.96;

/// Free parameters with their intervals, and what was not determined.
pub(super) fn parameters(said: &EstimateReport) -> String {
    let mut rows = String::new();
    for (name, of) in &said.parameters.0 {
        let (factor, unit) = shown_in(&of.unit);
        let digits = decimals(of.sd.map(|sd| sd * factor));
        let value = known(of.value).map_or("?".to_owned(), |v| format!("{:.digits$}", v * factor));
        let interval = match (known(of.value), of.sd) {
            (Some(value), Some(sd)) => format!(
                "{:.digits$} to {:.digits$}",
                (value - INTERVAL * sd) * factor,
                (value + INTERVAL * sd) * factor
            ),
            _ if said.undetermined.contains(name) => "undetermined".to_owned(),
            _ => "not computed".to_owned(),
        };
        let ends = of.bounds.map(|end| escaped(&bound(end * factor)));
        let at_bound = match of.at_bound.as_deref() {
            Some("cone") => " <span class=\"tag\">at the end of its cone</span>".to_owned(),
            Some(end) => format!(" <span class=\"tag\">at its {} bound</span>", escaped(end)),
            None => String::new(),
        };
        let _ = write!(
            rows,
            "<tr><th scope=\"row\"><bdi>{}</bdi></th><td class=\"n\">{value} {unit}</td><td>{interval} {unit}</td>\
             <td class=\"bar\">{}</td><td>{} to {} {unit}{at_bound}</td></tr>",
            escaped(name),
            bar(name, of),
            ends[0],
            ends[1]
        );
    }
    let mut text = match rows.is_empty() {
        true => "<p>The scene leaves nothing free.</p>".to_owned(),
        false => table(
            &[
                "parameter",
                "value*",
                "95 % interval",
                "within its bounds",
                "bounds",
            ],
            &rows,
        ),
    };
    text += "<h3>What the performance does not determine</h3>";
    text += &match said.undetermined.is_empty() {
        true => "<p>Nothing: everything that was asked is determined.</p>".to_owned(),
        false => format!("<p>{}.</p>", list(&said.undetermined)),
    };
    if !said.duration.physical_is_determined {
        text += &said.duration.physical_sd_s.map_or_else(
            || "<p>Nothing says how long the motion lasts.</p>".to_owned(),
            |sd_s| {
                format!(
                    "<p>The duration is known to {} only.</p>",
                    escaped(&deviation_ms(sd_s))
                )
            },
        );
    }
    text
}

/// A value with its interval between its bounds, or about itself where it has none.
fn bar(name: &str, of: &ParameterLine) -> String {
    let Some(value) = known(of.value) else {
        return String::new();
    };
    let half = INTERVAL * of.sd.unwrap_or(0.0);
    let [from, to] = match of.bounds.map(known) {
        [Some(from), Some(to)] if to > from => [from, to],
        _ => [value - 1.6 * half, value + 1.6 * half],
    };
    if !(to > from && half.is_finite()) {
        return String::new();
    }
    let (factor, unit) = for_people(&of.unit);
    let at = |value: f64| 4.0 + 162.0 * ((value - from) / (to - from)).clamp(0.0, 1.0);
    let [left, middle, right] = [value - half, value, value + half].map(at);
    let label = format!(
        "{name}: {:.4} {unit}, 95 % within {:.4} {unit}, drawn from {:.4} to {:.4}",
        value * factor,
        half * factor,
        from * factor,
        to * factor
    );
    format!(
        "<svg viewBox=\"0 0 170 20\" role=\"img\" aria-label=\"{}\"><path class=\"ax\" d=\"M4 10H166M4 6V14M166 6V14\"/>\
         <path class=\"gl\" style=\"stroke-dasharray:none\" stroke-width=\"5\" stroke-opacity=\".35\" d=\"M{} 10H{}\"/>\
         <circle class=\"gp\" cx=\"{}\" cy=\"10\" r=\"4\"/></svg>",
        escaped(&label),
        px(left),
        px(right),
        px(middle)
    )
}
