//! The strobe picture from one direction.

use std::fmt::Write;

use nalgebra::Vector3;

use super::super::svg::{line, loops, px, shortened, text, width_em};
use super::plan::{Flash, Shows};
use super::{Strobe, step_words};
use crate::math::Pose;
use crate::motion::GoalTarget;
use crate::report::units::seconds;
use crate::visual::{Camera, Outline, Subject, Visual, chain, mesh, outline, simplified, visuals};

/// Around what is drawn, in pixels.
const MARGIN_PX: f64 = 26.0;

/// Below it there is room for the axes and the scale, in pixels.
const FOOT_PX: f64 = 44.0;

/// Least and greatest height of what is drawn, as a part of the width.
const HEIGHTS: [f64; 2] = [0.3, 0.72];

/// How far off a line may be, in pixels.
const TOLERANCE_PX: f64 = 0.25;

/// How much of the ground covers what is farthest.
const FOG: f64 = 0.55;

/// A plane is seen edge-on where its normal is this nearly across the line of sight, as the cosine.
const EDGE_ON: f64 = 0.03;

/// Characters of a name in a picture.
const NAME: usize = 28;

/// The size of names, in pixels.
const FONT_PX: f64 = 12.0;

/// How large a picture is.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    pub width_px: f64,
    /// Whether it has to explain itself.
    pub is_alone: bool,
}

/// A picture as SVG.
pub(super) struct Picture {
    pub text: String,
    pub size_px: [f64; 2],
}

/// Something solid in the picture.
struct Item {
    outline: Outline,
    nearness_m: f64,
    look: Look,
}

/// How it is drawn.
#[derive(Clone, Copy, PartialEq)]
enum Look {
    Body { colour: usize, shows: Shows },
    Obstacle,
    Goal,
}

/// Where things are on the picture.
struct Scale {
    left_m: f64,
    top_m: f64,
    px_per_m: f64,
    offset_px: [f64; 2],
}

impl Scale {
    fn at(&self, [x_m, y_m]: [f64; 2]) -> [f64; 2] {
        [
            self.offset_px[0] + (x_m - self.left_m) * self.px_per_m,
            self.offset_px[1] + (self.top_m - y_m) * self.px_per_m,
        ]
    }

    fn all(&self, points_m: &[[f64; 2]]) -> Vec<[f64; 2]> {
        points_m.iter().map(|point_m| self.at(*point_m)).collect()
    }

    fn closed(&self, lines_m: &[Vec<[f64; 2]>]) -> String {
        let tolerance_m = TOLERANCE_PX / self.px_per_m;
        let lines = lines_m
            .iter()
            .map(|of| self.all(&simplified(of, tolerance_m)));
        let lines: Vec<Vec<[f64; 2]>> = lines.collect();
        loops(&lines)
    }
}

impl Picture {
    /// Of a strobe, through a camera.
    pub(super) fn new(strobe: &Strobe, camera: &Camera, frame: Frame) -> Self {
        let seen = |flash: &Flash| seen(strobe, camera, flash);
        let ghosts: Vec<Item> = strobe.ghosts.iter().map(seen).collect();
        let mut bodies: Vec<Item> = strobe.flashes.iter().map(seen).collect();
        let (obstacles, goals) = standing(strobe, camera);
        let reach = reach([&ghosts[..], &bodies, &goals]);
        let (scale, size_px) = fitted(reach, frame);
        let fog = Fog::new(&bodies, reach);
        let events: Vec<Item> = bodies.extract_if(.., |item| is_event(item)).collect();
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
        for event in &events {
            picture.hollow(&event.outline, &scale, "ev no", 1.6);
        }
        picture.labels(strobe, camera, &scale);
        picture.foot(strobe, camera, &scale, frame);
        picture
    }

