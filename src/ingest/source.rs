//! Sources of takes, one event at a time.

use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;

use super::error::IngestError;
use super::frames::{Rooted, seen_from};
use super::path::PathSeen;
use super::report::{TakeReport, TopicReport};
use super::route::{Route, RouteFeed, RouteFormat};
use super::survey::Survey;
use crate::motion::{Keyframe, Stamp, TakeEvent};
use crate::wire::container::Walk;
use crate::wire::{FramedPose, decode_keyframe};

/// Number of names of frames that are kept: every message may have another.
const NAMES_KEPT: usize = 1000;

/// A source of the events of a take.
pub trait Source {
    /// The next event and its log time, in the order of the source; `None` at its end.
    fn next(&mut self) -> Result<Option<(Stamp, TakeEvent)>, IngestError>;
}

/// A take from memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MemorySource {
    events: VecDeque<(Stamp, TakeEvent)>,
}

impl MemorySource {
    /// Yields these events with these log times, in this order.
    pub fn new(events: impl IntoIterator<Item = (Stamp, TakeEvent)>) -> Self {
        Self {
            events: events.into_iter().collect(),
        }
    }
}

impl Source for MemorySource {
    fn next(&mut self) -> Result<Option<(Stamp, TakeEvent)>, IngestError> {
        Ok(self.events.pop_front())
    }
}

/// A take from a recording, in file order. It shares the recording's bytes and outlives it.
pub struct RecordingSource {
    path: PathBuf,
    walk: Walk,
    routes: Vec<Route>,
    feeds: BTreeMap<u16, RouteFeed>,
    /// Events of the last message that were not yet returned.
    ready: VecDeque<(Stamp, TakeEvent)>,
    poses: Vec<FramedPose>,
    survey: Survey,
    /// Frames of poses that were read, each with how it stands.
    frames: BTreeMap<String, Rooted>,
    /// What was read on each route.
    paths: Vec<PathSeen>,
    /// How many were returned.
    events: u64,
    report: TakeReport,
}

impl RecordingSource {
    pub(super) fn new(
        path: PathBuf,
        walk: Walk,
        routes: Vec<Route>,
        feeds: BTreeMap<u16, RouteFeed>,
        survey: Survey,
        mut report: TakeReport,
    ) -> Self {
        report.topics = routes
            .iter()
            .map(|route| TopicReport {
                topic: route.topic.clone(),
                ..TopicReport::default()
            })
            .collect();
        Self {
            path,
            walk,
            paths: vec![PathSeen::default(); routes.len()],
            routes,
            feeds,
            ready: VecDeque::new(),
            poses: Vec::new(),
            survey,
            frames: BTreeMap::new(),
            events: 0,
            report,
        }
    }

    /// Counts of what was found so far; complete once the source has ended.
    pub fn report(&self) -> &TakeReport {
        &self.report
    }

    /// Decodes the next message of the scene's channels. False at the end.
    fn read_message(&mut self) -> Result<bool, IngestError> {
        let Some(message) = self.walk.next_message() else {
            return Ok(false);
        };
        let Some(feed) = self.feeds.get(&message.channel_id) else {
            return Ok(true);
        };
        // Log times past the year 2262 are no times.
        let log_time = Stamp(i64::try_from(message.log_time).unwrap_or(i64::MAX));
        for &route in &feed.routes {
            self.report.topics[route].messages += 1;
        }
        if self.events >= self.report.sample_limit {
            self.report.beyond_limit += 1;
            return Ok(true);
        }
        let mut keyframe = None;
        let decoded = match feed.format {
            RouteFormat::Marks(format) => format.decode(message.data).map(|mark| {
                let route = feed.routes[0];
                let fallback = self.survey.fallback(route, log_time);
                let topic = &mut self.report.topics[route];
                topic.events += 1;
                topic.stamped_by_log_time +=
                    u64::from(mark.stamp.is_none() && fallback.is_logged());
                let mark = mark.mark(fallback.stamp());
                self.ready.push_back((log_time, TakeEvent::Mark(mark)));
            }),
            RouteFormat::Poses(format) => {
                self.poses.clear();
                format.decode(message.data, &mut self.poses)
            }
            RouteFormat::Keyframes => decode_keyframe(message.data).map(|of| keyframe = Some(of)),
        };
        let routes = feed.routes.clone();
        if let Err(error) = decoded {
            for route in routes {
                let topic = &mut self.report.topics[route];
                topic.undecodable += 1;
                topic.first_error.get_or_insert_with(|| error.clone());
            }
        } else if let Some(keyframe) = keyframe {
            for route in routes {
                self.route_keyframe(route, log_time, &keyframe)?;
            }
        } else if matches!(feed.format, RouteFormat::Poses(_)) {
            for route in routes {
                self.route_poses(route, log_time)?;
            }
        }
        Ok(true)
    }

