//! Goals of every kind, drawn such that a motion meets them that is near the one performed.
//!
//! A neighbour of the true motion begins a little otherwise and obeys the same physics. What a goal is
//! about has a value in each of them; the goal's set is about the neighbour's. A tight set excludes the
//! true motion, a wide one holds both.

use enact::estimate::outcome::PHYSICAL;
use enact::motion::{
    Axes, BodyPoint, Condition, Estimate, EventKind, Goal, GoalQuantity, GoalSet, GoalTarget,
    LinkIndex, Moment, Performer, Scene,
};
use enact::physics::state::{StateTangent, part};
use enact::physics::{State, contact};
use enact::verify::overlaps;
use nalgebra::Vector3;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::case::Case;
use crate::perform::bounces::{Polyhedron, Throw, thrown};
use crate::perform::{Acting, Style, Truth, bounces, hat_box, simulate};

/// What a goal is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Where the centre of mass ends.
    Centre,
    /// Where a point of the body ends.
    Point,
    /// Where the first collision's contact is.
    Contact,
    /// How the body ends turned.
    Turn,
    /// Where an axis of it points at the end.
    Direction,
    /// How fast a point of it ends.
    Velocity,
    /// How fast it leaves the first collision.
    Bounced,
    /// How it spins at the end, in world axes.
    Spin,
    /// How it spins after the first collision, in its own axes.
    BouncedSpin,
    /// How long the last flight lasts.
    Time,
    /// Where it ends, seen from another body.
    Beside,
    /// How it ends turned, seen from another body.
    Aligned,
}

impl Quantity {
    /// All of them.
    pub const ALL: [Self; 12] = [
        Self::Centre,
        Self::Point,
        Self::Contact,
        Self::Turn,
        Self::Direction,
        Self::Velocity,
        Self::Bounced,
        Self::Spin,
        Self::BouncedSpin,
        Self::Time,
        Self::Beside,
        Self::Aligned,
    ];

    /// In words.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Centre => "centre of mass",
            Self::Point => "point of the body",
            Self::Contact => "place of the contact",
            Self::Turn => "orientation",
            Self::Direction => "direction of an axis",
            Self::Velocity => "velocity of a point",
            Self::Bounced => "velocity after the bounce",
            Self::Spin => "spin, world axes",
            Self::BouncedSpin => "spin after the bounce, body axes",
            Self::Time => "time since the bounce",
            Self::Beside => "position seen from another body",
            Self::Aligned => "orientation seen from another body",
        }
    }

    /// Whether it needs two bodies.
    pub fn is_of_two(self) -> bool {
        matches!(self, Self::Beside | Self::Aligned)
    }

    /// The sets that are asked of it.
    pub fn sets(self) -> &'static [Set] {
        match self {
            Self::Turn | Self::Direction | Self::Aligned => &[Set::Exact, Set::Ball],
            Self::Time => &[Set::Exact, Set::Box],
            _ => &[Set::Exact, Set::Box, Set::Ball, Set::HalfSpace],
        }
    }
}

/// What set it must be in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Set {
    /// The neighbour's value.
    Exact,
    /// A box about it.
    Box,
    /// A ball, a cone or an angle about it.
    Ball,
    /// A half-space that ends there.
    HalfSpace,
}

impl Set {
    /// In words.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Exact => "exactly",
            Self::Box => "box",
            Self::Ball => "ball, cone or angle",
            Self::HalfSpace => "half-space",
        }
    }
}

/// A true motion, and one near it.
pub struct Pair {
    /// What is performed.
    pub truth: Truth,
    /// What meets the goals.
    pub neighbour: Truth,
    rng: ChaCha8Rng,
}

/// Relative standard deviation of the neighbour's first velocities, and that of its orientation \[rad\].
const APART: f64 = 0.03;
/// How long before the end that a motion is made with it ends \[s\].
const EARLIER_S: f64 = 0.03;
/// Draws of a neighbour before giving up.
const TRIES: usize = 60;
/// Share of the distance between both motions' values that a tight set reaches, and a wide one.
const TIGHT: f64 = 0.3;
const WIDE: f64 = 4.0;

impl Pair {
    /// A pencil, a box, a die or a cube in turn; `None` where no neighbour touches with the same corners.
    pub fn of_one(seed: u64) -> Option<Self> {
        let mut truth = match seed % 5 {
            0 => before_it_lands(&Style::Tip.truth())?,
            1 => bounces(1, seed).ok()?,
            2 => thrown(Polyhedron::Cube, &Throw::DIE, 1, seed).ok()?,
            3 => thrown(Polyhedron::Cube, &Throw::sized(0.05, 40.0), 2, seed).ok()?,
            _ => before_it_lands(&Style::Eraser.truth())?,
        };
        truth.scene.goals.clear();
        Self::of(truth, seed, APART)
    }

    /// A hat and a box that bounce off the board and meet.
    pub fn of_two(seed: u64) -> Option<Self> {
        let mut truth = before_it_lands(&hat_box::truth())?;
        truth.scene.goals.clear();
        // Both begin where they must to meet: the neighbour is nearer.
        Self::of(truth, seed, 0.03 * APART)
    }

