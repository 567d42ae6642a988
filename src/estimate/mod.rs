//! Stage 4: the estimation.
