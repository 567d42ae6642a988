//! Who is to blame for a misfit: the quantities that the scene keeps fixed and whose change would
//! explain most of it, by Rao's test ([`score`](super::score)), and by what they explain when they are set free.

mod candidates;
mod errors;
mod scored;
mod trial;
mod wider;

pub(super) use self::candidates::{Which, candidates};
pub(super) use self::errors::Errors;
pub(super) use self::scored::scored;
pub(super) use self::trial::{SolvedMotion, tried};
pub(super) use self::wider::{Wider, unbounded};
