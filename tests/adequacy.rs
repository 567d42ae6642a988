//! Does a motion explain its performance, and what is to blame where it does not: cubes that are
//! really thrown, with a tracker's noise and nothing else wrong but one quantity of the scene.

use enact::motion::{Fits, LinkIndex, Scene, TakeEvent, TrackIndex};
use enact::physics::{Body, contact};
use enact::pipeline::{Outcome, Pipeline};
use enact_tools::case::Case;
use enact_tools::perform::{Acting, bounces};
use nalgebra::{UnitQuaternion, Vector3};

const SEEDS: std::ops::Range<u64> = 6000..6006;

/// A cube with one or two bounces.
fn toss(seed: u64) -> (Scene, Vec<TakeEvent>) {
    let truth = bounces(1 + (seed / 2 % 2) as usize, seed).expect("a motion");
    let acting = Acting {
        distortion: 0.0,
        mark_error_s: 0.002,
        ..Acting::timing_known()
    };
    let case = Case::new(&truth, &acting, seed);
    (case.scene().clone(), case.performance.events.clone())
}

fn answered(scene: Scene, events: Vec<TakeEvent>) -> Outcome {
    let answer = Pipeline::of(scene, events).finish(&mut ());
    answer.expect("an answer")
}

/// Names of the suspects, the likeliest first.
fn suspects(outcome: &Outcome) -> Vec<String> {
    let suspects = outcome.estimate.suspects.iter();
    suspects
        .map(|suspect| outcome.given.name_of_quantity(suspect.values[0].0))
        .collect()
}

fn turn_tables(scene: &mut Scene, height_m: f64, tilt_rad: f64) {
    for surface in &mut scene.surfaces {
        if let contact::Feature::Face { point_m, normal } = surface.geometry {
            let turn = UnitQuaternion::from_scaled_axis(Vector3::x() * tilt_rad);
            surface.geometry = contact::Feature::face(point_m + normal * height_m, turn * normal);
        }
    }
}

/// In how many takes the fault's own quantity is the first suspect, and none fits well.
fn blamed(fault: impl Fn(&mut Scene, &mut Vec<TakeEvent>), quantity: &str) -> usize {
    let mut first = 0;
    for seed in SEEDS {
        let (mut scene, mut events) = toss(seed);
        fault(&mut scene, &mut events);
        let outcome = answered(scene, events);
        let fit = outcome.estimate.fit.as_ref().expect("tested");
        let named = suspects(&outcome);
        if named.first().is_some_and(|name| name.starts_with(quantity)) {
            assert_ne!(fit.fits, Fits::Yes, "{quantity} {seed}");
            first += 1;
        }
    }
    first
}

#[test]
fn a_right_scene_fits_and_nothing_is_suspected() {
    for seed in SEEDS {
        let (scene, events) = toss(seed);
        let outcome = answered(scene, events);
        let fit = outcome.estimate.fit.as_ref().expect("tested");
        assert_eq!(fit.fits, Fits::Yes, "{seed}: {fit:?}");
        assert!(outcome.estimate.suspects.is_empty(), "{seed}");
        for event in &fit.events {
            assert!(event.by_noise.statistic < 4.0, "{seed}: {event:?}");
        }
    }
}

#[test]
fn the_wrong_quantity_is_the_first_suspect() {
    let cube = LinkIndex(0);
    let moments = |scene: &mut Scene, _: &mut Vec<TakeEvent>| {
        let body = &mut scene.links[cube].body;
        *body = Body::new(body.mass_kg(), body.moments_kg_m2() * 0.5).expect("a body");
    };
    assert_eq!(blamed(moments, "cube.moment"), 6);
    let table = |scene: &mut Scene, _: &mut Vec<TakeEvent>| turn_tables(scene, 0.008, 0.0);
    assert_eq!(blamed(table, "table.height"), 6);
    let restitution = |scene: &mut Scene, _: &mut Vec<TakeEvent>| {
        for law in scene.contact_laws.iter_mut() {
            law.restitution -= 0.25;
        }
    };
    assert!(blamed(restitution, "bounce 1.restitution") >= 5);
    let tracker = |scene: &mut Scene, _: &mut Vec<TakeEvent>| {
        let mount = &mut scene.tracks[TrackIndex(0)].link_from_tracker;
        mount.translation.vector.x += 0.01;
    };
    assert!(blamed(tracker, "cube.tracker") >= 5);
    let tilt = |scene: &mut Scene, _: &mut Vec<TakeEvent>| turn_tables(scene, 0.0, 0.05);
    assert!(blamed(tilt, "table.tilt") >= 4);
}

#[test]
fn a_wrong_bounce_does_not_fit() {
    let (mut scene, events) = toss(6001);
    for law in scene.contact_laws.iter_mut() {
        law.restitution -= 0.25;
    }
    let outcome = answered(scene, events);
    let fit = outcome.estimate.fit.expect("tested");
    assert_eq!(fit.fits, Fits::No, "{fit:?}");
    assert!(fit.joint[0] > 3.0 * fit.alone[0], "{fit:?}");
}
