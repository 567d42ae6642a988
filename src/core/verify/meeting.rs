//! Pairs of a link on an arc and something with which it may collide.

use nalgebra::{Point3, Vector3};
use typed_index_collections::TiVec;

use super::expected;
use super::moving::MovingLink;
use crate::math::Pose;
use crate::motion::{Against, ArcEstimate, Estimate, EventEstimate, LinkIndex, Scene};
use crate::physics::State;
use crate::physics::contact::Feature;
use crate::physics::shape::{Closest, Solid};

/// Message of a failed assertion: distances exist because the arcs are finite.
pub(super) const FINITE: &str = "the arcs are finite";

/// The scene as solids, with the estimated motion.
pub(super) struct World<'a> {
    pub(super) scene: &'a Scene,
    pub(super) estimate: &'a Estimate,
    pub(super) links: TiVec<LinkIndex, MovingLink<'a>>,
    obstacles: Vec<Fixed>,
}

/// An obstacle.
pub(super) struct Fixed {
    solid: Solid,
    world_from_solid: Pose,
    radius_m: f64,
}

/// Something with which a link may collide, with its place.
#[derive(Clone, Copy)]
pub(super) enum MeetingPartner<'w> {
    Plane {
        surface: usize,
        point_m: Vector3<f64>,
        normal: Vector3<f64>,
    },
    Obstacle {
        index: usize,
        fixed: &'w Fixed,
    },
    Link {
        index: LinkIndex,
        link: &'w MovingLink<'w>,
        arc: &'w ArcEstimate,
    },
}

/// A link and a partner over a time in which both move on one arc.
pub(super) struct MeetingPair<'w> {
    pub(super) index: LinkIndex,
    pub(super) link: &'w MovingLink<'w>,
    pub(super) arc: &'w ArcEstimate,
    pub(super) partner: MeetingPartner<'w>,
    pub(super) from_s: f64,
    pub(super) to_s: f64,
}

impl<'a> World<'a> {
    pub(super) fn new(scene: &'a Scene, estimate: &'a Estimate) -> Self {
        let links = scene.links.keys();
        let obstacles = scene.obstacles.iter().map(|obstacle| Fixed {
            solid: obstacle.shape.solid().expect("scenes have valid shapes"),
            world_from_solid: obstacle.world_from_shape,
            radius_m: obstacle.shape.radius_m(),
        });
        Self {
            scene,
            estimate,
            links: links
                .map(|link| MovingLink::new(scene, link, estimate))
                .collect(),
            obstacles: obstacles.collect(),
        }
    }

    /// The state of a link just before an event; `None` where it has none.
    pub(super) fn state_before(&self, link: LinkIndex, event: &EventEstimate) -> Option<State> {
        let link = &self.links[link];
        Some(link.state(link.ending_at(event.time_s)?, event.time_s))
    }

