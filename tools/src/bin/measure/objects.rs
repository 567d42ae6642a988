//! Real tosses of household objects: whether first flight and first impact of each are explained, or
//! what is said instead.

mod answer;
mod facts;
mod judge;
mod rows;
mod show;
mod told;
mod with;

use anyhow::{Context, Result};
use enact_tools::objects::read::{self, ObjectToss};
use enact_tools::objects::scene::{self, Trust};
use enact_tools::objects::solid::{Solid, solids};
use enact_tools::objects::trust::{known, trust};
use rayon::prelude::*;

use crate::options::Options;
use crate::record::Record;
use show::show;
use told::Told;
use with::With;

/// Every so many tosses in a quick run.
const QUICK: usize = 8;

/// Runs it, where the data are there.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let (Some(folder), Some(tosses)) = (read::folder(), read::all()?) else {
        return Ok(());
    };
    let shapes: Result<Vec<[Solid; 2]>> = tosses
        .iter()
        .map(|toss| solids(&folder, &toss.object))
        .collect();
    let shapes = shapes?;
    let unit = Trust {
        position_mm: 1.0,
        orientation_deg: 1.0,
        table_mm: 1.0,
    };
    let gravity_m_s2 = scene::flight(&shapes[0][0], &unit, false)?.gravity_m_s2;
    let trust = trust(&known(&tosses, &shapes), &gravity_m_s2)
        .context("no flights to choose weights on")?;
    let wanted: Vec<(&ObjectToss, &[Solid; 2])> = tosses
        .iter()
        .zip(&shapes)
        .step_by(options.either(QUICK, 1))
        .filter(|(toss, _)| options.wants(&toss.name))
        .collect();
    // No times are measured.
    let told: Vec<Told> = wanted
        .par_iter()
        .map(|(toss, shapes)| Told::new(toss, shapes, (&trust, &gravity_m_s2)))
        .collect::<Result<_>>()?;
    let with = With {
        trust: &trust,
        gravity_m_s2: &gravity_m_s2,
    };
    show(&told, &with, record)
}
