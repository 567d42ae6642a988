//! The motion in a picture, to be played: outlines of bodies and of their ghosts at even times.
//!
//! They are in one element, which is not displayed: attributes `data-d` have what `d` is at each time, one after
//! another with `|` between. `player.js` shows one after the other in place of the flashes.

use std::fmt::Write;

use super::super::svg::line;
use super::draw::Picture;
use super::items::{Item, seen};
use super::layout::Scale;
use super::lit::Strobe;
use super::plan::{Flash, GAP_STEPS, Shows, extent, pose};
use crate::motion::{LinkIndex, PoseSample, Stamp};
use crate::sampling::stamp;
use crate::visual::Camera;
use crate::write::export::{acted_at, motion_at};

/// Outlines a second, where that is not too many.
const RATE_HZ: f64 = 60.0;

/// At most so many, of all bodies.
const FRAMES: usize = 600;

/// At least so many of a body, whatever there is.
const LEAST: usize = 8;

/// The times that are shown.
struct PlayedTimes {
    from: Stamp,
    step_s: f64,
    count: usize,
}

impl PlayedTimes {
    fn of(strobe: &Strobe) -> Option<Self> {
        let [from, until] = extent(strobe.motion)?;
        let span_s = until.seconds_since(from);
        let most = (FRAMES / strobe.scene.links.len().max(1)).max(LEAST);
        let steps = ((span_s * RATE_HZ).ceil() as usize).clamp(1, most - 1);
        Some(Self {
            from,
            step_s: span_s / steps as f64,
            count: steps + 1,
        })
    }

    fn all(&self) -> impl Iterator<Item = Stamp> + '_ {
        (0..self.count).map(|step| stamp(self.from, step as f64 * self.step_s))
    }
}

impl Picture {
    /// Adds the element with the motion, and with what stands.
    pub(super) fn played(
        &mut self,
        strobe: &Strobe,
        camera: &Camera,
        scale: &Scale,
        obstacles: &[Item],
    ) {
        let Some(times) = PlayedTimes::of(strobe) else {
            return;
        };
        let from_s = times.from.seconds_since(strobe.motion.zero);
        let _ = write!(
            self.text,
            "<g class=\"played\" display=\"none\" data-from=\"{from_s:.4}\" data-step=\"{:.6}\" data-count=\"{}\">",
            times.step_s, times.count
        );
        for obstacle in obstacles {
            self.hollow(&obstacle.outline, scale, "ob", 0.8);
        }
        self.ways(strobe, camera, scale);
        for link in strobe.scene.links.keys() {
            let flash = |sample: PoseSample, shows| {
                let flash = Flash {
                    link,
                    at: sample.stamp,
                    world_from_link: pose(&sample),
                    shows,
                };
                seen(strobe, camera, &flash)
            };
            if !strobe.scene.is_held(link) {
                let far_s = GAP_STEPS * strobe.step_s.max(times.step_s);
                let ghosts = times.all().map(|at| {
                    let sample = acted_at(strobe.motion, link, at, far_s)?;
                    Some(flash(sample, Shows::Acted))
                });
                self.frames("gh", scale, ghosts.collect());
            }
            let bodies = times.all().map(|at| {
                let sample = motion_at(strobe.motion, link, at)?;
                Some(flash(sample, Shows::Motion))
            });
            self.body_frames(link, strobe, scale, bodies.collect());
        }
        self.text += "</g>";
    }

    /// A body, with its edges.
    fn body_frames(
        &mut self,
        link: LinkIndex,
        strobe: &Strobe,
        scale: &Scale,
        items: Vec<Option<Item>>,
    ) {
        let creases = items.iter().map(|item| {
            let creases = item.iter().flat_map(|item| &item.outline.creases);
            let lines = creases.map(|crease| line(&scale.all(crease)));
            lines.collect::<String>()
        });
        let creases: Vec<String> = creases.collect();
        self.frames(&format!("b{}f", strobe.colours[link]), scale, items);
        self.path("cr", &creases);
    }

    /// Silhouettes, none where there is no body.
    fn frames(&mut self, class: &str, scale: &Scale, items: Vec<Option<Item>>) {
        let data = items.iter().map(|item| {
            let item = item.as_ref();
            item.map_or(String::new(), |item| scale.closed(&item.outline.silhouette))
        });
        self.path(class, &data.collect::<Vec<_>>());
    }

    /// One path with what it is at each time, unless it is never anything.
    fn path(&mut self, class: &str, frames: &[String]) {
        if frames.iter().any(|data| !data.is_empty()) {
            let frames = frames.join("|");
            let _ = write!(
                self.text,
                "<path class=\"{class}\" stroke-width=\".9\" data-d=\"{frames}\"/>"
            );
        }
    }
}
