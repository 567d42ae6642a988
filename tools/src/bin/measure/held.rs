//! Bodies in the hand: how often the intervals of their states at collisions hold the truth, and what a
//! motion that bounces off them is worth.

use anyhow::Result;
use enact::math::{Pose, so3};
use enact::motion::{Fits, Held, Sample, Stamp, TrackSketch, Verdict};
use enact::physics::flow;
use enact::pipeline::Pipeline;
use enact::segment::smooth::smoothed;
use enact_tools::perform::held::{Game, HeldTake, Seen, Swing, play};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde::Serialize;

use crate::options::Options;
use crate::record::Record;
use crate::statistics::{median, quantile, rms};
use crate::table::{Table, number, percent};

/// Swings of each row, and games of each.
const SWINGS: u64 = 100;
const GAMES: u64 = 60;
/// How long a swing is seen \[s\].
const SEEN_S: f64 = 2.0;
/// Half widths of the intervals, in standard deviations.
const WIDTHS: [f64; 2] = [1.0, 1.96];

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    swings(options, record)?;
    games(options, record)
}

/// Errors of one state, part by part, in SI units and in standard deviations.
#[derive(Clone, Copy, Serialize)]
struct Off {
    errors: [[f64; 3]; 4],
    deviations: [[f64; 3]; 4],
}

fn swings(options: &Options, record: &mut Record) -> Result<()> {
    let mut table = Table::new(
        "swings",
        "States of a held body at a collision: truth within 68 % and 95 % intervals, and rms error per axis",
        &[
            "swing", "speed", "rate", "noise", "position", "", "mm", "turn", "", "°", "velocity",
            "", "m/s", "spin", "", "rad/s",
        ],
    );
    let rows = [
        (1.0, 30.0, [1e-3, 5e-3]),
        (1.0, 120.0, [0.05e-3, 0.5e-3]),
        (1.0, 120.0, [1e-3, 5e-3]),
        (1.0, 120.0, [5e-3, 2e-2]),
        (1.0, 960.0, [1e-3, 5e-3]),
        (4.0, 60.0, [1e-3, 5e-3]),
        (4.0, 120.0, [1e-3, 5e-3]),
        (4.0, 240.0, [0.2e-3, 1e-3]),
        (4.0, 960.0, [5e-3, 2e-2]),
        (15.0, 120.0, [1e-3, 5e-3]),
        (15.0, 240.0, [0.2e-3, 1e-3]),
        (15.0, 960.0, [0.2e-3, 1e-3]),
    ];
    let mut all: Vec<Off> = Vec::new();
    for is_stroke in [false, true] {
        for (speed_m_s, rate_hz, sd) in rows {
            let name = if is_stroke { "stroke" } else { "to and fro" };
            let what = format!("{name} {speed_m_s} m/s {rate_hz} Hz {} mm", 1e3 * sd[0]);
            if !options.wants(&what) {
                continue;
            }
            let seeds = options.seeds(SWINGS);
            let offs: Vec<Off> = seeds
                .map(|seed| swung(is_stroke, speed_m_s, rate_hz, sd, seed))
                .collect();
            let mut cells = vec![
                name.to_owned(),
                format!("{speed_m_s} m/s"),
                format!("{rate_hz} Hz"),
                format!("{} mm, {:.2}°", 1e3 * sd[0], sd[1].to_degrees()),
            ];
            for (part, unit) in [1e3, 1.0_f64.to_degrees(), 1.0, 1.0]
                .into_iter()
                .enumerate()
            {
                cells.extend(WIDTHS.map(|width| held_share(&offs, part, width)));
                let errors: Vec<f64> = offs.iter().flat_map(|off| off.errors[part]).collect();
                cells.push(number(unit * rms(&errors)));
            }
            table.row(cells);
            record.numbers(&what, &offs)?;
            all.extend(offs);
        }
    }
    record.table(table);
    let of_all = |width: f64| {
        let shares = (0..4).map(|part| held_share(&all, part, width));
        shares.collect::<Vec<_>>().join(", ")
    };
    record.say(format!(
        "Over all swings the truth is within 68 % intervals in {} of positions, turns, velocities and spins, within 95 % intervals in {}.",
        of_all(WIDTHS[0]),
        of_all(WIDTHS[1]),
    ));
    Ok(())
}

