//! A hand rounds the kinks of its path as a Gaussian does, there alone, and only if asked.

use enact::math::so3;
use enact::motion::{LinkIndex, Moment, TakeEvent, TrackIndex};
use enact_tools::perform::{
    Acting, Performance, Style, Truth, bounces, clatter, die, hat_box, perform, recording,
};
use nalgebra::Vector3;

use crate::acting::errors_of;

/// Of the rounding [s, acted].
const KINK_S: f64 = 0.01;

/// A hand that does nothing wrong but round.
fn rounding(rate_hz: f64) -> Acting {
    Acting {
        kink_s: KINK_S,
        rate_hz,
        ..Acting::exact()
    }
}

/// A change of velocities, by acted time.
#[derive(Debug)]
struct Kink {
    acted_s: f64,
    velocity_m_s: Vector3<f64>,
    angular_velocity_rad_s: Vector3<f64>,
}

/// Those of a link, from the states before and after the collisions.
fn kinks(performance: &Performance, link: LinkIndex) -> Vec<Kink> {
    let (truth, tempo) = (&performance.truth, &performance.tempo);
    let events = truth.scene.events.iter().enumerate();
    let collisions = events.filter(|(_, event)| event.kind.collision().is_some());
    let kink = |event: usize| {
        let [before, after] =
            [Moment::Before, Moment::After].map(|moment| truth.state_at(link, (event, moment)));
        let acted_s = tempo.acted_s(truth.event_times_s[event]);
        let step_s = 1e-5;
        let [from_s, to_s] = [-step_s, step_s].map(|by_s| tempo.physical_s(acted_s + by_s));
        let rate = (to_s - from_s) / (2.0 * step_s);
        let turning = after.angular_velocity_rad_s - before.angular_velocity_rad_s;
        Kink {
            acted_s,
            velocity_m_s: (after.velocity_m_s - before.velocity_m_s) * rate,
            angular_velocity_rad_s: turning * rate,
        }
    };
    collisions.map(|(event, _)| kink(event)).collect()
}

/// What a Gaussian of standard deviation one adds at `u` to the function that is 0 before 0 and then rises
/// by one per one: by quadrature.
fn added(u: f64) -> f64 {
    const FAR: f64 = 9.0;
    const STEPS: usize = 2000;
    if u.abs() >= FAR {
        return 0.0;
    }
    // Simpson's rule over the errors with which it has begun to rise.
    let step = (FAR + u) / STEPS as f64;
    let term = |at: usize| {
        let error = at as f64 * step - u;
        let weight = match at {
            0 | STEPS => 1.0,
            _ if at % 2 == 1 => 4.0,
            _ => 2.0,
        };
        weight * (u + error) * (-0.5 * error * error).exp()
    };
    let mean = (0..=STEPS).map(term).sum::<f64>() * step / 3.0 / std::f64::consts::TAU.sqrt();
    mean - u.max(0.0)
}

/// Checks that every sample of a track is where the Gaussian says.
fn is_smeared(performance: &Performance, track: TrackIndex) {
    let link = performance.truth.scene.tracks[track].link;
    let kinks = kinks(performance, link);
    assert!(!kinks.is_empty());
    let times_s = &performance.sample_times_s[track];
    for ((shift, turn), time_s) in errors_of(performance, track).iter().zip(times_s) {
        let acted_s = performance.tempo.acted_s(*time_s);
        let (mut shifted, mut turned) = (Vector3::zeros(), Vector3::zeros());
        for kink in &kinks {
            let by_s = KINK_S * added((acted_s - kink.acted_s) / KINK_S);
            shifted += kink.velocity_m_s * by_s;
            turned += kink.angular_velocity_rad_s * by_s;
        }
        let off = (shift - shifted).norm().max((turn - turned).norm());
        assert!(off < 1e-10, "{off} at {acted_s} of {kinks:?}");
    }
}

#[test]
fn kinks_are_rounded_as_a_gaussian_does_in_every_tempo() {
    let alone = [Style::Tip.truth(), bounces(5, 1).unwrap()];
    // Two bodies, which meet; and kinks nearer to each other than they are wide.
    let others = [hat_box::truth(), clatter(3, 0.004, 1).unwrap()];
    for truth in alone.iter().chain(&others) {
        let full_speed = rounding(2000.0);
        let slow = Acting {
            slowdown: 2.5,
            tempo_variation: 0.3,
            ..full_speed
        };
        for acting in [full_speed, slow] {
            let performance = perform(truth, &acting, 4);
            for track in truth.scene.tracks.keys() {
                is_smeared(&performance, track);
            }
        }
    }
}

