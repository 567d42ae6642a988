//! Tables of how far peers and the program are apart.

use super::draw::JOINTS;
use super::judge::Apart;
use super::{ARTICULATED, Judged, LINKS, MUJOCO, PINOCCHIO, SIZES_M};
use crate::record::Record;
use crate::statistics::{largest, median};
use crate::table::{Table, number, share};

fn greatest<'a>(all: impl Iterator<Item = &'a Judged>, of: impl Fn(&Judged) -> f64) -> f64 {
    all.map(of).fold(0.0, f64::max)
}

/// Tables and a sentence.
pub fn show(judged: &[Judged], record: &mut Record) {
    let header = [
        "mechanisms",
        "number",
        "condition of M, up to",
        "u̇: Pinocchio",
        "MuJoCo",
        "∂u̇/∂q: Pinocchio",
        "its articulated",
        "MuJoCo's differences",
        "∂u̇/∂u: Pinocchio",
        "its articulated",
        "MuJoCo's differences",
        "energy",
    ];
    let mut agree = Table::new("agree", "", &header);
    for (name, is_of) in groups() {
        let own = || judged.iter().filter(|one| is_of(one));
        let mut cells = vec![
            name,
            own().count().to_string(),
            format!("{:.0e}", greatest(own(), |one| one.condition)),
        ];
        let mut add = |part: fn(&Apart) -> f64, peer: usize| {
            cells.push(format!(
                "{:.0e}",
                greatest(own(), |one| part(&one.apart[peer]))
            ));
        };
        for peer in [PINOCCHIO, MUJOCO] {
            add(|apart| apart.accelerations, peer);
        }
        for peer in [PINOCCHIO, ARTICULATED, MUJOCO] {
            add(|apart| apart.by_coordinates, peer);
        }
        for peer in [PINOCCHIO, ARTICULATED, MUJOCO] {
            add(|apart| apart.by_rates, peer);
        }
        let energy = |one: &Judged| one.apart[PINOCCHIO].energy.max(one.apart[MUJOCO].energy);
        cells.push(format!("{:.0e}", greatest(own(), energy)));
        agree.row(cells);
    }
    let worst = |of: fn(&Apart) -> f64, peer: usize| {
        let all = judged.iter();
        format!("{:.0e}", greatest(all, |one| of(&one.apart[peer])))
    };
    record.say(format!(
        "In {} random trees of 2 to 8 links, 1 mm to 10 m, accelerations are within {} of Pinocchio's and {} of MuJoCo's, \
         their derivatives by coordinates within {} and by rates within {} of Pinocchio's analytic ones, relative to the greatest.",
        judged.len(),
        worst(|apart| apart.accelerations, PINOCCHIO),
        worst(|apart| apart.accelerations, MUJOCO),
        worst(|apart| apart.by_coordinates, PINOCCHIO),
        worst(|apart| apart.by_rates, PINOCCHIO),
    ));
    record.table(agree);
    record.table(flights(judged));
}

fn flights(judged: &[Judged]) -> Table {
    let header = [
        "flights",
        "number",
        "a rounding of the start: median",
        "greatest",
        "half the steps: median",
        "Pinocchio: median",
        "MuJoCo: median",
        "half the steps over the rounding: median",
        "Pinocchio over it: median",
        "MuJoCo over it: median",
        "Pinocchio within 1e-8",
        "MuJoCo within 1e-8",
    ];
    let mut table = Table::new("flights", "", &header);
    for (name, is_of) in groups() {
        let is_flown = |one: &&Judged| is_of(one) && one.flight_s.is_some();
        let own: Vec<&Judged> = judged.iter().filter(is_flown).collect();
        let all = |of: &dyn Fn(&Judged) -> Option<f64>| -> Vec<f64> {
            own.iter().map(|one| of(one).unwrap_or(f64::NAN)).collect()
        };
        let rounding = all(&|one| one.end_by_rounding);
        let ends = [
            all(&|one| one.end_in_half),
            all(&|one| one.apart[PINOCCHIO].end),
            all(&|one| one.apart[MUJOCO].end),
        ];
        let mut cells = vec![
            name,
            own.len().to_string(),
            format!("{:.0e}", median(&rounding)),
            format!("{:.0e}", largest(&rounding)),
        ];
        cells.extend(ends.iter().map(|ends| format!("{:.0e}", median(ends))));
        for ends in &ends {
            let over: Vec<f64> = ends.iter().zip(&rounding).map(|(a, b)| a / b).collect();
            cells.push(number(median(&over)));
        }
        cells.extend(ends[1..].iter().map(|ends| share(ends, |end| *end < 1e-8)));
        table.row(cells);
    }
    table
}

type Group = (String, Box<dyn Fn(&Judged) -> bool>);

/// All, then by base and joints, by number of links, by size.
fn groups() -> Vec<Group> {
    let mut groups: Vec<Group> = vec![("all".to_owned(), Box::new(|_| true))];
    for is_free in [false, true] {
        for joints in JOINTS {
            let joints = format!("{joints:?}").to_lowercase();
            let base = if is_free { "free" } else { "clamped" };
            let name = format!("{base}, {joints}");
            groups.push((
                name,
                Box::new(move |one| one.is_free == is_free && one.joints == joints),
            ));
        }
    }
    for links in LINKS {
        groups.push((
            format!("{links} links"),
            Box::new(move |one| one.links == links),
        ));
    }
    for size_m in SIZES_M {
        groups.push((
            format!("links of {size_m} m"),
            Box::new(move |one| one.size_m == size_m),
        ));
    }
    groups
}
