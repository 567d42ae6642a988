//! What a machine can check of the house and of its documents.

mod book;
mod charts;
mod methods;
mod promises;
mod readme;
mod tidy;
