//! What is performed: pencils, scenes of several bodies and many bounces, and cubes of any size and
//! speed, with marks as people and as annotators make them.

use enact_tools::case::Case;
use enact_tools::perform::{
    Acting, Polyhedron, Style, Throw, Truth, bounces, die, flips, hat_box, thrown,
};

/// How long the hand rests after the landing in the recordings of this repository \[s\].
const REST_S: f64 = 0.3;

/// A motion of a seed, if there is one.
type Make = Box<dyn Fn(u64) -> Option<Truth>>;

/// A motion, acted in one way.
pub struct Row {
    /// Of which table.
    pub table: &'static str,
    /// Unique.
    pub name: String,
    /// How it is acted.
    pub acting: Acting,
    truth: Make,
}

impl Row {
    /// Its performance of a seed; `None` where no motion is found.
    pub fn case(&self, seed: u64) -> Option<Case> {
        // Objectives are compared with those from the truth, of samples one by one.
        Some(Case::new(&(self.truth)(seed)?, &self.acting, seed).one_by_one())
    }
}

/// Every row, table by table.
pub fn all() -> Vec<Row> {
    let mut rows = pencils();
    rows.extend(scenes());
    rows.extend(scales());
    rows
}

fn timing(acting: &Acting) -> &'static str {
    match (acting.is_timing_known(), acting.hold_after_s > 0.0) {
        (true, _) => "timing known",
        (false, false) => "timing unknown",
        (false, true) => "timing unknown, rest",
    }
}

fn row(table: &'static str, what: &str, acting: Acting, truth: Make) -> Row {
    Row {
        table,
        name: format!("{what}, {}, {}×", timing(&acting), acting.distortion),
        acting,
        truth,
    }
}

/// A recorder that stops with the motion, and one that runs on while the hand rests.
fn pencils() -> Vec<Row> {
    let unknown = |hold_after_s| Acting {
        hold_after_s,
        ..Acting::default()
    };
    let mut rows = Vec::new();
    for (acting, distortions) in [
        (Acting::timing_known(), &[1.0, 2.0, 4.0, 8.0][..]),
        (unknown(0.0), &[1.0, 2.0, 4.0]),
        (unknown(REST_S), &[1.0, 2.0, 4.0]),
    ] {
        for style in Style::ALL {
            for distortion in distortions.iter().copied() {
                let acting = Acting {
                    distortion,
                    ..acting
                };
                let truth = Box::new(move |_| Some(style.truth()));
                let what = format!("pencil, {} first", style.as_str());
                rows.push(row("pencils", &what, acting, truth));
            }
        }
    }
    rows
}

fn scenes() -> Vec<Row> {
    let mut rows = Vec::new();
    let (known, unknown) = (Acting::timing_known(), Acting::default());
    let mut add = |what: &str, acting: Acting, distortion: f64, truth: Make| {
        let acting = Acting {
            distortion,
            ..acting
        };
        rows.push(row("scenes", what, acting, truth));
    };
    for distortion in [1.0, 2.0, 4.0] {
        let hat = || Box::new(|_| Some(hat_box::truth()));
        add("hat and box", known, distortion, hat());
        add("hat and box", unknown, distortion, hat());
        let die = Box::new(|_| Some(die::reference()));
        add("die, edited", Acting::edited(), distortion, die);
    }
    for count in [1, 2, 4, 6, 8, 10, 12, 20] {
        let cube = Box::new(move |seed| bounces(count, seed).ok());
        add(&format!("cube, {count} bounces"), known, 1.0, cube);
    }
    for count in [1, 2, 4, 8] {
        for acting in [known, unknown] {
            let brick = Box::new(move |seed| flips(count, seed).ok());
            add(&format!("brick, {count} flips"), acting, 1.0, brick);
        }
    }
    rows
}

/// How marks and stamps are made, and by how much marks are off where that is said \[s\].
const MARKS: [(&str, Option<f64>); 4] = [
    ("exact", Some(0.0)),
    ("within a sample", None),
    ("a person's", Some(0.03)),
    ("a person's, slow", None),
];

fn marked(marks: (&str, Option<f64>), rate_hz: f64) -> Acting {
    let base = match marks {
        ("a person's, slow", _) => Acting::default(),
        _ => Acting::timing_known(),
    };
    Acting {
        rate_hz,
        mark_error_s: marks.1.unwrap_or(base.mark_error_s),
        ..base
    }
}

fn scales() -> Vec<Row> {
    let mut rows = Vec::new();
    let mut add = |what: String, rate_hz: f64, marks: (&str, Option<f64>), truth: Make| {
        rows.push(Row {
            table: "scales",
            name: format!("{what}, {rate_hz:.0} Hz, marks {}", marks.0),
            acting: marked(marks, rate_hz),
            truth,
        });
    };
    let cube = |throw: Throw, count: usize| -> (String, Make) {
        let (side_mm, fastest) = (2e3 * throw.half_m, throw.fastest_rad_s);
        let what = format!("{side_mm:.0} mm, {fastest:.0} rad/s, {count} bounces");
        let truth = move |seed| thrown(Polyhedron::Cube, &throw, count, seed).ok();
        (what, Box::new(truth))
    };
    for marks in MARKS {
        for count in [4, 8, 12, 20] {
            let (what, truth) = cube(Throw::DIE, count);
            add(what, 120.0, marks, truth);
        }
        let hat = Box::new(|_| Some(hat_box::truth()));
        add("hat and box".to_owned(), 120.0, marks, hat);
    }
    for (side_m, fastest_rad_s) in [
        (0.005, 200.0),
        (0.016, 100.0),
        (0.03, 50.0),
        (0.1, 20.0),
        (0.3, 5.0),
        (0.3, 12.0),
        (1.0, 5.0),
    ] {
        for rate_hz in [120.0, 240.0] {
            let (what, truth) = cube(Throw::sized(side_m, fastest_rad_s), 4);
            add(what, rate_hz, MARKS[1], truth);
        }
    }
    for rate_hz in [60.0, 500.0, 1000.0] {
        let (what, truth) = cube(Throw::sized(0.03, 50.0), 4);
        add(what, rate_hz, MARKS[1], truth);
    }
    rows
}
