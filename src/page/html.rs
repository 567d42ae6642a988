//! The page.

use std::fmt::Write;

use super::input::Page;
use super::strobe::{Size, Strobe};
use super::svg::escaped;
use super::{advice, certainty, checks, events, impacts, parameters, residuals, time_map, verdict};
use crate::motion::Timing;
use crate::report::{EstimateMessage, EstimateReport, ExportProvenance};
use crate::visual::View;

/// The style of everything but pictures and charts.
pub(super) const STYLE: &str = include_str!("style.css");

/// The one script of pages: it plays a motion in a picture ([`Strobe::element_that_plays`]).
pub const PLAYER: &str = include_str!("player.js");

/// SHA-256 of [`PLAYER`], by which browsers know the script that may run, and no other.
pub(super) const PLAYER_HASH: &str = "3gmG33cvWU/5sEHIYkwVq9KtJFGyOXRBzRIFDb7SfCY=";

/// Width of the large picture, in its own pixels.
const LARGE_PX: f64 = 760.0;

/// Width and height of the others: side by side they are of one size.
const SMALL_PX: [f64; 2] = [400.0, 330.0];

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// The report in the file is none.
    #[error("the report in it cannot be read: {0}; expected what `enact replay` writes")]
    Report(#[from] serde_json::Error),
}

/// The page, complete in itself. Fails where the report of the estimate is not one.
pub fn html(page: &Page) -> Result<String, PageError> {
    let said = EstimateMessage::read(&page.motion.report)?;
    let report = &said.report;
    let strobe = Strobe::new(page, &said);
    let title = escaped(&page.scene.name);
    let drawn = strobe.as_ref().map_or_else(
        || super::theme::style(0..=super::theme::IN_HAND),
        Strobe::style,
    );
    let mut text = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-{PLAYER_HASH}'\">\n\
         <meta name=\"generator\" content=\"{}\">\n<title>{title}: estimated motion</title>\n<style>\n{STYLE}{drawn}</style>\n\
         <script class=\"player\">{PLAYER}</script>\n</head>\n<body>\n<main>\n<p class=\"over\">Estimated motion</p>\n<h1><bdi>{title}</bdi></h1>\n{}\n",
        escaped(&page.provenance.program),
        verdict::facts(report)
    );
    for loss in page.lost {
        let _ = writeln!(
            text,
            "<p><span class=\"tag\">lost</span> {}</p>",
            escaped(loss)
        );
    }
    section(
        &mut text,
        "The motion",
        &pictures(page, strobe.as_ref(), report),
    );
    section(
        &mut text,
        "Does it fit, and what is to blame",
        &verdict::blame(report),
    );
    let next = advice::advice(page, report);
    let next = next.iter().map(|line| format!("<li>{line}</li>"));
    section(
        &mut text,
        "What to try next",
        &format!("<ol class=\"next\">{}</ol>", next.collect::<String>()),
    );
    let happened = [
        events::events(report),
        impacts::impacts(report),
        impacts::forces(report),
    ];
    section(&mut text, "Events", &happened.concat());
    section(
        &mut text,
        "How certain the motion is",
        &certainty::certainty(report),
    );
    section(
        &mut text,
        "Distance from the samples",
        &residual(page, &said),
    );
    section(
        &mut text,
        "Acted time and physical time",
        &times(page, &said),
    );
    section(&mut text, "Parameters", &parameters::parameters(report));
    section(&mut text, "Checks and samples", &checks::checks(report));
    text += &provenance(page.provenance);
    text += "</main>\n</body>\n</html>\n";
    Ok(text)
}

/// The motion of a page, to be looked at; `None` where no body has one. Fails as [`html`].
pub fn strobe_of<'a>(page: &Page<'a>) -> Result<Option<Strobe<'a>>, PageError> {
    let said = EstimateMessage::read(&page.motion.report)?;
    Ok(Strobe::new(page, &said))
}

fn section(text: &mut String, title: &str, content: &str) {
    let _ = writeln!(text, "<section>\n<h2>{title}</h2>\n{content}\n</section>");
}