    /// Filled and with a border, in a class.
    fn hollow(&mut self, outline: &Outline, scale: &Scale, class: &str, width: f64) {
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
    fn ways(&mut self, strobe: &Strobe, camera: &Camera, scale: &Scale) {
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

    /// Names of events where they are, and of bodies where they begin, none over another.
    fn labels(&mut self, strobe: &Strobe, camera: &Camera, scale: &Scale) {
        let mut taken: Vec<[f64; 4]> = Vec::new();
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
            let spot = spot(place, &words, self.size_px, &taken);
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
    fn foot(&mut self, strobe: &Strobe, camera: &Camera, scale: &Scale, frame: Frame) {
        let [width, height] = self.size_px;
        let bottom = height - 16.0 - if frame.is_alone { 22.0 } else { 0.0 };
        let origin = [30.0, bottom - 8.0];
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
        if strobe.has_ghosts() {
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

fn is_event(item: &Item) -> bool {
    matches!(
        item.look,
        Look::Body {
            shows: Shows::Event,
            ..
        }
    )
}

fn seen(strobe: &Strobe, camera: &Camera, flash: &Flash) -> Item {
    let world_from_shape = strobe.world_from_shape(flash.link, &flash.world_from_link);
    Item {
        outline: outline(&strobe.surfaces[flash.link], &world_from_shape, camera),
        nearness_m: camera.nearness_m(&flash.world_from_link.translation.vector),
        look: Look::Body {
            colour: strobe.colours[flash.link],
            shows: flash.shows,
        },
    }
}

/// What stands still: obstacles, and goals that have a shape.
fn standing(strobe: &Strobe, camera: &Camera) -> (Vec<Item>, Vec<Item>) {
    let (mut obstacles, mut goals) = (Vec::new(), Vec::new());
    for visual in visuals(strobe.scene, &[]) {
        let Some(shape) = &visual.shape else {
            continue;
        };
        let item = |look| Item {
            outline: outline(&mesh(shape), &visual.frame_from_shape, camera),
            nearness_m: camera.nearness_m(&visual.frame_from_shape.translation.vector),
            look,
        };
        match visual.subject {
            Subject::Obstacle(_) => obstacles.push(item(Look::Obstacle)),
            Subject::Goal(_) if is_shown(strobe, &visual) => goals.push(item(Look::Goal)),
            _ => {}
        }
    }
    (obstacles, goals)
}

/// Whether a goal is drawn: a pose that the motion has is drawn as its event.
fn is_shown(strobe: &Strobe, visual: &Visual) -> bool {
    let Subject::Goal(goal) = visual.subject else {
        return false;
    };
    let goal = &strobe.scene.goals[goal];
    let event = &strobe.scene.events[goal.event].name;
    match &goal.target {
        GoalTarget::Pose { world_from_body } => !strobe.flashes.iter().any(|flash| {
            let is_at = strobe
                .motion
                .events
                .iter()
                .any(|(at, name)| name == event && *at == flash.at);
            is_at && flash.link == goal.link && is_near(&flash.world_from_link, world_from_body)
        }),
        _ => true,
    }
}

/// Whether two poses are drawn as one.
fn is_near(a: &Pose, b: &Pose) -> bool {
    (a.translation.vector - b.translation.vector).norm() < 1e-3
        && a.rotation.angle_to(&b.rotation) < 1e-2
}

/// Least and greatest of both coordinates of what bodies cover \[m\].
fn reach(items: [&[Item]; 3]) -> [[f64; 2]; 2] {
    let silhouettes = items
        .into_iter()
        .flatten()
        .flat_map(|of| &of.outline.silhouette);
    let mut reach = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for point in silhouettes.flatten() {
        for axis in 0..2 {
            reach[axis][0] = reach[axis][0].min(point[axis]);
            reach[axis][1] = reach[axis][1].max(point[axis]);
        }
    }
    if reach[0][0] > reach[0][1] {
        return [[-0.1, 0.1]; 2];
    }
    reach
}

/// How large what is to be seen is drawn, and how large the picture is.
fn fitted([across_m, high_m]: [[f64; 2]; 2], frame: Frame) -> (Scale, [f64; 2]) {
    let [width_m, height_m] = [across_m, high_m].map(|[from, to]| (to - from).max(1e-4));
    let room_px = frame.width_px - 2.0 * MARGIN_PX;
    let [least_px, most_px] = HEIGHTS.map(|part| part * frame.width_px);
    let px_per_m = (room_px / width_m).min((most_px - 2.0 * MARGIN_PX) / height_m);
    let drawn_px = [width_m, height_m].map(|of_m| of_m * px_per_m);
    let inner_px = (drawn_px[1] + 2.0 * MARGIN_PX).clamp(least_px, most_px);
    let foot_px = FOOT_PX + if frame.is_alone { 22.0 } else { 0.0 };
    let scale = Scale {
        left_m: across_m[0],
        top_m: high_m[1],
        px_per_m,
        offset_px: [
            0.5 * (frame.width_px - drawn_px[0]),
            0.5 * (inner_px - drawn_px[1]),
        ],
    };
    (scale, [frame.width_px, inner_px + foot_px])
}

/// What is farther is paler.
struct Fog {
    nearest_m: f64,
    depth_m: f64,
}

impl Fog {
    /// As deep as bodies are, but no less than half as deep as they are wide: a motion in a plane has none.
    fn new(bodies: &[Item], [across_m, _]: [[f64; 2]; 2]) -> Self {
        let depths = bodies.iter().map(|item| item.nearness_m);
        let nearest_m = depths.clone().fold(f64::NEG_INFINITY, f64::max);
        let farthest_m = depths.fold(f64::INFINITY, f64::min);
        Self {
            nearest_m,
            depth_m: (nearest_m - farthest_m).max(0.5 * (across_m[1] - across_m[0])),
        }
    }

    fn of(&self, nearness_m: f64) -> f64 {
        FOG * ((self.nearest_m - nearness_m) / self.depth_m).clamp(0.0, 1.0)
    }
}

/// Short strokes on one side of a line within the picture.
fn hatches(from: [f64; 2], to: [f64; 2], below: [f64; 2], [width, height]: [f64; 2]) -> String {
    let along = [to[0] - from[0], to[1] - from[1]];
    let length = along[0].hypot(along[1]).max(1e-9);
    let unit = along.map(|part| part / length);
    let mut data = String::new();
    for stroke in 0..(length / 9.0).min(1e4) as usize {
        let far = 9.0 * (stroke as f64 + 0.5);
        let at = [from[0] + unit[0] * far, from[1] + unit[1] * far];
        if !(0.0..=width).contains(&at[0]) || !(0.0..=height).contains(&at[1]) {
            continue;
        }
        let end = [
            at[0] + 7.0 * below[0] - 5.0 * unit[0],
            at[1] + 7.0 * below[1] - 5.0 * unit[1],
        ];
        data += &line(&[at, end]);
    }
    data
}

/// Where a text is near a place without being over another: left, top, right and bottom.
fn spot(place: [f64; 2], words: &str, [width, height]: [f64; 2], taken: &[[f64; 4]]) -> [f64; 4] {
    let size = [FONT_PX * width_em(words), FONT_PX + 4.0];
    let mut best = None;
    for distance in [8.0, 16.0, 28.0, 44.0, 64.0, 90.0] {
        for [x, y] in [
            [1.0, 0.0],
            [-1.0, 0.0],
            [0.7, -0.7],
            [-0.7, -0.7],
            [0.7, 0.7],
            [-0.7, 0.7],
            [0.0, -1.0],
            [0.0, 1.0],
        ] {
            let middle = [
                place[0] + x * (distance + 0.5 * size[0]),
                place[1] + y * (distance + 0.5 * size[1]),
            ];
            let left = (middle[0] - 0.5 * size[0]).clamp(4.0, (width - size[0] - 4.0).max(4.0));
            let top = (middle[1] - 0.5 * size[1]).clamp(4.0, height - size[1] - 4.0);
            let here = [left, top, left + size[0], top + size[1]];
            let is_over = |other: &[f64; 4]| {
                here[0] < other[2] && other[0] < here[2] && here[1] < other[3] && other[1] < here[3]
            };
            let covers = |at: [f64; 2]| {
                (here[0]..=here[2]).contains(&at[0]) && (here[1]..=here[3]).contains(&at[1])
            };
            best = best.or(Some(here));
            if !taken.iter().any(is_over) && !covers(place) {
                return here;
            }
        }
    }
    best.unwrap_or([place[0], place[1], place[0] + size[0], place[1] + size[1]])
}

/// The greatest length that people count in below another \[m\].
fn scale_length_m(most_m: f64) -> f64 {
    let power = 10f64.powf(most_m.log10().floor());
    let nice = [5.0, 2.0, 1.0].map(|of| of * power);
    nice.into_iter()
        .find(|length_m| *length_m <= most_m)
        .unwrap_or(power)
}
