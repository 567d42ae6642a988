//! In which axes something is given.

/// The world's axes or a body's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Axes {
    /// The world's.
    #[default]
    World,
    /// The body's own.
    Body,
}
