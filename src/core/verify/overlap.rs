//! Overlaps of solids along the arcs, by conservative advancement.
//!
//! No point of a body moves faster than `|v| + |ω| r`. Where the distance is `d`, no overlap
//! deeper than `D` occurs before `(d + D)` has been travelled at that speed; the scan jumps
//! there. Where the deepest point belongs to a feature that is expected to touch that partner
//! before or after the flight, the feature's own depth counts. By how much the shape goes deeper
//! than a point that represents it is reported separately; edges, rims and faces are exact. The
//! scan misses nothing deeper than the tolerance, on ways of up to 25 m inside of others.

use super::expected;
use super::meeting::{MeetingPair, MeetingPartner, World};
use crate::motion::{LinkIndex, Observer, Penetration, Touch};
use crate::physics::contact::Feature;

/// Way travelled between two distance queries inside an overlap \[tolerances\], and at most \[m\].
const RESOLUTION: f64 = 0.25;
const RESOLUTION_M: f64 = 2.5e-4;

/// Greatest number of distance queries for one body and one partner on one arc.
const LOOKS: f64 = 1e6;

/// Steps of the golden section that refines the deepest overlap: to 1e-8 of the interval.
const SECTIONS: usize = 40;

/// The result of the distance query at one time.
struct OverlapLook {
    /// Distance of the shapes \[m\].
    gap_m: f64,
    /// Depth of the overlap that no expected contact explains \[m\]; negative outside.
    depth_m: f64,
    penetration: Penetration,
    /// The expected feature to which the body's deepest point belongs, if any.
    owner: Option<usize>,
}

/// The deepest overlap that no expected contact explains, if it is above the tolerance.
/// Records in the touches how deep the surroundings of their features go.
///
/// What was found so far where the observer ends it.
pub(super) fn deepest(
    world: &World,
    touches: &mut [Touch],
    observer: &mut dyn Observer,
) -> Option<Penetration> {
    deepest_of(world, world.meetings(), touches, observer)
}

/// The deepest overlap of links of which this says that nothing ties them.
pub(super) fn deepest_between(
    world: &World,
    are_apart: &dyn Fn(LinkIndex, LinkIndex) -> bool,
    observer: &mut dyn Observer,
) -> Option<Penetration> {
    let is_between = |meeting: &MeetingPair| match meeting.partner {
        MeetingPartner::Link { index, .. } => are_apart(meeting.index, index),
        MeetingPartner::Plane { .. } | MeetingPartner::Obstacle { .. } => false,
    };
    let meetings = world.meetings().filter(is_between);
    deepest_of(world, meetings, &mut [], observer)
}

fn deepest_of<'w>(
    world: &World,
    meetings: impl Iterator<Item = MeetingPair<'w>>,
    touches: &mut [Touch],
    observer: &mut dyn Observer,
) -> Option<Penetration> {
    let found = each_of(world, meetings, touches, observer).into_iter();
    found.fold(None, |deepest, of| Penetration::deeper(deepest, Some(of)))
}

/// The deepest overlap of every meeting in which it is above the tolerance and no expected contact explains it; those that
/// were found until the observer ended it.
pub(super) fn each(world: &World, observer: &mut dyn Observer) -> Vec<Penetration> {
    each_of(world, world.meetings(), &mut [], observer)
}

fn each_of<'w>(
    world: &World,
    meetings: impl Iterator<Item = MeetingPair<'w>>,
    touches: &mut [Touch],
    observer: &mut dyn Observer,
) -> Vec<Penetration> {
    let mut found = Vec::new();
    for meeting in meetings {
        if observer.should_stop() {
            break;
        }
        found.extend(OverlapScan::new(world, &meeting).run(touches, observer));
    }
    found
}

/// When bodies that go deeper into others, or into what stands, than the tolerance begin to \[s\], in order of time.
pub(super) fn begin_s(world: &World) -> Vec<f64> {
    let meetings = world.meetings();
    let begin = meetings.filter_map(|meeting| OverlapScan::new(world, &meeting).begins_s());
    let mut begin_s: Vec<f64> = begin.collect();
    begin_s.sort_by(f64::total_cmp);
    begin_s
}

struct OverlapScan<'w, 'm> {
    meeting: &'m MeetingPair<'w>,
    /// Features expected to touch the partner at a neighbouring event.
    expected: Vec<usize>,
    /// Expected features of the partner, if it is a body.
    expected_of_partner: Vec<usize>,
    /// Overlaps up to this depth are attributed to the scene's inaccuracy \[m\].
    tolerance_m: f64,
}

impl<'w, 'm> OverlapScan<'w, 'm> {
    fn new(world: &World, meeting: &'m MeetingPair<'w>) -> Self {
        let against = meeting.partner.against();
        let about = |link, against| {
            let mut features = world.expected_at(link, against, meeting.from_s);
            features.extend(world.expected_at(link, against, meeting.to_s));
            features
        };
        Self {
            meeting,
            expected: about(meeting.index, against),
            expected_of_partner: match meeting.partner {
                MeetingPartner::Link { index, .. } => {
                    about(index, crate::motion::Against::Link(meeting.index))
                }
                MeetingPartner::Plane { .. } | MeetingPartner::Obstacle { .. } => Vec::new(),
            },
            tolerance_m: world.scene.tolerance_m,
        }
    }

