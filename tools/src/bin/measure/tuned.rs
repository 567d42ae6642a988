//! Scenes on which methods of estimation are compared.

use enact_tools::perform::{Acting, Style, Truth, bounces, die, flips, hat_box};

/// A scene, acted in one way.
pub struct Scene {
    /// For files.
    pub name: &'static str,
    /// In words.
    pub title: &'static str,
    /// How.
    pub acting: Acting,
    /// What, by seed.
    pub truth: fn(u64) -> Truth,
}

/// All of them.
pub fn scenes() -> Vec<Scene> {
    let (known, unknown) = (Acting::timing_known(), Acting::default());
    let scene = |name, title, acting, truth| Scene {
        name,
        title,
        acting,
        truth,
    };
    vec![
        scene("pencil_tip", "a pencil, tip first", known, |_| {
            Style::Tip.truth()
        }),
        scene("pencil_eraser", "a pencil, eraser first", known, |_| {
            Style::Eraser.truth()
        }),
        scene("cube_2", "a cube, two bounces", known, |seed| cube(2, seed)),
        scene("cube_6", "a cube, six bounces", known, |seed| cube(6, seed)),
        scene("cube_12", "a cube, twelve bounces", known, |seed| {
            cube(12, seed)
        }),
        scene(
            "die",
            "a die, six faces asked for",
            Acting::edited(),
            |_| die::reference(),
        ),
        scene("hat_box", "a hat and a box", known, |_| hat_box::truth()),
        scene("brick", "a brick that flips twice", known, |seed| {
            flips(2, seed).expect("a flipping brick")
        }),
        scene(
            "pencil_tip_unknown",
            "a pencil, tip first, timing unknown",
            unknown,
            |_| Style::Tip.truth(),
        ),
        scene(
            "cube_4_unknown",
            "a cube, four bounces, timing unknown",
            unknown,
            |seed| cube(4, seed),
        ),
        scene(
            "hat_box_unknown",
            "a hat and a box, timing unknown",
            unknown,
            |_| hat_box::truth(),
        ),
    ]
}

fn cube(count: usize, seed: u64) -> Truth {
    bounces(count, seed).expect("a bouncing cube")
}
