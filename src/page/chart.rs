//! Small charts: one quantity against time, or one time against another.

use std::fmt::Write;

use super::svg::{escaped, line, px, shortened, text};
use crate::visual::chain;

/// Around the plot: left, top, right and bottom, in pixels.
const AROUND_PX: [f64; 4] = [44.0, 10.0, 12.0, 24.0];

/// How far off a line may be, in pixels.
const TOLERANCE_PX: f64 = 0.2;

/// More points than these are drawn as a line alone.
const DOTS: usize = 160;

/// Something drawn in a chart.
pub(super) enum ChartMark {
    /// Points that follow each other, with a class for the line and one for the dots.
    Series {
        points: Vec<[f64; 2]>,
        classes: [String; 2],
    },
    /// A level, dashed, with its name.
    Level { at: f64, name: String },
    /// A straight line from one point to another.
    Guide { from: [f64; 2], to: [f64; 2] },
    /// A vertical line with a name.
    Event { at: f64, name: String },
    /// A ring at a point with a name.
    Ring { at: [f64; 2], name: String },
}

/// A chart: ranges are those of the axes.
pub(super) struct Chart<'a> {
    pub size_px: [f64; 2],
    pub across: [f64; 2],
    pub up: [f64; 2],
    /// What the axes are of, with units.
    pub axes: [&'a str; 2],
    /// What it shows, for who cannot see it.
    pub label: String,
    pub marks: Vec<ChartMark>,
}

impl Chart<'_> {
    /// As an element of a page.
    pub(super) fn element(&self) -> String {
        let [width, height] = self.size_px;
        let mut out = format!(
            "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\"><title>{}</title>",
            px(width),
            px(height),
            escaped(&self.label),
            escaped(&self.label)
        );
        self.axes(&mut out);
        for mark in &self.marks {
            self.mark(&mut out, mark);
        }
        out += "</svg>";
        out
    }

    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [left, top, right, bottom] = AROUND_PX;
        let part = |value: f64, [from, to]: [f64; 2]| (value - from) / (to - from).max(1e-300);
        let [width, height] = self.size_px;
        [
            left + part(x, self.across) * (width - left - right),
            height - bottom - part(y, self.up) * (height - top - bottom),
        ]
    }

    fn axes(&self, out: &mut String) {
        let [left, bottom] = [self.across[0], self.up[0]];
        let small = " class=\"dim\" font-size=\"10.5\"";
        let mut grid = String::new();
        let (steps, decimals) = ticks(self.up, 3.0);
        for y in steps {
            let [from, to] = [[left, y], [self.across[1], y]].map(|at| self.at(at));
            grid += &line(&[from, to]);
            let attributes = format!("{small} text-anchor=\"end\"");
            *out += &text(
                [from[0] - 5.0, from[1] + 3.5],
                &attributes,
                &format!("{y:.decimals$}"),
            );
        }
        let _ = write!(out, "<path class=\"gr\" d=\"{grid}\"/>");
        let mut feet = String::new();
        let (steps, decimals) = ticks(self.across, (self.size_px[0] / 75.0).clamp(2.0, 6.0));
        for x in steps {
            let at = self.at([x, bottom]);
            feet += &line(&[at, [at[0], at[1] + 4.0]]);
            let attributes = format!("{small} text-anchor=\"middle\"");
            *out += &text(
                [at[0], at[1] + 15.0],
                &attributes,
                &format!("{x:.decimals$}"),
            );
        }
        let [from, to] = [[left, bottom], [self.across[1], bottom]].map(|at| self.at(at));
        feet += &line(&[from, to]);
        let _ = write!(out, "<path class=\"ax\" d=\"{feet}\"/>");
        let [width, height] = self.size_px;
        *out += &text(
            [width - 2.0, height - AROUND_PX[3] - 5.0],
            &format!("{small} text-anchor=\"end\""),
            self.axes[0],
        );
        *out += &text(
            [AROUND_PX[0] + 5.0, AROUND_PX[1] + 8.0],
            small,
            self.axes[1],
        );
    }

    fn mark(&self, out: &mut String, mark: &ChartMark) {
        match mark {
            ChartMark::Series { points, classes } => {
                let points: Vec<[f64; 2]> = points.iter().map(|at| self.at(*at)).collect();
                let _ = write!(
                    out,
                    "<path class=\"{} no\" stroke-width=\"1.4\" stroke-linejoin=\"round\" d=\"{}\"/>",
                    classes[0],
                    line(&chain(&points, TOLERANCE_PX))
                );
                if points.len() <= DOTS {
                    let dots = points
                        .iter()
                        .map(|[x, y]| format!("M{} {}h0", px(*x), px(*y)));
                    let dots: String = dots.collect();
                    let _ = write!(
                        out,
                        "<path class=\"{} no\" stroke-width=\"3\" stroke-linecap=\"round\" d=\"{dots}\"/>",
                        classes[1]
                    );
                }
            }
            ChartMark::Level { at, name } => {
                let [from, to] = self.across.map(|x| self.at([x, *at]));
                let _ = write!(
                    out,
                    "<path class=\"gl\" stroke-width=\"1\" d=\"{}\"/>",
                    line(&[from, to])
                );
                let attributes = " class=\"dim halo\" font-size=\"10.5\" text-anchor=\"end\"";
                *out += &text([to[0], to[1] - 4.0], attributes, name);
            }
            ChartMark::Guide { from, to } => {
                let ends = [self.at(*from), self.at(*to)];
                let _ = write!(
                    out,
                    "<path class=\"ax\" stroke-dasharray=\"4 4\" d=\"{}\"/>",
                    line(&ends)
                );
            }
            ChartMark::Event { at, name } => {
                let [foot, head] = self.up.map(|y| self.at([*at, y]));
                let _ = write!(
                    out,
                    "<path class=\"ev\" stroke-width=\".8\" d=\"{}\"/>",
                    line(&[foot, head])
                );
                let is_right = head[0] > 0.6 * self.size_px[0];
                let (x, anchor) = match is_right {
                    true => (head[0] - 4.0, "end"),
                    false => (head[0] + 4.0, "start"),
                };
                let attributes =
                    format!(" class=\"et halo\" font-size=\"10.5\" text-anchor=\"{anchor}\"");
                *out += &text([x, head[1] + 20.0], &attributes, &shortened(name, 18));
            }
            ChartMark::Ring { at, name } => {
                let [x, y] = self.at(*at);
                let _ = write!(
                    out,
                    "<circle class=\"ep\" cx=\"{}\" cy=\"{}\" r=\"3.4\"/>",
                    px(x),
                    px(y)
                );
                let is_right = x > 0.6 * self.size_px[0];
                let (x, y, anchor) = match is_right {
                    true => (x - 7.0, y - 6.0, "end"),
                    false => (x + 8.0, y + 12.0, "start"),
                };
                let attributes =
                    format!(" class=\"et halo\" font-size=\"11\" text-anchor=\"{anchor}\"");
                *out += &text([x, y], &attributes, &shortened(name, 22));
            }
        }
    }
}

