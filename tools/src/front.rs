//! What was measured of the flows, and whether anything is at once faster and as exact as what
//! the program does. `tests/house/charts.rs` reads the numbers with this file.

use serde::{Deserialize, Serialize};

/// A body, how it begins to turn, and what became of it.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Turning {
    /// Name in files.
    pub name: String,
    /// In words.
    pub title: String,
    /// [kg m²].
    pub moments: [f64; 3],
    /// [rad/s, body].
    pub omega: [f64; 3],
    /// Class of the body, as the program tells it.
    pub class: String,
    /// What the program does for that class.
    pub chosen: String,
    /// By use and duration.
    pub tasks: Vec<Task>,
}

/// One duration, asked for once or sample by sample.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Task {
    /// Times asked for, evenly up to the duration.
    pub samples: usize,
    /// \[s\].
    pub duration_s: f64,
    /// What half a rounding of the first angular velocity makes of the rotation \[rad\],
    pub condition_rad: f64,
    /// and of its derivative, relative.
    pub condition_derivative: f64,
    /// By how much the reference and a second method to thirty digits differ: rotation \[rad\],
    /// derivative, relative.
    pub reference: [f64; 2],
    /// Every method and setting.
    pub points: Vec<Point>,
}

/// A method and a setting.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Point {
    /// Its name, as in the legend of the chart.
    pub method: String,
    /// Its tolerance or size of step, in words.
    pub setting: String,
    /// Whether it is what the program does for this body.
    pub is_ours: bool,
    /// Of the rotation at the end \[rad\]; none where it is no number.
    pub error_rad: Option<f64>,
    /// Of its derivative by the first angular velocity, relative; none where it is no number.
    pub derivative_error: Option<f64>,
    /// Per time asked for, with derivatives: the fastest run and the median of all \[s\]. Whatever
    /// else the machine does makes a run slower, never faster.
    pub fastest_s: f64,
    /// The median of all runs, per time asked for \[s\].
    pub median_s: f64,
}

/// A rotation that is off by more than this is no answer \[rad\].
const FAILED_RAD: f64 = 0.1;

impl Point {
    /// Whether it gave no answer.
    pub fn failed(&self) -> bool {
        let good = |error: Option<f64>, most: f64| error.is_some_and(|error| error < most);
        !(good(self.error_rad, FAILED_RAD) && good(self.derivative_error, 1.0))
    }
}

impl Task {
    /// Errors that are rounding, of the rotation and of its derivative: eight times what half a
    /// rounding of the start makes, and ten roundings.
    pub fn rounding(&self) -> [f64; 2] {
        [self.condition_rad, self.condition_derivative].map(|made| 8.0 * made + 2e-15)
    }

    /// The program's own.
    pub fn ours(&self) -> &Point {
        let ours = self.points.iter().find(|point| point.is_ours);
        ours.expect("the program was measured")
    }

    /// What is as exact as the program, to rounding, and faster by more than the spread: its median
    /// run than the program's fastest.
    pub fn as_exact_and_faster(&self) -> Vec<&Point> {
        let ours = self.ours();
        let [rotation, derivative] = self.rounding();
        let as_exact = |error: Option<f64>, own: Option<f64>, rounding: f64| {
            let most = own.unwrap_or(f64::INFINITY).max(rounding);
            error.is_some_and(|error| error <= most)
        };
        let is_ahead = |point: &&Point| {
            !point.is_ours
                && !point.failed()
                && point.median_s < ours.fastest_s
                && as_exact(point.error_rad, ours.error_rad, rotation)
                && as_exact(point.derivative_error, ours.derivative_error, derivative)
        };
        self.points.iter().filter(is_ahead).collect()
    }

    /// Those of them that are also more exact in one of the two, by more than rounding: what puts
    /// the program off the front.
    pub fn ahead_of_ours(&self) -> Vec<&Point> {
        let ours = self.ours();
        let [rotation, derivative] = self.rounding();
        let more_exact = |error: Option<f64>, own: Option<f64>, rounding: f64| {
            let own = own.unwrap_or(f64::INFINITY);
            own > rounding && error.is_some_and(|error| error < own - rounding)
        };
        let faster = self.as_exact_and_faster().into_iter();
        let is_ahead = |point: &&Point| {
            more_exact(point.error_rad, ours.error_rad, rotation)
                || more_exact(point.derivative_error, ours.derivative_error, derivative)
        };
        faster.filter(is_ahead).collect()
    }

    /// The fastest of the others among those that are exact to rounding.
    pub fn fastest_exact_other(&self) -> Option<&Point> {
        let [rotation, derivative] = self.rounding();
        let exact = self.points.iter().filter(|point| {
            !point.is_ours
                && point.error_rad.is_some_and(|error| error <= rotation)
                && point
                    .derivative_error
                    .is_some_and(|error| error <= derivative)
        });
        exact.min_by(|a, b| a.fastest_s.total_cmp(&b.fastest_s))
    }
}
