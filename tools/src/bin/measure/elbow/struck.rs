//! Real tosses of two boxes joined by a hinge through their first impact: with the law of the impact given, and free.

use anyhow::Result;
use enact::motion::{Estimate, TrackIndex, Verdict};
use enact_tools::elbow::{self, FirstImpact, ReadLaw, Reads};
use serde::Serialize;

use super::{finished, greatest, middle_half};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{largest, median};
use crate::table::{Table, number, share};

/// Where restitution and friction begin, or what they are said to be.
const LAW: [f64; 2] = [0.5, 0.3];
/// Heights of the table among which that with the lowest objective is looked for \[mm\].
const HEIGHTS_MM: std::ops::RangeInclusive<i32> = -15..=15;

/// One toss.
#[derive(Serialize)]
struct Hit {
    toss: String,
    readings: usize,
    after: usize,
    verdict: String,
    is_motion: bool,
    is_physical: bool,
    doubts: Vec<String>,
    /// Root mean square distance of the box that is farther from its readings, before the impact and after it \[mm\].
    off_mm: Option<[f64; 2]>,
    off_deg: Option<f64>,
    restitution: Option<f64>,
    restitution_sd: Option<f64>,
    friction: Option<f64>,
    table_mm: f64,
}

impl Hit {
    fn of(toss: String, of: &FirstImpact, reads: &Reads, law: &ReadLaw) -> (Self, f64) {
        let (scene, events) = elbow::take_struck(of, reads, law);
        let estimate = finished(scene.clone(), &events);
        let is_motion = estimate.verdict != Verdict::Failed;
        let free = |name: &str| {
            let mut all = estimate.parameters.iter();
            all.find(|of| of.name == name && is_motion)
        };
        let hit = Self {
            toss,
            readings: of.readings.len(),
            after: of.readings.len() - of.lowest,
            verdict: format!("{:?}", estimate.verdict).to_lowercase(),
            is_motion,
            is_physical: estimate.verdict == Verdict::Physical,
            doubts: estimate
                .doubts
                .iter()
                .map(|of| of.about.as_str().to_owned())
                .collect(),
            off_mm: is_motion.then(|| off_mm(of, &scene, &estimate)).flatten(),
            off_deg: greatest(&estimate, |of| of.orientation_rms_rad.map(f64::to_degrees))
                .filter(|_| is_motion),
            restitution: free("hit.restitution").map(|of| of.value),
            restitution_sd: free("hit.restitution").and_then(|of| of.sd),
            friction: free("hit.friction").map(|of| of.value),
            table_mm: 1e3 * law.table_m,
        };
        let objective = match is_motion {
            true => estimate.objective,
            false => f64::INFINITY,
        };
        (hit, objective)
    }

    /// With the table where the objective is lowest.
    fn where_it_fits(toss: &str, of: &FirstImpact, reads: &Reads, law: &ReadLaw) -> Self {
        let heights = HEIGHTS_MM.step_by(3).map(|height_mm| {
            let law = ReadLaw {
                table_m: 1e-3 * f64::from(height_mm),
                ..*law
            };
            Self::of(toss.to_owned(), of, reads, &law)
        });
        let best = heights.min_by(|a, b| a.1.total_cmp(&b.1));
        best.expect("a height").0
    }
}

/// Root mean square distances of the farther box, before the impact and after it \[mm\].
fn off_mm(of: &FirstImpact, scene: &enact::motion::Scene, estimate: &Estimate) -> Option<[f64; 2]> {
    let motion = estimate.trees.first()?;
    let (_, joined) = scene.joint_trees().next()?;
    let tree = scene.tree_model(joined);
    let gravity_m_s2 = &estimate.gravity_m_s2;
    let mut snapshot = enact::physics::tree::Snapshot::new(&tree, gravity_m_s2);
    let hit_s = estimate.events.get(1)?.time_s;
    let begin_s = of.readings[0].time_s;
    let mut squares_mm2 = [[0.0; 2]; 2];
    let mut counts = [0.0; 2];
    for reading in &of.readings {
        let time_s = reading.time_s - begin_s;
        let side = usize::from(time_s >= hit_s);
        snapshot.set(&motion.state(&tree, gravity_m_s2, time_s));
        counts[side] += 1.0;
        for (track, pose) in [reading.first, reading.second()].iter().enumerate() {
            let place = joined.place_of(scene.tracks.get(TrackIndex(track))?.link)?;
            let off_m = snapshot.link_state(place).position_m - pose.translation.vector;
            squares_mm2[side][track] += 1e6 * off_m.norm_squared();
        }
    }
    let side = |of: usize| {
        let [first, second] = squares_mm2[of];
        (first.max(second) / counts[of]).sqrt()
    };
    Some([side(0), side(1)])
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let header = [
        "read as",
        "tosses",
        "motions",
        "physical",
        "off before, mm",
        "off after, mm",
        "most, mm",
        "off, degrees",
        "restitution",
        "middle half",
        "its deviation",
        "friction",
    ];
    let mut table = Table::new("elbow_struck", "", &header);
    let mut numbers = Vec::new();
    // Every other toss, from the first: what tells that one corner alone is near was chosen on the others.
    let files = elbow::files().into_iter().step_by(2);
    let hits = files.filter_map(|file| {
        let toss = file.file_stem().unwrap_or_default().to_string_lossy();
        Some((toss.into_owned(), elbow::first_impact(&file)?))
    });
    let mut hits: Vec<(String, FirstImpact)> = hits.collect();
    if options.quick {
        hits.truncate(2);
    }
    if hits.is_empty() {
        return Ok(());
    }
    let reads = Reads {
        sees_both: true,
        moment_kg_m2: None,
        hinge_off_m: 0.0,
    };
    let given = ReadLaw {
        law: LAW,
        is_free: false,
        table_m: 0.0,
    };
    let free = ReadLaw {
        is_free: true,
        ..given
    };
    for (name, law, is_searched) in [
        ("restitution 0.5, friction 0.3", given, false),
        ("both free", free, false),
        ("both free, the table where it fits best", free, true),
    ] {
        let all = hits.iter().map(|(toss, of)| match is_searched {
            true => Hit::where_it_fits(toss, of, &reads, &law),
            false => Hit::of(toss.clone(), of, &reads, &law).0,
        });
        let all: Vec<Hit> = all.collect();
        let of = |of: &dyn Fn(&Hit) -> Option<f64>| all.iter().filter_map(of).collect::<Vec<f64>>();
        let restitutions = of(&|one| one.restitution);
        table.row([
            name.to_owned(),
            all.len().to_string(),
            share(&all, |one| one.is_motion),
            share(&all, |one| one.is_physical),
            number(median(&of(&|one| one.off_mm.map(|off| off[0])))),
            number(median(&of(&|one| one.off_mm.map(|off| off[1])))),
            number(largest(&of(&|one| {
                one.off_mm.map(|off| off[0].max(off[1]))
            }))),
            number(median(&of(&|one| one.off_deg))),
            number(median(&restitutions)),
            middle_half(&restitutions),
            number(median(&of(&|one| one.restitution_sd))),
            number(median(&of(&|one| one.friction))),
        ]);
        eprintln!("  first impact, {name}");
        numbers.push((name, all));
    }
    record.table(table);
    record.numbers("elbow_struck", &numbers)
}
