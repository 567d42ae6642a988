//! Previews: estimates while the performance is acted, each from the one before.

use std::path::Path;

use enact::config::scene_from_toml;
use enact::ingest::Recording;
use enact::motion::{
    Estimate, Mark, Performer, PoseSample, Scene, Stamp, TakeEvent, TrackIndex, Verdict,
};
use enact::pipeline::Preview;
use enact_tools::case::{Case, estimated};
use enact_tools::perform::{Acting, Style};
use nalgebra::Vector3;

/// Where two estimations end in one optimum, they agree to this [s, and relative].
const SAME: f64 = 1e-6;

/// Events between previews.
const STRIDE: usize = 8;

fn is_mark(event: &TakeEvent) -> bool {
    matches!(event, TakeEvent::Mark(_))
}

fn of(scene: &Scene, events: &[TakeEvent]) -> Preview {
    let mut preview = Preview::new(scene.clone());
    events.iter().for_each(|event| preview.push(event.clone()));
    preview
}

/// Marks weigh what they did when the estimation last began anew: objectives, and events [s], may
/// differ by as much.
const WEIGHED: (f64, f64) = (0.02, 0.002);

fn assert_same(a: &Estimate, b: &Estimate, at: &str) {
    assert_eq!(a.verdict, b.verdict, "{at}: {:?}; {:?}", a.reason, b.reason);
    let apart = (a.objective - b.objective).abs() / b.objective.max(1e-3);
    assert!(
        apart <= WEIGHED.0,
        "{at}: {} and {}",
        a.objective,
        b.objective
    );
    for (a, b) in a.events.iter().zip(&b.events) {
        assert!(
            (a.time_s - b.time_s).abs() <= WEIGHED.1,
            "{at}: {a:?} {b:?}"
        );
    }
    for (a, b) in a.arcs.iter().zip(&b.arcs) {
        let ends_s = [a.start_s - b.start_s, a.end_s - b.end_s];
        assert!(
            ends_s.iter().all(|s| s.abs() <= WEIGHED.1),
            "{at}: {ends_s:?}"
        );
    }
    for (a, b) in a.parameters.iter().zip(&b.parameters) {
        assert!((a.value - b.value).abs() <= 0.02, "{at}: {a:?} {b:?}");
    }
}

/// Acts a take; how many previews went on from the one before, and how many began anew. Parts of
/// a performance may have several optima, and then going on may keep another one than beginning
/// anew finds: a better one, or with `is_hard` a worse.
fn act(scene: &Scene, events: &[TakeEvent], is_hard: bool, at: &str) -> (usize, usize) {
    let mut preview = Preview::new(scene.clone());
    let (mut warm, mut cold) = (0, 0);
    for (index, event) in events.iter().enumerate() {
        preview.push(event.clone());
        let is_last = index + 1 == events.len();
        if index < 2 * STRIDE || !(is_last || is_mark(event) || index % STRIDE == 0) {
            continue;
        }
        let marks = preview.marks();
        // Too early after a mark, or before the samples that it is at.
        let Ok(Some(previewed)) = preview.estimate(&mut ()) else {
            assert!(of(scene, &events[..=index]).estimate(&mut ()).is_err());
            continue;
        };
        assert_eq!(previewed.outcome.scene.events.len(), marks, "{at}");
        warm += usize::from(previewed.is_warm);
        cold += usize::from(!previewed.is_warm);
        let mut anew = of(scene, &events[..=index]);
        let anew = anew.estimate(&mut ()).expect("as before").expect("begun");
        assert!(!anew.is_warm);
        let (here, there) = (&previewed.outcome.estimate, &anew.outcome.estimate);
        let is_better = here.objective < there.objective * (1.0 - SAME);
        if marks == scene.events.len() || !(is_hard || is_better) {
            assert_same(here, there, &format!("{at}, {marks} marks, event {index}"));
        }
    }
    let last = preview.estimate(&mut ()).expect("a take").expect("begun");
    let whole = estimated(scene, events, &mut ()).expect("a take");
    assert_same(&last.outcome.estimate, &whole.estimate, at);
    assert_eq!(last.outcome.estimate.verdict, Verdict::Physical, "{at}");
    (warm, cold)
}

#[test]
fn what_goes_on_from_the_last_answer_is_what_begins_anew() {
    for style in [Style::Tip, Style::Eraser] {
        for (acting, least_warm) in [(Acting::timing_known(), 4), (Acting::default(), 11)] {
            for seed in 1..=2 {
                let case = Case::pencil(style, &acting, seed).one_by_one();
                let at = format!("{style:?}, seed {seed}");
                let (warm, cold) = act(case.scene(), &case.performance.events, false, &at);
                assert!(warm >= least_warm && cold >= 2, "{at}: {warm}, {cold}");
            }
        }
    }
}

