//! Deviations of poses and velocities along the motion: those of many performances of one motion, and as large as errors are,
//! whatever the hand.

use enact::math::so3;
use enact::motion::{Performer, StateDeviation, TrackIndex, Verdict};
use enact::physics::{State, flow};
use enact::pipeline::Outcome;
use enact_tools::case::{Case, Posed};
use enact_tools::perform::{Acting, Style, bounces};
use nalgebra::Vector3;

/// Performances of one motion.
const SEEDS: u64 = 80;
/// Performances by hands.
const HAND_SEEDS: u64 = 25;
/// Instants of each flight.
const INSTANTS: usize = 5;

/// What is off at one instant of a flight: place, turn, velocity and angular velocity of the frame in which the scene gives
/// the body, and the deviations of them.
struct Told {
    off: [Vector3<f64>; 4],
    deviation: StateDeviation,
}

fn of_outcome(case: &Case, outcome: &Outcome) -> Vec<Told> {
    let posed = Posed::new(case.scene(), &outcome.sketch);
    let offset_s = case.offset_s(&posed, &outcome.sketch);
    let (scene, estimate) = (&outcome.scene, &outcome.estimate);
    let mut all = Vec::new();
    for (index, arc) in estimate.arcs.iter().enumerate() {
        let link = scene.mechanisms[arc.mechanism].links().next();
        let body_from_frame = scene.links[link.expect("a link")].link_from_given;
        let r = body_from_frame.translation.vector;
        let back = body_from_frame.rotation.inverse();
        let place_m = |of: &State| of.position_m + of.orientation * r;
        let pace_m_s =
            |of: &State| of.velocity_m_s + of.orientation * of.angular_velocity_rad_s.cross(&r);
        for instant in 0..INSTANTS {
            let share = instant as f64 / (INSTANTS - 1) as f64;
            let time_s = arc.start_s + share * (arc.end_s - arc.start_s);
            let truth = case.true_state(index, time_s, offset_s);
            let body = scene.body_of(arc.mechanism);
            let since_s = time_s - arc.epoch_s;
            let found = flow::advance(body, &estimate.gravity_m_s2, &arc.state, since_s);
            let turn = truth.orientation.inverse() * found.orientation;
            let spin_rad_s = found.angular_velocity_rad_s - truth.angular_velocity_rad_s;
            let deviation = arc.deviation(scene, &estimate.gravity_m_s2, time_s);
            all.push(Told {
                off: [
                    place_m(&found) - place_m(&truth),
                    back * so3::log(&turn),
                    pace_m_s(&found) - pace_m_s(&truth),
                    back * spin_rad_s,
                ],
                deviation: deviation.expect("a flight's certainty"),
            });
        }
    }
    all
}

/// Samples with white noise and nothing else, weighed by it, of a pencil that is tracked at its centre of mass.
fn white(style: Style, noise: f64, seed: u64) -> Case {
    let acting = Acting {
        distortion: 0.0,
        resolution_m: 0.0,
        resolution_quaternion: 0.0,
        mark_error_s: 0.0,
        noise_position_m: noise * 0.0005,
        noise_orientation_rad: noise * 0.3_f64.to_radians(),
        rate_hz: 60.0,
        ..Acting::timing_known()
    };
    let mut scene = style.truth().scene;
    scene.tracks[TrackIndex(0)].link_from_tracker = enact::math::Pose::identity();
    scene.weights.position_m = acting.noise_position_m;
    scene.weights.orientation_rad = acting.noise_orientation_rad;
    Case::new(&style.truth_in(&scene).unwrap(), &acting, seed).one_by_one()
}

#[test]
fn deviations_are_those_of_many_performances_of_one_motion() {
    for style in [Style::Tip, Style::Eraser] {
        let mut errors: Vec<[f64; 12]> = Vec::new();
        let mut variances: Vec<[f64; 12]> = Vec::new();
        for seed in 0..SEEDS {
            let case = white(style, 1.0, seed);
            let outcome = case.estimated(&mut ()).unwrap();
            assert_eq!(outcome.estimate.verdict, Verdict::Physical, "{seed}");
            for (instant, told) in of_outcome(&case, &outcome).iter().enumerate() {
                if errors.len() <= instant {
                    errors.push([0.0; 12]);
                    variances.push([0.0; 12]);
                }
                let off = told.off.iter().flat_map(|of| of.iter());
                let sds = told.deviation.parts().into_iter().flatten();
                for (at, (off, sd)) in off.zip(sds).enumerate() {
                    errors[instant][at] += off * off;
                    variances[instant][at] += sd.expect("determined").powi(2);
                }
            }
        }
        assert_eq!(errors.len(), 2 * INSTANTS);
        let ratios = errors
            .iter()
            .zip(&variances)
            .flat_map(|(errors, variances)| {
                let pairs = errors.iter().zip(variances);
                pairs.map(|(square, variance)| (square / variance).sqrt())
            });
        let ratios: Vec<f64> = ratios.collect();
        let what = format!("{}: {ratios:.2?}", style.as_str());
        // A deviation of eighty numbers is known to eight percent. That errors may be those of a slow hand is in what is
        // told: of what a hand could move as a whole it is more than white noise makes.
        assert!(
            ratios.iter().all(|ratio| (0.5..1.25).contains(ratio)),
            "{what}"
        );
        let logs: f64 = ratios.iter().map(|ratio| ratio.ln()).sum();
        let mean = (logs / ratios.len() as f64).exp();
        assert!((0.65..1.1).contains(&mean), "{mean}, {what}");
    }
}

