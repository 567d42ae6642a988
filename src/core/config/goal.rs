//! Goals at events: `[[goal]]` tables become conditions, each of one quantity.

mod angles;
mod keys;
mod point;
mod set;
mod turn;
mod vector;

use std::ops::Range;

use crate::config::spanned::Spanned;
use nalgebra::Vector3;

use self::keys::{ABOUT, Used};
use self::vector::{VectorKeys, sd};
use super::error::{Fault, fault};
use super::event::link_of;
use super::held::check_goal;
use super::number::{finite, index_of, positive};
use super::raw::{Number, RawGoal};
use crate::math::Pose;
use crate::motion::{
    Axes, BodyPoint, Condition, EventKind, Goal, GoalQuantity, GoalSet, GoalTarget, LinkIndex,
    Moment, Scene,
};

/// Millimetres, degrees and milliseconds in SI units.
const MM: f64 = 1e-3;
const DEG: f64 = std::f64::consts::PI / 180.0;
const MS: f64 = 1e-3;

/// The goals of the tables, with the place of the table of each.
pub(super) fn goals(
    raw: &[&Spanned<RawGoal>],
    scene: &Scene,
) -> Result<(Vec<Goal>, Vec<Range<usize>>), Fault> {
    let (mut goals, mut spans) = (Vec::new(), Vec::new());
    for spanned in raw {
        let of_table = Table::new(spanned, scene)?.goals()?;
        spans.extend(of_table.iter().map(|_| spanned.span()));
        goals.extend(of_table);
    }
    Ok((goals, spans))
}

/// One table.
struct Table<'a> {
    raw: &'a RawGoal,
    span: Range<usize>,
    scene: &'a Scene,
    event: usize,
    used: Used,
}

impl<'a> Table<'a> {
    fn new(spanned: &'a Spanned<RawGoal>, scene: &'a Scene) -> Result<Self, Fault> {
        let raw = spanned.get_ref();
        Ok(Self {
            event: event_of(&raw.event, scene)?,
            raw,
            span: spanned.span(),
            scene,
            used: Used::default(),
        })
    }

    /// The conditions of the table as goals.
    fn goals(mut self) -> Result<Vec<Goal>, Fault> {
        let mut goals: Vec<Goal> = self.time()?.into_iter().collect();
        let is_of_body = self
            .raw
            .given()
            .any(|(key, _)| !matches!(key, "time_ms" | "time_within_ms" | "since" | "sd_ms"));
        if let (Some(_), Some(joint)) = (&self.raw.body, &self.raw.joint) {
            return fault(joint.span(), "expected one of body, joint");
        }
        if let Some(joint) = &self.raw.joint {
            goals.push(self.of_joint(joint)?);
        }
        match &self.raw.body {
            Some(body) => {
                let link = link_of(body, self.scene)?;
                check_goal(body, link, self.scene)?;
                let of_body = self.of_body(link)?;
                if of_body.is_empty() && !goals.is_empty() {
                    self.used.check(self.raw)?;
                    return fault(body.span(), "body does not apply to a time");
                }
                let event = self.event;
                goals.extend(of_body.into_iter().map(|target| Goal {
                    event,
                    link,
                    target,
                }));
            }
            None if self.raw.joint.is_none() && (is_of_body || goals.is_empty()) => {
                return fault(self.span, "missing key `body`: what the goal is about");
            }
            None => {}
        }
        self.used.check(self.raw)?;
        if goals.is_empty() {
            return fault(self.span, format!("a goal needs one of {ABOUT}"));
        }
        Ok(goals)
    }

