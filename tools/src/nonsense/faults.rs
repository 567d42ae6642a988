//! Wrong models of right performances, and the right ones beside them.

use enact::motion::{PoseSample, Scene, TakeEvent, Timing as Stamps};
use enact::physics::contact;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::{Asked, Make, Row, thrown};
use crate::case::Case;
use crate::perform::{Acting, Polyhedron, Style, Throw, Truth, bounces, hat_box};

/// What is wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// Nothing.
    None,
    /// The table is so much higher than said \[m\].
    Table(f64),
    /// Quaternions are body from world.
    Conjugated,
    /// The tracker's y axis is up, not z.
    YUp,
    /// Positions are in centimetres.
    Centimetres,
    /// Restitution is less by so much.
    Restitution(f64),
}

impl Fault {
    /// The take with it.
    pub fn into(self, mut asked: Asked) -> Asked {
        match self {
            Fault::None => {}
            Fault::Table(height_m) => lift_tables(&mut asked.scene, height_m),
            Fault::Conjugated => each_sample(&mut asked.events, |sample| {
                let [x, y, z, w] = sample.quaternion_xyzw;
                sample.quaternion_xyzw = [-x, -y, -z, w];
            }),
            Fault::YUp => {
                let turn = UnitQuaternion::from_axis_angle(
                    &Vector3::x_axis(),
                    -std::f64::consts::FRAC_PI_2,
                );
                each_sample(&mut asked.events, |sample| {
                    let [x, y, z, w] = sample.quaternion_xyzw;
                    let q = turn.into_inner() * Quaternion::new(w, x, y, z);
                    sample.position_m = turn * sample.position_m;
                    sample.quaternion_xyzw = [q.i, q.j, q.k, q.w];
                });
            }
            Fault::Centimetres => each_sample(&mut asked.events, |s| s.position_m *= 100.0),
            Fault::Restitution(less) => {
                for law in &mut asked.scene.contact_laws {
                    law.restitution -= less;
                }
            }
        }
        asked
    }
}

pub(super) fn lift_tables(scene: &mut Scene, height_m: f64) {
    each_face(scene, |point_m, normal| {
        contact::Feature::face(point_m + normal * height_m, normal)
    });
}

/// Replaces the faces of all surfaces by what is made of their points and normals.
pub(super) fn each_face(
    scene: &mut Scene,
    change: impl Fn(Vector3<f64>, Vector3<f64>) -> contact::Feature,
) {
    for surface in &mut scene.surfaces {
        if let contact::Feature::Face { point_m, normal } = surface.geometry {
            surface.geometry = change(point_m, normal);
        }
    }
}

pub(super) fn each_sample(events: &mut [TakeEvent], mut change: impl FnMut(&mut PoseSample)) {
    for event in events {
        if let TakeEvent::Pose { sample, .. } = event {
            change(sample);
        }
    }
}

pub(super) fn asked(truth: &Truth, acting: &Acting, seed: u64) -> Asked {
    let case = Case::new(truth, acting, seed);
    Asked {
        scene: case.scene().clone(),
        events: case.performance.events.clone(),
    }
}

/// A hat that catches a box, weighed by the noise that the tracker has.
pub fn hat_and_box(acting: &Acting, seed: u64) -> Asked {
    let mut asked = asked(&hat_box::truth(), acting, seed);
    asked.scene.weights.position_m = acting.noise_position_m;
    asked.scene.weights.orientation_rad = acting.noise_orientation_rad;
    asked
}

/// A pencil, tip first with even seeds, eraser first with odd ones.
pub(super) fn pencil(acting: &Acting, seed: u64) -> Asked {
    asked(&Style::ALL[(seed % 2) as usize].truth(), acting, seed)
}

/// A die of 16 mm that bounces four times, by a hand that strays farther than the die is large: every flight is
/// too short to show it.
pub(super) fn die(seed: u64) -> Result<Asked, String> {
    let truth = bounces::thrown(Polyhedron::Cube, &Throw::DIE, 4, seed);
    let truth = truth.map_err(|error| error.to_string())?;
    Ok(asked(&truth, &at(true, 1.0), seed))
}

/// How much the tracker is off, and nothing else [m, rad, per axis].
const NOISE: (f64, f64) = (0.0005, 0.3 * std::f64::consts::PI / 180.0);

