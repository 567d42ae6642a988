//! Real tosses of a cube: residuals and gravity of the first flight, restitution and friction of the
//! first impact, what would have been predicted, and whole tosses until they rest.

pub mod bounce;
pub mod contacts;
mod flights;
mod impacts;
mod whole;

use anyhow::Result;

use crate::options::Options;
use crate::record::Record;

/// Tosses of a quick run.
const QUICK: usize = 12;

/// Runs it, where the data are there.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let Some((scene, mut tosses)) = enact_tools::tosses::all()? else {
        return Ok(());
    };
    if options.quick {
        tosses.truncate(QUICK);
    }
    flights::run(&scene, &tosses, record)?;
    impacts::run(&tosses, options.quick, record)?;
    whole::run(&tosses, record)
}
