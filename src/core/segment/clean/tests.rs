use nalgebra::{Translation3, Vector3};
use proptest::prelude::*;

use super::*;
use crate::math::Pose;
use crate::motion::{
    Collision, ContactLaw, ContactLawIndex, Event, Feature, FreeBody, LinkIndex, Performer,
    PoseSample, Surface, Timing, VelocityGaps, Weights,
};
use crate::physics::{Shape, contact};

const START: i64 = 1_700_000_000_000_000_000;
const STEP: i64 = 10_000_000;

/// Two balls; release, bounce of the first, landing.
fn scene() -> Scene {
    let ball = |name: &str, body_from_tracker: Pose| {
        let shape = Shape::Sphere { radius_m: 0.02 };
        FreeBody {
            name: name.into(),
            topic: format!("/tracker/{name}/pose"),
            body: shape.body_of_mass_kg(0.1).unwrap(),
            shape,
            body_from_tracker,
            features: vec![Feature {
                name: "south".into(),
                geometry: contact::Feature::corner(Vector3::new(0.0, 0.0, -0.02)),
            }],
        }
    };
    let event = |name: &str, kind: EventKind| Event::new(name, kind);
    let mount = Pose::from_parts(
        Translation3::new(0.0, 0.0, 0.03),
        UnitQuaternion::from_scaled_axis(Vector3::new(0.3, 0.0, 0.0)),
    );
    let mut scene = Scene {
        name: "balls".into(),
        gravity_m_s2: Vector3::new(0.0, 0.0, -9.81),
        timing: Timing::Known,
        mark_sd_s: None,
        marks_topic: "/marks".into(),
        links: TiVec::new(),
        mechanisms: TiVec::new(),
        tracks: TiVec::new(),
        surfaces: vec![Surface {
            name: "table".into(),
            geometry: contact::Feature::face(Vector3::zeros(), Vector3::z()),
            obstacle: None,
        }],
        obstacles: vec![],
        phases: Vec::new(),
        contact_laws: TiVec::from(vec![ContactLaw::frictionless("bounce", 0.5)]),
        events: vec![
            event("release", EventKind::Start),
            event(
                "bounce",
                EventKind::Collision(Collision::bounce(LinkIndex(0), 0, 0, ContactLawIndex(0))),
            ),
            event("landing", EventKind::End),
        ],
        goals: vec![],
        parameters: vec![],
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
    scene.add(ball("red", mount));
    scene.add(ball("blue", Pose::identity()));
    scene
}

/// Orientations of two samples.
fn turns(pair: &[Sample]) -> [UnitQuaternion<f64>; 2] {
    [0, 1].map(|at| pair[at].seen.orientation().expect("a pose"))
}

fn body_pose(index: i64) -> Pose {
    let t = index as f64;
    Pose::from_parts(
        Translation3::new(0.01 * t, 0.3, 1.0 - 0.002 * t),
        UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.11 * t, 0.02)),
    )
}

fn sample(scene: &Scene, track: TrackIndex, index: i64) -> PoseSample {
    let world_from_tracker = body_pose(index) * scene.tracks[track].link_from_tracker;
    PoseSample::from_pose(Stamp(START + index * STEP), &world_from_tracker)
}

fn mark(index: f64, event: Option<&str>) -> TakeEvent {
    TakeEvent::Mark(Mark {
        stamp: Stamp(START + (index * STEP as f64) as i64),
        event: event.map(str::to_owned),
    })
}

/// 40 samples of each track and three marks without names, at 5, 20 and 35 samples.
fn take(scene: &Scene) -> Vec<TakeEvent> {
    let mut take = Vec::new();
    for index in 0..40 {
        for track in scene.tracks.keys() {
            take.push(TakeEvent::Pose {
                track,
                stream: 0,
                sample: sample(scene, track, index),
            });
        }
    }
    take.extend([5.0, 20.0, 35.0].map(|index| mark(index, None)));
    take
}

