//! How far the motion is from the samples, over time, flight by flight.

use std::collections::BTreeMap;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::chart::{Chart, ChartMark, from_zero};
use super::input::Page;
use super::markup::with_phase;
use super::seen::seen_points;
use super::svg::escaped;
use super::theme::class_of_track;
use crate::motion::{LinkIndex, PoseSample, Sees, Stamp};
use crate::report::units::seconds;
use crate::report::{EstimateMessage, EstimateReport, SegmentLine, TimeMapMessage};
use crate::write::export::motion_at;

/// More flights than these are not drawn one by one.
const DRAWN: usize = 24;

/// A sample near an event is of either flight \[s\].
const EDGE_S: f64 = 1e-6;

/// How far the motion is from one sample.
#[derive(Clone, Copy)]
struct SampleOff {
    time_s: f64,
    position_mm: f64,
    /// None where the tracker sees a point.
    turn_deg: Option<f64>,
}

/// A card per flight.
pub(super) fn cards(page: &Page, said: &EstimateMessage) -> String {
    let segments = &said.report.segments;
    let series = series(page, &said.time_map);
    let of_track = |segment: &SegmentLine| series.get(segment.body.as_str());
    let all = || series.values().flatten();
    let ranges = [
        from_zero(all().map(|off| off.position_mm)),
        from_zero(all().filter_map(|off| off.turn_deg)),
    ];
    let mut shown: Vec<&SegmentLine> = segments.iter().collect();
    let mut text = String::new();
    if shown.len() > DRAWN {
        let worst = |of: &SegmentLine| of.residual_mm.unwrap_or(0.0);
        shown.sort_by(|a, b| worst(b).total_cmp(&worst(a)));
        shown.truncate(DRAWN);
        shown.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
        text += &format!(
            "<p class=\"note\">Of {} flights the {DRAWN} with the largest residuals are drawn.</p>",
            segments.len()
        );
    }
    text += "<div class=\"cards\">";
    for segment in shown {
        let nothing = Vec::new();
        let within = of_track(segment).unwrap_or(&nothing).iter();
        let within = within.filter(|off| {
            (segment.start_s - EDGE_S..=segment.end_s + EDGE_S).contains(&off.time_s)
        });
        text += &card(
            page,
            &said.report,
            segment,
            &within.copied().collect::<Vec<_>>(),
            ranges,
        );
    }
    text + "</div>"
}

fn card(
    page: &Page,
    said: &EstimateReport,
    segment: &SegmentLine,
    offs: &[SampleOff],
    ranges: [[f64; 2]; 2],
) -> String {
    let [mm, deg] = [(segment.residual_mm, " mm"), (segment.residual_deg, "°")]
        .map(|(rms, unit)| rms.map(|rms| format!("{rms:.2}{unit}")));
    let margin_s = 0.02 * (segment.end_s - segment.start_s);
    let track = page.scene.tracks.iter().find(|of| of.name == segment.body);
    let body = track.map(|of| &page.scene.links[of.link].name);
    let inner = said.events.iter().filter(|event| {
        body.is_some_and(|body| event.bodies.contains(body))
            && (segment.start_s + margin_s..=segment.end_s - margin_s).contains(&event.time_s)
    });
    let inner: Vec<(f64, &str)> = inner.map(|of| (of.time_s, of.name.as_str())).collect();
    let mut text = format!(
        "<figure class=\"card\"><figcaption><b><bdi>{}</bdi></b> <span>{} to {}</span><br>{} samples, root mean \
         square {}</figcaption>",
        escaped(&with_phase(&segment.body, segment.phase.as_deref())),
        seconds(segment.start_s),
        seconds(segment.end_s),
        segment.samples,
        match (&mm, &deg) {
            (None, None) => "not seen".to_owned(),
            _ => [&mm, &deg]
                .into_iter()
                .flatten()
                .cloned()
                .collect::<Vec<_>>()
                .join(", "),
        }
    );
    let positions = offs.iter().map(|off| [off.time_s, off.position_mm]);
    let turns = offs
        .iter()
        .filter_map(|off| Some([off.time_s, off.turn_deg?]));
    for (points, rms, range, unit) in [
        (
            positions.collect::<Vec<_>>(),
            segment.residual_mm,
            ranges[0],
            "mm",
        ),
        (turns.collect(), segment.residual_deg, ranges[1], "°"),
    ] {
        if points.len() < 2 {
            continue;
        }
        let class = class_of_track(page.scene, &segment.body);
        let level = rms.map(|at| ChartMark::Level {
            at,
            name: format!("{at:.2}{}{unit}", if unit == "°" { "" } else { " " }),
        });
        let series = ChartMark::Series {
            points,
            classes: [class.clone(), class],
        };
        let chart = Chart {
            size_px: [340.0, 118.0],
            across: [segment.start_s, segment.end_s],
            up: range,
            axes: ["s", unit],
            label: format!(
                "Distance of the motion of {} from its samples in {unit}, from {} to {}",
                segment.body,
                seconds(segment.start_s),
                seconds(segment.end_s)
            ),
            marks: [series]
                .into_iter()
                .chain(level)
                .chain(inner.iter().map(|(at, name)| ChartMark::Event {
                    at: *at,
                    name: (*name).to_owned(),
                }))
                .collect(),
        };
        text += &chart.element();
    }
    text + "</figure>"
}

/// Distances by the name of the track, in order of time.
fn series<'s>(page: &'s Page, time_map: &TimeMapMessage) -> BTreeMap<&'s str, Vec<SampleOff>> {
    let mut all: BTreeMap<&str, Vec<SampleOff>> = BTreeMap::new();
    for (index, track) in page.scene.tracks.iter_enumerated() {
        let offs = match track.sees {
            Sees::Pose => {
                let samples = page.motion.sketches[track.link].iter();
                samples
                    .filter_map(|seen| off(page, track.link, seen))
                    .collect()
            }
            Sees::Point => {
                let seen = seen_points(page, time_map, index).into_iter();
                seen.filter_map(|(at, seen_m)| {
                    off_point(page, track.link, at, [seen_m, track.point_m()])
                })
                .collect()
            }
            Sees::Orientation | Sees::Direction(_) => Vec::new(),
        };
        all.insert(track.name.as_str(), offs);
    }
    all
}

fn off(page: &Page, link: LinkIndex, seen: &PoseSample) -> Option<SampleOff> {
    let there = motion_at(page.motion, link, seen.stamp)?;
    let turn_rad = turn(&there).angle_to(&turn(seen));
    Some(SampleOff {
        time_s: seen.stamp.seconds_since(page.motion.zero),
        position_mm: (there.position_m - seen.position_m).norm() * 1e3,
        turn_deg: Some(turn_rad.to_degrees()),
    })
}

fn off_point(
    page: &Page,
    link: LinkIndex,
    at: Stamp,
    [seen_m, point_m]: [Vector3<f64>; 2],
) -> Option<SampleOff> {
    let there = motion_at(page.motion, link, at)?;
    // Poses of files are of the frame in which the scene gives the body.
    let given_from_link = page.scene.links[link].link_from_given.inverse();
    let point_m = given_from_link * nalgebra::Point3::from(point_m);
    let place_m = there.position_m + turn(&there) * point_m.coords;
    Some(SampleOff {
        time_s: at.seconds_since(page.motion.zero),
        position_mm: (place_m - seen_m).norm() * 1e3,
        turn_deg: None,
    })
}

fn turn(sample: &PoseSample) -> UnitQuaternion<f64> {
    let [x, y, z, w] = sample.quaternion_xyzw;
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}
