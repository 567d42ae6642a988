//! Two solids that meet, moved back along their motion to where they first overlap.

use nalgebra::Vector3;

use super::fitted::FittedView;
use crate::math::Pose;
use crate::motion::LinkIndex;
use crate::physics::contact::{Contact, Frame, Touch};
use crate::physics::shape::Solid;
use crate::physics::{Shape, State};

/// Longest time by which two solids are moved back \[s\], and number of bisections.
const BACK_S: f64 = 0.25;
const HALVINGS: usize = 16;
/// Distance of a contact point from a solid that is not counted, relative to the solid's radius.
const SLACK: f64 = 0.02;

/// Two solids that meet, on the motions by which they do.
pub(super) struct Solids<'a> {
    view: &'a FittedView<'a>,
    shapes: [&'a Shape; 2],
    solids: [Solid; 2],
    point: Solid,
    /// The first, and the second if it moves.
    links: (LinkIndex, Option<LinkIndex>),
    /// Where the second stands otherwise.
    standing: Pose,
}

impl<'a> Solids<'a> {
    pub(super) fn new(view: &'a FittedView<'a>, obstacle: Option<usize>) -> Option<Self> {
        let links = view.links();
        let first = *links.first()?;
        let scene = view.scene;
        let (shape, second, standing) = match obstacle {
            Some(obstacle) => {
                let obstacle = &scene.obstacles[obstacle];
                (&obstacle.shape, None, obstacle.world_from_shape)
            }
            None => {
                let second = *links.get(1)?;
                (&scene.links[second].shape, Some(second), Pose::identity())
            }
        };
        // Without fits there is nothing to rank by.
        for link in [Some(first), second].into_iter().flatten() {
            view.fitted.state(link, false, 0.0)?;
        }
        let shapes = [&scene.links[first].shape, shape];
        let point = Shape::Sphere { radius_m: 1e-6 };
        Some(Self {
            view,
            shapes,
            solids: [shapes[0].solid().ok()?, shape.solid().ok()?],
            point: point.solid().ok()?,
            links: (first, second),
            standing,
        })
    }

    fn states(&self, after_s: f64) -> (State, Option<State>) {
        let state = |link: LinkIndex| {
            let state = self.view.fitted.state(link, false, after_s);
            state.expect("the fit is there at all times")
        };
        (state(self.links.0), self.links.1.map(state))
    }

    pub(super) fn distance_m(&self, after_s: f64) -> f64 {
        let (first, second) = self.states(after_s);
        let there = second.map_or(self.standing, |state| pose(&state));
        let distance = self.solids[0].distance_m(&pose(&first), &self.solids[1], &there);
        distance.unwrap_or(f64::INFINITY)
    }

    /// Beginning of their overlap relative to the event \[s\]; zero where they do not overlap at
    /// it.
    pub(super) fn first_overlap_s(&self) -> f64 {
        if self.distance_m(0.0) >= 0.0 || self.distance_m(-BACK_S) < 0.0 {
            return 0.0;
        }
        let (mut apart_s, mut inside_s) = (-BACK_S, 0.0);
        for _ in 0..HALVINGS {
            let middle_s = 0.5 * (apart_s + inside_s);
            if self.distance_m(middle_s) < 0.0 {
                inside_s = middle_s;
            } else {
                apart_s = middle_s;
            }
        }
        apart_s
    }

    /// Size of a contact's gap at that time plus the distance of its points from the solids \[m\];
    /// `None` where it recedes from a fixed solid.
    pub(super) fn nearness_m(&self, contact: &Contact, after_s: f64) -> Option<f64> {
        let (first, second) = self.states(after_s);
        let there = second.map_or_else(Frame::world, |state| Frame::of(&state));
        let touch = contact.touch(&Frame::of(&first), &there).ok()?;
        let still = State {
            velocity_m_s: Vector3::zeros(),
            angular_velocity_rad_s: Vector3::zeros(),
            ..first
        };
        let speed_m_s = approach_m_s(&touch, &first, second.as_ref().unwrap_or(&still));
        // A feature of the static world is in world axes.
        let on_second_m = match second {
            Some(_) => Pose::from(touch.on_b_m),
            None => self.standing.inverse() * Pose::from(touch.on_b_m),
        };
        // Errors of the fits may put a point off its solid.
        let off_m = |which: usize, at: &Pose| {
            let slack_m = SLACK * self.shapes[which].radius_m();
            let distance = self.solids[which].distance_m(&Pose::identity(), &self.point, at);
            distance
                .ok()
                .map(|distance_m| (distance_m - slack_m).max(0.0))
        };
        let beside_m = off_m(0, &Pose::from(touch.on_a_m))? + off_m(1, &on_second_m)?;
        // Excludes the far sides of fixed solids; one of two bodies may recede before the other.
        let meets = second.is_some() || speed_m_s < 0.0;
        meets.then_some(touch.gap_m.abs() + beside_m)
    }
}

fn pose(state: &State) -> Pose {
    Pose::from_parts(state.position_m.into(), state.orientation)
}

/// Rate of the gap [m/s]; negative approaching. For a fixed second solid its point does not matter.
fn approach_m_s(touch: &Touch, first: &State, second: &State) -> f64 {
    let velocity = |state: &State, point_m: &Vector3<f64>| {
        state.velocity_m_s + state.orientation * state.angular_velocity_rad_s.cross(point_m)
    };
    let apart = velocity(first, &touch.on_a_m) - velocity(second, &touch.on_b_m);
    touch.normal.dot(&apart)
}
