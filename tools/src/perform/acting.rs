//! The knobs of a performance.

use enact::motion::Stamp;
use serde::Serialize;

/// The knobs. The wanders are the rms length of the whole displacement and angle; standard
/// deviations of noise are per axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Acting {
    /// Acted time per physical time, on the whole.
    pub slowdown: f64,
    /// Standard deviation of the logarithm of the tempo, which varies smoothly.
    pub tempo_variation: f64,
    /// Smooth wander of the centre of mass: rms distance \[m\].
    pub wander_position_m: f64,
    /// Smooth wander of the orientation: rms angle \[rad\].
    pub wander_orientation_rad: f64,
    /// Factor on both wanders.
    pub distortion: f64,
    /// Seconds of the hand's wander per second of acted time: 1, or the slowdown that a motion
    /// acted at full speed is to look as if it had.
    pub wander_pace: f64,
    /// How the hand rounds the kinks of its path at impacts: standard deviation of a Gaussian
    /// [s, acted, as it is the hand's and not the motion's]; 0: not at all. Edited sketches have none.
    #[serde(skip_serializing_if = "is_zero")]
    pub kink_s: f64,
    /// White noise of the tracker's position \[m\].
    pub noise_position_m: f64,
    /// White noise of the tracker's orientation \[rad\].
    pub noise_orientation_rad: f64,
    /// The tracker rounds to this \[m\]; 0: not at all.
    pub resolution_m: f64,
    /// The tracker rounds the components of its quaternions to this, then normalises; 0: not.
    pub resolution_quaternion: f64,
    /// Samples per second of acted time.
    pub rate_hz: f64,
    /// Error of the stamps \[s\], at most 0.45 of the sampling interval.
    pub stamp_jitter_s: f64,
    /// Share of the samples that are lost, in bursts.
    pub dropout_rate: f64,
    /// Mean length of a burst of lost samples.
    pub dropout_burst: f64,
    /// Readings that are wrong altogether, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outliers: Option<Outliers>,
    /// Error of the performer's marks [s, acted]: a normal distribution cut off at twice this.
    pub mark_error_s: f64,
    /// Whether marks name their events.
    pub marks_named: bool,
    /// How long the performer holds still before the motion [s, acted].
    pub hold_before_s: f64,
    /// How long the performer holds still after it [s, acted].
    pub hold_after_s: f64,
    /// From measurement to arrival \[s\].
    pub latency_s: f64,
    /// When acting begins.
    #[serde(skip)]
    pub start: Stamp,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// Readings that are wrong altogether: in bursts of one to three, half of them by the same jump,
/// in position, in orientation or in both.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Outliers {
    /// Share of the samples, below a half.
    pub share: f64,
    /// Least and greatest jump \[m\], uniform in the logarithm.
    pub position_m: [f64; 2],
    /// Least and greatest turn \[rad\], uniform in the logarithm.
    pub orientation_rad: [f64; 2],
}

impl Outliers {
    /// Jumps of 5 cm to 3 m and turns of 20° to 180°.
    pub fn of_share(share: f64) -> Self {
        Self {
            share,
            position_m: [0.05, 3.0],
            orientation_rad: [20_f64.to_radians(), std::f64::consts::PI],
        }
    }

    fn check(&self) -> Result<(), String> {
        if !(self.share >= 0.0 && self.share < 0.5) {
            return Err(format!(
                "share of outliers is {}, expected 0 to below 0.5",
                self.share
            ));
        }
        for (name, [least, greatest]) in [
            ("position_m", self.position_m),
            ("orientation_rad", self.orientation_rad),
        ] {
            if !(least > 0.0 && least <= greatest && greatest.is_finite()) {
                return Err(format!(
                    "{name} of outliers is {least} to {greatest}, expected positive numbers in order"
                ));
            }
        }
        Ok(())
    }
}

/// 2026-01-05 10:00:00 UTC [ns since 1970].
pub const START: Stamp = Stamp(1_767_607_200_000_000_000);

