//! Lines, points and words on a sheet.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::look::Look;

/// What is drawn on.
pub type Sheet<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// Whether drawing succeeded.
pub type Drawn = Result<(), Box<dyn std::error::Error>>;

/// Length of a dash and of the gap after it.
const DASH: f64 = 7.0;

/// A point in the shape of its series.
pub fn point(sheet: &Sheet, (x, y): (i32, i32), look: Look) -> Drawn {
    let fill = look.colour.filled();
    match look.shape {
        0 => sheet.draw(&Circle::new((x, y), 5, fill))?,
        1 => sheet.draw(&Rectangle::new([(x - 4, y - 4), (x + 4, y + 4)], fill))?,
        2 => sheet.draw(&Polygon::new(
            vec![(x, y - 5), (x + 5, y + 4), (x - 5, y + 4)],
            fill,
        ))?,
        3 => sheet.draw(&Polygon::new(
            vec![(x, y - 6), (x + 6, y), (x, y + 6), (x - 6, y)],
            fill,
        ))?,
        _ => sheet.draw(&Circle::new((x, y), 4, fill))?,
    }
    Ok(())
}

/// A failure.
pub fn cross(sheet: &Sheet, (x, y): (i32, i32), colour: RGBColor) -> Drawn {
    line(sheet, &[(x - 6, y - 6), (x + 6, y + 6)], colour, 3)?;
    line(sheet, &[(x - 6, y + 6), (x + 6, y - 6)], colour, 3)
}

/// A line through all places.
pub fn line(sheet: &Sheet, path: &[(i32, i32)], colour: RGBColor, width: u32) -> Drawn {
    if path.len() > 1 {
        sheet.draw(&PathElement::new(path.to_vec(), colour.stroke_width(width)))?;
    }
    Ok(())
}

/// A dashed line through all places.
pub fn dashed(sheet: &Sheet, path: &[(i32, i32)], colour: RGBColor) -> Drawn {
    let mut since = 0.0_f64;
    for ends in path.windows(2) {
        let [a, b] = [ends[0], ends[1]].map(|(x, y)| (f64::from(x), f64::from(y)));
        let length = (b.0 - a.0).hypot(b.1 - a.1);
        let on = |at: f64| {
            let share = at / length;
            let x = a.0 + share * (b.0 - a.0);
            let y = a.1 + share * (b.1 - a.1);
            (x.round() as i32, y.round() as i32)
        };
        let mut at = 0.0;
        while at < length {
            let next = ((((since + at) / DASH).floor() + 1.0) * DASH - since).min(length);
            let next = if next - at < 1e-6 {
                (at + DASH).min(length)
            } else {
                next
            };
            if ((since + at + 1e-6) / DASH) as i64 % 2 == 0 {
                line(sheet, &[on(at), on(next)], colour, 2)?;
            }
            at = next;
        }
        since += length;
    }
    Ok(())
}

/// The style of words.
pub fn written(size: u32, colour: RGBColor) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&colour)
}

/// Words at a place.
pub fn write(
    sheet: &Sheet,
    text: &str,
    at: (i32, i32),
    (size, colour): (u32, RGBColor),
    (across, up): (HPos, VPos),
) -> Drawn {
    let style = written(size, colour).pos(Pos::new(across, up));
    sheet.draw(&Text::new(text.to_owned(), at, style))?;
    Ok(())
}

/// Lines of at most so many letters, broken between words.
pub fn wrapped(text: &str, most: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= most => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// A rectangle that is taken: left, top, right, bottom.
pub struct Area(pub [i32; 4]);

impl Area {
    /// About a point.
    pub fn about((x, y): (i32, i32)) -> Self {
        Self([x - 5, y - 5, x + 5, y + 5])
    }

    /// Whether two have a place in common.
    pub fn meets(&self, other: &Self) -> bool {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        a < g && e < c && b < h && f < d
    }
}
