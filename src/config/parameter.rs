//! Free parameters: their quantities, initial values and bounds (paper §6).

use std::ops::Range;

use nalgebra::Vector3;
use toml::Spanned;

use super::error::{Fault, fault};
use super::number::{finite, positive, unique};
use super::raw::{Number, RawFree, Text};
use crate::motion::{Collision, Cone, Event, FreeParameter, Quantity};

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
    gravity_m_s2: &Vector3<f64>,
    events: &[Event],
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
                tilts(free, limit, events)?.to_vec()
            }
            None => vec![parameter(free, gravity_m_s2, events)?],
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

fn parameter(
    free: &RawFree,
    gravity_m_s2: &Vector3<f64>,
    events: &[Event],
) -> Result<FreeParameter, Fault> {
    let (quantity, of_scene) = quantity(&free.quantity, gravity_m_s2, events)?;
    let (unit, widest) = match quantity {
        Quantity::Gravity { .. } => (ACCELERATION, f64::NEG_INFINITY..f64::INFINITY),
        Quantity::Restitution { .. } => (RATIO, 0.0..1.0),
        Quantity::Friction { .. } => (RATIO, 0.0..f64::INFINITY),
        Quantity::Tilt { .. } => (ANGLE, f64::NEG_INFINITY..f64::INFINITY),
    };
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
        lower: lower.as_ref().map_or(widest.start, si),
        upper: upper.as_ref().map_or(widest.end, si),
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
    widest: &Range<f64>,
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
    if !(*lower >= widest.start && *lower < f64::INFINITY) {
        return fault(
            at_lower,
            format!(
                "the lower bound of {name} is {}, expected {} or more",
                shown(lower),
                widest.start
            ),
        );
    }
    if !(*upper <= widest.end && *upper > f64::NEG_INFINITY) {
        return fault(
            at_upper,
            format!(
                "the upper bound of {name} is {}, expected {} or less",
                shown(upper),
                widest.end
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
fn quantity(
    text: &Text,
    gravity_m_s2: &Vector3<f64>,
    events: &[Event],
) -> Result<(Quantity, f64), Fault> {
    let name = text.get_ref().as_str();
    for (axis, of_gravity) in ["gravity.x", "gravity.y", "gravity.z"]
        .into_iter()
        .enumerate()
    {
        if name == of_gravity {
            return Ok((Quantity::Gravity { axis }, gravity_m_s2[axis]));
        }
    }
    let known = |event_name: &str| {
        let index = events.iter().position(|event| event.name == event_name)?;
        Some((index, events[index].kind.collision()?))
    };
    type CollisionQuantity = fn(usize, &Collision) -> (Quantity, f64);
    let of_collision: [(&str, CollisionQuantity); 4] = [
        (".restitution", |event, collision| {
            (Quantity::Restitution { event }, collision.restitution)
        }),
        (".friction", |event, collision| {
            (Quantity::Friction { event }, collision.friction)
        }),
        (".tilt.0", |event, _| {
            (Quantity::Tilt { event, tangent: 0 }, 0.0)
        }),
        (".tilt.1", |event, _| {
            (Quantity::Tilt { event, tangent: 1 }, 0.0)
        }),
    ];
    for (suffix, found) in of_collision {
        if let Some((event, collision)) = name.strip_suffix(suffix).and_then(known) {
            return Ok(found(event, collision));
        }
    }
    let mut expected = String::from("gravity.x, gravity.y, gravity.z");
    for event in events.iter().filter(|e| e.kind.collision().is_some()) {
        let of = &event.name;
        expected += &format!(", {of}.restitution, {of}.friction, {of}.tilt.0, {of}.tilt.1");
    }
    fault(
        text.span(),
        format!("unknown quantity {name:?}, expected one of {expected}"),
    )
}
