//! Lines of text become cells.

use super::layout::{TableFault, fault};
use super::missing::is_absent;
use super::stamp::is_text_time;

/// The least numbers in a row of a table of poses: a time and a position.
const NUMBERS_MIN: usize = 4;

/// A line that is not empty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Line {
    /// From 1.
    pub(super) number: usize,
    pub(super) cells: Vec<String>,
}

impl Line {
    /// How many cells it has, but for empty ones at its end.
    pub(super) fn filled(&self) -> usize {
        let last = self.cells.iter().rposition(|cell| !cell.is_empty());
        last.map_or(0, |last| last + 1)
    }
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
    /// What was done to read them.
    pub(super) notes: Vec<String>,
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
        // A reader of CSV takes longer to be made than a line to be parted.
        if !line.contains('"') {
            return line
                .split(char::from(byte))
                .map(|cell| cell.trim().to_owned())
                .collect();
        }
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

/// Whether a line is a row of numbers: it begins with one or a time, or with the name of a body and has more of
/// them than of anything else. Identifiers above the columns of a head begin with empty cells.
fn is_row(cells: &[String]) -> bool {
    let numbers = cells.iter().filter(|cell| number(cell).is_some()).count();
    let shown = cells.iter().filter(|cell| !is_absent(cell)).count();
    let begins = cells.first().is_some_and(|cell| !cell.is_empty());
    numbers >= NUMBERS_MIN && begins && (begins_as_row(cells) || 2 * numbers > shown)
}

/// Whether the first cell is a number or a time.
fn begins_as_row(cells: &[String]) -> bool {
    let first = cells.first();
    first.is_some_and(|cell| number(cell).is_some() || is_text_time(cell))
}

/// Whether a line is a row in which nothing was seen: a number or a time, and nothing but numbers and empty cells.
fn is_empty_row(cells: &[String], count: usize) -> bool {
    let mut rest = cells.iter().skip(1);
    let is_as_long = cells.len() == count || cells.len() <= 2;
    is_as_long && begins_as_row(cells) && rest.all(|cell| number(cell).is_some() || is_absent(cell))
}

/// The lines of a text, by the separator with which a row of numbers comes first, and of those the one with
/// the most numbers.
pub(super) fn lines(text: &str) -> Result<Lines, TableFault> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let of_old_macs;
    let text = if text.contains('\r') && !text.contains('\n') {
        of_old_macs = text.replace('\r', "\n");
        &of_old_macs
    } else {
        text
    };
    let all = text.lines().enumerate();
    let all: Vec<(usize, &str)> = all
        .map(|(index, line)| (index + 1, line))
        .filter(|(_, line)| !line.trim().is_empty())
        .collect();
    let head_end = numbered_head(&all);
    let found = SEPARATORS.iter().filter_map(|separator| {
        let mut rows = all[head_end..].iter();
        let at = rows.position(|(_, line)| is_row(&separator.cells(line)))? + head_end;
        let numbers = separator.cells(all[at].1);
        let numbers = numbers.iter().filter(|cell| number(cell).is_some()).count();
        Some((at, numbers, *separator))
    });
    let Some((at, _, separator)) =
        found.min_by_key(|(at, numbers, _)| (*at, std::cmp::Reverse(*numbers)))
    else {
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
    let mut head: Vec<Line> = all[..at].iter().map(line).collect();
    let is_remark = |line: &str| line.starts_with(['#', '%']) || line.starts_with("//");
    let mut rows: Vec<Line> = all[at..]
        .iter()
        .filter(|(_, line)| !is_remark(line))
        .map(line)
        .collect();
    // Rows that begin before anything was seen.
    let count = rows.first().map_or(0, |row| row.cells.len());
    let before = head.iter().skip(head_end).rev();
    let empty = before.take_while(|line| is_empty_row(&line.cells, count));
    let mut whole = head.split_off(head.len() - empty.count());
    whole.append(&mut rows);
    let mut lines = Lines {
        head,
        rows: whole,
        separator,
        is_open: !text.ends_with('\n'),
        notes: Vec::new(),
    };
    join_decimal_commas(&mut lines);
    Ok(lines)
}

/// How many lines are of a head that has lines of numbers itself.
fn numbered_head(all: &[(usize, &str)]) -> usize {
    if !all
        .first()
        .is_some_and(|(_, line)| line.starts_with("PathFileType"))
    {
        return 0;
    }
    let columns = all.iter().position(|(_, line)| line.starts_with("Frame#"));
    columns.map_or(0, |at| at + 1)
}

/// Puts numbers with decimal commas together that commas part as well: twice as many cells as names, of which
/// each second one is digits alone.
fn join_decimal_commas(lines: &mut Lines) {
    let names = lines.head.last().map_or(0, Line::filled);
    let is_digits = |cell: &String| !cell.is_empty() && cell.bytes().all(|of| of.is_ascii_digit());
    let is_double = |row: &Line| {
        row.cells.len() == 2 * names && row.cells.iter().skip(1).step_by(2).all(is_digits)
    };
    let is_comma = lines.separator == Separator::Byte(b',');
    if !is_comma || names < NUMBERS_MIN || !lines.rows.iter().all(is_double) {
        return;
    }
    for row in &mut lines.rows {
        let pairs = row.cells.chunks(2);
        row.cells = pairs.map(|pair| pair.join(".")).collect();
    }
    lines.notes.push(
        "numbers have decimal commas, and commas part them: two cells are taken for one number"
            .to_owned(),
    );
}
