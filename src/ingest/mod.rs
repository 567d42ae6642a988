//! Stage 1: recordings and memory become takes.
