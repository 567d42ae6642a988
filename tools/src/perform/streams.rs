//! Streams of random numbers, one for each purpose.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// What a stream of random numbers is for: a knob changes nothing but what it is about.
#[derive(Clone, Copy)]
pub(super) enum Role {
    Tempo,
    Marks,
    PositionWander,
    OrientationWander,
    Noise,
    Jitter,
    Dropouts,
    Phase,
    Outliers,
    Knobs,
}

/// The stream of a seed for a purpose; tracks, or segments of an edited sketch, have channels of their own.
pub(super) fn stream(seed: u64, role: Role, channel: usize) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(role as u64 + 16 * channel as u64);
    rng
}
