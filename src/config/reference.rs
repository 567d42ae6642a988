//! The reference of scene files.
