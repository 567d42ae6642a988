//! Strobe pictures as elements of pages and as files.

use super::super::svg::{escaped, px};
use super::draw::Picture;
use super::layout::{LayoutFrame, Size};
use super::lit::Strobe;
use crate::visual::{Camera, View};

impl Strobe<'_> {
    /// A picture as an element of a page that has the style.
    pub fn element(&self, view: View, size: Size) -> String {
        let frame = LayoutFrame {
            size,
            is_alone: false,
            plays: false,
        };
        let picture = self.picture(view, frame);
        self.wrapped(view, &picture, "")
    }

    /// The same with the motion to be played by [`PLAYER`](crate::page::PLAYER).
    pub fn element_that_plays(&self, view: View, size: Size) -> String {
        let frame = LayoutFrame {
            size,
            is_alone: false,
            plays: true,
        };
        let picture = self.picture(view, frame);
        self.wrapped(view, &picture, "")
    }

    /// A picture as a file of its own.
    pub fn file(&self, view: View) -> String {
        self.alone(view, false)
    }

    /// The same with the motion to be played.
    pub fn file_that_plays(&self, view: View) -> String {
        self.alone(view, true)
    }

    fn alone(&self, view: View, plays: bool) -> String {
        let frame = LayoutFrame {
            size: Size::Fitted { width_px: 760.0 },
            is_alone: true,
            plays,
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

    fn picture(&self, view: View, frame: LayoutFrame) -> Picture {
        let camera = Camera::new(view, &self.scene.gravity_m_s2, &self.points_m);
        Picture::new(self, &camera, frame)
    }

    fn wrapped(&self, view: View, picture: &Picture, within: &str) -> String {
        let [width, height] = picture.size_px.map(px);
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
}
