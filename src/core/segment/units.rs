//! Detects positions that are not in metres.

use nalgebra::Vector3;

use super::error::SegmentError;
use crate::motion::{Link, Sample};

/// Greatest extent of a performance in sizes of its body: a die of a centimetre may cross a room
/// of five metres.
const SIZES_MAX: f64 = 500.0;
/// Greatest median speed of an object moved or thrown by hand [m/s].
const SPEED_MAX_M_S: f64 = 30.0;
/// Least time over which speeds are computed \[s\], so that noise does not dominate them.
const BASE_S: f64 = 0.05;

/// Refuses a stream that is too far-reaching or too fast to be in metres. The reach is the distance
/// from the middle sample within which nine tenths of the samples lie.
pub(super) fn check_units(link: &Link, samples: &[Sample]) -> Result<(), SegmentError> {
    let places = samples.iter();
    let places = places.filter_map(|sample| Some((sample.acted_s, sample.seen.position_m()?)));
    let count = places.clone().count();
    let Some((_, middle_m)) = places.clone().nth(count / 2) else {
        return Ok(());
    };
    let mut distances_m = Vec::with_capacity(count);
    distances_m.extend(
        places
            .clone()
            .map(|(_, place_m)| (place_m - middle_m).norm()),
    );
    let rank = count * 9 / 10;
    let reach_m = *distances_m.select_nth_unstable_by(rank, f64::total_cmp).1;
    let speed_m_s = median_speed_m_s(places, count);
    let size_m = 2.0 * link.shape.radius_m();
    if reach_m > SIZES_MAX * size_m || speed_m_s > SPEED_MAX_M_S {
        return Err(SegmentError::Units {
            body: link.name.clone(),
            reach_m,
            size_m,
            speed_m_s,
        });
    }
    Ok(())
}

/// Median speed through so many places at acted times [m/s].
fn median_speed_m_s(
    places: impl Iterator<Item = (f64, Vector3<f64>)> + Clone,
    count: usize,
) -> f64 {
    let mut speeds: Vec<f64> = Vec::with_capacity(count);
    let mut later = places.clone().peekable();
    for (from_s, from_m) in places {
        while later.next_if(|(s, _)| *s < from_s + BASE_S).is_some() {}
        let Some((to_s, to_m)) = later.peek() else {
            break;
        };
        speeds.push((to_m - from_m).norm() / (to_s - from_s));
    }
    if speeds.is_empty() {
        return 0.0;
    }
    let middle = speeds.len() / 2;
    *speeds.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};

    use super::*;
    use crate::math::Pose;
    use crate::motion::{MechanismIndex, Seen, Stamp};
    use crate::physics::Shape;

    fn die() -> Link {
        let shape = Shape::Sphere { radius_m: 0.01 };
        Link {
            name: "die".into(),
            body: shape.body_of_mass_kg(0.01).unwrap(),
            shape,
            shape_at_m: Vector3::zeros(),
            link_from_given: Pose::identity(),
            features: Vec::new(),
            mechanism: MechanismIndex(0),
            held: None,
        }
    }

    /// So many metres along, in two seconds.
    fn moving(distance_m: f64) -> Vec<Sample> {
        moving_for(distance_m, 2.0)
    }

    fn moving_for(distance_m: f64, duration_s: f64) -> Vec<Sample> {
        (0..=200)
            .map(|i| f64::from(i) / 200.0)
            .map(|share| {
                Sample::of_pose(
                    Stamp((share * duration_s * 1e9) as i64),
                    share * duration_s,
                    Vector3::new(distance_m * share, 0.0, 1.0),
                    UnitQuaternion::identity(),
                )
            })
            .collect()
    }

    #[test]
    fn too_far_alone_is_refused() {
        // Within 9/20 of the way of the middle are nine tenths of the samples: 9.9 and 10.35 m,
        // where 500 sizes are 10 m.
        assert_eq!(check_units(&die(), &moving_for(22.0, 60.0)), Ok(()));
        let error = check_units(&die(), &moving_for(23.0, 60.0)).unwrap_err();
        assert!(matches!(error, SegmentError::Units { reach_m, .. } if reach_m > 10.0));
    }

    #[test]
    fn too_fast_alone_is_refused() {
        // 500 sizes are a kilometre.
        let mut large = die();
        large.shape = Shape::Sphere { radius_m: 1.0 };
        assert_eq!(check_units(&large, &moving(58.0)), Ok(()));
        let error = check_units(&large, &moving(62.0)).unwrap_err();
        assert!(matches!(error, SegmentError::Units { speed_m_s, .. } if speed_m_s > 30.0));
    }

    #[test]
    fn a_throw_is_credible_and_a_thousand_of_it_is_not() {
        assert_eq!(check_units(&die(), &moving(5.0)), Ok(()));
        let error = check_units(&die(), &moving(500.0)).unwrap_err();
        assert_eq!(
            error.to_string(),
            "body \"die\" goes 225.0 m, 11250 times its size of 0.020 m, at 250.0 m/s in the median: \
             are the positions in millimetres? Expected metres"
        );
    }

    #[test]
    fn few_samples_and_one_wild_one_are_no_reason() {
        assert_eq!(check_units(&die(), &[]), Ok(()));
        assert_eq!(check_units(&die(), &moving(1e6)[..1]), Ok(()));
        let mut samples = moving(1.0);
        samples[50].seen = Seen::Point(Vector3::new(1e4, 0.0, 1.0));
        assert_eq!(check_units(&die(), &samples), Ok(()));
    }
}
