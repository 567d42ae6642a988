//! Drawings of figures, in SVG.

mod ink;
mod look;
mod scale;

use anyhow::{Result, anyhow};
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::figure::{Curve, Figure, Mark, Role};
use ink::{Drawn, Sheet, cross, dashed, line, point, wrapped, write, written};
use look::{FAINT, FINE_GRID, GRID, INK, Look, PAPER, looks};
use scale::{Scale, Tick};

/// Size of the plot itself and of what is around it.
const PLOT: (i32, i32) = (640, 420);
const LEFT: i32 = 86;
const RIGHT: i32 = 300;
const LINE: i32 = 19;
/// More names than this below the axis are written smaller.
const MANY: usize = 9;
/// How far from each other series stand whose points would lie on one another, and how wide all
/// of them may be.
const APART: i32 = 7;
const WIDEST: i32 = 56;

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

/// Where the curves are drawn.
struct Frame {
    x: Scale,
    y: Scale,
    left: i32,
    right: i32,
    top: i32,
    bottom: i32,
    /// How far the points of each curve stand aside.
    aside: Vec<i32>,
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
        let mut frame = Self {
            x: Scale::new(&figure.x, xs, [f64::from(left), f64::from(right)]),
            y: Scale::new(&figure.y, ys, [f64::from(bottom), f64::from(top)]),
            left,
            right,
            top,
            bottom,
            aside: vec![0; figure.curves.len()],
        };
        frame.stand_aside(figure);
        frame
    }

    /// Series stand side by side where points of two of them would lie on one another.
    fn stand_aside(&mut self, figure: &Figure) {
        let is_measured = |curve: &&Curve| curve.role != Role::Bound;
        let measured: Vec<&Curve> = figure.curves.iter().filter(is_measured).collect();
        let places = |curve: &Curve| -> Vec<(i32, i32)> {
            curve
                .points
                .iter()
                .map(|mark| (self.x.at(mark.x), self.y.at(mark.y)))
                .collect()
        };
        let all: Vec<Vec<(i32, i32)>> = measured.iter().map(|curve| places(curve)).collect();
        let meet = |a: &[(i32, i32)], b: &[(i32, i32)]| {
            a.iter().any(|p| {
                b.iter()
                    .any(|q| (p.0 - q.0).abs() < 3 && (p.1 - q.1).abs() < 3)
            })
        };
        // Only where all stand at the same places across, which then need not be read exactly.
        let longest = all.iter().max_by_key(|places| places.len());
        let stands =
            |at: i32| longest.is_some_and(|places| places.iter().any(|place| place.0 == at));
        let is_common = all.iter().flatten().all(|place| stands(place.0));
        let is_crowded =
            is_common && (1..all.len()).any(|b| (0..b).any(|a| meet(&all[a], &all[b])));
        if !is_crowded && figure.x.names.is_empty() {
            return;
        }
        let count = measured.len() as i32;
        let room = (self.right - self.left) / figure.x.names.len().max(8) as i32 - 6;
        let apart = APART.min(WIDEST.min(room) / count.max(1)).max(1);
        let mut index = 0;
        for (curve, aside) in figure.curves.iter().zip(&mut self.aside) {
            if curve.role != Role::Bound {
                *aside = (2 * index - (count - 1)) * apart / 2;
                index += 1;
            }
        }
    }

    fn at(&self, curve: usize, mark: &Mark) -> (i32, i32) {
        (self.x.at(mark.x) + self.aside[curve], self.y.at(mark.y))
    }

    fn grid(&self, sheet: &Sheet, figure: &Figure, sunk: i32) -> Drawn {
        let colour = |tick: &Tick| if tick.minor { FINE_GRID } else { GRID };
        for tick in self.x.ticks(&figure.x) {
            let ends = [(tick.at, self.top), (tick.at, self.bottom)];
            line(sheet, &ends, colour(&tick), 1)?;
            let lines = if figure.x.names.is_empty() {
                vec![tick.label]
            } else {
                column(figure, &tick.label)
            };
            let size = if figure.x.names.len() > MANY { 13 } else { 16 };
            for (index, part) in lines.iter().enumerate() {
                let at = (tick.at, self.bottom + 7 + 17 * index as i32);
                write(sheet, part, at, (size, INK), (HPos::Center, VPos::Top))?;
            }
        }
        for tick in self.y.ticks(&figure.y) {
            let ends = [(self.left, tick.at), (self.right, tick.at)];
            line(sheet, &ends, colour(&tick), 1)?;
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
        // The program's own last, over the others.
        let mut order: Vec<usize> = (0..figure.curves.len()).collect();
        order.sort_by_key(|index| figure.curves[*index].role == Role::Ours);
        let mut taken: Vec<Area> = Vec::new();
        for index in &order {
            let curve = &figure.curves[*index];
            self.curve(sheet, *index, curve, looks[*index])?;
            let places = curve.points.iter().map(|mark| self.at(*index, mark));
            taken.extend(places.map(Area::about));
        }
        // The heavier curve's settings are named first, and others where there is room.
        for index in order.iter().rev() {
            for mark in &figure.curves[*index].points {
                if let Some(setting) = &mark.setting {
                    self.name(
                        sheet,
                        setting,
                        self.at(*index, mark),
                        looks[*index],
                        &mut taken,
                    )?;
                }
            }
        }
        Ok(())
    }

    fn curve(&self, sheet: &Sheet, index: usize, curve: &Curve, look: Look) -> Drawn {
        let drawn = |mark: &&Mark| !mark.failed && mark.x.is_finite() && mark.y.is_finite();
        let good = curve.points.iter().filter(drawn);
        let path: Vec<(i32, i32)> = good.map(|mark| self.at(index, mark)).collect();
        if look.role == Role::Bound {
            return dashed(sheet, &path, look.colour);
        }
        if look.joins {
            line(sheet, &path, look.colour, look.width)?;
        }
        for mark in &curve.points {
            let at = self.at(index, mark);
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
        let places = [
            (x + 7, y - 13),
            (x + 7, y + 2),
            (x - 7 - width, y - 13),
            (x - 7 - width, y + 2),
            (x - width / 2, y - 20),
            (x - width / 2, y + 8),
        ];
        for (left, above) in places {
            let area = Area([left, above, left + width, above + 11]);
            let inside = left > self.left
                && left + width < self.right
                && above > self.top
                && above + 11 < self.bottom;
            if inside && !taken.iter().any(|other| other.meets(&area)) {
                let style = (13, look.colour);
                write(
                    sheet,
                    setting,
                    (left, above),
                    style,
                    (HPos::Left, VPos::Top),
                )?;
                taken.push(area);
                break;
            }
        }
        Ok(())
    }

    fn legend(&self, sheet: &Sheet, figure: &Figure) -> Drawn {
        let left = self.right + 16;
        let mut y = self.top + 8;
        let mut last = "";
        let said = |text: &str, y: i32| {
            write(
                sheet,
                text,
                (left + 36, y),
                (16, INK),
                (HPos::Left, VPos::Center),
            )
        };
        for (curve, look) in figure.curves.iter().zip(looks(figure)) {
            // Several bounds may be one thing.
            if look.role == Role::Bound && curve.name == last {
                continue;
            }
            last = &curve.name;
            if look.role == Role::Bound {
                dashed(sheet, &[(left, y), (left + 28, y)], look.colour)?;
            } else {
                if look.joins {
                    line(sheet, &[(left, y), (left + 28, y)], look.colour, look.width)?;
                }
                point(sheet, (left + 14, y), look)?;
            }
            for part in wrapped(&curve.name, 32) {
                said(&part, y)?;
                y += 17;
            }
            y += 6;
        }
        let failed = |curve: &Curve| curve.points.iter().any(|mark| mark.failed);
        if figure.curves.iter().any(failed) {
            cross(sheet, (left + 14, y), FAINT)?;
            said("failed", y)?;
        }
        Ok(())
    }
}

/// Left, top, right, bottom.
struct Area([i32; 4]);

impl Area {
    fn about((x, y): (i32, i32)) -> Self {
        Self([x - 5, y - 5, x + 5, y + 5])
    }

    fn meets(&self, other: &Self) -> bool {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        a < g && e < c && b < h && f < d
    }
}
