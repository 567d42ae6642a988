//! What is to be known of a whole recording before its first pose can be used: whether a stamp of zero is a time,
//! by how much its two clocks differ, and which frames it has.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use nalgebra::Vector3;

use super::error::{IngestError, listed};
use super::frames::{Frames, Rooted, frame_name, is_optical, may_be_camera};
use super::route::{Route, RouteFeed, RouteFormat};
use crate::motion::Stamp;
use crate::wire::container::Container;
use crate::wire::decode::PoseFormat;
use crate::wire::{FramedPose, MarkFormat};

/// Number of frames of poses that are kept of a topic: every message may have another.
const FRAMES_KEPT: usize = 1000;

/// Stamps that begin before are of a clock that began with the recording \[ns\]: a day.
const OWN_CLOCK_NS: i64 = 86_400 * 1_000_000_000;

/// Log times and stamps that differ by less are of one clock \[ns\]: what a message takes on its way, and more.
const ONE_CLOCK_NS: i64 = 1_000_000_000;

/// Messages that are looked at; of others it is taken to be as of these.
const MESSAGES: u64 = 1_000_000;

/// What was found.
#[derive(Clone, Debug, Default)]
pub(super) struct Survey {
    /// One per route.
    pub(super) routes: Vec<Surveyed>,
    /// The frames of poses, as messages name them.
    pub(super) rooted: BTreeMap<String, Rooted>,
    /// What log times are ahead of stamps \[ns\], where the two are of different clocks; else 0.
    pub(super) clocks_apart_ns: i64,
}

/// When a message was that has no stamp, or one of zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fallback {
    /// At the beginning of the topic's clock.
    Zero,
    /// When it was logged, by a clock that is so far ahead \[ns\].
    Logged { log_time: Stamp, ahead_ns: i64 },
}

impl Fallback {
    /// On the clock of the stamps.
    pub(super) fn stamp(self) -> Stamp {
        match self {
            Self::Zero => Stamp(0),
            Self::Logged { log_time, ahead_ns } => Stamp(log_time.0.saturating_sub(ahead_ns)),
        }
    }

    /// Whether it is another time than that of the stamp.
    pub(super) fn is_logged(self) -> bool {
        self.stamp() != Stamp(0)
    }
}

/// What was found on the topic of a route.
#[derive(Clone, Debug, Default)]
pub(super) struct Surveyed {
    /// Messages with a stamp that is not zero.
    stamped: u64,
    /// The least of those stamps, of either sign \[ns\].
    least_ns: i64,
    /// Whether a message without came after one with.
    is_missing: bool,
    /// Frames in which poses are given, seen from those in which they stand, with what was seen in each.
    pub(super) frames: BTreeMap<String, FrameSeen>,
}

/// What was seen in a frame.
#[derive(Clone, Debug)]
pub(super) struct FrameSeen {
    /// Poses.
    pub(super) count: u64,
    /// The first of them.
    first: FramedPose,
    /// Whether any other was another.
    pub(super) moves: bool,
}

impl Surveyed {
    /// Whether a stamp of zero is a time, the beginning of a clock: else, or where there is one among others, it is none.
    pub(super) fn zero_is_a_time(&self) -> bool {
        self.stamped > 0 && self.least_ns < OWN_CLOCK_NS && !self.is_missing
    }

    fn stamp(&mut self, stamp: Option<Stamp>) {
        if let Some(stamp) = stamp {
            let size_ns = stamp.0.saturating_abs();
            self.least_ns = match self.stamped {
                0 => size_ns,
                _ => self.least_ns.min(size_ns),
            };
            self.stamped += 1;
        } else {
            self.is_missing |= self.stamped > 0;
        }
    }

    fn pose(&mut self, pose: &FramedPose) {
        self.stamp(pose.stamp);
        let has_place = self.frames.len() < FRAMES_KEPT;
        match self.frames.get_mut(&pose.parent) {
            Some(seen) => {
                seen.count += 1;
                seen.moves |= seen.first.position_m != pose.position_m
                    || seen.first.quaternion_xyzw != pose.quaternion_xyzw;
            }
            None if has_place => {
                let seen = FrameSeen {
                    count: 1,
                    first: pose.clone(),
                    moves: false,
                };
                self.frames.insert(pose.parent.clone(), seen);
            }
            None => {}
        }
    }
}

impl Survey {
    /// Looks through a recording's messages once.
    pub(super) fn of(
        container: &Container,
        routes: &[Route],
        feeds: &BTreeMap<u16, RouteFeed>,
    ) -> Self {
        let transforms: BTreeMap<u16, PoseFormat> = container
            .channels()
            .iter()
            .filter_map(|(id, channel)| {
                let schema = container.schema_of(channel)?;
                let format = PoseFormat::of(&schema.name, &channel.message_encoding)?;
                format.relates_frames().then_some((*id, format))
            })
            .collect();
        let mut survey = Self {
            routes: vec![Surveyed::default(); routes.len()],
            ..Self::default()
        };
        let mut frames = Frames::default();
        let mut apart_ns: Option<i64> = None;
        let mut poses: Vec<FramedPose> = Vec::new();
        let mut looked = 0;
        let mut walk = container.walk();
        while let Some(message) = walk.next_message() {
            let feed = feeds.get(&message.channel_id);
            let relates = transforms.get(&message.channel_id);
            let format = match (feed.map(|feed| feed.format), relates) {
                (Some(RouteFormat::Poses(format)), _) => format,
                (None | Some(RouteFormat::Keyframes), Some(format)) => *format,
                (Some(RouteFormat::Marks(format)), _) => {
                    survey.mark(feed, format, message.data);
                    continue;
                }
                (None | Some(RouteFormat::Keyframes), None) => continue,
            };
            looked += 1;
            if looked > MESSAGES {
                break;
            }
            poses.clear();
            if format.decode(message.data, &mut poses).is_err() {
                continue;
            }
            let log_ns = i64::try_from(message.log_time).unwrap_or(i64::MAX);
            for pose in &poses {
                if relates.is_some() {
                    frames.note(pose);
                }
                for route in feed.iter().flat_map(|feed| &feed.routes) {
                    if !routes[*route].has_child(pose) {
                        continue;
                    }
                    survey.routes[*route].pose(pose);
                    let ahead_ns = pose.stamp.map(|stamp| log_ns.saturating_sub(stamp.0));
                    apart_ns = apart_ns.into_iter().chain(ahead_ns).min();
                }
            }
        }
        let is_other = |apart_ns: &i64| apart_ns.saturating_abs() > ONE_CLOCK_NS;
        survey.clocks_apart_ns = apart_ns.filter(is_other).unwrap_or(0);
        survey.root(&frames);
        survey
    }

