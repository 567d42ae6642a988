//! An answer as keys of a scene: in the place of what it corrects where a scene has one, else as free with what is known of
//! it as its prior.

use crate::config::{
    BodyValues, EventValues, FreeValue, SceneValues, SurfaceValue, TrackValues, TrackerValue, Unit,
};
use crate::motion::{Quantity, Scene, TrackIndex};
use crate::report::FittedLine;

/// A parameter that is told, with its quantity in the scene.
pub(super) struct ToldValue<'a> {
    pub(super) quantity: Quantity,
    pub(super) line: &'a FittedLine,
    /// Whether the scene as it was read has it free.
    pub(super) is_free: bool,
}

/// The keys. `scene` is as the takes have it, without what is told.
pub(super) fn keys(scene: &Scene, told: &[ToldValue]) -> SceneValues {
    let mut values = SceneValues::default();
    let is_placed = |of: &&ToldValue| !of.is_free && has_key(scene, of.quantity);
    let placed: Vec<&ToldValue> = told.iter().filter(is_placed).collect();
    let known = placed.iter().map(|of| (of.quantity, of.line.value));
    let known: Vec<(Quantity, f64)> = known.collect();
    // Of a scene without a motion that has such values nothing is placed.
    let Ok(with) = scene.with_values(&known) else {
        values.free = told.iter().map(free).collect();
        return values;
    };
    for of in &placed {
        match of.quantity {
            Quantity::Gravity { .. } => {
                values.gravity_m_s2 = Some(with.gravity_m_s2.map(short).into());
            }
            Quantity::Restitution { law }
            | Quantity::Friction { law }
            | Quantity::TangentialRestitution { law } => {
                let name = &scene.contact_laws[law].name;
                place_law(&mut values, scene, name, of);
            }
            Quantity::TrackerPosition { track, .. } => {
                let mount = mount(&with, track);
                tracker(&mut values, scene, track).position_mm = mount.position_mm;
            }
            Quantity::TrackerOrientation { track, .. } => {
                let mount = mount(&with, track);
                tracker(&mut values, scene, track).orientation_wxyz = mount.orientation_wxyz;
            }
            Quantity::SurfaceHeight { surface } | Quantity::SurfaceTilt { surface, .. } => {
                place_surface(&mut values, &with, surface);
            }
            _ => {}
        }
    }
    let others = told.iter().filter(|of| !is_placed(of));
    values.free = others.map(free).collect();
    values
}

/// Whether a scene has a key for it.
fn has_key(scene: &Scene, quantity: Quantity) -> bool {
    match quantity {
        Quantity::Gravity { .. }
        | Quantity::TrackerPosition { .. }
        | Quantity::TrackerOrientation { .. } => true,
        Quantity::Restitution { law }
        | Quantity::Friction { law }
        | Quantity::TangentialRestitution { law } => {
            let name = &scene.contact_laws[law].name;
            let is_body = scene.links.iter().any(|link| link.name == *name);
            is_body || scene.events.iter().any(|event| event.name == *name)
        }
        Quantity::SurfaceHeight { surface } | Quantity::SurfaceTilt { surface, .. } => {
            scene.surfaces[surface].obstacle.is_none()
        }
        _ => false,
    }
}

fn place_law(values: &mut SceneValues, scene: &Scene, name: &str, of: &ToldValue) {
    let value = Some(short(of.line.value));
    let is_body = scene.links.iter().any(|link| link.name == *name);
    let [restitution, friction, tangential] = if is_body {
        let body = body(values, name);
        [
            &mut body.restitution,
            &mut body.friction,
            &mut body.tangential_restitution,
        ]
    } else {
        let is_it = |event: &EventValues| event.name == *name;
        let event = entry(&mut values.event, is_it, || EventValues {
            name: name.to_owned(),
            ..EventValues::default()
        });
        [
            &mut event.restitution,
            &mut event.friction,
            &mut event.tangential_restitution,
        ]
    };
    match of.quantity {
        Quantity::Restitution { .. } => *restitution = value,
        Quantity::Friction { .. } => *friction = value,
        _ => *tangential = value,
    }
}

fn body<'a>(values: &'a mut SceneValues, name: &str) -> &'a mut BodyValues {
    let is_it = |body: &BodyValues| body.name == *name;
    entry(&mut values.body, is_it, || BodyValues {
        name: name.to_owned(),
        ..BodyValues::default()
    })
}

/// The entry of a list that is the one that is meant, added where there is none.
fn entry<T>(list: &mut Vec<T>, is_it: impl Fn(&T) -> bool, added: impl FnOnce() -> T) -> &mut T {
    let at = list.iter().position(is_it).unwrap_or(list.len());
    if at == list.len() {
        list.push(added());
    }
    &mut list[at]
}

/// The keys of a track's tracker: those of its body, or of the track where the body has several.
fn tracker<'a>(
    values: &'a mut SceneValues,
    scene: &Scene,
    track: TrackIndex,
) -> &'a mut TrackerValue {
    let of = &scene.tracks[track];
    let name = &scene.links[of.link].name;
    let own = of.name.strip_prefix(name.as_str());
    let own = own.and_then(|rest| rest.strip_prefix('.'));
    let body = body(values, name);
    let Some(own) = own else {
        return body.tracker.get_or_insert_default();
    };
    let track = entry(
        &mut body.track,
        |track| track.name == own,
        || TrackValues {
            name: own.to_owned(),
            tracker: TrackerValue::default(),
        },
    );
    &mut track.tracker
}

/// How a tracker is mounted, in the frame in which the scene gives its body.
fn mount(scene: &Scene, track: TrackIndex) -> TrackerValue {
    let of = &scene.tracks[track];
    let mount = scene.links[of.link].given_from(&of.link_from_tracker);
    let q = mount.rotation.quaternion();
    TrackerValue {
        position_mm: Some((mount.translation.vector * 1e3).map(short).into()),
        orientation_wxyz: Some([q.w, q.i, q.j, q.k].map(short)),
    }
}

fn place_surface(values: &mut SceneValues, scene: &Scene, surface: usize) {
    let of = &scene.surfaces[surface];
    let Some((point_m, normal)) = of.plane() else {
        return;
    };
    let value = SurfaceValue {
        name: of.name.clone(),
        point_mm: (point_m * 1e3).map(short).into(),
        normal: normal.map(short).into(),
    };
    values.surface.retain(|other| other.name != of.name);
    values.surface.push(value);
}

/// A free quantity whose prior is what is known of it: of what is drawn, where the next take is.
fn free(of: &ToldValue) -> FreeValue {
    let unit = Unit::of(of.quantity);
    let spread = of.line.spread.map_or(0.0, |spread| spread.sd);
    FreeValue {
        quantity: of.line.name.clone(),
        initial: short(of.line.value / unit.si),
        prior_sd: short(of.line.sd.unwrap_or(0.0).hypot(spread).max(1e-12) / unit.si),
    }
}

/// To ten digits: more than anything is known to.
fn short(number: f64) -> f64 {
    let digits = 9 - number.abs().log10().floor().clamp(-20.0, 20.0) as i32;
    let scale = 10f64.powi(digits);
    let rounded = (number * scale).round() / scale;
    match rounded.is_finite() {
        true => rounded + 0.0,
        false => number,
    }
}
