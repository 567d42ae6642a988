//! Mistakes in what is said of a performance, in a scene or by a driver, that the program should name.

use enact::motion::{
    Collision, Goal, GoalTarget, LengthUnit, MountSlip, Partner, QuaternionSlip, Remedy, Scene,
    Stamp, TakeEvent, Timing, TrackIndex,
};
use enact::physics::{Body, Shape, contact};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::faults::{asked, at, die, each_sample, pencil, stretch, toss};
use super::{Asked, Make};
use crate::perform::{Acting, bounces, hat_box};

/// A mistake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Slip {
    /// None.
    None,
    /// The tracker's offset has the wrong sign.
    TrackerNegated,
    /// The tracker's offset is not given.
    TrackerForgotten,
    /// The tracker's pose is the body's in the tracker's frame.
    TrackerInverted,
    /// The stream's quaternions are in another order.
    StreamQuaternions(QuaternionSlip),
    /// The quaternions of goals are in another order.
    GoalQuaternions(QuaternionSlip),
    /// The stream's y axis is up, not z.
    YUp,
    /// The stream's z axis is down.
    ZDown,
    /// The scene's gravity points up.
    GravityUp,
    /// The tables are higher than said by so much \[m\].
    Table(f64),
    /// The stream's zero is so much lower than the scene's \[m\].
    Origin(f64),
    /// Acted so many times slower, with stamps taken for physical times.
    Slow(f64),
    /// The stream's positions are in another unit.
    Positions(LengthUnit),
    /// Intervals of stamps are so many times too long.
    Stamps(f64),
    /// Stamps are numbers of frames at this rate, taken for seconds \[Hz\].
    Frames(f64),
    /// The scene's lengths are in another unit.
    Lengths(LengthUnit),
    /// The second collision with a table is neither in the scene nor marked.
    Unmarked,
}

/// All, each in a few sizes.
pub const ALL: &[Slip] = &[
    Slip::TrackerNegated,
    Slip::TrackerForgotten,
    Slip::TrackerInverted,
    Slip::StreamQuaternions(QuaternionSlip::ScalarFirst),
    Slip::StreamQuaternions(QuaternionSlip::ScalarLast),
    Slip::StreamQuaternions(QuaternionSlip::Inverse),
    Slip::GoalQuaternions(QuaternionSlip::ScalarLast),
    Slip::YUp,
    Slip::ZDown,
    Slip::GravityUp,
    Slip::Table(0.73),
    Slip::Table(0.1),
    Slip::Table(-0.3),
    Slip::Origin(0.73),
    Slip::Origin(-0.2),
    Slip::Slow(1.5),
    Slip::Slow(2.5),
    Slip::Slow(5.0),
    Slip::Positions(LengthUnit::Inch),
    Slip::Positions(LengthUnit::Foot),
    Slip::Positions(LengthUnit::Centimetre),
    Slip::Positions(LengthUnit::Millimetre),
    Slip::Stamps(1e3),
    Slip::Stamps(1e-3),
    Slip::Frames(120.0),
    Slip::Lengths(LengthUnit::Metre),
    Slip::Lengths(LengthUnit::Inch),
    Slip::Unmarked,
];

impl Slip {
    /// Its name in tables.
    pub fn name(self) -> String {
        match self {
            Slip::None => "nothing".into(),
            Slip::TrackerNegated => "tracker's offset with the wrong sign".into(),
            Slip::TrackerForgotten => "tracker's offset forgotten".into(),
            Slip::TrackerInverted => "tracker's pose the other way round".into(),
            Slip::StreamQuaternions(slip) => format!("stream's quaternions {}", words(slip)),
            Slip::GoalQuaternions(slip) => format!("goals' quaternions {}", words(slip)),
            Slip::YUp => "stream with y up".into(),
            Slip::ZDown => "stream with z down".into(),
            Slip::GravityUp => "gravity upwards".into(),
            Slip::Table(height_m) => format!("table {:.0} mm off", height_m * 1e3),
            Slip::Origin(height_m) => format!("stream's zero {:.0} mm lower", height_m * 1e3),
            Slip::Slow(slowness) => format!("acted {slowness}× slower, taken for physical"),
            Slip::Positions(unit) => format!("positions in {unit:?}"),
            Slip::Stamps(factor) => format!("stamps × {factor}"),
            Slip::Frames(rate_hz) => format!("frame numbers at {rate_hz} Hz"),
            Slip::Lengths(unit) => format!("scene in {unit:?}"),
            Slip::Unmarked => "second collision forgotten".into(),
        }
    }