    /// Every link with every plane, every obstacle and every other link, arc by arc, each pair
    /// once; of held links only with those that fly, and of joined ones none with its neighbours.
    pub(super) fn meetings(&'a self) -> impl Iterator<Item = MeetingPair<'a>> {
        let arcs = |link: LinkIndex| self.links[link].arcs.iter();
        let is_held = |link: LinkIndex| self.links[link].held.is_some();
        self.links.keys().flat_map(move |index| {
            arcs(index).flat_map(move |arc| {
                let standing = self.standing().filter(move |_| !is_held(index));
                let with_world = standing.map(move |partner| (partner, arc.start_s, arc.end_s));
                let others = self.links.keys().skip(usize::from(index) + 1);
                let others = others.filter(move |other| !(is_held(index) && is_held(*other)));
                let others = others.filter(move |other| !self.scene.are_joined(index, *other));
                let with_links = others.flat_map(move |other| {
                    arcs(other).filter_map(move |other_arc| {
                        let from_s = arc.start_s.max(other_arc.start_s);
                        let to_s = arc.end_s.min(other_arc.end_s);
                        let partner = self.moving(other, other_arc);
                        (from_s < to_s).then_some((partner, from_s, to_s))
                    })
                });
                with_world
                    .chain(with_links)
                    .map(move |(partner, from_s, to_s)| MeetingPair {
                        index,
                        link: &self.links[index],
                        arc,
                        partner,
                        from_s,
                        to_s,
                    })
            })
        })
    }

    /// Planes and obstacles.
    fn standing(&'a self) -> impl Iterator<Item = MeetingPartner<'a>> {
        let surfaces = 0..self.scene.surfaces.len();
        let obstacles = 0..self.obstacles.len();
        surfaces
            .map(Against::Surface)
            .chain(obstacles.map(Against::Obstacle))
            .filter_map(|against| self.partner(against, None))
    }

    fn moving(&'a self, index: LinkIndex, arc: &'a ArcEstimate) -> MeetingPartner<'a> {
        MeetingPartner::Link {
            index,
            link: &self.links[index],
            arc,
        }
    }

    /// The partner that `against` names; a link is taken on its arc that ends at `end_s`. `None`
    /// where it has no such arc, and for surfaces that are no planes.
    pub(super) fn partner(
        &'a self,
        against: Against,
        end_s: Option<f64>,
    ) -> Option<MeetingPartner<'a>> {
        match against {
            Against::Surface(surface) => {
                let (point_m, normal) = self.scene.surfaces[surface].plane()?;
                Some(MeetingPartner::Plane {
                    surface,
                    point_m,
                    normal,
                })
            }
            Against::Obstacle(index) => Some(MeetingPartner::Obstacle {
                index,
                fixed: &self.obstacles[index],
            }),
            Against::Link(index) => {
                let arc = self.links[index].ending_at(end_s?)?;
                Some(self.moving(index, arc))
            }
        }
    }

