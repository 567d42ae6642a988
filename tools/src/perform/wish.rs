//! What performance somebody wants, as arguments of a command.
//!
use clap::{Args, ValueEnum};
use enact::motion::Stamp;

use super::{Acting, Outliers, Performance, Style, Truth, bounces, die, hat_box, perform};

/// What is performed, and how.
#[derive(Args)]
pub struct Manner {
    /// The same seed gives the same bytes
    #[arg(long, default_value_t = 7)]
    pub seed: u64,
    /// What the knobs are where they are not given [default: edited for the die, else acted]
    #[arg(long, value_enum)]
    preset: Option<Preset>,
    #[command(flatten)]
    /// Knobs that differ from the preset.
    pub knobs: Knobs,
}

/// The motion of a performance.
#[derive(Clone, Copy)]
pub enum Wanted {
    /// One of those that have a name.
    Motion(Motion),
    /// A cube with that many bounces.
    Bounces(usize),
}

impl Manner {
    /// The performance, and its scene file.
    pub fn perform(&self, wanted: Wanted) -> anyhow::Result<(Performance, String)> {
        let base = match (self.preset, wanted) {
            (Some(Preset::Edited), _) | (None, Wanted::Motion(Motion::Die)) => Acting::edited(),
            (Some(Preset::Acted) | None, _) => Acting::default(),
            (Some(Preset::TimingKnown), _) => Acting::timing_known(),
            (Some(Preset::Exact), _) => Acting::exact(),
        };
        let acting = self.knobs.acting(base);
        acting.check().map_err(anyhow::Error::msg)?;
        let (truth, mut scene_toml) = match wanted {
            Wanted::Bounces(count) => {
                let truth = bounces(count, self.seed)?;
                let scene_toml = bounces::scene_toml(&truth.scene);
                (truth, scene_toml)
            }
            Wanted::Motion(motion) => {
                let (truth, scene_toml) = motion.truth();
                (truth, scene_toml.to_owned())
            }
        };
        if acting.is_timing_known() {
            scene_toml = scene_toml.replace("stamps = \"tempo\"", "stamps = \"physical\"");
            if !truth.scene.goals.is_empty() {
                let (end, free) = ("kind = \"end\"", "kind = \"end\"\ntime = \"free\"");
                scene_toml = scene_toml.replace(end, free);
            }
        }
        Ok((perform(&truth, &acting, self.seed), scene_toml))
    }
}

/// A motion with a name.
#[derive(Clone, Copy, ValueEnum)]
pub enum Motion {
    /// Pencil, tip first, full tumble
    Tip,
    /// Pencil, eraser first, half a tumble
    Eraser,
    /// A hat catches a box in mid-air
    HatBox,
    /// The same with more goals than physics meets
    HatBoxBent,
    /// A die that shows a given face at each of six bounces: an edited sketch
    Die,
}

impl Motion {
    /// The motion and its scene file.
    pub fn truth(self) -> (Truth, &'static str) {
        match self {
            Motion::Tip => (Style::Tip.truth(), Style::Tip.scene_toml()),
            Motion::Eraser => (Style::Eraser.truth(), Style::Eraser.scene_toml()),
            Motion::HatBox => (hat_box::truth(), hat_box::SCENE_TOML),
            Motion::HatBoxBent => (hat_box::bent_reference(), hat_box::BENT_TOML),
            Motion::Die => (die::reference(), die::SCENE_TOML),
        }
    }
}

/// What the knobs are where they are not given.
#[derive(Clone, Copy, ValueEnum)]
pub enum Preset {
    /// Slow and wavering, as a person acts
    Acted,
    /// At full speed: stamps are physical times, marks are within a sample
    TimingKnown,
    /// As an editing interface leaves it: for the die
    Edited,
    /// At full speed, without any error
    Exact,
}

