//! A motion as one picture, as if a lamp flashed while it was open: bodies at equal steps of time along their
//! ways, the performance beside them as a ghost, and what they touch.

mod draw;
mod plan;

use std::collections::BTreeSet;

use nalgebra::Vector3;
use typed_index_collections::TiVec;

use self::draw::{Frame, Picture};
use self::plan::{Flash, flashes, ghosts, step_s};
use super::svg::escaped;
use super::theme;
use crate::math::Pose;
use crate::motion::{LinkIndex, Scene, Stamp};
use crate::report::units::seconds;
use crate::visual::{Camera, Patch, Triangle, View, mesh, patches};
use crate::write::export::WrittenMotion;

/// More events than these are marked without their names.
const NAMED_EVENTS: usize = 16;

/// A motion, ready to be looked at from anywhere.
pub struct Strobe<'a> {
    scene: &'a Scene,
    motion: &'a WrittenMotion,
    /// Between two flashes.
    step_s: f64,
    /// What bodies are covered with.
    surfaces: TiVec<LinkIndex, Vec<Triangle>>,
    /// Colour of each body.
    colours: TiVec<LinkIndex, usize>,
    /// Of the motion, body by body in order of time.
    flashes: Vec<Flash>,
    /// Of the performance.
    ghosts: Vec<Flash>,
    /// What is drawn of planes.
    patches: Vec<Option<Patch>>,
    /// Where bodies are, for the direction of the views.
    points_m: Vec<Vector3<f64>>,
    /// What is written into pictures that stand alone.
    notes: Vec<String>,
}

impl<'a> Strobe<'a> {
    /// Of a motion that was read back; `notes` are written into pictures that stand alone. `None` where no body
    /// has a motion.
    pub fn new(scene: &'a Scene, motion: &'a WrittenMotion, notes: Vec<String>) -> Option<Self> {
        let step_s = step_s(scene, motion)?;
        let all = motion.estimates.iter().chain(&motion.sketches).flatten();
        Some(Self {
            scene,
            motion,
            step_s,
            surfaces: scene.links.iter().map(|of| mesh(&of.shape)).collect(),
            colours: colours(scene),
            flashes: flashes(scene, motion, step_s),
            ghosts: ghosts(scene, motion, step_s),
            patches: patches(scene, &motion.estimates),
            points_m: all.map(|sample| sample.position_m).collect(),
            notes,
        })
    }

    /// The style of all its pictures.
    pub fn style(&self) -> String {
        let used: BTreeSet<usize> = self.colours.iter().copied().collect();
        theme::style(used.into_iter())
    }

    /// What the pictures show, as a sentence.
    pub fn caption(&self) -> String {
        let mut words = format!("Bodies every {}", step_words(self.step_s));
        words += match self.ghosts.is_empty() {
            true => ", in physical time; no tracker saw a whole pose, so there is no ghost",
            false => ", in physical time; dashed: the same instants as they were acted",
        };
        if let Some(from) = self.motion.simulated_from {
            let from_s = from.seconds_since(self.motion.zero);
            words += &format!("; pale: simulated from {} on", seconds(from_s));
        }
        if self.motion.events.len() > NAMED_EVENTS {
            words += &format!(
                "; events are marked without their names, for there are {}",
                self.motion.events.len()
            );
        }
        words + "."
    }

    /// What a view shows, for who cannot see it.
    fn description(&self, view: View) -> String {
        let mut words = format!(
            "Strobe picture of {:?} from the {} view. {}",
            self.scene.name,
            view.as_str(),
            self.caption()
        );
        for (link, of) in self.scene.links.iter_enumerated() {
            let samples = &self.motion.estimates[link];
            if let (Some(first), Some(last)) = (samples.first(), samples.last()) {
                let [a, b] = [first, last].map(|at| at.position_m);
                words += &format!(
                    " {} goes from {:.2}, {:.2}, {:.2} m to {:.2}, {:.2}, {:.2} m.",
                    of.name, a.x, a.y, a.z, b.x, b.y, b.z
                );
            }
        }
        for (at, name) in self.motion.events.iter().take(NAMED_EVENTS) {
            let at_s = at.seconds_since(self.motion.zero);
            words += &format!(" {name} at {}.", seconds(at_s));
        }
        words
    }

    /// A picture as an element of a page, at most so many pixels wide; the page has the style.
    pub fn element(&self, view: View, width_px: f64) -> String {
        let frame = Frame {
            width_px,
            is_alone: false,
        };
        let picture = self.picture(view, frame);
        self.wrapped(view, &picture, "")
    }

    /// A picture as a file of its own.
    pub fn file(&self, view: View) -> String {
        let frame = Frame {
            width_px: 760.0,
            is_alone: true,
        };
        let picture = self.picture(view, frame);
        let notes: Vec<String> = self.notes.iter().map(|note| escaped(note)).collect();
        let within = format!(
            "<metadata>{}</metadata><style>{}</style>",
            notes.join("\n"),
            self.style()
        );
        let mut text = self.wrapped(view, &picture, &within);
        text.push('\n');
        text
    }

    fn picture(&self, view: View, frame: Frame) -> Picture {
        let camera = Camera::new(view, &self.scene.gravity_m_s2, &self.points_m);
        Picture::new(self, &camera, frame)
    }

    fn wrapped(&self, view: View, picture: &Picture, within: &str) -> String {
        let [width, height] = picture.size_px.map(super::svg::px);
        // Attributes that size it alone, and do not hinder a page.
        let size = match within.is_empty() {
            true => String::new(),
            false => format!(" width=\"{width}\" height=\"{height}\""),
        };
        let name = format!("{}, {} view", self.scene.name, view.as_str());
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\"{size} role=\"img\" \
             aria-label=\"{}\"><title>{}</title><desc>{}</desc>{within}{}</svg>",
            escaped(&name),
            escaped(&name),
            escaped(&self.description(view)),
            picture.text
        )
    }

    /// Names of bodies with the class of their colour, and whether they are in the hand.
    pub fn legend(&self) -> Vec<(&str, String, bool)> {
        let all = self.scene.links.iter_enumerated().map(|(link, of)| {
            let class = format!("b{}f", self.colours[link]);
            (of.name.as_str(), class, self.scene.is_held(link))
        });
        all.collect()
    }

    /// Whether a performance is drawn.
    pub fn has_ghosts(&self) -> bool {
        !self.ghosts.is_empty()
    }

    /// The pose of a body's shape where the body is.
    fn world_from_shape(&self, link: LinkIndex, world_from_link: &Pose) -> Pose {
        world_from_link * self.scene.links[link].link_from_shape()
    }

    /// Names of events and when they are, where there are few enough.
    fn named_events(&self) -> &[(Stamp, String)] {
        match self.motion.events.len() <= NAMED_EVENTS {
            true => &self.motion.events,
            false => &[],
        }
    }
}

/// Colours of bodies, in turn; what is in the hand has its own.
pub(super) fn colours(scene: &Scene) -> TiVec<LinkIndex, usize> {
    let mut flying = 0;
    let colours = scene.links.keys().map(|link| {
        if scene.is_held(link) {
            return theme::IN_HAND;
        }
        flying += 1;
        (flying - 1) % theme::IN_HAND
    });
    colours.collect()
}

/// A step of time in the unit that suits it.
pub(super) fn step_words(step_s: f64) -> String {
    let ms = step_s * 1e3;
    match ms < 1000.0 {
        true => format!("{} ms", super::svg::px(ms)),
        false => format!("{} s", super::svg::px(step_s)),
    }
}
