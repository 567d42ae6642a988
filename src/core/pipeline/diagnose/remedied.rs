//! A take with a remedy.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::missed::collision;
use crate::math::Pose;
use crate::motion::{
    Event, EventKind, GoalQuantity, GoalTarget, LengthUnit, Mark, PoseSample, QuaternionSlip,
    Remedy, Scene, SignedAxis, Stamp, TakeEvent, Timing,
};
use crate::physics::shape::{Compound, Part};
use crate::physics::{Body, Shape, contact};

/// Strength of tempo changes where a scene has none: the default of scene files [1/√s].
const TEMPO_SD_PER_SQRT_S: f64 = 0.5;
/// Name of an event that is missed.
const MISSED: &str = "missed collision";
/// Millimetres are what a scene's lengths are given in \[m\].
const SCENE_UNIT_M: f64 = 1e-3;

/// A scene and the events of a take, as they are meant if the remedy is right; `None` where the
/// remedied scene is none.
pub(super) fn remedied(
    remedy: &Remedy,
    scene: &Scene,
    events: &[TakeEvent],
) -> Option<(Scene, Vec<TakeEvent>)> {
    let (mut scene, mut events) = (scene.clone(), events.to_vec());
    match remedy {
        Remedy::Up { axis, .. } => {
            let turn = upright(*axis, &scene.gravity_m_s2)?;
            each_sample(&mut events, |sample| {
                sample.position_m = turn * sample.position_m;
                turn_by(sample, |q| turn.into_inner() * q);
            });
        }
        Remedy::Gravity { gravity_m_s2 } => scene.gravity_m_s2 = *gravity_m_s2,
        Remedy::PositionUnit(unit) => {
            each_sample(&mut events, |s| s.position_m *= unit.length_m());
        }
        Remedy::SceneUnit(unit) => scene = scaled(&scene, *unit)?,
        Remedy::StampUnit { factor } => stretch(&mut events, 1.0 / factor),
        Remedy::FrameNumbers { rate_hz } => stretch(&mut events, 1.0 / rate_hz),
        Remedy::Tempo { .. } => {
            scene.timing = Timing::Unknown {
                tempo_sd_per_sqrt_s: TEMPO_SD_PER_SQRT_S,
            };
        }
        Remedy::Mount {
            track,
            link_from_tracker,
            ..
        } => scene.tracks[*track].link_from_tracker = *link_from_tracker,
        Remedy::StreamQuaternions(slip) => each_sample(&mut events, |sample| {
            turn_by(sample, |q| meant(*slip, q));
        }),
        Remedy::GoalQuaternions(slip) => {
            for goal in &mut scene.goals {
                match &mut goal.target {
                    GoalTarget::Pose { world_from_body } => {
                        world_from_body.rotation = slip.corrected(&world_from_body.rotation);
                    }
                    GoalTarget::Condition(condition) => {
                        if let GoalQuantity::Turn { from, .. } = &mut condition.quantity {
                            *from = slip.corrected(from);
                        }
                    }
                    GoalTarget::PositionWithin { .. } => {}
                }
            }
            snapped(&mut scene)?;
        }
        Remedy::StuckTogether { event, .. } => scene = scene.with_stuck(*event)?,
        Remedy::FreeLabels { goal } => scene.rest_goals[*goal].labels_are_free = true,
        Remedy::Surface {
            surface, point_m, ..
        } => {
            let surface = &mut scene.surfaces[*surface];
            let contact::Feature::Face { normal, .. } = surface.geometry else {
                return None;
            };
            surface.geometry = contact::Feature::face(*point_m, normal);
            snapped(&mut scene)?;
        }
        Remedy::Origin { higher_m } => each_sample(&mut events, |s| s.position_m -= higher_m),
        Remedy::MissedCollision {
            index,
            link,
            surface,
            stamp,
            ..
        } => {
            let marks: Vec<&Mark> = events.iter().filter_map(TakeEvent::mark).collect();
            let is_named = marks.iter().any(|mark| mark.event.is_some());
            scene = scene.with_marks(marks.len());
            let kind = EventKind::Collision(collision(&scene, *link, Some(*surface))?);
            scene = scene.with_event(*index, Event::new(MISSED, kind));
            events.push(TakeEvent::Mark(Mark {
                stamp: *stamp,
                event: is_named.then(|| MISSED.to_owned()),
            }));
        }
    }
    Some((scene, events))
}

