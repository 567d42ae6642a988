//! An end to answers about joined bodies that take too long.

use std::time::Instant;

use enact::motion::Observer;

/// After which an answer is told to stop \[s\]; it has failed then.
const LIMIT_S: f64 = 10.0;

/// Stops an answer that takes too long since it began.
pub struct Limit(pub Instant);

impl Observer for Limit {
    fn should_stop(&mut self) -> bool {
        self.0.elapsed().as_secs_f64() > LIMIT_S
    }
}