    /// Hands a keyframe to a route's track. Fails where it cannot be estimated yet.
    fn route_keyframe(
        &mut self,
        route: usize,
        log_time: Stamp,
        keyframe: &Keyframe,
    ) -> Result<(), IngestError> {
        let topic = &mut self.report.topics[route];
        let route = &self.routes[route];
        let (Some(track), Some(mount)) = (route.track, &route.mount) else {
            return Ok(());
        };
        topic.events += 1;
        let refused = |reason: &'static str| IngestError::KeyframeNotEstimated {
            path: self.path.clone(),
            topic: route.topic.clone(),
            number: topic.events,
            reason,
        };
        let sample = mount.reading_of(keyframe, log_time, route.may_be_open);
        let sample = sample.map_err(refused)?;
        let offset_ns = log_time.0.saturating_sub(sample.stamp.0);
        let least = self.report.log_offset_ns.get_or_insert(offset_ns);
        *least = offset_ns.min(*least);
        let stream = route.stream;
        let event = TakeEvent::Pose {
            track,
            stream,
            sample,
        };
        self.ready.push_back((log_time, event));
        Ok(())
    }

    /// Hands the poses of the last message that belong to a route to its track's stream.
    fn route_poses(&mut self, index: usize, log_time: Stamp) -> Result<(), IngestError> {
        let topic = &mut self.report.topics[index];
        let route = &mut self.routes[index];
        let Some(track) = route.track else {
            return Ok(());
        };
        for pose in &self.poses {
            if route.seen.len() < NAMES_KEPT && !route.seen.contains(&pose.child) {
                route.seen.insert(pose.child.clone());
            }
            if !route.has_child(pose) {
                continue;
            }
            if route.child.is_none() && route.seen.len() > 1 {
                return Err(IngestError::Ambiguous {
                    path: self.path.clone(),
                    topic: route.topic.clone(),
                    children: route.seen.clone(),
                });
            }
            if self.frames.len() >= NAMES_KEPT {
                self.frames.clear();
            }
            if !self.frames.contains_key(&pose.parent) {
                let rooted = self.survey.root_of(&pose.parent);
                self.frames.insert(pose.parent.clone(), rooted);
            }
            let rooted = &self.frames[&pose.parent];
            if route
                .frame
                .as_ref()
                .is_some_and(|frame| *frame != rooted.root)
            {
                continue;
            }
            let fallback = self.survey.fallback(index, log_time);
            topic.events += 1;
            topic.stamped_by_log_time += u64::from(pose.stamp.is_none() && fallback.is_logged());
            let frames = &mut self.report.frame_ids;
            if frames.len() < NAMES_KEPT && !frames.contains(&rooted.root) {
                frames.insert(rooted.root.clone());
                self.report.notes.extend(standing(&pose.parent, rooted));
            }
            let sample = pose.sample(fallback.stamp());
            let sample = match &rooted.root_from_frame {
                Some(root_from_frame) => seen_from(root_from_frame, sample),
                None => sample,
            };
            self.paths[index].note(&sample);
            let offset_ns = log_time.0.saturating_sub(sample.stamp.0);
            let least = self.report.log_offset_ns.get_or_insert(offset_ns);
            *least = offset_ns.min(*least);
            let event = TakeEvent::Pose {
                track,
                stream: route.stream,
                sample,
            };
            self.ready.push_back((log_time, event));
        }
        Ok(())
    }

    /// Says what the readings of each topic were like, once.
    fn conclude(&mut self) {
        for (path, route) in std::mem::take(&mut self.paths).iter().zip(&self.routes) {
            self.report.mixed.extend(path.mixed(&route.topic));
            self.report.notes.extend(path.norms(&route.topic));
        }
    }

    /// Fails at the end where a child frame that the scene names never came.
    fn check_children(&self) -> Result<(), IngestError> {
        for (route, topic) in self.routes.iter().zip(&self.report.topics) {
            if let Some(child) = &route.child
                && topic.events == 0
                && !route.seen.is_empty()
            {
                return Err(IngestError::ChildAbsent {
                    path: self.path.clone(),
                    topic: route.topic.clone(),
                    child: child.clone(),
                    children: route.seen.clone(),
                });
            }
        }
        Ok(())
    }
}

impl Source for RecordingSource {
    fn next(&mut self) -> Result<Option<(Stamp, TakeEvent)>, IngestError> {
        loop {
            if let Some(event) = self.ready.pop_front() {
                self.events += 1;
                return Ok(Some(event));
            }
            if !self.read_message()? {
                self.check_children()?;
                self.conclude();
                return Ok(None);
            }
        }
    }
}

/// How a frame of poses was taken, in words, if it is not simply the world.
fn standing(frame: &str, rooted: &Rooted) -> Option<String> {
    let Rooted {
        root,
        root_from_frame,
        moves_in,
    } = rooted;
    match (root_from_frame, moves_in) {
        (Some(_), None) => Some(format!(
            "poses in frame {frame} are read in {root}, in which it stands by the recording's transforms"
        )),
        (None, None) => None,
        (_, Some(above)) => Some(format!(
            "poses in frame {frame} are read in {root}, which itself moves in {above}: expected one that stands still"
        )),
    }
}
