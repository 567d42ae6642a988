//! Colours, light and dark, of pictures and charts.
//!
//! Nothing is told by colour alone: what was acted is dashed and hollow, what moves is filled, what stands is
//! grey, and all have names.

use std::fmt::Write;

use typed_index_collections::TiVec;

use crate::motion::{LinkIndex, Scene};
use crate::visual::SHADES;

/// Red, green and blue of bodies, from 0 to 255; those after begin again.
const BODIES: [[f64; 3]; 5] = [
    [238.0, 158.0, 44.0],
    [62.0, 134.0, 222.0],
    [46.0, 168.0, 128.0],
    [202.0, 96.0, 164.0],
    [132.0, 118.0, 214.0],
];

/// Those of what is in the hand.
const HELD: [f64; 3] = [150.0, 156.0, 166.0];

/// The style of pictures and charts. Classes: `bg` ground, `ink` text, `dim` lesser text, `ax` axes, `tb` floors,
/// `ob` what stands, `go` goals, `gh` what was acted, `wy` ways, `ev` events, `fg` what is far, `cr` edges, `no`
/// nothing inside, `bNsM` body N in shade M, `bN` its lines.
const STYLE: &str = include_str!("picture.css");

/// The colour of what is in the hand, after those of all others.
pub(super) const IN_HAND: usize = BODIES.len();

/// Colours of bodies, in turn; what is in the hand has its own.
pub(super) fn colours(scene: &Scene) -> TiVec<LinkIndex, usize> {
    let mut flying = 0;
    let colours = scene.links.keys().map(|link| {
        if scene.is_held(link) {
            return IN_HAND;
        }
        flying += 1;
        (flying - 1) % IN_HAND
    });
    colours.collect()
}

/// Class of the lines of the body that a track of that name is on.
pub(super) fn class_of_track(scene: &Scene, track: &str) -> String {
    let of = scene.tracks.iter().find(|of| of.name == track);
    of.map_or_else(
        || "ax".to_owned(),
        |of| format!("b{}", colours(scene)[of.link]),
    )
}

/// The style, with the colours that are used.
pub(super) fn style(colours: impl Iterator<Item = usize>) -> String {
    let mut text = STYLE.to_owned();
    for colour in colours {
        let base = BODIES.get(colour).unwrap_or(&HELD);
        for shade in 0..SHADES {
            let _ = write!(text, ".b{colour}s{shade}{{fill:{}}}", hex(base, shade));
        }
        let _ = writeln!(
            text,
            ".b{colour}{{stroke:{};fill:none}}.b{colour}f{{fill:{};stroke:none}}",
            hex(base, 2),
            hex(base, 3)
        );
    }
    text
}

/// A colour by its brightness: towards a warm dark below the middle, towards white above.
fn hex(base: &[f64; 3], shade: usize) -> String {
    let level = shade as f64 / (SHADES - 1) as f64;
    let part = |base: f64| {
        let value = match level < 0.6 {
            true => base * (0.52 + 0.8 * level),
            false => base + (255.0 - base) * (level - 0.6),
        };
        value.round().clamp(0.0, 255.0) as u8
    };
    let [r, g, b] = base.map(part);
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brighter_shades_are_brighter() {
        for base in BODIES.iter().chain([&HELD]) {
            let lightness = |shade| {
                let hex = hex(base, shade);
                let part = |at: usize| i64::from_str_radix(&hex[at..at + 2], 16).expect("digits");
                part(1) + part(3) + part(5)
            };
            let all: Vec<i64> = (0..SHADES).map(lightness).collect();
            assert!(all.is_sorted() && all[0] < all[SHADES - 1], "{all:?}");
        }
        let style = style([0, IN_HAND].into_iter());
        assert!(style.contains(".b0s0{fill:#") && style.contains(&format!(".b{IN_HAND}f{{")));
        assert!(!style.contains(".b1s0"));
    }
}
