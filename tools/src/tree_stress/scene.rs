//! The scene file of a hard performance.

use super::{Hard, Seen};
use crate::trees::joint_between;

/// Height at which the first rod hangs \[m\].
pub const HANGS_M: f64 = 1.5;

/// The file, with these goals.
pub fn toml(hard: &Hard, goals: &str) -> String {
    let mut text = String::from(
        "name = \"rods\"\n\n[timing]\nstamps = \"physical\"\n\n[weights]\nposition_mm = 10\norientation_deg = 5\n",
    );
    for (link, rod) in hard.rods.iter().enumerate() {
        text += &format!(
            "\n[[body]]\nname = \"rod {}\"\nshape = {{ kind = \"cylinder\", length_mm = {:?}, radius_mm = {:?} }}\nmass_g = {:?}\n",
            link + 1,
            1e3 * rod.length_m,
            1e3 * rod.radius_m,
            1e3 * rod.mass_kg,
        );
        text += &tracks(hard, link);
    }
    for (link, rod) in hard.rods.iter().enumerate() {
        if link == 0 && !hard.is_clamped {
            continue;
        }
        let before_m = hard.rods[link.max(1) - 1].length_m;
        text += &joint_between(hard.joints, link, HANGS_M, [before_m, rod.length_m]);
    }
    text += "\n[[event]]\nname = \"start\"\nkind = \"start\"\n\n[[event]]\nname = \"end\"\nkind = \"end\"\n";
    text + goals
}

fn tracks(hard: &Hard, link: usize) -> String {
    let point = |at_mm: f64| {
        format!(
            "\n[[body.track]]\nsees = \"point\"\ntracker = {{ position_mm = [0, 0, {at_mm:?}] }}\n"
        )
    };
    match hard.seen {
        Seen::End(seen) if seen == link => point(-500.0 * hard.rods[link].length_m),
        Seen::Centre(seen) if seen == link => point(0.0),
        Seen::Whole(seen) if seen == link => String::new(),
        Seen::All => String::new(),
        Seen::End(_) | Seen::Centre(_) | Seen::Whole(_) => "tracked = false\n".to_owned(),
    }
}
