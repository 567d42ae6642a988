//! Pieces of HTML that parts of a page share.

use super::svg::escaped;
use crate::report::SuspectLine;
use crate::report::units::for_people;

/// A table; columns whose name ends with `*` are numbers.
pub(super) fn table(columns: &[&str], rows: &str) -> String {
    let heads = columns.iter().map(|name| match name.strip_suffix('*') {
        Some(name) => format!("<th scope=\"col\" class=\"n\">{name}</th>"),
        None => format!("<th scope=\"col\">{name}</th>"),
    });
    format!(
        "<div class=\"scroll\" tabindex=\"0\"><table><thead><tr>{}</tr></thead><tbody>{rows}</tbody></table></div>",
        heads.collect::<String>()
    )
}

/// Names one after the other.
pub(super) fn list(names: &[String]) -> String {
    let names = names
        .iter()
        .map(|name| format!("<bdi>{}</bdi>", escaped(name)));
    names.collect::<Vec<_>>().join(", ")
}

/// The unit in which people read values in a unit that a report names, as markup, and how many of it are one.
pub(super) fn shown_in(unit: &str) -> (f64, String) {
    let (factor, unit) = for_people(unit);
    (factor, escaped(unit))
}

/// A body, with the phase in which it is carried.
pub(super) fn with_phase(body: &str, phase: Option<&str>) -> String {
    phase.map_or_else(|| body.to_owned(), |phase| format!("{body}, {phase}"))
}

/// A number that the report knows.
pub(super) fn known(number: f64) -> Option<f64> {
    number.is_finite().then_some(number)
}

/// Names and likely values of what is suspected, or was.
pub(super) fn likely_values(of: &SuspectLine) -> String {
    let (factor, unit) = shown_in(&of.unit);
    let values = of.quantities.iter().map(|(name, value)| {
        let value = known(*value).map_or("?".to_owned(), |value| format!("{:.3}", value * factor));
        let words = format!("{} {value} {unit}", escaped(name));
        words.trim_end().to_owned()
    });
    values.collect::<Vec<_>>().join(", ")
}