impl Default for Acting {
    fn default() -> Self {
        Self {
            slowdown: 2.5,
            tempo_variation: 0.3,
            wander_position_m: 0.02,
            wander_orientation_rad: 8_f64.to_radians(),
            distortion: 1.0,
            wander_pace: 1.0,
            kink_s: 0.0,
            noise_position_m: 0.0005,
            noise_orientation_rad: 0.3_f64.to_radians(),
            resolution_m: 1e-7,
            resolution_quaternion: 1e-9,
            rate_hz: 120.0,
            stamp_jitter_s: 0.0005,
            dropout_rate: 0.01,
            dropout_burst: 3.0,
            outliers: None,
            mark_error_s: 0.03,
            marks_named: false,
            hold_before_s: 0.0,
            hold_after_s: 0.0,
            latency_s: 0.004,
            start: START,
        }
    }
}

impl Acting {
    /// Stamps are physical times, marks are within a sample, nothing is lost; the hand wanders
    /// as in the slow performance, compressed.
    pub fn timing_known() -> Self {
        let slow = Self::default();
        Self {
            slowdown: 1.0,
            tempo_variation: 0.0,
            wander_pace: slow.slowdown,
            stamp_jitter_s: 0.0,
            dropout_rate: 0.0,
            mark_error_s: 0.5 / slow.rate_hz,
            ..slow
        }
    }

    /// As an editing interface leaves it: at full speed, with stamps of a clock and no tracker
    /// that loses sight; each segment's time is off by a few per cent.
    pub fn edited() -> Self {
        Self {
            tempo_variation: 0.05,
            latency_s: 0.0,
            ..Self::timing_known()
        }
    }

    /// The truth itself, at full speed, through a perfect tracker.
    pub fn exact() -> Self {
        Self {
            distortion: 0.0,
            noise_position_m: 0.0,
            noise_orientation_rad: 0.0,
            resolution_m: 0.0,
            resolution_quaternion: 0.0,
            mark_error_s: 0.0,
            ..Self::timing_known()
        }
    }

    /// Whether stamps mean physical time.
    pub fn is_timing_known(&self) -> bool {
        self.slowdown == 1.0 && self.tempo_variation == 0.0
    }

    /// Says which knob is out of its range.
    pub fn check(&self) -> Result<(), String> {
        let positive = [
            ("slowdown", self.slowdown),
            ("wander_pace", self.wander_pace),
            ("rate_hz", self.rate_hz),
        ];
        let not_negative = [
            ("tempo_variation", self.tempo_variation),
            ("wander_position_m", self.wander_position_m),
            ("wander_orientation_rad", self.wander_orientation_rad),
            ("distortion", self.distortion),
            ("kink_s", self.kink_s),
            ("noise_position_m", self.noise_position_m),
            ("noise_orientation_rad", self.noise_orientation_rad),
            ("resolution_m", self.resolution_m),
            ("resolution_quaternion", self.resolution_quaternion),
            ("stamp_jitter_s", self.stamp_jitter_s),
            ("mark_error_s", self.mark_error_s),
            ("hold_before_s", self.hold_before_s),
            ("hold_after_s", self.hold_after_s),
            ("latency_s", self.latency_s),
        ];
        for (name, value) in positive {
            if !(value > 0.0 && value.is_finite()) {
                return Err(format!("{name} is {value}, expected a positive number"));
            }
        }
        for (name, value) in not_negative {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(format!(
                    "{name} is {value}, expected zero or a positive number"
                ));
            }
        }
        if !(self.dropout_rate >= 0.0 && self.dropout_rate < 1.0) {
            return Err(format!(
                "dropout_rate is {}, expected 0 to below 1",
                self.dropout_rate
            ));
        }
        if !(self.dropout_burst >= 1.0 && self.dropout_burst.is_finite()) {
            return Err(format!(
                "dropout_burst is {}, expected 1 or more",
                self.dropout_burst
            ));
        }
        if let Some(outliers) = &self.outliers {
            outliers.check()?;
        }
        Ok(())
    }

    /// What the clock says at an acted time [s since the motion began].
    pub(super) fn stamp(&self, acted_s: f64) -> Stamp {
        Stamp(self.start.0 + ((acted_s + self.hold_before_s) * 1e9).round() as i64)
    }
}
