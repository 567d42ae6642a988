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
//! Records outside of chunks with checksums are believed as long as each record leads to the next,
//! from the first on; once the next had to be searched for, what has no checksum is not, for a
//! search may end inside of something else. So in a file without chunks nothing after damage is
//! read. Where the checksum of the whole data section fails, the damage says how many messages no
//! other verifies. Every byte that was not read is in [`Damages::unread`].
//!
//! What reading costs is bounded (`budget`): chunks unpack to at most 64 times the file's size and
//! 64 MiB, and a search that finds nothing is given up. [`Reading`] may set a deadline as well.

mod budget;
mod damage;
mod digest;
mod index;
mod record;
mod scan;
mod summary;
pub mod walk;

pub use budget::Reading;
pub use damage::{Damage, Damages};
pub use digest::{Digest, digest};
pub use index::{Attachment, Channel, Container, ContainerError, Metadata, Schema};
pub use record::{REPEATED, REPEATS};
pub use walk::{Message, Walk};
