//! The errors of a hand as a process in time: slow ones are likely, fast ones are not.
//!
//! A hand strays by centimetres, but slowly; a tracker adds a thousandth of that at every sample. Residuals that are
//! weighed one by one know nothing of this: a motion may follow the wander as if each sample told of it anew. Here the
//! residuals of a [`series`] are taken for a [`process`], and a [`filter`] turns them and their derivatives into errors
//! that are independent and of unit variance, in one pass. Sizes and times of the process follow from the residuals
//! themselves by their restricted [`likelihood`], and so does which quantity of a scene is [`wrong`], and what stays [`vague`].

pub mod filter;
pub mod kink;
pub mod likelihood;
pub mod process;
mod search;
pub mod series;
pub mod spread;
pub mod vague;
pub mod white;
pub mod wrong;

pub use filter::{Filter, Gain, Means, SampleInstant};
pub use process::Process;
