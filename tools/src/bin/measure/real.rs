//! Part 7: real tosses of a cube, which are not part of this repository: residuals and gravity of the
//! first flight, restitution and friction of the first impact, and what would have been predicted.

mod bounce;

use anyhow::Result;
use enact::config::scene_from_toml;

use crate::Options;
use crate::book::Book;
use crate::figure::{Axis, Curve, Figure, Mark, Sheet};
use crate::statistics::{median, quantile, robust_sd};
use crate::tosses::{self, Fit, Flight, RATES_HZ, Toss};
use bounce::{AHEAD_S, Bounce, Miss, Setting};

/// Documented, measured by others, and what impulses fit [kg m²].
const MOMENTS_KG_M2: [f64; 3] = [6.2e-4, 8.1e-4, 1.1e-3];
/// Radii that a corner may have \[m\].
const RADII_M: [f64; 5] = [0.0, 0.003, 0.005, 0.006, 0.007];
/// Half width of a 95 % interval [standard deviations].
const INTERVAL: f64 = 1.96;
/// Friction that sticks is not determined: an interval wider than this is none.
const WIDE: f64 = 1.0;
/// Documented restitution and friction.
const DOCUMENTED: (f64, f64) = (0.125, 0.165);

/// A toss's impact, or why it has no estimate.
type Tried = Result<Bounce, String>;

/// Runs it.
pub fn run(options: &Options, book: &mut Book) -> Result<()> {
    let Some(folder) = tosses::folder() else {
        return Ok(());
    };
    let scene = scene_from_toml(&tosses::scene_toml()?)?;
    let mut all = tosses::read(&folder, &scene)?;
    if options.quick {
        all.truncate(30);
    }
    let flights: Vec<Flight> = all
        .iter()
        .map(|toss| tosses::flight(&scene, toss, RATES_HZ[0]))
        .collect();
    let fits: Vec<&Fit> = flights
        .iter()
        .filter_map(|f| f.result.as_ref().ok())
        .collect();
    book.keep(residuals(&fits))?;
    book.keep(gravity(&fits))?;
    // The moment and the radius are not known well; those that leave the least are charted.
    let mut rows = Vec::new();
    let mut best: Option<(f64, Setting, Vec<Tried>)> = None;
    for moment_kg_m2 in MOMENTS_KG_M2 {
        for radius_m in RADII_M {
            let setting = Setting::new(moment_kg_m2, radius_m)?;
            let bounces: Vec<Tried> = all.iter().map(|toss| setting.bounce(toss)).collect();
            rows.push(row(&setting, &bounces));
            let left = residual(&bounces);
            if best.as_ref().is_none_or(|(least, ..)| left < *least) {
                best = Some((left, setting, bounces));
            }
        }
    }
    if let Some((_, setting, bounces)) = best {
        let of = |bounce: &Bounce| bounce.restitution;
        book.keep(sorted("restitution", &setting, &bounces, of))?;
        let of = |bounce: &Bounce| bounce.friction;
        book.keep(sorted("friction", &setting, &bounces, of))?;
        predictions(book, &setting, &all, &bounces)?;
    }
    book.tabulate(Sheet {
        name: "real_bounces".to_owned(),
        header: [
            "moment of inertia, kg m²",
            "corners rounded by",
            "tosses",
            "estimated",
            "restitution, median (robust sd)",
            "its reported sd, median",
            "friction, median (robust sd)",
            "its reported sd, median",
            "residual after the impact, median",
            "why not",
        ]
        .map(str::to_owned)
        .to_vec(),
        rows,
        ..Sheet::default()
    })
}

/// Median over the tosses of what is left after the impact, in units of the documented noise;
/// infinite where there are too few of them.
fn residual(bounces: &[Tried]) -> f64 {
    let good = bounces.iter().flatten();
    let left = good.map(|bounce| (bounce.residual.0 / 0.02).hypot(bounce.residual.1 / 0.025));
    let left: Vec<f64> = left.collect();
    if 4 * left.len() < bounces.len() {
        return f64::INFINITY;
    }
    median(&left)
}

