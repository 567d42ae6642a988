//! What is in a strobe picture, from wherever it is seen.

use std::collections::BTreeSet;

use nalgebra::Vector3;
use typed_index_collections::TiVec;

use super::super::input::Page;
use super::super::seen::seen_points;
use super::super::svg::px;
use super::super::theme;
use super::plan::{Flash, flashes, ghosts, step_s};
use crate::math::Pose;
use crate::motion::{LinkIndex, Scene, Stamp};
use crate::report::EstimateMessage;
use crate::report::units::seconds;
use crate::visual::{Patch, Triangle, View, mesh, patches};
use crate::write::export::WrittenMotion;

/// More events than these are marked without their names.
const NAMED_EVENTS: usize = 16;

/// A motion, ready to be looked at from anywhere.
pub struct Strobe<'a> {
    pub(super) scene: &'a Scene,
    pub(super) motion: &'a WrittenMotion,
    /// Between two flashes.
    pub(super) step_s: f64,
    /// What bodies are covered with.
    pub(super) surfaces: TiVec<LinkIndex, Vec<Triangle>>,
    /// Colour of each body.
    pub(super) colours: TiVec<LinkIndex, usize>,
    /// Of the motion, body by body in order of time.
    pub(super) flashes: Vec<Flash>,
    /// Of the performance.
    pub(super) ghosts: Vec<Flash>,
    /// What is drawn of planes.
    pub(super) patches: Vec<Option<Patch>>,
    /// Where points were seen of which trackers saw nothing else, track by track.
    pub(super) seen_m: Vec<Vec<Vector3<f64>>>,
    /// Where bodies are, for the direction of the views.
    pub(super) points_m: Vec<Vector3<f64>>,
    /// What is written into pictures that stand alone.
    pub(super) notes: Vec<String>,
}

impl<'a> Strobe<'a> {
    /// Of what a page is of. `None` where no body has a motion.
    pub(in super::super) fn new(page: &Page<'a>, said: &EstimateMessage) -> Option<Self> {
        let (scene, motion) = (page.scene, page.motion);
        let step_s = step_s(scene, motion)?;
        let seen = scene
            .tracks
            .keys()
            .map(|track| seen_points(page, &said.time_map, track));
        let seen = seen.map(|points| points.into_iter().map(|(_, point_m)| point_m).collect());
        let all = motion.estimates.iter().chain(&motion.sketches).flatten();
        Some(Self {
            scene,
            motion,
            step_s,
            surfaces: scene.links.iter().map(|of| mesh(&of.shape)).collect(),
            colours: theme::colours(scene),
            flashes: flashes(scene, &said.report, motion, step_s),
            ghosts: ghosts(scene, motion, step_s),
            patches: patches(scene, &motion.estimates),
            points_m: all.map(|sample| sample.position_m).collect(),
            seen_m: seen.collect(),
            notes: page.provenance.lines(),
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
            true if self.has_seen_points() => {
                ", in physical time; dashed: the ways of points, as trackers saw them"
            }
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
    pub(super) fn description(&self, view: View) -> String {
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

    /// Names of bodies with the class of their colour, and whether they are in the hand.
    pub fn legend(&self) -> Vec<(&str, String, bool)> {
        let all = self.scene.links.iter_enumerated().map(|(link, of)| {
            let class = format!("b{}f", self.colours[link]);
            (of.name.as_str(), class, self.scene.is_held(link))
        });
        all.collect()
    }

    /// Whether ways of points are drawn of which trackers saw nothing else.
    pub fn has_seen_points(&self) -> bool {
        self.seen_m.iter().any(|points| points.len() > 1)
    }

    /// Whether a performance is drawn.
    pub fn has_ghosts(&self) -> bool {
        !self.ghosts.is_empty()
    }

    /// The pose of a body's shape where the body is.
    pub(super) fn world_from_shape(&self, link: LinkIndex, world_from_body: &Pose) -> Pose {
        world_from_body * self.scene.links[link].given_from_shape()
    }

    /// Names of events and when they are, where there are few enough.
    pub(super) fn named_events(&self) -> &[(Stamp, String)] {
        match self.motion.events.len() <= NAMED_EVENTS {
            true => &self.motion.events,
            false => &[],
        }
    }
}

/// A step of time in the unit that suits it.
pub(super) fn step_words(step_s: f64) -> String {
    let ms = step_s * 1e3;
    match ms < 1000.0 {
        true => format!("{} ms", px(ms)),
        false => format!("{} s", px(step_s)),
    }
}