/// Replaces the reading of a track at an index.
fn change(take: &mut [TakeEvent], track: TrackIndex, index: i64, change: impl Fn(&mut PoseSample)) {
    let stamp = Stamp(START + index * STEP);
    for event in take {
        if let TakeEvent::Pose {
            track: of,
            stream: 0,
            sample,
        } = event
            && *of == track
            && sample.stamp == stamp
        {
            change(sample);
        }
    }
}

fn failure(take: &[TakeEvent]) -> SegmentError {
    clean(&scene(), take).expect_err("accepted")
}

#[test]
fn starts_and_ends_that_the_recorder_missed_are_its_first_and_last_sample() {
    let scene = scene();
    let with = |marks: [f64; 3]| {
        let mut take = take(&scene);
        take.retain(|event| matches!(event, TakeEvent::Pose { .. }));
        take.extend(marks.map(|index| mark(index, None)));
        clean(&scene, &take)
    };
    // The last sample is the 39th, 10 ms apart; marks may be 67 ms off.
    let (sketch, counts) = with([-6.0, 20.0, 45.5]).unwrap();
    assert_eq!(sketch.marks_s, [0.0, 0.2, 0.39]);
    assert_eq!(counts.marks.late, [0, 2]);
    // A sample or two may be missing.
    let (sketch, counts) = with([0.0, 20.0, 41.0]).unwrap();
    assert!((sketch.marks_s[2] - 0.41).abs() < 1e-12);
    assert!(counts.marks.late.is_empty());
    for marks in [[0.0, 20.0, 46.0], [-7.0, 20.0, 39.0], [0.0, 41.0, 45.0]] {
        let error = with(marks).expect_err("accepted");
        let outside = matches!(error, SegmentError::MarkOutsideData { .. });
        assert!(outside, "{marks:?}: {error}");
    }
}

#[test]
fn a_clean_take_is_cut_to_start_and_end_and_moved_to_the_body() {
    let scene = scene();
    let (sketch, counts) = clean(&scene, &take(&scene)).unwrap();
    assert_eq!(sketch.origin, Stamp(START + 5 * STEP));
    for track in &sketch.tracks {
        assert_eq!(track.samples.len(), 31);
        for (index, sample) in track.samples.iter().enumerate() {
            let expected = body_pose(index as i64 + 5);
            assert!(
                (sample.seen.position_m().unwrap() - expected.translation.vector).norm() < 1e-15
            );
            assert!(
                sample
                    .seen
                    .orientation()
                    .unwrap()
                    .angle_to(&expected.rotation)
                    < 1e-7
            );
            assert!((sample.acted_s - 0.01 * index as f64).abs() < 1e-15);
        }
    }
    for (mark_s, expected) in sketch.marks_s.iter().zip([0.0, 0.15, 0.3]) {
        assert!((mark_s - expected).abs() < 1e-15);
    }
    assert_eq!((counts.read, counts.used), (80, 62));
    assert_eq!(
        counts.dropped,
        [(DropReason::BeforeStart, 10), (DropReason::AfterEnd, 8)].into()
    );
    assert_eq!(
        (
            counts.reordered,
            counts.normalised,
            counts.flipped,
            counts.gaps
        ),
        (0, 0, 0, 0)
    );
}

