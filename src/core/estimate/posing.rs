//! The problem of a scene and a sketch: which arcs there are, what ties them, and what is free.

pub(in crate::estimate) mod clearance;
pub(in crate::estimate) mod conditions;
mod hands;
pub(in crate::estimate) mod nodes;
pub(in crate::estimate) mod regulariser;
pub(in crate::estimate) mod sample_order;
pub(in crate::estimate) mod seen;
mod support;
pub(in crate::estimate) mod waypoint;
mod weaving;

use self::conditions::{conditions, flight_at};
use self::hands::PosedHands;
pub(in crate::estimate) use self::nodes::Nodes;
use self::seen::views;
use crate::estimate::problem::influence::{Acting, Influence, Owner, Role};
use crate::estimate::problem::{
    Arc, ArcCollision, ArcGoal, ArcPair, ArcTarget, Bounded, EventMark, HeldState, Ordered,
    Problem, TimeBound, TimeSide,
};
use crate::motion::{
    EventKind, GoalTarget, LinkIndex, Moment, Partner, Quantity, Scene, Segment, Sketch,
    SupportPhase, Timing,
};

impl Problem {
    /// The problem of a scene and a sketch cut into segments.
    ///
    /// # Panics
    /// Where the scene leaves a contact open or has an unsupported one: earlier stages exclude
    /// this.
    pub fn new(scene: &Scene, sketch: &Sketch, segments: &[Segment]) -> Self {
        let nodes = match scene.timing {
            Timing::Known | Timing::Edited => Nodes::everywhere(sketch, segments),
            Timing::Unknown { .. } => Nodes::spaced(sketch, segments),
        };
        Self::at_nodes(scene, sketch, segments, nodes)
    }