    fn of(truth: Truth, seed: u64, apart: f64) -> Option<Self> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x90a1);
        for _ in 0..TRIES {
            let first = first_states(&truth);
            let first: Vec<State> = first.iter().map(|s| beside(s, apart, &mut rng)).collect();
            let found = simulate(&truth.scene, &truth.parameters, &first, truth.duration_s);
            if let Ok(neighbour) = found
                && is_right(&neighbour)
                && keeps_out(&neighbour)
            {
                return Some(Self {
                    truth,
                    neighbour,
                    rng,
                });
            }
        }
        None
    }

    /// A goal for the performed motion's scene; tight or wide. `sd` as a share of the distance between
    /// both motions' values makes it a wish.
    pub fn goal(
        &mut self,
        (quantity, set): (Quantity, Set),
        is_tight: bool,
        sd: Option<f64>,
    ) -> Option<Goal> {
        let (event, link, moment, quantity) = self.about(quantity)?;
        let goal = |set, sd| Goal {
            event,
            link,
            target: GoalTarget::Condition(Condition {
                quantity,
                set,
                moment,
                sd,
            }),
        };
        let zero = Vector3::zeros();
        let there = value(&self.neighbour, &goal(GoalSet::point(zero), None))?;
        let here = value(&self.truth, &goal(GoalSet::point(zero), None))?;
        let apart = (there - here).norm();
        let reach = apart * if is_tight { TIGHT } else { WIDE };
        let mut quantity = quantity;
        let set = match set {
            Set::Exact => GoalSet::point(there),
            Set::Box => GoalSet::Box {
                lower: there.map(|x| x - reach * (0.2 + self.rng.random::<f64>())),
                upper: there.map(|x| x + reach * (0.2 + self.rng.random::<f64>())),
            },
            Set::Ball => GoalSet::Ball {
                centre: there,
                radius: reach,
            },
            Set::HalfSpace => {
                let normal = (there - here) / apart;
                GoalSet::HalfSpace {
                    normal,
                    least: normal.dot(&there) - reach,
                }
            }
        };
        // Orientations and directions are about the neighbour's own.
        let set = match (&mut quantity, set) {
            (GoalQuantity::Turn { from, seen_from }, set) => {
                let state = |link| self.neighbour.state_at(link, (event, moment));
                let body = state(link).orientation;
                *from = seen_from.map_or(body, |other| state(other).orientation.inverse() * body);
                about_zero(set)
            }
            (GoalQuantity::Direction { axis, towards, .. }, set) => {
                let body = self.neighbour.state_at(link, (event, moment)).orientation;
                *towards = body * *axis;
                about_zero(set)
            }
            (_, set) => set,
        };
        let sd = sd.map(|share| share * apart);
        Some(Goal {
            target: GoalTarget::Condition(Condition {
                quantity,
                set,
                moment,
                sd,
            }),
            event,
            link,
        })
    }

    /// Where, of what, at which side, and what of it.
    fn about(&mut self, quantity: Quantity) -> Option<(usize, LinkIndex, Moment, GoalQuantity)> {
        let scene = &self.truth.scene;
        let end = scene.events.len() - 1;
        let is_collision =
            |event: &usize| matches!(scene.events[*event].kind, EventKind::Collision(_));
        let bounce = (0..end).find(is_collision)?;
        let link = LinkIndex(scene.links.len() - 1);
        let body = &scene.links[link];
        let radius_m = body.radius_m();
        let rng = &mut self.rng;
        let mut unit = || {
            let v = Vector3::from_fn(|_, _| -> f64 { StandardNormal.sample(rng) });
            v.normalize()
        };
        let point = BodyPoint::Fixed(unit() * (0.8 * radius_m));
        let seen_from = quantity.is_of_two().then_some(LinkIndex(0));
        let turn = GoalQuantity::Turn {
            from: Default::default(),
            seen_from,
        };
        let (before, after) = (Moment::Before, Moment::After);
        Some(match quantity {
            Quantity::Centre => {
                let point = BodyPoint::Centre;
                (
                    end,
                    link,
                    before,
                    GoalQuantity::Position { point, seen_from },
                )
            }
            Quantity::Point | Quantity::Beside => (
                end,
                link,
                before,
                GoalQuantity::Position { point, seen_from },
            ),
            Quantity::Contact => {
                let point = BodyPoint::Contact(0);
                (
                    bounce,
                    link,
                    before,
                    GoalQuantity::Position { point, seen_from },
                )
            }
            Quantity::Turn | Quantity::Aligned => (end, link, before, turn),
            Quantity::Direction => {
                let axis = unit();
                let towards = Vector3::z();
                let quantity = GoalQuantity::Direction {
                    axis,
                    towards,
                    seen_from,
                };
                (end, link, before, quantity)
            }
            Quantity::Velocity => (end, link, before, GoalQuantity::Velocity { point }),
            Quantity::Bounced => {
                let point = BodyPoint::Centre;
                (bounce, link, after, GoalQuantity::Velocity { point })
            }
            Quantity::Spin => (end, link, before, GoalQuantity::Spin { axes: Axes::World }),
            Quantity::BouncedSpin => (bounce, link, after, GoalQuantity::Spin { axes: Axes::Body }),
            Quantity::Time => {
                let since = Some(last_collision(scene, end)?);
                (end, link, before, GoalQuantity::Time { since })
            }
        })
    }
}

