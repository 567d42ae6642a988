//! The examples of `docs/tracks.md` are read as they stand there.

use enact::config::scene_from_toml;
use enact::motion::{Sees, Weighing};

const PAGE: &str = include_str!("../../docs/tracks.md");

/// A scene with one body that has these tracks.
fn scene(tracks: &str) -> String {
    format!(
        "name = \"tracks\"\ntiming.stamps = \"physical\"\n[[body]]\nname = \"ball\"\nshape = {{ kind = \"sphere\", radius_mm = 30 }}\nmass_g = 100\n{tracks}"
    )
}

fn examples() -> Vec<&'static str> {
    let blocks = PAGE.split("```toml\n").skip(1);
    blocks
        .filter_map(|block| block.split("```").next())
        .collect()
}

#[test]
fn every_example_is_read() {
    let examples = examples();
    assert_eq!(examples.len(), 3);
    let scenes = examples
        .iter()
        .map(|tracks| scene_from_toml(&scene(tracks)));
    let scenes: Vec<_> = scenes
        .map(|scene| scene.expect("as the page has it"))
        .collect();
    let tracks = |of: usize| &scenes[of].tracks.raw;
    assert_eq!(tracks(0)[0].sees, Sees::Point);
    assert!(matches!(tracks(0)[0].weighing, Weighing::Own(own) if own.position_m == 0.003));
    assert_eq!(tracks(1)[0].weighing, Weighing::Messages);
    assert_eq!(tracks(1)[1].name, "ball.stick");
    assert!(matches!(tracks(1)[1].sees, Sees::Direction(axis) if axis.z == 1.0));
    assert_eq!(tracks(2)[0].sees, Sees::Orientation);
}

#[test]
fn what_means_nothing_is_refused_with_what_was_expected() {
    for (tracks, said) in [
        ("[[body.track]]\nsees = \"smell\"", "sees is \"smell\""),
        ("[[body.track]]\nsees = \"direction\"", "Expected axis"),
        ("[[body.track]]\naxis = [0, 0, 1]", "axis does not apply"),
        (
            "[[body.track]]\nsees = \"orientation\"\nposition_sd_mm = 1",
            "position_sd_mm does not apply",
        ),
        (
            "[[body.track]]\nsees = \"point\"\npoint = \"nose\"",
            "unknown point \"nose\"",
        ),
        ("[[body.track]]\n[[body.track]]", "without a name"),
        (
            "topic = \"/a\"\n[[body.track]]",
            "topic beside [[body.track]]",
        ),
        (
            "[[body.track]]\nweights = \"guess\"",
            "expected \"messages\"",
        ),
        (
            "[[body.track]]\nweights = \"messages\"\nposition_sd_mm = 1",
            "expected one of them",
        ),
    ] {
        let error = scene_from_toml(&scene(tracks))
            .expect_err(tracks)
            .to_string();
        assert!(error.contains(said), "{tracks}: {error}");
    }
}