    /// What is asked of a body.
    fn of_body(&mut self, link: LinkIndex) -> Result<Vec<GoalTarget>, Fault> {
        let raw = self.raw;
        let mut targets = Vec::new();
        let point = self.point(link)?;
        let seen_from = self.seen_from(link)?;
        let position = self.set(&VectorKeys {
            exact: ("position_mm", &raw.position_mm),
            within: ("position_within_mm", &raw.position_within_mm),
            radius: ("within_mm", &raw.within_mm),
            sd: ("sd_mm", &raw.sd_mm),
            unit: MM,
        })?;
        let turn = self.turn(link, seen_from)?;
        if position.is_some() {
            self.used
                .add(&["point_mm", "feature", "contact", "relative_to"]);
        }
        match (position, turn) {
            (Some((set, None)), Some(turn)) if is_pose(&set, &turn, point) => {
                targets.push(pose(&set, &turn, point));
            }
            (position, turn) => {
                if let Some((set, sd)) = position {
                    let quantity = GoalQuantity::Position { point, seen_from };
                    let axes_from_given = self.link_from_given(seen_from);
                    let sets = self.in_axes(set, &axes_from_given)?;
                    targets.extend(sets.into_iter().map(|set| target(quantity, set, sd)));
                }
                targets.extend(turn.map(GoalTarget::Condition));
            }
        }
        targets.extend(self.direction(link, seen_from)?);
        let velocity = self.set(&VectorKeys {
            exact: ("velocity_m_s", &raw.velocity_m_s),
            within: ("velocity_within_m_s", &raw.velocity_within_m_s),
            radius: ("within_m_s", &raw.within_m_s),
            sd: ("sd_m_s", &raw.sd_m_s),
            unit: 1.0,
        })?;
        let spin = self.set(&VectorKeys {
            exact: ("spin_rad_s", &raw.spin_rad_s),
            within: ("spin_within_rad_s", &raw.spin_within_rad_s),
            radius: ("within_rad_s", &raw.within_rad_s),
            sd: ("sd_rad_s", &raw.sd_rad_s),
            unit: 1.0,
        })?;
        let moment = self.moment(link)?;
        if velocity.is_some() {
            self.used.add(&["point_mm", "feature", "after"]);
            if let (Some(contact), None) = (&raw.contact, &raw.position_mm) {
                return fault(contact.span(), "contact does not apply to a velocity");
            }
        }
        if spin.is_some() {
            self.used.add(&["axes", "after"]);
        }
        let axes = self.axes()?;
        let still = self.still(moment, velocity.is_some(), spin.is_some())?;
        let hard = |quantity, (set, sd)| Condition {
            quantity,
            set,
            moment,
            sd,
        };
        let velocity = velocity.map(|of| hard(GoalQuantity::Velocity { point }, of));
        let spins = match spin {
            Some((set, sd)) => {
                let turn = match axes {
                    Axes::World => Pose::identity(),
                    Axes::Body => {
                        let turn = self.link_from_given(Some(link)).rotation;
                        Pose::from_parts(Vector3::zeros().into(), turn)
                    }
                };
                let sets = self.in_axes(set, &turn)?.into_iter();
                sets.map(|set| hard(GoalQuantity::Spin { axes }, (set, sd)))
                    .collect()
            }
            None => Vec::new(),
        };
        let all = velocity.into_iter().chain(spins).chain(still);
        targets.extend(all.map(GoalTarget::Condition));
        self.one_half_space()?;
        Ok(targets)
    }

    /// The frame in which a body is given, in its link's axes; of the world the identity.
    fn link_from_given(&self, of: Option<LinkIndex>) -> Pose {
        of.map_or_else(Pose::identity, |link| {
            self.scene.links[link].link_from_given
        })
    }

    fn in_axes(&self, set: GoalSet, axes_from_given: &Pose) -> Result<Vec<GoalSet>, Fault> {
        set::in_axes(set, axes_from_given).or_else(|said| fault(self.span.clone(), said))
    }

    /// When the event is.
    fn time(&mut self) -> Result<Option<Goal>, Fault> {
        let raw = self.raw;
        let bounds_ms = match (&raw.time_ms, &raw.time_within_ms) {
            (None, None) => return Ok(None),
            (Some(time), None) => [finite("time_ms", time)?; 2],
            (Some(_), Some(within)) => {
                return fault(within.span(), "expected one of time_ms, time_within_ms");
            }
            (None, Some(within)) => {
                let [from, to] = *within.get_ref();
                let some_room = from <= to && from < f64::INFINITY && to > f64::NEG_INFINITY;
                if !some_room || from.is_infinite() && to.is_infinite() {
                    return fault(
                        within.span(),
                        format!(
                            "time_within_ms is from {from} to {to}, expected a bound and one not before it"
                        ),
                    );
                }
                [from, to]
            }
        };
        let since = match &raw.since {
            Some(text) => Some(event_of(text, self.scene)?),
            None => None,
        };
        if let (Some(text), Some(since)) = (&raw.since, since)
            && since == self.event
        {
            return fault(
                text.span(),
                "since is the goal's own event, expected another",
            );
        }
        self.used
            .add(&["time_ms", "time_within_ms", "since", "sd_ms"]);
        let [from_s, to_s] = bounds_ms.map(|ms| ms * MS);
        let condition = Condition {
            quantity: GoalQuantity::Time { since },
            set: GoalSet::Box {
                lower: Vector3::new(from_s, f64::NEG_INFINITY, f64::NEG_INFINITY),
                upper: Vector3::new(to_s, f64::INFINITY, f64::INFINITY),
            },
            moment: Moment::Before,
            sd: sd("sd_ms", &raw.sd_ms, MS)?,
        };
        Ok(Some(Goal {
            event: self.event,
            link: LinkIndex(0),
            target: GoalTarget::Condition(condition),
        }))
    }

    /// In which axes a spin is.
    fn axes(&self) -> Result<Axes, Fault> {
        match self
            .raw
            .axes
            .as_ref()
            .map(|text| (text, text.get_ref().as_str()))
        {
            None | Some((_, "world")) => Ok(Axes::World),
            Some((_, "body")) => Ok(Axes::Body),
            Some((text, other)) => fault(
                text.span(),
                format!("axes are {other:?}, expected \"world\" or \"body\""),
            ),
        }
    }

