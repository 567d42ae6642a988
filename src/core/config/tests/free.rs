//! What may be free: names, units, bounds, and refusals of what no performance tells.

use super::refusals::refused;
use super::{PENCIL, error_of};
use crate::config::scene_from_toml;
use crate::config::unit::Unit;
use crate::motion::{FreeParameter, LinkIndex, Quantity, Scene, TrackIndex};

const LINK: LinkIndex = LinkIndex(0);
const TRACK: TrackIndex = TrackIndex(0);

/// The pencil with physical stamps, other bodies, and other free quantities.
fn text(bodies: &str, events: &str, free: &str) -> String {
    let base = &PENCIL[..PENCIL.find("[[free]]").unwrap()];
    base.replace("stamps = \"tempo\"", "stamps = \"physical\"")
        .replacen("[[surface]]", &format!("{bodies}[[surface]]"), 1)
        .replacen(
            "[[event]]\nname = \"landing\"",
            &format!("{events}[[event]]\nname = \"landing\""),
            1,
        )
        + free
}

fn freeing(free: &str) -> Scene {
    let text = text("", "", &format!("[[free]]\nquantity = {free}\n"));
    scene_from_toml(&text).unwrap_or_else(|error| panic!("{free}: {error}"))
}

fn refusal(bodies: &str, events: &str, quantities: &[&str]) -> String {
    let free = quantities
        .iter()
        .map(|q| format!("[[free]]\nquantity = {q}\n"));
    error_of(&text(bodies, events, &free.collect::<String>())).message
}

const BALL: &str = "[[body]]\nname = \"ball\"\nmass_g = 9\n\
                    shape = { kind = \"sphere\", radius_mm = 20 }\n";

const MEETING: &str = "[[event]]\nname = \"hit\"\nkind = \"collision\"\nbody = \"pencil\"\n\
                       feature = \"eraser\"\nother = \"ball\"\nother_feature = \"ball\"\n\
                       restitution = 0.5\n";

#[test]
fn every_quantity_has_a_name_a_unit_and_limits() {
    let (link, track) = (LINK, TRACK);
    let free = f64::INFINITY;
    for (name, quantity, si, [lower, upper]) in [
        (
            "pencil.force.x",
            Quantity::Force { link, axis: 0 },
            1.0,
            [-free, free],
        ),
        (
            "pencil.drag.linear",
            Quantity::LinearDrag { link },
            1.0,
            [0.0, free],
        ),
        (
            "pencil.drag.quadratic",
            Quantity::QuadraticDrag { link },
            1.0,
            [0.0, free],
        ),
        (
            "pencil.moment.x",
            Quantity::Moment { link, axis: 0 },
            1.0,
            [0.01, free],
        ),
        (
            "pencil.moment.z",
            Quantity::Moment { link, axis: 2 },
            1.0,
            [0.01, free],
        ),
        (
            "pencil.centre.y",
            Quantity::Centre { link, axis: 1 },
            1e-3,
            [-free, free],
        ),
        (
            "pencil.tracker.x",
            Quantity::TrackerPosition { track, axis: 0 },
            1e-3,
            [-free, free],
        ),
        (
            "pencil.tracker.turn.z",
            Quantity::TrackerOrientation { track, axis: 2 },
            1f64.to_radians(),
            [-free, free],
        ),
        (
            "pencil.clock.rate",
            Quantity::ClockRate { track },
            0.01,
            [-0.99, free],
        ),
        (
            "table.height",
            Quantity::SurfaceHeight { surface: 0 },
            1e-3,
            [-free, free],
        ),
        (
            "table.tilt.1",
            Quantity::SurfaceTilt {
                surface: 0,
                tangent: 1,
            },
            1f64.to_radians(),
            [-free, free],
        ),
    ] {
        let scene = freeing(&format!("{name:?}"));
        let of_scene = scene.value_of(quantity);
        let expected = FreeParameter {
            name: name.to_owned(),
            quantity,
            initial: of_scene,
            lower,
            upper,
            prior_sd: None,
        };
        assert_eq!(scene.parameters, [expected], "{name}");
        assert_eq!(scene.name_of_quantity(quantity), name);
        let all = format!("{name:?}\ninitial = 1.5\nlower = 0.25\nupper = 4\nprior_sd = 2");
        let free = &freeing(&all).parameters[0];
        let found = [free.initial, free.lower, free.upper, free.prior_sd.unwrap()];
        for (found, expected) in found.into_iter().zip([1.5, 0.25, 4.0, 2.0]) {
            assert!((found - expected * si).abs() < 1e-15, "{name} {found}");
        }
    }
}

