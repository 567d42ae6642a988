//! `capture`: runs the live daemon and prints one line per event.

use std::io::{IsTerminal, Write};

use super::account::{Style, account};
use super::arguments::{CaptureArguments, Format};
use super::exit::Exit;
use super::output;
use crate::service::capture::{CaptureEvent, CaptureJob, CountsLine, Status, capture};

pub(super) fn run(arguments: CaptureArguments, verbose: bool) -> anyhow::Result<Exit> {
    let job = CaptureJob {
        scene: arguments.scene,
        folder: arguments.output,
        iceoryx2: arguments.iceoryx2,
        start_now: arguments.start,
        viewer_port: arguments.viewer_port,
        metrics_port: arguments.metrics_port,
    };
    let format = arguments.format;
    let style = Style {
        colours: output::colours_on_stdout(),
        verbose,
    };
    let shows = format == Format::Text && std::io::stderr().is_terminal();
    let mut exit = Exit::Done;
    capture(
        &job,
        |said| {
            if !said.is_whole() {
                exit = Exit::NotWhole;
            }
            if shows {
                // What follows is a line of its own.
                let _ = write!(std::io::stderr(), "\r\x1b[K");
            }
            match format {
                Format::Ndjson => output::print_json("enact.capture/1", said),
                Format::Text => Ok(output::print(&text(said, style))?),
            }
        },
        |status| {
            if shows {
                show(status);
            }
        },
    )?;
    Ok(exit)
}

fn text(said: &CaptureEvent, style: Style) -> String {
    match said {
        CaptureEvent::Ready {
            topics,
            shortcomings,
            abandoned,
            viewer,
            metrics,
        } => {
            let mut text = format!("ready: {}\n", topics.join(", "));
            if let Some(viewer) = viewer {
                text.push_str(&format!("  shown at {viewer}\n"));
            }
            if let Some(metrics) = metrics {
                text.push_str(&format!("  health and metrics at {metrics}\n"));
            }
            for shortcoming in shortcomings {
                text.push_str(&format!("  note: {shortcoming}\n"));
            }
            for journal in abandoned {
                text.push_str(&format!("  note: cut short: enact recover {journal}\n"));
            }
            text
        }
        CaptureEvent::Started { take, recording } => format!("take {take}: records {recording}\n"),
        CaptureEvent::Closed {
            take,
            recording,
            messages,
            counts,
        } => format!(
            "take {take}: {messages} samples and marks in {recording}\n{}",
            counts_text(counts)
        ),
        CaptureEvent::Discarded { take } => format!("take {take}: discarded\n"),
        CaptureEvent::Broken {
            take,
            recording,
            error,
            ..
        } => format!(
            "take {take}: recording stopped: {error}\n  what came before is in {recording}\n"
        ),
        CaptureEvent::SoFar {
            take,
            marks,
            verdict,
            doubt,
            seconds,
        } => {
            let doubt = doubt.as_ref().map(|doubt| format!(": {doubt}"));
            format!(
                "take {take}: {verdict} so far, after mark {marks}, in {:.1} ms{}\n",
                seconds * 1e3,
                doubt.unwrap_or_default()
            )
        }
        CaptureEvent::Estimated { take, report } => {
            format!("take {take}: {}", account(report, style))
        }
        CaptureEvent::NotEstimated { take, error, .. } => {
            format!("take {take}: not estimated: {error}\n")
        }
        // An answer to a machine.
        CaptureEvent::Asked { .. } => String::new(),
        CaptureEvent::Refused { command, reason } => {
            format!("command {command} refused: {reason}\n")
        }
        CaptureEvent::Warning { text } => format!("warning: {text}\n"),
    }
}

/// One line per stream: samples received, source of the stamps, and problems.
fn counts_text(counts: &CountsLine) -> String {
    let mut text = String::new();
    for tracker in &counts.trackers {
        let (of, clock) = (&tracker.counts, &tracker.clock);
        let mut line = format!("  {}: {}", tracker.topic, of.received);
        if let Some(source) = clock.source {
            line.push_str(&format!(
                ", stamps by {source}, delay {:.2} ± {:.2} ms",
                clock.delay_ms, clock.delay_sd_ms
            ));
        }
        let of_clock = [
            ("clock steps", clock.steps),
            ("without a time", clock.unstamped),
        ];
        for (what, count) in of.troubles().into_iter().chain(of_clock) {
            if count > 0 {
                line.push_str(&format!(", {count} {what}"));
            }
        }
        text.push_str(&line);
        text.push('\n');
    }
    let latency = &counts.latency_ms;
    text.push_str(&format!(
        "  to the journal in {:.2} ms (99 %: {:.2} ms, longest {:.2} ms)\n",
        latency.p50, latency.p99, latency.max
    ));
    text
}

/// Prints the status as one line that replaces itself.
fn show(status: &Status) {
    let line = match status.take {
        None => format!("no take; {} samples came by", status.outside),
        Some(take) => {
            let trackers = status.counts.trackers.iter();
            let streams: Vec<String> = trackers
                .map(|tracker| {
                    let of = &tracker.counts;
                    let wrong = of.missing + of.invalid + of.duplicated + of.frozen;
                    let name = tracker.topic.trim_start_matches("/tracker/");
                    match wrong {
                        0 => format!("{name} {}", of.received),
                        _ => format!("{name} {} ({wrong} wrong)", of.received),
                    }
                })
                .collect();
            let marks = status.counts.marks.received;
            format!("take {take}: {}, {marks} marks", streams.join(", "))
        }
    };
    let _ = write!(std::io::stderr(), "\r\x1b[K{line}");
}
