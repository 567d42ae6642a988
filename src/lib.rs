//! `enact`: acting capture.
//!
//! Somebody picks up a real object with a 6-DoF tracker on it and *acts* a motion: a pencil
//! bounces on the table, twirls, lands in a mug. The performance is slow, imprecise, physically
//! impossible. `enact` takes the tracker's stream, cuts it at the collisions that the performer
//! marked, and estimates the rigid-body motion that fits it best and is physically correct,
//! subject to what must hold (it *does* land in the mug). It follows Popović, Seitz and Erdmann,
//! "Motion Sketching for Control of Rigid-Body Simulations", ACM Transactions on Graphics 22(4),
//! 2003; equation numbers in the code are theirs.
//!
//! # The problem
//!
//! Unknown are the state `q` of every arc, the times `τ` of the events, free parameters `u`, and
//! the physical times `t` of the samples where the stamps only give an order:
//!
//! ```text
//! min   Σ_i ‖W (Φ(q, t_i) ⊟ s_i)‖² + priors(u) + tempo(t)   distance from what was acted (eq. 1, 6)
//! s.t.  φ(Φ(q, τ)) = 0, approaching                         contact at a collision (§5.2)
//!       q⁺ = Impact(q⁻, u)                                  continuity over it (eq. 3, 8)
//!       goals (§3.1), bounds (§6), order of times (eq. 7)
//! ```
//!
//! # The rooms
//!
//! Folders are the stages of the pipeline and the few rooms they stand on.
//!
//! | room | what is in it | may import |
//! |---|---|---|
//! | [`math`] | SO(3), poses | |
//! | [`optimise`] | constrained least squares over any unknowns | |
//! | [`physics`] | bodies, shapes (all of parry), flight, impact; each beside its derivatives | `math` |
//! | [`motion`] | the nouns that stages exchange: scene, take, sketch, estimate | `physics`, `math` |
//! | [`ingest`] | 1 recordings, memory and live trackers become takes; tables of poses are read | `wire`, `motion` |
//! | [`segment`] | 2 clean the streams, match and refine the marks, cut | `motion` and below |
//! | [`initialise`] | 3 a first guess, arc by arc | `motion` and below |
//! | [`estimate`] | 4 the constrained estimation | `optimise`, `motion` and below |
//! | [`verify`] | 4b independent checks: overlap, what touches first, single shot, energy; could it be what was acted | `motion` and below |
//! | [`settle`] | 4c the motion goes on by simulation until it rests (all of rapier) | `motion` and below |
//! | [`report`] | what an estimate says of itself, with the scene's names: lines, sentences, the JSON of files and recordings | `motion` |
//! | [`sampling`] | a motion becomes frames: stamped poses of every body at a rate | `motion` and below |
//! | [`visual`] | what of a scene is drawn: shapes as primitives and as triangles, with colours | `motion` and below |
//! | [`mod@write`] | 5 estimates become files | `report`, `sampling`, `visual`, `wire`, `motion` and below |
//! | [`page`] | an estimate as a page that people open, and as pictures: HTML and SVG | `write`, `report`, `sampling`, `visual`, `motion` and below |
//! | [`wire`] | bytes ↔ motion, the contract over iceoryx2; shared by `ingest` and `write`; no files | `motion`, `math` |
//! | [`config`] | TOML → checked scenes; URDF, meshes and objects at hand → TOML | `motion` and below |
//! | [`calibrate`] | beside the stages: tip, table, noise, gravity and clocks of what a tracker sees | `motion` and below |
//! | [`jointly`] | beside the stages: one answer from what many takes say of what they share | `motion` |
//! | [`pipeline`] | stages 2 to 4c as one pure state machine | the stages |
//! | [`service`] | its drivers, with clock, files and threads: live, replay and offline | `pipeline`, `calibrate`, `jointly`, `ingest`, `write`, `page`, `report`, `config`, `motion` |
//! | [`cli`] | the commands and their accounts | `config`, `report`, `service` |
//!
//! The crate `enact-core` in `src/core` has `config` and the rooms that compute; the others, around it, are the program.
//! `math`, `optimise`, `physics`, `motion`, the stages 2 to 4, `calibrate`, `jointly` and `pipeline` do nothing but compute. What is
//! absent there matters most: no files, no sockets, no clock, no threads, no printing, no logging, no container of random
//! order. A run can be stopped and watched through
//! [`motion::Observer`], and the same take gives the same bits. Stages never import each other;
//! what they exchange is in [`motion`]. `tests/house/tidy.rs` enforces all of this.
//!
//! # Conventions
//!
//! - Perturbation on the right, `R ⊞ θ = R·Exp(θ)`; quaternions are Hamilton and unit, world
//!   from body.
//! - A transform is named by its frames, `world_from_body`, so that neighbours cancel.
//! - SI inside, with the unit in the name of every bare float that crosses a room (`gap_m`,
//!   `rate_rad_s`). Time is integer nanoseconds at the edge ([`motion::Stamp`]) and seconds
//!   since the first sample inside.
//! - Distances are signed: negative is penetration.
//! - Body axes are principal axes at the centre of mass. A scene gives a body in any frame
//!   ([`motion::Link::link_from_given`]), and in that its poses are written.
//! - Bad input is an error with place and numbers, one enum per room. Not converging is an
//!   outcome with a verdict and a reason. A bug is a failed assertion.
//!
//! # Links, mechanisms, tracks
//!
//! A scene has three lists, and an index type for each, so that none is taken for another:
//!
//! - A *link* ([`motion::LinkIndex`]) is one rigid body: mass, shape, and features that touch.
//! - A *mechanism* ([`motion::MechanismIndex`]) is what moves as one system of differential
//!   equations between its collisions: one link in free flight, or links joined in a tree.
//! - A *track* ([`motion::TrackIndex`]) is what one tracker on a link delivers.
//!
//! A link that somebody holds ([`motion::Held`]) does not fly: its track, smoothed, is its motion
//! ([`motion::held`]).
//!
//! # Symbols
//!
//! | symbol | in the code | meaning |
//! |---|---|---|
//! | `q` | [`physics::State`] | state of a free body |
//! | `x`, `R`, `v`, `ω` | `position_m`, `orientation`, `velocity_m_s`, `angular_velocity_rad_s` | its parts: centre of mass and velocity in world axes, angular velocity in body axes |
//! | `s_i` | [`motion::Sample`] | an acted pose |
//! | `τ_k` | [`motion::EventEstimate::time_s`] | physical time of an event |
//! | `t_i` | [`motion::SampleTime::time_s`] | physical time of a sample |
//! | `u` | [`motion::ParameterEstimate`] | free parameters |
//! | `Φ` | [`physics::flow`] | flight: state and duration → state |
//! | `e` | `restitution` | coefficient of restitution |
//!
//! # Limits
//!
//! Free rigid bodies that collide with the static world, with each other or with bodies in the hand; bodies
//! joined in trees, and free ones beside them. Contacts are
//! between features: points, lines, rims and faces, sharp or rounded, in the pairs that
//! [`physics::contact`] knows. Friction is for one contact at a time.

#![forbid(unsafe_code)]

pub use enact_core::{
    calibrate, config, estimate, initialise, jointly, math, motion, optimise, physics, pipeline,
    segment, settle, verify,
};

pub mod cli;
#[cfg(test)]
mod fixture;
pub mod ingest;
pub mod page;
pub mod report;
pub mod sampling;
pub mod service;
pub mod visual;
pub mod wire;
pub mod write;