#[test]
fn a_rounded_path_is_never_further_off_than_at_the_kink() {
    let performance = perform(&Style::Tip.truth(), &rounding(20_000.0), 1);
    let kinks = kinks(&performance, LinkIndex(0));
    let [kink] = &kinks[..] else {
        panic!("{kinks:?}")
    };
    let errors = errors_of(&performance, TrackIndex(0));
    let most = |size: fn(&(Vector3<f64>, Vector3<f64>)) -> f64| {
        errors.iter().map(size).fold(0.0, f64::max)
    };
    for (most, jump) in [
        (most(|(shift, _)| shift.norm()), kink.velocity_m_s.norm()),
        (
            most(|(_, turn)| turn.norm()),
            kink.angular_velocity_rad_s.norm(),
        ),
    ] {
        let share = most / (KINK_S * jump);
        assert!((0.395..0.4).contains(&share), "{share}");
    }
}

/// The greatest change of velocity [m/s] and of angular velocity [rad/s] from one sample to the next.
fn greatest_changes(truth: &Truth, acting: &Acting) -> [f64; 2] {
    let sketch = perform(truth, acting, 1).sketch();
    let samples = &sketch.tracks[TrackIndex(0)].samples;
    let seen = samples.iter().map(|sample| {
        let orientation = sample.seen.orientation().unwrap();
        (sample.seen.position_m().unwrap(), orientation)
    });
    let poses: Vec<_> = seen.collect();
    let rates = poses.windows(2).map(|pair| {
        let [(x, q), (y, r)] = [pair[0], pair[1]];
        let turn = so3::log(&(q.inverse() * r));
        ((y - x) * acting.rate_hz, turn * acting.rate_hz)
    });
    let rates: Vec<_> = rates.collect();
    let changes = rates.windows(2);
    changes.fold([0.0, 0.0], |[most_m_s, most_rad_s], pair| {
        let change_m_s: f64 = (pair[1].0 - pair[0].0).norm();
        let change_rad_s: f64 = (pair[1].1 - pair[0].1).norm();
        [most_m_s.max(change_m_s), most_rad_s.max(change_rad_s)]
    })
}

#[test]
fn velocities_jump_where_nothing_is_rounded_and_vanish_with_the_step_where_it_is() {
    let truth = Style::Tip.truth();
    let rates_hz = [1e3, 1e4, 1e5];
    let [sharp, round] = [0.0, KINK_S].map(|kink_s| {
        rates_hz.map(|rate_hz| {
            let acting = Acting {
                kink_s,
                ..rounding(rate_hz)
            };
            greatest_changes(&truth, &acting)
        })
    });
    for part in 0..2 {
        for step in 1..rates_hz.len() {
            let [sharp, round] =
                [&sharp, &round].map(|changes| changes[step][part] / changes[step - 1][part]);
            // The step over the kink is shared by two differences.
            assert!(sharp > 0.5, "{sharp}");
            assert!((0.08..0.12).contains(&round), "{round}");
        }
    }
}

#[test]
fn beyond_six_standard_deviations_a_rounding_hand_leaves_every_bit_as_it_was() {
    let truth = bounces(2, 3).unwrap();
    let sharp = Acting::default();
    let round = Acting {
        kink_s: KINK_S,
        ..sharp
    };
    let [was, is] = [sharp, round].map(|acting| perform(&truth, &acting, 5));
    let kinks = kinks(&was, LinkIndex(0));
    // Standard deviations to the nearest kink.
    let distance = |time_s: &f64| {
        let acted_s = was.tempo.acted_s(*time_s);
        let off = |kink: &Kink| (acted_s - kink.acted_s).abs() / KINK_S;
        kinks.iter().map(off).fold(f64::INFINITY, f64::min)
    };
    assert_eq!(was.sample_times_s, is.sample_times_s);
    assert_eq!(was.arrivals, is.arrivals);
    let mut times_s = was.sample_times_s[TrackIndex(0)].iter();
    let (mut near, mut far) = (0, 0);
    for (was, is) in was.events.iter().zip(&is.events) {
        let distance = match was {
            TakeEvent::Pose { .. } => distance(times_s.next().unwrap()),
            TakeEvent::Mark(_) => f64::INFINITY,
        };
        if distance > 6.0 {
            assert_eq!(was, is);
            far += 1;
        } else if distance < 3.0 {
            assert_ne!(was, is);
            near += 1;
        }
    }
    assert!(far > 100 && near > 10, "{far} far, {near} near");
}

#[test]
fn the_record_says_how_kinks_are_rounded_only_if_they_are() {
    let truth = Style::Eraser.truth();
    let record = |acting: &Acting| recording::truth_json(&perform(&truth, acting, 1));
    assert!(!record(&Acting::default()).contains("kink"));
    assert!(record(&rounding(120.0)).contains("\"kink_s\":0.01"));
    let negative = Acting {
        kink_s: -0.01,
        ..Acting::default()
    };
    let refusal = "kink_s is -0.01, expected zero or a positive number";
    assert_eq!(negative.check(), Err(refusal.to_owned()));
}

#[test]
fn an_edited_sketch_has_no_kinks_to_round() {
    let [was, is] = [0.0, KINK_S].map(|kink_s| {
        let acting = Acting {
            kink_s,
            ..Acting::edited()
        };
        perform(&die::reference(), &acting, 1).events
    });
    assert_eq!(was, is);
}
