//! How far two motions are apart: an estimate from the truth, over all or a part of its time.

use enact::math::so3;
use enact::motion::{Estimate, Scene};
use serde::Serialize;

use crate::case::Case;
use crate::perform::Truth;

/// Instants at which motions are compared.
const INSTANTS: usize = 100;
/// Farthest that a zero of time is looked for, in shares of the time compared, and steps of the
/// search: each narrows it to two thirds.
const SHIFT: f64 = 0.25;
const STEPS: usize = 30;

/// Root of the mean square over time and links.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Apart {
    /// Of the distance between centres of mass \[m\].
    pub position_m: f64,
    /// Of the angle between orientations \[rad\].
    pub orientation_rad: f64,
}

/// An estimate in its scene, and the true motion from its start to `until_s`, as far as both go. Where timing is
/// unknown the zero of physical time is a convention: the one that brings centres of mass nearest is taken. `None` where an
/// estimate is not finite.
pub fn apart(case: &Case, scene: &Scene, estimate: &Estimate, until_s: f64) -> Option<Apart> {
    let truth = &case.performance.truth;
    let own = moving(scene, estimate);
    let first = estimate.sample_times.first()?;
    let given_s = first.time_s - case.hidden_s(first.track, first.stamp);
    aligned(case, given_s, until_s, |shift_s| {
        between(&own, truth, shift_s, [0.0, until_s])
    })
}

/// The same of two estimates of one performance, from the other's beginning to its end.
pub fn apart_from_another(
    case: &Case,
    (scene, estimate): (&Scene, &Estimate),
    (other_scene, other): (&Scene, &Estimate),
) -> Option<Apart> {
    let [own, others] = [moving(scene, estimate), moving(other_scene, other)];
    let given_s = estimate.sample_times.first()?.time_s - other.sample_times.first()?.time_s;
    let starts_s = other.arcs.iter().map(|arc| arc.start_s);
    let ends_s = other.arcs.iter().map(|arc| arc.end_s);
    let range_s = [
        starts_s.fold(f64::INFINITY, f64::min),
        ends_s.fold(f64::NEG_INFINITY, f64::max),
    ];
    aligned(case, given_s, range_s[1] - range_s[0], |shift_s| {
        between(&own, &others, shift_s, range_s)
    })
}

fn moving(scene: &Scene, estimate: &Estimate) -> Truth {
    Truth {
        scene: scene.clone(),
        is_physical: true,
        parameters: Vec::new(),
        arcs: estimate.arcs.clone(),
        event_times_s: Vec::new(),
        duration_s: 0.0,
    }
}

/// How far apart at the difference of zeros that is given, or where timing is unknown at the one within
/// reach that brings centres of mass nearest.
fn aligned(case: &Case, given_s: f64, lasts_s: f64, at: impl Fn(f64) -> Apart) -> Option<Apart> {
    let shift_s = if case.performance.acting.is_timing_known() {
        given_s
    } else {
        let reach_s = SHIFT * lasts_s;
        least(given_s - reach_s, given_s + reach_s, |shift_s| {
            at(shift_s).position_m
        })
    };
    let apart = at(shift_s);
    (apart.position_m + apart.orientation_rad)
        .is_finite()
        .then_some(apart)
}

fn between(own: &Truth, truth: &Truth, shift_s: f64, [from_s, until_s]: [f64; 2]) -> Apart {
    let (mut square_m2, mut square_rad2, mut count) = (0.0, 0.0, 0.0);
    for link in truth.scene.links.keys() {
        for instant in 0..=INSTANTS {
            let share = instant as f64 / INSTANTS as f64;
            let time_s = from_s + (until_s - from_s) * share;
            let [here, there] = [
                own.world_from_body(link, time_s + shift_s),
                truth.world_from_body(link, time_s),
            ];
            let way_m = here.translation.vector - there.translation.vector;
            let turn = here.rotation.inverse() * there.rotation;
            square_m2 += way_m.norm_squared();
            square_rad2 += so3::log(&turn).norm_squared();
            count += 1.0;
        }
    }
    Apart {
        position_m: (square_m2 / count).sqrt(),
        orientation_rad: (square_rad2 / count).sqrt(),
    }
}

/// Where a function that falls and then rises is least, by thirds.
fn least(mut low: f64, mut high: f64, of: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..STEPS {
        let third = (high - low) / 3.0;
        if of(low + third) < of(high - third) {
            high -= third;
        } else {
            low += third;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::perform::{Acting, Style};

    #[test]
    fn what_is_moved_is_as_far_apart_and_what_is_late_is_not() {
        let slow = Acting {
            distortion: 0.0,
            noise_position_m: 0.0,
            noise_orientation_rad: 0.0,
            ..Acting::default()
        };
        for acting in [Acting::exact(), slow] {
            let case = Case::pencil(Style::Tip, &acting, 6000);
            let outcome = case.estimated(&mut ()).expect("an estimate");
            let until_s = case.performance.truth.duration_s;
            let off = |estimate: &Estimate| {
                apart(&case, &outcome.scene, estimate, until_s).expect("finite")
            };
            let mut estimate = outcome.estimate.clone();
            let least = off(&estimate);
            assert!(
                least.position_m < 1e-4 && least.orientation_rad < 1e-3,
                "{least:?}"
            );
            if !acting.is_timing_known() {
                for arc in &mut estimate.arcs {
                    for time_s in [&mut arc.epoch_s, &mut arc.start_s, &mut arc.end_s] {
                        *time_s += 0.03;
                    }
                }
                let late = off(&estimate);
                assert!(
                    (late.position_m - least.position_m).abs() < 1e-5,
                    "{late:?}"
                );
            }
            for arc in &mut estimate.arcs {
                arc.state.position_m += Vector3::y() * 0.003;
            }
            let moved = off(&estimate);
            assert!((moved.position_m - 0.003).abs() < 1e-4, "{moved:?}");
        }
    }
}
