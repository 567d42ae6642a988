//! Studies of the estimator on performances with known truth.
use std::time::Instant;

use enact::estimate::layout::Layout;
use enact::estimate::problem::Problem;
use enact::estimate::recipe::{self, Recipe};
use enact::initialise;
use enact::motion::{ArcGuess, Guess, Scene, Sketch};
use enact::physics::flow;
use enact::segment;

#[path = "../perform/mod.rs"]
mod perform;
use perform::{Acting, Performance, Style};

fn truth_guess(perf: &Performance, guess: &Guess, epochs: bool) -> Guess {
    let truth = &perf.truth;
    let scene = &truth.scene;
    let _ = epochs;
    let arcs = guess
        .arcs
        .iter()
        .enumerate()
        .map(|(i, arc)| {
            let t = &truth.arcs[i];
            let body = &scene.bodies[t.body].body;
            ArcGuess {
                state: flow::advance(body, &scene.gravity_m_s2, &t.state, arc.epoch_s - t.epoch_s),
                ..arc.clone()
            }
        })
        .collect();
    Guess {
        arcs,
        event_times_s: truth.event_times_s.clone(),
    }
}

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let seeds: u64 = args.get(1).map_or(20, |s| s.parse().unwrap());
    let known = args.get(2).map_or(true, |s| s == "known");
    for style in Style::ALL {
        for distortion in [1.0, 2.0, 4.0, 8.0] {
            let mut times = vec![];
            let mut its = vec![];
            let mut conv = 0;
            let mut best = 0;
            let mut n = 0;
            let mut fit = vec![];
            let mut ratio_bad = vec![];
            for seed in 0..seeds {
                let mut scene: Scene = enact::config::scene_from_toml(style.scene_toml()).unwrap();
                let acting = if known {
                    Acting {
                        distortion,
                        ..Acting::timing_known()
                    }
                } else {
                    Acting {
                        distortion,
                        ..Acting::default()
                    }
                };
                if known {
                    scene.timing = enact::motion::Timing::Known;
                }
                let truth = style.truth_in(&scene).unwrap();
                let perf = perform::perform(&truth, &acting, seed);
                let mut sketch: Sketch = perf.sketch();
                let t0 = Instant::now();
                segment::refine(&scene, &mut sketch);
                let segments = match segment::cut(&scene, &sketch) {
                    Ok(s) => s,
                    Err(e) => {
                        println!("seed {seed}: {e}");
                        continue;
                    }
                };
                let guessed = initialise::guess(&scene, &sketch, &segments);
                let t1 = Instant::now();
                let problem = Problem::new(&scene, &sketch, &segments);
                let layout = Layout::new(&problem);
                let sol = enact::estimate::solve::best(
                    &problem,
                    &layout,
                    &guessed.guesses,
                    &Recipe::default(),
                    &mut (),
                )
                .1;
                let t2 = Instant::now();
                n += 1;
                fit.push((t1 - t0).as_secs_f64());
                times.push((t2 - t0).as_secs_f64());
                its.push(sol.counters.iterations);
                if sol.finished.converged {
                    conv += 1;
                }
                // from the truth
                let tg = truth_guess(&perf, &guessed.guesses[0], true);
                let refs = [tg];
                let mut low = sol.system.cost;
                for g in &refs {
                    if known {
                        let s = recipe::solve(
                            &problem,
                            &layout,
                            g,
                            &Recipe {
                                sweep_weights: vec![],
                                ..Recipe::default()
                            },
                            &mut (),
                        );
                        if s.finished.converged {
                            low = low.min(s.system.cost);
                        }
                    }
                }
                if sol.finished.converged && sol.system.cost <= low * (1.0 + 2e-5) + 1e-12 {
                    best += 1;
                } else {
                    ratio_bad.push((seed, sol.system.cost / low, sol.finished.converged));
                }
            }
            times.sort_by(f64::total_cmp);
            fit.sort_by(f64::total_cmp);
            its.sort();
            println!(
                "{:?} {distortion}x: n {n} converged {conv} best {best} iterations {} ({}) time {:.3} ms (max {:.3}) fit {:.3} ms  bad {:?}",
                style,
                its[its.len() / 2],
                its[its.len() - 1],
                times[times.len() / 2] * 1e3,
                times[times.len() - 1] * 1e3,
                fit[fit.len() / 2] * 1e3,
                &ratio_bad[..ratio_bad.len().min(4)]
            );
        }
    }
}
