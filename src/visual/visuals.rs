//! What there is to draw: the shapes of a scene with their frames and colours.

use nalgebra::{Translation3, UnitQuaternion, Vector3};

use super::patch::Patch;
use crate::math::Pose;
use crate::motion::{GoalQuantity, GoalSet, GoalTarget, LinkIndex, Scene};
use crate::physics::Shape;

/// How thick a surface is drawn \[m\]; it lies below the plane. No side of a goal is drawn thinner.
const SURFACE_THICKNESS_M: f64 = 1e-3;

/// Red, green, blue and opacity of a body as it was acted, beside its estimate.
pub const GHOST_RGBA: [f64; 4] = [0.95, 0.65, 0.20, 0.35];

/// Something to draw.
#[derive(Clone, Debug, PartialEq)]
pub struct Visual {
    /// What it stands for.
    pub subject: Subject,
    /// Where its shape is in its frame: the one in which the scene gives a link, the world for all others.
    pub frame_from_shape: Pose,
    /// What is drawn; `None` of a goal without ends.
    pub shape: Option<Shape>,
}

/// What a visual stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// A link.
    Link(LinkIndex),
    /// Index into `Scene::obstacles`.
    Obstacle(usize),
    /// Index into `Scene::surfaces`.
    Surface(usize),
    /// Index into `Scene::goals`.
    Goal(usize),
}

/// Colours by which bodies beside one another are told apart: that of a body alone first, then those that people with
/// any colour vision tell apart (Okabe and Ito).
const BODIES_RGB: [[f64; 3]; 7] = [
    [0.95, 0.65, 0.20],
    [0.34, 0.71, 0.91],
    [0.00, 0.62, 0.45],
    [0.80, 0.47, 0.65],
    [0.00, 0.45, 0.70],
    [0.84, 0.37, 0.00],
    [0.94, 0.89, 0.26],
];

/// The colour of a body among others, opaque.
pub fn body_rgba(link: LinkIndex) -> [f64; 4] {
    let [red, green, blue] = BODIES_RGB[usize::from(link) % BODIES_RGB.len()];
    [red, green, blue, 1.0]
}

impl Subject {
    /// Red, green, blue and opacity, from 0 to 1.
    pub fn rgba(self) -> [f64; 4] {
        match self {
            Subject::Link(_) => [0.95, 0.65, 0.20, 1.0],
            Subject::Obstacle(_) => [0.45, 0.55, 0.65, 0.5],
            Subject::Surface(_) => [0.75, 0.75, 0.75, 0.5],
            Subject::Goal(_) => [0.25, 0.80, 0.35, 0.3],
        }
    }
}

/// Links, obstacles, flat surfaces as far as their patches, and goals, in this order.
pub fn visuals(scene: &Scene, patches: &[Option<Patch>]) -> Vec<Visual> {
    let links = scene.links.iter_enumerated().map(|(index, link)| Visual {
        subject: Subject::Link(index),
        frame_from_shape: link.given_from_shape(),
        shape: Some(link.shape.clone()),
    });
    let obstacles = scene.obstacles.iter().enumerate();
    let obstacles = obstacles.map(|(index, obstacle)| Visual {
        subject: Subject::Obstacle(index),
        frame_from_shape: obstacle.world_from_shape,
        shape: Some(obstacle.shape.clone()),
    });
    let patches = patches.iter().enumerate();
    let surfaces = patches.filter_map(|(index, patch)| {
        let (patch, [x_m, y_m]) = (patch.as_ref()?, patch.as_ref()?.sides_m);
        let below = Translation3::new(0.0, 0.0, -0.5 * SURFACE_THICKNESS_M);
        Some(Visual {
            subject: Subject::Surface(index),
            frame_from_shape: patch.world_from_patch * below,
            shape: Some(cuboid(&Vector3::new(x_m, y_m, SURFACE_THICKNESS_M))),
        })
    });
    let goals = (0..scene.goals.len()).map(|goal| goal_visual(scene, goal));
    let fixed = obstacles.chain(surfaces);
    links.chain(fixed).chain(goals).collect()
}

