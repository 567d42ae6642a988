//! Goals at events: `[[goal]]` tables become conditions, each of one quantity.

use std::ops::Range;

use nalgebra::Vector3;
use toml::Spanned;

use super::error::{Fault, fault};
use super::event::{feature_of, link_of};
use super::goal_keys::{ABOUT, Used};
use super::number::{direction, finite, index_of, orientation, positive, vector};
use super::raw::{Corners, Number, RawAxis, RawGoal, Triple};
use super::rest::axis;
use crate::math::Pose;
use crate::motion::{
    Axes, BodyPoint, Condition, EventKind, Goal, GoalQuantity, GoalSet, GoalTarget, LinkIndex,
    Moment, Scene,
};
use crate::physics::contact::Feature;

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
        match &self.raw.body {
            Some(body) => {
                let link = link_of(body, self.scene)?;
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
            None if is_of_body || goals.is_empty() => {
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
        let turn = self.turn(seen_from)?;
        if position.is_some() {
            self.used
                .add(&["point_mm", "feature", "contact", "relative_to"]);
        }
        match (position, turn) {
            (Some((set, None)), Some(turn)) if is_pose(&set, &turn, point) => {
                targets.push(pose(&set, &turn, point));
            }
            (position, turn) => {
                let position = position.map(|(set, sd)| {
                    let quantity = GoalQuantity::Position { point, seen_from };
                    target(quantity, set, sd)
                });
                let turn = turn.map(GoalTarget::Condition);
                targets.extend(position.into_iter().chain(turn));
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
        let still = self.still(moment, (velocity.is_some(), spin.is_some()))?;
        let hard = |quantity, (set, sd)| Condition {
            quantity,
            set,
            moment,
            sd,
        };
        let velocity = velocity.map(|of| hard(GoalQuantity::Velocity { point }, of));
        let spin = spin.map(|of| hard(GoalQuantity::Spin { axes }, of));
        let all = velocity.into_iter().chain(spin).chain(still);
        targets.extend(all.map(GoalTarget::Condition));
        self.one_half_space()?;
        Ok(targets)
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

    /// The point of the body that is meant.
    fn point(&self, link: LinkIndex) -> Result<BodyPoint, Fault> {
        let raw = self.raw;
        if let Some(contact) = raw.contact.as_ref().filter(|contact| *contact.get_ref()) {
            if let Some(point) = &raw.point_mm {
                return fault(point.span(), "expected one of contact, point_mm");
            }
            return Ok(BodyPoint::Contact(self.contact(link, contact.span())?));
        }
        match (&raw.point_mm, &raw.feature) {
            (None, None) => Ok(BodyPoint::Centre),
            (Some(point), None) => Ok(BodyPoint::Fixed(vector("point_mm", point)? * MM)),
            (Some(_), Some(feature)) => fault(feature.span(), "expected one of point_mm, feature"),
            (None, Some(text)) => {
                let link = &self.scene.links[link];
                let feature = &link.features[feature_of(link, text)?];
                match feature.geometry {
                    Feature::Point { point_m, .. } => Ok(BodyPoint::Fixed(point_m)),
                    Feature::Rim { centre_m, .. } => Ok(BodyPoint::Fixed(centre_m)),
                    Feature::Line { .. } | Feature::Face { .. } => fault(
                        text.span(),
                        format!(
                            "{:?} is no one point, expected a corner, or point_mm",
                            feature.name
                        ),
                    ),
                }
            }
        }
    }

    /// Which of the collision's contacts is meant.
    fn contact(&self, link: LinkIndex, span: Range<usize>) -> Result<usize, Fault> {
        let event = &self.scene.events[self.event];
        let collision = event.kind.collision();
        let Some(collision) = collision.filter(|of| of.links().any(|other| other == link)) else {
            return fault(
                span,
                format!(
                    "{:?} touches nothing at {:?}, expected a collision of it",
                    self.scene.links[link].name, event.name
                ),
            );
        };
        let touching = &collision.contacts;
        let Some(text) = &self.raw.feature else {
            return if touching.len() == 1 {
                Ok(0)
            } else {
                fault(
                    span,
                    format!(
                        "{} features touch at {:?}, expected feature to say which",
                        touching.len(),
                        event.name
                    ),
                )
            };
        };
        let feature = feature_of(&self.scene.links[link], text)?;
        let is_it = |touching: &crate::motion::Touching| {
            let own = if collision.link == link {
                touching.feature
            } else {
                touching.other
            };
            own == Some(feature)
        };
        touching.iter().position(is_it).ok_or_else(|| Fault {
            span: text.span(),
            message: format!(
                "{:?} does not touch at {:?}, expected a feature that the event names",
                text.get_ref(),
                event.name
            ),
        })
    }

    /// The body in whose axes positions, orientations and directions are given.
    fn seen_from(&self, link: LinkIndex) -> Result<Option<LinkIndex>, Fault> {
        let Some(text) = &self.raw.relative_to else {
            return Ok(None);
        };
        let other = link_of(text, self.scene)?;
        if other == link {
            return fault(
                text.span(),
                "a body is not seen from itself, expected another",
            );
        }
        Ok(Some(other))
    }

    /// An orientation, exactly or within an angle.
    fn turn(&mut self, seen_from: Option<LinkIndex>) -> Result<Option<Condition>, Fault> {
        let raw = self.raw;
        let Some(wxyz) = &raw.orientation_wxyz else {
            return Ok(None);
        };
        if let Some(axis) = &raw.axis {
            return fault(
                axis.span(),
                "expected one of orientation_wxyz, axis: each in a goal of its own",
            );
        }
        let keys = ["orientation_wxyz", "relative_to", "within_deg", "sd_deg"];
        self.used.add(&keys);
        Ok(Some(Condition {
            quantity: GoalQuantity::Turn {
                from: orientation("orientation of the goal", wxyz)?,
                seen_from,
            },
            set: GoalSet::about_zero(self.angle()?),
            moment: Moment::Before,
            sd: sd("sd_deg", &raw.sd_deg, DEG)?,
        }))
    }

    /// An axis of the body along a direction, exactly or within a cone.
    fn direction(
        &mut self,
        link: LinkIndex,
        seen_from: Option<LinkIndex>,
    ) -> Result<Option<GoalTarget>, Fault> {
        let raw = self.raw;
        let Some(given) = &raw.axis else {
            return Ok(None);
        };
        let axis = match given.get_ref() {
            RawAxis::Name(name) => axis("axis", &self.scene.links[link], (name, given.span()))?,
            RawAxis::Vector(numbers) => {
                let triple: Triple = Spanned::new(given.span(), *numbers);
                direction("axis", &triple)?
            }
        };
        let towards = match (&raw.direction, seen_from) {
            (Some(triple), _) => direction("direction", triple)?,
            (None, None) => {
                let up = self.scene.gravity_m_s2.try_normalize(0.0).map(|down| -down);
                up.ok_or_else(|| Fault {
                    span: given.span(),
                    message: "without gravity nothing is up, expected direction beside axis".into(),
                })?
            }
            (None, Some(_)) => {
                return fault(
                    given.span(),
                    "an axis seen from another body needs a direction in its axes",
                );
            }
        };
        let keys = ["axis", "direction", "relative_to", "within_deg", "sd_deg"];
        self.used.add(&keys);
        let quantity = GoalQuantity::Direction {
            axis,
            towards,
            seen_from,
        };
        let set = GoalSet::about_zero(self.angle()?);
        Ok(Some(target(quantity, set, sd("sd_deg", &raw.sd_deg, DEG)?)))
    }

    fn angle(&self) -> Result<Option<f64>, Fault> {
        let Some(number) = &self.raw.within_deg else {
            return Ok(None);
        };
        let within_deg = positive("within_deg", number)?;
        if within_deg >= 180.0 {
            return fault(
                number.span(),
                format!("within_deg is {within_deg}, expected less than 180"),
            );
        }
        Ok(Some(within_deg * DEG))
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
        if collision.is_some_and(|of| of.links().any(|other| other == link)) {
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
        (has_velocity, has_spin): (bool, bool),
    ) -> Result<Vec<Condition>, Fault> {
        let raw = self.raw;
        let Some(at_rest) = raw.at_rest.as_ref().filter(|of| *of.get_ref()) else {
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

    /// The set of a vector, with its weight; `None` where the goal is not about it.
    fn set(&mut self, keys: &VectorKeys) -> Result<Option<(GoalSet, Option<f64>)>, Fault> {
        let (exact, within) = (keys.exact.1.as_ref(), keys.within.1.as_ref());
        let set = match (exact, within) {
            (None, None) => return Ok(None),
            (Some(_), Some(within)) => {
                return fault(
                    within.span(),
                    format!("expected one of {}, {}", keys.exact.0, keys.within.0),
                );
            }
            (None, Some(within)) => corners(keys.within.0, within, keys.unit)?,
            (Some(exact), None) => {
                self.used.add(&[keys.radius.0, "normal"]);
                let at = vector(keys.exact.0, exact)? * keys.unit;
                match (keys.radius.1, &self.raw.normal) {
                    (None, None) => GoalSet::point(at),
                    (Some(radius), None) => GoalSet::Ball {
                        centre: at,
                        radius: positive(keys.radius.0, radius)? * keys.unit,
                    },
                    (None, Some(triple)) => {
                        let normal = direction("normal", triple)?;
                        GoalSet::HalfSpace {
                            normal,
                            least: normal.dot(&at),
                        }
                    }
                    (Some(_), Some(normal)) => {
                        return fault(
                            normal.span(),
                            format!("expected one of {}, normal", keys.radius.0),
                        );
                    }
                }
            }
        };
        self.used.add(&[keys.exact.0, keys.within.0, keys.sd.0]);
        Ok(Some((set, sd(keys.sd.0, keys.sd.1, keys.unit)?)))
    }

    /// A normal is of one vector.
    fn one_half_space(&self) -> Result<(), Fault> {
        let raw = self.raw;
        let exact = [&raw.position_mm, &raw.velocity_m_s, &raw.spin_rad_s];
        let count = exact.into_iter().flatten().count();
        match &raw.normal {
            Some(normal) if count > 1 => fault(
                normal.span(),
                format!("normal is of {count} vectors, expected a goal for each"),
            ),
            _ => Ok(()),
        }
    }
}

/// The keys of a vector.
struct VectorKeys<'a> {
    exact: (&'static str, &'a Option<Triple>),
    within: (&'static str, &'a Option<Corners>),
    radius: (&'static str, &'a Option<Number>),
    sd: (&'static str, &'a Option<Number>),
    /// Their unit in SI units.
    unit: f64,
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

/// Least standard deviation of a wish: a thousandth of its key's unit.
const SD_MIN: f64 = 1e-3;

/// A standard deviation, in SI units.
fn sd(key: &str, number: &Option<Number>, unit: f64) -> Result<Option<f64>, Fault> {
    let Some(number) = number else {
        return Ok(None);
    };
    let sd = positive(key, number)?;
    if sd < SD_MIN {
        return fault(
            number.span(),
            format!("{key} is {sd}, expected {SD_MIN} or more: without it the goal is hard"),
        );
    }
    Ok(Some(sd * unit))
}

/// A box between two corners.
fn corners(key: &str, given: &Corners, unit: f64) -> Result<GoalSet, Fault> {
    let [lower, upper] = given.get_ref();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let (low, high) = (lower[axis], upper[axis]);
        // `low <= high` is false for NaN too.
        let some_room = low <= high && low < f64::INFINITY && high > f64::NEG_INFINITY;
        if !some_room {
            return fault(
                given.span(),
                format!(
                    "{key} allows {name} from {low} to {high}, expected a lower bound and one not below it"
                ),
            );
        }
    }
    if lower.iter().chain(upper).all(|bound| bound.is_infinite()) {
        return fault(
            given.span(),
            format!("{key} bounds nothing, expected at least one finite bound"),
        );
    }
    Ok(GoalSet::Box {
        lower: Vector3::from(*lower) * unit,
        upper: Vector3::from(*upper) * unit,
    })
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
