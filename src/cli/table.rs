//! Aligned columns.

use crate::report::plain;

/// Lines of cells under a head: first column aligned left, numbers aligned right, two spaces
/// between columns, `indent` before each line and no space at its end. Names in cells may be anything
/// ([`plain`]).
pub(super) fn table(indent: &str, head: &[&str], rows: &[Vec<String>]) -> String {
    let head: Vec<String> = head.iter().map(|cell| (*cell).to_owned()).collect();
    let row = |row: &Vec<String>| row.iter().map(|cell| plain(cell).into_owned()).collect();
    let rows: Vec<Vec<String>> = rows.iter().map(row).collect();
    let all: Vec<&Vec<String>> = std::iter::once(&head).chain(&rows).collect();
    let columns = all.iter().map(|row| row.len()).max().unwrap_or(0);
    let width = |column: usize| {
        all.iter()
            .filter_map(|row| row.get(column))
            .map(|cell| cell.chars().count())
            .max()
            .unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let left = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column));
        !cells
            .into_iter()
            .all(|cell| cell.chars().all(|c| !c.is_alphabetic()) || numeric(cell))
    };
    let lefts: Vec<bool> = (0..columns).map(|c| c == 0 || left(c)).collect();
    let mut text = String::new();
    for row in all {
        let mut line = indent.to_owned();
        for (column, cell) in row.iter().enumerate() {
            if column > 0 {
                line.push_str("  ");
            }
            let pad = " ".repeat(widths[column] - cell.chars().count());
            if lefts[column] {
                line.push_str(cell);
                line.push_str(&pad);
            } else {
                line.push_str(&pad);
                line.push_str(cell);
            }
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

/// Begins like a number: `0.41 s`, `< 1 µm`, `± 3 ms`, `within 0.2`.
fn numeric(cell: &str) -> bool {
    let cell = cell.trim_start_matches("within ");
    cell.trim_start_matches(['<', '±', '-', ' ', '['])
        .starts_with(|c: char| c.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stand_left_and_numbers_right() {
        let row = |cells: [&str; 3]| cells.map(str::to_owned).to_vec();
        let rows = [
            row(["bounce", "collision", "0.4 s"]),
            row(["end", "end", "12.0 s"]),
        ];
        assert_eq!(
            table("  ", &["event", "kind", "time"], &rows),
            "  event   kind         time\n  bounce  collision   0.4 s\n  end     end        12.0 s\n"
        );
    }
}