/// The link where it is to be, or the box or ball in which a point of it is to be.
fn goal_visual(scene: &Scene, index: usize) -> Visual {
    let goal = &scene.goals[index];
    let (frame_from_shape, shape) = match &goal.target {
        GoalTarget::Pose { world_from_body } => {
            let link = &scene.links[goal.link];
            let world_from_shape = world_from_body * link.link_from_shape();
            (world_from_shape, Some(link.shape.clone()))
        }
        GoalTarget::PositionWithin { lower_m, upper_m } => within_box(lower_m, upper_m),
        GoalTarget::Condition(condition) => match (&condition.quantity, &condition.set) {
            // What is seen from another body moves with it.
            (quantity, _) if quantity.seen_from().is_some() => (Pose::identity(), None),
            (GoalQuantity::Position { .. }, GoalSet::Box { lower, upper }) => {
                within_box(lower, upper)
            }
            (GoalQuantity::Position { .. }, GoalSet::Ball { centre, radius }) => (
                Pose::from_parts((*centre).into(), UnitQuaternion::identity()),
                Some(Shape::Sphere { radius_m: *radius }),
            ),
            _ => (Pose::identity(), None),
        },
    };
    Visual {
        subject: Subject::Goal(index),
        frame_from_shape,
        shape,
    }
}

/// A box, unless it has no ends.
fn within_box(lower_m: &Vector3<f64>, upper_m: &Vector3<f64>) -> (Pose, Option<Shape>) {
    let sides_m = upper_m - lower_m;
    let centre = Translation3::from(0.5 * (upper_m + lower_m));
    let is_finite = sides_m.iter().all(|side_m| side_m.is_finite());
    // A side of no length would not be seen.
    let seen_m = sides_m.map(|side_m| side_m.max(SURFACE_THICKNESS_M));
    (
        Pose::from_parts(centre, UnitQuaternion::identity()),
        is_finite.then(|| cuboid(&seen_m)),
    )
}

fn cuboid(sides_m: &Vector3<f64>) -> Shape {
    Shape::Cuboid {
        half_extents_m: 0.5 * sides_m,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::scene;
    use crate::motion::{BodyPoint, Condition, Moment};
    use crate::visual::patches;
    use typed_index_collections::TiSlice;

    fn unmoved(scene: &Scene) -> Vec<Visual> {
        visuals(scene, &patches(scene, TiSlice::from_ref(&[])))
    }

    #[test]
    fn everything_is_listed_and_slabs_lie_below_their_planes() {
        let visuals = unmoved(&scene());
        let subjects: Vec<Subject> = visuals.iter().map(|visual| visual.subject).collect();
        let expected = [
            Subject::Link(LinkIndex(0)),
            Subject::Obstacle(0),
            Subject::Surface(0),
            Subject::Goal(0),
        ];
        assert_eq!(subjects, expected);
        let slab = &visuals[2];
        assert_eq!(
            slab.frame_from_shape.translation.z,
            -0.5 * SURFACE_THICKNESS_M
        );
        let half_extents_m = Vector3::new(0.25, 0.25, 0.5 * SURFACE_THICKNESS_M);
        assert_eq!(slab.shape, Some(Shape::Cuboid { half_extents_m }));
        assert_eq!(visuals[3].frame_from_shape.translation.z, 0.1);
    }

    #[test]
    fn a_point_within_a_ball_is_drawn_as_one_unless_the_ball_moves() {
        let mut scene = scene();
        let centre = Vector3::new(0.1, 0.2, 0.3);
        let within = |seen_from| {
            GoalTarget::Condition(Condition {
                quantity: GoalQuantity::Position {
                    point: BodyPoint::Centre,
                    seen_from,
                },
                set: GoalSet::Ball {
                    centre,
                    radius: 0.05,
                },
                moment: Moment::Before,
                sd: Some(0.01),
            })
        };
        scene.goals[0].target = within(None);
        let drawn = goal_visual(&scene, 0);
        assert_eq!(drawn.shape, Some(Shape::Sphere { radius_m: 0.05 }));
        assert_eq!(drawn.frame_from_shape.translation.vector, centre);
        scene.goals[0].target = within(Some(LinkIndex(0)));
        assert_eq!(goal_visual(&scene, 0).shape, None);
    }

    #[test]
    fn goals_without_ends_have_no_shape_and_flat_ones_are_seen() {
        let mut scene = scene();
        let within = |upper_m| GoalTarget::PositionWithin {
            lower_m: Vector3::zeros(),
            upper_m,
        };
        let shape = |scene: &Scene| unmoved(scene).pop().and_then(|visual| visual.shape);
        scene.goals[0].target = within(Vector3::new(1.0, f64::INFINITY, 1.0));
        assert_eq!(shape(&scene), None);
        scene.goals[0].target = within(Vector3::new(1.0, 2.0, 0.0));
        let half_extents_m = Vector3::new(0.5, 1.0, 0.5 * SURFACE_THICKNESS_M);
        assert_eq!(shape(&scene), Some(Shape::Cuboid { half_extents_m }));
    }
}
