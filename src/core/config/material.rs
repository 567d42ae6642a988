//! How bodies bounce on surfaces, by the rules of sports: heights and ratios of speeds that they state, with how far
//! they let balls differ; and how surfaces rub, by a table of friction. None states both.

use super::keys::nearest;
use super::preset::TENNIS_BALL;

/// What a rule states.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stated {
    /// Dropped from there \[m\] it comes back between these heights \[m\], without spin.
    Rebound { drop_m: f64, rebound_m: [f64; 2] },
    /// Speed after over speed before, between these.
    Ratio([f64; 2]),
    /// Friction: kinetic and static. An impact slides at first; where it sticks, more is not needed.
    Friction([f64; 2]),
}

/// A body on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// By this name it is asked for.
    pub name: &'static str,
    /// What bounces on what.
    pub what: &'static str,
    /// The rule, and what it states.
    pub source: &'static str,
    stated: Stated,
    /// The object at hand that bounces so, by its name; none where it is only how something rubs.
    pub(super) object: Option<&'static str>,
}

/// All of them.
pub const MATERIALS: &[Material] = &[
    Material {
        name: "tennis-ball",
        what: "a tennis ball on concrete",
        source: "International Tennis Federation, Rules of Tennis, appendix I: dropped from 254 cm upon a flat, rigid \
                 surface it bounces 135 to 147 cm high (types 1 to 3)",
        stated: Stated::Rebound {
            drop_m: 2.54,
            rebound_m: [1.35, 1.47],
        },
        object: Some(TENNIS_BALL),
    },
    Material {
        name: "table-tennis-ball",
        what: "a table tennis ball, not of celluloid, on steel",
        source: "International Table Tennis Federation, Technical Leaflet T3, B.7: dropped from 305 mm on to a standard \
                 steel block it bounces 240 to 265 mm high",
        stated: Stated::Rebound {
            drop_m: 0.305,
            rebound_m: [0.240, 0.265],
        },
        object: Some("table-tennis-ball"),
    },
    Material {
        name: "table-tennis-table",
        what: "a table tennis ball on the table",
        source: "International Table Tennis Federation, Laws of Table Tennis, 2.1.3: dropped from 30 cm it bounces about \
                 23 cm high; how far tables may differ is not said there",
        stated: Stated::Rebound {
            drop_m: 0.30,
            rebound_m: [0.23, 0.23],
        },
        object: Some("table-tennis-ball"),
    },
    Material {
        name: "football",
        what: "a football at 0.8 bar and 20 °C on steel",
        source: "FIFA Quality Programme for Footballs, FIFA Quality Pro, from 2016: dropped from 2 m on to a steel plate \
                 it bounces 135 to 155 cm high",
        stated: Stated::Rebound {
            drop_m: 2.0,
            rebound_m: [1.35, 1.55],
        },
        object: Some("football"),
    },
    Material {
        name: "basketball",
        what: "a basketball on the playing floor",
        source: "International basketball rules: dropped from 1.8 m, below the ball, it comes back to 1.2 to 1.4 m, above \
                 the ball, which is 75 to 78 cm around",
        // Below the ball, of the greatest and of the smallest one.
        stated: Stated::Rebound {
            drop_m: 1.8,
            rebound_m: [
                1.2 - 0.78 / std::f64::consts::PI,
                1.4 - 0.75 / std::f64::consts::PI,
            ],
        },
        object: Some("basketball"),
    },
    Material {
        name: "baseball",
        what: "a baseball on ash wood, at 26 m/s",
        source: "Major League Baseball: fired at a slab of northern white ash at 85 feet per second it comes back at \
                 0.514 to 0.578 of that; slower ones come back at more",
        stated: Stated::Ratio([0.514, 0.578]),
        object: Some("baseball"),
    },
    rubs("wood-on-wood", "wood on wood", [0.3, 0.5]),
    rubs("metal-on-wood", "metal on wood", [0.3, 0.5]),
    rubs("steel-on-steel", "dry steel on steel", [0.3, 0.6]),
    rubs("rubber-on-concrete", "rubber on dry concrete", [0.7, 1.0]),
];

/// A row of the table of friction, which is no standard and states no conditions: kinetic and static.
const fn rubs(name: &'static str, what: &'static str, between: [f64; 2]) -> Material {
    Material {
        name,
        what,
        source: "S. A. Hill, How and Why, chapter Motion, table Coefficients of Friction: kinetic to static, a textbook's \
                 round values; surfaces differ",
        stated: Stated::Friction(between),
        object: None,
    }
}

/// What a material says something of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coefficient {
    /// Of restitution.
    Restitution,
    /// Of friction.
    Friction,
}

impl Coefficient {
    /// Its key in a scene.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Restitution => "restitution",
            Self::Friction => "friction",
        }
    }

    /// The other one.
    pub const fn other(self) -> Self {
        match self {
            Self::Restitution => Self::Friction,
            Self::Friction => Self::Restitution,
        }
    }
}

impl Material {
    /// The one of a name; otherwise in words what was expected.
    pub fn named(name: &str) -> Result<&'static Self, String> {
        let found = MATERIALS.iter().find(|of| of.name == name);
        found.ok_or_else(|| {
            let names: Vec<&str> = MATERIALS.iter().map(|of| of.name).collect();
            let meant = match nearest(name, &names) {
                Some(near) => format!("did you mean {near}? Expected"),
                None => "expected".into(),
            };
            format!("{meant} one of {}", names.join(", "))
        })
    }

    /// What it says something of, with the least and the greatest to a thousandth: of heights the square root of their ratio.
    pub fn states(&self) -> (Coefficient, [f64; 2]) {
        let (of, between) = match self.stated {
            Stated::Ratio(ratio) => (Coefficient::Restitution, ratio),
            Stated::Rebound { drop_m, rebound_m } => {
                let ratio = rebound_m.map(|of| (of / drop_m).sqrt());
                (Coefficient::Restitution, ratio)
            }
            Stated::Friction(between) => (Coefficient::Friction, between),
        };
        (of, between.map(|of| (of * 1e3).round() / 1e3))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_are_those_of_the_heights() {
        for (name, least, most) in [
            ("tennis-ball", 0.729, 0.761),
            ("table-tennis-ball", 0.887, 0.932),
            ("table-tennis-table", 0.876, 0.876),
            ("football", 0.822, 0.880),
            ("basketball", 0.727, 0.803),
            ("baseball", 0.514, 0.578),
        ] {
            let found = Material::named(name).expect("a material").states();
            let expected = (Coefficient::Restitution, [least, most]);
            assert_eq!(found, expected, "{name}");
        }
        assert_eq!(MATERIALS.len(), 10);
        let mut others = MATERIALS[6..].iter().map(Material::states);
        assert!(others.all(|(of, [least, most])| of == Coefficient::Friction && least < most));
        let said = Material::named("tennis_ball").expect_err("none");
        assert!(said.starts_with("did you mean tennis-ball?"), "{said}");
    }
}
