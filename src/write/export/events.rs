//! Events as a table: what happens when, where, how fast and with which impulse.

use std::fmt::Write;

use super::super::keyframes::quoted;
use super::motion::WrittenMotion;
use super::tables::comment;
use crate::report::{EstimateMessage, EventLine, ExportProvenance, ImpactLine};
use crate::sampling::stamp;

/// The columns of [`events_csv`].
const HEADER: &str = "t_s,t_sd_s,stamp_ns,event,kind,body,other,phase_before,phase_after,contact,\
     x_m,y_m,z_m,nx,ny,nz,approach_m_s,slip_m_s,parting_m_s,slip_after_m_s,\
     jx_n_s,jy_n_s,jz_n_s,impulse_n_s,mx_n_m_s,my_n_m_s,mz_n_m_s";

/// Columns of an impact.
const OF_IMPACT: usize = 17;

/// A row per event in order of time, of a collision one per contact, below comments on where it is from and a header.
///
/// Of an event of one body or two its body, what that hits if it is one, and the phases of the first before and after, empty
/// in flight. Columns of an impact are those of [`ImpactLine`], empty where there is none.
/// Fails where the report in the file is none.
pub fn events_csv(
    motion: &WrittenMotion,
    provenance: &ExportProvenance,
) -> Result<String, serde_json::Error> {
    let said = EstimateMessage::read(&motion.report)?;
    let mut events: Vec<&EventLine> = said.report.events.iter().collect();
    events.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    let mut text = comment(provenance);
    text += HEADER;
    text.push('\n');
    for event in events {
        let row = event_cells(motion, &said, event);
        for impact in &event.impacts {
            let _ = writeln!(text, "{row}{}", impact_cells(impact));
        }
        if event.impacts.is_empty() {
            let contact = quoted(event.contact.as_deref().unwrap_or_default());
            let _ = writeln!(text, "{row},{contact}{}", ",".repeat(OF_IMPACT));
        }
    }
    Ok(text)
}

/// Up to the contact.
fn event_cells(motion: &WrittenMotion, said: &EstimateMessage, event: &EventLine) -> String {
    // What begins or ends is of all bodies.
    let is_of_some = matches!(event.kind.as_str(), "collision" | "change" | "waypoint");
    let names = |at: usize| {
        let name = event.bodies.get(at).filter(|_| is_of_some);
        name.map_or("", String::as_str)
    };
    let [body, other] = [names(0), names(1)];
    let [before, after] = phases(said, body, event.time_s);
    let sd_s = event.time_sd_s.map_or(String::new(), |sd| sd.to_string());
    format!(
        "{},{sd_s},{},{},{},{},{},{},{}",
        event.time_s,
        stamp(motion.zero, event.time_s).0,
        quoted(&event.name),
        event.kind,
        quoted(body),
        quoted(other),
        quoted(before),
        quoted(after),
    )
}

/// The phases of a body that end and begin at a time; empty of flights.
fn phases<'s>(said: &'s EstimateMessage, body: &str, time_s: f64) -> [&'s str; 2] {
    let arcs = said.arcs.iter();
    let arcs = arcs.map(|of| (&of.body, &of.phase, Some(of.start_s), Some(of.end_s)));
    let held = said.report.held.iter();
    let held = held.map(|of| (&of.body, &of.phase, of.start_s, of.end_s));
    let mut beside = ["", ""];
    for (of, phase, start_s, end_s) in arcs.chain(held) {
        let name = phase.as_deref().filter(|_| of == body);
        if let Some(name) = name.filter(|_| end_s == Some(time_s)) {
            beside[0] = name;
        }
        if let Some(name) = name.filter(|_| start_s == Some(time_s)) {
            beside[1] = name;
        }
    }
    beside
}

/// From the contact on.
fn impact_cells(of: &ImpactLine) -> String {
    let mut text = format!(",{}", quoted(of.contact.as_deref().unwrap_or_default()));
    let speeds = [
        of.approach_m_s,
        of.slip_m_s,
        of.parting_m_s,
        of.slip_after_m_s,
    ];
    let places = of.point_m.iter().chain(&of.normal);
    let impulses = of.impulse_n_s.iter().chain([&of.impulse_size_n_s]);
    let impulses = impulses.chain(&of.moment_n_m_s);
    for number in places.chain(&speeds).chain(impulses) {
        let _ = match number.is_finite() {
            true => write!(text, ",{number}"),
            false => write!(text, ","),
        };
    }
    text
}
