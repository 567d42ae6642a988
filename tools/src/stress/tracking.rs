//! Trackers that jump, lose sight, or report a body the wrong way round.

use enact::math::{Pose, so3};
use enact::motion::{PoseSample, TakeEvent};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rand::{Rng, RngExt};

use super::hit::{direction, rng};
use super::{Trouble, add_both};
use crate::case::Case;
use crate::perform::Style;

/// Adds them.
pub fn add(all: &mut Vec<Trouble>) {
    for degrees in [150.0_f64, 165.0, 180.0] {
        for (which, arc) in [("before the bounce", Some(0)), ("throughout", None)] {
            let name = format!("off by {degrees}° {which}");
            add_both(all, "orientation", &name, move |acting, seed| {
                let mut case = Case::pencil(Style::Tip, acting, seed);
                let turn = so3::exp(&(direction(&mut rng(seed)) * degrees.to_radians()));
                turn_sketch(&mut case, arc, &turn);
                Ok(case)
            });
        }
    }
    for share in [0.01, 0.05, 0.2] {
        let name = format!("{} % of samples", 100.0 * share);
        for style in Style::ALL {
            let name = format!("{name}, {} first", style.as_str());
            add_both(all, "outliers", &name, move |acting, seed| {
                let mut case = Case::pencil(style, acting, seed);
                outliers(&mut case, share, &mut rng(seed));
                Ok(case)
            });
        }
    }
    for lost_s in [0.05, 0.1, 0.2, 0.35, 0.5] {
        let name = format!("{} ms in each flight", 1e3 * lost_s);
        add_both(all, "dropouts", &name, move |acting, seed| {
            let mut case = Case::pencil(Style::Tip, acting, seed);
            drop_out(&mut case, lost_s);
            Ok(case)
        });
    }
}

/// Turns what the tracker saw of the body, about the centre of mass, during one arc or all.
fn turn_sketch(case: &mut Case, arc: Option<usize>, turn: &UnitQuaternion<f64>) {
    let truth = case.performance.truth.clone();
    let tracker = truth.scene.bodies[0].body_from_tracker;
    let hidden_s: Vec<f64> = case.performance.sample_times_s[0].clone();
    let poses = case.performance.events.iter_mut().filter_map(|e| match e {
        TakeEvent::Pose { sample, .. } => Some(sample),
        TakeEvent::Mark(_) => None,
    });
    for (sample, time_s) in poses.zip(hidden_s) {
        let own = usize::from(time_s >= truth.event_times_s[0]);
        if arc.is_none_or(|arc| arc == own) {
            let body = pose(sample) * tracker.inverse();
            let turned = Pose::from_parts(body.translation, body.rotation * turn);
            *sample = PoseSample::from_pose(sample.stamp, &(turned * tracker));
        }
    }
}

fn pose(sample: &PoseSample) -> Pose {
    let [x, y, z, w] = sample.quaternion_xyzw;
    let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    Pose::from_parts(sample.position_m.into(), rotation)
}

/// Makes a share of the samples jump by 5 cm to 1 m and 20° to 180°.
pub fn outliers(case: &mut Case, share: f64, rng: &mut impl Rng) {
    let poses = case.performance.events.iter_mut().filter_map(|e| match e {
        TakeEvent::Pose { sample, .. } => Some(sample),
        TakeEvent::Mark(_) => None,
    });
    let mut poses: Vec<&mut PoseSample> = poses.collect();
    let count = (share * poses.len() as f64).ceil() as usize;
    for _ in 0..count {
        let at = rng.random_range(0..poses.len());
        let shift_m: Vector3<f64> = direction(rng) * 0.05 * 20f64.powf(rng.random());
        let angle_rad = (20.0 + 160.0 * rng.random::<f64>()).to_radians();
        let turn = so3::exp(&(direction(rng) * angle_rad));
        let seen = pose(poses[at]);
        let jumped = Pose::from_parts(
            (seen.translation.vector + shift_m).into(),
            seen.rotation * turn,
        );
        *poses[at] = PoseSample::from_pose(poses[at].stamp, &jumped);
    }
}

/// Loses so much acted time in the middle of each flight.
fn drop_out(case: &mut Case, lost_s: f64) {
    let truth = &case.performance.truth;
    let mut middles_s = Vec::new();
    let mut start_s = 0.0;
    for end_s in &truth.event_times_s {
        middles_s.push(case.performance.tempo.acted_s(0.5 * (start_s + end_s)));
        start_s = *end_s;
    }
    let origin = case.performance.acting.start;
    case.performance.events.retain(|event| match event {
        TakeEvent::Mark(_) => true,
        TakeEvent::Pose { sample, .. } => {
            let acted_s = sample.stamp.seconds_since(origin);
            // The first sample is zero of all times.
            acted_s <= 0.0
                || middles_s
                    .iter()
                    .all(|middle_s| (acted_s - middle_s).abs() > 0.5 * lost_s)
        }
    });
}