#[test]
fn the_whole_scene_goes_on_too_when_samples_come_late() {
    for acting in [Acting::timing_known(), Acting::default()] {
        let case = Case::pencil(Style::Tip, &acting, 4).one_by_one();
        let events = &case.performance.events;
        let (late, early): (Vec<_>, Vec<_>) = events
            .iter()
            .enumerate()
            .partition(|(index, event)| index % 4 == 1 && !is_mark(event));
        let mut preview = Preview::new(case.scene().clone());
        early
            .iter()
            .for_each(|(_, event)| preview.push((*event).clone()));
        let first = preview.estimate(&mut ()).expect("a take").expect("begun");
        assert!(!first.is_warm);
        late.iter()
            .for_each(|(_, event)| preview.push((*event).clone()));
        let last = preview.estimate(&mut ()).expect("a take").expect("begun");
        let whole = case.estimated(&mut ()).expect("a take");
        assert!(last.is_warm);
        assert_same(&last.outcome.estimate, &whole.estimate, "late samples");
        let (warm, cold) = (last.outcome.estimate.counters, whole.estimate.counters);
        assert!(warm.iterations < cold.iterations, "{warm:?} {cold:?}");
    }
}

#[test]
fn scenes_with_several_bodies_and_parameters_are_previewed() {
    let path = Path::new("recordings/hat_box.mcap");
    let recording = Recording::open(path).expect("open");
    let toml = std::str::from_utf8(recording.scene_toml().expect("scene")).expect("UTF-8");
    let mut scene = scene_from_toml(toml).expect("valid");
    scene.performer = Performer::Nobody;
    let events = recording.take(&scene).expect("take").events;
    let (warm, cold) = act(&scene, &events, true, "hat and box");
    assert!(warm > cold, "{warm}, {cold}");
}

/// What is carried at a steady pace, thrown, and lies still in a hand again.
#[test]
fn phases_are_previewed_once_they_are_over() {
    let toml = "name = \"x\"\nhand = \"none\"\n[timing]\nstamps = \"physical\"\n\
        [[body]]\nname = \"ball\"\nshape = { kind = \"sphere\", radius_mm = 30 }\nmass_g = 60\n\
        [[event]]\nname = \"go\"\nkind = \"start\"\n\
        [[event]]\nname = \"thrown\"\nkind = \"change\"\nbody = \"ball\"\n\
        [[event]]\nname = \"caught\"\nkind = \"change\"\nbody = \"ball\"\n\
        [[event]]\nname = \"end\"\nkind = \"end\"\n\
        [[phase]]\nname = \"carried\"\nmotion = \"held\"\nbody = \"ball\"\nfrom = \"go\"\nuntil = \"thrown\"\n\
        [[phase]]\nname = \"taken\"\nmotion = \"held\"\nbody = \"ball\"\nfrom = \"caught\"\nuntil = \"end\"\n";
    let scene = scene_from_toml(toml).expect("valid");
    let [thrown_s, caught_s, end_s] = [0.5, 0.9, 1.4];
    let velocity_m_s = Vector3::new(1.0, 0.2, 2.5);
    let place_m = |time_s: f64| {
        let flown_s = (time_s.min(caught_s) - thrown_s).max(0.0);
        velocity_m_s * time_s.min(caught_s) - Vector3::z() * (0.5 * 9.80665 * flown_s * flown_s)
    };
    let stamp = |time_s: f64| Stamp((time_s * 1e9).round() as i64);
    let pose = |time_s: f64| TakeEvent::Pose {
        track: TrackIndex(0),
        stream: 0,
        sample: PoseSample::new(stamp(time_s), place_m(time_s), [0.0, 0.0, 0.0, 1.0]),
    };
    let mark = |time_s: f64, name: &str| {
        TakeEvent::Mark(Mark {
            stamp: stamp(time_s),
            event: Some(name.into()),
        })
    };
    let mut events: Vec<TakeEvent> = (0..=168).map(|k| pose(f64::from(k) / 120.0)).collect();
    let marks = [
        (0.0, "go"),
        (thrown_s, "thrown"),
        (caught_s, "caught"),
        (end_s, "end"),
    ];
    events.extend(marks.map(|(time_s, name)| mark(time_s, name)));
    events.sort_by_key(TakeEvent::stamp);
    let mut preview = Preview::new(scene.clone());
    let mut told = Vec::new();
    for of in &events {
        preview.push(of.clone());
        if let Ok(Some(of)) = preview.estimate(&mut ()) {
            told.push(of.outcome.scene.events.len());
        }
    }
    told.dedup();
    let whole = preview.estimate(&mut ()).expect("a take").expect("begun");
    assert_eq!(told, [2, 3, 4]);
    let estimate = &whole.outcome.estimate;
    assert_eq!(estimate.verdict, Verdict::Physical, "{:?}", estimate.reason);
    assert_eq!((estimate.grips.len(), estimate.arcs.len()), (2, 1));
}
