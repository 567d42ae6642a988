//! Marks that are off, missing, too many, or in another order than the scene's events.

use enact::motion::{EventKind, Mark, Stamp, TakeEvent};
use rand::RngExt;

use super::hit::rng;
use super::{Trouble, add_both};
use crate::case::Case;
use crate::perform::{Acting, Style, bounces};

/// Adds them.
pub fn add(all: &mut Vec<Trouble>) {
    for samples in [5, 20, 50] {
        for sign in [-1, 1] {
            let name = format!("bounce {:+} samples", sign * samples);
            add_both(all, "marks", &name, move |acting, seed| {
                let mut case = Case::pencil(Style::Tip, acting, seed);
                shift(&mut case, 0, f64::from(sign * samples) / acting.rate_hz);
                Ok(case)
            });
        }
        let name = format!("one of four bounces ±{samples} samples");
        add_both(all, "marks", &name, move |acting, seed| {
            let mut case = cube(4, acting, seed)?;
            let mut rng = rng(seed);
            let late = if rng.random::<bool>() { 1.0 } else { -1.0 };
            let mark = rng.random_range(0..4);
            shift(&mut case, mark, late * f64::from(samples) / acting.rate_hz);
            Ok(case)
        });
    }
    add_both(all, "marks", "one missing", |acting, seed| {
        let mut case = Case::pencil(Style::Tip, acting, seed);
        let mut first = true;
        let events = &mut case.performance.events;
        events.retain(|event| match event {
            TakeEvent::Mark(_) => !std::mem::take(&mut first),
            TakeEvent::Pose { .. } => true,
        });
        Ok(case)
    });
    add_both(all, "marks", "one too many", |acting, seed| {
        let mut case = Case::pencil(Style::Tip, acting, seed);
        let stamps = marks(&mut case)
            .iter()
            .map(|mark| mark.stamp.0)
            .collect::<Vec<i64>>();
        let share = rng(seed).random::<f64>();
        let extra = stamps[0] + (share * (stamps[1] - stamps[0]) as f64) as i64;
        case.performance.events.push(TakeEvent::Mark(Mark {
            stamp: Stamp(extra),
            event: None,
        }));
        Ok(case)
    });
    add_order(all);
}

fn add_order(all: &mut Vec<Trouble>) {
    add_both(all, "order", "marks named in reverse", |acting, seed| {
        let named = Acting {
            marks_named: true,
            ..*acting
        };
        let mut case = cube(4, &named, seed)?;
        let mut marks = marks(&mut case);
        let names: Vec<Option<String>> = marks.iter().map(|mark| mark.event.clone()).collect();
        for (mark, name) in marks.iter_mut().zip(names.into_iter().rev()) {
            mark.event = name;
        }
        Ok(case)
    });
    add_both(all, "order", "corners in reverse", |acting, seed| {
        let mut case = cube(4, acting, seed)?;
        let events = &mut case.performance.truth.scene.events;
        let kinds: Vec<EventKind> = events[..4].iter().map(|e| e.kind.clone()).collect();
        for (event, kind) in events[..4].iter_mut().zip(kinds.into_iter().rev()) {
            event.kind = kind;
        }
        Ok(case)
    });
    add_both(all, "order", "the pencil's other end", |acting, seed| {
        let mut case = Case::pencil(Style::Tip, acting, seed);
        let scene = &mut case.performance.truth.scene;
        if let EventKind::Collision(collision) = &mut scene.events[0].kind {
            let touching = &mut collision.contacts[0];
            touching.feature = touching.feature.map(|feature| 1 - feature);
        }
        Ok(case)
    });
}

/// A cube's bounces.
pub fn cube(count: usize, acting: &Acting, seed: u64) -> Result<Case, String> {
    let truth = bounces(count, seed).map_err(|error| error.to_string())?;
    Ok(Case::new(&truth, acting, seed))
}

/// The marks, in the order in which the performer made them.
fn marks(case: &mut Case) -> Vec<&mut Mark> {
    let events = case.performance.events.iter_mut();
    let mut marks: Vec<&mut Mark> = events
        .filter_map(|event| match event {
            TakeEvent::Mark(mark) => Some(mark),
            TakeEvent::Pose { .. } => None,
        })
        .collect();
    marks.sort_by_key(|mark| mark.stamp);
    marks
}

/// Moves a mark.
fn shift(case: &mut Case, index: usize, by_s: f64) {
    marks(case)[index].stamp.0 += (by_s * 1e9).round() as i64;
}
