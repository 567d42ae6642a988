//! `scene`: makes scenes, and says what they mean.

use super::arguments::{
    CheckSceneArguments, Format, FromUrdfArguments, LengthUnit, NewSceneArguments, NewStamps,
    SceneCommand,
};
use super::calibrate;
use super::exit::Exit;
use super::output::{self, Account};
use super::process::print_failure;
use crate::config::{BodyCheck, MATERIALS, PRESETS, SceneCheck, scene_reference, scene_schema};
use crate::service::{self, FromUrdfJob, NewSceneJob, NewSceneMade, UrdfImported};

/// A turn by less is rounding \[degrees\].
const SMALL_TURN_DEG: f64 = 1e-4;

/// So many names of features are said.
const FEATURES_SAID: usize = 6;

pub(super) fn run(command: SceneCommand) -> anyhow::Result<Exit> {
    match command {
        SceneCommand::FromUrdf(arguments) => from_urdf(arguments),
        SceneCommand::New(arguments) => new(arguments),
        SceneCommand::Check(arguments) => check(&arguments),
        SceneCommand::Objects => {
            let lines = PRESETS
                .iter()
                .map(|of| format!("{:<8} {}\n         {}\n", of.name, of.what, of.source));
            output::print(&lines.collect::<String>())?;
            Ok(Exit::Done)
        }
        SceneCommand::Materials => {
            let lines = MATERIALS.iter().map(|of| {
                let (coefficient, [least, most]) = of.states();
                let (name, what, source) = (of.name, of.what, of.source);
                let key = coefficient.key();
                format!("{name}  {what}\n  {key} {least} to {most}\n  {source}\n")
            });
            output::print(&lines.collect::<String>())?;
            Ok(Exit::Done)
        }
        SceneCommand::Schema => {
            let text = serde_json::to_string_pretty(&scene_schema())?;
            output::print(&format!("{text}\n"))?;
            Ok(Exit::Done)
        }
        SceneCommand::Reference => {
            output::print(&scene_reference())?;
            Ok(Exit::Done)
        }
        SceneCommand::Calibrated(arguments) => calibrate::scene(arguments),
    }
}

fn new(arguments: NewSceneArguments) -> anyhow::Result<Exit> {
    let said = Account::new(arguments.format, arguments.output.as_deref());
    let job = NewSceneJob {
        object: arguments.object.clone(),
        output: arguments.output,
        unit_m: arguments.unit.map(LengthUnit::metres),
        take_hull: arguments.hull,
        mass_g: arguments.mass_g,
        size_mm: arguments.size_mm,
        material: arguments.material,
        tracker_mm: arguments.tracker_mm,
        bounces: arguments.bounces,
        stamps: match arguments.stamps {
            NewStamps::Tempo => "tempo".into(),
            NewStamps::Physical => "physical".into(),
        },
        lands: arguments.lands,
        command: output::command_line(),
    };
    let made = match service::make_scene(&job) {
        Ok(made) => made,
        Err(error) => {
            print_failure(&arguments.object, &error, said.of_failure())?;
            return Ok(Exit::Error);
        }
    };
    said.print("enact.new_scene/1", &made, |_| text_of_made(&made))?;
    Ok(Exit::Done)
}

fn text_of_made(made: &NewSceneMade) -> String {
    let mut text = format!("{}:\n{}", made.scene, text_of_body(&made.body));
    for note in &made.notes {
        output::push_line(&mut text, format!("  note: {note}"));
    }
    output::push_line(&mut text, format!("  written   {}", made.output));
    text
}

fn check(arguments: &CheckSceneArguments) -> anyhow::Result<Exit> {
    let path = arguments.scene.display().to_string();
    let found = match service::look_at_scene(&arguments.scene) {
        Ok(found) => found,
        Err(error) => {
            print_failure(&path, &error, arguments.format)?;
            return Ok(Exit::Error);
        }
    };
    match arguments.format {
        Format::Ndjson => output::print_json("enact.scene_check/1", &found)?,
        Format::Text => output::print(&text_of_check(&path, &found))?,
    }
    Ok(if found.missing.is_empty() {
        Exit::Done
    } else {
        Exit::NotWhole
    })
}

