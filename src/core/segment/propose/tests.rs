use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;
use typed_index_collections::TiVec;

use super::*;
use crate::math::Pose;
use crate::motion::{
    ContactLaw, ContactLawIndex, Event, EventKind, FreeBody, LinkIndex, Performer, Stamp, Surface,
    Timing, VelocityGaps, Weights,
};
use crate::physics::Shape;
use crate::segment::{refine, relocate_marks};

/// A ball that bounces so many times on a table.
fn scene(bounces: usize, timing: Timing) -> Scene {
    let shape = Shape::Sphere { radius_m: 0.02 };
    let mut scene = Scene {
        name: "ball".into(),
        gravity_m_s2: Vector3::new(0.0, 0.0, -10.0),
        timing,
        mark_sd_s: None,
        marks_topic: "/marks".into(),
        links: TiVec::new(),
        mechanisms: TiVec::new(),
        tracks: TiVec::new(),
        surfaces: vec![Surface {
            name: "table".into(),
            geometry: Feature::face(Vector3::zeros(), Vector3::z()),
            obstacle: None,
        }],
        obstacles: Vec::new(),
        phases: Vec::new(),
        contact_laws: TiVec::from(vec![ContactLaw::frictionless("table", 1.0)]),
        events: (0..bounces)
            .map(|k| {
                let bounce = Collision::bounce(LinkIndex(0), 0, 0, ContactLawIndex(0));
                Event::new(format!("bounce {k}"), EventKind::Collision(bounce))
            })
            .collect(),
        goals: Vec::new(),
        parameters: Vec::new(),
        cones: Vec::new(),
        velocity_gaps: VelocityGaps::WhenNeeded,
        settle_s: None,
        rest_goals: Vec::new(),
        weights: Weights {
            position_m: 0.01,
            orientation_rad: 0.1,
        },
        performer: Performer::Unsaid,
        tolerance_m: Scene::TOLERANCE_M,
    };
    scene.add(FreeBody {
        name: "ball".into(),
        topic: "/ball".into(),
        body: shape.body_of_mass_kg(0.1).unwrap(),
        shape,
        body_from_tracker: Pose::identity(),
        features: vec![crate::motion::Feature {
            name: "south".into(),
            geometry: Feature::corner(Vector3::new(0.0, 0.0, -0.02)),
        }],
    });
    scene
}

fn sketch(samples: Vec<Sample>, bounces: usize) -> Sketch {
    Sketch {
        origin: Stamp(0),
        tracks: [TrackSketch::new(samples)].into_iter().collect(),
        marks_s: vec![0.0; bounces],
        contacts_s: Default::default(),
        cuts_sd_s: Default::default(),
        marks: vec![None; bounces],
    }
}

fn sample(acted_s: f64, position_m: Vector3<f64>, turn: Vector3<f64>) -> Sample {
    Sample::of_pose(
        Stamp((acted_s * 1e9) as i64),
        acted_s,
        position_m,
        UnitQuaternion::from_scaled_axis(turn),
    )
}

/// Dropped from 0.47 m, up and down every 0.6 s without loss, at 100 Hz; first down at 0.3 s.
fn bouncing(count: usize) -> Vec<Sample> {
    (0..count)
        .map(|i| {
            let s = 0.01 * i as f64;
            let phase = (s + 0.3) % 0.6;
            let height_m = 0.02 + 0.5 * 10.0 * phase * (0.6 - phase);
            sample(s, Vector3::new(0.1 * s, 0.0, height_m), Vector3::zeros())
        })
        .collect()
}

const UNKNOWN: Timing = Timing::Unknown {
    tempo_sd_per_sqrt_s: 0.5,
};

#[test]
fn bounces_are_found_and_stand_out() {
    for timing in [Timing::Known, UNKNOWN] {
        let proposals = propose(&scene(3, timing), &sketch(bouncing(180), 3), None);
        assert_eq!(proposals.len(), 3);
        for (k, proposal) in proposals.iter().enumerate() {
            let true_s = 0.3 + 0.6 * k as f64;
            assert!((proposal.acted_s - true_s).abs() <= 0.01, "{proposals:?}");
            assert_eq!((proposal.event, proposal.track), (Some(k), TrackIndex(0)));
            assert!(proposal.score > 100.0, "{proposals:?}");
        }
    }
}

#[test]
fn more_cuts_than_bounces_do_not_stand_out() {
    // A little unevenness, for clean data have nothing to compare with.
    let mut samples = bouncing(180);
    for (i, sample) in samples.iter_mut().enumerate() {
        if let Seen::Pose { position_m, .. } = &mut sample.seen {
            position_m.y += 1e-3 * (0.35 * i as f64).sin();
        }
    }
    let proposals = propose(&scene(3, Timing::Known), &sketch(samples, 3), Some(4));
    let mut scores: Vec<f64> = proposals.iter().map(|p| p.score).collect();
    scores.sort_by(f64::total_cmp);
    assert!(scores[0] < 10.0 && scores[1] > 100.0, "{scores:?}");
}

/// Some samples of a flight with a millimetre of noise that is the same every time; after `hit`, where
/// there is one, it flies up.
fn short(count: usize, hit: Option<usize>, bend_m: f64) -> Vec<Sample> {
    (0..count)
        .map(|i| {
            let since = |from: usize| 0.02 * (i as f64 - from as f64 + 0.5);
            let (s, up) = match hit {
                Some(hit) if i >= hit => (since(hit), 1.5),
                Some(hit) => (since(hit), -2.0),
                None => (since(count / 2), -2.0),
            };
            let along = (i as f64 / count as f64 - 0.5) * 2.0;
            let noise = Vector3::new(
                1e-3 * (12.9 * i as f64).sin(),
                1e-3 * (78.2 * i as f64).sin() + bend_m * along.powi(3),
                1e-3 * (37.7 * i as f64).sin(),
            );
            let place_m = Vector3::new(0.3 * s, 0.0, 0.02 + up * s - 5.0 * s * s);
            sample(0.02 * i as f64, place_m + noise, Vector3::zeros())
        })
        .collect()
}

