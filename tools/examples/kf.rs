use enact::motion::*;
use enact::pipeline::Pipeline;
use enact_tools::perform::*;

fn truth(scene: &str, seed: u64) -> Option<Truth> {
    let of = match scene {
        "tip" => Keyframed::Pencil(Style::Tip),
        "eraser" => Keyframed::Pencil(Style::Eraser),
        "box1" => Keyframed::Box(1),
        "box2" => Keyframed::Box(2),
        "box4" => Keyframed::Box(4),
        "die3" => Keyframed::Die(3),
        _ => panic!(),
    };
    let t = of.truth(seed).ok()?;
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
