//! Whole tosses, from the hand to the rest: phases as they are proposed, estimated, and compared with every sample.

use anyhow::{Context, Result};
use enact::config::scene_from_toml;
use enact::motion::{Fits, LinkIndex, Mark, Scene, TakeEvent, Verdict};
use enact::pipeline::{Outcome, Pipeline};
use enact::sampling::MovedBody;
use enact::service::proposed_phases;
use enact_tools::tosses::{RATES_HZ, Toss, scene_toml};

use super::bounce::Setting;
use super::contacts::contacts;
use crate::record::Record;
use crate::statistics::{median, quantile};
use crate::table::Table;

/// As the cameras ran \[Hz\].
const RATE_HZ: f64 = RATES_HZ[0];
/// A whole motion is explained within these, rms over all samples \[m\], \[rad\].
const WITHIN_M: f64 = 0.001;
const WITHIN_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// A second corner touches soon after so many samples at most.
const SOON: f64 = 2.0;
/// The setting of the impacts that leaves the least.
const MOMENT_KG_M2: f64 = 8.1e-4;
const RADIUS_M: f64 = 0.005;
/// What scenes may be inaccurate: by default, and as deep as corners are seen below the table \[mm\].
const TOLERANCES_MM: [Option<f64>; 2] = [None, Some(3.0)];

/// A toss with its answer.
struct Whole {
    outcome: Outcome,
    /// Distance of the motion from all samples, rms \[m\], \[rad\].
    off: [f64; 2],
    /// Whether a second corner touches soon after the first.
    is_double: bool,
    /// How long it tumbles, and all of it \[s\].
    tumbles_s: f64,
    lasts_s: f64,
}

/// Tries all tosses.
pub fn run(tosses: &[Toss], record: &mut Record) -> Result<()> {
    let header = [
        "tolerance",
        "tosses",
        "estimated",
        "within 1 mm and 2° of all samples",
        "of these physical",
        "of these nothing against, fits",
        "not within: doubted or said not to fit",
        "of these a second corner within two samples of the first",
        "not within and not said: that too, furthest off mm, deg",
        "within: that too",
        "position off mm, quartiles",
        "turned off deg, quartiles",
        "tumbles s, quartiles",
        "share of the time, median",
    ];
    let mut table = Table::new("whole", "", &header);
    let setting = Setting::new(MOMENT_KG_M2, RADIUS_M)?;
    for tolerance_mm in TOLERANCES_MM {
        let each = tosses.iter();
        let each = each.map(|toss| whole(toss, &setting, tolerance_mm));
        let each: Vec<Option<Whole>> = each.collect::<Result<_>>()?;
        table.row(row(tolerance_mm, &each));
    }
    record.table(table);
    Ok(())
}

/// The scene of a toss through its first impact, before anything is proposed.
fn first_toml(tolerance_mm: Option<f64>) -> Result<String> {
    let flight = scene_toml();
    let sharp = "kind = \"cuboid\", size_mm = [104.8, 104.8, 104.8]";
    let round = "kind = \"rounded_cuboid\", size_mm = [104.8, 104.8, 104.8], radius_mm = 5";
    let end = flight.find("[[event]]").context("events")?;
    let head = flight[..end].replace(sharp, round);
    // The cube rests 1.15 mm lower than its size has it.
    let head = head.replace("point_mm = [0, 0, 0]", "point_mm = [0, 0, -1.15]");
    let tolerance = tolerance_mm.map_or(String::new(), |mm| format!("tolerance_mm = {mm}\n"));
    let whole = "hand = \"none\"\ngravity_m_s2 = [0, 0, -9.648]\n";
    let events = "[[event]]\nname = \"impact\"\nkind = \"collision\"\nbody = \"cube\"\nsurface = \"table\"\n\
                  restitution = 0.25\nfriction = 0.18\n\n[[event]]\nname = \"end\"\nkind = \"end\"\n\n\
                  [[free]]\nquantity = \"impact.restitution\"\n\n[[free]]\nquantity = \"impact.friction\"\n";
    Ok(format!("{whole}{tolerance}{head}{events}"))
}

/// Whether two corners touch within some samples.
fn is_double(toss: &Toss, setting: &Setting) -> bool {
    let poses = toss.poses.iter();
    let heights_m: Vec<Vec<f64>> = poses.map(|pose| setting.heights_m(pose)).collect();
    let places = contacts(&heights_m);
    places.len() > 1 && places[1].place - places[0].place <= SOON
}

