//! The plot itself: axes, grid and curves.

use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::ink::{Area, Drawn, Sheet, cross, dashed, line, point, write, written};
use super::look::{FAINT, FINE_GRID, GRID, INK, Look, looks};
use super::scale::{Scale, Tick};
use super::{LEFT, MANY, PLOT, column};
use crate::figure::{Curve, Figure, Mark, Role};

/// How far from each other series stand whose points would lie on one another, and how wide all
/// of them may be.
const APART: i32 = 7;
const WIDEST: i32 = 56;

/// Where the curves are drawn.
pub struct Frame {
    x: Scale,
    y: Scale,
    pub(super) left: i32,
    pub(super) right: i32,
    pub(super) top: i32,
    pub(super) bottom: i32,
    /// How far the points of each curve stand aside.
    aside: Vec<i32>,
}

impl Frame {
    /// Scales that hold all of a figure.
    pub fn new(figure: &Figure, top: i32) -> Self {
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

    /// Grid, axes and what is written along them.
    pub fn grid(&self, sheet: &Sheet, figure: &Figure, sunk: i32) -> Drawn {
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

    /// All curves, and names of settings where there is room.
    pub fn curves(&self, sheet: &Sheet, figure: &Figure) -> Drawn {
        let looks = looks(figure);
        // The program's own last, over the others.
        let mut order: Vec<usize> = (0..figure.curves.len()).collect();
        order.sort_by_key(|index| figure.curves[*index].role == Role::Ours);
        let mut taken: Vec<Area> = Vec::new();
        for index in &order {
            let curve = &figure.curves[*index];
            self.curve(sheet, *index, figure, looks[*index])?;
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

    fn curve(&self, sheet: &Sheet, index: usize, figure: &Figure, look: Look) -> Drawn {
        let curve = &figure.curves[index];
        let drawn = |mark: &&Mark| !mark.failed && mark.x.is_finite() && mark.y.is_finite();
        // What is no step stands beside the others.
        let steps = figure.x.steps as f64;
        let is_joined = |mark: &&Mark| steps == 0.0 || look.role == Role::Bound || mark.x < steps;
        let good = curve.points.iter().filter(drawn).filter(is_joined);
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
}
