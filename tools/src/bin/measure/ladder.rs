//! The model ladder: what motions predict, and how certain of it they are, as parameters are freed one
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
use self::step::{Against, Held, Step};
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
                "Among suspects",
                [0, 1],
            ),
            (
                "everything",
                "The one thing that is set free of everything",
                "Among everything that could be free",
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
    let (name, title) = (way.name(), way.title());
    let against = |against: Against| move |step: &Step| show::errors_and_failures(step, against);
    let errors = format!("{title}: error to the truth, median (ninth decile)");
    record.table(show::by_kind(
        (name, &errors),
        &kinds,
        against(Against::Truth),
    ));
    let holding =
        format!("{title}: 95 % intervals that hold the truth, as reported; of white noise alone");
    let name_of_intervals = format!("{name}_intervals");
    record.table(show::by_kind(
        (&name_of_intervals, &holding),
        &kinds,
        show::intervals,
    ));
    if way == Way::Later {
        let errors = format!("{title}: error to the samples");
        record.table(show::by_kind(
            ("samples", &errors),
            &kinds,
            against(Against::Samples),
        ));
        figures(&kinds, record);
    }
    record.numbers(name, &kinds)
}

fn figures(kinds: &[Vec<Step>], record: &mut Record) {
    let note = format!(
        "{} throws of a cube with two bounces of each kind, the later half of the last flight held out. Things are freed from left \
         to right and stay free; `auto` stands for itself. Medians over the throws of the rms distance to the truth, bars from \
         quartile to quartile.",
        kinds[0][0].takes
    );
    let title = "Too little free is biased, too much free is uncertain";
    let of = (&Rung::ALL[..], kinds);
    record.figure(show::errors(
        ("ladder_error", title, note),
        of,
        Against::Truth,
    ));
    let note = "The same throws: share of the 95 % intervals of the tracker's position and orientation, where samples are held \
                out, that hold the truth.";
    let title = "Reported intervals of predictions: a misfit widens them";
    let reported: fn(&Step) -> &Held = |step| &step.truth;
    record.figure(show::coverage(
        ("ladder_coverage", title, note),
        of,
        reported,
    ));
    let title = "Under white noise alone, intervals hold once the culprit is free";
    let stated: fn(&Step) -> &Held = |step| &step.stated;
    record.figure(show::coverage(
        ("ladder_coverage_white", title, note),
        of,
        stated,
    ));
}

/// The ladder on real tosses.
fn tosses(options: &Options, record: &mut Record) -> Result<()> {
    let Some((steps, all)) = real::steps(options)? else {
        return Ok(());
    };
    let takes = steps[0].takes;
    record.table(show::tosses(&steps));
    let are_everywhere = show::have_motions_everywhere(&steps);
    let everywhere = steps.iter().map(|step| step.of_takes(&are_everywhere));
    let everywhere: Vec<Step> = everywhere
        .map(|step| step.named("those with a motion on every rung"))
        .collect();
    let kinds = [steps, everywhere];
    let note = format!(
        "{takes} of {all} real tosses. Things are freed from left to right and stay free; `auto` stands for itself. Medians of the \
         rms distance to the samples over the tosses that have a motion, bars from quartile to quartile."
    );
    let of = (&real::RUNGS[..], &kinds[..]);
    let title = "What real tosses predict of the flight after the impact";
    record.figure(show::errors(
        ("ladder_tosses", title, note),
        of,
        Against::Samples,
    ));
    let title = "Reported intervals of what real tosses predict";
    let note = "The same tosses: share of the 95 % intervals of position and orientation, the white noise seen included, that hold \
                the sample.";
    let held: fn(&Step) -> &Held = |step| &step.samples;
    let of = (&real::RUNGS[..], &kinds[..1]);
    record.figure(show::coverage(
        ("ladder_tosses_coverage", title, note),
        of,
        held,
    ));
    record.numbers("tosses", &kinds[0])
}
