//! What independent checks found, and how the motion goes on.

use std::fmt::Write;

use crate::cli::output::push_line;
use crate::report::units::{angle, length, seconds};
use crate::report::{EstimateReport, LieLine, SpreadLine};

/// What independent checks found, and how the motion goes on.
pub(super) fn checks(report: &EstimateReport) -> String {
    let mut text = String::new();
    if let Some(checked) = &report.verification {
        let overlap = match &checked.deepest {
            Some(deepest) => format!(
                "{} is {} inside {} at {}",
                deepest.body,
                length(deepest.depth_m),
                deepest.against,
                seconds(deepest.time_s)
            ),
            None => format!("no overlap beyond {}", length(checked.tolerance_m)),
        };
        let mut line = format!("  checked   {overlap}");
        for wrong in &checked.wrong_features {
            let _ = write!(
                line,
                "; at {} {} leads {} by {}",
                wrong.event,
                wrong.found.as_deref().unwrap_or("an unnamed part"),
                wrong.expected.join(", "),
                length(wrong.lead_m)
            );
        }
        if checked.simplified_m > checked.tolerance_m {
            let deep = length(checked.simplified_m);
            let _ = write!(line, "; about touching features shapes go {deep} deeper");
        }
        push_line(&mut text, line);
        if let Some(shot) = &checked.single_shot {
            let mut line = format!(
                "            simulated from its first state it ends within {}, {}",
                length(shot.position_m),
                angle(shot.orientation_rad)
            );
            if !checked.restarts.is_empty() {
                let _ = write!(line, ", begun anew after {}", checked.restarts.join(", "));
            }
            push_line(&mut text, line);
        }
    }
    if let Some(settled) = &report.settled {
        let took = seconds(settled.end_s - settled.from_s);
        let how = match settled.at_rest {
            true => "at rest",
            false => "still moving",
        };
        let _ = match settled.is_predicted {
            true => writeln!(text, "  predicted {how} {took} after the last sample used"),
            false => writeln!(
                text,
                "  settled   {how} {took} after the end, by simulation"
            ),
        };
    }
    if let Some(settled) = report.settled.as_ref().filter(|of| of.is_predicted) {
        match &settled.spread {
            Some(spread) => text += &spread_text(spread),
            None => push_line(
                &mut text,
                "            how far that may be off is not known",
            ),
        }
    }
    if let Some(rest) = &report.rest {
        for lie in &rest.goals {
            push_line(&mut text, format!("  rest      {}", lying(lie)));
        }
        if rest.tried > 0 {
            let _ = writeln!(
                text,
                "            {} motions near the best tried, objective {:.1} against its {:.1}",
                rest.tried, report.objective, rest.best_objective
            );
        }
    }
    text
}

/// How far a prediction may be off.
fn spread_text(spread: &SpreadLine) -> String {
    let mut text = String::new();
    for of in &spread.bodies {
        let [x, y, z] = of.median_m;
        let up = of
            .up
            .iter()
            .map(|of| format!("{} {:.0} %", of.up, 100.0 * of.share));
        push_line(
            &mut text,
            format!(
                "  spread    {}: 90 % within {} of ({x:.3}, {y:.3}, {z:.3}) m; up: {}",
                of.body,
                length(of.radius_m),
                up.collect::<Vec<_>>().join(", ")
            ),
        );
    }
    let moving = spread.draws - spread.at_rest;
    let moving = match moving {
        0 => String::new(),
        moving => format!(", {moving} of them still moving at the end"),
    };
    push_line(
        &mut text,
        format!("            of {} predictions{moving}", spread.draws),
    );
    if !spread.exact.is_empty() {
        push_line(
            &mut text,
            format!(
                "            material of {} taken as exact: most of what it may be off is left out (friction_sd, restitution_sd)",
                spread.exact.join(", ")
            ),
        );
    }
    text
}

/// How a body lies, against what was asked.
fn lying(lie: &LieLine) -> String {
    let found = if lie.is_met {
        format!("{} up as asked, {} off", lie.asked, angle(lie.angle_rad))
    } else if lie.is_still {
        format!("{} up, asked for {}", lie.face_up, lie.asked)
    } else {
        format!("not at rest, asked for {} up", lie.asked)
    };
    let labels = lie.labels_wxyz.map_or_else(String::new, |[w, x, y, z]| {
        format!("; its labels turned from those acted by wxyz {w:.3}, {x:.3}, {y:.3}, {z:.3}")
    });
    format!("{}: {found}{labels}", lie.body)
}
