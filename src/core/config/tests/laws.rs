//! Restitution and friction: of a body, shared by its impacts, or of one event.

use super::refusals::refused;
use super::{PENCIL, with};
use crate::config::scene_from_toml;
use crate::motion::{ContactLaw, ContactLawIndex, Quantity, Scene};

/// A second bounce, before the landing.
const AGAIN: &str = "[[event]]\nname = \"again\"\nkind = \"collision\"\nbody = \"pencil\"\n\
                     feature = \"eraser\"\nsurface = \"table\"\n";

/// The scene with a body's law, its bounce without one, and another bounce with `own`.
fn shared(of_body: &str, own: &str) -> String {
    with("mass_g = 6.0", &format!("mass_g = 6.0\n{of_body}"))
        .replace("restitution = 0.6\n\n", &format!("\n{AGAIN}{own}\n"))
        .replace("bounce.restitution", "pencil.restitution")
}

fn laws_of(scene: &Scene) -> Vec<&ContactLaw> {
    let collisions = scene.events.iter().filter_map(|e| e.kind.collision());
    collisions.map(|c| scene.law_of(c)).collect()
}

#[test]
fn impacts_of_a_body_share_its_law() {
    let text = shared(
        "restitution = 0.7\nfriction = 0.2\nrestitution_sd = 0.1\nfriction_sd = 0.05",
        "",
    );
    let scene = scene_from_toml(&text).unwrap();
    let law = ContactLaw {
        friction: 0.2,
        restitution_sd: 0.1,
        friction_sd: 0.05,
        ..ContactLaw::frictionless("pencil", 0.7)
    };
    assert_eq!(laws_of(&scene), [&law, &law]);
    assert_eq!(scene.contact_laws.len(), 1);
    let free = &scene.parameters[1];
    let law = ContactLawIndex(0);
    assert_eq!(free.quantity, Quantity::Restitution { law });
    assert_eq!((free.initial, free.lower, free.upper), (0.7, 0.0, 1.0));
    // Before the first bounce nothing tells it, after it something does.
    let names = |count: usize| {
        let part = scene.first_events(count);
        let names = part.parameters.iter().map(|free| free.name.clone());
        names.collect::<Vec<_>>()
    };
    assert_eq!(names(1), ["gravity.z"]);
    assert_eq!(names(2)[..2], ["gravity.z", "pencil.restitution"]);
}

#[test]
fn an_event_may_have_a_law_of_its_own() {
    let text = shared("restitution = 0.7", "restitution = 0.4\nfriction = 0.1\n");
    let scene = scene_from_toml(&text).unwrap();
    let own = ContactLaw {
        friction: 0.1,
        ..ContactLaw::frictionless("again", 0.4)
    };
    let body = ContactLaw::frictionless("pencil", 0.7);
    assert_eq!(laws_of(&scene), [&body, &own]);
    let freed = text.replace("pencil.restitution", "again.friction");
    let scene = scene_from_toml(&freed).unwrap();
    let law = ContactLawIndex(1);
    assert_eq!(scene.parameters[1].quantity, Quantity::Friction { law });
    assert_eq!(scene.parameters[1].initial, 0.1);
}

#[test]
fn a_bumper_is_one_event_that_says_so() {
    let own = |own: &str| shared("restitution = 0.7", own);
    let scene = scene_from_toml(&own("restitution = 1.4\nbumper = true\n")).unwrap();
    let bumper = ContactLaw {
        is_bumper: true,
        ..ContactLaw::frictionless("again", 1.4)
    };
    let body = ContactLaw::frictionless("pencil", 0.7);
    assert_eq!(laws_of(&scene), [&body, &bumper]);
    let limits = |law| scene.limits_of(Quantity::Restitution { law });
    let both = [0, 1].map(|law| limits(ContactLawIndex(law)));
    assert_eq!(both, [[0.0, 1.0], [0.0, 10.0]]);
    let freed = own("restitution = 1.4\nbumper = true\n")
        + "\n[[free]]\nquantity = \"again.restitution\"\n";
    let scene = scene_from_toml(&(freed.clone() + "upper = 2\n")).unwrap();
    let last = scene.parameters.last().unwrap();
    assert_eq!((last.initial, last.lower, last.upper), (1.4, 0.0, 2.0));
    assert!(scene_from_toml(&(freed.clone() + "upper = 11\n")).is_err());
    assert!(scene_from_toml(&freed.replace("bumper = true", "bumper = false")).is_err());
    for (own_keys, at, said) in [
        ("restitution = 1.4\n", "1.4", "say bumper = true beside"),
        (
            "restitution = 1.4\nbumper = false\n",
            "1.4",
            "say bumper = true beside",
        ),
        (
            "restitution = 14\nbumper = true\n",
            "14",
            "expected 0 to 10",
        ),
        ("bumper = true\n", "true", "a bumper without a restitution"),
    ] {
        refused(&own(own_keys), 46, at, said);
    }
    refused(
        &shared("restitution = 1.4", ""),
        15,
        "1.4",
        "say bumper = true beside",
    );
}

