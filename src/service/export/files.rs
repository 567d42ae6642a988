//! The files of an export and their names.

use std::path::{Path, PathBuf};

use anyhow::bail;

use super::super::finish::beside;
use super::super::guard::Inputs;
use super::super::output::write_file_of;
use super::super::read_back::ReadBack;
use super::job::{ExportFormat, ExportJob, Exported};
use crate::ingest::is_pipe;
use crate::report::{ExportProvenance, prints};
use crate::write::export::{ExportedBody, bvh, csv, events_csv, glb, ros2, tum};

/// Files by what is added to the name; one without an addition keeps it.
pub(super) fn files(
    job: &ExportJob,
    read: &ReadBack,
    bodies: &[ExportedBody],
    provenance: &ExportProvenance,
) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    let (scene, motion) = (&read.scene, &read.motion);
    let files = match job.format {
        ExportFormat::Glb => {
            vec![(
                String::new(),
                glb(scene, bodies, motion.zero, job.frame_rate_hz, provenance),
            )]
        }
        ExportFormat::Csv => {
            let text = csv(scene, bodies, motion, provenance);
            vec![(String::new(), text.into_bytes())]
        }
        ExportFormat::Tum => {
            let mut files = Vec::new();
            for body in bodies {
                let name = &scene.links[body.link].name;
                files.push((name.clone(), tum(&body.keys, provenance).into_bytes()));
                if !body.acted.is_empty() {
                    let name = format!("{name}.acted");
                    files.push((name, tum(&body.acted, provenance).into_bytes()));
                }
            }
            if let [(addition, _)] = &mut files[..] {
                addition.clear();
            }
            files
        }
        ExportFormat::Bvh => {
            let text = bvh(scene, bodies, motion.zero, job.frame_rate_hz);
            vec![(String::new(), text.into_bytes())]
        }
        ExportFormat::Events => {
            let text = events_csv(motion, provenance)?;
            vec![(String::new(), text.into_bytes())]
        }
        ExportFormat::Ros2 => {
            let bytes = ros2(&job.input, read.recording.container(), provenance)?;
            vec![(String::new(), bytes)]
        }
    };
    Ok(files)
}

/// Writes them; beside a BVH, which has no place for it, a text that says from what it was made.
pub(super) fn write(
    job: &ExportJob,
    files: Vec<(String, Vec<u8>)>,
    provenance: &ExportProvenance,
    exported: &mut Exported,
) -> anyhow::Result<()> {
    let output = match &job.output {
        None => beside(&job.input, job.format.ending())?,
        Some(output) => output.clone(),
    };
    let count = files.len();
    if is_pipe(&output) && count > 1 {
        bail!("{count} trajectories, expected -o FILE: one stream holds one");
    }
    let mut named: Vec<(PathBuf, Vec<u8>)> = files
        .into_iter()
        .map(|(addition, bytes)| (with_addition(&output, &addition), bytes))
        .collect();
    if job.format == ExportFormat::Bvh && !is_pipe(&output) {
        let text = provenance.lines().join("\n") + "\n";
        named.push((with_origin(&output), text.into_bytes()));
    }
    let inputs = Inputs::of([job.input.as_path()]);
    for (index, (path, _)) in named.iter().enumerate() {
        inputs.keep_from(path)?;
        if named[..index].iter().any(|(other, _)| other == path) {
            bail!(
                "{}: is the file of two bodies, expected other names",
                path.display()
            );
        }
    }
    for (path, bytes) in named {
        write_file_of(&path, &bytes, &[&job.input])?;
        exported.outputs.push(path.display().to_string());
    }
    Ok(())
}

/// `out.tum` → `out.pencil.tum`; what is no part of a name of a file is replaced by `_`.
fn with_addition(output: &Path, addition: &str) -> PathBuf {
    if addition.is_empty() {
        return output.to_owned();
    }
    let plain = |c: char| match c {
        '/' | '\\' | ':' => '_',
        c if !prints(c) => '_',
        c => c,
    };
    let addition: String = addition.chars().map(plain).collect();
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    let ending = output.extension().map(|ending| ending.to_string_lossy());
    let ending = ending.map_or(String::new(), |ending| format!(".{ending}"));
    output.with_file_name(format!("{stem}.{addition}{ending}"))
}

/// `out.bvh` → `out.bvh.provenance.txt`.
fn with_origin(output: &Path) -> PathBuf {
    let mut name = output.file_name().unwrap_or_default().to_owned();
    name.push(".provenance.txt");
    output.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_bodies_are_named_after_the_output() {
        for (output, addition, path) in [
            ("a/x.tum", "", "a/x.tum"),
            ("a/x.tum", "pencil", "a/x.pencil.tum"),
            ("x.y.tum", "link 1/2", "x.y.link 1_2.tum"),
            ("x", "die.acted", "x.die.acted"),
        ] {
            assert_eq!(with_addition(Path::new(output), addition), Path::new(path));
        }
    }
}