#[test]
fn offsets_and_masses_need_another() {
    let bodies = |quantities: &str| text(BALL, MEETING, quantities);
    let scene = scene_from_toml(&bodies(
        "[[free]]\nquantity = \"ball.mass\"\n[[free]]\nquantity = \"ball.clock.offset\"\nlower = -5\n",
    ))
    .unwrap();
    let quantities: Vec<Quantity> = scene.parameters.iter().map(|p| p.quantity).collect();
    let (link, track) = (LinkIndex(1), TrackIndex(1));
    assert_eq!(
        quantities,
        [Quantity::Mass { link }, Quantity::ClockOffset { track }]
    );
    assert_eq!(
        (scene.parameters[0].initial, scene.parameters[1].lower),
        (1.0, -0.005)
    );
    // Before they meet, nothing tells a mass.
    assert_eq!(scene.first_events(2).parameters.len(), 1);
    assert_eq!(scene.first_events(3).parameters.len(), 2);

    let together = |name: &str| {
        let [a, b] = ["pencil", "ball"].map(|body| format!("\"{body}.{name}\""));
        refusal(BALL, MEETING, &[&a, &b])
    };
    assert_eq!(
        together("mass"),
        "only a combination of pencil.mass, ball.mass is determined: masses of bodies that meet count only \
         relative to one another; expected one of them fixed, or with a prior_sd"
    );
    assert!(together("clock.offset").contains("only relative to one another"));
    // A prior holds one of them.
    let held = "[[free]]\nquantity = \"pencil.mass\"\nprior_sd = 0.1\n[[free]]\nquantity = \"ball.mass\"\n";
    assert_eq!(scene_from_toml(&bodies(held)).unwrap().parameters.len(), 2);
}

#[test]
fn what_no_performance_tells_is_refused_with_the_reason() {
    for (bodies, quantity, why) in [
        ("", "pencil.mass", "cancels out of its motion"),
        ("", "pencil.clock.offset", "the only tracker's clock"),
        (
            BALL,
            "ball.moment.x",
            "only ratios of moments show in flight",
        ),
        (
            BALL,
            "ball.tracker.turn.y",
            "turns alike whichever way its tracker is mounted",
        ),
        (
            "[[surface]]\nname = \"wall\"\npoint_mm = [0, 0, 0]\nnormal = [1, 0, 0]\n",
            "wall.height",
            "nothing touches this surface",
        ),
        (
            "",
            "pencil.moment.y",
            "equals pencil.moment.x and moves with it",
        ),
    ] {
        let message = refusal(bodies, "", &[&format!("{quantity:?}")]);
        assert!(
            message.starts_with(quantity) && message.contains(why),
            "{message}"
        );
    }
    let tempo = PENCIL.replace("bounce.restitution", "pencil.clock.rate");
    refused(
        &tempo,
        57,
        "\"pencil.clock.rate\"",
        "pencil.clock.rate cannot be free: clocks are told only where stamps are physical times",
    );
}

#[test]
fn what_counts_only_together_is_refused() {
    for (bodies, quantities, why) in [
        (
            "",
            &["\"gravity.z\"", "\"pencil.force.z\""][..],
            "are one pull",
        ),
        (
            "",
            &["\"gravity.z\"", "\"pencil.clock.rate\""],
            "how fast time runs",
        ),
        (
            BALL,
            &["\"ball.centre.x\"", "\"ball.tracker.x\""],
            "only one offset between them",
        ),
    ] {
        let message = refusal(bodies, "", quantities);
        assert!(message.starts_with("only a combination of "), "{message}");
        assert!(message.contains(why), "{message}");
    }
    // The rate is told by gravity, and the centre by what touches.
    freeing("\"pencil.clock.rate\"");
    freeing("\"pencil.centre.x\"\n[[free]]\nquantity = \"pencil.tracker.x\"");
    let rod = BALL.replace(
        "kind = \"sphere\", radius_mm",
        "kind = \"capsule\", length_mm = 90, radius_mm",
    );
    let message = refusal(&rod, "", &["\"ball.moment.x\"", "\"ball.moment.z\""]);
    assert!(
        message.contains("only the ratios of its moments"),
        "{message}"
    );
}

