//! Where things are on a picture, and how large it is.

use super::super::svg::{line, loops, width_em};
use crate::visual::simplified;

/// Around what is drawn, in pixels.
const MARGIN_PX: f64 = 26.0;

/// Below it there is room for the axes and the scale, in pixels.
const FOOT_PX: f64 = 44.0;

/// Least and greatest height of what is drawn, as a part of the width.
const HEIGHTS: [f64; 2] = [0.3, 0.72];

/// How far off a line may be, in pixels.
pub(super) const TOLERANCE_PX: f64 = 0.25;

/// The size of names, in pixels.
pub(super) const FONT_PX: f64 = 12.0;

/// How large a picture is, in its own pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Size {
    /// So wide, and as high as what is on it.
    Fitted {
        /// Its width.
        width_px: f64,
    },
    /// So wide and so high.
    Fixed {
        /// Both.
        size_px: [f64; 2],
    },
}

/// What a picture is to be.
#[derive(Clone, Copy)]
pub(super) struct LayoutFrame {
    pub size: Size,
    /// Whether it has to explain itself.
    pub is_alone: bool,
    /// Whether it has the motion to be played, too.
    pub plays: bool,
}

/// Where things are on the picture.
pub(super) struct Scale {
    left_m: f64,
    top_m: f64,
    pub(super) px_per_m: f64,
    offset_px: [f64; 2],
}

impl Scale {
    pub(super) fn at(&self, [x_m, y_m]: [f64; 2]) -> [f64; 2] {
        [
            self.offset_px[0] + (x_m - self.left_m) * self.px_per_m,
            self.offset_px[1] + (self.top_m - y_m) * self.px_per_m,
        ]
    }

    pub(super) fn all(&self, points_m: &[[f64; 2]]) -> Vec<[f64; 2]> {
        points_m.iter().map(|point_m| self.at(*point_m)).collect()
    }

    pub(super) fn closed(&self, lines_m: &[Vec<[f64; 2]>]) -> String {
        let tolerance_m = TOLERANCE_PX / self.px_per_m;
        let lines = lines_m
            .iter()
            .map(|of| self.all(&simplified(of, tolerance_m)));
        let lines: Vec<Vec<[f64; 2]>> = lines.collect();
        loops(&lines)
    }
}

/// How large what is to be seen is drawn, and how large the picture is.
pub(super) fn fitted([across_m, high_m]: [[f64; 2]; 2], frame: LayoutFrame) -> (Scale, [f64; 2]) {
    let [width_m, height_m] = [across_m, high_m].map(|[from, to]| (to - from).max(1e-4));
    let foot_px = FOOT_PX + if frame.is_alone { 22.0 } else { 0.0 };
    let (width_px, [least_px, most_px]) = match frame.size {
        Size::Fitted { width_px } => (width_px, HEIGHTS.map(|part| part * width_px)),
        Size::Fixed {
            size_px: [width_px, height_px],
        } => (width_px, [height_px - foot_px; 2]),
    };
    let room_px = width_px - 2.0 * MARGIN_PX;
    let px_per_m = (room_px / width_m).min((most_px - 2.0 * MARGIN_PX) / height_m);
    let drawn_px = [width_m, height_m].map(|of_m| of_m * px_per_m);
    let inner_px = (drawn_px[1] + 2.0 * MARGIN_PX).clamp(least_px, most_px);
    let scale = Scale {
        left_m: across_m[0],
        top_m: high_m[1],
        px_per_m,
        offset_px: [
            0.5 * (width_px - drawn_px[0]),
            0.5 * (inner_px - drawn_px[1]),
        ],
    };
    (scale, [width_px, inner_px + foot_px])
}

/// Short strokes on one side of a line within the picture.
pub(super) fn hatches(
    from: [f64; 2],
    to: [f64; 2],
    below: [f64; 2],
    [width, height]: [f64; 2],
) -> String {
    let along = [to[0] - from[0], to[1] - from[1]];
    let length = along[0].hypot(along[1]).max(1e-9);
    let unit = along.map(|part| part / length);
    let mut data = String::new();
    for stroke in 0..(length / 9.0).min(1e4) as usize {
        let far = 9.0 * (stroke as f64 + 0.5);
        let at = [from[0] + unit[0] * far, from[1] + unit[1] * far];
        if !(0.0..=width).contains(&at[0]) || !(0.0..=height).contains(&at[1]) {
            continue;
        }
        let end = [
            at[0] + 7.0 * below[0] - 5.0 * unit[0],
            at[1] + 7.0 * below[1] - 5.0 * unit[1],
        ];
        data += &line(&[at, end]);
    }
    data
}

/// The area of two rectangles that is of both.
fn common(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    let width = a[2].min(b[2]) - a[0].max(b[0]);
    let height = a[3].min(b[3]) - a[1].max(b[1]);
    width.max(0.0) * height.max(0.0)
}

/// Where a text is near a place: not over what is taken if there is any such place, and where it may be over
/// little of what is covered. Left, top, right and bottom.
pub(super) fn spot(
    place: [f64; 2],
    words: &str,
    [width, height]: [f64; 2],
    [taken, covered]: [&[[f64; 4]]; 2],
) -> [f64; 4] {
    let size = [FONT_PX * width_em(words), FONT_PX + 4.0];
    let area = size[0] * size[1];
    let mut best: Option<(f64, [f64; 4])> = None;
    for distance in [8.0, 18.0, 32.0, 52.0, 78.0, 110.0, 150.0] {
        for [x, y] in [
            [1.0, 0.0],
            [-1.0, 0.0],
            [0.7, -0.7],
            [-0.7, -0.7],
            [0.7, 0.7],
            [-0.7, 0.7],
            [0.0, -1.0],
            [0.0, 1.0],
        ] {
            let middle = [
                place[0] + x * (distance + 0.5 * size[0]),
                place[1] + y * (distance + 0.5 * size[1]),
            ];
            let left = (middle[0] - 0.5 * size[0]).clamp(4.0, (width - size[0] - 4.0).max(4.0));
            let top = (middle[1] - 0.5 * size[1]).clamp(4.0, (height - size[1] - 4.0).max(4.0));
            let here = [left, top, left + size[0], top + size[1]];
            let over = taken.iter().map(|other| common(&here, other)).sum::<f64>() / area;
            let hides = covered
                .iter()
                .map(|other| common(&here, other))
                .sum::<f64>()
                / area;
            let cost = 1e3 * over + 25.0 * hides.min(3.0) + distance;
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, here));
            }
        }
    }
    best.map_or([place[0], place[1], place[0], place[1]], |(_, here)| here)
}

/// The greatest length that people count in below another \[m\].
pub(super) fn scale_length_m(most_m: f64) -> f64 {
    let power = 10f64.powf(most_m.log10().floor());
    let nice = [5.0, 2.0, 1.0].map(|of| of * power);
    nice.into_iter()
        .find(|length_m| *length_m <= most_m)
        .unwrap_or(power)
}
