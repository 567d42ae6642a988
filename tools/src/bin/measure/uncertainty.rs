//! How certain an estimate is, and whether it says so: errors against the covariance, beside the
//! Cramér–Rao bound as data become fewer, and how often reported intervals hold the truth.

mod bound;
mod figures;
mod intervals;
mod square;
mod sweep;

use anyhow::Result;
use enact::math::Pose;
use enact::motion::TrackIndex;

use crate::options::Options;
use crate::record::Record;
use crate::statistics::rms;
use enact_tools::case::Posed;
use enact_tools::perform::{Acting, Style, Truth};

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    if options.rows.is_none() {
        square::run(options, record)?;
        sweep::run(options, record)?;
    }
    intervals::run(options, record)
}

/// Kinds of unknown.
const KINDS: [&str; 5] = [
    "position",
    "orientation",
    "velocity",
    "angular velocity",
    "event time",
];

/// White noise and nothing else, of the size of one unit of residual.
fn white_noise() -> Acting {
    Acting {
        distortion: 0.0,
        resolution_m: 0.0,
        resolution_quaternion: 0.0,
        mark_error_s: 0.0,
        rate_hz: 125.0,
        ..Acting::timing_known()
    }
}

/// A pencil tracked at its centre of mass, so that both kinds of noise stay what they are, and
/// weighed by that noise.
fn weighed(style: Style, acting: &Acting) -> Truth {
    let mut scene = style.truth().scene;
    scene.tracks[TrackIndex(0)].link_from_tracker = Pose::identity();
    scene.weights.position_m = acting.noise_position_m;
    scene.weights.orientation_rad = acting.noise_orientation_rad;
    style.truth_in(&scene).expect("the style's own scene")
}

/// The rms of a value of each unknown over the unknowns of each kind.
fn rms_by_kind(posed: &Posed, value: impl Fn(usize) -> f64) -> [f64; 5] {
    let layout = &posed.layout;
    std::array::from_fn(|kind| {
        let values: Vec<f64> = if kind == 4 {
            layout
                .events
                .iter()
                .flatten()
                .map(|at| value(*at))
                .collect()
        } else {
            let arcs = layout.arcs.iter().map(|at| at + 3 * kind);
            arcs.flat_map(|at| (at..at + 3).map(&value)).collect()
        };
        rms(&values)
    })
}
