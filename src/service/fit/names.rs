//! The quantities that are asked for, by name.

use anyhow::ensure;

use crate::config::share;
use crate::motion::Scene;

/// What is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct AskedNames {
    pub(super) all: Vec<String>,
    /// How many of them are shared: the others are drawn.
    pub(super) shared: usize,
}

impl AskedNames {
    /// Names of quantities that have one value in all takes, and of those that each take draws. Fails without any.
    pub fn new(shared: &[String], drawn: &[String]) -> anyhow::Result<Self> {
        let all = [shared, drawn].concat();
        ensure!(
            !all.is_empty(),
            "nothing is asked for, expected --shared NAME or --drawn NAME, such as --shared bounce.restitution"
        );
        Ok(Self {
            shared: shared.len(),
            all,
        })
    }

    /// Frees what they mean in a scene: places of the parameters, and how many of them are shared.
    pub(super) fn free(&self, scene: &mut Scene) -> anyhow::Result<(Vec<usize>, usize)> {
        let (shared, _) = self.all.split_at(self.shared);
        let wrong = |message: String| anyhow::anyhow!(message);
        let shared = share(&mut scene.clone(), shared).map_err(wrong)?;
        let all = share(scene, &self.all).map_err(wrong)?;
        Ok((all, shared.len()))
    }
}