#[test]
fn unknown_names_are_answered_with_the_nearest() {
    let message = refusal("", "", &["\"pencil.drag.liner\""]);
    assert!(
        message.starts_with(
            "unknown quantity \"pencil.drag.liner\", did you mean pencil.drag.linear? Expected one of gravity.x, "
        ),
        "{message}"
    );
    for name in ["pencil.tracker.turn.x", "table.tilt.0", "pencil.moment.z"] {
        assert!(message.contains(name), "{name}: {message}");
    }
    // What is not told is not offered.
    for name in ["pencil.mass", "clock.offset", "moment.y"] {
        assert!(!message.contains(name), "{name}: {message}");
    }
}

#[test]
fn a_surface_may_tilt_within_a_cone() {
    let scene = freeing("\"table.tilt\"\ncone_deg = 3");
    let tilt = |tangent| Quantity::SurfaceTilt {
        surface: 0,
        tangent,
    };
    let quantities: Vec<Quantity> = scene.parameters.iter().map(|p| p.quantity).collect();
    assert_eq!(quantities, [tilt(0), tilt(1)]);
    assert_eq!(scene.cones[0].parameters, [0, 1]);
    assert!((scene.cones[0].limit - 3f64.to_radians()).abs() < 1e-15);
    let message = refusal("", "", &["\"table.height\"\ncone_deg = 3"]);
    assert!(
        message.contains("expected `<event>.tilt` or `<surface>.tilt`"),
        "{message}"
    );
}

#[test]
fn known_force_and_drag_are_the_bodies() {
    let known = "mass_g = 6.0\nforce_m_s2 = [0, 0.5, 0]\ndrag_linear_per_s = 0.2\ndrag_quadratic_per_m = 0.1";
    let free = "[[free]]\nquantity = \"pencil.drag.quadratic\"\n";
    let scene = text("", "", free).replace("mass_g = 6.0", known);
    let scene = scene_from_toml(&scene).unwrap();
    let body = &scene.links[LINK].body;
    assert_eq!(body.force_m_s2().y, 0.5);
    assert_eq!(
        (body.drag().linear_per_s, body.drag().quadratic_per_m),
        (0.2, 0.1)
    );
    assert_eq!(scene.parameters[0].initial, 0.1);
    for (key, number) in [
        ("drag_linear_per_s", "-0.1"),
        ("drag_quadratic_per_m", "inf"),
    ] {
        let wrong = format!("mass_g = 6.0\n{key} = {number}");
        let message = error_of(&text("", "", "").replace("mass_g = 6.0", &wrong)).message;
        assert!(
            message.starts_with(&format!("{key} is {number}")),
            "{message}"
        );
    }
}

#[test]
fn a_ball_has_a_lift_and_what_is_no_ball_has_none() {
    let ball = |keys: &str, free: &str| {
        let shape =
            "shape = { kind = \"cylinder\", length_mm = 190.0, radius_mm = 3.75 }\nmass_g = 6.0";
        let ball = format!("shape = {{ kind = \"sphere\", radius_mm = 95 }}\nmass_g = 6.0\n{keys}");
        let text = text("", "", free).replace(shape, &ball);
        assert!(text.contains("sphere"));
        text
    };
    let free = "[[free]]\nquantity = \"pencil.lift\"\n";
    let scene = scene_from_toml(&ball("lift = -0.006", free)).unwrap();
    assert_eq!(scene.links[LINK].body.lift(), -0.006);
    let last = scene.parameters.last().unwrap();
    assert_eq!(last.quantity, Quantity::Lift { link: LINK });
    assert_eq!((last.initial, last.lower), (-0.006, f64::NEG_INFINITY));
    let other = scene.with_values(&[(Quantity::Lift { link: LINK }, 0.02)]);
    assert_eq!(other.unwrap().links[LINK].body.lift(), 0.02);
    let nan = error_of(&ball("lift = nan", "")).message;
    assert!(nan.starts_with("lift is NaN"), "{nan}");
    let rod = text("", "", "").replace("mass_g = 6.0", "mass_g = 6.0\nlift = 0.01");
    let said = error_of(&rod).message;
    assert!(said.starts_with("only a ball is lifted"), "{said}");
    let said = error_of(&text("", "", free)).message;
    assert!(
        said.contains("pencil.lift cannot be free: only a ball"),
        "{said}"
    );
}

