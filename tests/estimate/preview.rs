//! Previews: estimates while the performance is acted, each from the one before.

use std::path::Path;

use enact::config::scene_from_toml;
use enact::ingest::Recording;
use enact::motion::{Estimate, Performer, Scene, TakeEvent, Verdict};
use enact::pipeline::Preview;
use enact_tools::case::{Case, estimated};
use enact_tools::perform::{Acting, Style};

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
