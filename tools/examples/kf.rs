use enact::motion::*;
use enact::pipeline::Pipeline;
use enact_tools::perform::*;
use rand::{RngExt, SeedableRng};

fn truth(scene: &str, seed: u64) -> Option<Truth> {
    let t = match scene {
        "tip" | "eraser" => {
            let style = if scene == "tip" {
                Style::Tip
            } else {
                Style::Eraser
            };
            let base = style.truth();
            let mut scene = base.scene.clone();
            scene.goals.clear();
            scene.settle_s = None;
            scene.obstacles = Default::default();
            let mut r = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
            let mut n = || 2.0 * r.random::<f64>() - 1.0;
            let mut state = base.arcs[0].state;
            for a in 0..3 {
                state.velocity_m_s[a] += 0.15 * n();
                state.angular_velocity_rad_s[a] += 1.0 * n();
            }
            let whole = simulate(&scene, &[], &[state], base.duration_s).ok()?;
            let bounce_s = whole.event_times_s[0];
            let low = |time_s: f64| {
                let s = whole.state(LinkIndex(0), time_s);
                let up = (s.orientation * nalgebra::Vector3::z()).z;
                s.position_m.z - 0.095 * up.abs()
            };
            let lasts_s = base.duration_s - bounce_s;
            let until = (30..=100)
                .map(|p| bounce_s + lasts_s * p as f64 / 100.0)
                .take_while(|t| low(*t) > 0.01)
                .last()?;
            simulate(&scene, &[], &[state], until).ok()?
        }
        "box1" => bounces(1, seed).ok()?,
        "box2" => bounces(2, seed).ok()?,
        "box4" => bounces(4, seed).ok()?,
        "die3" => thrown(Polyhedron::Cube, &Throw::DIE, 3, seed).ok()?,
        _ => panic!(),
    };
    Some(t)
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let seeds: u64 = args[0].parse().unwrap();
    let verbose = args.get(3).is_some();
    for timing in [Timing::Known, Timing::Edited] {
        if !format!("{timing:?}").starts_with(&args[1]) && args[1] != "all" {
            continue;
        }
        for scene in ["tip", "eraser", "box1", "box2", "box4", "die3"] {
            if args
                .get(2)
                .is_some_and(|s| s != "all" && !s.split(',').any(|t| t == scene))
            {
                continue;
            }
            for n in std::env::var("N").map_or(vec![1, 2, 3, 6], |n| vec![n.parse().unwrap()]) {
                let (mut total, mut exact, mut wrong, mut weak, mut open, mut failed, mut refused) =
                    (0, 0, 0, 0, 0, 0, 0);
                let mut why = String::new();
                let start = std::time::Instant::now();
                for seed in 7000..7000 + seeds {
                    let Some(mut t) = truth(scene, seed) else {
                        continue;
                    };
                    t.scene.timing = timing;
                    let events = Keyframing::exact(n).of(&t, seed);
                    total += 1;
                    match Pipeline::of(t.scene.clone(), events.clone()).finish(&mut ()) {
                        Err(e) => {
                            refused += 1;
                            why = e.to_string();
                            if verbose {
                                println!("{seed} {e}")
                            }
                        }
                        Ok(o) => {
                            let off = Off::of(&t, &events, &o.estimate);
                            let is = off.greatest() < 1e-9;
                            let v = o.estimate.verdict;
                            exact += u32::from(is);
                            if verbose {
                                println!(
                                    "{seed} {scene} {n} {v:?} rivals {} {off:?} obj {:.2e} undet {:?} doubts {:?} it {}",
                                    o.estimate.rivals,
                                    o.estimate.objective,
                                    o.estimate.undetermined,
                                    o.estimate
                                        .doubts
                                        .iter()
                                        .map(|d| (d.about.as_str(), d.value))
                                        .collect::<Vec<_>>(),
                                    o.estimate.counters.iterations
                                )
                            }
                            if !is {
                                match v {
                                    Verdict::Physical if o.estimate.undetermined.is_empty() => {
                                        wrong += 1
                                    }
                                    Verdict::Physical => open += 1,
                                    Verdict::Plausible => weak += 1,
                                    Verdict::Failed => failed += 1,
                                }
                            }
                        }
                    }
                }
                println!(
                    "{timing:?} {scene} {n}: {exact}/{total} exact; wrong physical {wrong}, physical-undetermined {open}, plausible {weak}, failed {failed}, refused {refused} {why} [{:.1} s]",
                    start.elapsed().as_secs_f64()
                );
            }
        }
    }
}