/// The least turn that brings an axis of the streams opposite to the scene's gravity.
pub(super) fn upright(
    axis: SignedAxis,
    gravity_m_s2: &Vector3<f64>,
) -> Option<UnitQuaternion<f64>> {
    let up = -gravity_m_s2.try_normalize(0.0)?;
    // Opposite axes leave the turn open: half a turn about the first axis across, x for z.
    let half = || {
        let across = Vector3::ith_axis((gravity_m_s2.iamax() + 1) % 3);
        UnitQuaternion::from_axis_angle(&across, std::f64::consts::PI)
    };
    Some(UnitQuaternion::rotation_between(&axis.vector(), &up).unwrap_or_else(half))
}

fn each_sample(events: &mut [TakeEvent], mut change: impl FnMut(&mut PoseSample)) {
    for event in events {
        if let TakeEvent::Pose { sample, .. } = event {
            change(sample);
        }
    }
}

fn turn_by(sample: &mut PoseSample, change: impl Fn(Quaternion<f64>) -> Quaternion<f64>) {
    let [x, y, z, w] = sample.quaternion_xyzw;
    let q = change(Quaternion::new(w, x, y, z));
    sample.quaternion_xyzw = [q.i, q.j, q.k, q.w];
}

/// [`QuaternionSlip::corrected`] of what may be no unit quaternion.
fn meant(slip: QuaternionSlip, given: Quaternion<f64>) -> Quaternion<f64> {
    let given = UnitQuaternion::new_unchecked(given);
    slip.corrected(&given).into_inner()
}

/// Multiplies all intervals, from the first stamp on.
fn stretch(events: &mut [TakeEvent], factor: f64) {
    let stamp = |event: &TakeEvent| match event {
        TakeEvent::Pose { sample, .. } => sample.stamp,
        TakeEvent::Mark(mark) => mark.stamp,
    };
    let Some(Stamp(zero)) = events.iter().map(stamp).min() else {
        return;
    };
    let moved = |stamp: Stamp| {
        let since_ns = i128::from(stamp.0) - i128::from(zero);
        // A float's rounding is below a nanosecond for intervals of a month.
        Stamp(zero.saturating_add((since_ns as f64 * factor).round() as i64))
    };
    for event in events {
        match event {
            TakeEvent::Pose { sample, .. } => sample.stamp = moved(sample.stamp),
            TakeEvent::Mark(mark) => mark.stamp = moved(mark.stamp),
        }
    }
}