fn text_of_check(path: &str, found: &SceneCheck) -> String {
    let mut text = String::new();
    output::push_line(
        &mut text,
        format!("{path}: {}, {} stamps", found.scene, found.stamps),
    );
    for body in &found.bodies {
        text += &text_of_body(body);
    }
    let widest = found.topics.iter().map(|of| of.topic.chars().count()).max();
    let widest = widest.unwrap_or(0);
    for (index, of) in found.topics.iter().enumerate() {
        let title = if index == 0 { "expected" } else { "" };
        output::push_line(
            &mut text,
            format!("  {title:<9} {:<widest$}  {}", of.topic, of.carries),
        );
    }
    let mut number = 1;
    for of in &found.events {
        let [least, most] = of.marks;
        let marks = match (least, most) {
            (0, 0) => "no mark".to_owned(),
            (1, 1) => format!("mark {number}"),
            _ => format!("{least} to {most} marks from {number} on"),
        };
        number += least;
        let goals = match of.goals {
            0 => String::new(),
            1 => ", 1 goal".into(),
            count => format!(", {count} goals"),
        };
        output::push_line(
            &mut text,
            format!("  {marks:<9} {}: {}{goals}", of.name, of.means),
        );
    }
    if !found.free.is_empty() {
        output::push_line(&mut text, format!("  free      {}", found.free.join(", ")));
    }
    for open in &found.open {
        output::push_line(&mut text, format!("  open: {open}"));
    }
    for missing in &found.missing {
        output::push_line(&mut text, format!("  missing: {missing}"));
    }
    text
}

fn text_of_body(body: &BodyCheck) -> String {
    let mut text = format!("  body      {}: ", body.name);
    match (body.mass_g, body.moments_kg_m2) {
        (Some(mass_g), Some([a, b, c])) => {
            let [x, y, z] = body.centre_mm.map(|mm| rounded(mm, 1e3));
            text += &format!(
                "{} g, centre of mass at [{x}, {y}, {z}] mm, moments {a:.3e}, {b:.3e}, {c:.3e} kg m²",
                rounded(mass_g, 1e3)
            );
            if body.turn_deg > SMALL_TURN_DEG {
                let [w, x, y, z] = body.orientation_wxyz.map(|q| rounded(q, 1e4));
                text += &format!(
                    " about axes that are turned by {}° ([{w}, {x}, {y}, {z}])",
                    rounded(body.turn_deg, 1e2)
                );
            }
        }
        _ => text += "held",
    }
    text += "\n";
    let names: Vec<&str> = body.features.iter().map(String::as_str).collect();
    let said = match names.get(..FEATURES_SAID) {
        Some(first) if names.len() > FEATURES_SAID => {
            let more = names.len() - FEATURES_SAID;
            format!("{}, and {more} more", first.join(", "))
        }
        _ if names.is_empty() => "none".into(),
        _ => names.join(", "),
    };
    text + &format!("  touches   by {said}\n")
}

/// Rounded to so many parts of one, and zero without a sign.
fn rounded(value: f64, parts: f64) -> f64 {
    (value * parts).round() / parts + 0.0
}

fn from_urdf(arguments: FromUrdfArguments) -> anyhow::Result<Exit> {
    let input = arguments.input.display().to_string();
    let said = Account::new(arguments.format, arguments.output.as_deref());
    let job = FromUrdfJob {
        input: arguments.input,
        output: arguments.output,
        command: output::command_line(),
    };
    let imported = match service::from_urdf(&job) {
        Ok(imported) => imported,
        Err(error) => {
            print_failure(&input, &error, said.of_failure())?;
            return Ok(Exit::Error);
        }
    };
    said.print("enact.scene/1", &imported, |_| text(&imported))?;
    Ok(if imported.lost.is_empty() {
        Exit::Done
    } else {
        Exit::NotWhole
    })
}

fn text(imported: &UrdfImported) -> String {
    let mut text = String::new();
    output::push_line(&mut text, format!("{}: {}", imported.input, imported.scene));
    output::push_notes(&mut text, &imported.lost, &imported.warnings);
    let (bodies, joints) = (imported.bodies, imported.joints);
    output::push_line(&mut text, format!("  bodies {bodies}, joints {joints}"));
    output::push_line(&mut text, format!("  written   {}", imported.output));
    text
}
