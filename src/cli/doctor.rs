//! `doctor`: checks what a capture needs.

use super::arguments::{DoctorArguments, Format};
use super::exit::Exit;
use super::output;
use crate::report::plain;
use crate::service::{DoctorJob, Health, doctor};

pub(super) fn run(arguments: DoctorArguments) -> anyhow::Result<Exit> {
    let findings = doctor(&DoctorJob {
        scene: arguments.scene,
        iceoryx2: arguments.iceoryx2,
    })?;
    let mut worst = Health::Well;
    for finding in &findings {
        worst = worst.max(finding.health);
        match arguments.format {
            Format::Ndjson => output::print_json("enact.finding/1", finding)?,
            Format::Text => {
                let mark = match finding.health {
                    Health::Well => "ok  ",
                    Health::Poor => "poor",
                    Health::Bad => "BAD ",
                };
                let (subject, text) = (plain(&finding.subject), plain(&finding.text));
                output::print(&format!("{mark}  {subject}: {text}\n"))?;
            }
        }
    }
    Ok(match worst {
        Health::Well => Exit::Done,
        Health::Poor => Exit::NotWhole,
        Health::Bad => Exit::Error,
    })
}
