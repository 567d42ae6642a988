//! What a file is, by its first bytes.

use std::path::Path;

use anyhow::bail;

/// Longest line of a table: a thousand bodies and more.
const LINE_BYTES: usize = 1 << 20;

/// A file that can be read.
pub(super) enum Kind {
    /// A text: a table.
    Table(String),
    /// MCAP.
    Recording(Vec<u8>),
}

/// The kind of a file. Fails for what is neither, and says how to get there.
pub(super) fn of(path: &Path, bytes: Vec<u8>) -> anyhow::Result<Kind> {
    let shown = path.display();
    if bytes.starts_with(b"\x89MCAP") {
        return Ok(Kind::Recording(bytes));
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
    if bytes.starts_with(b"HIERARCHY") {
        bail!(
            "{shown}: is BVH, joint angles of a skeleton, expected poses of rigid bodies: export them as \
             CSV with quaternions"
        );
    }
    // The number of the block of parameters, then the key of the format.
    if matches!(bytes[..], [1..=31, 0x50, ..]) {
        bail!(
            "{shown}: is C3D, positions of markers, expected a table: export poses of rigid bodies as CSV with \
             quaternions, or markers as CSV with marker, t, x, y, z (docs/import.md has lines that do it)"
        );
    }
    if bytes.is_empty() {
        bail!("{shown}: is empty, expected a table of poses or MCAP");
    }
    if let Some(line) = long_line(&bytes) {
        bail!(
            "{shown}:{line}: the line is longer than {} KiB, expected a table of poses or MCAP",
            LINE_BYTES >> 10
        );
    }
    match String::from_utf8(bytes) {
        Ok(text) if !text.contains('\0') => Ok(Kind::Table(text)),
        _ => bail!(
            "{shown}: is neither UTF-8 text nor MCAP, expected one of them: a table of poses, or a \
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
