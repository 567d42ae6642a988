//! The one place where a table's reader says what it takes for granted: a line each, what is assumed, why, and the flag
//! for another.

use super::axes::Preset;
use super::layout::{BodyColumns, Orientation, TableLayout};
use super::poses::{MarkColumn, TableOptions};
use super::turn::Turn;
use super::units::{AngleUnit, length_name};
use crate::motion::LengthUnit;

/// Most names that a line lists.
const LISTED: usize = 8;

/// What is to be known of how a table was read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Said {
    /// Assumptions, and what is left aside.
    pub(super) notes: Vec<String>,
    /// What speaks against an assumption.
    pub(super) against: Vec<String>,
}

impl Said {
    pub(super) fn note(&mut self, line: impl Into<String>) {
        self.notes.push(line.into());
    }

    pub(super) fn against(&mut self, line: impl Into<String>) {
        self.against.push(line.into());
    }

    /// The columns that are not read; of those that look like an orientation, none may be left aside where
    /// points are taken.
    pub(super) fn unread(
        &mut self,
        layout: &TableLayout,
        options: &TableOptions,
        looks_turned: impl Fn(&str) -> bool,
    ) {
        let is_button = |name: &&String| {
            let mut buttons = options.mark_columns.iter();
            buttons.any(|of| of.is_named(name))
        };
        let unread = layout.unread.iter().filter(|name| !is_button(name));
        let unread: Vec<String> = unread.cloned().collect();
        if unread.is_empty() {
            return;
        }
        let buttons = unread.iter().filter(|name| MarkColumn::may_be(name));
        let buttons: Vec<String> = buttons.cloned().collect();
        let as_marks = match &buttons[..] {
            [] => String::new(),
            [first, ..] => format!(
                "; --mark-column makes marks of {}, such as --mark-column {first:?}",
                listed(&buttons)
            ),
        };
        self.note(format!("columns not read: {}{as_marks}", listed(&unread)));
        let are_points = layout
            .bodies
            .iter()
            .any(|of| of.orientation == Orientation::Unseen);
        // Robots' A, B, C.
        let has = |letter: &str| {
            layout
                .unread
                .iter()
                .any(|of| of.trim().eq_ignore_ascii_case(letter))
        };
        let is_abc = |of: &str| {
            ["a", "b", "c"]
                .iter()
                .any(|letter| of.trim().eq_ignore_ascii_case(letter))
        };
        let are_abc = has("a") && has("b") && has("c");
        let is_turned = |of: &&String| looks_turned(of) || (are_abc && is_abc(of));
        let turned: Vec<String> = layout.unread.iter().filter(is_turned).cloned().collect();
        if are_points && !turned.is_empty() {
            self.against(format!(
                "columns that look like an orientation are not read: {}; expected qx, qy, qz, qw, or rx, ry, rz, or \
                 roll, pitch, yaw in their places of --columns",
                listed(&turned)
            ));
        }
    }

    /// In which order the numbers of quaternions are.
    pub(super) fn order(&mut self, layout: &TableLayout) {
        let named = layout.bodies.iter().filter(|_| layout.is_order_named);
        if let Some(order) = { named }.find_map(|body| body.orientation.order()) {
            self.note(format!(
                "quaternions are {order}, as their columns are named"
            ));
        }
    }

    /// Which unit positions are in.
    pub(super) fn length(
        &mut self,
        unit: LengthUnit,
        layout: &TableLayout,
        options: &TableOptions,
        preset: &Preset,
    ) {
        let name = length_name(unit);
        self.note(if options.length_unit.is_some() {
            format!("positions are in {name}, as --length-unit says")
        } else if layout.length.is_some() {
            format!("positions are in {name}, as the file says")
        } else if options.preset.is_some() || layout.preset.is_some() {
            format!(
                "positions are taken for {name}, as usual for {} (--length-unit for others)",
                preset.name
            )
        } else {
            format!(
                "positions are taken for {name}: the file does not say (--length-unit for others)"
            )
        });
    }

    /// Which axis is up.
    pub(super) fn axes(&mut self, layout: &TableLayout, options: &TableOptions, preset: &Preset) {
        if options.preset.is_some() {
            return self.note(format!(
                "axes are those of --from {}: {}",
                preset.name, preset.about
            ));
        }
        self.note(match layout.preset {
            Some(_) => format!("axes are taken as in {} (--from for others)", preset.about),
            None => "axes are taken for right-handed with z up: the file does not say (--from for others)".to_owned(),
        });
    }

    /// What three angles mean: as a user says, as a format has it, or by their names.
    pub(super) fn angles(&mut self, turn: &Turn, is_given: bool, is_format: bool, preset: &Preset) {
        let why = match (is_given, is_format) {
            (true, _) => "as --rotation says",
            (false, true) => "as its format has them (--rotation for others)",
            (false, false) => "by their names (--rotation for others)",
        };
        self.note(format!("angles are {}: {}, {why}", turn.name, turn.about));
        if !is_given && !is_format && turn != Turn::VECTOR && !preset.keeps_axes() {
            self.against(format!(
                "roll, pitch and yaw are taken about x, y and z of a world whose z is not up ({}): expected --rotation, or \
                 quaternions",
                preset.name
            ));
        }
    }

    /// In which unit angles are, and why.
    pub(super) fn angle_unit(&mut self, unit: AngleUnit, why: &str) {
        self.note(format!("angles are in {}, {why}", unit.name()));
    }

    /// Whether several bodies are in a row.
    pub(super) fn bodies(&mut self, bodies: &[BodyColumns]) {
        let points = bodies
            .iter()
            .filter(|of| of.orientation == Orientation::Unseen)
            .count();
        if bodies.len() > 1 {
            self.note(format!(
                "{} bodies side by side: {} with poses, {points} with points",
                bodies.len(),
                bodies.len() - points
            ));
        }
    }
}

/// Names in a row, and how many more there are.
pub(super) fn listed(names: &[String]) -> String {
    let shown = names.len().min(LISTED);
    let more = match names.len() - shown {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("{}{more}", names[..shown].join(", "))
}
