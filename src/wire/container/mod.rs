//! MCAP files in memory, read so that no byte of them can abort the process and none is
//! believed that fails its checksum.
//!
//! [`walk`] yields the records of the data section one by one: chunks are decompressed and
//! verified whole before anything in them is handed out, and a chunk that fails is left out and
//! named. The frame of a record is checked against the file before anything is allocated.
//! [`Container`] is what one such walk over the whole file finds: channels, schemas,
//! attachments, counts, and the damage. The summary section is not needed, so a file cut off
//! at any byte is read as far as it goes; it is asked for channels whose definition is lost.
//!
//! After damage the walk goes on with the next record that can be verified: type and length of a
//! record have no checksum, and a chunk is known by its own header and checksum whatever they say.
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
