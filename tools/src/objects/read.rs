//! The tosses as they are stored.

use std::path::PathBuf;

use anyhow::{Context, Result};

use crate::nonsense::real::files;
use crate::tosses::{Pose, Toss, poses, real_folder};

/// Nominal rate of the samples; the source does not state it \[Hz\].
pub const RATE_HZ: f64 = 30.0;

/// One toss of an object.
pub struct ObjectToss {
    /// Of the file: `egg_2`.
    pub name: String,
    /// What is tossed: `egg`.
    pub object: String,
    /// Whether weights and bounds may be chosen on it: the first, third, … of the list.
    pub is_for_choosing: bool,
    /// In order; the frame that was tracked.
    pub poses: Vec<Pose>,
}

impl ObjectToss {
    /// Its samples from one place to another, both included, as a toss of its own.
    pub fn part(&self, first: usize, last: usize) -> Toss {
        Toss {
            number: 0,
            poses: self.poses[first..=last].to_vec(),
            flight: last + 1 - first,
            flight_is_given: false,
        }
    }
}

/// The folder of the tosses and their meshes, if it is there.
pub fn folder() -> Option<PathBuf> {
    let folder = real_folder()?.join("objects");
    folder.is_dir().then_some(folder)
}

/// All tosses in order of name; `None` where they are not there.
pub fn all() -> Result<Option<Vec<ObjectToss>>> {
    let Some(folder) = folder() else {
        return Ok(None);
    };
    let read = |(index, file): (usize, PathBuf)| {
        let name = file.file_stem().context("a name")?.to_string_lossy();
        let (object, _) = name.split_once('_').context("object and number")?;
        Ok(ObjectToss {
            object: object.to_owned(),
            poses: poses(&file)?,
            is_for_choosing: index.is_multiple_of(2),
            name: name.into_owned(),
        })
    };
    let tosses: Result<Vec<ObjectToss>> = files(&folder, "csv")
        .into_iter()
        .enumerate()
        .map(read)
        .collect();
    tosses.map(Some)
}