#[test]
fn each_fault_is_dropped_once_and_counted() {
    let scene = scene();
    let mut take = take(&scene);
    change(&mut take, TrackIndex(0), 8, |s| s.position_m.y = f64::NAN);
    change(&mut take, TrackIndex(0), 9, |s| {
        s.quaternion_xyzw[0] = f64::INFINITY
    });
    change(&mut take, TrackIndex(0), 10, |s| {
        s.quaternion_xyzw = s.quaternion_xyzw.map(|x| x * 1.2)
    });
    change(&mut take, TrackIndex(1), 11, |s| {
        s.quaternion_xyzw = [0.0; 4]
    });
    change(&mut take, TrackIndex(1), 12, |s| {
        s.quaternion_xyzw = [1e300; 4]
    });
    change(&mut take, TrackIndex(1), 14, |s| {
        s.quaternion_xyzw = s.quaternion_xyzw.map(|x| x * 1.005)
    });
    let still = sample(&scene, TrackIndex(1), 15);
    for index in [16, 17] {
        change(&mut take, TrackIndex(1), index, |s| {
            s.position_m = still.position_m;
            s.quaternion_xyzw = still.quaternion_xyzw;
        });
    }
    take.push(TakeEvent::Pose {
        track: TrackIndex(0),
        stream: 0,
        sample: sample(&scene, TrackIndex(0), 30),
    });
    let (sketch, counts) = clean(&scene, &take).unwrap();
    assert_eq!(
        counts.dropped,
        [
            (DropReason::NotFinite, 2),
            (DropReason::NotUnit, 3),
            (DropReason::Duplicate, 1),
            (DropReason::Frozen, 2),
            (DropReason::BeforeStart, 10),
            (DropReason::AfterEnd, 8),
        ]
        .into()
    );
    assert_eq!(counts.normalised, 1);
    assert_eq!(counts.reordered, 1);
    // Three samples missing in a row make a gap; two frozen ones and two broken ones too.
    assert_eq!(counts.gaps, 3);
    assert_eq!(counts.read, 81);
    assert_eq!(counts.used + counts.dropped.values().sum::<usize>(), 81);
    let samples = sketch.tracks.iter().flat_map(|b| &b.samples);
    for sample in samples {
        assert!((sample.seen.orientation().unwrap().coords.norm() - 1.0).abs() < 1e-15);
    }
}

/// Readings count as late after any later one, not only after their predecessor.
#[test]
fn all_that_come_late_are_counted() {
    let scene = scene();
    let mut take = take(&scene);
    let of_red: Vec<usize> = (0..take.len())
        .filter(|at| {
            matches!(
                take[*at],
                TakeEvent::Pose {
                    track: TrackIndex(0),
                    ..
                }
            )
        })
        .collect();
    let early = take.remove(of_red[13]);
    take.insert(of_red[10], early);
    let (_, counts) = clean(&scene, &take).unwrap();
    assert_eq!(counts.reordered, 3);
}

#[test]
fn signs_are_made_continuous() {
    let scene = scene();
    let mut take = take(&scene);
    for index in 20..23 {
        change(&mut take, TrackIndex(1), index, |s| {
            s.quaternion_xyzw = s.quaternion_xyzw.map(|x| -x)
        });
    }
    let (sketch, counts) = clean(&scene, &take).unwrap();
    assert_eq!(counts.flipped, 3);
    for track in &sketch.tracks {
        for pair in track.samples.windows(2) {
            assert!(turns(pair)[0].coords.dot(&turns(pair)[1].coords) > 0.9);
        }
    }
}

#[test]
fn named_marks_go_to_their_events_and_others_to_what_is_left() {
    let scene = scene();
    let mut take: Vec<TakeEvent> = take(&scene)
        .into_iter()
        .filter(|event| matches!(event, TakeEvent::Pose { .. }))
        .collect();
    take.extend([
        mark(30.0, None),
        mark(12.5, Some("bounce")),
        mark(3.0, None),
    ]);
    let (sketch, _) = clean(&scene, &take).unwrap();
    assert_eq!(sketch.origin, Stamp(START + 3 * STEP));
    for (mark_s, expected) in sketch.marks_s.iter().zip([0.0, 0.095, 0.27]) {
        assert!((mark_s - expected).abs() < 1e-12, "{mark_s}");
    }
}

