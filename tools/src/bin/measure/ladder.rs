//! The model ladder: what motions foretell, and how certain of it they are, as parameters are freed one
//! after another; and two criteria of what to free.

mod criteria;
mod predict;
mod real;
mod rungs;
mod show;
mod split;
mod step;
mod throws;

use anyhow::Result;

use self::rungs::Rung;
use self::step::{Against, Step};
use self::throws::Way;
use crate::options::Options;
use crate::record::Record;

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    for way in Way::ALL {
        if options.wants(way.name()) {
            throws(way, options, record)?;
        }
    }
    if options.wants("real") {
        tosses(options, record)?;
    }
    if options.wants("criteria") {
        let compared = criteria::compare(options);
        for (name, title, what, two) in [
            (
                "criteria",
                "What is set free of the suspects",
                "Of the suspects",
                [0, 1],
            ),
            (
                "everything",
                "The one thing that is set free of everything",
                "Of everything",
                [2, 3],
            ),
        ] {
            record.table(criteria::table((name, title), &compared, two));
            record.say(criteria::verdict(what, &compared, two));
        }
        record.numbers("criteria", &compared)?;
    }
    Ok(())
}

/// The ladder on throws.
fn throws(way: Way, options: &Options, record: &mut Record) -> Result<()> {
    let kinds = throws::steps(way, options);
    let title = way.title();
    let against_truth = |step: &Step| show::cell(step, Against::Truth);
    record.table(show::by_kind((way.name(), title), &kinds, against_truth));
    if way == Way::Later {
        let title = "The same against the samples that were held out";
        let against_samples = |step: &Step| show::cell(step, Against::Samples);
        record.table(show::by_kind(("samples", title), &kinds, against_samples));
        let title = "Components of the poses that have an interval";
        record.table(show::by_kind(
            ("determined", title),
            &kinds,
            show::determined,
        ));
    }
    if way != Way::Middle {
        let note = format!(
            "{title}: {} throws of a cube with one or two bounces. Things are freed from left to right and stay free; `auto` stands \
             for itself. Medians over the throws of the rms distance to the truth, bars from quartile to quartile.",
            kinds[0][0].takes
        );
        let name = format!("ladder_{}", way.name());
        let title = match way {
            Way::Hand => "With a wandering hand, what is too much shows earlier",
            _ => "Too little free is biased, too much free is uncertain",
        };
        let of = (&Rung::ALL[..], &kinds[..], Against::Truth);
        record.figure(show::errors((&name, title, note.clone()), of));
        let name = format!("{name}_coverage");
        let title = "Intervals of what is foretold hold once the culprit is free";
        let note = "The same throws: share of the 95 % intervals of the tracker's position and orientation that hold the truth.";
        record.figure(show::coverage((&name, title, note.to_owned()), of));
    }
    record.numbers(way.name(), &kinds)
}

/// The ladder on real tosses.
fn tosses(options: &Options, record: &mut Record) -> Result<()> {
    let Some((steps, all)) = real::steps(options)? else {
        return Ok(());
    };
    let takes = steps[0].takes;
    let kinds = [steps];
    record.table(show::tosses(&kinds[0]));
    let note = format!(
        "{takes} of {all} real tosses. Things are freed from left to right and stay free; `auto` stands for itself. Medians of the rms \
         distance to the samples, bars from quartile to quartile."
    );
    let of = (&real::RUNGS[..], &kinds[..], Against::Samples);
    let title = "What real tosses foretell of the flight after the impact";
    record.figure(show::errors(("ladder_tosses", title, note), of));
    let title = "Intervals of what real tosses foretell";
    let note = "The same tosses: share of the 95 % intervals of position and orientation, the white noise seen included, that hold the sample.";
    record.figure(show::coverage(
        ("ladder_tosses_coverage", title, note.to_owned()),
        of,
    ));
    record.numbers("tosses", &kinds)
}
