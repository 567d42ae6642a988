//! Takes of a few poses, at random: an estimate or an error that says why, as in the first moments of
//! every take that is estimated while it is acted.

use enact::config::scene_from_toml;
use enact::math::Pose;
use enact::motion::{Mark, PoseSample, Scene, Stamp, TakeEvent, TrackIndex};
use enact::pipeline::{Pipeline, Preview};
use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Two bodies whose times are physical, with so many collisions of the first with a table.
fn scene(collisions: usize) -> Scene {
    let mut text = "name = \"few\"\n[timing]\nstamps = \"physical\"\n".to_owned();
    for name in ["thing", "other"] {
        text += &format!(
            "[[body]]\nname = \"{name}\"\nmass_g = 200\n\
             shape = {{ kind = \"cuboid\", size_mm = [120, 70, 30] }}\n\
             features_mm = {{ corner = [60, 35, 15] }}\n"
        );
    }
    text += "[[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n";
    for number in 0..collisions {
        text += &format!(
            "[[event]]\nname = \"hit {number}\"\nkind = \"collision\"\nbody = \"thing\"\n\
             feature = \"corner\"\nsurface = \"table\"\nrestitution = 0.5\n"
        );
    }
    scene_from_toml(&text).unwrap()
}

fn pose(track: usize, time_s: f64, random: &mut ChaCha8Rng) -> TakeEvent {
    let mut place = || random.random_range(-1.0..1.0);
    let place_m = Vector3::new(place(), place(), place());
    let turn = UnitQuaternion::from_scaled_axis(3.0 * Vector3::new(place(), place(), place()));
    let stamp = Stamp((1e9 * time_s) as i64);
    TakeEvent::Pose {
        track: TrackIndex(track),
        stream: 0,
        sample: PoseSample::from_pose(stamp, &Pose::from_parts(place_m.into(), turn)),
    }
}

#[test]
fn one_pose_of_each_body_is_an_estimate() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let events = [0, 1].map(|track| pose(track, 0.0, &mut random));
    let mut preview = Preview::new(scene(0));
    for event in &events {
        preview.push(event.clone());
    }
    let previewed = preview.estimate(&mut ()).expect("an estimate so far");
    assert!(previewed.is_some());
    let outcome = Pipeline::of(scene(0), events).finish(&mut ());
    let outcome = outcome.expect("an estimate");
    // Nothing says how fast they were.
    assert!(!outcome.estimate.undetermined.is_empty());
}

#[test]
fn a_few_poses_anywhere_are_an_estimate_or_an_error() {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let (mut estimated, mut refused) = (0, 0);
    // The search for a motion through nonsense takes seconds for each collision.
    for (collisions, takes) in [(0, 20), (1, 3)] {
        for _ in 0..takes {
            let mut events = Vec::new();
            for flight in 0..=collisions {
                let begun_s = 0.5 * flight as f64;
                // The first body has at least one pose before its first collision.
                let least = usize::from(flight == 0);
                for number in 0..random.random_range(least..4) {
                    events.push(pose(0, begun_s + 0.1 * number as f64, &mut random));
                }
                for number in 0..random.random_range(least..3) {
                    events.push(pose(1, begun_s + 0.15 * number as f64, &mut random));
                }
                if flight < collisions {
                    let stamp = Stamp((1e9 * (begun_s + 0.45)) as i64);
                    events.push(TakeEvent::Mark(Mark { stamp, event: None }));
                }
            }
            match Pipeline::of(scene(collisions), events).estimate(&mut ()) {
                Ok(_) => estimated += 1,
                Err(error) => {
                    assert!(!error.to_string().is_empty());
                    refused += 1;
                }
            }
        }
    }
    assert!(estimated > 0, "{estimated} estimated, {refused} refused");
}
