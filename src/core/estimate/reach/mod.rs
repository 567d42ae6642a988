//! The state at an event with its derivatives: plain ([`arc_end`]), and where parameters act (`arrival`).

pub(in crate::estimate) mod arc_end;
pub(in crate::estimate) mod arrival;
