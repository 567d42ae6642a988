//! Stage 4b: an independent check of the estimate.
