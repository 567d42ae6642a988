//! Takes among each other: in one order, and agreed on what is asked.

use std::collections::BTreeMap;

use anyhow::bail;

use super::names::AskedNames;
use super::take::Member;
use crate::jointly::JointParameter;

/// Takes in the order of their contents, each once.
pub(super) fn in_order(mut members: Vec<Member>) -> Vec<Member> {
    members.sort_by(|a, b| a.order().cmp(&b.order()));
    let mut known: BTreeMap<String, String> = BTreeMap::new();
    for member in &mut members {
        let name = member.file.clone();
        if let Some(other) = known.get(&member.sha256) {
            member.is_the_same_as(other);
        } else if !member.sha256.is_empty() {
            known.insert(member.sha256.clone(), name);
        }
    }
    members
}

/// The parameters as the takes' scenes have them, which must agree.
pub(super) fn agreed(
    members: &[Member],
    names: &AskedNames,
) -> anyhow::Result<Vec<JointParameter>> {
    let mut known: Option<(&Member, Vec<JointParameter>)> = None;
    for member in members {
        let Ok(asked) = &member.asked else { continue };
        let parameters = asked.parameters();
        match &known {
            None => known = Some((member, parameters)),
            Some((first, agreed)) if *agreed != parameters => {
                let differing = agreed.iter().zip(&parameters);
                let differing = differing.filter(|(a, b)| a != b).map(|(a, _)| &a.name);
                let differing: Vec<&str> = differing.map(String::as_str).collect();
                bail!(
                    "the scenes of {} and {} differ in {}, expected the same value, bounds and prior in all: --scene FILE",
                    first.file,
                    member.file,
                    differing.join(", ")
                );
            }
            Some(_) => {}
        }
    }
    let Some((_, parameters)) = known else {
        let first = members.iter().find_map(|of| of.asked.as_ref().err());
        bail!(
            "no take says anything of {}{}",
            names.all.join(", "),
            first.map_or(String::new(), |why| format!(": {why}"))
        );
    };
    Ok(parameters)
}

/// Which of takes that are asked, evenly spread in their order: of the first `n` of them `upto(n)`.
pub(super) fn evenly(
    are_asked: impl IntoIterator<Item = bool>,
    upto: impl Fn(usize) -> usize,
) -> Vec<bool> {
    let mut number = 0;
    let each = are_asked.into_iter().map(|is_asked| {
        number += usize::from(is_asked);
        is_asked && upto(number) > upto(number - 1)
    });
    each.collect()
}
