//! The order of rows, which is looked at before anybody sorts them.

use super::said::listed;

/// A step back of more intervals than this is no late delivery,
const LATE_INTERVALS: f64 = 5.0;
/// nor is one of more than this \[ns\].
const LATE_NS: f64 = 50e6;
/// More poses than this share of them at the time of another are no accident.
const EQUAL_SHARE: f64 = 0.05;

/// Half a day: who goes back by more has passed midnight \[ns\].
const HALF_DAY_NS: i64 = 43_200_000_000_000;

/// Days that have passed, of clocks that begin anew at midnight.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Days {
    passed_ns: i64,
    last_ns: Option<i64>,
}

impl Days {
    /// The time since the first row's midnight; of a clock that does not begin anew the time itself.
    pub(super) fn of(&mut self, ns: i64, wraps: bool) -> i64 {
        let goes_back = |last_ns: i64| ns + self.passed_ns < last_ns - HALF_DAY_NS;
        if wraps && self.last_ns.is_some_and(goes_back) {
            self.passed_ns += 2 * HALF_DAY_NS;
        }
        let ns = ns.saturating_add(self.passed_ns);
        self.last_ns = Some(ns);
        ns
    }
}

/// The time of a row, with its line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RowTime {
    pub(super) line: usize,
    pub(super) ns: i64,
}

/// What the order of a body's rows tells.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct RowOrder {
    pub(super) notes: Vec<String>,
    pub(super) against: Vec<String>,
}

/// Looks at the times of a body's rows in the order of the file. `others` are columns that may serve better.
pub(super) fn order(rows: &[RowTime], others: &[String]) -> RowOrder {
    let mut order = RowOrder::default();
    let steps = || {
        rows.windows(2)
            .map(|pair| (pair[1].line, pair[1].ns.saturating_sub(pair[0].ns)))
    };
    let mut forward: Vec<i64> = steps()
        .map(|(_, step)| step)
        .filter(|step| *step > 0)
        .collect();
    let middle = forward.len() / 2;
    let median_ns = match forward.is_empty() {
        true => 0.0,
        false => *forward.select_nth_unstable(middle).1 as f64,
    };
    back(&mut order, steps(), median_ns);
    let equal: Vec<usize> = steps()
        .filter(|(_, step)| *step == 0)
        .map(|(line, _)| line)
        .collect();
    let Some(first) = equal.first() else {
        return order;
    };
    let count = rows.len();
    let said = format!(
        "{} of {count} poses have the time of the one before, the first in line {first}",
        equal.len()
    );
    if equal.len() as f64 <= EQUAL_SHARE * count as f64 {
        order.notes.push(said);
        return order;
    }
    let are_whole = rows.iter().all(|row| row.ns % 1_000_000_000 == 0);
    let column = match others {
        [] => String::new(),
        others => format!(
            ", or another column ({}) for the time in --columns",
            listed(others)
        ),
    };
    order.against.push(if equal.len() + 1 == count {
        format!("all poses are at one instant, {} s: expected --rate HZ{column}", rows[0].ns as f64 * 1e-9)
    } else if are_whole {
        format!("times are whole seconds: {said}; expected --rate HZ{column}")
    } else {
        format!("{said}: several bodies in turn? Expected a column body in --columns that tells them, --rate HZ{column}")
    });
    order
}

fn back(order: &mut RowOrder, steps: impl Iterator<Item = (usize, i64)> + Clone, median_ns: f64) {
    let mut late = 0;
    let mut late_most_ns = 0.0_f64;
    let mut first: Option<(usize, f64)> = None;
    let mut restarts = 0;
    for (line, step) in steps.filter(|(_, step)| *step < 0) {
        let back_ns = -(step as f64);
        if back_ns <= LATE_NS.min(LATE_INTERVALS * median_ns) {
            late += 1;
            late_most_ns = late_most_ns.max(back_ns);
        } else {
            restarts += 1;
            first = first.or(Some((line, back_ns)));
        }
    }
    if let Some((line, back_ns)) = first {
        let more = match restarts {
            1 => String::new(),
            more => format!(", and {} times more", more - 1),
        };
        order.against.push(format!(
            "times go back by {:.3} s at line {line}{more}: two takes in one file? Expected rows in order of time: part \
             the file there",
            back_ns * 1e-9
        ));
    }
    if late > 0 {
        order.notes.push(format!(
            "{late} rows come after later ones, by {:.4} s at most: they are put in order",
            late_most_ns * 1e-9
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(times_ms: &[i64]) -> RowOrder {
        let rows = times_ms.iter().enumerate();
        let rows = rows.map(|(index, ms)| RowTime {
            line: index + 2,
            ns: ms * 1_000_000,
        });
        order(&rows.collect::<Vec<_>>(), &["stamp".to_owned()])
    }

    #[test]
    fn rows_in_order_are_nothing_to_speak_of() {
        assert_eq!(of(&[0, 10, 20, 25, 40]), RowOrder::default());
        assert_eq!(of(&[]), RowOrder::default());
        assert_eq!(of(&[5]), RowOrder::default());
    }

    #[test]
    fn what_is_out_of_order_is_said_with_its_line() {
        let again = of(&[0, 10, 20, 30, 40, 50, 60, 0, 10, 20]);
        assert!(
            again.against[0].starts_with("times go back by 0.060 s at line 9:"),
            "{again:?}"
        );
        let late = of(&[0, 10, 20, 40, 30, 50, 60]);
        assert!(
            late.against.is_empty() && late.notes[0].contains("1 rows come after"),
            "{late:?}"
        );
    }

    #[test]
    fn poses_at_one_time_are_doubted_with_what_would_serve() {
        let instant = of(&[0, 0, 0]);
        assert!(
            instant.against[0].contains("all poses are at one instant")
                && instant.against[0].contains("stamp")
        );
        let whole = of(&[0, 0, 0, 1000, 1000, 2000]);
        assert!(
            whole.against[0].starts_with("times are whole seconds: 3 of 6"),
            "{whole:?}"
        );
        let turns = of(&[0, 0, 10, 10, 20, 20]);
        assert!(
            turns.against[0].contains("several bodies in turn"),
            "{turns:?}"
        );
    }
}
