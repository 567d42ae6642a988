//! Free parameters: their quantities, initial values and bounds (paper §6).

use std::ops::Range;

use toml::Spanned;

use super::error::{Fault, fault};
use super::number::{finite, positive, unique};
use super::raw::{Number, RawFree, Text};
use crate::motion::{Cone, Event, FreeParameter, Quantity, Scene};

/// Greatest half opening of a cone for the tilt of a normal [°].
const CONE_MAX_DEG: f64 = 60.0;

/// A quantity's unit in the file.
#[derive(Clone, Copy, PartialEq)]
struct Unit {
    /// Suffix of the keys.
    suffix: &'static str,
    /// Value of the unit in SI units.
    si: f64,
}

const ACCELERATION: Unit = Unit {
    suffix: "_m_s2",
    si: 1.0,
};
const RATIO: Unit = Unit {
    suffix: "",
    si: 1.0,
};
const ANGLE: Unit = Unit {
    suffix: "_deg",
    si: std::f64::consts::PI / 180.0,
};

/// The free parameters, none twice, and the cones that bound pairs of tilts.
pub(super) fn parameters(
    raw: &[RawFree],
    scene: &Scene,
) -> Result<(Vec<FreeParameter>, Vec<Cone>), Fault> {
    let mut parameters: Vec<FreeParameter> = Vec::new();
    let mut cones = Vec::new();
    for free in raw {
        let next = parameters.len();
        let found = match &free.cone_deg {
            Some(limit) => {
                let limit = cone_rad(limit)?;
                cones.push(Cone {
                    parameters: [next, next + 1],
                    limit,
                });
                tilts(free, limit, &scene.events)?.to_vec()
            }
            None => vec![parameter(free, scene)?],
        };
        for parameter in found {
            unique(
                "free quantity",
                &free.quantity,
                &parameter.name,
                parameters.iter().map(|p| p.name.as_str()),
            )?;
            parameters.push(parameter);
        }
    }
    Ok((parameters, cones))
}

/// Half the opening of a cone.
fn cone_rad(number: &Number) -> Result<f64, Fault> {
    let degrees = positive("cone_deg", number)?;
    if degrees > CONE_MAX_DEG {
        return fault(
            number.span(),
            format!("cone_deg is {degrees}, expected at most {CONE_MAX_DEG}"),
        );
    }
    Ok(degrees.to_radians())
}

/// Both tilts of a collision's normal, initially zero and bounded by their cone only.
fn tilts(free: &RawFree, limit_rad: f64, events: &[Event]) -> Result<[FreeParameter; 2], Fault> {
    let name = free.quantity.get_ref();
    let collision = name.strip_suffix(".tilt").and_then(|event_name| {
        let is_it = |event: &Event| event.name == event_name && event.kind.collision().is_some();
        events.iter().position(is_it)
    });
    let Some(event) = collision else {
        return fault(
            free.quantity.span(),
            format!(
                "cone_deg bounds the tilt of a collision's normal, expected `<event>.tilt` instead of {name:?}"
            ),
        );
    };
    Ok([0, 1].map(|tangent| FreeParameter {
        name: format!("{name}.{tangent}"),
        quantity: Quantity::Tilt { event, tangent },
        initial: 0.0,
        lower: -limit_rad,
        upper: limit_rad,
        prior_sd: None,
    }))
}

fn parameter(free: &RawFree, scene: &Scene) -> Result<FreeParameter, Fault> {
    let (quantity, of_scene) = quantity(&free.quantity, scene)?;
    let unit = match quantity {
        Quantity::Gravity { .. } => ACCELERATION,
        Quantity::Tilt { .. } => ANGLE,
        _ => RATIO,
    };
    let widest = quantity.limits();
    let name = free.quantity.get_ref();
    let pick = |key: &str, candidates: [&Option<Number>; 3]| -> Result<Option<Number>, Fault> {
        let units = [RATIO, ACCELERATION, ANGLE];
        let mut right = None;
        for (candidate, its) in candidates.into_iter().zip(units) {
            let Some(number) = candidate else { continue };
            if its != unit {
                return fault(
                    number.span(),
                    format!(
                        "{key}{} does not apply to {name}, expected {key}{}",
                        its.suffix, unit.suffix
                    ),
                );
            }
            right = Some(number.clone());
        }
        Ok(right)
    };
    let initial = pick(
        "initial",
        [&free.initial, &free.initial_m_s2, &free.initial_deg],
    )?;
    let lower = pick("lower", [&free.lower, &free.lower_m_s2, &free.lower_deg])?;
    let upper = pick("upper", [&free.upper, &free.upper_m_s2, &free.upper_deg])?;
    let prior_sd = pick(
        "prior_sd",
        [&free.prior_sd, &free.prior_sd_m_s2, &free.prior_sd_deg],
    )?;
    let si = |number: &Number| *number.get_ref() * unit.si;
    let parameter = FreeParameter {
        name: name.clone(),
        quantity,
        initial: match &initial {
            Some(number) => finite("the initial value", number)? * unit.si,
            None => of_scene,
        },
        lower: lower.as_ref().map_or(widest[0], si),
        upper: upper.as_ref().map_or(widest[1], si),
        prior_sd: match &prior_sd {
            Some(number) => Some(positive("the prior's standard deviation", number)? * unit.si),
            None => None,
        },
    };
    let place = |number: &Option<Number>| number.as_ref().unwrap_or(&fallback(free)).span();
    check_bounds(
        &parameter,
        unit,
        &widest,
        [place(&lower), place(&upper), place(&initial)],
    )?;
    Ok(parameter)
}

