//! Contact laws: restitutions and friction of a body, or of one event.

use crate::config::spanned::Spanned;
use typed_index_collections::TiVec;

use super::error::{Fault, fault};
use super::number::finite;
use super::raw::{Number, RawBody, RawEvent};
use crate::motion::{Collision, ContactLaw, ContactLawIndex, LinkIndex};

/// Greatest coefficient of friction; a larger one is a mistake.
const FRICTION_MAX: f64 = 10.0;

/// All laws of a scene.
pub(super) type Laws = TiVec<ContactLawIndex, ContactLaw>;

/// The laws of the bodies that have one.
pub(super) type BodyLaws = TiVec<LinkIndex, Option<ContactLawIndex>>;

/// The laws of the bodies that have one; appends them to the scene's.
pub(super) fn of_bodies(raw: &[Spanned<RawBody>], laws: &mut Laws) -> Result<BodyLaws, Fault> {
    let of_body = |spanned: &Spanned<RawBody>| {
        let body = spanned.get_ref();
        let Some(restitution) = &body.restitution else {
            let others = [
                (&body.friction, "friction"),
                (&body.tangential_restitution, "tangential restitution"),
                (&body.restitution_sd, "deviation of it"),
                (&body.friction_sd, "deviation of its friction"),
            ];
            for (other, what) in others {
                if let Some(alone) = other {
                    let message = format!(
                        "the body has a {what} and no restitution, expected both or neither"
                    );
                    return fault(alone.span(), message);
                }
            }
            return Ok(None);
        };
        let name = body.name.get_ref();
        let law = law(
            name,
            &LawNumbers {
                restitution,
                friction: body.friction.as_ref(),
                tangential: body.tangential_restitution.as_ref(),
                is_bumper: false,
            },
        )?;
        let sd = |what: &str, number: &Option<Number>| match number {
            None => Ok(0.0),
            Some(number) => within(what, number, 1.0),
        };
        let law = ContactLaw {
            restitution_sd: sd("restitution_sd", &body.restitution_sd)?,
            friction_sd: sd("friction_sd", &body.friction_sd)?,
            ..law
        };
        Ok(Some(laws.push_and_get_key(law)))
    };
    raw.iter().map(of_body).collect()
}

/// The law of a collision between links of which the bodies' laws are known: the event's own, or
/// that of the one body that has one.
pub(super) fn of_event(
    spanned: &Spanned<RawEvent>,
    collision: &Collision,
    of_links: &BodyLaws,
    laws: &mut Laws,
) -> Result<ContactLawIndex, Fault> {
    let event = spanned.get_ref();
    if let (Some(tangential), None) = (&event.tangential_restitution, &event.restitution) {
        return fault(
            tangential.span(),
            "the event has a tangential restitution of its own but no restitution, expected both or neither",
        );
    }
    if let (Some(bumper), None) = (&event.bumper, &event.restitution) {
        return fault(
            bumper.span(),
            "a bumper without a restitution, expected the event's own beside it",
        );
    }
    let of_bodies: Vec<ContactLawIndex> = collision.links().filter_map(|l| of_links[l]).collect();
    let found = match (&event.restitution, &event.friction, of_bodies.as_slice()) {
        (Some(restitution), friction, bodies) => {
            let tangential = event.tangential_restitution.as_ref();
            if let Some(body) = bodies.first() {
                let body = &laws[*body];
                let lacks = match (friction, tangential) {
                    (None, _) if body.friction > 0.0 => Some("friction"),
                    (_, None) if body.tangential_restitution > 0.0 => {
                        Some("tangential restitution")
                    }
                    _ => None,
                };
                if let Some(what) = lacks {
                    return fault(
                        restitution.span(),
                        format!(
                            "the event has a restitution of its own but no {what}, and {:?} has {what}, expected both here or neither",
                            body.name
                        ),
                    );
                }
            }
            let name = event.name.get_ref();
            if laws.iter().any(|law| law.name == *name) {
                return fault(
                    event.name.span(),
                    format!(
                        "the event {name:?} has a restitution and so has the body of this name, expected another name"
                    ),
                );
            }
            let is_bumper = event.bumper.as_ref().is_some_and(|of| *of.get_ref());
            let given = LawNumbers {
                restitution,
                friction: friction.as_ref(),
                tangential,
                is_bumper,
            };
            laws.push_and_get_key(law(name, &given)?)
        }
        (None, Some(friction), [_, ..]) => {
            return fault(
                friction.span(),
                "the event has a friction of its own but no restitution, expected both or neither",
            );
        }
        (None, None, [body]) => *body,
        (None, None, [_, other, ..]) => {
            return fault(
                spanned.span(),
                format!(
                    "both bodies have a restitution ({:?} {}), expected the event's own",
                    laws[*other].name, laws[*other].restitution
                ),
            );
        }
        (None, _, []) => {
            return fault(
                spanned.span(),
                "missing key `restitution`: a collision needs body and restitution, its own or the body's",
            );
        }
    };
    Ok(found)
}

/// What a body or an event says of its law.
struct LawNumbers<'a> {
    restitution: &'a Number,
    friction: Option<&'a Number>,
    tangential: Option<&'a Number>,
    is_bumper: bool,
}

fn law(name: &str, given: &LawNumbers) -> Result<ContactLaw, Fault> {
    let LawNumbers {
        restitution,
        friction,
        tangential,
        is_bumper,
    } = *given;
    if let (Some(tangential), None) = (tangential, friction) {
        return fault(
            tangential.span(),
            "a tangential restitution without friction, expected a friction beside it: only what sticks springs back",
        );
    }
    let law = ContactLaw {
        is_bumper,
        ..ContactLaw::frictionless(name, *restitution.get_ref())
    };
    if law.restitution > 1.0 && !is_bumper {
        return fault(
            restitution.span(),
            format!(
                "restitution is {}, expected 0 to 1: of an event at which something gives energy say bumper = true beside its own restitution",
                law.restitution
            ),
        );
    }
    within("restitution", restitution, law.most_restitution())?;
    Ok(ContactLaw {
        friction: match friction {
            None => 0.0,
            Some(number) => within("friction", number, FRICTION_MAX)?,
        },
        tangential_restitution: match tangential {
            None => 0.0,
            Some(number) => within("tangential_restitution", number, 1.0)?,
        },
        ..law
    })
}

/// The law of what stays on a surface: friction only.
pub(super) fn sustained(name: &str, friction: &Number) -> Result<ContactLaw, Fault> {
    Ok(ContactLaw {
        friction: within("friction", friction, FRICTION_MAX)?,
        ..ContactLaw::frictionless(name, 0.0)
    })
}

/// A number from zero to a greatest one.
fn within(what: &str, number: &Number, most: f64) -> Result<f64, Fault> {
    let value = finite(what, number)?;
    if (0.0..=most).contains(&value) {
        Ok(value)
    } else {
        fault(
            number.span(),
            format!("{what} is {value}, expected 0 to {most}"),
        )
    }
}
