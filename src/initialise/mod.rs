//! Stage 3: a first guess, arc by arc.
