//! The performance maker acts as badly as its knobs say, and no worse.

use enact::math::so3;
use enact::motion::{TakeEvent, Timing, TrackIndex};
use enact_tools::perform::{Acting, Performance, Style, bounces, hat_box, perform};
use nalgebra::Vector3;

fn errors(performance: &Performance) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    errors_of(performance, TrackIndex(0))
}

/// Errors of all samples of a track: shift [m, world] and turn [rad, body].
pub(crate) fn errors_of(
    performance: &Performance,
    track: TrackIndex,
) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let sketch = performance.sketch();
    let link = performance.truth.scene.tracks[track].link;
    let samples = sketch.tracks[track]
        .samples
        .iter()
        .zip(&performance.sample_times_s[track]);
    samples
        .map(|(sample, time_s)| {
            let truth = performance.truth.state(link, *time_s);
            let orientation = sample.seen.orientation().unwrap();
            let turn = so3::log(&(truth.orientation.inverse() * orientation));
            (sample.seen.position_m().unwrap() - truth.position_m, turn)
        })
        .collect()
}

/// Root mean square per axis, of shifts and turns over many seeds.
fn rms_per_axis(acting: &Acting, seeds: u64) -> (f64, f64) {
    let truth = Style::Tip.truth();
    let (mut shift, mut turn, mut count) = (0.0, 0.0, 0.0);
    for seed in 0..seeds {
        for (s, t) in errors(&perform(&truth, acting, seed)) {
            shift += s.norm_squared();
            turn += t.norm_squared();
            count += 3.0;
        }
    }
    ((shift / count).sqrt(), (turn / count).sqrt())
}

fn close(value: f64, expected: f64, relative: f64) {
    assert!(
        (value / expected - 1.0).abs() < relative,
        "{value}, expected {expected}"
    );
}

#[test]
fn exact_acting_is_the_truth() {
    for truth in [Style::Tip.truth(), bounces(5, 1).unwrap()] {
        let performance = perform(&truth, &Acting::exact(), 1);
        for (shift, turn) in errors(&performance) {
            assert!(shift.norm() < 1e-14 && turn.norm() < 1e-14);
        }
        let sketch = performance.sketch();
        for (mark_s, event_s) in sketch.marks_s.iter().zip(&truth.event_times_s) {
            assert!((mark_s - event_s).abs() < 1e-9);
        }
        for (sample, time_s) in sketch.tracks[TrackIndex(0)]
            .samples
            .iter()
            .zip(&performance.sample_times_s[TrackIndex(0)])
        {
            assert!((sample.acted_s - time_s).abs() < 1e-9);
        }
    }
}

#[test]
fn the_wander_is_as_large_as_asked() {
    let whole = |per_axis: (f64, f64)| (per_axis.0 * 3_f64.sqrt(), per_axis.1 * 3_f64.sqrt());
    // A take is shorter than the slowest wander: some 400 takes × 3 axes × 1 independent value
    // each leave a standard error of 2 %.
    let wander = Acting {
        distortion: 1.0,
        ..Acting::exact()
    };
    let (shift_m, _) = whole(rms_per_axis(
        &Acting {
            wander_orientation_rad: 0.0,
            ..wander
        },
        400,
    ));
    close(shift_m, 0.02, 0.06);
    let (_, turn_rad) = whole(rms_per_axis(
        &Acting {
            wander_position_m: 0.0,
            ..wander
        },
        400,
    ));
    close(turn_rad, 8_f64.to_radians(), 0.06);
    let small = Acting {
        distortion: 0.25,
        ..wander
    };
    let (shift_m, turn_rad) = whole(rms_per_axis(&small, 400));
    close(shift_m, 0.005, 0.06);
    close(turn_rad, 2_f64.to_radians(), 0.06);
}