    /// The same with other nodes.
    pub(in crate::estimate) fn at_nodes(
        scene: &Scene,
        sketch: &Sketch,
        segments: &[Segment],
        nodes: Nodes,
    ) -> Self {
        let roles = Role::all(
            scene.parameters.iter().map(|free| free.quantity),
            |link| scene.mechanism_of(link),
            |link| scene.links[link].body.moments_kg_m2(),
        );
        let arcs = segments.iter().map(|segment| Arc {
            mechanism: segment.mechanism,
            start: segment.start_event,
            end: segment.end_event,
            views: views(scene, sketch, segment, &nodes),
            body: scene.body_between(segment.mechanism, segment.ends()),
            friction_parameter: None,
            clock: None,
            acting: Vec::new(),
            is_plain: true,
        });
        let mut arcs: Vec<Arc> = arcs.collect();
        let parameter = |quantity: Quantity| scene.parameter_of(quantity);
        let gravity_parameters = [0, 1, 2].map(|axis| parameter(Quantity::Gravity { axis }));
        let flights: Vec<usize> = (0..arcs.len())
            .map(|index| {
                let before = arcs[..index].iter();
                before
                    .filter(|arc| arc.mechanism == arcs[index].mechanism)
                    .count()
            })
            .collect();
        for ((arc, segment), flight) in arcs.iter_mut().zip(segments).zip(flights) {
            let acting = |role: &Role| match role.owner {
                Owner::Link(_, mechanism) => mechanism == arc.mechanism,
                Owner::Track(track) => arc.views.iter().any(|view| view.track == track),
                Owner::Flight(track, of) => {
                    of == flight && arc.views.iter().any(|view| view.track == track)
                }
                Owner::Sample(track, of) => {
                    let mut views = segment.views.iter();
                    views.any(|view| view.track == track && view.samples.contains(&of))
                }
                Owner::Surface(_) | Owner::Contact(_) => false,
            };
            let acting = roles.iter().filter(|role| acting(role));
            let mut of_flights = acting.clone();
            let clock = of_flights.find(|role| matches!(role.owner, Owner::Flight(..)));
            arc.clock = clock.map(|role| role.parameter);
            arc.acting = acting.map(|role| role.acting(None)).collect();
            let phase = scene.phase_between(arc.mechanism, segment.ends());
            let law = phase.and_then(SupportPhase::friction_law);
            arc.friction_parameter = law.and_then(|law| parameter(Quantity::Friction { law }));
            arc.acting.extend(arc.friction_parameter.map(friction));
            let body = arc.body;
            arc.is_plain = arc.acting.is_empty() && body.is_ballistic();
            for view in &mut arc.views {
                let acts = |acting: &Acting| acting.is_on(view.track);
                view.is_plain &= body.is_ballistic() && !arc.acting.iter().any(acts);
            }
            if arc.views.iter().any(|view| !view.is_plain) || !arc.is_plain {
                arc.acting.extend(gravity(&gravity_parameters));
            }
        }
        let waypoints = waypoint::waypoints(scene, &arcs);
        // The time of a collision or a waypoint is an unknown even where it is fixed: by a bound.
        let events = scene.events.iter().enumerate();
        let event_is_free: Vec<bool> = events
            .map(|(event, e)| match e.kind.waypoint() {
                Some(_) => waypoints.iter().any(|waypoint| waypoint.event == event),
                None => {
                    let is_unknown = e.kind.collision().is_some() || e.kind.change().is_some();
                    is_unknown || scene.time_is_free(event)
                }
            })
            .collect();
        let (mut ordered, mut time_bounds) = (
            ordered(&arcs, &event_is_free),
            time_bounds(scene, sketch, &event_is_free, &nodes.acted_s),
        );
        let within = waypoint::kept_within(
            scene,
            sketch,
            &nodes.acted_s,
            &arcs,
            &waypoints,
            &event_is_free,
        );
        ordered.extend(within.0);
        time_bounds.extend(within.1);
        let marks = marks(scene, sketch, &event_is_free, &nodes.acted_s);
        let mut held = Vec::new();
        let posed = PosedHands {
            scene,
            sketch,
            roles: &roles,
            nodes_acted_s: &nodes.acted_s,
        };
        let mut hold = |of: Option<HeldState>| {
            held.push(of?);
            Some(held.len() - 1)
        };
        let collisions = collisions(
            scene,
            &arcs,
            &roles,
            &gravity_parameters,
            &parameter,
            |of| hold(posed.hit(of)),
        );
        let changes = support::changes(scene, &arcs, &gravity_parameters, |phase, event| {
            hold(posed.gripped(phase, event))
        });
        Self {
            conditions: conditions(scene, &arcs, &collisions, &gravity_parameters),
            // What is apart has no arcs: any body stands for it.
            bodies: scene
                .mechanisms
                .iter()
                .filter_map(|of| Some(scene.links[of.links().next()?].body))
                .collect(),
            changes,
            cuts_sd_s: sketch.cuts_sd_s.clone(),
            stickings: support::stickings(scene, &arcs, &gravity_parameters),
            supports: support::supports(scene, &arcs),
            grips: support::grips(scene, sketch),
            gravity_m_s2: scene.gravity_m_s2,
            collisions,
            held,
            gravity_parameters,
            mounts: scene
                .tracks
                .iter()
                .map(|track| track.link_from_tracker)
                .collect(),
            roles,
            goals: goals(scene, &arcs),
            ordered,
            sample_orders: sample_order::of_arcs(&arcs, |event| {
                event_is_free[event] || scene.timing != Timing::Edited
            }),
            ends_are_samples: scene.timing == Timing::Edited,
            time_bounds,
            waypoints,
            regulariser: regulariser::pulls(&arcs),
            arcs,
            event_is_free,
            events_acted_s: sketch.marks_s.clone(),
            marks,
            parameters: scene.parameters.clone(),
            bounded: bounded(scene),
            cones: scene.cones.clone(),
            clearances: Vec::new(),
            velocity_gap_weight: None,
            tempo_sd_per_sqrt_s: match scene.timing {
                Timing::Known | Timing::Edited => None,
                Timing::Unknown {
                    tempo_sd_per_sqrt_s,
                } => Some(tempo_sd_per_sqrt_s),
            },
            tempo_counts: nodes.samples_each,
            nodes_acted_s: nodes.acted_s,
            performer: scene.performer,
            weave: None,
            position_unit_m: scene.weights.position_m,
            orientation_unit_rad: scene.weights.orientation_rad,
            keeps_starts: scene.is_keyframed(sketch),
            pulls: Vec::new(),
        }
    }
}

