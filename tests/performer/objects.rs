//! Real tosses of household objects, heavily smoothed: what their study stands on, on made-up
//! motions; and on the tosses themselves that every first flight is explained or named. That part is skipped, saying
//! so, where the data are not there.

use crate::skip::skip;
use enact::math::so3;
use enact::motion::{LinkIndex, Verdict};
use enact::pipeline::Pipeline;
use enact_tools::objects::check::checked;
use enact_tools::objects::cut::{cut, flights};
use enact_tools::objects::mesh::{mesh_from_body, vertices};
use enact_tools::objects::read::{self, RATE_HZ};
use enact_tools::objects::scene::{IMPACT, Trust, contact_height_m, flight, impact, rest_height_m};
use enact_tools::objects::smoothing::{Filter, fall, filter, run};
use enact_tools::objects::solid::{Solid, solids};
use enact_tools::objects::trust::{known, trust};
use enact_tools::tosses::Pose;
use nalgebra::{UnitQuaternion, Vector3};

const GRAVITY_M_S2: Vector3<f64> = Vector3::new(0.0, 0.0, -9.80665);
/// A drop from 0.3 m that turns by a tenth of a radian from sample to sample, is hit after seven samples, and
/// turns the other way.
const HIT: usize = 7;

fn dropped(samples: usize) -> Vec<Pose> {
    let pose = |index: usize| {
        let time_s = index as f64 / RATE_HZ;
        let hit_s = (HIT as f64 - 0.5) / RATE_HZ;
        let after_s = (time_s - hit_s).max(0.0);
        let z_m = 0.3 - 4.9 * time_s * time_s + 3.0 * after_s;
        let turned = 0.1 * (time_s.min(hit_s) * RATE_HZ) - 0.2 * after_s * RATE_HZ;
        (
            Vector3::new(0.4 * time_s, -0.1, z_m),
            so3::exp(&(Vector3::new(0.6, 0.0, 0.8) * turned)),
        )
    };
    (0..samples).map(pose).collect()
}

fn heights(poses: &[Pose]) -> Vec<f64> {
    poses.iter().map(|pose| pose.0.z).collect()
}

#[test]
fn a_filter_is_seen_by_the_samples_that_it_puts_on_one_cubic() {
    let poses = dropped(24);
    let heights_m = heights(&poses);
    let unfiltered: Vec<Pose> = poses.iter().map(|pose| (bent(pose.0), pose.1)).collect();
    assert_eq!(filter(&unfiltered), None);
    for (order, window) in [(2, 7), (3, 9), (3, 15)] {
        let of = Filter { order, window };
        let positions_m: Vec<Vector3<f64>> = poses.iter().map(|pose| bent(pose.0)).collect();
        let filtered_m = of.smoothed_positions(&positions_m).unwrap();
        let along: Vec<f64> = filtered_m.iter().map(|position| position.z).collect();
        assert_eq!(run(&along, order), window / 2 + 1);
        let turns = poses.iter().map(|pose| pose.1);
        let filtered: Vec<Pose> = filtered_m.into_iter().zip(turns).collect();
        assert_eq!(filter(&filtered), Some(of));
    }
    let cubic = Filter {
        order: 3,
        window: 15,
    };
    assert_eq!(cubic.smoothed(&heights_m[..14]), None);
    // A cubic stays as it is, at the ends too.
    let values: Vec<f64> = (0..20).map(|i| f64::from(i).powi(3) / 1e3 - 0.2).collect();
    let same = cubic.smoothed(&values).unwrap();
    let off = values.iter().zip(same).map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) < 1e-9);
}

/// A position on no line and no parabola in any axis.
fn bent(position_m: Vector3<f64>) -> Vector3<f64> {
    position_m.map(|along| along + 0.05 * (40.0 * position_m.z).sin())
}

#[test]
fn what_a_filter_does_to_a_fall_is_far_from_gravity() {
    let poses = dropped(24);
    let fallen = |heights_m: &[f64]| {
        let positions_m: Vec<Vector3<f64>> = heights_m[..HIT]
            .iter()
            .map(|z_m| Vector3::new(0.0, 0.0, *z_m))
            .collect();
        fall(&positions_m, RATE_HZ, &Vector3::new(0.0, 0.0, -9.8)).unwrap()
    };
    let heights_m = heights(&poses);
    let true_fall = fallen(&heights_m);
    assert!((true_fall.acceleration_m_s2.unwrap().z + 9.8).abs() < 1e-6);
    assert!(true_fall.squares_m2 < 1e-18 && true_fall.freedom == 3 * (HIT - 2));
    let of = Filter {
        order: 3,
        window: 15,
    };
    let bent = fallen(&of.smoothed(&heights_m).unwrap());
    assert!(bent.acceleration_m_s2.unwrap().z > -5.0);
}

