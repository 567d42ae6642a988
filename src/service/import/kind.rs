//! What a file is, by its first bytes.

use std::path::Path;

use anyhow::bail;

use crate::ingest::CapturedSession;
use crate::ingest::table::{TableText, table_text};

/// Longest line of a table: a thousand bodies and more.
const LINE_BYTES: usize = 1 << 20;

/// A file that can be read.
pub(super) enum ImportKind {
    /// A text: a table.
    Table(TableText),
    /// A session that a page in a browser captured.
    Captured(CapturedSession),
    /// MCAP.
    Recording(Vec<u8>),
}

/// A format that is known and not read: its first bytes, what it is, and what to do.
struct Other {
    begins: &'static [u8],
    is: &'static str,
    next: &'static str,
}

const fn other(begins: &'static [u8], is: &'static str, next: &'static str) -> Other {
    Other { begins, is, next }
}

const OTHERS: [Other; 9] = [
    other(
        b"HIERARCHY",
        "BVH, joint angles of a skeleton",
        "poses of rigid bodies: export them as CSV with quaternions",
    ),
    other(
        b"\x1f\x8b",
        "gzip",
        "a table: gunzip -c FILE | enact import - -o OUT.mcap reads what is in it",
    ),
    other(
        b"\x28\xb5\x2f\xfd",
        "zstd",
        "a table: zstd -dc FILE | enact import - -o OUT.mcap reads what is in it",
    ),
    other(
        b"PK\x03\x04",
        "a ZIP archive or an Excel workbook",
        "a table: unpack it, or save the sheet as CSV",
    ),
    other(
        b"\xd0\xcf\x11\xe0",
        "an old Excel workbook",
        "a table: save the sheet as CSV",
    ),
    other(
        b"\x89HDF",
        "HDF5",
        "a table: write the poses as CSV, for example with pandas' to_csv",
    ),
    other(
        b"\x93NUMPY",
        "an array of NumPy",
        "a table: write it with numpy.savetxt",
    ),
    other(b"PAR1", "Parquet", "a table: write it with pandas' to_csv"),
    other(
        b"Kaydara FBX",
        "FBX",
        "a table: export poses of rigid bodies as CSV with quaternions",
    ),
];

/// The kind of a file. Fails for what is neither, and says how to get there.
pub(super) fn of(path: &Path, bytes: Vec<u8>) -> anyhow::Result<ImportKind> {
    let shown = path.display();
    if bytes.starts_with(b"\x89MCAP") {
        return Ok(ImportKind::Recording(bytes));
    }
    let rosbags = |what: &str| {
        format!(
            "{shown}: is {what}, expected a table of poses or MCAP; make MCAP of it: `pip install rosbags==0.11.9`, then \
             `rosbags-convert --src {shown} --dst {}_mcap --dst-storage mcap`, and import that folder",
            path.with_extension("").display()
        )
    };
    if bytes.starts_with(b"#ROSBAG") {
        bail!("{}", rosbags("a ROS 1 bag"));
    }
    if bytes.starts_with(b"SQLite format 3\0") {
        let folder = path.parent().filter(|of| !of.as_os_str().is_empty());
        let beside = folder.map_or(path.with_extension(""), Path::to_owned);
        let folder = folder.unwrap_or(Path::new("."));
        bail!(
            "{shown}: is the storage of a ROS 2 bag, expected a table of poses or MCAP; make MCAP of its \
             folder, where metadata.yaml is: `pip install rosbags==0.11.9`, then `rosbags-convert --src {} --dst {}_mcap \
             --dst-storage mcap`, and import that folder",
            folder.display(),
            beside.display()
        );
    }
    // The number of the block of parameters, then the key of the format.
    if matches!(bytes[..], [1..=31, 0x50, ..]) {
        bail!(
            "{shown}: is C3D, positions of markers, expected a table: export poses of rigid bodies as CSV with \
             quaternions, or markers as CSV with marker, t, x, y, z (docs/import.md has lines that do it)"
        );
    }
    if let Some(other) = OTHERS.iter().find(|other| bytes.starts_with(other.begins)) {
        bail!("{shown}: is {}, expected {}", other.is, other.next);
    }
    if bytes.is_empty() {
        bail!("{shown}: is empty, expected a table of poses or MCAP: export it again");
    }
    let begin = bytes.trim_ascii_start();
    let is_json = begin.starts_with(b"{") || begin.starts_with(b"[{");
    if is_json && let Ok(text) = std::str::from_utf8(&bytes) {
        let session = CapturedSession::of_json(text);
        match session.map_err(|why| anyhow::anyhow!("{shown}: {why}"))? {
            Some(session) => return Ok(ImportKind::Captured(session)),
            None => bail!(
                "{shown}: is JSON, but none of A-Frame's motion capture or of iwer's, expected a table: write a line per \
                 pose with t, x, y, z, qx, qy, qz, qw under a line of these names"
            ),
        }
    }
    if let Some(line) = long_line(&bytes) {
        bail!(
            "{shown}:{line}: the line is longer than {} KiB, expected a table of poses or MCAP",
            LINE_BYTES >> 10
        );
    }
    match table_text(bytes) {
        Some(text) => Ok(ImportKind::Table(text)),
        None => bail!(
            "{shown}: is neither text nor MCAP, expected one of them: a table of poses as CSV, or a \
             recording"
        ),
    }
}

/// The number of the first line that is longer than any table has, from 1.
fn long_line(bytes: &[u8]) -> Option<usize> {
    let long = |line: &[u8]| line.len() > LINE_BYTES;
    let mut lines = bytes.split(|byte| *byte == b'\n');
    lines.position(long).map(|place| place + 1)
}