/// Share of axes within so many standard deviations.
fn held_share(offs: &[Off], part: usize, width: f64) -> String {
    let deviations = offs.iter().flat_map(|off| off.deviations[part]);
    let within = deviations.filter(|deviation| deviation.abs() <= width);
    percent(within.count(), 3 * offs.len())
}

/// One swing, seen and smoothed.
fn swung(is_stroke: bool, speed_m_s: f64, rate_hz: f64, sd: [f64; 2], seed: u64) -> Off {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let hit_s = random.random_range(0.9..1.1);
    let swing = if is_stroke {
        let lasts_s = 1.5 / speed_m_s;
        let halfway_s = hit_s + lasts_s * random.random_range(-0.17..0.17);
        Swing::stroke(speed_m_s, halfway_s, &mut random)
    } else {
        Swing::to_and_fro(speed_m_s, &mut random)
    };
    let mut noise = |sd: f64| {
        Vector3::from_fn(|_, _| {
            let one: f64 = random.sample(StandardNormal);
            sd * one
        })
    };
    let samples = (0..(SEEN_S * rate_hz) as usize).map(|k| {
        let acted_s = k as f64 / rate_hz;
        let state = swing.state(acted_s);
        Sample::of_pose(
            Stamp((acted_s * 1e9) as i64),
            acted_s,
            state.position_m + noise(sd[0]),
            state.orientation * so3::exp(&noise(sd[1])),
        )
    });
    let track = TrackSketch::new(samples.collect());
    let motion = smoothed(
        &track.samples,
        1.0 / rate_hz,
        &Pose::identity(),
        &Held::default(),
        &[(0, hit_s)],
    );
    let off = motion.at(hit_s).state.minus(&swing.state(hit_s));
    let covariance = &motion.meetings[0].covariance;
    let by_part = |of: &dyn Fn(usize) -> f64| [0, 3, 6, 9].map(|at| [at, at + 1, at + 2].map(of));
    Off {
        errors: by_part(&|row| off[row]),
        deviations: by_part(&|row| off[row] / covariance[(row, row)].sqrt()),
    }
}

/// One game through the program.
#[derive(Serialize)]
struct Played {
    seed: u64,
    verdict: &'static str,
    fits: &'static str,
    /// Whether what touches is what touched.
    is_right: bool,
    /// Errors of the times of hits \[s\], and in standard deviations.
    times_s: Vec<f64>,
    deviations: Vec<f64>,
    /// Error of the restitution where it is free, and in standard deviations.
    restitution: Option<[f64; 2]>,
    /// Errors of velocities after hits, of their places there, and of the hand's velocities at them.
    velocities_m_s: Vec<f64>,
    places_m: Vec<f64>,
    hands_m_s: Vec<f64>,
}

fn games(options: &Options, record: &mut Record) -> Result<()> {
    let mut table = Table::new(
        "games",
        "Through the program: a ball on a racket three times, a box and a paddle, a die on a moving ramp",
        &[
            "game",
            "hand",
            "rate",
            "noise",
            "played",
            "physical",
            "does not fit",
            "right contact",
            "hits within 68 %",
            "95 %",
            "rms",
            "restitution within 68 %",
            "95 %",
            "rms",
            "velocity after, median",
            "95 %",
            "hand's velocity, rms",
        ],
    );
    let ways = [
        (1.5, 120.0, [1e-3, 3e-3]),
        (1.5, 30.0, [1e-3, 3e-3]),
        (1.5, 240.0, [0.1e-3, 0.5e-3]),
        (3.0, 120.0, [1e-3, 3e-3]),
    ];
    for game in Game::ALL {
        for (speed_m_s, rate_hz, sd) in ways {
            let name = game.as_str();
            let what = format!("{name} {speed_m_s} m/s {rate_hz} Hz {} mm", 1e3 * sd[0]);
            if !options.wants(&what) {
                continue;
            }
            let seen = Seen {
                rate_hz,
                position_sd_m: sd[0],
                orientation_sd_rad: sd[1],
                speed_m_s,
                ..Seen::default()
            };
            let seeds = options.seeds(GAMES);
            let played = seeds.filter_map(|seed| Some((seed, play(game, &seen, seed)?)));
            let played: Vec<Played> = played.map(|(seed, take)| judged(seed, &take)).collect();
            row(&mut table, (game, &seen), &played);
            record.numbers(&what, &played)?;
        }
    }
    record.table(table);
    Ok(())
}

