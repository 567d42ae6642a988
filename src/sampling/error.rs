//! Why a motion cannot be sampled.

use thiserror::Error;

/// Why a motion cannot be sampled.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SamplingError {
    /// No frames can be made at this rate.
    #[error("frame rate {frame_rate_hz} Hz, expected 0.001 to 100000")]
    FrameRate {
        /// As given.
        frame_rate_hz: f64,
    },
    /// The estimated motion is absurdly long.
    #[error(
        "the motion of body {body:?} reaches from {start_s} s to {end_s} s: too many frames to write"
    )]
    Span {
        /// Name of the body.
        body: String,
        /// Where its first arc begins.
        start_s: f64,
        /// Where its last arc ends.
        end_s: f64,
    },
}