fn row(setting: &Setting, bounces: &[Tried]) -> Vec<String> {
    let (moment_kg_m2, radius_m) = (setting.moment_kg_m2(), setting.radius_m);
    let good: Vec<&Bounce> = bounces.iter().flatten().collect();
    let spread = |value: &dyn Fn(&Bounce) -> f64| {
        let values: Vec<f64> = good.iter().map(|bounce| value(bounce)).collect();
        format!("{:.3} ({:.3})", median(&values), robust_sd(&values))
    };
    let sd = |value: &dyn Fn(&Bounce) -> Option<f64>| {
        let values: Vec<f64> = good.iter().filter_map(|bounce| value(bounce)).collect();
        format!(
            "{:.4} ({} of {})",
            median(&values),
            values.len(),
            good.len()
        )
    };
    let middle = |value: &dyn Fn(&Bounce) -> f64| {
        median(
            &good
                .iter()
                .map(|bounce| value(bounce))
                .collect::<Vec<f64>>(),
        )
    };
    let (mut few, mut others) = (0, 0);
    for reason in bounces.iter().filter_map(|bounce| bounce.as_ref().err()) {
        if reason.contains("samples before") {
            few += 1;
        } else {
            others += 1;
            eprintln!("moment {moment_kg_m2:e}, radius {radius_m}: {reason}");
        }
    }
    vec![
        format!("{moment_kg_m2:e}"),
        format!("{} mm", 1e3 * radius_m),
        bounces.len().to_string(),
        good.len().to_string(),
        spread(&|bounce| bounce.restitution.0),
        sd(&|bounce| bounce.restitution.1),
        spread(&|bounce| bounce.friction.0),
        sd(&|bounce| bounce.friction.1),
        format!(
            "{:.3} mm, {:.3}°",
            middle(&|bounce| bounce.residual.0),
            middle(&|bounce| bounce.residual.1)
        ),
        format!("{few} touch again within 3 samples, {others} not physical"),
    ]
}

/// Shares of tosses below a value.
fn shares(values: impl Iterator<Item = f64>) -> Vec<Mark> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let count = values.len() as f64;
    let ranked = values.into_iter().enumerate();
    ranked
        .map(|(rank, value)| Mark::at(value, 100.0 * (rank + 1) as f64 / count))
        .collect()
}

fn residuals(fits: &[&Fit]) -> Figure {
    let ends = || [Mark::at(1.0, 0.0), Mark::at(1.0, 100.0)].to_vec();
    Figure {
        name: "real_residuals".to_owned(),
        title: "Residuals of real first flights are as large as the cameras' noise".to_owned(),
        note: format!(
            "{} tosses of a cube, gravity free; rms per axis, the degrees of freedom taken off, over the \
             documented noise of 0.02 mm and 0.025°.",
            fits.len()
        ),
        x: Axis::logarithmic("residual over the documented noise"),
        y: Axis::linear("tosses with less [%]"),
        curves: vec![
            Curve::new(
                "position",
                shares(fits.iter().map(|fit| fit.position_mm / 0.02)),
            ),
            Curve::new(
                "orientation",
                shares(fits.iter().map(|fit| fit.orientation_deg / 0.025)),
            ),
            Curve::bound("as documented", ends()),
        ],
    }
}

fn gravity(fits: &[&Fit]) -> Figure {
    let mut sorted: Vec<&&Fit> = fits.iter().collect();
    sorted.sort_by(|a, b| b.gravity_m_s2.z.total_cmp(&a.gravity_m_s2.z));
    let marks = sorted.iter().enumerate().map(|(rank, fit)| {
        let value = -fit.gravity_m_s2.z;
        Mark {
            spread: fit
                .sd_m_s2
                .map(|sd| [value - INTERVAL * sd, value + INTERVAL * sd]),
            ..Mark::at((rank + 1) as f64, value)
        }
    });
    let values: Vec<f64> = fits.iter().map(|fit| -fit.gravity_m_s2.z).collect();
    let sds: Vec<f64> = fits.iter().filter_map(|fit| fit.sd_m_s2).collect();
    let ends = |value: f64| vec![Mark::at(1.0, value), Mark::at(fits.len() as f64, value)];
    let middle = median(&values);
    Figure {
        name: "real_gravity".to_owned(),
        title: "Gravity from 10 to 22 samples of each real toss, with the reported 95 % intervals"
            .to_owned(),
        note: format!(
            "Sorted. Median {middle:.3} m/s², robust spread over the tosses {:.3}, median reported standard \
             deviation {:.3}: lengths are some 2 % short, by place and camera, and that is no noise.",
            robust_sd(&values),
            median(&sds)
        ),
        x: Axis::linear("toss, by gravity"),
        y: Axis::linear("vertical gravity [m/s²]"),
        curves: vec![
            Curve::ours("estimated", marks.collect()),
            Curve::bound(format!("median {middle:.3}"), ends(middle)),
            Curve::bound("true 9.81", ends(9.81)),
        ],
    }
}