/// The ends of arcs that have few samples, where both are unknowns.
fn ordered(arcs: &[Arc], event_is_free: &[bool]) -> Vec<Ordered> {
    let few = arcs.iter().filter(|arc| !arc.is_informed());
    let pairs = few.filter_map(|arc| Some([arc.start?, arc.end?]));
    let free = pairs.filter(|events| events.iter().all(|event| event_is_free[*event]));
    let ordered = free.map(|events| Ordered { events });
    ordered.collect()
}

/// The friction of what supports a body, held by a parameter.
fn friction(parameter: usize) -> Acting {
    Acting {
        parameter,
        influence: Influence::SupportFriction,
        side: None,
        track: None,
    }
}

/// Gravity's free components as parameters that act on every flight.
fn gravity(parameters: &[Option<usize>; 3]) -> impl Iterator<Item = Acting> + '_ {
    let axes = parameters.iter().enumerate();
    axes.filter_map(|(axis, parameter)| {
        Some(Acting {
            parameter: (*parameter)?,
            influence: Influence::Pull(axis),
            side: None,
            track: None,
        })
    })
}

fn bounded(scene: &Scene) -> Vec<Bounded> {
    let parameters = scene.parameters.iter().enumerate();
    let bounded = parameters.filter(|(parameter, free)| {
        let in_cone = scene.cones.iter().any(|c| c.parameters.contains(parameter));
        !in_cone && (free.lower.is_finite() || free.upper.is_finite())
    });
    bounded
        .map(|(parameter, _)| Bounded { parameter })
        .collect()
}

fn marks(
    scene: &Scene,
    sketch: &Sketch,
    event_is_free: &[bool],
    nodes_acted_s: &[f64],
) -> Vec<EventMark> {
    let is_known = !matches!(scene.timing, Timing::Unknown { .. });
    let marks = sketch.marks.iter().enumerate();
    let marks = marks.filter(|(event, _)| event_is_free[*event]);
    marks
        .filter_map(|(event, mark)| {
            let mark = (*mark)?;
            let nodes = EventMark::nodes_about(nodes_acted_s, sketch.marks_s[event]);
            (is_known || nodes.is_some()).then_some(EventMark {
                event,
                acted_s: mark.acted_s,
                sd_s: mark.counted_sd_s(),
                counted: mark.counted,
                nodes: nodes.filter(|_| !is_known),
            })
        })
        .collect()
}

fn time_bounds(
    scene: &Scene,
    sketch: &Sketch,
    event_is_free: &[bool],
    nodes_acted_s: &[f64],
) -> Vec<TimeBound> {
    let is_known = !matches!(scene.timing, Timing::Unknown { .. });
    let mut bounds = Vec::new();
    for (event, of) in scene.events.iter().enumerate() {
        let mark_s = sketch.marks[event].map_or(sketch.marks_s[event], |mark| mark.acted_s);
        let [earliest_s, latest_s] = of.time.window_s;
        let sides = if scene.time_is_free(event) {
            vec![
                (TimeSide::Earliest, earliest_s),
                (TimeSide::Latest, latest_s),
            ]
        } else if !matches!(of.kind, EventKind::Start | EventKind::End) {
            vec![(TimeSide::Only, 0.0)]
        } else {
            Vec::new()
        };
        // A waypoint is here only with its flight.
        let is_here = of.kind.waypoint().is_none() || event_is_free[event];
        let sides = sides.into_iter().filter(|_| is_here);
        let sides = sides.filter(|(_, after_s)| after_s.is_finite());
        bounds.extend(sides.map(|(side, after_s)| {
            let acted_s = mark_s + after_s;
            let nodes = EventMark::nodes_about(nodes_acted_s, acted_s);
            TimeBound {
                event,
                side,
                acted_s,
                nodes: nodes.filter(|_| !is_known),
                half_width_s: 0.5 * (latest_s - earliest_s),
            }
        }));
    }
    bounds
}

