//! `capture`: runs the live daemon and prints one line per event.

use std::io::{IsTerminal, Write};

use super::account::{Style, account};
use super::arguments::{CaptureArguments, Format};
use super::exit::Exit;
use super::output;
use crate::report::plain;
use crate::service::capture::{
    ActingPage, CaptureEvent, CaptureJob, CountsLine, HttpsLink, Presence, Status, TakeLabel,
    TrackerState, capture,
};

/// Port of the acting page for other devices where none is said.
const HTTPS_PORT: u16 = 9465;

pub(super) fn run(arguments: CaptureArguments, verbose: bool) -> anyhow::Result<Exit> {
    let job = CaptureJob {
        scene: arguments.scene,
        folder: arguments.output,
        iceoryx2: arguments.iceoryx2,
        start_now: arguments.start,
        viewer_port: arguments.viewer_port,
        metrics_port: arguments.metrics_port,
        acting: arguments.acting.map(|file| match file {
            None => ActingPage::Found,
            Some(file) => ActingPage::File(file),
        }),
        https_port: arguments.https.map(|port| port.unwrap_or(HTTPS_PORT)),
    };
    let format = arguments.format;
    let style = Style {
        colours: output::colours_on_stdout(),
        verbose,
    };
    let shows = format == Format::Text && std::io::stderr().is_terminal();
    let each = move |said: &CaptureEvent| {
        if shows {
            // What follows is a line of its own.
            let _ = write!(std::io::stderr(), "\r\x1b[K");
        }
        match format {
            Format::Ndjson => output::print_json("enact.capture/1", said),
            Format::Text => Ok(output::print(&text(said, style))?),
        }
    };
    let show = move |status: &Status| {
        if shows {
            show(status);
        }
    };
    Ok(if capture(&job, each, show)? {
        Exit::Done
    } else {
        Exit::NotWhole
    })
}

fn text(said: &CaptureEvent, style: Style) -> String {
    match said {
        CaptureEvent::Ready {
            topics,
            shortcomings,
            abandoned,
            viewer,
            metrics,
            page,
            acting,
            https,
        } => {
            let mut text = format!("ready: {}\n", plain(&topics.join(", ")));
            if let Some(viewer) = viewer {
                text.push_str(&format!("  shown at {viewer}\n"));
            }
            if let Some(metrics) = metrics {
                text.push_str(&format!(
                    "  /, /health and /metrics at {metrics}, for whoever watches\n"
                ));
            }
            if let Some(page) = page {
                text.push_str(&format!("  operator's page, which directs takes: {page}\n"));
            }
            if let Some(acting) = acting {
                text.push_str(&format!("  acting page, with its pairing code: {acting}\n"));
            }
            if let Some(HttpsLink { link, fingerprint }) = https {
                text.push_str(&format!(
                    "  acting page for other devices: {link}\n{}  its certificate, where the browser warns, SHA-256:\n    {fingerprint}\n",
                    qr(link)
                ));
            }
            for shortcoming in shortcomings {
                text.push_str(&format!("  note: {}\n", plain(shortcoming)));
            }
            for journal in abandoned {
                let journal = plain(journal);
                text.push_str(&format!("  note: cut short: enact recover {journal}\n"));
            }
            text
        }
        CaptureEvent::Started {
            take,
            recording,
            unheard,
            before,
            troubles,
        } => {
            let mut text = format!("take {take}: records {}\n", plain(recording));
            if *before > 0 {
                text.push_str(&format!("  with {before} samples and marks from before\n"));
            }
            for topic in unheard {
                text.push_str(&format!("  warning: nothing comes on {}\n", plain(topic)));
            }
            for trouble in troubles {
                text.push_str(&format!("  warning: {}\n", plain(trouble)));
            }
            text
        }
        CaptureEvent::Heard { topic, .. } => format!("{}: sends\n", plain(topic)),
        CaptureEvent::Silent {
            topic,
            take,
            seen_s,
        } => {
            let take = take.map_or(String::new(), |take| format!(" in take {take}"));
            let topic = plain(topic);
            format!("{topic}: SILENT{take}: its last sample came {seen_s:.1} s ago\n")
        }
        CaptureEvent::Closed {
            take,
            recording,
            messages,
            counts,
            label,
        } => format!(
            "take {take}: {messages} samples and marks in {}\n{}{}",
            plain(recording),
            label_text(label),
            counts_text(counts)
        ),
        CaptureEvent::Discarded { take, recording } => {
            let moved = recording.as_ref();
            let moved = moved.map(|path| format!(", moved to {}", plain(path)));
            format!("take {take}: discarded{}\n", moved.unwrap_or_default())
        }
        CaptureEvent::Broken {
            take,
            recording,
            error,
            ..
        } => format!(
            "take {take}: recording stopped: {}\n  what came before is in {}\n",
            plain(error),
            plain(recording)
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
            format!("take {take}: not estimated: {}\n", plain(error))
        }
        // An answer to a machine.
        CaptureEvent::Asked { .. } => String::new(),
        CaptureEvent::Refused { command, reason } => {
            format!("command {command} refused: {}\n", plain(reason))
        }
        CaptureEvent::Warning { text } => format!("warning: {}\n", plain(text)),
    }
}

