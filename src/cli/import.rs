//! `import`: files of other programs become recordings.

use super::arguments::{ImportArguments, Order};
use super::exit::Exit;
use super::inspect::range;
use super::output::{Account, push_line};
use super::process::print_failure;
use super::table::table;
use crate::service::{
    self, ImportJob, Imported, Preset, QuaternionOrder, TableOptions, Turn, length_unit,
};

pub(super) fn run(arguments: ImportArguments) -> anyhow::Result<Exit> {
    let said = Account::new(arguments.format, Some(&arguments.output));
    let job = ImportJob {
        inputs: arguments.inputs,
        output: arguments.output,
        scene: arguments.scene,
        options: TableOptions {
            columns: arguments.columns,
            time_unit: arguments.time_unit,
            length_unit: arguments.length_unit.as_deref().and_then(length_unit),
            rate_hz: arguments.rate,
            quaternion: arguments.quaternion.map(|order| match order {
                Order::Xyzw => QuaternionOrder::Xyzw,
                Order::Wxyz => QuaternionOrder::Wxyz,
            }),
            turn: arguments.rotation.as_deref().and_then(Turn::named),
            angle_unit: arguments.angle_unit,
            preset: arguments.from.as_deref().and_then(Preset::named),
            mark_columns: arguments.mark_column,
        },
        topics: arguments.topic,
        marks: arguments.mark,
        start_s: arguments.start,
        end_s: arguments.end,
    };
    if !arguments.each {
        return one(&job, said);
    }
    let outputs = service::beside_each(&job.inputs, &job.output, "mcap")?;
    let mut exit = Exit::Done;
    for (input, output) in job.inputs.iter().zip(outputs) {
        let each = ImportJob {
            inputs: vec![input.clone()],
            output,
            ..job.clone()
        };
        exit = exit.max(one(&each, said)?);
    }
    Ok(exit)
}

fn one(job: &ImportJob, said: Account) -> anyhow::Result<Exit> {
    let imported = match service::import(job) {
        Ok(imported) => imported,
        Err(error) => {
            let output = job.output.display().to_string();
            print_failure(&output, &error, said.of_failure())?;
            return Ok(Exit::Error);
        }
    };
    said.print("enact.import/1", &imported, |_| text(&imported))?;
    Ok(if imported.lost.is_empty() && imported.against.is_empty() {
        Exit::Done
    } else {
        Exit::NotWhole
    })
}

fn text(imported: &Imported) -> String {
    let mut text = String::new();
    for input in &imported.inputs {
        push_line(&mut text, format!("{}: {}", input.file, input.kind));
    }
    let lines = [
        ("lost", &imported.lost),
        ("against", &imported.against),
        ("note", &imported.warnings),
    ];
    for (what, all) in lines {
        for line in all {
            push_line(&mut text, format!("  {what}: {line}"));
        }
    }
    let rows: Vec<Vec<String>> = imported
        .bodies
        .iter()
        .map(|body| {
            let rate = body.rate_hz.map(|rate| format!("{rate:.1} Hz"));
            vec![
                body.name.clone(),
                body.topic.clone(),
                body.poses.to_string(),
                body.absent.to_string(),
                rate.unwrap_or_else(|| "-".into()),
                format!("{:.3} s", body.duration_s),
                range(body.extent_m[0], 3),
                range(body.extent_m[1], 3),
                range(body.extent_m[2], 3),
            ]
        })
        .collect();
    if !rows.is_empty() {
        let head = [
            "body", "topic", "poses", "without", "rate", "duration", "x [m]", "y [m]", "z [m]",
        ];
        text.push('\n');
        text += &table("  ", &head, &rows);
        text.push('\n');
    }
    if let Some(copied) = imported.copied {
        text += &format!("  copied    {copied} messages\n");
    }
    if imported.left_out > 0 {
        text += &format!(
            "  left out  {} before --start or after --end\n",
            imported.left_out
        );
    }
    if imported.marks > 0 {
        text += &format!("  marks     {}\n", imported.marks);
    }
    if let Some(scene) = &imported.scene {
        push_line(&mut text, format!("  scene     {scene}"));
    }
    push_line(&mut text, format!("  written   {}", imported.output));
    text
}
