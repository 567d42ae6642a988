//! Objects that people have at hand, each with where its sizes and its mass are from.
//!
//! Masses and sizes are of one usual specimen; a calliper and a kitchen scale give those of another. Where no
//! standard or maker says a mass it follows from the shape and the density of the material. Coefficients of
//! restitution and friction are rough, on a wooden table, and those of the tennis ball alone are from a standard:
//! free them where they matter.

/// An object, as it is written into a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// By this name it is asked for.
    pub name: &'static str,
    /// What it is, with its frame.
    pub what: &'static str,
    /// Where its sizes and its mass are from.
    pub source: &'static str,
    /// Its mass, as a line of the scene.
    pub(super) mass: &'static str,
    /// Shape, features and coefficients, as lines of its `[[body]]`.
    pub(super) body: &'static str,
    /// Tables below its `[[body]]`: parts and faces.
    pub(super) parts: &'static str,
    /// Feature by which it usually bounces, if not any may.
    pub(super) feature: Option<&'static str>,
}

/// Where the middle of a box is whose origin is in the middle of its bottom, as long as the box has its usual sides.
const ABOVE_ORIGIN: &str = "position_mm = [0, 0, 50]";

impl Preset {
    /// Whether it is one box, which may have other sides.
    pub(super) fn has_sides(&self) -> bool {
        self.sides().is_some()
    }

    /// Its keys with other sides \[mm\]; an origin in the middle of its bottom stays there. `None` where it is no box.
    pub(super) fn sized(&self, [x, y, z]: [f64; 3]) -> Option<String> {
        let sides = format!("size_mm = [{x}, {y}, {z}]");
        let above = format!("position_mm = [0, 0, {}]", 0.5 * z);
        let body = self.body.replace(self.sides()?, &sides);
        Some(body.replace(ABOVE_ORIGIN, &above))
    }

    /// The key of its sides, where it is one box.
    fn sides(&self) -> Option<&'static str> {
        let from = self.body.find("size_mm = [")?;
        let sides = &self.body[from..];
        Some(&sides[..=sides.find(']')?]).filter(|_| self.parts.is_empty())
    }
}

/// The ball that is meant where none is named.
pub(super) const TENNIS_BALL: &str = "ball";