/// Every knob of [`Acting`], in handy units.
#[derive(Args)]
#[command(next_help_heading = "Knobs")]
pub struct Knobs {
    /// Acted time per physical time
    #[arg(long)]
    slowdown: Option<f64>,
    /// Standard deviation of the tempo's logarithm
    #[arg(long)]
    tempo_variation: Option<f64>,
    /// Wander of the position, rms distance
    #[arg(long)]
    wander_position_mm: Option<f64>,
    /// Wander of the orientation, rms angle
    #[arg(long)]
    wander_orientation_deg: Option<f64>,
    /// Factor on both wanders
    #[arg(long)]
    distortion: Option<f64>,
    /// Seconds of the hand's wander per acted second
    #[arg(long)]
    wander_pace: Option<f64>,
    /// Rounding of the path at impacts, standard deviation in acted time; 0: sharp kinks
    #[arg(long)]
    kink_ms: Option<f64>,
    /// White noise of the tracker, per axis
    #[arg(long)]
    noise_position_mm: Option<f64>,
    /// White noise of the tracker, per axis
    #[arg(long)]
    noise_orientation_deg: Option<f64>,
    /// The tracker rounds positions to this; 0: not at all
    #[arg(long)]
    resolution_mm: Option<f64>,
    /// The tracker rounds components of quaternions to this; 0: not at all
    #[arg(long)]
    resolution_quaternion: Option<f64>,
    /// Samples per acted second
    #[arg(long)]
    pub rate_hz: Option<f64>,
    /// Error of the stamps
    #[arg(long)]
    stamp_jitter_ms: Option<f64>,
    /// Share of samples lost
    #[arg(long)]
    dropout_rate: Option<f64>,
    /// Mean length of a burst of lost samples
    #[arg(long)]
    dropout_burst: Option<f64>,
    /// Share of readings that are wrong altogether: jumps of 5 cm to 3 m, turns of 20° to 180°
    #[arg(long)]
    outlier_share: Option<f64>,
    /// Error of the performer's marks
    #[arg(long)]
    mark_error_ms: Option<f64>,
    /// Marks name their events
    #[arg(long)]
    marks_named: bool,
    /// Holding still before the motion
    #[arg(long)]
    hold_before_s: Option<f64>,
    /// Holding still after it
    #[arg(long)]
    hold_after_s: Option<f64>,
    /// From measurement to arrival
    #[arg(long)]
    latency_ms: Option<f64>,
    /// When acting begins [ns since 1970]
    #[arg(long)]
    pub start_ns: Option<i64>,
}

impl Knobs {
    /// `base` with the knobs that are given.
    pub fn acting(&self, base: Acting) -> Acting {
        let or = |given: Option<f64>, scale: f64, base: f64| given.map_or(base, |x| x * scale);
        let degree = 1_f64.to_radians();
        Acting {
            slowdown: or(self.slowdown, 1.0, base.slowdown),
            tempo_variation: or(self.tempo_variation, 1.0, base.tempo_variation),
            wander_position_m: or(self.wander_position_mm, 1e-3, base.wander_position_m),
            wander_orientation_rad: or(
                self.wander_orientation_deg,
                degree,
                base.wander_orientation_rad,
            ),
            distortion: or(self.distortion, 1.0, base.distortion),
            wander_pace: or(self.wander_pace, 1.0, base.wander_pace),
            kink_s: or(self.kink_ms, 1e-3, base.kink_s),
            noise_position_m: or(self.noise_position_mm, 1e-3, base.noise_position_m),
            noise_orientation_rad: or(
                self.noise_orientation_deg,
                degree,
                base.noise_orientation_rad,
            ),
            resolution_m: or(self.resolution_mm, 1e-3, base.resolution_m),
            resolution_quaternion: or(self.resolution_quaternion, 1.0, base.resolution_quaternion),
            rate_hz: or(self.rate_hz, 1.0, base.rate_hz),
            stamp_jitter_s: or(self.stamp_jitter_ms, 1e-3, base.stamp_jitter_s),
            dropout_rate: or(self.dropout_rate, 1.0, base.dropout_rate),
            dropout_burst: or(self.dropout_burst, 1.0, base.dropout_burst),
            outliers: self.outlier_share.map(Outliers::of_share).or(base.outliers),
            mark_error_s: or(self.mark_error_ms, 1e-3, base.mark_error_s),
            marks_named: self.marks_named || base.marks_named,
            hold_before_s: or(self.hold_before_s, 1.0, base.hold_before_s),
            hold_after_s: or(self.hold_after_s, 1.0, base.hold_after_s),
            latency_s: or(self.latency_ms, 1e-3, base.latency_s),
            start: self.start_ns.map_or(base.start, Stamp),
        }
    }
}