/// The last collision before an event.
/// Whether an estimate leaves no gap, whatever else is doubted.
pub fn is_closed(estimate: &Estimate) -> bool {
    estimate.events.iter().all(|event| {
        event.gap.position_m <= PHYSICAL.position_m
            && event.gap.orientation_rad <= PHYSICAL.orientation_rad
            && event.gap.velocity_m_s <= PHYSICAL.velocity_m_s
            && event.gap.angular_velocity_rad_s <= PHYSICAL.angular_velocity_rad_s
    })
}

fn last_collision(scene: &Scene, before: usize) -> Option<usize> {
    (0..before)
        .rev()
        .find(|event| scene.events[*event].kind.collision().is_some())
}

/// A set of turns from what it is about.
fn about_zero(set: GoalSet) -> GoalSet {
    match set {
        GoalSet::Ball { radius, .. } => GoalSet::about_zero(Some(radius)),
        _ => GoalSet::about_zero(None),
    }
}

/// The value of a goal's quantity in a true motion: a turn's is that from the identity, so that two of
/// them differ by about the turn from one to the other.
fn value(truth: &Truth, goal: &Goal) -> Option<Vector3<f64>> {
    let GoalTarget::Condition(condition) = &goal.target else {
        return None;
    };
    let at = (goal.event, condition.moment);
    if let GoalQuantity::Time { since } = condition.quantity {
        let since_s = since.map_or(0.0, |event| truth.event_times_s[event]);
        return Some(Vector3::new(
            truth.event_times_s[goal.event] - since_s,
            0.0,
            0.0,
        ));
    }
    let state_of = |link| Some(truth.state_at(link, at));
    let quantity = &condition.quantity;
    let point_m = truth.scene.point_of(goal, quantity, &state_of)?;
    let other = quantity.seen_from().map(|link| truth.state_at(link, at));
    Some(quantity.value(&truth.state_at(goal.link, at), other.as_ref(), &point_m))
}

/// The state of every mechanism at the beginning.
fn first_states(truth: &Truth) -> Vec<State> {
    let links = truth.scene.links.keys();
    links.map(|link| truth.state(link, 0.0)).collect()
}

/// A state with other velocities, turned a little.
fn beside(state: &State, apart: f64, rng: &mut impl Rng) -> State {
    let mut random =
        |size: f64| Vector3::from_fn(|_, _| -> f64 { StandardNormal.sample(rng) }) * (apart * size);
    let mut delta = StateTangent::zeros();
    let mut set = |at: usize, by: Vector3<f64>| delta.fixed_rows_mut::<3>(at).copy_from(&by);
    set(part::ORIENTATION, random(1.0));
    set(part::VELOCITY, random(state.velocity_m_s.norm()));
    set(
        part::ANGULAR_VELOCITY,
        random(state.angular_velocity_rad_s.norm()),
    );
    state.retract(&delta)
}

/// Whether no other corner would have touched a surface before the one that does.
fn is_right(truth: &Truth) -> bool {
    let scene = &truth.scene;
    let planes: Vec<_> = scene
        .surfaces
        .iter()
        .filter_map(|surface| surface.plane())
        .collect();
    scene.links.keys().all(|link| {
        let events = scene.events.iter().enumerate();
        let mut collisions = events.filter(|(_, of)| of.kind.collision().is_some());
        collisions.all(|(event, _)| {
            let state = truth.state_at(link, (event, Moment::Before));
            let corners =
                scene.links[link]
                    .features
                    .iter()
                    .filter_map(|feature| match feature.geometry {
                        contact::Feature::Point { point_m, .. } => Some(point_m),
                        _ => None,
                    });
            let places = corners.map(|corner_m| state.position_m + state.orientation * corner_m);
            let mut heights = places.flat_map(|place| {
                planes
                    .iter()
                    .map(move |(point_m, normal)| normal.dot(&(place - point_m)))
            });
            heights.all(|height_m| height_m > -1e-4)
        })
    })
}

/// The motion until shortly before its end: what ends where it lands has neighbours that are inside by then.
fn before_it_lands(truth: &Truth) -> Option<Truth> {
    let ends_s = truth.duration_s - EARLIER_S;
    simulate(
        &truth.scene,
        &truth.parameters,
        &first_states(truth),
        ends_s,
    )
    .ok()
}

/// Whether a motion goes into nothing on its way: told of a performance without errors.
fn keeps_out(truth: &Truth) -> bool {
    let mut truth = truth.clone();
    truth.scene.performer = Performer::Nobody;
    let exact = Acting {
        distortion: 0.0,
        mark_error_s: 0.0,
        stamp_jitter_s: 0.0,
        ..Acting::timing_known()
    };
    let solved = Case::new(&truth, &exact, 0).estimated(&mut ());
    solved.is_ok_and(|of| overlaps(&of.scene, &of.estimate, &mut ()).is_empty())
}
