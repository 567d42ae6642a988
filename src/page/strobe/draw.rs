//! The strobe picture from one direction.

use std::fmt::Write;

use nalgebra::Vector3;

use super::super::svg::{line, loops, px, shortened, text, width_em};
use super::items::{Fog, Item, Look, covered, is_event, reach, seen, standing};
use super::layout::{
    FONT_PX, LayoutFrame, Scale, TOLERANCE_PX, fitted, hatches, scale_length_m, spot,
};
use super::lit::{Strobe, step_words};
use super::plan::{Flash, Shows};
use crate::report::units::seconds;
use crate::visual::{Camera, Outline, chain};

/// A plane is seen edge-on where its normal is this nearly across the line of sight, as the cosine.
const EDGE_ON: f64 = 0.03;

/// Characters of a name in a picture.
const NAME: usize = 28;

/// A picture as SVG.
pub(super) struct Picture {
    pub text: String,
    pub size_px: [f64; 2],
}

impl Picture {
    /// Of a strobe, through a camera.
    pub(super) fn new(strobe: &Strobe, camera: &Camera, frame: LayoutFrame) -> Self {
        let seen = |flash: &Flash| seen(strobe, camera, flash);
        let ghosts: Vec<Item> = strobe.ghosts.iter().map(seen).collect();
        let bodies: Vec<Item> = strobe.flashes.iter().map(seen).collect();
        let (obstacles, goals) = standing(strobe, camera);
        let reach = reach([&ghosts[..], &bodies, &goals]);
        let (scale, size_px) = fitted(reach, frame);
        let fog = Fog::new(&bodies, reach);
        let mut picture = Self {
            text: String::new(),
            size_px,
        };
        let [width, height] = size_px.map(px);
        let _ = write!(
            picture.text,
            "<rect class=\"bg\" width=\"{width}\" height=\"{height}\" rx=\"8\"/>"
        );
        picture.planes(strobe, camera, &scale);
        for goal in &goals {
            picture.hollow(&goal.outline, &scale, "go", 1.0);
        }
        if frame.plays {
            picture.played(strobe, camera, &scale, &obstacles);
            picture.text += "<g class=\"flashes\">";
        }
        for ghost in &ghosts {
            picture.hollow(&ghost.outline, &scale, "gh", 0.9);
        }
        let mut solid: Vec<Item> = bodies.into_iter().chain(obstacles).collect();
        // From far to near; those of one flash and body after another stay in order of time.
        solid.sort_by(|a, b| a.nearness_m.total_cmp(&b.nearness_m));
        for item in &solid {
            match item.look {
                Look::Body { colour, shows } => {
                    picture.body(item, colour, shows == Shows::Simulated, &scale, &fog);
                }
                Look::Obstacle | Look::Goal => {
                    picture.hollow(&item.outline, &scale, "ob", 0.8);
                }
            }
        }
        picture.ways(strobe, camera, &scale);
        picture.seen(strobe, camera, &scale);
        for event in solid.iter().filter(|item| is_event(item)) {
            picture.hollow(&event.outline, &scale, "ev no", 1.4);
        }
        let covered: Vec<[f64; 4]> = solid.iter().map(|item| covered(item, &scale)).collect();
        picture.labels(strobe, camera, &scale, &covered);
        if frame.plays {
            picture.text += "</g>";
        }
        picture.foot(strobe, camera, &scale, frame);
        picture
    }

    /// Filled and with a border, in a class.
    pub(super) fn hollow(&mut self, outline: &Outline, scale: &Scale, class: &str, width: f64) {
        let data = scale.closed(&outline.silhouette);
        if !data.is_empty() {
            let _ = write!(
                self.text,
                "<path class=\"{class}\" stroke-width=\"{width}\" d=\"{data}\"/>"
            );
        }
    }

    /// A body, lit.
    fn body(&mut self, item: &Item, colour: usize, is_pale: bool, scale: &Scale, fog: &Fog) {
        let silhouette = scale.closed(&item.outline.silhouette);
        let Some((shade, _)) = item.outline.parts.iter().max_by(|(_, a), (_, b)| {
            let points = |loops: &[Vec<[f64; 2]>]| loops.iter().map(Vec::len).sum::<usize>();
            points(a).cmp(&points(b))
        }) else {
            return;
        };
        self.text += if is_pale { "<g opacity=\".4\">" } else { "<g>" };
        let _ = write!(
            self.text,
            "<path class=\"b{colour}s{shade}\" d=\"{silhouette}\"/>"
        );
        for (other, part) in &item.outline.parts {
            let data = scale.closed(part);
            if other != shade && !data.is_empty() {
                let _ = write!(
                    self.text,
                    "<path class=\"b{colour}s{other}\" d=\"{data}\"/>"
                );
            }
        }
        let creases = item.outline.creases.iter();
        let creases: String = creases.map(|crease| line(&scale.all(crease))).collect();
        let _ = write!(
            self.text,
            "<path class=\"cr\" stroke-width=\".7\" stroke-linejoin=\"round\" d=\"{silhouette}{creases}\"/>"
        );
        let depth = fog.of(item.nearness_m);
        if depth > 0.02 {
            let _ = write!(
                self.text,
                "<path class=\"fg\" fill-opacity=\"{depth:.2}\" d=\"{silhouette}\"/>"
            );
        }
        self.text += "</g>";
    }

