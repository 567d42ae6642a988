//! How a free body flies: the map (state, duration) → state, with its derivatives.
