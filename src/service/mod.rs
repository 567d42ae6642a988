//! Drivers of the pipeline: replay and offline.