#[test]
fn flights_too_short_for_a_superfluous_cut_are_judged_by_a_smooth_bend() {
    // Nothing touches, so that only the path tells.
    let mut scene = scene(1, Timing::Known);
    scene.surfaces.clear();
    for event in &mut scene.events {
        if let EventKind::Collision(collision) = &mut event.kind {
            collision.contacts.clear();
        }
    }
    let proposed = |samples: Vec<Sample>| propose(&scene, &sketch(samples, 1), None)[0];
    for (before, after) in [(5, 5), (5, 12), (12, 5), (8, 9), (12, 12)] {
        let hit = proposed(short(before + after, Some(before), 0.0));
        let off = hit.acted_s / 0.02 + 0.5 - before as f64;
        assert!(off.abs() <= 1.0, "{before} and {after}: {hit:?}");
        assert!(hit.score >= CLEAR_SCORE, "{before} and {after}: {hit:?}");
        // A flight, and one through which a hand wanders.
        for bend_m in [0.0, 0.02] {
            let none = proposed(short(before + after, None, bend_m));
            assert!(none.score < 1.0, "{before} and {after}, {bend_m}: {none:?}");
        }
    }
}

#[test]
fn marks_far_off_are_relocated() {
    let scene = scene(3, Timing::Known);
    let mut sketch = sketch(bouncing(180), 3);
    sketch.marks_s = vec![0.55, 0.7, 1.1];
    refine(&scene, &mut sketch);
    assert_eq!(relocate_marks(&scene, &mut sketch), [0, 1, 2]);
    for (mark_s, true_s) in sketch.marks_s.iter().zip([0.3, 0.9, 1.5]) {
        assert!((mark_s - true_s).abs() <= 0.01, "{:?}", sketch.marks_s);
    }
    assert!(relocate_marks(&scene, &mut sketch).is_empty());
}

/// Held for 0.4 s, dropped, and at rest from 0.305 s later on, at 100 Hz with a tenth of a millimetre of noise.
fn dropped() -> Vec<Sample> {
    (0..150)
        .map(|i| {
            let fallen_s = 0.01 * f64::from(i - 40);
            let fallen_m = match fallen_s {
                of if of <= 0.0 => 0.0,
                of if of >= 0.305 => 5.0 * 0.305 * 0.305,
                of => 5.0 * of * of,
            };
            let noise = |pace: f64| 1e-4 * (pace * f64::from(i)).sin();
            let place_m = Vector3::new(noise(12.9), noise(78.2), 0.5 - fallen_m + noise(37.7));
            sample(0.01 * f64::from(i), place_m, Vector3::zeros())
        })
        .collect()
}

#[test]
fn a_toss_that_rests_after_its_impact_ends_six_samples_later() {
    let ends_s = ends_of_motion_s(&scene(1, Timing::Known), &sketch(dropped(), 1));
    let [begin_s, end_s] = ends_s.expect("samples");
    assert!((begin_s - 0.4).abs() < 0.025, "{begin_s}");
    // The first sample past the impact is that at 0.71 s.
    assert!((end_s - 0.77).abs() < 1e-9, "{end_s}");
}

#[test]
fn what_does_not_fit_is_not_proposed() {
    assert!(propose(&scene(3, UNKNOWN), &sketch(bouncing(19), 3), None).is_empty());
    let long = sketch(bouncing(1000), 0);
    assert!(propose(&scene(0, UNKNOWN), &long, Some(CUTS_MAX + 1)).is_empty());
    assert!(propose(&scene(0, UNKNOWN), &long, None).is_empty());
    let none = sketch(Vec::new(), 1);
    assert!(propose(&scene(1, UNKNOWN), &none, None).is_empty());
}

proptest! {
    #[test]
    fn any_stream_gives_proposals_in_order(
        readings in prop::collection::vec(
            (1e-4..0.05, prop::array::uniform3(-1.0..1.0), prop::array::uniform3(-3.0..3.0)),
            0..90,
        ),
        bounces in 0_usize..5,
        is_known in any::<bool>(),
        scale in prop::sample::select(vec![0.0, 1e-6, 1.0, 1e4]),
        marks in prop::collection::vec(-0.5..3.0, 5),
    ) {
        let mut acted_s = 0.0;
        let samples: Vec<Sample> = readings
            .into_iter()
            .map(|(step_s, position, turn): (f64, [f64; 3], [f64; 3])| {
                acted_s += step_s;
                sample(acted_s, Vector3::from(position) * scale, Vector3::from(turn))
            })
            .collect();
        let scene = scene(bounces, if is_known { Timing::Known } else { UNKNOWN });
        let mut sketch = sketch(samples, bounces);
        let proposals = propose(&scene, &sketch, None);
        prop_assert!(proposals.is_empty() || proposals.len() == bounces);
        for pair in proposals.windows(2) {
            prop_assert!(pair[0].acted_s < pair[1].acted_s);
        }
        for proposal in &proposals {
            prop_assert!((0.0..=SCORE_MAX).contains(&proposal.score), "{proposal:?}");
        }
        sketch.marks_s.copy_from_slice(&marks[..bounces]);
        relocate_marks(&scene, &mut sketch);
        prop_assert!(sketch.marks_s.iter().all(|mark_s| mark_s.is_finite()));
    }
}