/// The scene with lengths that were given in a unit instead of in millimetres.
fn scaled(scene: &Scene, unit: LengthUnit) -> Option<Scene> {
    let factor = unit.length_m() / SCENE_UNIT_M;
    let mut scene = scene.clone();
    for link in &mut scene.links {
        // Moments that belong to the shape as it is given change with it; others were given.
        let uniform = link.shape.body_of_mass_kg(link.body.mass_kg());
        let is_uniform = uniform.is_ok_and(|uniform| {
            let apart = uniform.moments_kg_m2() - link.body.moments_kg_m2();
            apart.norm() < 1e-6 * link.body.moments_kg_m2().norm()
        });
        link.shape = shape_scaled(&link.shape, factor);
        pose_scaled(&mut link.link_from_given, factor);
        if is_uniform {
            let moments_kg_m2 = link.body.moments_kg_m2() * (factor * factor);
            link.body = Body::new(link.body.mass_kg(), moments_kg_m2).ok()?;
        }
        for feature in &mut link.features {
            feature.geometry = feature_scaled(&feature.geometry, factor);
        }
    }
    for track in &mut scene.tracks {
        pose_scaled(&mut track.link_from_tracker, factor);
    }
    for surface in &mut scene.surfaces {
        surface.geometry = feature_scaled(&surface.geometry, factor);
    }
    for obstacle in &mut scene.obstacles {
        obstacle.shape = shape_scaled(&obstacle.shape, factor);
        pose_scaled(&mut obstacle.world_from_shape, factor);
    }
    for goal in &mut scene.goals {
        match &mut goal.target {
            GoalTarget::Pose { world_from_body } => pose_scaled(world_from_body, factor),
            GoalTarget::PositionWithin { lower_m, upper_m } => {
                *lower_m *= factor;
                *upper_m *= factor;
            }
            GoalTarget::Condition(condition) => {
                *condition = condition.clone().with_lengths_scaled(factor);
            }
        }
    }
    snapped(&mut scene)?;
    Some(scene)
}

/// Goals at a collision are in contact; `None` where they cannot be.
fn snapped(scene: &mut Scene) -> Option<()> {
    (0..scene.goals.len()).try_for_each(|goal| scene.snap_to_contact(goal).map(|_| ()).ok())
}

fn pose_scaled(pose: &mut Pose, factor: f64) {
    pose.translation.vector *= factor;
}

fn shape_scaled(shape: &Shape, factor: f64) -> Shape {
    match shape {
        Shape::Cuboid { half_extents_m } => Shape::Cuboid {
            half_extents_m: half_extents_m * factor,
        },
        Shape::RoundedCuboid {
            half_extents_m,
            radius_m,
        } => Shape::RoundedCuboid {
            half_extents_m: half_extents_m * factor,
            radius_m: radius_m * factor,
        },
        Shape::Sphere { radius_m } => Shape::Sphere {
            radius_m: radius_m * factor,
        },
        Shape::Cylinder {
            half_length_m,
            radius_m,
        } => Shape::Cylinder {
            half_length_m: half_length_m * factor,
            radius_m: radius_m * factor,
        },
        Shape::Capsule {
            half_length_m,
            radius_m,
        } => Shape::Capsule {
            half_length_m: half_length_m * factor,
            radius_m: radius_m * factor,
        },
        Shape::Cone {
            half_height_m,
            radius_m,
        } => Shape::Cone {
            half_height_m: half_height_m * factor,
            radius_m: radius_m * factor,
        },
        Shape::Hull { points_m } => Shape::Hull {
            points_m: points_m.iter().map(|point_m| point_m * factor).collect(),
        },
        Shape::Compound(compound) => {
            let parts = compound.parts.iter().map(|part| {
                let mut compound_from_shape = part.compound_from_shape;
                pose_scaled(&mut compound_from_shape, factor);
                Part {
                    shape: shape_scaled(&part.shape, factor),
                    compound_from_shape,
                }
            });
            let features = compound.features.iter();
            let features = features.map(|(name, of)| (name.clone(), feature_scaled(of, factor)));
            Shape::Compound(Compound {
                parts: parts.collect(),
                features: features.collect(),
            })
        }
    }
}

fn feature_scaled(feature: &contact::Feature, factor: f64) -> contact::Feature {
    use contact::Feature::{Face, Line, Point, Rim};
    match *feature {
        Point { point_m, radius_m } => Point {
            point_m: point_m * factor,
            radius_m: radius_m * factor,
        },
        Line {
            point_m,
            direction,
            radius_m,
        } => Line {
            point_m: point_m * factor,
            direction,
            radius_m: radius_m * factor,
        },
        Rim {
            centre_m,
            axis,
            radius_m,
        } => Rim {
            centre_m: centre_m * factor,
            axis,
            radius_m: radius_m * factor,
        },
        Face { point_m, normal } => Face {
            point_m: point_m * factor,
            normal,
        },
    }
}