    /// The features of a link that are expected to touch a partner at an event at a time.
    pub(super) fn expected_at(&self, link: LinkIndex, against: Against, time_s: f64) -> Vec<usize> {
        let mut features = Vec::new();
        for event in &self.estimate.events {
            let kind = &self.scene.events[event.event].kind;
            let (Some(collision), true) = (kind.collision(), event.time_s == time_s) else {
                continue;
            };
            if collision.links().any(|touching| touching == link) {
                let groups = expected::expected(self.scene, collision, link);
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

impl MeetingPartner<'_> {
    pub(super) fn against(&self) -> Against {
        match *self {
            MeetingPartner::Plane { surface, .. } => Against::Surface(surface),
            MeetingPartner::Obstacle { index, .. } => Against::Obstacle(index),
            MeetingPartner::Link { index, .. } => Against::Link(index),
        }
    }

    /// Nearest points of a placed solid and this partner; a link is placed at `pose`.
    fn closest(&self, solid: &Solid, world_from_solid: &Pose, pose: &Pose) -> Closest {
        match self {
            MeetingPartner::Plane {
                point_m, normal, ..
            } => solid.lowest(world_from_solid, point_m, normal),
            MeetingPartner::Obstacle { fixed, .. } => {
                solid.closest(world_from_solid, &fixed.solid, pose)
            }
            MeetingPartner::Link { link, .. } => solid.closest(world_from_solid, &link.solid, pose),
        }
        .expect(FINITE)
    }

    /// Nearest points of a placed solid and this partner; a link is placed at the given pose, or at
    /// the end of its arc.
    pub(super) fn closest_to(&self, solid: &Solid, at: &Pose, link_at: Option<&Pose>) -> Closest {
        let pose = match (self, link_at) {
            (MeetingPartner::Link { .. }, Some(pose)) => *pose,
            (MeetingPartner::Link { arc, .. }, None) => self.pose(arc.end_s),
            (MeetingPartner::Plane { .. } | MeetingPartner::Obstacle { .. }, _) => self.pose(0.0),
        };
        self.closest(solid, at, &pose)
    }

    fn pose(&self, time_s: f64) -> Pose {
        match self {
            MeetingPartner::Plane { .. } => Pose::identity(),
            MeetingPartner::Obstacle { fixed, .. } => fixed.world_from_solid,
            MeetingPartner::Link { link, arc, .. } => link.state(arc, time_s).world_from_body(),
        }
    }
}

impl MeetingPair<'_> {
    /// Whether a link on one of its arcs is one of both.
    pub(super) fn concerns(&self, index: LinkIndex, arc: &ArcEstimate) -> bool {
        let is_its = |of: &ArcEstimate| of.start_s == arc.start_s;
        let is_other = match self.partner {
            MeetingPartner::Link {
                index: other,
                arc: of,
                ..
            } => other == index && is_its(of),
            MeetingPartner::Plane { .. } | MeetingPartner::Obstacle { .. } => false,
        };
        is_other || self.index == index && is_its(self.arc)
    }

    /// Upper bound of the rate of the distance [m/s].
    pub(super) fn speed_bound_m_s(&self) -> f64 {
        let own = self.link.speed_bound_m_s(self.arc, self.from_s, self.to_s);
        own + match self.partner {
            MeetingPartner::Plane { .. } | MeetingPartner::Obstacle { .. } => 0.0,
            MeetingPartner::Link { link, arc, .. } => {
                link.speed_bound_m_s(arc, self.from_s, self.to_s)
            }
        }
    }

    /// Lower bound of the solids' distance, by the balls about them \[m\].
    pub(super) fn least_gap_m(&self, time_s: f64) -> f64 {
        let centre_m = self.link.state(self.arc, time_s).position_m;
        let between_m = match self.partner {
            MeetingPartner::Plane {
                point_m, normal, ..
            } => normal.dot(&(centre_m - point_m)),
            MeetingPartner::Obstacle { fixed, .. } => {
                (centre_m - fixed.world_from_solid.translation.vector).norm() - fixed.radius_m
            }
            MeetingPartner::Link { link, arc, .. } => {
                (centre_m - link.state(arc, time_s).position_m).norm() - link.radius_m
            }
        };
        between_m - self.link.radius_m
    }

    /// Nearest points of the link and its partner.
    pub(super) fn closest(&self, time_s: f64) -> Closest {
        let world_from_link = self.link.state(self.arc, time_s).world_from_body();
        let pose = self.partner.pose(time_s);
        self.partner
            .closest(&self.link.solid, &world_from_link, &pose)
    }

    /// Distance of the link's feature from the partner \[m\], measured at the point of the feature
    /// nearest to `near_m` [m, link].
    pub(super) fn feature_gap_m(&self, time_s: f64, feature: usize, near_m: &Vector3<f64>) -> f64 {
        let geometry = &self.link.of_scene.features[feature].geometry;
        let (centre_m, radius_m) = geometry.skeleton_m(near_m);
        let world_from_link = self.link.state(self.arc, time_s).world_from_body();
        let centre_m = world_from_link * Point3::from(centre_m);
        let ball = Solid::ball(radius_m);
        let pose = self.partner.pose(time_s);
        self.partner
            .closest(&ball, &Pose::from(centre_m.coords), &pose)
            .gap_m
    }

    /// Distance of an expected point feature of the partner from the link \[m\]: of the one to
    /// which a place \[world\] belongs. `None` where it belongs to none, or the partner is no link.
    pub(super) fn partner_point_gap_m(
        &self,
        time_s: f64,
        expected: &[usize],
        near_m: &Vector3<f64>,
    ) -> Option<f64> {
        let MeetingPartner::Link { link, .. } = self.partner else {
            return None;
        };
        let world_from_other = self.partner.pose(time_s);
        let near_m = world_from_other.inverse_transform_point(&Point3::from(*near_m));
        let feature = expected::owner(link.of_scene, link.is_declared(), expected, &near_m.coords)
            .filter(|feature| expected.contains(feature))?;
        let Feature::Point { point_m, radius_m } = link.of_scene.features[feature].geometry else {
            return None;
        };
        let centre_m = world_from_other * Point3::from(point_m);
        let world_from_link = self.link.state(self.arc, time_s).world_from_body();
        let closest = Solid::ball(radius_m)
            .closest(
                &Pose::from(centre_m.coords),
                &self.link.solid,
                &world_from_link,
            )
            .expect(FINITE);
        Some(closest.gap_m)
    }
}
