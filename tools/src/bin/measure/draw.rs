//! Drawings of figures, in SVG.

mod frame;
mod ink;
mod labels;
mod look;
mod scale;

use anyhow::{Result, anyhow};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use crate::figure::Figure;
use frame::Frame;
use ink::{Drawn, wrapped, write};
use look::{FAINT, INK, PAPER};

/// Size of the plot itself and of what is around it.
const PLOT: (i32, i32) = (640, 420);
const LEFT: i32 = 86;
const RIGHT: i32 = 300;
const LINE: i32 = 19;
/// More names than this below the axis are written smaller.
const MANY: usize = 9;

/// The drawing of a figure.
pub fn svg(figure: &Figure) -> Result<String> {
    let title = wrapped(&figure.title, 88);
    let note = wrapped(&figure.note, 150);
    // Names stand in columns.
    let columns = figure.x.names.iter().map(|name| column(figure, name).len());
    let sunk = 17 * (columns.max().unwrap_or(1) as i32 - 1);
    let top = 16 + 24 * title.len() as i32 + 8;
    let bottom = top + PLOT.1;
    let width = LEFT + PLOT.0 + RIGHT;
    let height = bottom + sunk + 58 + LINE * note.len() as i32 + 10;
    let mut text = String::new();
    {
        let size = (width as u32, height as u32);
        let sheet = SVGBackend::with_string(&mut text, size).into_drawing_area();
        let draw = || -> Drawn {
            sheet.fill(&PAPER)?;
            for (index, line) in title.iter().enumerate() {
                let at = (20, 14 + 24 * index as i32);
                let style = ("sans-serif", 21).into_font().style(FontStyle::Bold);
                sheet.draw(&Text::new(line.clone(), at, style.color(&INK)))?;
            }
            let frame = Frame::new(figure, top);
            frame.grid(&sheet, figure, sunk)?;
            frame.curves(&sheet, figure)?;
            frame.legend(&sheet, figure)?;
            for (index, line) in note.iter().enumerate() {
                let at = (20, bottom + sunk + 58 + LINE * index as i32);
                write(&sheet, line, at, (15, FAINT), (HPos::Left, VPos::Top))?;
            }
            sheet.present()?;
            Ok(())
        };
        draw().map_err(|error| anyhow!("{}: {error}", figure.name))?;
    }
    Ok(text)
}

/// The lines of a name below the axis.
fn column(figure: &Figure, name: &str) -> Vec<String> {
    let letter = if figure.x.names.len() > MANY { 7 } else { 8 };
    wrapped(name, PLOT.0 as usize / figure.x.names.len().max(1) / letter)
}