#[test]
fn the_noise_is_as_large_as_asked() {
    // 97 samples × 3 axes × 200 takes: a standard error of 0.3 %.
    let noise_m = Acting {
        noise_position_m: 5e-4,
        ..Acting::exact()
    };
    let (shift_m, turn_rad) = rms_per_axis(&noise_m, 200);
    close(shift_m, 5e-4, 0.01);
    assert!(turn_rad < 1e-14);
    let noise_rad = Acting {
        noise_orientation_rad: 0.3_f64.to_radians(),
        ..Acting::exact()
    };
    let (shift_m, turn_rad) = rms_per_axis(&noise_rad, 200);
    close(turn_rad, 0.3_f64.to_radians(), 0.01);
    // Through the mount's lever: |r|²·2/3 per axis.
    let lever_m = Style::Tip.truth().scene.tracks[TrackIndex(0)]
        .link_from_tracker
        .translation
        .vector
        .norm();
    close(shift_m, lever_m * (2.0_f64 / 3.0).sqrt() * turn_rad, 0.02);
}

#[test]
fn the_tempo_is_monotone_and_varies_as_asked() {
    let truth = Style::Tip.truth();
    let (mut square, mut mean, mut count) = (0.0, 0.0, 0.0);
    for seed in 0..400 {
        for variation in [0.3, 1.5] {
            let acting = Acting {
                tempo_variation: variation,
                dropout_rate: 0.0,
                ..Acting::default()
            };
            let performance = perform(&truth, &acting, seed);
            let tempo = &performance.tempo;
            let times = &performance.sample_times_s[TrackIndex(0)];
            assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
            assert!(times[0] == 0.0 && *times.last().unwrap() <= truth.duration_s);
            let end_s = tempo.acted_duration_s();
            assert_eq!(tempo.physical_s(end_s), truth.duration_s);
            for step in 0..100 {
                let acted_s = end_s * (f64::from(step) + 0.5) / 100.0;
                let back_s = tempo.acted_s(tempo.physical_s(acted_s));
                assert!((back_s - acted_s).abs() < 1e-12 * (1.0 + end_s * variation.exp()));
                if variation == 0.3 {
                    let h = 1e-5;
                    let rise_s = tempo.physical_s(acted_s + h) - tempo.physical_s(acted_s - h);
                    let logarithm = (2.5 * rise_s / (2.0 * h)).ln();
                    square += logarithm * logarithm;
                    mean += logarithm;
                    count += 1.0;
                }
            }
        }
    }
    // Slow takes last longer and weigh no more here: their mean is a little below 0.
    close((square / count).sqrt(), 0.3, 0.06);
    assert!((mean / count).abs() < 0.06, "{}", mean / count);
}

#[test]
fn marks_are_off_by_what_is_asked_and_never_by_more_than_twice_that() {
    let truth = Style::Tip.truth();
    let acting = Acting {
        marks_named: true,
        ..Acting::default()
    };
    let (mut square, mut count) = (0.0, 0.0);
    for seed in 0..500 {
        let performance = perform(&truth, &acting, seed);
        let marks = performance.events.iter().filter_map(|event| match event {
            TakeEvent::Mark(mark) => Some(mark),
            TakeEvent::Pose { .. } => None,
        });
        for (mark, (event, time_s)) in
            marks.zip(truth.scene.events.iter().zip(&truth.event_times_s))
        {
            assert_eq!(mark.event.as_deref(), Some(event.name.as_str()));
            let off_s = mark.stamp.seconds_since(acting.start) - performance.tempo.acted_s(*time_s);
            assert!(off_s.abs() <= 2.0 * acting.mark_error_s + 1e-9);
            square += off_s * off_s;
            count += 1.0;
        }
    }
    assert_eq!(count, 1000.0);
    // Cut off at two, a normal distribution has 0.880 of its standard deviation.
    close((square / count).sqrt(), 0.880 * acting.mark_error_s, 0.07);
}