/// A link for a camera, light on dark.
fn qr(link: &str) -> String {
    use qrcode::render::unicode::Dense1x2;
    let Ok(code) = qrcode::QrCode::new(link) else {
        return String::new();
    };
    let mut picture = code.render::<Dense1x2>();
    picture
        .dark_color(Dense1x2::Light)
        .light_color(Dense1x2::Dark);
    let picture = picture.build();
    let lines = picture.lines().map(|line| format!("    {line}\n"));
    lines.collect()
}

/// One line per stream: samples received, source of the stamps, and problems.
fn counts_text(counts: &CountsLine) -> String {
    let mut text = String::new();
    for tracker in &counts.trackers {
        let (of, clock) = (&tracker.counts, &tracker.clock);
        let mut line = format!("  {}: {}", plain(&tracker.topic), of.received);
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

/// What was said of a take, if anything was.
fn label_text(label: &TakeLabel) -> String {
    let rating = label.rating.map(|rating| format!("{rating} of 5"));
    let said = [&label.name, &rating, &label.note].into_iter().flatten();
    let said: Vec<_> = said.map(|text| plain(text)).collect();
    match said.is_empty() {
        true => String::new(),
        false => format!("  {}\n", said.join(", ")),
    }
}

/// Prints the status as one line that replaces itself.
fn show(status: &Status) {
    let mut parts = vec![match status.take {
        None => format!("no take; {} samples came by", status.outside),
        Some(take) => format!("take {take}: {} marks", status.counts.marks.received),
    }];
    for tracker in &status.trackers {
        let name = plain(tracker.topic.trim_start_matches("/tracker/"));
        parts.push(match (tracker.state, tracker.seen_s) {
            (Presence::Silent, Some(seen_s)) => format!("{name} SILENT for {seen_s:.0} s"),
            (Presence::Sending, _) => {
                format!("{name} {:.0} Hz{}", tracker.rate_hz, wrong(tracker, status))
            }
            _ => format!("{name} unheard"),
        });
    }
    let _ = write!(std::io::stderr(), "\r\x1b[K{}", parts.join(", "));
}

/// What is wrong with a tracker's samples, if anything is.
fn wrong(tracker: &TrackerState, status: &Status) -> String {
    let mut said = Vec::new();
    if let Some(share) = tracker.valid_share.filter(|share| *share < 0.995) {
        said.push(format!("{:.0} % valid", 100.0 * share));
    }
    let mut lines = status.counts.trackers.iter();
    if let Some(line) = lines.find(|line| line.topic == tracker.topic) {
        let of = &line.counts;
        let wrong = of.missing + of.invalid + of.duplicated + of.frozen;
        said.extend((wrong > 0).then(|| format!("{wrong} wrong")));
    }
    match said.is_empty() {
        true => String::new(),
        false => format!(" ({})", said.join(", ")),
    }
}
