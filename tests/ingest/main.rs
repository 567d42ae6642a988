//! Bytes that come in: recordings, tables and messages of other programs, and files that were made to do harm.

mod hostile;
mod import;
mod messages;
mod names;
mod raw_mcap;
mod reader;
#[path = "../support/skip.rs"]
mod skip;
