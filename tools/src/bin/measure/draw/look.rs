//! How curves look: a colour and a shape for each.

use plotters::prelude::RGBColor;

use crate::figure::{Curve, Figure, Role};

pub const PAPER: RGBColor = RGBColor(255, 255, 255);
pub const INK: RGBColor = RGBColor(34, 34, 34);
pub const FAINT: RGBColor = RGBColor(90, 90, 90);
pub const GRID: RGBColor = RGBColor(205, 205, 205);
pub const FINE_GRID: RGBColor = RGBColor(236, 236, 236);

/// Okabe and Ito's colours without the yellow, which most colour-blind people tell apart, and
/// darker and lighter ones between them: one for every series of a figure.
const COLOURS: [RGBColor; 14] = [
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(120, 120, 120),
    RGBColor(0, 0, 0),
    RGBColor(115, 60, 140),
    RGBColor(120, 90, 40),
    RGBColor(150, 190, 60),
    RGBColor(0, 90, 80),
    RGBColor(180, 140, 220),
    RGBColor(70, 70, 160),
    RGBColor(190, 30, 90),
];
/// The program's own.
const OURS: RGBColor = RGBColor(213, 94, 0);
const BOUND: RGBColor = RGBColor(60, 60, 60);

/// How a curve looks.
#[derive(Clone, Copy)]
pub struct Look {
    pub colour: RGBColor,
    /// 0 to 4.
    pub shape: usize,
    /// Of its line, in dots.
    pub width: u32,
    /// What it is.
    pub role: Role,
    /// Whether a line joins its points: there is none between things without order.
    pub joins: bool,
}

/// Curve by curve.
pub fn looks(figure: &Figure) -> Vec<Look> {
    let compared = figure
        .curves
        .iter()
        .filter(|curve| curve.role == Role::Compared);
    assert!(
        compared.count() <= COLOURS.len(),
        "{}: too many series",
        figure.name
    );
    let mut next = 0;
    let look = |curve: &Curve| {
        let (colour, width, shape) = match curve.role {
            Role::Ours => (OURS, 3, 0),
            Role::Bound => (BOUND, 1, 0),
            Role::Compared => (COLOURS[next], 2, 1 + next % 4),
        };
        next += usize::from(curve.role == Role::Compared);
        Look {
            colour,
            shape,
            width,
            role: curve.role,
            joins: figure.x.names.is_empty() || figure.x.steps > 0,
        }
    };
    figure.curves.iter().map(look).collect()
}
