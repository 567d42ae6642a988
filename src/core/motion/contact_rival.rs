//! Contacts that an inferred one is not told from.

use super::scene::Touching;

/// Another contact than the inferred one that is not ruled out.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactRival {
    /// The collision (index into `Scene::events`).
    pub event: usize,
    /// What would touch.
    pub contacts: Vec<Touching>,
    /// Why it is not ruled out.
    pub standing: Standing,
}

/// Why another contact is not ruled out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// A motion with it is as near to the performance, within what its errors let tell.
    Alike,
    /// No motion with it was found, which does not show that there is none.
    Lost,
    /// It was not tried.
    Untried,
}

impl Standing {
    /// Its name in files and reports.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Alike => "alike",
            Self::Lost => "no motion found",
            Self::Untried => "not tried",
        }
    }
}
