//! Pairs of a body on an arc and something with which it may collide.

use nalgebra::{Point3, Vector3};

use super::expected;
use super::track::Track;
use crate::math::Pose;
use crate::motion::{Against, ArcEstimate, Estimate, Scene};
use crate::physics::contact::Feature;
use crate::physics::shape::{Closest, Solid};

/// Message of a failed assertion: distances exist because the arcs are finite.
pub(super) const FINITE: &str = "the arcs are finite";

/// The scene as solids, with the estimated motion.
pub(super) struct World<'a> {
    pub(super) scene: &'a Scene,
    pub(super) estimate: &'a Estimate,
    pub(super) tracks: Vec<Track<'a>>,
    obstacles: Vec<Fixed>,
}

/// An obstacle.
pub(super) struct Fixed {
    solid: Solid,
    world_from_solid: Pose,
    radius_m: f64,
}

/// Something with which a body may collide, with its place.
#[derive(Clone, Copy)]
pub(super) enum Partner<'w> {
    Plane {
        surface: usize,
        point_m: Vector3<f64>,
        normal: Vector3<f64>,
    },
    Obstacle {
        index: usize,
        fixed: &'w Fixed,
    },
    Body {
        index: usize,
        track: &'w Track<'w>,
        arc: &'w ArcEstimate,
    },
}

/// A body and a partner over a time in which both move on one arc.
pub(super) struct Meeting<'w> {
    pub(super) body: usize,
    pub(super) track: &'w Track<'w>,
    pub(super) arc: &'w ArcEstimate,
    pub(super) partner: Partner<'w>,
    pub(super) from_s: f64,
    pub(super) to_s: f64,
}

impl<'a> World<'a> {
    pub(super) fn new(scene: &'a Scene, estimate: &'a Estimate) -> Self {
        let tracks = scene.bodies.iter().enumerate();
        let obstacles = scene.obstacles.iter().map(|obstacle| Fixed {
            solid: obstacle.shape.solid().expect("scenes have valid shapes"),
            world_from_solid: obstacle.world_from_shape,
            radius_m: obstacle.shape.radius_m(),
        });
        Self {
            scene,
            estimate,
            tracks: tracks
                .map(|(index, body)| Track::new(index, body, estimate))
                .collect(),
            obstacles: obstacles.collect(),
        }
    }

    /// Every body with every plane, every obstacle and every other body, arc by arc, each pair
    /// once.
    pub(super) fn meetings(&'a self) -> impl Iterator<Item = Meeting<'a>> {
        let arcs = |body: usize| self.tracks[body].arcs.iter().copied();
        (0..self.tracks.len()).flat_map(move |body| {
            arcs(body).flat_map(move |arc| {
                let with_world = self
                    .standing()
                    .map(move |partner| (partner, arc.start_s, arc.end_s));
                let with_bodies = (body + 1..self.tracks.len()).flat_map(move |other| {
                    arcs(other).filter_map(move |other_arc| {
                        let from_s = arc.start_s.max(other_arc.start_s);
                        let to_s = arc.end_s.min(other_arc.end_s);
                        let partner = self.moving(other, other_arc);
                        (from_s < to_s).then_some((partner, from_s, to_s))
                    })
                });
                with_world
                    .chain(with_bodies)
                    .map(move |(partner, from_s, to_s)| Meeting {
                        body,
                        track: &self.tracks[body],
                        arc,
                        partner,
                        from_s,
                        to_s,
                    })
            })
        })
    }

    /// Planes and obstacles.
    fn standing(&'a self) -> impl Iterator<Item = Partner<'a>> {
        let surfaces = 0..self.scene.surfaces.len();
        let obstacles = 0..self.obstacles.len();
        surfaces
            .map(Against::Surface)
            .chain(obstacles.map(Against::Obstacle))
            .filter_map(|against| self.partner(against, None))
    }

    fn moving(&'a self, index: usize, arc: &'a ArcEstimate) -> Partner<'a> {
        Partner::Body {
            index,
            track: &self.tracks[index],
            arc,
        }
    }

    /// The partner that `against` names; a body is taken on its arc that ends at `end_s`. `None`
    /// where it has no such arc, and for surfaces that are no planes.
    pub(super) fn partner(&'a self, against: Against, end_s: Option<f64>) -> Option<Partner<'a>> {
        match against {
            Against::Surface(surface) => {
                let (point_m, normal) = self.scene.surfaces[surface].plane()?;
                Some(Partner::Plane {
                    surface,
                    point_m,
                    normal,
                })
            }
            Against::Obstacle(index) => Some(Partner::Obstacle {
                index,
                fixed: &self.obstacles[index],
            }),
            Against::Body(index) => {
                let arc = self.tracks[index].ending_at(end_s?)?;
                Some(self.moving(index, arc))
            }
        }
    }

    /// The features of a body that are expected to touch a partner at an event at a time.
    pub(super) fn expected_at(&self, body: usize, against: Against, time_s: f64) -> Vec<usize> {
        let mut features = Vec::new();
        for event in &self.estimate.events {
            let kind = &self.scene.events[event.event].kind;
            let (Some(collision), true) = (kind.collision(), event.time_s == time_s) else {
                continue;
            };
            if collision.concerns(body) {
                let groups = expected::expected(self.scene, collision, body);
                features.extend(
                    groups
                        .into_iter()
                        .filter(|(partner, _)| *partner == against)
                        .flat_map(|(_, features)| features),
                );
            }
        }
        features
    }
}

impl Partner<'_> {
    pub(super) fn against(&self) -> Against {
        match *self {
            Partner::Plane { surface, .. } => Against::Surface(surface),
            Partner::Obstacle { index, .. } => Against::Obstacle(index),
            Partner::Body { index, .. } => Against::Body(index),
        }
    }

    /// Nearest points of a placed solid and this partner; a body is placed at `pose`.
    fn closest(&self, solid: &Solid, world_from_solid: &Pose, pose: &Pose) -> Closest {
        match self {
            Partner::Plane {
                point_m, normal, ..
            } => solid.lowest(world_from_solid, point_m, normal),
            Partner::Obstacle { fixed, .. } => solid.closest(world_from_solid, &fixed.solid, pose),
            Partner::Body { track, .. } => solid.closest(world_from_solid, &track.solid, pose),
        }
        .expect(FINITE)
    }

    /// Nearest points of a placed solid and this partner; a body is placed at the given pose, or at
    /// the end of its arc.
    pub(super) fn closest_to(&self, solid: &Solid, at: &Pose, body_at: Option<&Pose>) -> Closest {
        let pose = match (self, body_at) {
            (Partner::Body { .. }, Some(pose)) => *pose,
            (Partner::Body { arc, .. }, None) => self.pose(arc.end_s),
            (Partner::Plane { .. } | Partner::Obstacle { .. }, _) => self.pose(0.0),
        };
        self.closest(solid, at, &pose)
    }

    fn pose(&self, time_s: f64) -> Pose {
        match self {
            Partner::Plane { .. } => Pose::identity(),
            Partner::Obstacle { fixed, .. } => fixed.world_from_solid,
            Partner::Body { track, arc, .. } => track.state(arc, time_s).world_from_body(),
        }
    }
}

impl Meeting<'_> {
    /// Upper bound of the rate of the distance [m/s].
    pub(super) fn speed_bound_m_s(&self) -> f64 {
        let own = self.track.speed_bound_m_s(self.arc, self.from_s, self.to_s);
        own + match self.partner {
            Partner::Plane { .. } | Partner::Obstacle { .. } => 0.0,
            Partner::Body { track, arc, .. } => track.speed_bound_m_s(arc, self.from_s, self.to_s),
        }
    }