#[test]
fn marks_that_do_not_fit_the_events_are_refused_by_name() {
    let scene = scene();
    let poses: Vec<TakeEvent> = take(&scene)
        .into_iter()
        .filter(|event| matches!(event, TakeEvent::Pose { .. }))
        .collect();
    let cases: [(&[TakeEvent], &str); 9] = [
        (
            &[],
            "0 marks, expected 3: \"release\", \"bounce\", \"landing\"",
        ),
        (
            &[mark(5.0, None), mark(20.0, Some("bounce"))],
            "2 marks, expected 3: \"release\", \"bounce\", \"landing\"; no mark names \"release\", \"landing\"",
        ),
        (
            &[5.0, 10.0, 20.0, 35.0].map(|i| mark(i, None)),
            "4 marks, expected 3: \"release\", \"bounce\", \"landing\"",
        ),
        (
            &[mark(5.0, None), mark(20.0, Some("bonce")), mark(35.0, None)],
            "a mark at 0.200 s is for \"bonce\", expected one of \"release\", \"bounce\", \"landing\"",
        ),
        (
            &[
                mark(5.0, Some("bounce")),
                mark(20.0, Some("bounce")),
                mark(35.0, None),
            ],
            "two marks for \"bounce\", at 0.050 s and 0.200 s, expected one",
        ),
        (
            &[
                mark(20.0, Some("release")),
                mark(5.0, Some("bounce")),
                mark(35.0, None),
            ],
            "the mark of \"bounce\" is at 0.050 s, expected after that of \"release\" at 0.200 s",
        ),
        (
            &[5.0, 20.0, 47.0].map(|i| mark(i, None)),
            "the mark of \"landing\" is at 0.470 s, outside the data: expected 0.000 to 0.390 s",
        ),
        (
            &[-300.0, 20.0, 35.0].map(|i| mark(i, None)),
            "the mark of \"release\" is at -3.000 s, outside the data: expected 0.000 to 0.390 s",
        ),
        (
            &[5.0, 39.5, 40.5].map(|i| mark(i, None)),
            "the mark of \"bounce\" is at 0.395 s, outside the data: expected 0.000 to 0.390 s",
        ),
    ];
    for (marks, message) in cases {
        let take = [&poses, marks].concat();
        let error = failure(&take).to_string();
        // Where counts differ, what the stream suggests comes after it.
        let (said, suggested) = error
            .split_once("; the stream suggests")
            .unwrap_or((&error, ""));
        assert_eq!(said, message);
        assert_eq!(!suggested.is_empty(), message.contains("marks, expected"));
    }
}

#[test]
fn an_end_just_after_the_last_sample_is_in_the_data() {
    let scene = scene();
    let mut take = take(&scene);
    take.pop();
    take.push(mark(40.0, None));
    let (_, counts) = clean(&scene, &take).unwrap();
    assert_eq!(counts.dropped.get(&DropReason::AfterEnd), None);
}

#[test]
fn what_has_no_samples_is_refused() {
    let scene = scene();
    let marks: Vec<TakeEvent> = take(&scene).split_off(80);
    assert_eq!(
        failure(&marks).to_string(),
        "the take has no samples, expected poses on \"/tracker/red/pose\", \"/tracker/blue/pose\""
    );
    let red_only: Vec<TakeEvent> = take(&scene)
        .into_iter()
        .filter(|event| {
            !matches!(
                event,
                TakeEvent::Pose {
                    track: TrackIndex(1),
                    ..
                }
            )
        })
        .collect();
    assert_eq!(
        failure(&red_only).to_string(),
        "body \"blue\" has no usable samples on \"/tracker/blue/pose\": 0 read"
    );
    let mut broken = take(&scene);
    for index in 0..40 {
        change(&mut broken, TrackIndex(1), index, |s| {
            s.position_m.x = f64::NAN
        });
    }
    assert_eq!(
        failure(&broken).to_string(),
        "body \"blue\" has no usable samples on \"/tracker/blue/pose\": 40 read, 40 with a number that is not finite"
    );
    let mut early = take(&scene);
    early.retain(|event| {
        !matches!(event, TakeEvent::Pose { track: TrackIndex(1), stream: 0, sample } if sample.stamp.0 > START + 4 * STEP)
    });
    assert_eq!(
        failure(&early).to_string(),
        "body \"blue\" has no usable samples on \"/tracker/blue/pose\": 5 read, 5 before the mark of the start"
    );
}