#[test]
fn moments_begin_as_those_of_a_body() {
    let message = refusal("", "", &["\"pencil.moment.z\"\ninitial = 1e4"]);
    assert!(
        message.starts_with("at the initial values moments "),
        "{message}"
    );
}

/// The rows of the table of free quantities: names and unit.
fn documented() -> Vec<(Vec<&'static str>, &'static str)> {
    let docs = include_str!("../mod.rs");
    let table = docs.split("| quantity | what it is |").nth(1).unwrap();
    let rows = table
        .lines()
        .skip(2)
        .take_while(|line| line.starts_with("//! | `"));
    let row = |line: &'static str| {
        let cells: Vec<&str> = line.split('|').collect();
        let names = cells[1].split('`').skip(1).step_by(2).collect();
        (names, cells[3].trim())
    };
    rows.map(row).collect()
}

/// Joined bodies.
const CHAIN: &str = include_str!("../../../../config/chain.toml");

#[test]
fn documented_quantities_are_those_that_there_are() {
    let brick = "[[body]]\nname = \"brick\"\nmass_g = 9\n\
                 shape = { kind = \"cuboid\", size_mm = [10, 20, 30] }\nrestitution = 0.5\n";
    let hit = "[[event]]\nname = \"fall\"\nkind = \"collision\"\nbody = \"brick\"\n\
               feature = \"corner -x -y -z\"\nsurface = \"table\"\n";
    let mut named = Vec::new();
    for (names, unit) in documented() {
        for name in names {
            let name = name
                .replace("<event>", "bounce")
                .replace("<surface>", "table");
            let mut name = name.replace("<body>", "brick");
            let mut free =
                format!("[[free]]\nquantity = {name:?}\ninitial = 0.9\nlower = 0.25\nupper = 1\n");
            if let Some(of) = name.strip_suffix("tangential_restitution") {
                // Of what has friction.
                free = format!("[[free]]\nquantity = \"{of}friction\"\n{free}");
            }
            let meets = format!(
                "{hit}{}",
                MEETING
                    .replace("ball", "brick")
                    .replace("other_feature = \"brick\"\n", "")
            );
            let scene = match name.strip_prefix("<joint>") {
                Some(end) => {
                    let free = free.replace("<joint>", "joint 2");
                    name = format!("joint 2{end}");
                    scene_from_toml(&(CHAIN.to_owned() + &free))
                }
                // Only a ball is lifted.
                None if name.ends_with(".lift") => {
                    scene_from_toml(&text(&BALL.replace("ball", "brick"), "", &free))
                }
                None => scene_from_toml(&text(brick, &meets, &free)),
            };
            let scene = scene.unwrap_or_else(|error| panic!("{name}: {error}"));
            let last = scene.parameters.last().unwrap();
            assert_eq!(last.name, name);
            let of = Unit::of(last.quantity).name.trim();
            assert_eq!(if of.is_empty() { "none" } else { of }, unit, "{name}");
            named.push(name);
        }
    }
    // Each kind of quantity is there.
    for scene in [text(brick, hit, ""), CHAIN.to_owned()] {
        let scene = scene_from_toml(&scene).unwrap();
        for quantity in scene.quantities() {
            let name = scene.name_of_quantity(quantity);
            let name = ["pencil.", "rod 1.", "rod 2.", "rod 3."]
                .into_iter()
                .fold(name, |name, body| name.replace(body, "brick."))
                .replace("joint 3.", "joint 2.")
                .replace("fall.", "bounce.");
            assert!(named.contains(&name), "{name}");
        }
    }
}