/// The place for an error about a key that was left out.
fn fallback(free: &RawFree) -> Number {
    Spanned::new(free.quantity.span(), 0.0)
}

fn check_bounds(
    parameter: &FreeParameter,
    unit: Unit,
    widest: &[f64; 2],
    [at_lower, at_upper, at_initial]: [Range<usize>; 3],
) -> Result<(), Fault> {
    let FreeParameter {
        name,
        initial,
        lower,
        upper,
        ..
    } = parameter;
    let shown = |si: &f64| si / unit.si;
    // Written so that NaN fails each check.
    if !(*lower >= widest[0] && *lower < f64::INFINITY) {
        return fault(
            at_lower,
            format!(
                "the lower bound of {name} is {}, expected {} or more",
                shown(lower),
                widest[0]
            ),
        );
    }
    if !(*upper <= widest[1] && *upper > f64::NEG_INFINITY) {
        return fault(
            at_upper,
            format!(
                "the upper bound of {name} is {}, expected {} or less",
                shown(upper),
                widest[1]
            ),
        );
    }
    if lower >= upper {
        return fault(
            at_upper,
            format!(
                "the bounds of {name} are {} to {}, expected the upper one above the lower",
                shown(lower),
                shown(upper)
            ),
        );
    }
    if initial < lower || initial > upper {
        return fault(
            at_initial,
            format!(
                "{name} begins at {}, expected a value within its bounds {} to {}",
                shown(initial),
                shown(lower),
                shown(upper)
            ),
        );
    }
    Ok(())
}

/// The quantity with a name, and its value in the scene in SI units.
fn quantity(text: &Text, scene: &Scene) -> Result<(Quantity, f64), Fault> {
    let name = text.get_ref().as_str();
    let known: Vec<(String, Quantity, f64)> = freeable(scene);
    if let Some((_, quantity, of_scene)) = known.iter().find(|(known, ..)| known == name) {
        return Ok((*quantity, *of_scene));
    }
    let names: Vec<&str> = known.iter().map(|(name, ..)| name.as_str()).collect();
    fault(
        text.span(),
        format!(
            "unknown quantity {name:?}, expected one of {}",
            names.join(", ")
        ),
    )
}

/// What may be free: names, quantities, and their values in the scene.
fn freeable(scene: &Scene) -> Vec<(String, Quantity, f64)> {
    let axes = ["gravity.x", "gravity.y", "gravity.z"]
        .into_iter()
        .enumerate();
    let gravity = axes.map(|(axis, name)| {
        let quantity = Quantity::Gravity { axis };
        (name.to_owned(), quantity, scene.gravity_m_s2[axis])
    });
    let laws = scene.contact_laws.iter_enumerated();
    let laws = laws.flat_map(|(law, of)| {
        let restitution = Quantity::Restitution { law };
        let friction = Quantity::Friction { law };
        [
            (
                format!("{}.restitution", of.name),
                restitution,
                of.restitution,
            ),
            (format!("{}.friction", of.name), friction, of.friction),
        ]
    });
    let events = scene.events.iter().enumerate();
    let collisions = events.filter(|(_, event)| event.kind.collision().is_some());
    let tilts = collisions.flat_map(|(event, of)| {
        [0, 1].map(|tangent| {
            let quantity = Quantity::Tilt { event, tangent };
            (format!("{}.tilt.{tangent}", of.name), quantity, 0.0)
        })
    });
    gravity.chain(laws).chain(tilts).collect()
}