fn row(table: &mut Table, (game, seen): (Game, &Seen), played: &[Played]) {
    let count = |is: &dyn Fn(&Played) -> bool| played.iter().filter(|one| is(one)).count();
    let all = |of: fn(&Played) -> &Vec<f64>| -> Vec<f64> {
        played.iter().flat_map(|one| of(one).clone()).collect()
    };
    let within = |values: &[f64], width: f64| {
        let inside = values.iter().filter(|value| value.abs() <= width);
        percent(inside.count(), values.len())
    };
    let of_restitution = |which: usize| -> Vec<f64> {
        let found = played.iter().filter_map(|one| one.restitution);
        found.map(|of| of[which]).collect()
    };
    let restitution = of_restitution(1);
    let of_law = |text: String| {
        if restitution.is_empty() {
            "–".into()
        } else {
            text
        }
    };
    let (deviations, velocities) = (all(|one| &one.deviations), all(|one| &one.velocities_m_s));
    table.row([
        game.as_str().to_owned(),
        format!("{} m/s", seen.speed_m_s),
        format!("{} Hz", seen.rate_hz),
        format!(
            "{} mm, {:.2}°",
            1e3 * seen.position_sd_m,
            seen.orientation_sd_rad.to_degrees()
        ),
        played.len().to_string(),
        percent(
            count(&|one| one.verdict == Verdict::Physical.as_str()),
            played.len(),
        ),
        count(&|one| one.fits == Fits::No.as_str()).to_string(),
        percent(count(&|one| one.is_right), played.len()),
        within(&deviations, WIDTHS[0]),
        within(&deviations, WIDTHS[1]),
        format!("{} ms", number(1e3 * rms(&all(|one| &one.times_s)))),
        of_law(within(&restitution, WIDTHS[0])),
        of_law(within(&restitution, WIDTHS[1])),
        of_law(number(rms(&of_restitution(0)))),
        format!("{} m/s", number(median(&velocities))),
        format!("{} m/s", number(quantile(&velocities, 0.95))),
        format!("{} m/s", number(rms(&all(|one| &one.hands_m_s)))),
    ]);
}

fn judged(seed: u64, take: &HeldTake) -> Played {
    let pipeline = Pipeline::of(take.scene.clone(), take.events.clone());
    let outcome = pipeline.finish(&mut ());
    let mut played = Played {
        seed,
        verdict: "refused",
        fits: "unknown",
        is_right: false,
        times_s: Vec::new(),
        deviations: Vec::new(),
        restitution: None,
        velocities_m_s: Vec::new(),
        places_m: Vec::new(),
        hands_m_s: Vec::new(),
    };
    let Ok(outcome) = outcome else { return played };
    let estimate = &outcome.estimate;
    played.verdict = estimate.verdict.as_str();
    played.fits = estimate.fits().as_str();
    if estimate.verdict == Verdict::Failed {
        return played;
    }
    let hits = take.touching.iter().enumerate();
    played.is_right = hits.clone().all(|(event, touching)| {
        let collision = outcome.scene.events[event].kind.collision();
        collision.is_some_and(|collision| collision.contacts == [*touching])
    });
    for (event, hit_s) in estimate.events.iter().zip(&take.hits_s) {
        let off_s = event.time_s - hit_s;
        played.times_s.push(off_s);
        played
            .deviations
            .push(event.sd_s.map_or(f64::INFINITY, |sd_s| off_s / sd_s));
    }
    played.restitution = estimate.parameters.first().map(|found| {
        let off = found.value
            - take
                .scene
                .contact_laws
                .first()
                .map_or(0.0, |law| law.restitution);
        [off, found.sd.map_or(f64::INFINITY, |sd| off / sd)]
    });
    for (hit, truth) in take.after.iter().enumerate() {
        // Flights of what flies are in order of time, the first before any hit.
        let Some(arc) = estimate.arcs.get(hit + 1) else {
            continue;
        };
        let body = outcome.scene.body_of(arc.mechanism);
        let since_s = take.hits_s[hit] - arc.epoch_s;
        let state = flow::advance(body, &estimate.gravity_m_s2, &arc.state, since_s);
        let off = state.minus(truth);
        played.places_m.push(off.fixed_rows::<3>(0).norm());
        played.velocities_m_s.push(off.fixed_rows::<3>(6).norm());
    }
    for passed in estimate.held.iter().flat_map(|held| &held.passed) {
        let off = passed.state.velocity_m_s - take.swing.state(passed.time_s).velocity_m_s;
        played.hands_m_s.push(off.norm());
    }
    played
}
