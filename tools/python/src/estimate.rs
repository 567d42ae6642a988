//! Estimates.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use enact::motion::{LinkIndex, TrackIndex};
use enact::physics::State;
use enact::pipeline::KeptMotion;
use enact::report::{EstimateMessage, json};
use enact::sampling::{MovedBody, seen_less_moving, zero};
use enact::service::{EstimateInMemory, TakeInMemory};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors;
use crate::numbers;
use crate::scene::{Scene, place};
use crate::watch::{Watch, limit};

/// An estimate with its take.
#[pyclass(frozen, module = "enact_motion._core")]
pub struct Estimate {
    take: Arc<TakeInMemory>,
    of: EstimateInMemory,
    /// Whoever waits for it has let go of the interpreter.
    kept: Mutex<Option<KeptMotion>>,
    /// Whether its deadline ended it.
    #[pyo3(get)]
    is_late: bool,
    /// Whether it began at another estimate.
    #[pyo3(get)]
    is_warm: bool,
    /// How long phases took \[s\].
    spent: Vec<(&'static str, f64)>,
}

impl Estimate {
    pub fn new(
        take: Arc<TakeInMemory>,
        (mut of, kept): (EstimateInMemory, Option<KeptMotion>),
        watch: Watch,
    ) -> Self {
        let spent = watch.spent.into_iter();
        of.ended_after_s = watch.ended_after.map(|after| after.as_secs_f64());
        Self {
            take,
            kept: Mutex::new(kept),
            is_late: of.ended_after_s.is_some(),
            of,
            is_warm: false,
            spent: spent
                .map(|(phase, spent)| (phase.as_str(), spent.as_secs_f64()))
                .collect(),
        }
    }

    fn kept(&self) -> MutexGuard<'_, Option<KeptMotion>> {
        // What panicked has only read it.
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn link(&self, body: &str) -> PyResult<LinkIndex> {
        let links = self.of.outcome.scene.links.iter();
        place("body", body, links.map(|of| &of.name)).map(LinkIndex)
    }
}

#[pymethods]
impl Estimate {
    #[getter]
    fn spent(&self) -> Vec<(&'static str, f64)> {
        self.spent.clone()
    }

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
        let moving = MovedBody::new(&outcome.scene, &outcome.estimate, self.link(body)?);
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
            let moving = MovedBody::new(&outcome.scene, &outcome.estimate, link);
            moving.map_or_else(Vec::new, |of| of.states(&times_s))
        });
        Ok(numbers::to_bytes(py, states.iter().flat_map(row)))
    }

    /// Of a body what is simulated after the end, row by row: time, position, quaternion w x y z.
    fn simulated<'py>(&self, py: Python<'py>, body: &str) -> PyResult<Bound<'py, PyBytes>> {
        let link = self.link(body)?;
        let outcome = &self.of.outcome;
        let given = outcome.scene.links[link].link_from_given;
        let rows = outcome.settled.iter().flat_map(|settled| {
            let poses = settled.links[link].poses.iter().enumerate();
            poses.flat_map(move |(step, pose)| {
                let pose = pose * given;
                let [x, y, z] = pose.translation.vector.into();
                let q = pose.rotation.quaternion();
                let time_s = settled.from_s + step as f64 * settled.interval_s;
                [time_s, x, y, z, q.w, q.i, q.j, q.k]
            })
        });
        Ok(numbers::to_bytes(py, rows))
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

    /// The names of numbers, and their covariances row by row; `None` where nothing tells them.
    fn varied_together<'py>(&self, py: Python<'py>) -> Option<(Vec<String>, Bound<'py, PyBytes>)> {
        let varied = py.detach(|| self.kept().as_ref()?.varied_together())?;
        let rows = varied.covariance.transpose();
        Some((varied.names, numbers::to_bytes(py, rows.iter().copied())))
    }

    /// The estimate of the same take in a scene with other goals, from this one on; anew where that leads nowhere.
    #[expect(clippy::too_many_arguments, reason = "Python names them")]
    fn update(
        &self,
        py: Python<'_>,
        scene: &Scene,
        is_told: bool,
        is_free_auto: bool,
        is_diagnosing: bool,
        deadline_s: Option<f64>,
        told: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let take = Arc::new(self.take.in_scene(&scene.of));
        let mut watch = Watch::begin(limit(deadline_s)).telling(told);
        let found = py.detach(|| {
            let warm = match self.kept().as_ref() {
                Some(kept) => take.with_goals_of(&self.of, kept, is_told, &mut watch)?,
                None => None,
            };
            let is_warm = warm.is_some();
            let of = match warm {
                Some((of, kept)) => (of, Some(kept)),
                None => take.estimate(is_free_auto, is_diagnosing, &mut watch)?,
            };
            Ok((of, is_warm))
        });
        if let Some(raised) = watch.raised.take() {
            return Err(raised);
        }
        let (of, is_warm) = found.map_err(|error| errors::of_any(py, &error))?;
        Ok(Self {
            is_warm,
            ..Self::new(take, of, watch)
        })
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
