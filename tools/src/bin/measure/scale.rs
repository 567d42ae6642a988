//! From a quantity to a place on paper, and what is written along the axis.

use crate::figure::Axis;

/// An axis on paper.
pub struct Scale {
    logarithmic: bool,
    /// Least and greatest, of the logarithm where the axis is logarithmic.
    range: [f64; 2],
    /// Where these are on paper.
    paper: [f64; 2],
}

/// A line of the grid.
pub struct Tick {
    /// Where it is on paper.
    pub at: i32,
    /// What is written there.
    pub label: String,
    /// Whether it is drawn lightly.
    pub minor: bool,
}

impl Scale {
    /// One that holds all of these; `paper` is where its ends are.
    pub fn new(axis: &Axis, values: impl Iterator<Item = f64>, paper: [f64; 2]) -> Self {
        let logarithmic = axis.logarithmic;
        let usable = values.filter(|v| v.is_finite() && (!logarithmic || *v > 0.0));
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in usable {
            let value = if logarithmic { value.log10() } else { value };
            (least, greatest) = (least.min(value), greatest.max(value));
        }
        if !axis.names.is_empty() {
            (least, greatest) = (-0.5, axis.names.len() as f64 - 0.5);
        } else if least > greatest {
            (least, greatest) = (0.0, 1.0);
        } else {
            let margin = 0.05 * (greatest - least);
            let margin = match (margin > 0.0, logarithmic) {
                (true, true) => margin.max(0.1),
                (true, false) => margin,
                (false, true) => 0.5,
                (false, false) => 0.5 * least.abs().max(1.0),
            };
            // A quantity that is never negative keeps its zero where it comes near it.
            let keeps_zero = !logarithmic && least >= 0.0 && least < 0.4 * greatest;
            least = if keeps_zero { 0.0 } else { least - margin };
            greatest += margin;
        }
        Self {
            logarithmic,
            range: [least, greatest],
            paper,
        }
    }

    /// Where a value is on paper; what is beyond an end, or no number, at that end. Not a number
    /// counts as beyond the upper end.
    pub fn at(&self, value: f64) -> i32 {
        let value = match (self.logarithmic, value > 0.0) {
            (true, true) => value.log10(),
            (true, false) if value <= 0.0 => f64::NEG_INFINITY,
            _ => value,
        };
        let [least, greatest] = self.range;
        let value = if value.is_nan() { greatest } else { value };
        self.place(value.clamp(least, greatest))
    }

    fn place(&self, value: f64) -> i32 {
        let [least, greatest] = self.range;
        let share = (value - least) / (greatest - least);
        (self.paper[0] + share * (self.paper[1] - self.paper[0])).round() as i32
    }

    /// Lines of the grid: powers of ten, or 1, 2 and 5 of them where few powers are in sight.
    pub fn ticks(&self, axis: &Axis) -> Vec<Tick> {
        if !axis.names.is_empty() {
            let names = axis.names.iter().enumerate();
            return names
                .map(|(index, name)| Tick {
                    at: self.place(index as f64),
                    label: name.clone(),
                    minor: false,
                })
                .collect();
        }
        if self.logarithmic {
            self.powers()
        } else {
            self.steps()
        }
    }

    fn powers(&self) -> Vec<Tick> {
        let [least, greatest] = self.range;
        let decades = greatest - least;
        let stride = (decades / 9.0).ceil().max(1.0) as i32;
        let all_plain = least > -3.2 && greatest < 4.2;
        let mut ticks = Vec::new();
        for power in least.floor() as i32..=greatest.ceil() as i32 {
            for digit in 1..10_u8 {
                let value = f64::from(power) + f64::from(digit).log10();
                if value < least - 1e-9 || value > greatest + 1e-9 {
                    continue;
                }
                let is_power = digit == 1;
                let plain = decades < 2.5 && matches!(digit, 1 | 2 | 5);
                let label = match () {
                    () if plain || all_plain && is_power => plainly(digit, power),
                    () if is_power && power.rem_euclid(stride) == 0 => power_of_ten(power),
                    () => String::new(),
                };
                if is_power || plain || decades < 4.0 {
                    ticks.push(Tick {
                        at: self.place(value),
                        minor: label.is_empty(),
                        label,
                    });
                }
            }
        }
        ticks
    }

    fn steps(&self) -> Vec<Tick> {
        let [least, greatest] = self.range;
        let rough = (greatest - least) / 6.0;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|digit| digit * power)
            .find(|step| *step >= rough * 0.999)
            .unwrap_or(10.0 * power);
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        let (first, last) = (
            (least / step).ceil() as i64,
            (greatest / step).floor() as i64,
        );
        (first..=last)
            .map(|index| Tick {
                at: self.place(index as f64 * step),
                label: format!("{:.decimals$}", index as f64 * step + 0.0),
                minor: false,
            })
            .collect()
    }
}

/// 0.002, 0.5, 20, 5000; beyond, as powers.
fn plainly(digit: u8, power: i32) -> String {
    match (power, digit) {
        (-3..=4, _) => {
            let decimals = (-power).max(0) as usize;
            format!("{:.decimals$}", f64::from(digit) * 10f64.powi(power))
        }
        (_, 1) => power_of_ten(power),
        _ => format!("{digit}·{}", power_of_ten(power)),
    }
}

/// 10⁻³.
fn power_of_ten(power: i32) -> String {
    const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digits = power.to_string();
    let raised = digits.chars().map(|c| match c.to_digit(10) {
        Some(digit) => RAISED[digit as usize],
        None => '⁻',
    });
    format!("10{}", raised.collect::<String>())
}