    /// Lower bound of the solids' distance, by the balls about them \[m\].
    pub(super) fn least_gap_m(&self, time_s: f64) -> f64 {
        let centre_m = self.track.state(self.arc, time_s).position_m;
        let between_m = match self.partner {
            Partner::Plane {
                point_m, normal, ..
            } => normal.dot(&(centre_m - point_m)),
            Partner::Obstacle { fixed, .. } => {
                (centre_m - fixed.world_from_solid.translation.vector).norm() - fixed.radius_m
            }
            Partner::Body { track, arc, .. } => {
                (centre_m - track.state(arc, time_s).position_m).norm() - track.radius_m
            }
        };
        between_m - self.track.radius_m
    }

    /// Nearest points of the body and its partner.
    pub(super) fn closest(&self, time_s: f64) -> Closest {
        let world_from_body = self.track.state(self.arc, time_s).world_from_body();
        let pose = self.partner.pose(time_s);
        self.partner
            .closest(&self.track.solid, &world_from_body, &pose)
    }

    /// Distance of the body's feature from the partner \[m\], measured at the point of the feature
    /// nearest to `near_m` [m, body].
    pub(super) fn feature_gap_m(&self, time_s: f64, feature: usize, near_m: &Vector3<f64>) -> f64 {
        let geometry = &self.track.of_scene.features[feature].geometry;
        let (centre_m, radius_m) = expected::skeleton(geometry, near_m);
        let world_from_body = self.track.state(self.arc, time_s).world_from_body();
        let centre_m = world_from_body * Point3::from(centre_m);
        let ball = Solid::ball(radius_m);
        let pose = self.partner.pose(time_s);
        self.partner
            .closest(&ball, &Pose::from(centre_m.coords), &pose)
            .gap_m
    }

    /// Distance of an expected point feature of the partner from the body \[m\]: of the one to
    /// which a place \[world\] belongs. `None` where it belongs to none, or the partner is no body.
    pub(super) fn partner_point_gap_m(
        &self,
        time_s: f64,
        expected: &[usize],
        near_m: &Vector3<f64>,
    ) -> Option<f64> {
        let Partner::Body { track, .. } = self.partner else {
            return None;
        };
        let world_from_other = self.partner.pose(time_s);
        let near_m = world_from_other.inverse_transform_point(&Point3::from(*near_m));
        let feature = expected::owner(track.of_scene, expected, &near_m.coords)
            .filter(|feature| expected.contains(feature))?;
        let Feature::Point { point_m, radius_m } = track.of_scene.features[feature].geometry else {
            return None;
        };
        let centre_m = world_from_other * Point3::from(point_m);
        let world_from_body = self.track.state(self.arc, time_s).world_from_body();
        let closest = Solid::ball(radius_m)
            .closest(
                &Pose::from(centre_m.coords),
                &self.track.solid,
                &world_from_body,
            )
            .expect(FINITE);
        Some(closest.gap_m)
    }
}