#[test]
fn less_noise_makes_smaller_deviations() {
    let totals = |noise: f64| {
        let case = white(Style::Tip, noise, 3);
        let outcome = case.estimated(&mut ()).unwrap();
        let told = of_outcome(&case, &outcome);
        let totals = told
            .iter()
            .map(|of| of.deviation.totals().map(Option::unwrap));
        totals.collect::<Vec<_>>()
    };
    for (coarse, fine) in totals(2.0).iter().zip(totals(0.5)) {
        for (coarse, fine) in coarse.iter().zip(fine) {
            assert!(fine > 0.0 && fine.is_finite());
            let ratio = coarse / fine;
            // The noise is told anew from each performance.
            assert!((2.0..8.0).contains(&ratio), "{ratio}");
        }
    }
}

#[test]
fn intervals_along_the_motion_hold_whatever_the_hand() {
    let slow = |wander_pace| Acting {
        wander_pace,
        ..Acting::default()
    };
    let known = |wander_pace| Acting {
        wander_pace,
        ..Acting::timing_known()
    };
    for performer in [Performer::Hand, Performer::Nobody] {
        for (name, acting) in [
            ("known", known(1.0)),
            ("known, fast", known(2.5)),
            ("unknown tempo", slow(1.0)),
        ] {
            let mut normalised: [Vec<f64>; 4] = Default::default();
            for seed in 0..HAND_SEEDS {
                let mut case = match seed % 2 {
                    0 => Case::pencil(Style::Tip, &acting, seed),
                    _ => Case::new(&bounces(2, seed).unwrap(), &acting, seed),
                };
                case.performance.truth.scene.performer = performer;
                let outcome = case.estimated(&mut ()).unwrap();
                if outcome.estimate.verdict == Verdict::Failed {
                    continue;
                }
                for told in of_outcome(&case, &outcome) {
                    for (part, sds) in told.deviation.parts().iter().enumerate() {
                        let both = told.off[part].iter().zip(sds);
                        let each = both.map(|(off, sd)| off.abs() / sd.expect("determined"));
                        normalised[part].extend(each);
                    }
                }
            }
            for (part, all) in normalised.iter_mut().enumerate() {
                let what = format!("{performer:?}, {name}, part {part}");
                assert!(all.len() > 500, "{what}: {}", all.len());
                let holds = all.iter().filter(|off| **off <= 1.96).count();
                let share = holds as f64 / all.len() as f64;
                // How large a wander is that is slower than the take is told by its prior alone.
                assert!(share >= 0.78, "{what}: {share}");
                // Wide is no art.
                all.sort_by(f64::total_cmp);
                let median = all[all.len() / 2];
                assert!(median > 0.2, "{what}: {median}");
            }
        }
    }
}

#[test]
fn previews_have_none() {
    let case = white(Style::Tip, 1.0, 0);
    let mut preview = enact::pipeline::Preview::new(case.scene().clone());
    for event in &case.performance.events {
        preview.push(event.clone());
    }
    let previewed = preview.estimate(&mut ()).unwrap().expect("a motion");
    assert!(!previewed.outcome.estimate.arcs.is_empty());
    for arc in &previewed.outcome.estimate.arcs {
        assert_eq!(arc.certainty, None);
    }
}

/// A goal of a pose at a given time leaves nothing open of it, though no sample tells that.
#[test]
fn what_a_goal_holds_is_exact_and_not_unknown() {
    let mut case = white(Style::Tip, 1.0, 0);
    case.performance.truth.scene.events[1].time.is_free = Some(false);
    let outcome = case.estimated(&mut ()).unwrap();
    assert_eq!(outcome.estimate.verdict, Verdict::Physical);
    let told = of_outcome(&case, &outcome);
    let (start, end) = (&told[INSTANTS], &told[2 * INSTANTS - 1]);
    for part in [0, 1] {
        for axis in 0..3 {
            let [at_start, at_end] = [start, end].map(|told| told.deviation.parts()[part][axis]);
            let (at_start, at_end) = (at_start.expect("told"), at_end.expect("held"));
            assert!(
                at_start > 1e-5 && at_end < 1e-2 * at_start,
                "{at_start} {at_end}"
            );
        }
    }
    let velocities = end.deviation.velocity_m_s.map(|sd| sd.expect("told"));
    assert!(velocities.iter().all(|sd| *sd > 1e-5), "{velocities:?}");
}
