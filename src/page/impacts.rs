//! What happens at collisions, and what carries bodies between events, as tables.

use std::fmt::Write;

use super::markup::{known, table};
use super::svg::escaped;
use crate::report::units::seconds;
use crate::report::{AlongLine, EstimateReport};

/// Impacts contact by contact; nothing where there are none.
pub(super) fn impacts(said: &EstimateReport) -> String {
    let mut rows = String::new();
    for event in &said.events {
        for impact in &event.impacts {
            let contact = impact.contact.as_deref().unwrap_or_default();
            let place = impact.point_m.map(|m| known(m * 1e3));
            let place = place.map(|mm| mm.map_or("?".to_owned(), |mm| format!("{mm:.1}")));
            let speed = |m_s: f64| known(m_s).map_or(String::new(), |of| format!("{of:.3} m/s"));
            let _ = write!(
                rows,
                "<tr><th scope=\"row\"><bdi>{}</bdi><br><span class=\"note\"><bdi>{}</bdi></span></th>\
                 <td class=\"n\">{}</td><td class=\"n\">{}<br>{}</td><td class=\"n\">{}<br>{}</td><td class=\"n\">{}</td></tr>",
                escaped(&event.name),
                escaped(contact),
                place.join(", "),
                speed(impact.approach_m_s),
                speed(impact.slip_m_s),
                speed(impact.parting_m_s),
                speed(impact.slip_after_m_s),
                known(impact.impulse_size_n_s)
                    .map_or(String::new(), |of| format!("{:.3} mN s", of * 1e3)),
            );
        }
    }
    match rows.is_empty() {
        true => String::new(),
        false => format!(
            "<h3>Impacts</h3><p class=\"note\">Speeds of what touches against what it hits, along the normal and across \
             it.</p>{}",
            table(
                &["impact", "at, in mm*", "before*", "after*", "impulse*"],
                &rows
            )
        ),
    }
}

/// Forces of what carries bodies, phase by phase; nothing where nothing does.
pub(super) fn forces(said: &EstimateReport) -> String {
    let mut rows = String::new();
    for segment in &said.segments {
        let Some(phase) = &segment.phase else {
            continue;
        };
        let [presses, friction, pivot] =
            [segment.normal_n, segment.friction_n, segment.pivot_n].map(cell);
        let _ = write!(
            rows,
            "<tr><th scope=\"row\"><bdi>{}</bdi>, <bdi>{}</bdi></th><td>{} to {}</td><td class=\"n\">{presses}</td>\
             <td class=\"n\">{friction}</td><td class=\"n\">{pivot}</td></tr>",
            escaped(&segment.body),
            escaped(phase),
            seconds(segment.start_s),
            seconds(segment.end_s)
        );
    }
    match rows.is_empty() {
        true => String::new(),
        false => format!(
            "<h3>Phases</h3><p class=\"note\">Forces on the body, at the beginning and at the end.</p>{}",
            table(
                &["phase", "", "surface presses*", "friction*", "place holds*"],
                &rows
            )
        ),
    }
}

fn cell(of: Option<AlongLine>) -> String {
    let ends = of.map_or([None; 2], |of| [of.at_start, of.at_end]);
    let shown = |n: f64| format!("{n:.3} N");
    let ends: Vec<String> = ends.into_iter().flatten().map(shown).collect();
    ends.join("<br>")
}