#[test]
fn stamps_jitter_and_samples_are_lost_in_bursts_as_asked() {
    let truth = Style::Tip.truth();
    let acting = Acting {
        stamp_jitter_s: 1e-3,
        dropout_rate: 0.1,
        dropout_burst: 4.0,
        ..Acting::default()
    };
    let (mut square, mut count, mut lost, mut bursts) = (0.0, 0.0, 0.0, 0.0);
    for seed in 0..300 {
        let performance = perform(&truth, &acting, seed);
        let sketch = performance.sketch();
        let samples = &sketch.tracks[TrackIndex(0)].samples;
        assert!(samples.windows(2).all(|pair| pair[0].stamp < pair[1].stamp));
        let mut last_index = -1.0;
        for (sample, time_s) in samples
            .iter()
            .zip(&performance.sample_times_s[TrackIndex(0)])
        {
            let acted_s = performance.tempo.acted_s(*time_s);
            let off_s = sample.stamp.seconds_since(acting.start) - acted_s;
            square += off_s * off_s;
            count += 1.0;
            let index = (acted_s * acting.rate_hz).round();
            lost += index - last_index - 1.0;
            bursts += f64::from(index - last_index > 1.5);
            last_index = index;
        }
    }
    close((square / count).sqrt(), 1e-3, 0.01);
    close(lost / (lost + count), 0.1, 0.1);
    close(lost / bursts, 4.0, 0.1);
    assert!(
        perform(
            &truth,
            &Acting {
                dropout_rate: 0.0,
                ..acting
            },
            1
        )
        .events
        .len()
            > 200
    );
}

#[test]
fn known_timing_is_full_speed_with_the_wander_of_the_slow_performance() {
    let truth = Style::Tip.truth();
    let acting = Acting::timing_known();
    let performance = perform(&truth, &acting, 3);
    let sketch = performance.sketch();
    assert_eq!(performance.truth.scene.timing, Timing::Known);
    assert_eq!(
        sketch.tracks[TrackIndex(0)].samples.len(),
        (truth.duration_s * 120.0) as usize + 1
    );
    for (sample, time_s) in sketch.tracks[TrackIndex(0)]
        .samples
        .iter()
        .zip(&performance.sample_times_s[TrackIndex(0)])
    {
        assert!((sample.acted_s - time_s).abs() < 1e-9);
    }
    for (mark_s, event_s) in sketch.marks_s.iter().zip(&truth.event_times_s) {
        assert!((mark_s - event_s).abs() <= 1.0 / 120.0 + 1e-9);
    }

    // The same hand at an even slow tempo, every 2.5 times later.
    let quiet = |acting: Acting| Acting {
        noise_position_m: 0.0,
        noise_orientation_rad: 0.0,
        resolution_m: 0.0,
        resolution_quaternion: 0.0,
        stamp_jitter_s: 0.0,
        dropout_rate: 0.0,
        tempo_variation: 0.0,
        ..acting
    };
    let slow = quiet(Acting {
        rate_hz: 48.0,
        ..Acting::default()
    });
    let (fast, slow) = (
        errors(&perform(&truth, &quiet(acting), 3)),
        errors(&perform(&truth, &slow, 3)),
    );
    assert_eq!(fast.len(), slow.len());
    for ((shift, turn), (slow_shift, slow_turn)) in fast.iter().zip(&slow) {
        assert!((shift - slow_shift).norm() < 1e-13 && (turn - slow_turn).norm() < 1e-13);
        assert!(shift.norm() > 0.0);
    }
}

#[test]
fn a_knob_changes_nothing_but_what_it_is_about() {
    let truth = Style::Eraser.truth();
    let base = Acting {
        resolution_m: 0.0,
        resolution_quaternion: 0.0,
        ..Acting::default()
    };
    let strong = Acting {
        distortion: 4.0,
        mark_error_s: 0.06,
        ..base
    };
    let (one, four) = (perform(&truth, &base, 9), perform(&truth, &strong, 9));
    assert_eq!(one.sample_times_s, four.sample_times_s);
    // The noise is the same shift of the tracker whatever else is wrong with its pose.
    let noise_of = |acting: Acting| -> Vec<Vector3<f64>> {
        let quiet = Acting {
            noise_position_m: 0.0,
            ..acting
        };
        let tracked = [acting, quiet].map(|acting| perform(&truth, &acting, 9).events);
        let shift = |pair: (&TakeEvent, &TakeEvent)| match pair {
            (TakeEvent::Pose { sample: noisy, .. }, TakeEvent::Pose { sample, .. }) => {
                Some(noisy.position_m - sample.position_m)
            }
            _ => None,
        };
        tracked[0]
            .iter()
            .zip(&tracked[1])
            .filter_map(shift)
            .collect()
    };
    let (noise, noise_when_strong) = (noise_of(base), noise_of(strong));
    assert!(noise.len() > 100 && noise.len() == noise_when_strong.len());
    for (a, b) in noise.iter().zip(&noise_when_strong) {
        assert!((a - b).norm() < 1e-15 && a.norm() > 0.0);
    }
    let marks = [&one, &four].map(|p| p.sketch().marks_s);
    for ((a, b), event_s) in marks[0].iter().zip(&marks[1]).zip(&truth.event_times_s) {
        let acted_s = one.tempo.acted_s(*event_s);
        assert!(
            (2.0 * (a - acted_s) - (b - acted_s)).abs() < 2e-3,
            "{a} {b} {acted_s}"
        );
    }
}

