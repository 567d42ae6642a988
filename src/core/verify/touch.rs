//! Checks whether the expected part of a body touches first.

use super::expected;
use super::meeting::{MeetingPair, World};
use crate::motion::{Against, LinkIndex, Touch};

/// Number of halvings of the interval in which the first touch lies.
const HALVINGS: usize = 50;

/// Least step back from an event in the search for the first touch, as a way travelled \[m\].
const WAY_M: f64 = 1e-4;

/// The first touches of every body at every collision, partner by partner, at the end of the flight
/// before it. Collisions that leave the feature or the partner open are left out.
pub(super) fn touches(world: &World) -> Vec<Touch> {
    let mut touches = Vec::new();
    for event in &world.estimate.events {
        let Some(collision) = world.scene.events[event.event].kind.collision() else {
            continue;
        };
        for link in collision.links() {
            for (against, features) in expected::expected(world.scene, collision, link) {
                touches.extend(touch(
                    world,
                    event.event,
                    event.time_s,
                    link,
                    against,
                    features,
                ));
            }
        }
    }
    touches
}

fn touch(
    world: &World,
    event: usize,
    time_s: f64,
    index: LinkIndex,
    against: Against,
    expected: Vec<usize>,
) -> Option<Touch> {
    let link = &world.links[index];
    let arc = link.ending_at(time_s)?;
    let meeting = MeetingPair {
        index,
        link,
        arc,
        partner: world.partner(against, Some(time_s))?,
        from_s: arc.start_s,
        to_s: arc.end_s,
    };
    let closest = meeting.closest(time_s);
    let of_features_m = expected
        .iter()
        .map(|&feature| meeting.feature_gap_m(time_s, feature, &closest.point_m))
        .fold(f64::INFINITY, f64::min);
    let lead_m = of_features_m - closest.gap_m;
    let found = expected::owner(
        link.of_scene,
        link.is_declared(),
        &expected,
        &closest.point_m,
    );
    let is_expected = found.is_some_and(|found| expected.contains(&found));
    Some(Touch {
        event,
        link: index,
        against,
        found_point_m: closest.point_m,
        found,
        lead_m,
        found_time_s: if lead_m > 0.0 {
            first_touch_s(&meeting)
        } else {
            time_s
        },
        overlap_m: 0.0,
        is_wrong: lead_m > world.scene.tolerance_m && !is_expected,
        expected,
    })
}

/// Time at which the shape first touched the partner in which it is at the end of the meeting
/// \[s\].
fn first_touch_s(meeting: &MeetingPair) -> f64 {
    let speed_m_s = meeting.speed_bound_m_s().max(f64::MIN_POSITIVE);
    let gap_m = |time_s: f64| meeting.closest(time_s).gap_m;
    let mut inside_s = meeting.to_s;
    let mut depth_m = -gap_m(inside_s);
    if depth_m <= 0.0 {
        return inside_s;
    }
    let mut outside_s = inside_s;
    while depth_m > 0.0 {
        if outside_s <= meeting.from_s {
            return meeting.from_s;
        }
        inside_s = outside_s;
        outside_s = (outside_s - depth_m.max(WAY_M) / speed_m_s).max(meeting.from_s);
        depth_m = -gap_m(outside_s);
    }
    for _ in 0..HALVINGS {
        let middle_s = 0.5 * (outside_s + inside_s);
        if gap_m(middle_s) > 0.0 {
            outside_s = middle_s;
        } else {
            inside_s = middle_s;
        }
    }
    inside_s
}
