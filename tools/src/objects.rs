//! Real tosses of household objects (DAIRLab's `dair_pll_vision`, BSD-3), which are not part of this
//! repository: imprecise sketches of motions with contact.
//!
//! - [`read`]: the tosses; what their [`smoothing`] has done to them, seen in the samples alone;
//! - [`cut`]: flights and contacts by the spin, which is not smoothed like the positions;
//! - [`solid`]: shapes from [`mesh`]es or, where there is none, of household size; a [`scene`] of them, and how
//!   far samples can be [`mod@trust`]ed;
//! - [`check`]: what can be checked of an answer without the program's own checks.

pub mod check;
pub mod cut;
pub mod mesh;
pub mod read;
pub mod scene;
pub mod smoothing;
pub mod solid;
pub mod trust;