/// Numbers that people count in within a range, about so many, and how many decimals they have.
fn ticks([from, to]: [f64; 2], about: f64) -> (Vec<f64>, usize) {
    let span = to - from;
    if !(span > 0.0 && span.is_finite()) {
        return (vec![from], 2);
    }
    let rough = span / about;
    let power = 10f64.powf(rough.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|of| of * power);
    let step = steps.into_iter().find(|step| *step >= rough * 0.99);
    let step = step.unwrap_or(10.0 * power);
    let [first, last] = [(from / step - 1e-6).ceil(), (to / step + 1e-6).floor()];
    // Not so of spans that rounding makes nothing of either.
    let is_sane = last - first < 4.0 * about && first.abs() < 1e15;
    if !is_sane {
        return (vec![from], 2);
    }
    let (first, last) = (first as i64, last as i64);
    let decimals = (-(step * 1.000_001).log10().floor()).clamp(0.0, 9.0) as usize;
    let all = (first..=last).map(|index| index as f64 * step);
    (all.collect(), decimals)
}

/// A range from zero to a little more than the greatest.
pub(super) fn from_zero(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let greatest = values.filter(|value| value.is_finite()).fold(0.0, f64::max);
    [0.0, if greatest > 0.0 { 1.12 * greatest } else { 1.0 }]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_numbers_that_people_count_in() {
        assert_eq!(
            ticks([0.0, 1.0], 5.0),
            (vec![0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0], 1)
        );
        assert_eq!(ticks([0.0, 23.0], 3.0), (vec![0.0, 10.0, 20.0], 0));
        assert_eq!(ticks([-0.003, 0.004], 3.0).1, 3);
        assert_eq!(ticks([2.0, 2.0], 3.0).0, [2.0]);
        assert_eq!(ticks([0.0, f64::NAN], 3.0).0, [0.0]);
        assert_eq!(ticks([0.0, 5e-324], 3.0).0, [0.0]);
        assert!((1..6).contains(&ticks([1e300, 1.0000001e300], 3.0).0.len()));
    }

    #[test]
    fn points_are_where_the_axes_say() {
        let chart = Chart {
            size_px: [144.0 + 12.0, 134.0],
            across: [0.0, 2.0],
            up: [0.0, 10.0],
            axes: ["s", "mm"],
            label: "a <b>".to_owned(),
            marks: vec![ChartMark::Series {
                points: vec![[0.0, 0.0], [2.0, 10.0]],
                classes: ["b0".to_owned(), "b0".to_owned()],
            }],
        };
        assert_eq!(chart.at([0.0, 0.0]), [44.0, 110.0]);
        assert_eq!(chart.at([2.0, 10.0]), [144.0, 10.0]);
        let element = chart.element();
        assert!(element.contains("d=\"M44 110L144 10\"") && element.contains("a &lt;b&gt;"));
        assert!(roxmltree::Document::parse(&element).is_ok());
        assert_eq!(from_zero([1.0, f64::NAN].into_iter()), [0.0, 1.12]);
        assert_eq!(from_zero([].into_iter()), [0.0, 1.0]);
    }
}
