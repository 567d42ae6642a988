//! What is solid in a strobe picture, as it is seen through a camera.

use super::layout::Scale;
use super::lit::Strobe;
use super::plan::{Flash, Shows};
use crate::math::Pose;
use crate::motion::GoalTarget;
use crate::visual::{Camera, Outline, Subject, Visual, mesh, outline, visuals};

/// How much of the ground covers what is farthest.
const FOG: f64 = 0.55;

/// Something solid in the picture.
pub(super) struct Item {
    pub(super) outline: Outline,
    pub(super) nearness_m: f64,
    pub(super) look: Look,
}

/// How it is drawn.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Look {
    Body { colour: usize, shows: Shows },
    Obstacle,
    Goal,
}

pub(super) fn is_event(item: &Item) -> bool {
    matches!(
        item.look,
        Look::Body {
            shows: Shows::Event,
            ..
        }
    )
}

pub(super) fn seen(strobe: &Strobe, camera: &Camera, flash: &Flash) -> Item {
    let world_from_shape = strobe.world_from_shape(flash.link, &flash.world_from_link);
    Item {
        outline: outline(&strobe.surfaces[flash.link], &world_from_shape, camera),
        nearness_m: camera.nearness_m(&flash.world_from_link.translation.vector),
        look: Look::Body {
            colour: strobe.colours[flash.link],
            shows: flash.shows,
        },
    }
}

/// What stands still: obstacles, and goals that have a shape.
pub(super) fn standing(strobe: &Strobe, camera: &Camera) -> (Vec<Item>, Vec<Item>) {
    let (mut obstacles, mut goals) = (Vec::new(), Vec::new());
    for visual in visuals(strobe.scene, &[]) {
        let Some(shape) = &visual.shape else {
            continue;
        };
        let item = |look| Item {
            outline: outline(&mesh(shape), &visual.frame_from_shape, camera),
            nearness_m: camera.nearness_m(&visual.frame_from_shape.translation.vector),
            look,
        };
        match visual.subject {
            Subject::Obstacle(_) => obstacles.push(item(Look::Obstacle)),
            Subject::Goal(_) if is_shown(strobe, &visual) => goals.push(item(Look::Goal)),
            _ => {}
        }
    }
    (obstacles, goals)
}

/// Whether a goal is drawn: a pose that the motion has is drawn as its event.
fn is_shown(strobe: &Strobe, visual: &Visual) -> bool {
    let Subject::Goal(goal) = visual.subject else {
        return false;
    };
    let goal = &strobe.scene.goals[goal];
    let event = &strobe.scene.events[goal.event].name;
    match &goal.target {
        GoalTarget::Pose { world_from_body } => !strobe.flashes.iter().any(|flash| {
            let is_at = strobe
                .motion
                .events
                .iter()
                .any(|(at, name)| name == event && *at == flash.at);
            is_at && flash.link == goal.link && is_near(&flash.world_from_link, world_from_body)
        }),
        _ => true,
    }
}

/// Whether two poses are drawn as one.
fn is_near(a: &Pose, b: &Pose) -> bool {
    (a.translation.vector - b.translation.vector).norm() < 1e-3
        && a.rotation.angle_to(&b.rotation) < 1e-2
}

/// Least and greatest of both coordinates of what bodies cover \[m\].
pub(super) fn reach(items: [&[Item]; 3]) -> [[f64; 2]; 2] {
    let silhouettes = items
        .into_iter()
        .flatten()
        .flat_map(|of| &of.outline.silhouette);
    let mut reach = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for point in silhouettes.flatten() {
        for axis in 0..2 {
            reach[axis][0] = reach[axis][0].min(point[axis]);
            reach[axis][1] = reach[axis][1].max(point[axis]);
        }
    }
    if reach[0][0] > reach[0][1] {
        return [[-0.1, 0.1]; 2];
    }
    reach
}

/// What is farther is paler.
pub(super) struct Fog {
    nearest_m: f64,
    depth_m: f64,
}

impl Fog {
    /// As deep as bodies are, but no less than half as deep as they are wide: a motion in a plane has none.
    pub(super) fn new(bodies: &[Item], [across_m, _]: [[f64; 2]; 2]) -> Self {
        let depths = bodies.iter().map(|item| item.nearness_m);
        let nearest_m = depths.clone().fold(f64::NEG_INFINITY, f64::max);
        let farthest_m = depths.fold(f64::INFINITY, f64::min);
        Self {
            nearest_m,
            depth_m: (nearest_m - farthest_m).max(0.5 * (across_m[1] - across_m[0])),
        }
    }

    pub(super) fn of(&self, nearness_m: f64) -> f64 {
        FOG * ((self.nearest_m - nearness_m) / self.depth_m).clamp(0.0, 1.0)
    }
}

/// What an item covers, about: left, top, right and bottom, in pixels.
pub(super) fn covered(item: &Item, scale: &Scale) -> [f64; 4] {
    let points = item.outline.silhouette.iter().flatten();
    let nothing = [
        f64::INFINITY,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NEG_INFINITY,
    ];
    points.fold(nothing, |[left, top, right, bottom], point| {
        let [x, y] = scale.at(*point);
        [left.min(x), top.min(y), right.max(x), bottom.max(y)]
    })
}
