//! Stage 2: clean the streams and cut them at the marks.
