//! Stage 5: estimates become files.
