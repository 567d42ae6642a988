//! Estimates.

use std::path::PathBuf;
use std::sync::Arc;

use enact::motion::{LinkIndex, TrackIndex};
use enact::physics::State;
use enact::report::{EstimateMessage, json};
use enact::sampling::{Moving, seen_less_moving, zero};
use enact::service::{EstimateInMemory, TakeInMemory};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors;
use crate::numbers;
use crate::scene::place;

/// An estimate with its take.
#[pyclass(frozen, module = "enact_motion._core")]
pub struct Estimate {
    take: Arc<TakeInMemory>,
    of: EstimateInMemory,
    /// Whether its deadline ended it.
    #[pyo3(get)]
    is_late: bool,
}

impl Estimate {
    pub fn new(take: Arc<TakeInMemory>, of: EstimateInMemory, is_late: bool) -> Self {
        Self { take, of, is_late }
    }

    fn link(&self, body: &str) -> PyResult<LinkIndex> {
        let links = self.of.outcome.scene.links.iter();
        place("body", body, links.map(|of| &of.name)).map(LinkIndex)
    }
}

#[pymethods]
impl Estimate {
    /// All that it says: the JSON that its file has.
    fn report(&self, py: Python<'_>) -> String {
        let outcome = &self.of.outcome;
        let message = py.detach(|| {
            let provenance = self.take.provenance(&self.of);
            let zero = zero(&outcome.estimate, &outcome.sketch);
            json(&EstimateMessage::new(
                &self.of.reported(),
                zero,
                Some(&provenance),
            ))
        });
        String::from_utf8_lossy(&message).into_owned()
    }

    /// From when to when a body's motion is known \[s\].
    fn span(&self, body: &str) -> PyResult<Option<[f64; 2]>> {
        let outcome = &self.of.outcome;
        let moving = Moving::new(&outcome.scene, &outcome.estimate, self.link(body)?);
        Ok(moving.and_then(|of| of.span_s()))
    }

    /// Of a body at times \[s\], row by row: position, quaternion w x y z, velocity, angular velocity.
    fn states<'py>(
        &self,
        py: Python<'py>,
        body: &str,
        times: &[u8],
    ) -> PyResult<Bound<'py, PyBytes>> {
        let times_s = numbers::of_bytes(times)?;
        let link = self.link(body)?;
        let outcome = &self.of.outcome;
        let states = py.detach(|| {
            let moving = Moving::new(&outcome.scene, &outcome.estimate, link);
            moving.map_or_else(Vec::new, |of| of.states(&times_s))
        });
        Ok(numbers::to_bytes(py, states.iter().flat_map(row)))
    }

    /// Of a track, row by row: acted time, physical time \[s\], position \[m\], rotation vector \[rad\]; NaN of what it does not see.
    fn residuals<'py>(&self, py: Python<'py>, track: &str) -> PyResult<Bound<'py, PyBytes>> {
        let outcome = &self.of.outcome;
        let tracks = outcome.scene.tracks.iter();
        let track = place("track", track, tracks.map(|of| &of.name)).map(TrackIndex)?;
        let (scene, estimate) = (&outcome.scene, &outcome.estimate);
        let each = py.detach(|| seen_less_moving(scene, estimate, &outcome.sketch, track));
        let unseen = [f64::NAN; 3];
        let rows = each.iter().flat_map(|of| {
            let position_m = of.position_m.map_or(unseen, Into::into);
            let turn_rad = of.turn_rad.map_or(unseen, Into::into);
            let times_s = [of.acted_s, of.time_s];
            times_s.into_iter().chain(position_m).chain(turn_rad)
        });
        Ok(numbers::to_bytes(py, rows))
    }

    /// Writes the file that `enact replay` writes.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let written = py.detach(|| self.take.write(&self.of, &path));
        written.map_err(|error| errors::of_any(py, &error))
    }
}

fn row(state: &State) -> [f64; 13] {
    let [x, y, z] = state.position_m.into();
    let q = state.orientation.quaternion();
    let [u, v, w] = state.velocity_m_s.into();
    let [p, q_rad_s, r] = state.angular_velocity_rad_s.into();
    [x, y, z, q.w, q.i, q.j, q.k, u, v, w, p, q_rad_s, r]
}