    /// Whether a remedy is the one for it.
    pub fn is_named_by(self, remedy: &Remedy) -> bool {
        match (self, remedy) {
            (Slip::TrackerNegated, Remedy::Mount { slip, .. }) => {
                matches!(slip, MountSlip::Negated | MountSlip::Offset)
            }
            (Slip::TrackerForgotten, Remedy::Mount { slip, .. }) => {
                matches!(slip, MountSlip::Missing | MountSlip::Offset)
            }
            (Slip::TrackerInverted, Remedy::Mount { slip, .. }) => *slip == MountSlip::Inverted,
            (Slip::StreamQuaternions(a), Remedy::StreamQuaternions(b))
            | (Slip::GoalQuaternions(a), Remedy::GoalQuaternions(b)) => a == *b,
            (Slip::YUp, Remedy::Up { axis, .. }) => axis.vector() == Vector3::y(),
            (Slip::ZDown, Remedy::Up { axis, .. }) => axis.vector() == -Vector3::z(),
            (Slip::GravityUp, Remedy::Gravity { gravity_m_s2 }) => gravity_m_s2.z < 0.0,
            (Slip::Table(height_m) | Slip::Origin(height_m), Remedy::Surface { higher_m, .. }) => {
                (height_m - higher_m.z).abs() < 0.05
            }
            (Slip::Table(height_m) | Slip::Origin(height_m), Remedy::Origin { higher_m }) => {
                (height_m - higher_m.z).abs() < 0.05
            }
            (Slip::Slow(_), Remedy::Tempo { .. }) => true,
            (Slip::Positions(a), Remedy::PositionUnit(b))
            | (Slip::Lengths(a), Remedy::SceneUnit(b)) => a == *b,
            (Slip::Stamps(a), Remedy::StampUnit { factor }) => (a / factor - 1.0).abs() < 1e-9,
            (Slip::Frames(_), Remedy::FrameNumbers { .. }) => true,
            (Slip::Unmarked, Remedy::MissedCollision { index, .. }) => *index == 1,
            _ => false,
        }
    }

    /// The take with it; `None` where it would change nothing there.
    pub fn put_into(self, mut asked: Asked) -> Option<Asked> {
        let is_there = match self {
            Slip::TrackerNegated | Slip::TrackerForgotten => has_offset(&asked.scene),
            Slip::TrackerInverted => asked.scene.tracks.iter().any(|track| {
                has_offset(&asked.scene) && track.link_from_tracker.rotation.angle() > 0.1
            }),
            Slip::GoalQuaternions(_) => asked.scene.goals.iter().any(turns),
            Slip::Table(_) => asked.scene.events.iter().any(|event| {
                let collision = event.kind.collision();
                collision.is_some_and(|collision| is_on_table(&asked.scene, collision))
            }),
            // Acted times have no unit of their own.
            Slip::Slow(_) => asked.scene.timing == Timing::Known,
            Slip::Unmarked => forgettable(&asked.scene),
            _ => true,
        };
        if !is_there {
            return None;
        }
        let scene = &mut asked.scene;
        let mount = |scene: &mut Scene, change: fn(&mut Isometry3<f64>)| {
            change(&mut scene.tracks[TrackIndex(0)].link_from_tracker);
        };
        match self {
            Slip::None => {}
            Slip::TrackerNegated => mount(scene, |m| m.translation.vector *= -1.0),
            Slip::TrackerForgotten => mount(scene, |m| m.translation = Translation3::identity()),
            Slip::TrackerInverted => mount(scene, |m| *m = m.inverse()),
            Slip::StreamQuaternions(slip) => each_sample(&mut asked.events, |sample| {
                let [x, y, z, w] = sample.quaternion_xyzw;
                sample.quaternion_xyzw = match slip {
                    QuaternionSlip::ScalarFirst => [w, x, y, z],
                    QuaternionSlip::ScalarLast => [y, z, w, x],
                    QuaternionSlip::Inverse => [-x, -y, -z, w],
                };
            }),
            Slip::GoalQuaternions(_) => {
                for goal in &mut scene.goals {
                    if let GoalTarget::Pose { world_from_body } = &mut goal.target {
                        let q = world_from_body.rotation.into_inner();
                        let typed = Quaternion::new(q.i, q.j, q.k, q.w);
                        world_from_body.rotation = UnitQuaternion::new_unchecked(typed);
                    }
                }
            }
            Slip::YUp => turn(&mut asked.events, &-Vector3::x_axis(), 0.5),
            Slip::ZDown => turn(&mut asked.events, &Vector3::x_axis(), 1.0),
            Slip::GravityUp => scene.gravity_m_s2 *= -1.0,
            // The table is where it was, and so is the performance: the scene says it is lower.
            Slip::Table(height_m) => {
                for surface in &mut scene.surfaces {
                    if let contact::Feature::Face { point_m, normal } = surface.geometry
                        && normal.z > 0.9
                    {
                        surface.geometry =
                            contact::Feature::face(point_m - normal * height_m, normal);
                    }
                }
            }
            Slip::Origin(height_m) => each_sample(&mut asked.events, |s| {
                s.position_m.z += height_m;
            }),
            Slip::Slow(slowness) => stretch(&mut asked.events, slowness),
            Slip::Positions(unit) => {
                each_sample(&mut asked.events, |s| s.position_m /= unit.length_m());
            }
            Slip::Stamps(factor) => stretch(&mut asked.events, factor),
            Slip::Frames(rate_hz) => numbered(&mut asked.events, rate_hz),
            Slip::Lengths(unit) => *scene = shrunk(scene, 1e-3 / unit.length_m())?,
            Slip::Unmarked => {
                scene.events.remove(1);
                let marks = asked.events.iter().filter_map(TakeEvent::mark);
                let mut stamps: Vec<Stamp> = marks.map(|mark| mark.stamp).collect();
                stamps.sort_unstable();
                let second = stamps[1];
                let is_second = |event: &TakeEvent| event.mark().is_some_and(|m| m.stamp == second);
                asked.events.retain(|event| !is_second(event));
            }
        }
        Some(asked)
    }
}