#[test]
fn the_performer_holds_still_before_and_after() {
    let truth = Style::Tip.truth();
    let acting = Acting {
        hold_before_s: 0.5,
        hold_after_s: 0.3,
        dropout_rate: 0.0,
        ..Acting::default()
    };
    let performance = perform(&truth, &acting, 2);
    let times = &performance.sample_times_s[TrackIndex(0)];
    assert!(times[..60].iter().all(|time_s| *time_s == 0.0));
    assert!(
        times[times.len() - 35..]
            .iter()
            .all(|time_s| *time_s == truth.duration_s)
    );
    let arrivals = &performance.arrivals;
    assert_eq!(arrivals.len(), performance.events.len());
    assert!(arrivals.windows(2).all(|pair| pair[0] <= pair[1]));
}

#[test]
fn knobs_out_of_range_are_named() {
    let slack = Acting {
        rate_hz: 0.0,
        ..Acting::default()
    };
    assert_eq!(
        slack.check(),
        Err("rate_hz is 0, expected a positive number".to_owned())
    );
    assert!(
        Acting {
            dropout_rate: 1.0,
            ..Acting::default()
        }
        .check()
        .is_err()
    );
    assert!(
        Acting {
            distortion: f64::NAN,
            ..Acting::default()
        }
        .check()
        .is_err()
    );
    for preset in [Acting::default(), Acting::timing_known(), Acting::exact()] {
        assert_eq!(preset.check(), Ok(()));
    }
}

#[test]
fn trackers_of_several_bodies_are_out_of_step_and_share_the_marks() {
    let truth = hat_box::truth();
    let acting = Acting {
        stamp_jitter_s: 0.0,
        ..Acting::default()
    };
    let interval_s = 1.0 / acting.rate_hz;
    let mut phases = Vec::new();
    for seed in 0..8 {
        let performance = perform(&truth, &acting, seed);
        let sketch = performance.sketch();
        assert_eq!(sketch.marks_s.len(), 3);
        let tracks = [TrackIndex(0), TrackIndex(1)];
        let firsts = tracks.map(|track| sketch.tracks[track].samples[0].acted_s);
        assert_eq!(firsts[0], 0.0);
        phases.push(firsts[1] / interval_s);
        // Losses of the one are none of the other's.
        let [hat, cube] = tracks.map(|track| sketch.tracks[track].samples.len());
        let whole = (performance.tempo.acted_duration_s() * acting.rate_hz) as usize;
        assert!(hat > whole * 9 / 10 && cube > whole * 9 / 10);
        for track in tracks {
            for (sample, time_s) in sketch.tracks[track]
                .samples
                .iter()
                .zip(&performance.sample_times_s[track])
            {
                let state = truth.state(truth.scene.tracks[track].link, *time_s);
                assert!((sample.seen.position_m().unwrap() - state.position_m).norm() < 0.15);
            }
        }
    }
    phases.sort_by(f64::total_cmp);
    assert!(phases[0] > 0.0 && phases[7] < 1.0);
    assert!(phases.windows(2).all(|pair| pair[1] - pair[0] > 1e-3));
}