#[test]
fn repeated_collisions_have_one_law_between_them() {
    let counted = PENCIL
        .replace("restitution = 0.6", "restitution = 0.6\ncount = [2, 4]")
        .replace("bounce.tilt.1\"\nlower = -6\nupper = 6", "gravity.x\"");
    let scene = scene_from_toml(&counted).unwrap().with_marks(6);
    let law = ContactLaw::frictionless("bounce", 0.6);
    assert_eq!(laws_of(&scene), [&law; 4]);
    let names: Vec<&str> = scene.parameters.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["gravity.z", "bounce.restitution", "gravity.x"]);
}

#[test]
fn what_sticks_may_spring_back() {
    let of_body = "restitution = 0.7\nfriction = 0.2\ntangential_restitution = 0.4";
    let own = "restitution = 0.5\nfriction = 0.3\ntangential_restitution = 0.9\n";
    let scene = scene_from_toml(&shared(of_body, own)).unwrap();
    let laws = laws_of(&scene);
    let back = laws.iter().map(|law| law.tangential_restitution);
    assert_eq!(back.collect::<Vec<_>>(), [0.4, 0.9]);
    let free = "\n[[free]]\nquantity = \"again.tangential_restitution\"\n";
    let freed = scene_from_toml(&(shared(of_body, own) + free)).unwrap();
    let last = freed.parameters.last().unwrap();
    let law = ContactLawIndex(1);
    assert_eq!(last.quantity, Quantity::TangentialRestitution { law });
    assert_eq!((last.initial, last.lower, last.upper), (0.9, 0.0, 1.0));
    let with = freed.with_values(&[(last.quantity, 0.2)]).unwrap();
    assert_eq!(with.contact_laws[law].tangential_restitution, 0.2);
    for (keys, line, at, said) in [
        (
            "restitution = 0.1\nfriction = 0.1\n",
            48,
            "0.1",
            "\"pencil\" has tangential restitution, expected both",
        ),
        (
            "tangential_restitution = 0.6\n",
            48,
            "0.6",
            "a tangential restitution of its own but no restitution",
        ),
        (
            "restitution = 0.1\nfriction = 0.1\ntangential_restitution = 1.6\n",
            50,
            "1.6",
            "expected 0 to 1",
        ),
    ] {
        refused(&shared(of_body, keys), line, at, said);
    }
    let alone = "restitution = 0.7\ntangential_restitution = 0.4";
    refused(
        &shared(alone, ""),
        16,
        "0.4",
        "without friction, expected a friction beside it",
    );
    let zero = "restitution = 0.7\nfriction = 0\ntangential_restitution = 0.4";
    let error = scene_from_toml(&shared(zero, "")).unwrap_err().to_string();
    assert!(
        error.contains("tangential restitution is for one contact"),
        "{error}"
    );
    let none = shared("restitution = 0.7", "") + &free.replace("again", "pencil");
    let error = scene_from_toml(&none).unwrap_err().to_string();
    assert!(error.contains("without friction nothing sticks"), "{error}");
}

#[test]
fn halves_of_laws_are_refused() {
    let both = "restitution = 0.7\nfriction = 0.2";
    refused(
        &shared("friction = 0.2", ""),
        15,
        "0.2",
        "the body has a friction and no restitution, expected both or neither",
    );
    refused(
        &shared(both, "friction = 0.1\n"),
        47,
        "0.1",
        "a friction of its own but no restitution",
    );
    refused(
        &shared(both, "restitution = 0.1\n"),
        47,
        "0.1",
        "no friction, and \"pencil\" has friction, expected both here or neither",
    );
    refused(
        &shared(both, "restitution = 0.1\nfriction = 0\n").replace("\"again\"", "\"pencil\""),
        42,
        "\"pencil\"",
        "so has the body of this name",
    );
    let meeting = "[[body]]\nname = \"box\"\nmass_kg = 1\nrestitution = 0.3\n\
                   shape = { kind = \"sphere\", radius_mm = 30 }\n\n[[surface]]";
    let two = shared(both, "")
        .replacen("[[surface]]", meeting, 1)
        .replace(
            "feature = \"eraser\"\nsurface = \"table\"",
            "other = \"box\"",
        );
    refused(
        &two,
        47,
        "[[event]]",
        "both bodies have a restitution (\"box\" 0.3), expected the event's own",
    );
}
