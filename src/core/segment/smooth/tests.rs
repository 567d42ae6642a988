use nalgebra::{SymmetricEigen, UnitQuaternion, Vector3};

use super::*;
use crate::math::random::Random;
use crate::math::so3;
use crate::motion::{Seen, Stamp, TrackSketch};
use crate::segment::cut::median_interval_s;

/// A swing: the tracker goes to and fro on a bent way while it turns, at `speed_m_s` at most.
fn swing(speed_m_s: f64, time_s: f64) -> State {
    let (reach_m, rate) = (0.6, speed_m_s / 0.6);
    let at = |time_s: f64| {
        let phase = rate * time_s;
        let position_m = Vector3::new(
            reach_m * phase.sin(),
            0.3 * reach_m * (0.7 * phase + 0.3).cos(),
            0.2 * reach_m * (1.3 * phase).sin() + 1.0,
        );
        let turn = Vector3::new(
            0.3 * phase.sin(),
            0.9 * (0.8 * phase).sin(),
            0.4 * phase.cos(),
        );
        (position_m, so3::exp(&turn))
    };
    let h = 1e-5 / rate.max(1.0);
    let [before, here, after] = [-h, 0.0, h].map(|by_s| at(time_s + by_s));
    State {
        position_m: here.0,
        orientation: here.1,
        velocity_m_s: (after.0 - before.0) / (2.0 * h),
        angular_velocity_rad_s: so3::log(&(before.1.inverse() * after.1)) / (2.0 * h),
    }
}

/// Two seconds of a swing that begins with some phase, as a tracker with noise sees it.
fn seen(speed_m_s: f64, rate_hz: f64, sd: [f64; 2], random: &mut Random) -> (TrackSketch, f64) {
    let begun_s = 10.0 * random.signed();
    let mut vector = |sd: f64| Vector3::new(random.normal(), random.normal(), random.normal()) * sd;
    let count = (2.0 * rate_hz) as usize;
    let samples = (0..count).map(|k| {
        let acted_s = k as f64 / rate_hz;
        let state = swing(speed_m_s, begun_s + acted_s);
        Sample::of_pose(
            Stamp((acted_s * 1e9) as i64),
            acted_s,
            state.position_m + vector(sd[0]),
            state.orientation * so3::exp(&vector(sd[1])),
        )
    });
    let track = TrackSketch::new(samples.collect());
    (track, begun_s)
}

fn of(track: &TrackSketch, hits_s: &[f64]) -> HeldMotion {
    let hits: Vec<(usize, f64)> = hits_s.iter().copied().enumerate().collect();
    smoothed(
        &track.samples,
        median_interval_s(track),
        &Pose::identity(),
        &Held::default(),
        &hits,
    )
}

/// Shares of errors at collisions within one and within two standard deviations, of positions,
/// orientations, velocities and angular velocities; with the root mean square error of each.
fn coverage(speed_m_s: f64, rate_hz: f64, sd: [f64; 2]) -> [[f64; 3]; 4] {
    let mut random = Random::default();
    let mut found = [[0.0; 3]; 4];
    let mut count = 0.0;
    for _ in 0..8 {
        let (track, begun_s) = seen(speed_m_s, rate_hz, sd, &mut random);
        let hits_s = [0.4137, 0.9311, 1.4762];
        let motion = of(&track, &hits_s);
        for (hit_s, meeting) in hits_s.iter().zip(&motion.meetings) {
            let truth = swing(speed_m_s, begun_s + hit_s);
            let off = motion.at(*hit_s).state.minus(&truth);
            count += 3.0;
            for row in 0..12 {
                let sd = meeting.covariance[(row, row)].sqrt();
                let [one, two, square] = &mut found[row / 3];
                *one += f64::from(u8::from(off[row].abs() <= sd));
                *two += f64::from(u8::from(off[row].abs() <= 1.96 * sd));
                *square += off[row] * off[row];
            }
        }
    }
    found.map(|[one, two, square]| [one / count, two / count, (square / count).sqrt()])
}

