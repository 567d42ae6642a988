//! MCAP files in memory, read so that no content can abort the process and no data are used that
//! fail their checksum.
//!
//! [`walk`] yields the records of the data section one by one: chunks are decompressed and
//! verified whole before anything in them is handed out, and a chunk that fails is left out and
//! reported. The frame of a record is checked against the file before anything is allocated.
//! [`Container`] is the result of one walk over the whole file: channels, schemas, attachments,
//! counts, and the damage. The summary section is not needed, so that a file cut off at any byte is
//! read up to there; it is used only for channels whose definition is lost.
//!
//! After damage the walk continues at the next record that can be verified. Type and length of a
//! record have no checksum, so a chunk is recognised by its own header and checksum instead.
//! In a file without chunks nothing after damage can be verified. Every byte that was not read is
//! in [`Damages::unread`].

mod damage;
mod index;
mod record;
mod scan;
mod summary;
pub mod walk;

pub use damage::{Damage, Damages};
pub use index::{Attachment, Channel, Container, ContainerError, Metadata, Schema};
pub use record::{REPEATED, REPEATS};
pub use walk::{Message, Walk};
