//! Lines of text become cells.

use super::layout::{Fault, fault};

/// The least numbers in a row of a table of poses: a time and a position.
const NUMBERS_MIN: usize = 4;

/// A line that is not empty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Line {
    /// From 1.
    pub(super) number: usize,
    pub(super) cells: Vec<String>,
}

/// A file's lines: those before the first row of numbers, and those from there on.
#[derive(Clone, Debug)]
pub(super) struct Lines {
    pub(super) head: Vec<Line>,
    pub(super) rows: Vec<Line>,
    /// What parts the cells.
    pub(super) separator: Separator,
    /// Whether the last line has no end: a file that was cut off may have half a number there.
    pub(super) is_open: bool,
}

/// What stands between cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Separator {
    Byte(u8),
    Blanks,
}

const SEPARATORS: [Separator; 5] = [
    Separator::Byte(b';'),
    Separator::Byte(b'\t'),
    Separator::Byte(b','),
    Separator::Byte(b'|'),
    Separator::Blanks,
];

impl Separator {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Byte(b';') => "semicolons",
            Self::Byte(b'\t') => "tabs",
            Self::Byte(b'|') => "bars",
            Self::Byte(_) => "commas",
            Self::Blanks => "blanks",
        }
    }

    /// The cells of a line, at least one, without blanks and quotes about them.
    fn cells(self, line: &str) -> Vec<String> {
        let cells = self.parted(line);
        if cells.is_empty() {
            return vec![String::new()];
        }
        cells
    }

    fn parted(self, line: &str) -> Vec<String> {
        let Self::Byte(byte) = self else {
            return line.split_whitespace().map(str::to_owned).collect();
        };
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(byte)
            .has_headers(false)
            .flexible(true)
            .trim(csv::Trim::All)
            .buffer_capacity(line.len().max(1))
            .from_reader(line.as_bytes());
        let mut record = csv::StringRecord::new();
        // A text in memory can be read, and its pieces at ASCII bytes are text.
        match reader.read_record(&mut record) {
            Ok(true) => record.iter().map(str::to_owned).collect(),
            Ok(false) | Err(_) => Vec::new(),
        }
    }
}

/// A finite number; a comma may stand for the point.
pub(super) fn number(cell: &str) -> Option<f64> {
    let value = match cell.parse::<f64>() {
        Ok(value) => value,
        Err(_) => cell.replacen(',', ".", 1).parse().ok()?,
    };
    value.is_finite().then_some(value)
}

/// Whether a cell says that there is nothing.
pub(super) fn is_absent(cell: &str) -> bool {
    cell.is_empty() || ["nan", "null", "none", "-"].contains(&cell.to_ascii_lowercase().as_str())
}

/// Whether a line is a row of numbers: it begins with one, or with the name of a body and has more of them
/// than of anything else. Identifiers above the columns of a head begin with empty cells.
fn is_row(cells: &[String]) -> bool {
    let numbers = cells.iter().filter(|cell| number(cell).is_some()).count();
    let shown = cells.iter().filter(|cell| !is_absent(cell)).count();
    let begins = cells.first().is_some_and(|cell| !cell.is_empty());
    let is_first = cells.first().is_some_and(|cell| number(cell).is_some());
    numbers >= NUMBERS_MIN && begins && (is_first || 2 * numbers > shown)
}

/// The lines of a text, by the separator with which a row of numbers comes first, and of those the one with
/// the most numbers.
pub(super) fn lines(text: &str) -> Result<Lines, Fault> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let all = text.lines().enumerate();
    let all: Vec<(usize, &str)> = all
        .map(|(index, line)| (index + 1, line))
        .filter(|(_, line)| !line.trim().is_empty())
        .collect();
    let found = SEPARATORS.iter().filter_map(|separator| {
        let at = all
            .iter()
            .position(|(_, line)| is_row(&separator.cells(line)))?;
        let numbers = separator.cells(all[at].1);
        let numbers = numbers.iter().filter(|cell| number(cell).is_some()).count();
        Some((at, numbers, *separator))
    });
    let best = found.min_by_key(|(at, numbers, _)| (*at, usize::MAX - numbers));
    let Some((at, _, separator)) = best else {
        return fault(
            0,
            "no row of numbers, expected lines with a time, a position and an orientation, parted by \
             commas, semicolons, tabs or blanks",
        );
    };
    let line = |(number, line): &(usize, &str)| Line {
        number: *number,
        cells: separator.cells(line.trim_start_matches(['#', '%'])),
    };
    Ok(Lines {
        head: all[..at].iter().map(line).collect(),
        rows: all[at..]
            .iter()
            .filter(|(_, line)| !line.starts_with('#'))
            .map(line)
            .collect(),
        separator,
        is_open: !text.ends_with('\n'),
    })
}
