//! What cannot be calibrated, with what to do instead.

use thiserror::Error;

/// Why there is no calibration.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum CalibrateError {
    /// Too few usable readings.
    #[error("{usable} usable poses, expected at least {least}: record for longer")]
    TooFew {
        /// Readings that are poses.
        usable: usize,
        /// How many are needed.
        least: usize,
    },
    /// The object hardly turned about some axis.
    #[error(
        "the object was swung by {least_deg:.1}° only about one axis (root mean square), expected \
         at least {needed_deg}°: swing it about two axes, by 30° or more each way"
    )]
    NoSwing {
        /// Root mean square of the turns about the axis with the smallest ones \[deg\].
        least_deg: f64,
        /// How much is needed \[deg\].
        needed_deg: f64,
    },
    /// Fewer touches than span a plane.
    #[error("{0} touches, expected at least 3 that are not in a line")]
    FewTouches(usize),
    /// No samples near a touch.
    #[error(
        "no pose within {window_ms:.0} ms of the touch at {time_s:.3} s, expected a time within the recording"
    )]
    TouchOutside {
        /// When it is said to touch \[s\].
        time_s: f64,
        /// How far poses are looked for \[ms\].
        window_ms: f64,
    },
    /// Touches in a line: the plane is free to turn about it.
    #[error(
        "the touches lie in a line, {long_mm:.0} mm long and {wide_mm:.1} mm wide: touch beside it too"
    )]
    Collinear {
        /// Extent along the line \[mm\].
        long_mm: f64,
        /// Extent across it \[mm\].
        wide_mm: f64,
    },
    /// Nothing in the recording moves as in a flight.
    #[error(
        "no free flight found: expected a drop or toss of at least {0} samples, or --from and --to where it is"
    )]
    NoFlight(usize),
    /// The streams have too little time in common.
    #[error(
        "the streams overlap for {overlap_s:.2} s, expected at least {least_s} s of one motion"
    )]
    NoOverlap {
        /// Time in common \[s\].
        overlap_s: f64,
        /// How much is needed \[s\].
        least_s: f64,
    },
    /// The motion does not single out one offset.
    #[error(
        "the streams' turning does not agree at any offset (correlation {0:.2}), expected two trackers on one object that is turned to and fro"
    )]
    NoAgreement(f64),
}