fn collisions(
    scene: &Scene,
    arcs: &[Arc],
    roles: &[Role],
    gravity_parameters: &[Option<usize>; 3],
    parameter: &impl Fn(Quantity) -> Option<usize>,
    mut hold: impl FnMut(usize) -> Option<usize>,
) -> Vec<ArcCollision> {
    let events = scene.events.iter().enumerate();
    let all = events.filter_map(|(event, e)| Some((event, e.kind.collision()?)));
    all.filter_map(|(event, collision)| {
        let law = collision.law;
        let side = |link: LinkIndex| {
            let mechanism = scene.mechanism_of(link);
            let arc_with = |end: bool| {
                arcs.iter().position(|arc| {
                    arc.mechanism == mechanism
                        && (if end { arc.end } else { arc.start }) == Some(event)
                })
            };
            Some(ArcPair {
                mechanism,
                before: arc_with(true)?,
                after: arc_with(false)?,
            })
        };
        let free = collision.links().filter(|link| !scene.is_held(*link));
        let sides: Vec<ArcPair> = free.map(side).collect::<Option<_>>()?;
        let surface = match collision.partner {
            Partner::World => collision
                .contacts
                .first()
                .and_then(|touching| touching.other),
            Partner::Link(_) => None,
        };
        let acting = roles.iter().filter_map(|role| match role.owner {
            Owner::Link(link, _) => {
                let side = collision.links().position(|other| other == link)?;
                Some(role.acting(Some(side)))
            }
            Owner::Surface(of) => (Some(of) == surface).then(|| role.acting(None)),
            Owner::Contact(of) => (of == event).then(|| role.acting(None)),
            Owner::Track(_) | Owner::Flight(..) | Owner::Sample(..) => None,
        });
        let mut acting: Vec<Acting> = acting.collect();
        let is_parabola = |side: &ArcPair| {
            let mut both = [side.before, side.after].into_iter();
            both.all(|arc| arcs[arc].body.is_ballistic())
        };
        // The friction of what supports it before or after acts on the flights beside the impact.
        let of_supports = sides.iter().flat_map(|side| [side.before, side.after]);
        let mut supports: Vec<usize> = of_supports
            .filter_map(|arc| arcs[arc].friction_parameter)
            .collect();
        supports.sort_unstable();
        supports.dedup();
        acting.extend(supports.into_iter().map(friction));
        let is_plain = acting.is_empty() && sides.iter().all(is_parabola);
        if !is_plain {
            acting.extend(gravity(gravity_parameters));
        }
        Some(ArcCollision {
            event,
            sides,
            held: hold(event),
            acting,
            is_plain,
            contacts: scene
                .contact_set(event)
                .expect("a collision that the scene's makers checked")
                .expect("contacts that stages before found"),
            touches_by_goal: collision.partner == Partner::World
                && scene.fixes_pose(event, collision.link),
            law: scene.impact_law(collision),
            restitution_parameter: parameter(Quantity::Restitution { law }),
            friction_parameter: parameter(Quantity::Friction { law }),
            tangential_parameter: parameter(Quantity::TangentialRestitution { law }),
            tilts: (0..2)
                .filter_map(|tangent| {
                    Some((tangent, parameter(Quantity::Tilt { event, tangent })?))
                })
                .collect(),
        })
    })
    .collect()
}

/// The held body at a collision with one.
fn goals(scene: &Scene, arcs: &[Arc]) -> Vec<ArcGoal> {
    let mut goals = Vec::new();
    for goal in &scene.goals {
        let mechanism = scene.mechanism_of(goal.link);
        let arc = arcs
            .iter()
            .position(|arc| arc.mechanism == mechanism && arc.end == Some(goal.event))
            .or_else(|| {
                arcs.iter()
                    .position(|arc| arc.mechanism == mechanism && arc.start == Some(goal.event))
            });
        // Through the events of others a body flies on.
        let through = || flight_at(scene, arcs, mechanism, goal.event, Moment::Before);
        let Some(arc) = arc.or_else(through) else {
            continue;
        };
        let event = goal.event;
        match &goal.target {
            GoalTarget::Pose { world_from_body } => {
                goals.push(ArcGoal {
                    event,
                    arc,
                    target: ArcTarget::Pose(*world_from_body),
                });
            }
            GoalTarget::PositionWithin { lower_m, upper_m } => {
                for axis in 0..3 {
                    let (lower_m, upper_m) = (lower_m[axis], upper_m[axis]);
                    if lower_m.is_finite() || upper_m.is_finite() {
                        let target = ArcTarget::Coordinate {
                            axis,
                            lower_m,
                            upper_m,
                        };
                        goals.push(ArcGoal { event, arc, target });
                    }
                }
            }
            GoalTarget::Condition(_) => {}
        }
    }
    goals
}
