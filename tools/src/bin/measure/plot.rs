//! Drawings of figures, in SVG.

use anyhow::{Result, anyhow};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::figure::{Curve, Figure, Mark, Role};
use crate::scale::{Scale, Tick};

type Sheet<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Size of the plot itself and of what is around it.
const PLOT: (i32, i32) = (640, 420);
const LEFT: i32 = 86;
const RIGHT: i32 = 300;
const LINE: i32 = 19;

const PAPER: RGBColor = RGBColor(255, 255, 255);
const INK: RGBColor = RGBColor(34, 34, 34);
const FAINT: RGBColor = RGBColor(90, 90, 90);
const GRID: RGBColor = RGBColor(205, 205, 205);
const FINE_GRID: RGBColor = RGBColor(236, 236, 236);

/// Okabe and Ito's colours, which most colour-blind people tell apart, without the yellow.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(120, 120, 120),
    RGBColor(0, 0, 0),
];
/// The program's own.
const OURS: RGBColor = RGBColor(213, 94, 0);
const BOUND: RGBColor = RGBColor(60, 60, 60);

/// How a curve looks.
#[derive(Clone, Copy)]
struct Look {
    colour: RGBColor,
    shape: usize,
    width: u32,
    role: Role,
}

/// The drawing of a figure.
pub fn svg(figure: &Figure) -> Result<String> {
    let title = wrapped(&figure.title, 88);
    let note = wrapped(&figure.note, 150);
    // Names stand in columns.
    let names: Vec<Vec<String>> = figure
        .x
        .names
        .iter()
        .map(|name| column(figure, name))
        .collect();
    let rows = names.iter().map(Vec::len).max().unwrap_or(1);
    let sunk = 17 * (rows as i32 - 1);
    let top = 16 + 24 * title.len() as i32 + 8;
    let bottom = top + PLOT.1;
    let width = LEFT + PLOT.0 + RIGHT;
    let height = bottom + sunk + 58 + LINE * note.len() as i32 + 10;
    let mut text = String::new();
    {
        let size = (width as u32, height as u32);
        let sheet = SVGBackend::with_string(&mut text, size).into_drawing_area();
        let draw = || -> Result<(), Box<dyn std::error::Error>> {
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
    let letters = PLOT.0 as usize / figure.x.names.len().max(1) / 8;
    wrapped(name, letters)
}

type Drawn = Result<(), Box<dyn std::error::Error>>;

/// Where the curves are drawn.
struct Frame {
    x: Scale,
    y: Scale,
    left: i32,
    right: i32,
    top: i32,
    bottom: i32,
}

impl Frame {
    fn new(figure: &Figure, top: i32) -> Self {
        let (left, right, bottom) = (LEFT, LEFT + PLOT.0, top + PLOT.1);
        let marks = || figure.curves.iter().flat_map(|curve| &curve.points);
        let ys = marks().flat_map(|mark| {
            let [least, greatest] = mark.spread.unwrap_or([mark.y; 2]);
            [mark.y, least, greatest]
        });
        let xs = marks().map(|mark| mark.x);
        Self {
            x: Scale::new(&figure.x, xs, [f64::from(left), f64::from(right)]),
            y: Scale::new(&figure.y, ys, [f64::from(bottom), f64::from(top)]),
            left,
            right,
            top,
            bottom,
        }
    }

    fn at(&self, mark: &Mark) -> (i32, i32) {
        (self.x.at(mark.x), self.y.at(mark.y))
    }

    fn grid(&self, sheet: &Sheet, figure: &Figure, sunk: i32) -> Drawn {
        let colour = |tick: &Tick| if tick.minor { FINE_GRID } else { GRID };
        for tick in self.x.ticks(&figure.x) {
            line(
                sheet,
                &[(tick.at, self.top), (tick.at, self.bottom)],
                colour(&tick),
                1,
            )?;
            let lines = if figure.x.names.is_empty() {
                vec![tick.label]
            } else {
                column(figure, &tick.label)
            };
            for (index, part) in lines.iter().enumerate() {
                let at = (tick.at, self.bottom + 7 + 17 * index as i32);
                write(sheet, part, at, (16, INK), (HPos::Center, VPos::Top))?;
            }
        }
        for tick in self.y.ticks(&figure.y) {
            line(
                sheet,
                &[(self.left, tick.at), (self.right, tick.at)],
                colour(&tick),
                1,
            )?;
            let at = (self.left - 7, tick.at);
            write(
                sheet,
                &tick.label,
                at,
                (16, INK),
                (HPos::Right, VPos::Center),
            )?;
        }
        let corners = [(self.left, self.top), (self.right, self.bottom)];
        sheet.draw(&Rectangle::new(corners, FAINT.stroke_width(1)))?;
        let middle = ((self.left + self.right) / 2, self.bottom + 30 + sunk);
        write(
            sheet,
            &figure.x.label,
            middle,
            (18, INK),
            (HPos::Center, VPos::Top),
        )?;
        let style = written(18, INK)
            .transform(FontTransform::Rotate270)
            .pos(Pos::new(HPos::Center, VPos::Top));
        let beside = (14, (self.top + self.bottom) / 2);
        sheet.draw(&Text::new(figure.y.label.clone(), beside, style))?;
        Ok(())
    }

    fn curves(&self, sheet: &Sheet, figure: &Figure) -> Drawn {
        let looks = looks(figure);
        let mut taken: Vec<Area> = Vec::new();
        // The program's own last, over the others.
        let mut order: Vec<usize> = (0..figure.curves.len()).collect();
        order.sort_by_key(|index| figure.curves[*index].role == Role::Ours);
        for index in &order {
            self.curve(sheet, &figure.curves[*index], looks[*index])?;
        }
        for index in &order {
            for mark in &figure.curves[*index].points {
                taken.push(Area::about(self.at(mark), 5));
            }
        }
        // The heavier curve's settings are named first, and others where there is room.
        for index in order.iter().rev() {
            for mark in &figure.curves[*index].points {
                if let Some(setting) = &mark.setting {
                    self.name(sheet, setting, self.at(mark), looks[*index], &mut taken)?;
                }
            }
        }
        Ok(())
    }

    fn curve(&self, sheet: &Sheet, curve: &Curve, look: Look) -> Drawn {
        let drawn = |mark: &&Mark| !mark.failed && mark.x.is_finite() && mark.y.is_finite();
        let good = curve.points.iter().filter(drawn);
        let path: Vec<(i32, i32)> = good.map(|mark| self.at(mark)).collect();
        if look.role == Role::Bound {
            dashed(sheet, &path, look)?;
            return Ok(());
        }
        line(sheet, &path, look.colour, look.width)?;
        for mark in &curve.points {
            let at = self.at(mark);
            if let Some([least, greatest]) = mark.spread {
                let (low, high) = (self.y.at(least), self.y.at(greatest));
                line(sheet, &[(at.0, low), (at.0, high)], look.colour, 1)?;
                for end in [low, high] {
                    line(sheet, &[(at.0 - 3, end), (at.0 + 3, end)], look.colour, 1)?;
                }
            }
            if mark.failed {
                cross(sheet, at, look.colour)?;
            } else {
                point(sheet, at, look)?;
            }
        }
        Ok(())
    }

    /// The name of a setting beside its point, unless there is no room.
    fn name(
        &self,
        sheet: &Sheet,
        setting: &str,
        (x, y): (i32, i32),
        look: Look,
        taken: &mut Vec<Area>,
    ) -> Drawn {
        let width = 6 * setting.chars().count() as i32 + 2;
        for (left, above) in [
            (x + 7, y - 13),
            (x + 7, y + 2),
            (x - 7 - width, y - 13),
            (x - 7 - width, y + 2),
            (x - width / 2, y - 20),
            (x - width / 2, y + 8),
        ] {
            let area = Area([left, above, left + width, above + 11]);
            let inside = left > self.left
                && left + width < self.right
                && above > self.top
                && above + 11 < self.bottom;
            if inside && !taken.iter().any(|other| other.meets(&area)) {
                write(
                    sheet,
                    setting,
                    (left, above),
                    (13, look.colour),
                    (HPos::Left, VPos::Top),
                )?;
                taken.push(area);
                return Ok(());
            }
        }
        Ok(())
    }

    fn legend(&self, sheet: &Sheet, figure: &Figure) -> Drawn {
        let left = self.right + 16;
        let mut y = self.top + 8;
        let mut last = "";
        for (curve, look) in figure.curves.iter().zip(looks(figure)) {
            // Several bounds may be one thing.
            if look.role == Role::Bound && curve.name == last {
                continue;
            }
            last = &curve.name;
            if look.role == Role::Bound {
                dashed(sheet, &[(left, y), (left + 28, y)], look)?;
            } else {
                line(sheet, &[(left, y), (left + 28, y)], look.colour, look.width)?;
                point(sheet, (left + 14, y), look)?;
            }
            for part in wrapped(&curve.name, 32) {
                write(
                    sheet,
                    &part,
                    (left + 36, y),
                    (16, INK),
                    (HPos::Left, VPos::Center),
                )?;
                y += 17;
            }
            y += 6;
        }
        let failed = |curve: &Curve| curve.points.iter().any(|mark| mark.failed);
        if figure.curves.iter().any(failed) {
            cross(sheet, (left + 14, y), FAINT)?;
            write(
                sheet,
                "failed",
                (left + 36, y),
                (16, INK),
                (HPos::Left, VPos::Center),
            )?;
        }
        Ok(())
    }
}

/// Left, top, right, bottom.
struct Area([i32; 4]);

impl Area {
    fn about((x, y): (i32, i32), half: i32) -> Self {
        Self([x - half, y - half, x + half, y + half])
    }

    fn meets(&self, other: &Self) -> bool {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        a < g && e < c && b < h && f < d
    }
}

fn looks(figure: &Figure) -> Vec<Look> {
    let mut next = 0;
    let look = |curve: &Curve| {
        let (colour, width) = match curve.role {
            Role::Ours => (OURS, 3),
            Role::Bound => (BOUND, 1),
            Role::Compared => (COLOURS[next % COLOURS.len()], 2),
        };
        // Between things without order a line only leads the eye.
        let width = if figure.x.names.is_empty() { width } else { 1 };
        let shape = if curve.role == Role::Ours {
            0
        } else {
            1 + next % 4
        };
        next += usize::from(curve.role == Role::Compared);
        Look {
            colour,
            shape,
            width,
            role: curve.role,
        }
    };
    figure.curves.iter().map(look).collect()
}

fn point(sheet: &Sheet, (x, y): (i32, i32), look: Look) -> Drawn {
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

fn cross(sheet: &Sheet, (x, y): (i32, i32), colour: RGBColor) -> Drawn {
    line(sheet, &[(x - 6, y - 6), (x + 6, y + 6)], colour, 3)?;
    line(sheet, &[(x - 6, y + 6), (x + 6, y - 6)], colour, 3)
}

fn line(sheet: &Sheet, path: &[(i32, i32)], colour: RGBColor, width: u32) -> Drawn {
    if path.len() > 1 {
        sheet.draw(&PathElement::new(path.to_vec(), colour.stroke_width(width)))?;
    }
    Ok(())
}

fn dashed(sheet: &Sheet, path: &[(i32, i32)], look: Look) -> Drawn {
    const DASH: f64 = 7.0;
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
                line(sheet, &[on(at), on(next)], look.colour, 2)?;
            }
            at = next;
        }
        since += length;
    }
    Ok(())
}

fn written(size: u32, colour: RGBColor) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&colour)
}

fn write(
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
fn wrapped(text: &str, most: usize) -> Vec<String> {
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
