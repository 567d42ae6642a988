//! The quantity that a name means, and refusals of what no performance tells.

use std::ops::Range;

use super::error::{Fault, fault};
use super::keys::nearest;
use crate::motion::{Quantity, Scene};

/// The quantity with a name, if a performance can tell it.
pub(super) fn named(name: &str, span: Range<usize>, scene: &Scene) -> Result<Quantity, Fault> {
    let all = scene.quantities().into_iter();
    let mut found = all.filter(|quantity| scene.name_of_quantity(*quantity) == name);
    let Some(quantity) = found.next() else {
        return unknown(name, span, scene);
    };
    if found.next().is_some() {
        return fault(
            span,
            format!("{name:?} means two quantities, expected different names of their parts"),
        );
    }
    match scene.untold(quantity) {
        None => Ok(quantity),
        Some(why) => fault(span, format!("{name} cannot be free: {why}")),
    }
}

fn unknown(name: &str, span: Range<usize>, scene: &Scene) -> Result<Quantity, Fault> {
    // A moment that equals one before it has no name of its own.
    for (link, of) in scene.links.iter_enumerated() {
        for axis in 0..3 {
            let first = of.moment_axis(axis);
            let name_of = |axis| scene.name_of_quantity(Quantity::Moment { link, axis });
            if first != axis && name_of(axis) == name {
                let first = name_of(first);
                return fault(
                    span,
                    format!("{name} equals {first} and moves with it, expected {first}"),
                );
            }
        }
    }
    let told = scene.quantities().into_iter();
    let told = told.filter(|quantity| scene.untold(*quantity).is_none());
    let names: Vec<String> = told.map(|q| scene.name_of_quantity(q)).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let meant = match nearest(name, &names) {
        Some(near) => format!(", did you mean {near}? Expected"),
        None => ", expected".to_owned(),
    };
    fault(
        span,
        format!(
            "unknown quantity {name:?}{meant} one of {}",
            names.join(", ")
        ),
    )
}

/// Refuses free parameters of which only a combination is told, and initial values of which no body
/// is made. `places` are those of the parameters in the text.
pub(super) fn check_together(scene: &Scene, places: &[Range<usize>]) -> Result<(), Fault> {
    if let Some(combination) = scene.told_together() {
        let names = combination.parameters.iter();
        let names: Vec<&str> = names.map(|i| scene.parameters[*i].name.as_str()).collect();
        let last = combination
            .parameters
            .last()
            .map_or(0..0, |i| places[*i].clone());
        return fault(
            last,
            format!(
                "only a combination of {} is determined: {}; expected one of them fixed, or with a prior_sd",
                names.join(", "),
                combination.why
            ),
        );
    }
    let initial = scene.parameters.iter();
    let initial: Vec<(Quantity, f64)> = initial.map(|p| (p.quantity, p.initial)).collect();
    if let Err(error) = scene.with_values(&initial) {
        let is_factor = |quantity: Quantity| {
            matches!(quantity, Quantity::Moment { .. } | Quantity::Mass { .. })
        };
        let place = initial
            .iter()
            .position(|(quantity, _)| is_factor(*quantity));
        return fault(
            place.map_or(0..0, |at| places[at].clone()),
            format!("at the initial values {error}"),
        );
    }
    Ok(())
}
