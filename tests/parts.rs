//! Trackers that see parts of a body: its centre of mass, points, its orientation, a direction.

use enact::motion::{MotionPart, Undetermined, Verdict};
use enact_tools::apart::apart;
use enact_tools::case::{Case, estimated};
use enact_tools::parts::{LATE_S, Part};
use enact_tools::perform::{Acting, Style, bounces};

#[test]
fn looks() {
    for (name, acting) in [
        ("known", Acting::timing_known()),
        ("tempo", Acting::default()),
    ] {
        for part in Part::ALL {
            for seed in 0..4 {
                for (what, case) in [
                    ("tip", Case::pencil(Style::Tip, &acting, seed)),
                    (
                        "cube",
                        Case::new(&bounces::bounces(2, seed).unwrap(), &acting, seed),
                    ),
                ] {
                    let (scene, events) = part.seen(&case);
                    match estimated(&scene, &events, &mut ()) {
                        Ok(outcome) => {
                            let e = &outcome.estimate;
                            let off =
                                apart(&case, &outcome.scene, e, case.performance.truth.duration_s);
                            println!(
                                "{name} {what} {seed} {:40} {:?} it {} f {:.1} {:?} {:?} {:?} {:?}",
                                part.as_str(),
                                e.verdict,
                                e.counters.iterations,
                                e.objective,
                                off.map(|o| (1e3 * o.position_m, o.orientation_rad.to_degrees())),
                                e.undetermined,
                                e.parameters
                                    .iter()
                                    .find(|p| p.name == "late")
                                    .map(|p| (p.value, p.sd)),
                                if e.verdict == Verdict::Failed {
                                    format!("{:?}", e.reason)
                                } else {
                                    String::new()
                                }
                            );
                        }
                        Err(error) => {
                            println!("{name} {what} {seed} {:40} ERR {error}", part.as_str())
                        }
                    }
                }
            }
        }
    }
}