    /// Floors, tables and boards: from above an area, edge-on a line with hatches below, as mechanics draws them.
    fn planes(&mut self, strobe: &Strobe, camera: &Camera, scale: &Scale) {
        for patch in strobe.patches.iter().flatten() {
            let corners = patch.corners_m().map(|at| scale.at(camera.project(&at)));
            let normal = patch.world_from_patch.rotation * Vector3::z();
            let towards = normal.dot(&camera.back);
            if towards.abs() > EDGE_ON {
                let class = if towards > 0.0 { "tb" } else { "tb no" };
                let data = loops(&[corners.to_vec()]);
                let _ = write!(
                    self.text,
                    "<path class=\"{class}\" stroke-width=\"1\" d=\"{data}\"/>"
                );
                continue;
            }
            let mut ends = corners;
            ends.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
            let [from, to] = [ends[0], ends[3]];
            let below = [-normal.dot(&camera.right), normal.dot(&camera.up)];
            let _ = write!(
                self.text,
                "<path class=\"ht\" stroke-width=\"1.4\" d=\"{}\"/><path class=\"ht\" stroke-width=\".7\" d=\"{}\"/>",
                line(&[from, to]),
                hatches(from, to, below, self.size_px)
            );
        }
    }

    /// The ways of centres of mass.
    pub(super) fn ways(&mut self, strobe: &Strobe, camera: &Camera, scale: &Scale) {
        let tolerance_m = TOLERANCE_PX / scale.px_per_m;
        for (link, samples) in strobe.motion.estimates.iter_enumerated() {
            let acted = &strobe.motion.sketches[link];
            let is_held = strobe.scene.is_held(link);
            for (samples, class, width) in [
                (acted, "gl".to_owned(), 1.1),
                (samples, format!("b{}", strobe.colours[link]), 1.3),
            ] {
                // What is held is where it was acted.
                if samples.len() < 2 || is_held && class == "gl" {
                    continue;
                }
                let points = samples.iter().map(|of| camera.project(&of.position_m));
                let points: Vec<[f64; 2]> = points.collect();
                let data = line(&scale.all(&chain(&points, tolerance_m)));
                let _ = write!(
                    self.text,
                    "<path class=\"{class} no\" stroke-width=\"{width}\" stroke-linejoin=\"round\" d=\"{data}\"/>"
                );
            }
        }
    }

    /// Where points were seen, with a dot for each.
    fn seen(&mut self, strobe: &Strobe, camera: &Camera, scale: &Scale) {
        for points_m in strobe.seen_m.iter().filter(|points_m| points_m.len() > 1) {
            let points = points_m
                .iter()
                .map(|point_m| scale.at(camera.project(point_m)));
            let points: Vec<[f64; 2]> = points.collect();
            let dots = points
                .iter()
                .map(|[x, y]| format!("M{} {}h0", px(*x), px(*y)));
            let dots: String = dots.collect();
            let _ = write!(
                self.text,
                "<path class=\"gl no\" stroke-width=\"1.1\" d=\"{}\"/><path class=\"gl no\" \
                 style=\"stroke-dasharray:none\" stroke-width=\"3\" stroke-linecap=\"round\" d=\"{dots}\"/>",
                line(&points)
            );
        }
    }