/// Whether the first two events are collisions with a table, and nothing is asked at events.
fn forgettable(scene: &Scene) -> bool {
    let collisions = scene.events.iter().map(|event| event.kind.collision());
    let mut first = collisions.take(2);
    scene.goals.is_empty()
        && scene.events.len() > 2
        && first.all(|of| of.is_some_and(|of| is_on_table(scene, of)))
}

/// Whether a body hits a level plane.
fn is_on_table(scene: &Scene, collision: &Collision) -> bool {
    let surfaces = collision
        .contacts
        .iter()
        .filter_map(|touching| touching.other);
    let mut surfaces = surfaces.filter_map(|surface| scene.surfaces.get(surface));
    collision.partner == Partner::World
        && surfaces.any(|surface| surface.plane().is_some_and(|(_, normal)| normal.z > 0.9))
}

fn words(slip: QuaternionSlip) -> &'static str {
    match slip {
        QuaternionSlip::ScalarFirst => "w first",
        QuaternionSlip::ScalarLast => "w last",
        QuaternionSlip::Inverse => "body from world",
    }
}

fn has_offset(scene: &Scene) -> bool {
    let mount = &scene.tracks[TrackIndex(0)].link_from_tracker;
    mount.translation.vector.norm() > 1e-6
}

fn turns(goal: &Goal) -> bool {
    matches!(goal.target, GoalTarget::Pose { .. })
}

fn turn(events: &mut [TakeEvent], axis: &nalgebra::UnitVector3<f64>, half_turns: f64) {
    let turn = UnitQuaternion::from_axis_angle(axis, std::f64::consts::PI * half_turns);
    each_sample(events, |sample| {
        let [x, y, z, w] = sample.quaternion_xyzw;
        let q = turn.into_inner() * Quaternion::new(w, x, y, z);
        sample.position_m = turn * sample.position_m;
        sample.quaternion_xyzw = [q.i, q.j, q.k, q.w];
    });
}

/// Stamps as numbers of frames since the first sample, a second each.
fn numbered(events: &mut [TakeEvent], rate_hz: f64) {
    stretch(events, rate_hz);
    let first = events.iter().find_map(|event| match event {
        TakeEvent::Pose { sample, .. } => Some(sample.stamp.0),
        TakeEvent::Mark(_) => None,
    });
    let first = first.unwrap_or(0);
    each_sample(events, |sample| {
        let frames = ((sample.stamp.0 - first) as f64 * 1e-9).round();
        sample.stamp.0 = first + frames as i64 * 1_000_000_000;
    });
}