/// A cube that was really thrown: one or two bounces, physical times, only the tracker's noise, and
/// weights that say so.
pub(super) fn toss(seed: u64) -> Result<Asked, String> {
    let truth = bounces(1 + (seed / 2 % 2) as usize, seed).map_err(|error| error.to_string())?;
    let mut asked = asked(&truth, &at(true, 0.0), seed);
    asked.scene.weights.position_m = NOISE.0;
    asked.scene.weights.orientation_rad = NOISE.1;
    Ok(asked)
}

pub(super) fn at(is_known: bool, distortion: f64) -> Acting {
    let acting = if is_known {
        Acting::timing_known()
    } else {
        Acting::default()
    };
    Acting {
        distortion,
        ..acting
    }
}

/// All rows from performances.
pub fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    let mut add = |name: String, is_right: bool, make: Make| {
        rows.push(Row {
            name,
            is_right,
            make,
        });
    };
    for is_known in [true, false] {
        let timing = if is_known { "known" } else { "unknown" };
        for distortion in [1.0, 2.0, 4.0, 8.0] {
            let acting = at(is_known, distortion);
            let make = move |seed| Ok(pencil(&acting, seed));
            add(
                format!("pencil, {timing}, {distortion}×"),
                true,
                Box::new(make),
            );
            let make = move |seed| Ok(asked(&hat_box::truth(), &acting, seed));
            add(
                format!("hat and box, {timing}, {distortion}×"),
                true,
                Box::new(make),
            );
            let make = move |seed| {
                let truth = bounces(1 + (seed % 3) as usize, seed);
                Ok(asked(
                    &truth.map_err(|error| error.to_string())?,
                    &acting,
                    seed,
                ))
            };
            add(
                format!("cube, {timing}, {distortion}×"),
                true,
                Box::new(make),
            );
        }
    }
    for slowdown in [1.0, 5.0, 10.0] {
        let acting = Acting {
            slowdown,
            ..Acting::default()
        };
        let make = move |seed| Ok(pencil(&acting, seed));
        add(
            format!("pencil, acted {slowdown} times slower"),
            true,
            Box::new(make),
        );
    }
    for thrown in thrown::all() {
        let name = thrown.name();
        let make = move |seed| thrown.asked(seed);
        add(name, true, Box::new(make));
    }
    add("toss, weights as its noise".into(), true, Box::new(toss));
    let name = "die of 16 mm, 4 bounces, known, 1×";
    add(name.into(), true, Box::new(die));
    let faults = [
        ("table 30 mm off", Fault::Table(0.03)),
        ("table 8 mm off", Fault::Table(0.008)),
        ("quaternions conjugated", Fault::Conjugated),
        ("y up taken for z up", Fault::YUp),
        ("positions in cm", Fault::Centimetres),
        ("restitution 0.3 less", Fault::Restitution(0.3)),
    ];
    for (name, fault) in faults {
        let make = move |seed| Ok(fault.into(toss(seed)?));
        add(format!("toss: {name}"), false, Box::new(make));
        let make = move |seed| Ok(fault.into(die(seed)?));
        add(format!("die of 16 mm: {name}"), false, Box::new(make));
        for is_known in [true, false] {
            let timing = if is_known { "known" } else { "unknown" };
            let acting = at(is_known, 1.0);
            let make = move |seed| Ok(fault.into(pencil(&acting, seed)));
            add(
                format!("pencil 1×, {timing}: {name}"),
                false,
                Box::new(make),
            );
        }
    }
    for slowdown in [1.2, 2.5] {
        let make = move |seed| {
            let acting = Acting {
                slowdown,
                ..Acting::default()
            };
            let mut asked = pencil(&acting, seed);
            asked.scene.timing = Stamps::Known;
            Ok(asked)
        };
        add(
            format!("pencil 1×: {slowdown} times slower taken for physical"),
            false,
            Box::new(make),
        );
        let make = move |seed| {
            let mut asked = toss(seed)?;
            stretch(&mut asked.events, slowdown);
            Ok(asked)
        };
        add(
            format!("toss: {slowdown} times slower taken for physical"),
            false,
            Box::new(make),
        );
    }
    rows
}

pub(super) fn stretch(events: &mut [TakeEvent], slowdown: f64) {
    let stamps = events.iter().map(|event| match event {
        TakeEvent::Pose { sample, .. } => sample.stamp,
        TakeEvent::Mark(mark) => mark.stamp,
    });
    let Some(zero) = stamps.min() else { return };
    for event in events {
        let stamp = match event {
            TakeEvent::Pose { sample, .. } => &mut sample.stamp,
            TakeEvent::Mark(mark) => &mut mark.stamp,
        };
        stamp.0 = zero.0 + ((stamp.0 - zero.0) as f64 * slowdown).round() as i64;
    }
}