#[test]
fn stamps_of_two_clocks_and_bodies_out_of_range_are_refused() {
    let scene = scene();
    let mut clocks = take(&scene);
    change(&mut clocks, TrackIndex(0), 0, |s| s.stamp = Stamp(i64::MIN));
    change(&mut clocks, TrackIndex(0), 1, |s| s.stamp = Stamp(i64::MAX));
    assert!(matches!(failure(&clocks), SegmentError::Span { .. }));
    let mut third = take(&scene);
    third.push(TakeEvent::Pose {
        track: TrackIndex(2),
        stream: 0,
        sample: sample(&scene, TrackIndex(0), 3),
    });
    assert_eq!(
        failure(&third),
        SegmentError::NoSuchTrack {
            track: 2,
            tracks: 2
        }
    );
    let mut far = take(&scene);
    far.pop();
    far.push(TakeEvent::Mark(Mark {
        stamp: Stamp(i64::MAX),
        event: None,
    }));
    assert!(matches!(
        failure(&far),
        SegmentError::MarkOutsideData { .. }
    ));
}

/// Readings as they may come: repeats, broken numbers, any sign.
fn any_reading() -> impl Strategy<Value = TakeEvent> {
    let number = prop_oneof![
        9 => -1.0..1.0_f64,
        1 => prop_oneof![Just(f64::NAN), Just(f64::INFINITY), any::<f64>()],
    ];
    (
        0_usize..2,
        0_i64..40,
        prop::array::uniform3(number),
        prop_oneof![
            8 => prop::array::uniform4(-1.0..1.0_f64).prop_map(|q| {
                let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
                q.map(|x| x / norm)
            }),
            1 => Just([0.0, 0.0, 0.0, 1.0]),
            1 => prop::array::uniform4(any::<f64>()),
        ],
    )
        .prop_map(
            |(track, index, position, quaternion_xyzw)| TakeEvent::Pose {
                track: TrackIndex(track),
                stream: 0,
                sample: PoseSample::new(
                    Stamp(START + index * STEP),
                    Vector3::from(position),
                    quaternion_xyzw,
                ),
            },
        )
}

proptest! {
    #[test]
    fn the_sketch_does_not_depend_on_the_order_of_arrival(
        (take, shuffled) in prop::collection::vec(any_reading(), 0..120)
            .prop_map(|mut readings| {
                readings.extend([5.0, 20.0, 35.0].map(|index| mark(index, None)));
                readings
            })
            .prop_flat_map(|take| (Just(take.clone()), Just(take).prop_shuffle()))
    ) {
        let scene = scene();
        match (clean(&scene, &take), clean(&scene, &shuffled)) {
            (Ok((one, mut counts)), Ok((other, mut others))) => {
                prop_assert_eq!(one, other);
                prop_assert_eq!(
                    counts.read,
                    counts.used + counts.dropped.values().sum::<usize>()
                );
                counts.reordered = 0;
                others.reordered = 0;
                prop_assert_eq!(counts, others);
            }
            (Err(one), Err(other)) => prop_assert_eq!(one, other),
            (one, other) => prop_assert!(false, "{:?} against {:?}", one, other),
        }
    }

    #[test]
    fn kept_samples_are_poses_in_order(
        readings in prop::collection::vec(any_reading(), 20..120)
    ) {
        let mut take = readings;
        take.extend([2.0, 20.0, 37.0].map(|index| mark(index, None)));
        if let Ok((sketch, _)) = clean(&scene(), &take) {
            for track in &sketch.tracks {
                for pair in track.samples.windows(2) {
                    prop_assert!(pair[0].stamp < pair[1].stamp);
                    prop_assert!(pair[0].acted_s < pair[1].acted_s);
                    prop_assert!(
                        turns(pair)[0].coords.dot(&turns(pair)[1].coords) >= 0.0
                    );
                }
                for sample in &track.samples {
                    prop_assert!((sample.seen.orientation().unwrap().coords.norm() - 1.0).abs() < 1e-12);
                    prop_assert!(sample.acted_s >= 0.0 && sample.acted_s <= 0.35 + 1e-9);
                }
            }
        }
    }
}