fn pictures(page: &Page, strobe: Option<&Strobe>, said: &EstimateReport) -> String {
    let Some(strobe) = strobe else {
        return format!(
            "<p>There is no motion to be seen; the verdict is {}.</p>",
            escaped(&said.verdict)
        );
    };
    let mut text = "<ul class=\"legend\">".to_owned();
    let sign = |class: &str, words: &str| {
        format!(
            "<li><svg viewBox=\"0 0 22 12\" aria-hidden=\"true\"><rect class=\"{class}\" x=\"1\" y=\"1\" width=\"20\" \
             height=\"10\" rx=\"2\"/></svg>{words}</li>"
        )
    };
    for (name, class, is_held) in strobe.legend() {
        let held = if is_held { ", in the hand" } else { "" };
        text += &sign(&class, &format!("<bdi>{}</bdi>{held}", escaped(name)));
    }
    if strobe.has_ghosts() || strobe.has_seen_points() {
        text += &sign("gh", "as it was acted");
    }
    if !said.events.is_empty() {
        text += &sign("ev no", "at an event");
    }
    if !page.scene.obstacles.is_empty() {
        text += &sign("ob", "what stands");
    }
    text += "</ul><div class=\"views\">";
    for view in View::ALL {
        let (class, element) = match view {
            View::ThreeQuarter => {
                let size = Size::Fitted { width_px: LARGE_PX };
                let element = strobe.element_that_plays(view, size);
                (
                    "view main plays",
                    element + "<div class=\"controls\" hidden=\"hidden\"></div>",
                )
            }
            _ => {
                let size = Size::Fixed { size_px: SMALL_PX };
                ("view", strobe.element(view, size))
            }
        };
        let _ = write!(
            text,
            "<figure class=\"{class}\">{element}<figcaption>{}</figcaption></figure>",
            match view {
                View::ThreeQuarter => escaped(&strobe.caption()),
                View::Front => "From the front".to_owned(),
                View::Side => "From the side".to_owned(),
                View::Top => "From above".to_owned(),
            }
        );
    }
    text + "</div>"
}

fn residual(page: &Page, said: &EstimateMessage) -> String {
    if said.report.segments.is_empty() {
        return "<p>No flight has samples.</p>".to_owned();
    }
    let cards = residuals::cards(page, said);
    format!(
        "<p class=\"note\">Flight by flight, and phase by phase, over physical time, all on one scale; dashed: the root mean square.</p>{cards}"
    )
}

fn times(page: &Page, said: &EstimateMessage) -> String {
    let how = match page.scene.timing {
        Timing::Known => "Stamps are physical times: they are kept, up to an offset of the clock.",
        Timing::Edited => {
            "The sketch is edited: every flight has physical times of its own, put one after another here."
        }
        Timing::Unknown { .. } => {
            "It was acted in a tempo of its own: physical times are estimated. Where the line is steep the motion is \
             slower than it was acted, where it is flat faster; along the dashed line it is as fast."
        }
    };
    time_map::chart(page, said).map_or_else(
        || format!("<p>{how}</p><p>No sample has a time.</p>"),
        |chart| format!("<p>{how}</p><figure class=\"chart\">{chart}</figure>"),
    )
}

/// From what the page was made.
fn provenance(of: &ExportProvenance) -> String {
    let mut rows = vec![
        ("made by", of.program.clone()),
        ("command", of.command.clone()),
        (
            "of",
            format!("{} (SHA-256 {})", of.recording, of.recording_sha256),
        ),
        (
            "scene",
            format!("{} (SHA-256 {})", of.scene, of.scene_sha256),
        ),
    ];
    match &of.estimate {
        Some(estimate) => rows.extend([
            ("estimated by", estimate.program.clone()),
            ("command", estimate.command.clone()),
            (
                "from",
                format!(
                    "{} (SHA-256 {})",
                    estimate.recording, estimate.recording_sha256
                ),
            ),
        ]),
        None => rows.push(("estimated from", "not said in the file".to_owned())),
    }
    let rows = rows
        .iter()
        .map(|(name, value)| format!("<dt>{name}</dt><dd><bdi>{}</bdi></dd>", escaped(value)));
    format!("<footer><dl>{}</dl></footer>\n", rows.collect::<String>())
}