    /// At which side of the event.
    fn moment(&self, link: LinkIndex) -> Result<Moment, Fault> {
        let Some(after) = self.raw.after.as_ref().filter(|after| *after.get_ref()) else {
            return Ok(Moment::Before);
        };
        let collision = self.scene.events[self.event].kind.collision();
        let mechanism = self.scene.mechanism_of(link);
        if collision.is_some_and(|of| self.scene.takes_part(mechanism, of)) {
            return Ok(Moment::After);
        }
        fault(
            after.span(),
            format!(
                "nothing changes for {:?} at {:?}, expected a collision of it",
                self.scene.links[link].name, self.scene.events[self.event].name
            ),
        )
    }

    /// No velocity and no spin.
    fn still(
        &mut self,
        moment: Moment,
        has_velocity: bool,
        has_spin: bool,
    ) -> Result<Vec<Condition>, Fault> {
        let raw = self.raw;
        let Some(at_rest) = raw.at_rest.as_ref().filter(|of| *of.get_ref()) else {
            // What is not at rest may be said so.
            self.used.add(&["at_rest"]);
            return Ok(Vec::new());
        };
        if has_velocity || has_spin {
            return fault(
                at_rest.span(),
                "at_rest is no velocity and no spin, expected it or others",
            );
        }
        self.used.add(&[
            "at_rest",
            "after",
            "within_m_s",
            "sd_m_s",
            "within_rad_s",
            "sd_rad_s",
        ]);
        let radius = |key: &str, number: &Option<Number>| {
            let radius = number.as_ref().map(|number| positive(key, number));
            radius.transpose().map(GoalSet::about_zero)
        };
        let condition = |quantity, set, sd| Condition {
            quantity,
            set,
            moment,
            sd,
        };
        let point = BodyPoint::Centre;
        Ok(vec![
            condition(
                GoalQuantity::Velocity { point },
                radius("within_m_s", &raw.within_m_s)?,
                sd("sd_m_s", &raw.sd_m_s, 1.0)?,
            ),
            condition(
                GoalQuantity::Spin { axes: Axes::World },
                radius("within_rad_s", &raw.within_rad_s)?,
                sd("sd_rad_s", &raw.sd_rad_s, 1.0)?,
            ),
        ])
    }
}

/// An event of which a goal may be: one, not several.
fn event_of(text: &Spanned<String>, scene: &Scene) -> Result<usize, Fault> {
    let events = &scene.events;
    let event = index_of("event", text, events.iter().map(|e| e.name.as_str()))?;
    if matches!(events[event].kind, EventKind::Collisions { .. }) {
        return fault(
            text.span(),
            format!(
                "a goal at {:?}, which stands for several, expected an event of its own",
                events[event].name
            ),
        );
    }
    Ok(event)
}

/// A condition on poses; a hard box for the centre of mass in its short form.
fn target(quantity: GoalQuantity, set: GoalSet, sd: Option<f64>) -> GoalTarget {
    let centre = GoalQuantity::Position {
        point: BodyPoint::Centre,
        seen_from: None,
    };
    match set {
        GoalSet::Box { lower, upper } if sd.is_none() && quantity == centre => {
            GoalTarget::PositionWithin {
                lower_m: lower,
                upper_m: upper,
            }
        }
        _ => GoalTarget::Condition(Condition {
            quantity,
            set,
            moment: Moment::Before,
            sd,
        }),
    }
}

/// Whether a position and a turn are a pose in the world, exactly.
fn is_pose(set: &GoalSet, turn: &Condition, point: BodyPoint) -> bool {
    set.is_point(3)
        && turn.is_equality()
        && turn.quantity.seen_from().is_none()
        && !matches!(point, BodyPoint::Contact(_))
}

/// The pose in which a point is there.
fn pose(set: &GoalSet, turn: &Condition, point: BodyPoint) -> GoalTarget {
    let (GoalSet::Box { lower: at_m, .. }, GoalQuantity::Turn { from, .. }) = (set, turn.quantity)
    else {
        unreachable!("a pose is a point and a turn");
    };
    let point_m = match point {
        BodyPoint::Fixed(point_m) => point_m,
        _ => Vector3::zeros(),
    };
    let centre_m = at_m - from * point_m;
    GoalTarget::Pose {
        world_from_body: Pose::from_parts(centre_m.into(), from),
    }
}

/// Refuses goals that contradict each other, as far as the scene tells it.
pub(super) fn check(scene: &Scene, spans: &[Range<usize>]) -> Result<(), Fault> {
    match scene.goal_fault() {
        Some((goal, message)) => fault(spans[goal].clone(), message),
        None => Ok(()),
    }
}
