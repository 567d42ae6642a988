//! A Cholesky factorisation for chains of blocks.