/// What is made of a toss with what is proposed of it; `None` where there is no motion.
fn whole(toss: &Toss, setting: &Setting, tolerance_mm: Option<f64>) -> Result<Option<Whole>> {
    let text = first_toml(tolerance_mm)?;
    let take = toss.take(RATE_HZ, toss.poses.len(), &[]);
    let first = scene_from_toml(&text)?;
    let marks = marks(&first, &take)?;
    let seen = Pipeline::of(first.clone(), take.clone()).seen()?;
    let proposed = proposed_phases(&first, &text, &seen, &marks);
    let scene = scene_from_toml(&proposed.scene_toml.unwrap_or(text))?;
    let mut events = take.clone();
    events.extend(self::marks(&scene, &take)?.into_iter().map(TakeEvent::Mark));
    let Ok(outcome) = Pipeline::of(scene, events).finish(&mut ()) else {
        return Ok(None);
    };
    let estimate = &outcome.estimate;
    if estimate.verdict == Verdict::Failed {
        return Ok(None);
    }
    let spans_s = estimate.grips.iter().map(|of| of.span_s[1] - of.span_s[0]);
    Ok(Some(Whole {
        off: off(toss, &outcome),
        is_double: is_double(toss, setting),
        tumbles_s: spans_s.sum(),
        lasts_s: (toss.poses.len() - 1) as f64 / RATE_HZ,
        outcome,
    }))
}

/// The marks that are proposed for a scene.
fn marks(scene: &Scene, take: &[TakeEvent]) -> Result<Vec<Mark>> {
    let proposals = Pipeline::of(scene.clone(), take.to_vec()).propose(None)?;
    let marks = proposals.into_iter().map(|of| Mark {
        stamp: of.stamp,
        event: of.event,
    });
    Ok(marks.collect())
}

/// Distance of a motion from all samples of a toss between its start and its end, rms \[m\], \[rad\].
fn off(toss: &Toss, outcome: &Outcome) -> [f64; 2] {
    let moved = MovedBody::new(&outcome.scene, &outcome.estimate, LinkIndex(0));
    let Some((moved, [from_s, until_s])) =
        moved.and_then(|of| of.span_s().map(|span_s| (of, span_s)))
    else {
        return [f64::INFINITY; 2];
    };
    let timed = toss.poses.iter().enumerate();
    let timed = timed.map(|(index, pose)| (index as f64 / RATE_HZ, pose));
    let timed: Vec<_> = timed
        .filter(|(time_s, _)| (from_s..=until_s).contains(time_s))
        .collect();
    let times_s: Vec<f64> = timed.iter().map(|(time_s, _)| *time_s).collect();
    let mut squares = [0.0; 2];
    for (state, (_, (position_m, q))) in moved.states(&times_s).iter().zip(&timed) {
        squares[0] += (state.position_m - position_m).norm_squared();
        squares[1] += state.orientation.angle_to(q).powi(2);
    }
    squares.map(|of| (of / timed.len() as f64).sqrt())
}

fn row(tolerance_mm: Option<f64>, each: &[Option<Whole>]) -> Vec<String> {
    let told: Vec<&Whole> = each.iter().flatten().collect();
    let is_within = |of: &Whole| of.off[0] <= WITHIN_M && of.off[1] <= WITHIN_RAD;
    let is_physical = |of: &Whole| of.outcome.estimate.verdict == Verdict::Physical;
    let fits = |of: &Whole| of.outcome.estimate.fits() == Fits::Yes;
    let count = |is_it: &dyn Fn(&Whole) -> bool| told.iter().filter(|of| is_it(of)).count();
    let beyond = count(&|of| !is_within(of));
    let is_said = |of: &Whole| !(is_within(of) || is_physical(of) && fits(of));
    let said = count(&is_said);
    let is_silent = |of: &Whole| !is_within(of) && is_physical(of) && fits(of);
    let furthest = |kind: usize| {
        let silent = told.iter().filter(|of| is_silent(of));
        silent.map(|of| of.off[kind]).fold(0.0, f64::max)
    };
    let quartiles = |value: &dyn Fn(&Whole) -> f64, decimals: usize| {
        let mut all: Vec<f64> = told.iter().map(|of| value(of)).collect();
        all.sort_by(f64::total_cmp);
        let [low, middle, high] = [0.25, 0.5, 0.75].map(|share| quantile(&all, share));
        format!("{low:.decimals$}, {middle:.decimals$}, {high:.decimals$}")
    };
    let shares: Vec<f64> = told.iter().map(|of| of.tumbles_s / of.lasts_s).collect();
    vec![
        tolerance_mm.map_or("by default".to_owned(), |mm| format!("{mm} mm")),
        each.len().to_string(),
        told.len().to_string(),
        count(&|of| is_within(of)).to_string(),
        count(&|of| is_within(of) && is_physical(of)).to_string(),
        count(&|of| is_within(of) && is_physical(of) && fits(of)).to_string(),
        format!("{said} of {beyond}"),
        count(&|of| is_said(of) && of.is_double).to_string(),
        format!(
            "{} of {}, {:.2}, {:.2}",
            count(&|of| is_silent(of) && of.is_double),
            beyond - said,
            1e3 * furthest(0),
            furthest(1).to_degrees()
        ),
        count(&|of| is_within(of) && of.is_double).to_string(),
        quartiles(&|of| 1e3 * of.off[0], 2),
        quartiles(&|of| of.off[1].to_degrees(), 2),
        quartiles(&|of| of.tumbles_s, 3),
        format!("{:.0} %", 100.0 * median(&shares)),
    ]
}
