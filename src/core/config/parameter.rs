//! Free parameters: their quantities, initial values and bounds (paper §6).

use std::ops::Range;

use super::error::{Fault, fault};
use super::number::{finite, positive, unique};
use super::quantity::{check_together, named};
use super::raw::{Number, RawFree};
use super::unit::Unit;
use crate::motion::{Cone, FreeParameter, Scene};

/// Greatest half opening of a cone for the tilt of a normal [°].
const CONE_MAX_DEG: f64 = 60.0;

/// Sets the free parameters, none twice, and the cones that bound pairs of tilts.
pub(super) fn parameters(raw: &[RawFree], scene: &mut Scene) -> Result<(), Fault> {
    let mut places: Vec<Range<usize>> = Vec::new();
    for free in raw {
        let next = scene.parameters.len();
        let found = match &free.cone_deg {
            Some(limit) => {
                let limit = cone_rad(limit)?;
                scene.cones.push(Cone {
                    parameters: [next, next + 1],
                    limit,
                });
                tilts(free, limit, scene)?.to_vec()
            }
            None => vec![parameter(free, scene)?],
        };
        for parameter in found {
            unique(
                "free quantity",
                &free.quantity,
                &parameter.name,
                scene.parameters.iter().map(|p| p.name.as_str()),
            )?;
            scene.parameters.push(parameter);
            places.push(free.quantity.span());
        }
    }
    check_together(scene, &places)
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

/// Both tilts of a collision's normal or of a surface, initially zero and bounded by their cone
/// only.
fn tilts(free: &RawFree, limit_rad: f64, scene: &Scene) -> Result<[FreeParameter; 2], Fault> {
    let name = free.quantity.get_ref();
    if !name.ends_with(".tilt") {
        return fault(
            free.quantity.span(),
            format!(
                "cone_deg bounds the tilt of a collision's normal or of a surface, expected `<event>.tilt` or `<surface>.tilt` instead of {name:?}"
            ),
        );
    }
    let tilt = |tangent: usize| {
        let name = format!("{name}.{tangent}");
        let quantity = named(&name, free.quantity.span(), scene)?;
        Ok(FreeParameter {
            name,
            quantity,
            initial: 0.0,
            lower: -limit_rad,
            upper: limit_rad,
            prior_sd: None,
        })
    };
    Ok([tilt(0)?, tilt(1)?])
}

fn parameter(free: &RawFree, scene: &Scene) -> Result<FreeParameter, Fault> {
    let name = free.quantity.get_ref();
    let quantity = named(name, free.quantity.span(), scene)?;
    let unit = Unit::of(quantity);
    let widest = scene.limits_of(quantity);
    let RawFree {
        initial,
        lower,
        upper,
        prior_sd,
        ..
    } = free;
    let [lower, upper] = [lower, upper].map(Option::as_ref);
    let si = |number: &Number| *number.get_ref() * unit.si;
    let parameter = FreeParameter {
        name: name.clone(),
        quantity,
        initial: match initial {
            Some(number) => finite("the initial value", number)? * unit.si,
            None => scene.value_of(quantity),
        },
        lower: lower.map_or(widest[0], si),
        upper: upper.map_or(widest[1], si),
        prior_sd: match prior_sd {
            Some(number) => Some(positive("the prior's standard deviation", number)? * unit.si),
            None => None,
        },
    };
    let place = |number: Option<&Number>| match number {
        Some(number) => number.span(),
        None => free.quantity.span(),
    };
    let places = [place(lower), place(upper), place(initial.as_ref())];
    check_bounds(&parameter, unit, widest, places)?;
    Ok(parameter)
}

fn check_bounds(
    parameter: &FreeParameter,
    unit: &Unit,
    widest: [f64; 2],
    [at_lower, at_upper, at_initial]: [Range<usize>; 3],
) -> Result<(), Fault> {
    let FreeParameter {
        name,
        initial,
        lower,
        upper,
        ..
    } = parameter;
    let shown = |si: &f64| format!("{}{}", si / unit.si, unit.name);
    // Written so that NaN fails each check.
    if !(*lower >= widest[0] && *lower < f64::INFINITY) {
        return fault(
            at_lower,
            format!(
                "the lower bound of {name} is {}, expected {} or more",
                shown(lower),
                shown(&widest[0])
            ),
        );
    }
    if !(*upper <= widest[1] && *upper > f64::NEG_INFINITY) {
        return fault(
            at_upper,
            format!(
                "the upper bound of {name} is {}, expected {} or less",
                shown(upper),
                shown(&widest[1])
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
