//! TOML → checked scenes.
//!
//! Two steps. First the text as it stands, [`serde`] structs with every key optional that may be
//! left out, unknown keys refused, units in the keys. Then a [`Scene`](crate::motion::Scene) in
//! SI units that the stages trust without looking again. Whatever is wrong in either step comes
//! out as a [`SceneError`] that says where (line and column from 1) and what was expected.
//!
//! `timing.stamps` says what the samples' stamps are: `"physical"` times; times of an acting whose
//! `"tempo"` is unknown; or `"edited"`, an edited sketch. In that every body has a stream per
//! flight, on its topic with `/1`, `/2`, … after it, one more than it has collisions. Each has
//! physical times of its own, from any zero, and need not begin where another ends. They are
//! taken one after the other, a median interval apart. An edited sketch needs no marks, and any
//! that are there are not read.
//!
//! A body's corners are in `features_mm`, its flat faces in `[[body.face]]` (`name`, `point_mm`,
//! `normal` out of the body).
//!
//! Defaults, all of them:
//!
//! | key | default |
//! |---|---|
//! | `gravity_m_s2` | `[0, 0, -9.80665]` |
//! | `marks_topic` | `"/marks"` |
//! | `settle_s` | the motion ends where the performance does |
//! | `timing.tempo_sd_per_sqrt_s` | 0.5 |
//! | `weights.position_mm`, `weights.orientation_deg` | 10 mm, 0.1 rad |
//! | `body.topic` | `"/tracker/<name>/pose"` |
//! | `velocity_gaps` | `"when needed"` |
//! | `body.tracker`, `obstacle.orientation_wxyz` | identity |
//! | `free.initial…` | the scene's value; 0 for a tilt |
//! | `free.lower…`, `free.upper…` | −∞, +∞; 0 and 1 for a restitution |

mod body;
mod error;
mod event;
mod keys;
mod number;
mod parameter;
mod raw;
mod scene;
mod solid;

pub use error::SceneError;
pub use scene::scene_from_toml;

#[cfg(test)]
mod tests;