    fn resolution_m(&self) -> f64 {
        RESOLUTION_M.min(RESOLUTION * self.tolerance_m)
    }

    fn run(&self, touches: &mut [Touch], observer: &mut dyn Observer) -> Option<Penetration> {
        let MeetingPair { from_s, to_s, .. } = *self.meeting;
        let speed_m_s = self.meeting.speed_bound_m_s().max(f64::MIN_POSITIVE);
        let mut deepest: Option<Penetration> = None;
        let mut threshold_m = self.tolerance_m - self.resolution_m();
        let mut time_s = from_s;
        loop {
            let least_m = self.meeting.least_gap_m(time_s);
            let gap_m = if least_m > 0.0 {
                least_m
            } else {
                let look = self.look(time_s);
                self.note(&look, touches);
                if look.depth_m > threshold_m {
                    threshold_m = look.depth_m;
                    deepest = Some(look.penetration);
                }
                look.gap_m
            };
            if time_s >= to_s || observer.should_stop() {
                break;
            }
            let way_m = (gap_m + threshold_m).max(self.resolution_m());
            let step_s = (way_m / speed_m_s).max((to_s - from_s) / LOOKS);
            time_s = (time_s + step_s).min(to_s);
        }
        let refined = self.refined(deepest?.time_s, self.resolution_m() / speed_m_s);
        (refined.depth_m > self.tolerance_m).then_some(refined)
    }

    /// The last time before an overlap beyond the tolerance at which nothing touched.
    fn begins_s(&self) -> Option<f64> {
        let MeetingPair { from_s, to_s, .. } = *self.meeting;
        let speed_m_s = self.meeting.speed_bound_m_s().max(f64::MIN_POSITIVE);
        let (mut time_s, mut free_s) = (from_s, None);
        loop {
            let look = self.look(time_s);
            if look.depth_m > self.tolerance_m {
                return free_s;
            }
            if look.gap_m > 0.0 {
                free_s = Some(time_s);
            }
            if time_s >= to_s {
                return None;
            }
            let step_s = look.gap_m.max(self.resolution_m()) / speed_m_s;
            time_s = (time_s + step_s.max((to_s - from_s) / LOOKS)).min(to_s);
        }
    }

    fn look(&self, time_s: f64) -> OverlapLook {
        let closest = self.meeting.closest(time_s);
        let mut gap_m = closest.gap_m;
        let mut owner = None;
        if gap_m < 0.0 {
            let link = self.meeting.link.of_scene;
            let declared = self.meeting.link.is_declared();
            owner = expected::owner(link, declared, &self.expected, &closest.point_m)
                .filter(|feature| self.expected.contains(feature));
            let of_link = owner
                .filter(|&feature| matches!(link.features[feature].geometry, Feature::Point { .. }))
                .map(|feature| {
                    self.meeting
                        .feature_gap_m(time_s, feature, &closest.point_m)
                });
            let of_partner = self.meeting.partner_point_gap_m(
                time_s,
                &self.expected_of_partner,
                &closest.other_point_m,
            );
            // Where points represent both touching parts, the deeper of them counts.
            if let Some(of_feature) = of_link.into_iter().chain(of_partner).reduce(f64::min) {
                gap_m = gap_m.max(of_feature);
            }
        }
        OverlapLook {
            gap_m: closest.gap_m,
            depth_m: -gap_m,
            penetration: Penetration {
                link: self.meeting.index,
                against: self.meeting.partner.against(),
                time_s,
                depth_m: -gap_m,
                point_m: closest.point_m,
            },
            owner,
        }
    }

    fn note(&self, look: &OverlapLook, touches: &mut [Touch]) {
        let Some(owner) = look.owner else { return };
        let Penetration { link, against, .. } = look.penetration;
        let touch = touches.iter_mut().filter(|touch| {
            touch.link == link && touch.against == against && touch.expected.contains(&owner)
        });
        for touch in touch {
            touch.overlap_m = touch.overlap_m.max(-look.gap_m);
        }
    }

    /// The deepest overlap near a time, by golden-section search.
    fn refined(&self, time_s: f64, reach_s: f64) -> Penetration {
        const RATIO: f64 = 0.618_033_988_749_894_9;
        let mut lower_s = (time_s - reach_s).max(self.meeting.from_s);
        let mut upper_s = (time_s + reach_s).min(self.meeting.to_s);
        let mut best = self.look(time_s);
        for _ in 0..SECTIONS {
            let width_s = RATIO * (upper_s - lower_s);
            let (left, right) = (self.look(upper_s - width_s), self.look(lower_s + width_s));
            if left.depth_m > right.depth_m {
                upper_s = right.penetration.time_s;
            } else {
                lower_s = left.penetration.time_s;
            }
            for look in [left, right] {
                if look.depth_m > best.depth_m {
                    best = look;
                }
            }
        }
        best.penetration
    }
}