fn sorted(
    quantity: &str,
    setting: &Setting,
    bounces: &[Tried],
    of: impl Fn(&Bounce) -> (f64, Option<f64>),
) -> Figure {
    let mut values: Vec<(f64, Option<f64>)> = bounces.iter().flatten().map(of).collect();
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let middle = median(&values.iter().map(|value| value.0).collect::<Vec<f64>>());
    let marks = values.iter().enumerate().map(|(rank, (value, sd))| {
        let sd = sd.filter(|sd| INTERVAL * sd < WIDE);
        Mark {
            spread: sd.map(|sd| [value - INTERVAL * sd, value + INTERVAL * sd]),
            failed: sd.is_none(),
            ..Mark::at((rank + 1) as f64, *value)
        }
    });
    let ends = vec![Mark::at(1.0, middle), Mark::at(values.len() as f64, middle)];
    Figure {
        name: format!("real_{quantity}"),
        title: format!(
            "The first impact's {quantity} in real tosses, with the reported 95 % intervals"
        ),
        note: format!(
            "Sorted; {} of {} tosses have enough samples before the next contact. Moment of inertia \
             {:e} kg m², corners rounded by {} mm. A cross: not determined.",
            values.len(),
            bounces.len(),
            setting.moment_kg_m2(),
            1e3 * setting.radius_m
        ),
        x: Axis::linear(&format!("toss, by {quantity}")),
        y: Axis::linear(quantity),
        curves: vec![
            Curve::ours("estimated", marks.collect()),
            Curve::bound(format!("median {middle:.3}"), ends),
        ],
    }
}

/// The law that all tosses but one say.
fn without(bounces: &[Tried], toss: usize) -> (f64, f64) {
    let others = bounces
        .iter()
        .enumerate()
        .filter(|(index, _)| *index != toss);
    let others: Vec<&Bounce> = others
        .filter_map(|(_, bounce)| bounce.as_ref().ok())
        .collect();
    let of = |value: &dyn Fn(&Bounce) -> f64| {
        median(
            &others
                .iter()
                .map(|bounce| value(bounce))
                .collect::<Vec<f64>>(),
        )
    };
    (
        of(&|bounce| bounce.restitution.0).clamp(0.0, 1.0),
        of(&|bounce| bounce.friction.0).max(0.0),
    )
}

/// A law for each toss, if any.
type Laws<'a> = (&'static str, Box<dyn Fn(usize) -> Option<(f64, f64)> + 'a>);

fn predictions(
    book: &mut Book,
    setting: &Setting,
    tosses: &[Toss],
    bounces: &[Tried],
) -> Result<()> {
    let laws: [Laws; 4] = [
        (
            "restitution and friction of the other tosses",
            Box::new(|toss| Some(without(bounces, toss))),
        ),
        (
            "the same without friction",
            Box::new(|toss| Some((without(bounces, toss).0, 0.0))),
        ),
        ("as documented", Box::new(|_| Some(DOCUMENTED))),
        ("no impact", Box::new(|_| None)),
    ];
    let mut position = Vec::new();
    let mut orientation = Vec::new();
    let mut refused = 0;
    for (index, (name, law)) in laws.iter().enumerate() {
        let mut misses: Vec<Miss> = Vec::new();
        for (toss_index, toss) in tosses.iter().enumerate() {
            match setting.misses(toss, law(toss_index)) {
                Ok(of_toss) => misses.extend(of_toss),
                Err(reason) if index == 0 => {
                    refused += 1;
                    eprintln!("toss {}: {reason}", toss.number);
                }
                Err(_) => {}
            }
        }
        let make = |marks| {
            if index == 0 {
                Curve::ours(*name, marks)
            } else {
                Curve::new(*name, marks)
            }
        };
        position.push(make(binned(&misses, |miss| miss.position_mm)));
        orientation.push(make(binned(&misses, |miss| miss.orientation_deg)));
    }
    for (what, label, curves) in [
        ("position", "error of the centre [mm]", position),
        ("orientation", "error of the orientation [°]", orientation),
    ] {
        book.keep(Figure {
            name: format!("real_prediction_{what}"),
            title: format!("What is predicted of the {what} after the first impact, from before it"),
            note: format!(
                "{} real tosses, {refused} more without a predicted impact. From the first flight alone; every \
                 later contact is an impact by the same law. Moment and corners' radius are those that fit all \
                 tosses best, restitution and friction those of the other tosses. Medians, bars from quartile to quartile.",
                tosses.len() - refused
            ),
            x: Axis::linear("time since the impact [ms]"),
            y: Axis::logarithmic(label),
            curves,
        })?;
    }
    Ok(())
}

/// Medians and quartiles, a bin per sample of the cameras.
fn binned(misses: &[Miss], value: impl Fn(&Miss) -> f64) -> Vec<Mark> {
    let width_s = 1.0 / RATES_HZ[0];
    let bins = (AHEAD_S / width_s).floor() as usize;
    (0..bins)
        .filter_map(|bin| {
            let within = bin as f64 * width_s..(bin + 1) as f64 * width_s;
            let own = misses.iter().filter(|miss| within.contains(&miss.after_s));
            let values: Vec<f64> = own.map(&value).collect();
            let middle_ms = 1e3 * (bin as f64 + 0.5) * width_s;
            (!values.is_empty()).then(|| Mark {
                spread: Some([quantile(&values, 0.25), quantile(&values, 0.75)]),
                ..Mark::at(middle_ms, median(&values))
            })
        })
        .collect()
}