#[test]
fn contacts_are_where_the_spin_changes() {
    let poses = dropped(20);
    let found = cut(&poses).expect("two flights");
    assert_eq!(found.first, [0, HIT - 1]);
    assert_eq!(found.impact(), HIT as f64 - 0.5);
    assert_eq!(found.second, Some([HIT, 19]));
    // A second hit two samples later leaves no flight between.
    let mut twice = dropped(20);
    for pose in &mut twice[HIT + 2..] {
        pose.1 = so3::exp(&(Vector3::y() * 0.7)) * pose.1;
    }
    let found = cut(&twice).expect("a first flight");
    assert_eq!((found.first, found.second), ([0, HIT - 1], None));
    // One that never turns alike for long has none.
    let tumbling: Vec<Pose> = (0..12)
        .map(|i| {
            let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
            (Vector3::zeros(), so3::exp(&(Vector3::x() * 0.2 * sign)))
        })
        .collect();
    assert!(flights(&tumbling).is_empty());
}

const PRISM_OBJ: &str = "# a wedge\no wedge\nv 0 0 0\nv 0.08 0 0\nv 0 0.06 0\nv 0 0 0.2\nv 0.08 0 0.2\n\
                         v 0 0.06 0.2\nvn 0 0 1\nf 1//1 2//1 3//1\n";

#[test]
fn a_mesh_is_a_body_about_its_centre_of_mass() {
    let points_m = vertices(PRISM_OBJ).unwrap();
    assert_eq!(points_m.len(), 6);
    let centre_m = mesh_from_body(&points_m).unwrap().translation.vector;
    let expected_m = Vector3::new(0.08 / 3.0, 0.02, 0.1);
    assert!((centre_m - expected_m).norm() < 1e-12, "{centre_m}");
    assert!(vertices("v 1 2\n").is_err() && vertices("v 1 2 three\n").is_err());
    // The scene file takes it: the axes are principal and the centre is the origin.
    let solid = Solid::hull("a wedge", &points_m).unwrap();
    let trust = Trust {
        position_mm: 10.0,
        orientation_deg: 1.0,
        table_mm: 10.0,
    };
    let scene = impact(&solid, &trust, 0.01).expect("a scene");
    let link = &scene.links[LinkIndex(0)];
    assert_eq!(link.features.len(), 6 + 9 + 5, "corners, edges, faces");
    // Where the mesh lies on its first face its lowest point is at the origin's height.
    let lies = (Vector3::new(0.3, 0.2, 0.05), UnitQuaternion::identity());
    let lowest_m = |pose: &Pose| solid.lowest_m(&solid.world_from_body(pose));
    assert!((lowest_m(&lies) - 0.05).abs() < 1e-12);
    assert!((rest_height_m(&solid, &[lies; 5]).unwrap() - 0.05).abs() < 1e-12);
    let above = (Vector3::new(0.3, 0.2, 0.09), lies.1);
    assert!((contact_height_m(&solid, &[above, lies], 0) - 0.07).abs() < 1e-12);
    let still_turns = [lies, (lies.0, so3::exp(&(Vector3::x() * 0.2))), lies, lies];
    assert_eq!(rest_height_m(&solid, &still_turns), None);
    // The box about it has its extent.
    let about = Solid::about(&points_m);
    let text = &about.shape_toml;
    assert!(text.contains("[80.0, 60.0, 200.0]"), "{text}");
    assert!((about.lowest_m(&about.world_from_body(&lies)) - 0.05).abs() < 1e-12);
}

/// Of every first flight that is called physical, the motion comes back to the samples through the
/// filter that they went through; of every other something is said.
#[test]
fn every_first_flight_is_explained_or_named() {
    let (Some(folder), Some(tosses)) = (read::folder(), read::all().expect("files")) else {
        return skip(
            "real_objects",
            "no real tosses of objects beside the repository",
        );
    };
    assert!(tosses.len() >= 40, "{}", tosses.len());
    let shapes: Vec<[Solid; 2]> = tosses
        .iter()
        .map(|toss| solids(&folder, &toss.object).expect("a shape"))
        .collect();
    let trust = trust(&known(&tosses, &shapes), &GRAVITY_M_S2).expect("flights");
    let (mut physical, mut named) = (0, 0);
    for (toss, [solid, _]) in tosses.iter().zip(&shapes) {
        let Some(found) = cut(&toss.poses) else {
            continue;
        };
        let [first, last] = found.first;
        let part = toss.part(first, toss.poses.len() - 1);
        let count = last + 1 - first;
        let events = part.take(RATE_HZ, count, &[(count as f64 - 1.0, IMPACT)]);
        let scene = flight(solid, &trust, false).expect("a scene");
        let outcome = Pipeline::of(scene, events)
            .finish(&mut ())
            .expect("an estimate");
        let estimate = &outcome.estimate;
        if estimate.verdict != Verdict::Physical {
            assert!(!estimate.doubts.is_empty(), "{}", toss.name);
            named += 1;
            continue;
        }
        physical += 1;
        let of = checked(&outcome, solid, (&part.poses, count), filter(&toss.poses));
        // Of guessed shapes the moments are wrong, and with them the turn.
        let turned_deg = 2.0 * 3.0_f64.sqrt() * trust.orientation_deg;
        assert!(
            !solid.is_measured || of.residual.1 < turned_deg,
            "{}: {of:?}",
            toss.name
        );
        if let Some(filtered_mm) = of.filtered_mm {
            assert!(
                filtered_mm < 3.0_f64.sqrt() * trust.position_mm,
                "{}: {of:?}",
                toss.name
            );
        }
    }
    assert!(physical > 0 && named > 0, "{physical} and {named}");
}