/// All of them.
pub const PRESETS: &[Preset] = &[
    Preset {
        name: "pencil",
        what: "a pencil, sharpened; origin at the tip, z along the shaft",
        source: "190 mm long and 7 mm thick is usual for a new one; 6 g on a scale",
        mass: "mass_g = 6",
        body: "shape = { kind = \"revolution\", profile_mm = [[0, 0], [3.5, 20], [3.5, 190]] }\n\
               restitution = 0.6\n\
               features_mm = { tip = [0, 0, 0], end = [0, 0, 190] }\n",
        parts: "",
        feature: Some("tip"),
    },
    Preset {
        name: "pen",
        what: "a ball pen without its cap; origin at the ball, z along the shaft",
        source: "145 mm long and 8 mm thick; 6 g, near that of a hexagonal plastic one",
        mass: "mass_g = 6",
        body: "shape = { kind = \"revolution\", profile_mm = [[0.5, 0], [1.2, 6], [4, 20], [4, 145]] }\n\
               restitution = 0.5\n\
               features_mm = { tip = [0, 0, 0], end = [0, 0, 145] }\n",
        parts: "",
        feature: Some("tip"),
    },
    Preset {
        name: "die",
        what: "a die; origin in the middle, axes through the faces",
        source: "16 mm is the usual size of dice for games; density of acrylic glass, 1190 kg/m³",
        mass: "density_kg_m3 = 1190",
        body: "shape = { kind = \"rounded_cuboid\", size_mm = [16, 16, 16], radius_mm = 1.5 }\n\
               restitution = 0.5\nfriction = 0.2\n",
        parts: "",
        feature: None,
    },
    Preset {
        name: "mug",
        what: "a mug with its handle towards x; origin in the middle of its bottom, z up",
        source: "82 mm wide and 95 mm high holds 11 fl oz (325 ml); density of stoneware, 2300 kg/m³",
        mass: "density_kg_m3 = 2300",
        body: "restitution = 0.3\nfriction = 0.3\n",
        parts: "\n[[body.part]]\nname = \"cup\"\n\
                shape = { kind = \"revolution\", profile_mm = [[0, 0], [41, 0], [41, 95]], wall_mm = 4.5 }\n\
                \n[[body.part]]\nname = \"handle\"\n\
                shape = { kind = \"cuboid\", size_mm = [8, 14, 60], position_mm = [66, 0, 48] }\n\
                \n[[body.part]]\nname = \"upper bar\"\n\
                shape = { kind = \"cuboid\", size_mm = [22, 14, 8], position_mm = [51, 0, 74] }\n\
                \n[[body.part]]\nname = \"lower bar\"\n\
                shape = { kind = \"cuboid\", size_mm = [22, 14, 8], position_mm = [51, 0, 22] }\n",
        feature: Some("cup/rim 2"),
    },
    Preset {
        name: "box",
        what: "an empty cardboard box, closed; origin in the middle of its bottom, z up",
        source: "200 × 150 × 100 mm; corrugated board of 3 mm with 180 kg/m³ (540 g/m²)",
        mass: "density_kg_m3 = 180",
        body: "shape = { kind = \"cuboid\", size_mm = [200, 150, 100], wall_mm = 3, position_mm = [0, 0, 50] }\n\
               restitution = 0.3\nfriction = 0.4\n",
        parts: "",
        feature: None,
    },
    Preset {
        name: "book",
        what: "a paperback; origin in the middle, z out of the front cover",
        source: "A5 (ISO 216) with 150 leaves of 80 g/m² and 0.1 mm, and two covers: 15.6 mm, 390 g",
        mass: "mass_g = 390",
        body: "shape = { kind = \"cuboid\", size_mm = [148, 210, 15.6] }\n\
               restitution = 0.2\nfriction = 0.4\n",
        parts: "",
        feature: None,
    },
    Preset {
        name: TENNIS_BALL,
        what: "a tennis ball; origin in the middle",
        source: "International Tennis Federation, Rules of Tennis, appendix I: 65.4 to 68.6 mm, 56.0 to 59.4 g, \
                 1.35 to 1.47 m high after a fall of 2.54 m, which is a restitution of 0.73 to 0.76",
        mass: "mass_g = 57.7",
        body: "shape = { kind = \"sphere\", radius_mm = 33.5, wall_mm = 6 }\n\
               restitution = 0.745\nfriction = 0.5\n",
        parts: "",
        feature: None,
    },
    Preset {
        name: "table-tennis-ball",
        what: "a table tennis ball; origin in the middle",
        source: "International Table Tennis Federation, Laws of Table Tennis, 2.3: 40 mm, 2.7 g; a wall of 0.4 mm is usual",
        mass: "mass_g = 2.7",
        body: "shape = { kind = \"sphere\", radius_mm = 20, wall_mm = 0.4 }\n\
               restitution = 0.9\nfriction = 0.5\n",
        parts: "",
        feature: None,
    },
    Preset {
        name: "football",
        what: "a football of size 5; origin in the middle",
        source: "International Football Association Board, Laws of the Game, 2: 68 to 70 cm around, 410 to 450 g; a wall of 4 mm",
        mass: "mass_g = 430",
        body: "shape = { kind = \"sphere\", radius_mm = 110, wall_mm = 4 }\n\
               restitution = 0.8\nfriction = 0.5\n",
        parts: "",
        feature: None,
    },
    Preset {
        name: "basketball",
        what: "a basketball of size 7; origin in the middle",
        source: "International basketball rules: 75 to 78 cm around, 567 to 650 g; a wall of 5 mm",
        mass: "mass_g = 610",
        body: "shape = { kind = \"sphere\", radius_mm = 122, wall_mm = 5 }\n\
               restitution = 0.76\nfriction = 0.5\n",
        parts: "",
        feature: None,
    },
    Preset {
        name: "baseball",
        what: "a baseball; origin in the middle",
        source: "Major League Baseball, Official Baseball Rules, 3.01: 9 to 9¼ inches around, 5 to 5¼ ounces",
        mass: "mass_g = 145",
        body: "shape = { kind = \"sphere\", radius_mm = 36.9 }\n\
               restitution = 0.5\nfriction = 0.5\n",
        parts: "",
        feature: None,
    },
    Preset {
        name: "coin",
        what: "a coin of one euro; origin in the middle, z out of one side",
        source: "European Central Bank, common sides of euro coins: 23.25 × 2.33 mm, 7.5 g",
        mass: "mass_g = 7.5",
        body: "shape = { kind = \"cylinder\", length_mm = 2.33, radius_mm = 11.625 }\n\
               restitution = 0.5\nfriction = 0.2\n",
        parts: "",
        feature: Some("rim -z"),
    },
    Preset {
        name: "racket",
        what: "a table tennis racket; origin in the middle of its blade, z out of one side, the handle towards -y",
        source: "150 mm wide is usual, with a handle of 100 mm; 175 g on a scale",
        mass: "mass_g = 175",
        body: "restitution = 0.4\nfriction = 0.4\n",
        parts: "\n[[body.part]]\nname = \"blade\"\n\
                shape = { kind = \"cylinder\", length_mm = 10, radius_mm = 75 }\n\
                \n[[body.part]]\nname = \"handle\"\n\
                shape = { kind = \"cuboid\", size_mm = [28, 100, 23], position_mm = [0, -124, 0] }\n",
        feature: Some("handle/corner +x -y +z"),
    },
    Preset {
        name: "hat",
        what: "a felt hat; origin in the middle of its opening, z out of the top of the head",
        source: "crown 200 mm wide and 100 mm high, brim 40 mm, felt of 2 mm; 90 g on a scale",
        mass: "mass_g = 90",
        body: "shape = { kind = \"revolution\", profile_mm = [[140, 0], [100, 0], [100, 100], [0, 100]], wall_mm = 2 }\n\
               restitution = 0.1\nfriction = 0.4\n",
        parts: "",
        feature: Some("rim 1"),
    },
    Preset {
        name: "bottle",
        what: "an empty half-litre bottle without its cap; origin in the middle of its bottom, z up",
        source: "65 mm wide and 220 mm high; PET of 1380 kg/m³, 0.35 mm thick, which is near 24 g",
        mass: "mass_g = 24",
        body: "shape = { kind = \"revolution\", profile_mm = [[0, 0], [28, 0], [32.5, 8], [32.5, 140], [13, 190], [13, 220]], wall_mm = 0.35 }\n\
               restitution = 0.4\nfriction = 0.2\n",
        parts: "",
        feature: Some("rim 2"),
    },
    Preset {
        name: "phone",
        what: "a phone; origin in the middle, y up and z out of the screen",
        source: "Apple, technical specifications of the iPhone 15: 71.6 × 147.6 × 7.8 mm, 171 g",
        mass: "mass_g = 171",
        body: "shape = { kind = \"rounded_cuboid\", size_mm = [71.6, 147.6, 7.8], radius_mm = 2 }\n\
               restitution = 0.3\nfriction = 0.2\n",
        parts: "",
        feature: None,
    },
];

/// The preset of a name.
pub fn preset(name: &str) -> Option<&'static Preset> {
    PRESETS.iter().find(|of| of.name == name)
}
