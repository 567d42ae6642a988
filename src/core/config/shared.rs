//! Quantities of a scene that many takes share, by the names of free ones.

use super::quantity::named;
use crate::motion::{Quantity, Scene};

/// What ends the name of a component of a vector, or of a pair of tilts.
const COMPONENTS: [&str; 5] = ["x", "y", "z", "0", "1"];

/// Frees the quantities of names in a scene, each from where the scene has it on, and gives their places among its
/// parameters, in the order of the names. `gravity` means all of its components. One that the scene frees already keeps what
/// the scene says of it, but for a cone. Fails where a name means none, or one that is named already, and where only a
/// combination of free quantities is told.
pub fn share(scene: &mut Scene, names: &[String]) -> Result<Vec<usize>, String> {
    let mut shared: Vec<usize> = Vec::new();
    for name in names {
        for quantity in meant(scene, name)? {
            let known = scene.parameter_of(quantity);
            let parameter = known.unwrap_or_else(|| {
                let free = scene.freed(quantity, scene.value_of(quantity));
                scene.parameters.push(free);
                scene.parameters.len() - 1
            });
            if shared.contains(&parameter) {
                let name = scene.name_of_quantity(quantity);
                return Err(format!(
                    "{name} is named twice, expected each quantity once"
                ));
            }
            shared.push(parameter);
        }
    }
    scene.cones.retain(|cone| {
        let mut both = cone.parameters.iter();
        !both.any(|of| shared.contains(of))
    });
    match scene.told_together() {
        None => Ok(shared),
        Some(combination) => {
            let names = combination.parameters.iter();
            let names: Vec<&str> = names
                .map(|of| scene.parameters[*of].name.as_str())
                .collect();
            Err(format!(
                "only a combination of {} is determined: {}; expected one of them left out, or a [[free]] of the scene \
                 with a prior_sd",
                names.join(", "),
                combination.why
            ))
        }
    }
}

/// The quantities that a name means.
fn meant(scene: &Scene, name: &str) -> Result<Vec<Quantity>, String> {
    let all = scene.quantities().into_iter();
    let components = all.filter(|quantity| {
        let full = scene.name_of_quantity(*quantity);
        let rest = full
            .strip_prefix(name)
            .and_then(|rest| rest.strip_prefix('.'));
        rest.is_some_and(|rest| COMPONENTS.contains(&rest))
    });
    let components: Vec<Quantity> = components.collect();
    let names = match components.is_empty() {
        true => vec![name.to_owned()],
        false => components
            .iter()
            .map(|quantity| scene.name_of_quantity(*quantity))
            .collect(),
    };
    let meant = names.iter().map(|name| named(name, 0..0, scene));
    let meant: Result<Vec<Quantity>, _> = meant.collect();
    meant.map_err(|fault| fault.message)
}
