//! How certain the motion is, flight by flight.

use std::fmt::Write;

use super::markup::{table, with_phase};
use super::svg::escaped;
use crate::report::units::{decimals, seconds};
use crate::report::{AlongLine, EstimateReport};

/// A table of the deviations along flights.
pub(super) fn certainty(said: &EstimateReport) -> String {
    if said.certainty.is_empty() {
        return "<p>Nothing is told: of bodies in the hand, of joined ones and of a motion that failed it is not known.</p>"
            .to_owned();
    }
    let mut rows = String::new();
    for flight in &said.certainty {
        let _ = write!(
            rows,
            "<tr><th scope=\"row\"><bdi>{}</bdi></th><td>{} to {}</td>",
            escaped(&with_phase(&flight.body, flight.phase.as_deref())),
            seconds(flight.start_s),
            seconds(flight.end_s)
        );
        for (along, unit) in [
            (&flight.position_sd_mm, " mm"),
            (&flight.orientation_sd_deg, "°"),
            (&flight.velocity_sd_mm_s, " mm/s"),
            (&flight.angular_velocity_sd_rad_s, " rad/s"),
        ] {
            let _ = write!(rows, "<td class=\"n\">{}</td>", cell(along, unit));
        }
        rows += "</tr>";
    }
    format!(
        "<p class=\"note\">Standard deviations at a fixed physical time: half of the time less than the first, at most the \
         second. When an impact is has a deviation of its own, among the events.</p>{}",
        table(
            &["body", "flight", "place*", "turn*", "velocity*", "spin*"],
            &rows
        )
    )
}

fn cell(of: &AlongLine, unit: &str) -> String {
    match (of.median, of.largest) {
        (Some(median), Some(largest)) => {
            let shown = |sd: f64| format!("{sd:.*}{unit}", decimals(Some(sd)));
            format!("± {}<br>≤ {}", shown(median), shown(largest))
        }
        _ => "not determined".to_owned(),
    }
}
