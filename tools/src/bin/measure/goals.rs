//! Goals of every kind that a motion near the performed one meets: whether they are met, by a motion that
//! is called physical, and how near the truth that is.

mod asked;

use anyhow::Result;

use crate::options::Options;
use crate::record::Record;
use crate::statistics::median;
use crate::table::{Table, number, percent};
use enact_tools::goals::{Quantity, Set};
use enact_tools::perform::Acting;

use self::asked::{Asked, What, asked};

/// Standard deviation of a wish, as a share of how far the true motion is from what is wished.
const SD: f64 = 0.3;

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let ways = [
        ("acted slowly", "tempo", Acting::default()),
        ("physical stamps", "physical", Acting::timing_known()),
    ];
    let sets = |quantity: Quantity| {
        quantity
            .sets()
            .iter()
            .map(move |set| (quantity, *set, None))
    };
    let hard: Vec<What> = Quantity::ALL.into_iter().flat_map(sets).collect();
    let mut missed = Table::new(
        "missed",
        "Not met, or not by a motion that obeys physics",
        &[
            "stamps",
            "what",
            "set",
            "seed",
            "met",
            "how the solver ended",
            "iterations",
        ],
    );
    for (way, name, acting) in ways {
        let mut table = Table::new(
            name,
            way,
            &[
                "what",
                "set",
                "not met without it",
                "met",
                "obeys physics",
                "physical",
                "physical without it",
                "from the truth",
                "without it",
                "iterations",
                "without it",
                "met without it",
                "met",
                "physical",
                "physical without it",
            ],
        );
        let (mut all, mut good, mut physical, mut usual) = (0, 0, 0, 0);
        for ((quantity, set, _), asked) in asked(options, &acting, &hard) {
            let (idle, active): (Vec<&Asked>, Vec<&Asked>) =
                asked.iter().partition(|one| one.met_without);
            let count =
                |some: &[&Asked], is: fn(&Asked) -> bool| some.iter().filter(|one| is(one)).count();
            let share =
                |some: &[&Asked], is: fn(&Asked) -> bool| percent(count(some, is), some.len());
            let whole: Vec<&Asked> = asked.iter().collect();
            all += whole.len();
            good += count(&whole, |one| one.met && one.closed);
            physical += count(&whole, |one| one.met && one.physical);
            usual += count(&whole, |one| one.physical_without);
            let of = |value: fn(&Asked) -> f64| {
                let values = active
                    .iter()
                    .map(|one| value(one))
                    .filter(|v| v.is_finite());
                number(median(&values.collect::<Vec<_>>()))
            };
            table.row([
                quantity.as_str().to_owned(),
                set.as_str().to_owned(),
                active.len().to_string(),
                share(&active, |one| one.met),
                share(&active, |one| one.met && one.closed),
                share(&active, |one| one.met && one.physical),
                share(&active, |one| one.physical_without),
                format!("{} mm", of(|one| one.apart_mm)),
                format!("{} mm", of(|one| one.apart_without_mm)),
                of(|one| one.iterations as f64),
                of(|one| one.iterations_without as f64),
                idle.len().to_string(),
                share(&idle, |one| one.met),
                share(&idle, |one| one.met && one.physical),
                share(&idle, |one| one.physical_without),
            ]);
            let row = format!("{way}: {}, {}", quantity.as_str(), set.as_str());
            let not_met = || asked.iter().filter(|one| !(one.met && one.closed));
            record.numbers(&row, &not_met().map(|one| one.seed).collect::<Vec<_>>())?;
            for one in not_met() {
                missed.row([
                    way.to_owned(),
                    quantity.as_str().to_owned(),
                    set.as_str().to_owned(),
                    one.seed.to_string(),
                    if one.met { "yes" } else { "no" }.to_owned(),
                    one.end.clone(),
                    one.iterations.to_string(),
                ]);
            }
        }
        record.table(table);
        record.say(format!(
            "{way}: of {all} goals that a motion near the performed one meets, {good} are met by a motion that obeys physics; {physical} of these motions are called physical after all checks, and {usual} of those without the goal."
        ));
    }
    record.table(missed);
    wishes(options, record);
    Ok(())
}

/// Goals with a weight.
fn wishes(options: &Options, record: &mut Record) {
    let mut table = Table::new(
        "wishes",
        "With a weight",
        &[
            "what",
            "performances",
            "obeys physics",
            "off it, sd",
            "without it",
            "from the truth",
            "without it",
        ],
    );
    let soft = Quantity::ALL.map(|quantity| (quantity, Set::Exact, Some(SD)));
    for ((quantity, ..), asked) in asked(options, &Acting::default(), &soft) {
        let of = |value: fn(&Asked) -> f64| {
            let values = asked.iter().map(value).filter(|v| v.is_finite());
            number(median(&values.collect::<Vec<_>>()))
        };
        let closed = asked.iter().filter(|one| one.closed).count();
        table.row([
            quantity.as_str().to_owned(),
            asked.len().to_string(),
            percent(closed, asked.len()),
            of(|one| one.off_sds),
            of(|one| one.off_without_sds),
            format!("{} mm", of(|one| one.apart_mm)),
            format!("{} mm", of(|one| one.apart_without_mm)),
        ]);
    }
    record.table(table);
}