    /// Names of events where they are, and of bodies where they begin, none over another.
    fn labels(&mut self, strobe: &Strobe, camera: &Camera, scale: &Scale, covered: &[[f64; 4]]) {
        let mut at_events: Vec<([f64; 2], String, &str)> = Vec::new();
        for (at, name) in strobe.named_events() {
            let since_s = at.seconds_since(strobe.motion.zero);
            let words = format!("{} {}", shortened(name, NAME), seconds(since_s));
            let mut here = strobe.flashes.iter();
            let here = here.find(|flash| flash.shows == Shows::Event && flash.at == *at);
            if let Some(flash) = here {
                let place = camera.project(&flash.world_from_link.translation.vector);
                at_events.push((scale.at(place), words, "et"));
            }
        }
        let dots: Vec<[f64; 2]> = at_events.iter().map(|(place, ..)| *place).collect();
        let around = |[x, y]: &[f64; 2]| [x - 4.0, y - 4.0, x + 4.0, y + 4.0];
        let mut taken: Vec<[f64; 4]> = dots.iter().map(around).collect();
        let moving = strobe.scene.links.iter_enumerated();
        let moving = moving.filter_map(|(link, of)| {
            let first = strobe.motion.estimates[link].first()?;
            let place = scale.at(camera.project(&first.position_m));
            Some((place, shortened(&of.name, NAME), "ink"))
        });
        let names: Vec<_> = moving.collect();
        let names = names.into_iter().filter(|_| strobe.scene.links.len() > 1);
        for place in &dots {
            let _ = write!(
                self.text,
                "<circle class=\"ep\" cx=\"{}\" cy=\"{}\" r=\"2.6\"/>",
                px(place[0]),
                px(place[1])
            );
        }
        for (place, words, class) in at_events.into_iter().chain(names) {
            let spot = spot(place, &words, self.size_px, [&taken, covered]);
            let [left, top, right, bottom] = spot;
            taken.push(spot);
            let near = [place[0].clamp(left, right), place[1].clamp(top, bottom)];
            if (near[0] - place[0]).hypot(near[1] - place[1]) > 10.0 {
                let _ = write!(
                    self.text,
                    "<path class=\"ax\" stroke-width=\".8\" d=\"{}\"/>",
                    line(&[place, near])
                );
            }
            let attributes = format!(" class=\"{class} halo\" font-size=\"{FONT_PX}\"");
            self.text += &text([left, bottom - 3.0], &attributes, &words);
        }
    }

    /// The axes of the world, a scale, and what else explains a picture that stands alone.
    fn foot(&mut self, strobe: &Strobe, camera: &Camera, scale: &Scale, frame: LayoutFrame) {
        let [width, height] = self.size_px;
        let bottom = height - 16.0 - if frame.is_alone { 22.0 } else { 0.0 };
        let origin = [38.0, bottom - 8.0];
        for (axis, name) in [Vector3::x(), Vector3::y(), Vector3::z()]
            .iter()
            .zip(["x", "y", "z"])
        {
            let [x, y] = camera.project(axis);
            if x.hypot(y) < 0.2 {
                continue;
            }
            let tip = [origin[0] + 20.0 * x, origin[1] - 20.0 * y];
            let _ = write!(
                self.text,
                "<path class=\"ax\" stroke-width=\"1.5\" d=\"{}\"/>",
                line(&[origin, tip])
            );
            let at = [origin[0] + 28.0 * x - 3.0, origin[1] - 28.0 * y + 4.0];
            self.text += &text(at, " class=\"dim\" font-size=\"11\"", name);
        }
        let length_m = scale_length_m(0.25 * width / scale.px_per_m);
        let length_px = length_m * scale.px_per_m;
        let right = width - 20.0;
        let left = right - length_px;
        let data = format!(
            "{}{}{}",
            line(&[[left, bottom - 4.0], [left, bottom + 4.0]]),
            line(&[[left, bottom], [right, bottom]]),
            line(&[[right, bottom - 4.0], [right, bottom + 4.0]])
        );
        let _ = write!(
            self.text,
            "<path class=\"ax\" stroke-width=\"1.5\" d=\"{data}\"/>"
        );
        let words = match length_m < 1.0 {
            true => format!("{} mm", px(length_m * 1e3)),
            false => format!("{} m", px(length_m)),
        };
        let attributes = " class=\"dim\" font-size=\"11\" text-anchor=\"middle\"";
        self.text += &text([0.5 * (left + right), bottom - 8.0], attributes, &words);
        if frame.is_alone {
            self.explain(strobe, bottom + 24.0);
        }
    }

    /// What filled, dashed and pale means.
    fn explain(&mut self, strobe: &Strobe, bottom: f64) {
        let mut signs = vec![(
            "b0s3 cr",
            1.0,
            format!("every {}", step_words(strobe.step_s)),
        )];
        if strobe.has_ghosts() || strobe.has_seen_points() {
            signs.push(("gh", 1.0, "as acted".to_owned()));
        }
        if strobe.flashes.iter().any(|of| of.shows == Shows::Simulated) {
            signs.push(("b0s3 cr", 0.4, "simulated".to_owned()));
        }
        if !strobe.motion.events.is_empty() {
            signs.push(("ev no", 1.0, "event".to_owned()));
        }
        let mut left = 16.0;
        for (class, opacity, words) in signs {
            let _ = write!(
                self.text,
                "<rect class=\"{class}\" opacity=\"{opacity}\" x=\"{}\" y=\"{}\" width=\"16\" height=\"9\"/>",
                px(left),
                px(bottom - 9.0)
            );
            let at = [left + 22.0, bottom];
            self.text += &text(at, " class=\"dim\" font-size=\"12\"", &words);
            left += 22.0 + 12.0 * width_em(&words) + 22.0;
        }
    }
}
