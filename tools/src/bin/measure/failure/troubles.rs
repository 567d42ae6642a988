//! Troubles that grow: what is varied, in what settings, on which performance.

use enact_tools::case::Case;
use enact_tools::perform::{Acting, Outliers, Style, bounces, flips};
use enact_tools::stress;

/// The performance of a setting and a seed, or why there is none.
pub type Make = Box<dyn Fn(f64, u64) -> Result<Case, String> + Send + Sync>;

/// A trouble.
pub struct Trouble {
    /// For files.
    pub name: &'static str,
    /// What grows, and its unit.
    pub label: &'static str,
    /// On what performance.
    pub what: &'static str,
    /// From easy to hard.
    pub settings: Vec<f64>,
    /// Whether settings are far apart.
    pub logarithmic: bool,
    /// Whether it acts on the segmentation, before any solve.
    pub acts_before: bool,
    /// Performances.
    pub make: Make,
}

/// Samples per second.
const RATE_HZ: f64 = 120.0;

/// All of them; of each only the first and the last setting where they are few.
pub fn troubles(few: bool) -> Vec<Trouble> {
    let mut all = all();
    for trouble in all.iter_mut().filter(|_| few) {
        trouble.settings.drain(1..trouble.settings.len() - 1);
    }
    all
}

fn all() -> Vec<Trouble> {
    let known = Acting::timing_known;
    vec![
        Trouble {
            name: "bounces",
            label: "number of bounces",
            what: "a cube, timing known",
            settings: vec![1.0, 2.0, 4.0, 8.0, 12.0, 16.0, 20.0],
            logarithmic: false,
            acts_before: false,
            make: Box::new(move |count, seed| cube(count as usize, &known(), seed)),
        },
        Trouble {
            name: "approach",
            label: "approach speed [m/s]",
            what: "a pencil that glances off a wall, timing known",
            settings: vec![1.0, 0.3, 0.1, 0.03, 0.01],
            logarithmic: true,
            acts_before: false,
            make: Box::new(approach),
        },
        Trouble {
            name: "distortion",
            label: "distortion (1: 2 cm and 8° of wander)",
            what: "a pencil, tip first, timing known",
            settings: vec![0.25, 0.5, 1.0, 2.0, 4.0, 8.0],
            logarithmic: true,
            acts_before: false,
            make: Box::new(move |distortion, seed| {
                let acting = Acting {
                    distortion,
                    ..known()
                };
                Ok(Case::pencil(Style::Tip, &acting, seed))
            }),
        },
        Trouble {
            name: "distortion_cube",
            label: "distortion (1: 2 cm and 8° of wander)",
            what: "a cube, six bounces, timing known",
            settings: vec![0.25, 0.5, 1.0, 2.0, 4.0, 8.0],
            logarithmic: true,
            acts_before: false,
            make: Box::new(move |distortion, seed| {
                let acting = Acting {
                    distortion,
                    ..known()
                };
                cube(6, &acting, seed)
            }),
        },
        Trouble {
            name: "tempo",
            label: "wavering of the tempo (sd of its logarithm)",
            what: "a pencil, tip first, acted 2.5 times too slowly, timing unknown",
            settings: vec![0.0, 0.15, 0.3, 0.6, 0.9],
            logarithmic: false,
            acts_before: false,
            make: Box::new(|tempo_variation, seed| {
                let acting = Acting {
                    tempo_variation,
                    ..Acting::default()
                };
                Ok(Case::pencil(Style::Tip, &acting, seed))
            }),
        },
        Trouble {
            name: "slowness",
            label: "acted time per physical time",
            what: "a cube, three bounces, timing unknown",
            settings: vec![1.25, 2.5, 5.0],
            logarithmic: true,
            acts_before: false,
            make: Box::new(|slowdown, seed| {
                let acting = Acting {
                    slowdown,
                    ..Acting::default()
                };
                cube(3, &acting, seed)
            }),
        },
        Trouble {
            name: "marks",
            label: "error of the marks, sd [samples]",
            what: "a cube, four bounces, timing known",
            settings: vec![0.0, 2.0, 4.0, 8.0, 12.0],
            logarithmic: false,
            acts_before: true,
            make: Box::new(move |samples, seed| {
                let acting = Acting {
                    mark_error_s: samples / RATE_HZ,
                    ..known()
                };
                cube(4, &acting, seed)
            }),
        },
        Trouble {
            name: "outliers",
            label: "share of samples that jump [%]",
            what: "a cube, four bounces, timing known",
            settings: vec![0.0, 1.0, 5.0, 10.0, 20.0, 30.0],
            logarithmic: false,
            acts_before: false,
            make: Box::new(move |percent, seed| {
                let outliers = (percent > 0.0).then(|| Outliers::of_share(percent / 100.0));
                let acting = Acting {
                    outliers,
                    ..known()
                };
                cube(4, &acting, seed)
            }),
        },
        Trouble {
            name: "flips",
            label: "flips about the middle axis before the bounce",
            what: "a brick with three different moments, timing known",
            settings: vec![1.0, 2.0, 4.0, 8.0],
            logarithmic: true,
            acts_before: false,
            make: Box::new(move |count, seed| {
                let truth = flips(count as usize, seed).map_err(|error| error.to_string())?;
                Ok(Case::new(&truth, &known(), seed))
            }),
        },
    ]
}

fn cube(count: usize, acting: &Acting, seed: u64) -> Result<Case, String> {
    let truth = bounces(count, seed).map_err(|error| error.to_string())?;
    Ok(Case::new(&truth, acting, seed))
}

/// As the subject `stress` makes it.
fn approach(speed_m_s: f64, seed: u64) -> Result<Case, String> {
    let name = format!("{speed_m_s} m/s against a wall");
    let all = stress::all();
    let mut known = all.iter().filter(|t| t.timing == stress::Timing::Known);
    let trouble = known.find(|t| t.theme == "approach" && t.name == name);
    (trouble.ok_or("no such trouble")?.make)(seed)
}
