//! The topics of bodies.

use std::path::Path;

use anyhow::{bail, ensure};

use crate::ingest::is_pipe;
use crate::ingest::table::{BodyPoses, PoseTable};
use crate::motion::{Holds, Scene, Timing};

/// A body of a file.
pub(super) struct Named<'a> {
    /// Its name in the file, or the file's.
    pub(super) name: String,
    pub(super) table: &'a PoseTable,
    pub(super) body: &'a BodyPoses,
}

/// The name of a file without folder and ending, of stdin `stdin`.
pub(super) fn name_of_file(file: &Path) -> String {
    if is_pipe(file) {
        return "stdin".to_owned();
    }
    let stem = file.file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

/// A topic for each body: that which is given, that of the scene's body with its name or of its only one,
/// else `/tracker/NAME/pose`, of points `/tracker/NAME/point`. `None` for those that are of no body of the scene,
/// where others are.
pub(super) fn topics(
    named: &[(&str, Holds)],
    given: &[String],
    scene: Option<&Scene>,
) -> anyhow::Result<Vec<Option<String>>> {
    let mut in_order = given.iter().filter(|given| !given.contains('='));
    let names: Vec<&str> = named.iter().map(|(name, _)| *name).collect();
    let is_given = |name: &str| {
        given
            .iter()
            .any(|given| given.split_once('=').is_some_and(|(of, _)| of == name))
    };
    let has_order = in_order.clone().next().is_some();
    let is_one = |name: &&str| scene.is_some_and(|scene| is_given(name) || names_body(name, scene));
    // Where some are of the scene, the others are not wanted.
    let some_are = !has_order && names.iter().any(is_one);
    let mut topics: Vec<Option<String>> = Vec::new();
    for (name, holds) in named {
        let by_name = given.iter().find_map(|given| {
            let (of, topic) = given.split_once('=')?;
            (of == *name).then(|| topic.to_owned())
        });
        let topic = match by_name.or_else(|| in_order.next().cloned()) {
            Some(topic) => topic,
            None => match scene {
                Some(_) if some_are && !is_one(name) => {
                    topics.push(None);
                    continue;
                }
                Some(scene) => of_scene(name, &names, scene)?,
                None if *holds == Holds::Position => format!("/tracker/{}/point", plain(name)),
                None => format!("/tracker/{}/pose", plain(name)),
            },
        };
        ensure!(
            !topic.is_empty() && !topic.contains(char::is_whitespace),
            "topic {topic:?} of {name:?}, expected one without spaces, such as /tracker/{}/pose",
            plain(name)
        );
        ensure!(
            !topics.iter().flatten().any(|other| *other == topic),
            "two bodies for topic {topic}: {}; expected a topic for each, with --topic NAME=TOPIC",
            listed(&names)
        );
        topics.push(Some(topic));
    }
    let unknown = given.iter().find(|given| {
        let named = given.split_once('=').map(|(name, _)| name);
        named.is_some_and(|name| !names.contains(&name))
    });
    if let Some(unknown) = unknown.or(in_order.next()) {
        bail!(
            "--topic {unknown}: the files have {}, expected one of them",
            listed(&names)
        );
    }
    Ok(topics)
}

/// Most names that a message lists.
const LISTED: usize = 12;

/// Names in a row, and how many more there are.
pub(super) fn listed(names: &[&str]) -> String {
    match names.len().saturating_sub(LISTED) {
        0 => names.join(", "),
        more => format!("{} and {more} more", names[..LISTED].join(", ")),
    }
}

/// Whether a body of the scene has this name.
fn names_body(name: &str, scene: &Scene) -> bool {
    let mut bodies = scene
        .tracks
        .keys()
        .map(|track| scene.link_seen_by(track).name.as_str());
    bodies.any(|body| same(body, name))
}

fn same(a: &str, b: &str) -> bool {
    plain(a).eq_ignore_ascii_case(&plain(b))
}

fn of_scene(name: &str, names: &[&str], scene: &Scene) -> anyhow::Result<String> {
    let bodies: Vec<(&str, &str)> = scene
        .tracks
        .iter_enumerated()
        .map(|(index, track)| {
            let body = scene.link_seen_by(index).name.as_str();
            (body, track.topic.as_str())
        })
        .collect();
    let listed = || {
        let each = bodies
            .iter()
            .map(|(body, topic)| format!("{body} on {topic}"));
        each.collect::<Vec<_>>().join(", ")
    };
    if scene.timing == Timing::Edited {
        bail!(
            "the scene's stamps are edited, with a topic per flight: expected --topic {name}=TOPIC, such \
             as the topic of one of {} with /1, /2, …",
            listed()
        );
    }
    let mut found = bodies.iter().filter(|(body, _)| same(body, name));
    match (found.next(), found.next(), bodies.as_slice()) {
        (Some((_, topic)), None, _) => Ok((*topic).to_owned()),
        (None, _, [(_, topic)]) if names.len() == 1 => Ok((*topic).to_owned()),
        _ => bail!(
            "which body of the scene is {name:?}? It has {}; expected --topic {name}=TOPIC",
            listed()
        ),
    }
}

/// A name as part of a topic.
fn plain(name: &str) -> String {
    let part = |character: char| match character {
        '.' | '-' | '_' => character,
        character if character.is_alphanumeric() => character,
        _ => '_',
    };
    name.chars().map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_are_named_after_bodies_or_given() {
        let given = |given: &[&str]| -> Vec<String> {
            given.iter().map(|given| (*given).to_owned()).collect()
        };
        let of = |names: &[&str], topics_given: &[&str]| {
            let named: Vec<_> = names.iter().map(|name| (*name, Holds::Pose)).collect();
            let found = topics(&named, &given(topics_given), None);
            found.map(|all| all.into_iter().flatten().collect::<Vec<_>>())
        };
        let point = topics(&[("m", Holds::Position)], &[], None).unwrap();
        let point: Vec<String> = point.into_iter().flatten().collect();
        assert_eq!(point, ["/tracker/m/point"]);
        assert_eq!(of(&["my cup"], &[]).unwrap(), ["/tracker/my_cup/pose"]);
        assert_eq!(of(&["a", "b"], &["b=/b", "/a"]).unwrap(), ["/a", "/b"]);
        assert_eq!(of(&["a"], &["/x"]).unwrap(), ["/x"]);
        for (names, given, message) in [
            (&["a", "a"][..], &[][..], "two bodies"),
            (&["a"], &["b=/b"], "the files have a"),
            (&["a"], &["/a", "/b"], "the files have a"),
            (&["a"], &["/a b"], "without spaces"),
        ] {
            let error = of(names, given).unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        }
    }
}
