//! The state of a body at any time of its motion, and how far what trackers saw is from it.

use nalgebra::Vector3;

use super::frames::{FramedPiece, pieces};
use crate::math::so3;
use crate::motion::held::HeldEstimate;
use crate::motion::{Estimate, LinkIndex, Scene, Seen, Sketch, TrackIndex, TreeEstimate};
use crate::physics::State;
use crate::physics::tree::{Snapshot, Tree};

/// The motion of one link. Of a failed estimate it may be of any numbers, or none.
pub struct MovedBody<'a> {
    scene: &'a Scene,
    estimate: &'a Estimate,
    link: LinkIndex,
    by: MovedLink<'a>,
}

/// By what a link moves.
enum MovedLink<'a> {
    Itself(Vec<FramedPiece<'a>>),
    Hand(&'a HeldEstimate),
    Joints {
        tree: Box<Tree>,
        motion: &'a TreeEstimate,
        place: usize,
    },
}

impl<'a> MovedBody<'a> {
    /// That of a link; `None` where it has none. The scene is as estimated.
    pub fn new(scene: &'a Scene, estimate: &'a Estimate, link: LinkIndex) -> Option<Self> {
        let mechanism = scene.mechanism_of(link);
        let by = match (estimate.held_motion(link), scene.joint_tree(mechanism)) {
            (Some(held), _) => MovedLink::Hand(held),
            (None, Some(joined)) => MovedLink::Joints {
                tree: Box::new(scene.tree_model_with(joined, &estimate.held)),
                motion: estimate.tree_motion(mechanism)?,
                place: joined.place_of(link)?,
            },
            (None, None) => MovedLink::Itself(pieces(scene, estimate, link)),
        };
        let moving = Self {
            scene,
            estimate,
            link,
            by,
        };
        moving.span_s().is_some().then_some(moving)
    }

    /// From when to when it is known \[s\].
    pub fn span_s(&self) -> Option<[f64; 2]> {
        match &self.by {
            MovedLink::Itself(pieces) => {
                Some([pieces.first()?.span_s()[0], pieces.last()?.span_s()[1]])
            }
            MovedLink::Hand(_) => self.estimate.extent_s(),
            MovedLink::Joints { motion, .. } => Some(motion.span_s()),
        }
    }

    /// The states at physical times \[s\] of the frame in which the scene gives the link: its origin, world from its axes,
    /// the velocity of that origin, and the angular velocity in its axes. At an impact that before it; beyond the ends the motion
    /// is continued, that of joined bodies stays.
    pub fn states(&self, times_s: &[f64]) -> Vec<State> {
        let link_from_given = &self.scene.links[self.link].link_from_given;
        let arm = link_from_given.translation.vector;
        let given = self.link_states(times_s).into_iter().map(|of| {
            let swept = of.angular_velocity_rad_s.cross(&arm);
            State {
                position_m: of.position_m + of.orientation * arm,
                orientation: of.orientation * link_from_given.rotation,
                velocity_m_s: of.velocity_m_s + of.orientation * swept,
                angular_velocity_rad_s: link_from_given
                    .rotation
                    .inverse_transform_vector(&of.angular_velocity_rad_s),
            }
        });
        given.collect()
    }

    /// The same of the centre of mass and the principal axes.
    fn link_states(&self, times_s: &[f64]) -> Vec<State> {
        let gravity_m_s2 = &self.estimate.gravity_m_s2;
        let times_s = times_s.iter();
        match &self.by {
            MovedLink::Hand(held) => times_s.map(|time_s| held.state(*time_s)).collect(),
            MovedLink::Itself(pieces) => times_s
                .map(|time_s| {
                    let at = pieces.iter().position(|of| *time_s <= of.span_s()[1]);
                    match &pieces[at.unwrap_or(pieces.len() - 1)] {
                        FramedPiece::Arc(of) => self.scene.flown(of.arc, gravity_m_s2, *time_s),
                        FramedPiece::Grip(of) => of.state(*time_s),
                        FramedPiece::Pressed(of) => of.state(*time_s),
                    }
                })
                .collect(),
            MovedLink::Joints {
                tree,
                motion,
                place,
            } => {
                let mut snapshot = Snapshot::new(tree, gravity_m_s2);
                let states = times_s.map(|time_s| {
                    let time_s = time_s.min(motion.span_s()[1]);
                    snapshot.set(&motion.state_before(tree, gravity_m_s2, time_s));
                    snapshot.link_state(*place)
                });
                states.collect()
            }
        }
    }
}

/// What a track saw less what the motion shows it, at one sample; `None` of what it does not see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenLess {
    /// Acted time [s since the sketch's origin].
    pub acted_s: f64,
    /// Physical time \[s\].
    pub time_s: f64,
    /// Of the centre of mass, or of the point that is seen [m, world].
    pub position_m: Option<Vector3<f64>>,
    /// Rotation vector from the motion to what is seen, about the principal axes \[rad\].
    pub turn_rad: Option<Vector3<f64>>,
}

/// How far each used sample of a track is from the motion, in order of physical time.
pub fn seen_less_moving(
    scene: &Scene,
    estimate: &Estimate,
    sketch: &Sketch,
    track: TrackIndex,
) -> Vec<SeenLess> {
    let of = &scene.tracks[track];
    let (Some(moving), Some(stream)) = (
        MovedBody::new(scene, estimate, of.link),
        sketch.tracks.get(track),
    ) else {
        return Vec::new();
    };
    let times = estimate.all_sample_times();
    let mut times: Vec<_> = times.filter(|time| time.track == track).collect();
    times.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    let times_s: Vec<f64> = times.iter().map(|time| time.time_s).collect();
    let states = moving.link_states(&times_s).into_iter().zip(times);
    let each = states.filter_map(|(state, time)| {
        let at = stream
            .samples
            .binary_search_by_key(&time.stamp, |sample| sample.stamp);
        let sample = &stream.samples[at.ok()?];
        let position_m = sample.seen.position_m().map(|seen_m| match sample.seen {
            Seen::Point(_) => seen_m - state.position_m - state.orientation * of.point_m(),
            _ => seen_m - state.position_m,
        });
        let turn_rad = match sample.seen {
            Seen::Pose { orientation, .. } | Seen::Orientation(orientation) => {
                Some(so3::log(&(state.orientation.inverse() * orientation)))
            }
            Seen::Point(_) | Seen::Direction(_) => None,
        };
        Some(SeenLess {
            acted_s: sample.acted_s,
            time_s: time.time_s,
            position_m,
            turn_rad,
        })
    });
    each.collect()
}
