//! Folders that stand for the recordings in them, and a folder for what is made of several.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

/// The files that are meant: of a folder, as of a bag, the recordings in it by name. Fails where a folder has none that can be
/// read.
pub fn recordings_in(inputs: &[PathBuf]) -> anyhow::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for input in inputs {
        match input.is_dir() {
            true => files.extend(files_in(input)?),
            false => files.push(input.clone()),
        }
    }
    Ok(files)
}

fn files_in(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let shown = folder.display();
    let entries = std::fs::read_dir(folder).with_context(|| format!("{shown}: cannot read"))?;
    let mut recordings = Vec::new();
    let mut others = Vec::new();
    for entry in entries {
        let path = entry
            .with_context(|| format!("{shown}: cannot read"))?
            .path();
        let ending = path.extension().and_then(|of| of.to_str());
        match ending.map(str::to_ascii_lowercase).as_deref() {
            Some("mcap") => recordings.push(path),
            Some(ending) => others.push(ending.to_owned()),
            None => {}
        }
    }
    recordings.sort();
    if !recordings.is_empty() {
        return Ok(recordings);
    }
    let has = |ending: &str| others.iter().any(|of| of == ending);
    if has("db3") {
        let folder = folder.components().as_path().display();
        bail!(
            "{shown}: is the folder of a ROS 2 bag that is no MCAP, expected recordings (.mcap); make MCAP of it: `pip install \
             rosbags==0.11.9`, then `rosbags-convert --src {folder} --dst {folder}_mcap --dst-storage mcap`, and import \
             {folder}_mcap"
        );
    }
    if has("zstd") {
        bail!(
            "{shown}: its recordings are packed, expected .mcap: `zstd -d {shown}/*.zstd` unpacks them"
        );
    }
    if has("bag") {
        bail!(
            "{shown}: has bags of ROS 1, expected recordings (.mcap): import one of them for how to convert it"
        );
    }
    bail!("{shown}: is a folder without recordings (.mcap), expected some, or the name of a file")
}

/// What is made of each of several files: a file of its own name with this ending in a folder, which is made if it is not there.
/// Fails where two have the same name.
pub fn beside_each(
    inputs: &[PathBuf],
    folder: &Path,
    ending: &str,
) -> anyhow::Result<Vec<PathBuf>> {
    let outputs = outputs_of(inputs, |input| {
        let stem = input
            .file_stem()
            .with_context(|| format!("{}: expected the name of a file", input.display()))?;
        let mut name = stem.to_owned();
        name.push(".");
        name.push(ending);
        Ok(folder.join(name))
    })?;
    std::fs::create_dir_all(folder)
        .with_context(|| format!("{}: cannot make the folder", folder.display()))?;
    Ok(outputs)
}

/// The output of each input. Fails where two are equal.
pub(super) fn outputs_of(
    inputs: &[PathBuf],
    output_of: impl Fn(&Path) -> anyhow::Result<PathBuf>,
) -> anyhow::Result<Vec<PathBuf>> {
    let mut taken: BTreeMap<PathBuf, &Path> = BTreeMap::new();
    let mut outputs = Vec::new();
    for input in inputs {
        let output = output_of(input)?;
        if let Some(other) = taken.insert(output.clone(), input) {
            bail!(
                "{} and {} would both be written to {}",
                other.display(),
                input.display(),
                output.display()
            );
        }
        outputs.push(output);
    }
    Ok(outputs)
}