/// A scene with all lengths multiplied.
fn shrunk(scene: &Scene, factor: f64) -> Option<Scene> {
    let mut scene = scene.clone();
    for link in &mut scene.links {
        link.shape = match &link.shape {
            Shape::Cuboid { half_extents_m } => Shape::Cuboid {
                half_extents_m: half_extents_m * factor,
            },
            Shape::Cylinder {
                half_length_m,
                radius_m,
            } => Shape::Cylinder {
                half_length_m: half_length_m * factor,
                radius_m: radius_m * factor,
            },
            // The hat's moments are given and not its shape's.
            Shape::Hull { points_m } => Shape::Hull {
                points_m: points_m.iter().map(|p| p * factor).collect(),
            },
            _ => return None,
        };
        if !matches!(link.shape, Shape::Hull { .. }) {
            let moments_kg_m2 = link.body.moments_kg_m2() * (factor * factor);
            link.body = Body::new(link.body.mass_kg(), moments_kg_m2).ok()?;
        }
        for feature in &mut link.features {
            feature.geometry = part(&feature.geometry, factor)?;
        }
    }
    for track in &mut scene.tracks {
        track.link_from_tracker.translation.vector *= factor;
    }
    for surface in &mut scene.surfaces {
        surface.geometry = part(&surface.geometry, factor)?;
    }
    scene.obstacles.clear();
    for goal in &mut scene.goals {
        match &mut goal.target {
            GoalTarget::Pose { world_from_body } => world_from_body.translation.vector *= factor,
            GoalTarget::PositionWithin { lower_m, upper_m } => {
                *lower_m *= factor;
                *upper_m *= factor;
            }
            GoalTarget::Condition(condition) => {
                *condition = condition.clone().with_lengths_scaled(factor);
            }
        }
    }
    Some(scene)
}

fn part(part: &contact::Feature, factor: f64) -> Option<contact::Feature> {
    match *part {
        contact::Feature::Point { point_m, radius_m } => Some(contact::Feature::Point {
            point_m: point_m * factor,
            radius_m: radius_m * factor,
        }),
        contact::Feature::Face { point_m, normal } => {
            Some(contact::Feature::face(point_m * factor, normal))
        }
        _ => None,
    }
}

/// A kind of performance that is right.
pub struct Base {
    /// Unique.
    pub name: String,
    /// Performances into which each mistake is put: fewer where an estimate takes long.
    pub seeds: u64,
    /// The take of a seed.
    pub make: Make,
}

/// Performances into which the mistakes are put.
pub fn bases() -> Vec<Base> {
    let mut bases = vec![
        Base {
            name: "cube, tracker's noise only".into(),
            seeds: 20,
            make: Box::new(toss),
        },
        Base {
            name: "die of 16 mm, known, 1×".into(),
            seeds: 20,
            make: Box::new(die),
        },
    ];
    for (is_known, distortion) in [(true, 1.0), (false, 1.0), (true, 2.0), (false, 2.0)] {
        let timing = if is_known { "known" } else { "unknown" };
        let acting = at(is_known, distortion);
        let mut add = |name: &str, seeds: u64, make: Make| {
            bases.push(Base {
                name: format!("{name}, {timing}, {distortion}×"),
                seeds,
                make,
            });
        };
        let seeds = match (is_known, distortion > 1.0) {
            (true, false) => 20,
            (true, true) | (false, false) => 4,
            (false, true) => 1,
        };
        add(
            "pencil",
            seeds,
            Box::new(move |seed| Ok(pencil(&acting, seed))),
        );
        add("cube", seeds, Box::new(move |seed| cube(&acting, seed)));
        let hat = move |seed| Ok(asked(&hat_box::truth(), &acting, seed));
        add("hat and box", seeds.div_ceil(5), Box::new(hat));
    }
    bases
}

/// A cube with a tracker beside its middle.
fn cube(acting: &Acting, seed: u64) -> Result<Asked, String> {
    let truth = bounces(1 + (seed % 2) as usize, seed).map_err(|error| error.to_string())?;
    Ok(asked(&truth, acting, seed))
}
