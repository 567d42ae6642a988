//! The first impacts, and what is predicted of the time after them.

use anyhow::Result;

use super::bounce::{AHEAD_S, Bounce, Miss, Setting};
use crate::figure::{Axis, Curve, Figure, Mark};
use crate::record::Record;
use crate::statistics::{INTERVALS, median, quantile, robust_sd};
use crate::table::Table;
use enact_tools::tosses::{RATES_HZ, Toss};

/// Documented, measured by others, and what impulses fit [kg m²].
const MOMENTS_KG_M2: [f64; 3] = [6.2e-4, 8.1e-4, 1.1e-3];
/// Radii that a corner may have \[m\].
const RADII_M: [f64; 5] = [0.0, 0.003, 0.005, 0.006, 0.007];
/// Friction that sticks is not determined: an interval wider than this is none.
const WIDE: f64 = 1.0;
/// Documented restitution and friction.
const DOCUMENTED: (f64, f64) = (0.125, 0.165);

/// A toss's impact, or why it has no estimate.
type Tried = Result<Bounce, String>;

/// The moment and the radius are not known well; those that leave the least are charted.
pub fn run(tosses: &[Toss], quick: bool, record: &mut Record) -> Result<()> {
    let header = [
        "moment of inertia, kg m²",
        "corners rounded by",
        "tosses",
        "estimated",
        "through further impacts",
        "restitution, median (robust sd)",
        "its reported sd, median",
        "friction, median (robust sd)",
        "its reported sd, median",
        "residual before the impact, median",
        "residual after it, median",
    ];
    let mut table = Table::new("bounces", "", &header);
    let mut best: Option<(f64, Setting, Vec<Tried>)> = None;
    let moments_kg_m2 = if quick {
        &MOMENTS_KG_M2[1..2]
    } else {
        &MOMENTS_KG_M2[..]
    };
    for moment_kg_m2 in moments_kg_m2 {
        for radius_m in RADII_M {
            let setting = Setting::new(*moment_kg_m2, radius_m)?;
            let bounces: Vec<Tried> = tosses.iter().map(|toss| setting.bounce(toss)).collect();
            table.row(row(&setting, &bounces));
            let left = residual(&bounces);
            if best.as_ref().is_none_or(|(least, ..)| left < *least) {
                best = Some((left, setting, bounces));
            }
        }
    }
    record.table(table);
    if let Some((_, setting, bounces)) = best {
        record.table(failures(tosses, &bounces));
        record.figure(sorted("restitution", &setting, &bounces, |b| b.restitution));
        record.figure(sorted("friction", &setting, &bounces, |b| b.friction));
        predictions(record, &setting, tosses, &bounces);
    }
    Ok(())
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
    let good: Vec<&Bounce> = bounces.iter().flatten().collect();
    let of = |value: &dyn Fn(&Bounce) -> f64| -> Vec<f64> {
        good.iter().map(|bounce| value(bounce)).collect()
    };
    let spread = |value: &dyn Fn(&Bounce) -> f64| {
        let values = of(value);
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
    let through = good.iter().filter(|bounce| bounce.impacts > 1).count();
    let left = |value: &dyn Fn(&Bounce) -> (f64, f64)| {
        let [position_mm, orientation_deg] = [
            median(&of(&|bounce| value(bounce).0)),
            median(&of(&|bounce| value(bounce).1)),
        ];
        format!("{position_mm:.3} mm, {orientation_deg:.3}°")
    };
    vec![
        format!("{:e}", setting.moment_kg_m2()),
        format!("{} mm", 1e3 * setting.radius_m),
        bounces.len().to_string(),
        good.len().to_string(),
        through.to_string(),
        spread(&|bounce| bounce.restitution.0),
        sd(&|bounce| bounce.restitution.1),
        spread(&|bounce| bounce.friction.0),
        sd(&|bounce| bounce.friction.1),
        left(&|bounce| bounce.before),
        left(&|bounce| bounce.residual),
    ]
}

fn failures(tosses: &[Toss], bounces: &[Tried]) -> Table {
    let title = "Tosses whose first impact has no estimate, with the moment and the radius that leave the least";
    let mut table = Table::new("impact_failures", title, &["toss", "why"]);
    for (toss, bounce) in tosses.iter().zip(bounces) {
        if let Err(reason) = bounce {
            table.row([toss.number.to_string(), reason.clone()]);
        }
    }
    table
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
    let width = INTERVALS[2].1;
    let marks = values.iter().enumerate().map(|(rank, (value, sd))| {
        let sd = sd.filter(|sd| width * sd < WIDE);
        Mark {
            spread: sd.map(|sd| [value - width * sd, value + width * sd]),
            failed: sd.is_none(),
            ..Mark::at((rank + 1) as f64, *value)
        }
    });
    let ends = vec![Mark::at(1.0, middle), Mark::at(values.len() as f64, middle)];
    Figure {
        name: format!("tosses_{quantity}"),
        title: format!(
            "The first impact's {quantity} in real tosses, with the reported 95 % intervals"
        ),
        note: format!(
            "Sorted; {} of {} tosses. Moment of inertia \
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
    let others = others.filter_map(|(_, bounce)| bounce.as_ref().ok());
    let laws = others.map(|bounce| (bounce.restitution.0, bounce.friction.0));
    let (restitution, friction): (Vec<f64>, Vec<f64>) = laws.unzip();
    (
        median(&restitution).clamp(0.0, 1.0),
        median(&friction).max(0.0),
    )
}

/// A law for each toss, if any.
type Laws<'a> = (&'static str, Box<dyn Fn(usize) -> Option<(f64, f64)> + 'a>);

fn predictions(record: &mut Record, setting: &Setting, tosses: &[Toss], bounces: &[Tried]) {
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
    let (mut position, mut orientation) = (Vec::new(), Vec::new());
    let mut refused = 0;
    for (index, (name, law)) in laws.iter().enumerate() {
        let mut misses: Vec<Miss> = Vec::new();
        for (toss_index, toss) in tosses.iter().enumerate() {
            match setting.misses(toss, law(toss_index)) {
                Ok(of_toss) => misses.extend(of_toss),
                Err(_) => refused += usize::from(index == 0),
            }
        }
        let make = |marks| match index {
            0 => Curve::ours(*name, marks),
            _ => Curve::new(*name, marks),
        };
        position.push(make(binned(&misses, |miss| miss.position_mm)));
        orientation.push(make(binned(&misses, |miss| miss.orientation_deg)));
    }
    for (what, label, curves) in [
        ("position", "error of the centre [mm]", position),
        ("orientation", "error of the orientation [°]", orientation),
    ] {
        record.figure(Figure {
            name: format!("tosses_prediction_{what}"),
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
        });
    }
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