#[test]
fn intervals_hold_the_truth_as_often_as_they_say() {
    for (speed_m_s, rate_hz, sd) in [
        (1.0, 60.0, [1e-3, 5e-3]),
        (4.0, 120.0, [1e-3, 5e-3]),
        (15.0, 480.0, [0.3e-3, 2e-3]),
        (4.0, 30.0, [1e-3, 5e-3]),
        (15.0, 120.0, [0.05e-3, 1e-3]),
        (1.0, 960.0, [5e-3, 1e-2]),
    ] {
        let coverage = coverage(speed_m_s, rate_hz, sd);
        println!("{speed_m_s} {rate_hz} {sd:?} {coverage:.3?}");
        for [one, two, _] in coverage {
            assert!(
                one > 0.55 && two > 0.85,
                "{speed_m_s} {rate_hz}: {one} {two}"
            );
        }
    }
}

/// Kalman and Rauch–Tung–Striebel are the least squares of all samples and all jerks at once.
#[test]
fn it_is_the_least_squares_of_samples_and_jerks() {
    use super::chain::Nine;
    let mut random = Random::default();
    let times_s = [0.0, 0.01, 0.025, 0.04, 0.05, 0.07];
    let timed: Vec<Timed<Vector3<f64>>> = times_s
        .iter()
        .enumerate()
        .map(|(k, time_s)| Timed {
            time_s: *time_s,
            reading: (k != 3).then(|| Vector3::repeat(time_s * time_s + 0.01 * random.normal())),
        })
        .collect();
    let noises = Noises {
        reading: 1e-4,
        jerk: 1e3,
    };
    let smoothed = filter::smooth::<PlaceChain>(&timed, &noises);
    // One axis of the same as a dense system: unknowns are value, rate, acceleration at each time.
    let count = times_s.len();
    let mut information = nalgebra::DMatrix::<f64>::zeros(3 * count, 3 * count);
    let mut pull = nalgebra::DVector::<f64>::zeros(3 * count);
    for (k, one) in timed.iter().enumerate() {
        if let Some(reading) = one.reading {
            information[(3 * k, 3 * k)] += 1.0 / noises.reading;
            pull[3 * k] += reading.x / noises.reading;
        }
        if k + 1 < count {
            let h = times_s[k + 1] - times_s[k];
            let phi = nalgebra::Matrix3::new(1.0, h, 0.5 * h * h, 0.0, 1.0, h, 0.0, 0.0, 1.0);
            let q = nalgebra::Matrix3::new(
                h.powi(5) / 20.0,
                h.powi(4) / 8.0,
                h.powi(3) / 6.0,
                h.powi(4) / 8.0,
                h.powi(3) / 3.0,
                h * h / 2.0,
                h.powi(3) / 6.0,
                h * h / 2.0,
                h,
            ) * noises.jerk;
            let weight = q.try_inverse().unwrap();
            let mut by = nalgebra::SMatrix::<f64, 3, 6>::zeros();
            by.fixed_view_mut::<3, 3>(0, 0).copy_from(&-phi);
            by.fixed_view_mut::<3, 3>(0, 3).fill_with_identity();
            let mut block = information.view_mut((3 * k, 3 * k), (6, 6));
            block += by.transpose() * weight * by;
        }
    }
    let covariance = information.try_inverse().unwrap();
    let mean = &covariance * pull;
    for (k, believed) in smoothed.iter().enumerate() {
        let nine: Nine = believed.chain.minus(&PlaceChain {
            position_m: Vector3::zeros(),
            velocity_m_s: Vector3::zeros(),
            acceleration_m_s2: Vector3::zeros(),
        });
        for part in 0..3 {
            let sd = covariance[(3 * k + part, 3 * k + part)].sqrt();
            let off = (nine[3 * part] - mean[3 * k + part]).abs();
            // The filter's vague beginning is a prior of a hundredth of what the samples say.
            assert!(off < 2e-2 * sd, "{k} {part}: {off} of {sd}");
            let own = believed.covariance[(3 * part, 3 * part)].sqrt();
            assert!((own / sd - 1.0).abs() < 2e-2, "{k} {part}: {own} {sd}");
        }
    }
}

