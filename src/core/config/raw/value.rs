//! Values with their places in the text.

use super::super::spanned::Spanned;

pub(in crate::config) type Number = Spanned<f64>;
pub(in crate::config) type Triple = Spanned<[f64; 3]>;
pub(in crate::config) type Quadruple = Spanned<[f64; 4]>;
pub(in crate::config) type Text = Spanned<String>;
/// Lower and upper corner of a box.
pub(in crate::config) type Corners = Spanned<[[f64; 3]; 2]>;