    fn mark(&mut self, feed: Option<&RouteFeed>, format: MarkFormat, data: &[u8]) {
        let decoded = format.decode(data);
        let stamp = decoded.ok().and_then(|mark| mark.stamp);
        for route in feed.iter().flat_map(|feed| &feed.routes) {
            self.routes[*route].stamp(stamp);
        }
    }

    /// Puts together what was seen in frames that stand in one.
    fn root(&mut self, frames: &Frames) {
        for of in &mut self.routes {
            let mut roots: BTreeMap<String, FrameSeen> = BTreeMap::new();
            for (frame, seen) in std::mem::take(&mut of.frames) {
                let rooted = frames.rooted(&frame);
                match roots.get_mut(&rooted.root) {
                    Some(same) => {
                        same.count += seen.count;
                        same.moves |= seen.moves;
                    }
                    None => {
                        roots.insert(rooted.root.clone(), seen);
                    }
                }
                self.rooted.insert(frame, rooted);
            }
            of.frames = roots;
        }
    }

    /// When a message of a route was that has no stamp, or one of zero.
    pub(super) fn fallback(&self, route: usize, log_time: Stamp) -> Fallback {
        match self.routes[route].zero_is_a_time() {
            true => Fallback::Zero,
            false => Fallback::Logged {
                log_time,
                ahead_ns: self.clocks_apart_ns,
            },
        }
    }

    /// The frame in which a message's frame stands; its own where it is not known.
    pub(super) fn root_of(&self, frame: &str) -> Rooted {
        let known = self.rooted.get(frame).cloned();
        known.unwrap_or_else(|| Rooted {
            root: frame_name(frame).to_owned(),
            root_from_frame: None,
            moves_in: None,
        })
    }
}

/// Decides in which frame poses of a topic are read that are given in several: in that which the scene names, else in
/// the only one in which anything moves. Fails where neither tells.
pub(super) fn choose_frames(
    path: &Path,
    survey: &Survey,
    routes: &mut [Route],
    notes: &mut Vec<String>,
) -> Result<(), IngestError> {
    for (route, seen) in routes.iter_mut().zip(&survey.routes) {
        let frames = || seen.frames.keys().cloned().collect::<BTreeSet<String>>();
        if let Some(frame) = &route.frame {
            let root = survey.root_of(frame).root;
            if !seen.frames.contains_key(&root) && !seen.frames.is_empty() {
                return Err(IngestError::FrameAbsent {
                    path: path.to_owned(),
                    topic: route.topic.clone(),
                    frame: frame.clone(),
                    frames: frames(),
                });
            }
            route.frame = Some(root);
            continue;
        }
        if seen.frames.len() < 2 {
            continue;
        }
        let mut moving = seen.frames.iter().filter(|(_, of)| of.moves);
        let (Some((frame, of)), None) = (moving.next(), moving.next()) else {
            return Err(IngestError::ManyFrames {
                path: path.to_owned(),
                topic: route.topic.clone(),
                frames: frames(),
            });
        };
        let all: u64 = seen.frames.values().map(|of| of.count).sum();
        notes.push(format!(
            "poses on {} are given in {} frames ({}) by several publishers: the {} of {all} in {frame} are read, in the \
             others nothing moves",
            route.topic,
            seen.frames.len(),
            listed(&frames()),
            of.count
        ));
        route.frame = Some(frame.clone());
    }
    Ok(())
}

/// What frames say of the directions of their axes, for gravity in a direction.
pub(super) fn cameras(survey: &Survey, routes: &[Route], along: Vector3<f64>) -> Vec<String> {
    let read = survey.routes.iter().zip(routes).flat_map(|(seen, route)| {
        let is_read = |frame: &&String| route.frame.as_ref().is_none_or(|of| of == *frame);
        seen.frames.keys().filter(is_read)
    });
    let frames: BTreeSet<&String> = read.collect();
    // A scene that says another gravity than along −z knows about its axes.
    let is_usual = along.z < -0.5;
    let said = frames.into_iter().filter(|_| is_usual).filter_map(|frame| {
        let way = "say gravity_m_s2 in the scene, which is then in the camera's axes, or record on /tf_static how the \
                   camera stands";
        if is_optical(frame) {
            Some(format!(
                "poses are given in frame {frame}, that of a camera's picture: z looks ahead and y down, so gravity is \
                 along +y of a camera held level, and not along −z as in the scene; {way}"
            ))
        } else if may_be_camera(frame) {
            Some(format!(
                "poses are given in frame {frame}, by its name a camera's: where its z looks ahead, gravity is not along \
                 −z as in the scene; {way}"
            ))
        } else {
            None
        }
    });
    said.collect()
}