#[test]
fn what_stands_still_stands_still() {
    let pose = (
        Vector3::new(0.3, -0.2, 1.0),
        so3::exp(&Vector3::new(0.3, 0.2, -0.5)),
    );
    let samples =
        (0..200).map(|k| Sample::of_pose(Stamp(k * 10_000_000), k as f64 * 0.01, pose.0, pose.1));
    let track = TrackSketch::new(samples.collect());
    let motion = of(&track, &[0.5, 1.234]);
    for acted_s in [-0.1, 0.0, 0.3337, 1.234, 1.99, 2.1] {
        let Driven { state, .. } = motion.at(acted_s);
        assert!((state.position_m - pose.0).norm() < 1e-12);
        assert!(state.orientation.angle_to(&pose.1) < 1e-12);
        assert!(state.velocity_m_s.norm() < 1e-12, "{}", state.velocity_m_s);
        assert!(state.angular_velocity_rad_s.norm() < 1e-12);
    }
    for meeting in &motion.meetings {
        let least = SymmetricEigen::new(meeting.covariance).eigenvalues.min();
        assert!(least > 0.0);
        let sd = meeting.covariance.diagonal().map(f64::sqrt);
        assert!(sd[0] < 1e-5 && sd[6] < 1e-3, "{sd}");
    }
}

#[test]
fn a_swing_without_noise_is_found_to_a_hundredth_of_a_millimetre() {
    let mut random = Random::default();
    let (track, begun_s) = seen(4.0, 240.0, [0.0; 2], &mut random);
    let motion = of(&track, &[1.0]);
    for k in 20..380 {
        let acted_s = (f64::from(k) + 0.37) / 200.0;
        let off = motion
            .at(acted_s)
            .state
            .minus(&swing(4.0, begun_s + acted_s));
        assert!(off.fixed_rows::<6>(0).amax() < 1e-5, "{acted_s}: {off}");
        assert!(off.fixed_rows::<6>(6).amax() < 5e-3, "{acted_s}: {off}");
    }
    assert!(motion.noise_sd[0] < 1e-4);
    let noisy = seen(4.0, 240.0, [2e-3, 1e-2], &mut random).0;
    let motion = of(&noisy, &[1.0]);
    assert!((motion.noise_sd[0] / 2e-3 - 1.0).abs() < 0.2);
    assert!((motion.noise_sd[1] / 1e-2 - 1.0).abs() < 0.2);
}

/// Gaps, jitter, and what was measured in any orientation of the world.
#[test]
fn a_turned_world_turns_the_motion_with_it() {
    let mut random = Random::default();
    let (track, _) = seen(3.0, 120.0, [1e-3, 5e-3], &mut random);
    let mut gappy = track.clone();
    gappy.samples.drain(100..108);
    let world = Pose::from_parts(
        Vector3::new(3.0, -1.0, 2.0).into(),
        UnitQuaternion::from_euler_angles(0.3, 1.2, -2.0),
    );
    let mut turned = gappy.clone();
    for sample in &mut turned.samples {
        if let Seen::Pose {
            position_m,
            orientation,
        } = &mut sample.seen
        {
            let pose = world * Pose::from_parts((*position_m).into(), *orientation);
            *position_m = pose.translation.vector;
            *orientation = pose.rotation;
        }
    }
    let hits_s = [0.6, 0.87, 1.4];
    let [one, other] = [&gappy, &turned].map(|track| of(track, &hits_s));
    for acted_s in [0.1, 0.6, 0.87, 1.77] {
        let [here, there] = [&one, &other].map(|motion| motion.at(acted_s).state);
        let moved = State {
            position_m: (world * nalgebra::Point3::from(here.position_m)).coords,
            orientation: world.rotation * here.orientation,
            velocity_m_s: world.rotation * here.velocity_m_s,
            ..here
        };
        let off = there.minus(&moved).amax();
        assert!(off < 1e-7, "{acted_s}: {off}");
    }
    // In the gap less is known.
    let sd = |at: usize| one.meetings[at].covariance[(6, 6)].sqrt();
    assert!(sd(1) > 1.05 * sd(0), "{} {}", sd(1), sd(0));
}
