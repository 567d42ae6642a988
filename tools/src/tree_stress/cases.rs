//! The hard performances that are measured.

use super::{Draw, Hard, Rod, Seen, Wish};
use crate::joint_wrongs::Wrong;
use crate::trees::{Jointed, ROD_M};

/// The rod of the other studies of joined bodies.
const USUAL: Rod = Rod {
    length_m: ROD_M,
    radius_m: 0.005,
    mass_kg: 0.1,
};

/// Some usual rods that hang from the world, with one point of the last one seen, for 0.9 s.
fn pendulum(name: &str, links: usize, joints: Jointed) -> Hard {
    Hard {
        name: name.to_owned(),
        rods: vec![USUAL; links],
        joints,
        is_clamped: true,
        duration_s: 0.9,
        seen: Seen::End(links - 1),
        draw: Draw::Within([0.8, 4.0]),
        is_exact: true,
        asks_start: true,
        wish: Wish::Reached,
        wrong: Wrong::Nothing,
        distortion: 1.0,
    }
}

/// A pendulum that swings gently, for how cost grows: no draw of many rods whips.
pub fn gentle(links: usize, joints: Jointed, duration_s: f64) -> Hard {
    let most = 1.0 / links as f64;
    Hard {
        duration_s,
        draw: Draw::Within([0.8 * most, 2.0 * most]),
        is_exact: false,
        ..pendulum("gentle pendulum", links, joints)
    }
}

/// Rods that are nearly along the last joint's first axis in passing: there the thin ones have next to no inertia about it.
fn through(name: &str, radius_m: f64) -> Hard {
    Hard {
        rods: vec![Rod { radius_m, ..USUAL }; 2],
        draw: Draw::Through([1.4, 6.0]),
        ..pendulum(name, 2, Jointed::Universal)
    }
}

fn with_masses(name: &str, masses_kg: [f64; 2]) -> Hard {
    Hard {
        rods: masses_kg.map(|mass_kg| Rod { mass_kg, ..USUAL }).into(),
        ..pendulum(name, 2, Jointed::Universal)
    }
}

/// Rods that taper: each as much shorter than the one before, and as much thinner.
fn whip() -> Hard {
    const TAPER: f64 = 0.65;
    let rod = |link: i32| Rod {
        length_m: 0.3 * TAPER.powi(link),
        radius_m: 0.005 * TAPER.powi(link),
        mass_kg: 0.2 * TAPER.powi(3 * link),
    };
    Hard {
        rods: (0..5).map(rod).collect(),
        draw: Draw::Swung(8.0, [0.5, 4.0]),
        ..pendulum("whip of 5 tapering rods", 5, Jointed::Pin)
    }
}

fn straight() -> Hard {
    Hard {
        is_clamped: false,
        seen: Seen::Centre(0),
        draw: Draw::Within([0.02, 0.05]),
        ..pendulum(
            "chain of 3, nearly straight, hardly turning",
            3,
            Jointed::Universal,
        )
    }
}

fn chaotic(duration_s: f64) -> Hard {
    Hard {
        duration_s,
        draw: Draw::FromAbove([1.0, 4.0]),
        is_exact: false,
        ..pendulum(
            &format!("chaotic double pendulum, {duration_s} s"),
            2,
            Jointed::Pin,
        )
    }
}

fn beyond(name: &str, by_m: f64) -> Hard {
    Hard {
        wish: Wish::Beyond(by_m),
        ..pendulum(name, 2, Jointed::Universal)
    }
}

fn one_tracker(name: &str, rod: usize) -> Hard {
    Hard {
        seen: Seen::Whole(rod),
        asks_start: false,
        ..pendulum(name, 5, Jointed::Pin)
    }
}

fn too_long(name: &str, seen: Seen, distortion: f64) -> Hard {
    Hard {
        seen,
        distortion,
        wrong: Wrong::Long(0.1),
        ..pendulum(name, 2, Jointed::Pin)
    }
}

/// All of them, in the order of the tables.
pub fn all() -> Vec<Hard> {
    vec![
        through("universal joint through 90°, thin rods", USUAL.radius_m),
        through("universal joint through 90°, stout rods", 0.05),
        with_masses("masses 10⁴ : 1", [1.0, 1e-4]),
        with_masses("masses 1 : 10⁴", [1e-4, 1.0]),
        whip(),
        straight(),
        chaotic(3.0),
        chaotic(10.0),
        chaotic(30.0),
        beyond("goal 1 mm out of reach", 0.001),
        beyond("goal 100 mm out of reach", 0.1),
        one_tracker("pendulum of 5, one tracker, on the first", 0),
        one_tracker("pendulum of 5, one tracker, on the last", 4),
        too_long(
            "a rod 10 % too long, the tip seen, noise",
            Seen::End(1),
            0.0,
        ),
        too_long("a rod 10 % too long, all seen, a hand", Seen::All, 1.0),
    ]
}
