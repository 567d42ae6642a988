//! Names beside curves and points.

use plotters::style::text_anchor::{HPos, VPos};

use super::frame::Frame;
use super::ink::{Area, Drawn, Sheet, cross, dashed, line, point, wrapped, write};
use super::look::{FAINT, INK, Look, looks};
use crate::figure::{Curve, Figure, Role};

impl Frame {
    /// The name of a setting beside its point, unless there is no room.
    pub(super) fn name(
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

    /// Names of the curves, beside the plot.
    pub fn legend(&self, sheet: &Sheet, figure: &Figure) -> Drawn {
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
