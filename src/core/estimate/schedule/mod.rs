//! The way to the solution: first event times ([`events`]) and first states of flights without samples (`hand_on`), the
//! schedule of solves ([`recipe`]) and their `work`, and the problem as the optimiser sees it (`evaluate`).

mod evaluate;
pub mod events;
mod hand_on;
pub mod recipe;
pub(in crate::estimate) mod work;
