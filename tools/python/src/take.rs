//! Takes.

use std::path::PathBuf;
use std::sync::Arc;

use enact::motion::{Holds, Mark, OpenTime, PoseSample, SampleSource, Stamp, TrackIndex};
use enact::service::TakeInMemory;
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::PyBytes;

use crate::errors;
use crate::estimate::Estimate;
use crate::numbers;
use crate::scene::{Scene, place};
use crate::watch::{Watch, limit};

/// A recording with the scene with which it is read.
#[pyclass(frozen, module = "enact_motion._core")]
pub struct Take {
    pub of: Arc<TakeInMemory>,
}

/// A mark that is proposed: event, time \[s since the first sample\], body, score.
type ProposedMark = (Option<String>, f64, Option<String>, Option<f64>);

/// Poses of one track, row by row: of a track that sees no orientation the quaternions are empty. Where the last is a number
/// they are keyframes of the body, within so many seconds of their times.
type Rows = (
    String,
    PyBackedBytes,
    PyBackedBytes,
    PyBackedBytes,
    Option<f64>,
);

#[pymethods]
impl Take {
    /// Of a file.
    #[staticmethod]
    fn of_file(py: Python<'_>, path: PathBuf, scene: Option<&Scene>) -> PyResult<Self> {
        let scene = scene.map(|scene| &scene.of);
        Self::read(py, || TakeInMemory::read(&path, scene))
    }

    /// Of the bytes of a file of that name.
    #[staticmethod]
    fn of_bytes(
        py: Python<'_>,
        name: PathBuf,
        bytes: &[u8],
        scene: Option<&Scene>,
    ) -> PyResult<Self> {
        let (bytes, scene) = (bytes.to_vec(), scene.map(|scene| &scene.of));
        Self::read(py, || TakeInMemory::of_bytes(&name, bytes, scene))
    }

    /// The bytes of a recording of poses (track, times \[s\], positions \[m\], quaternions x y z w) and marks (event, time).
    #[staticmethod]
    fn recording<'py>(
        py: Python<'py>,
        name: PathBuf,
        scene: &Scene,
        poses: Vec<Rows>,
        marks: Vec<(Option<String>, f64)>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let mut samples: Vec<(TrackIndex, PoseSample)> = Vec::new();
        for (track, times, positions, quaternions, within_s) in poses {
            let track = scene.track(&track)?;
            let [times_s, positions, quaternions] = [
                numbers::of_bytes(&times)?,
                numbers::of_bytes(&positions)?,
                numbers::of_bytes(&quaternions)?,
            ];
            let positions_m = positions.as_chunks::<3>().0.iter();
            let mut quaternions = quaternions.as_chunks::<4>().0.iter();
            for (time_s, position_m) in times_s.into_iter().zip(positions_m) {
                let quaternion = quaternions.next();
                let unturned = [0.0, 0.0, 0.0, 1.0];
                let pose = PoseSample::new(
                    Stamp(0).after(time_s),
                    (*position_m).into(),
                    quaternion.copied().unwrap_or(unturned),
                );
                let holds = match quaternion {
                    Some(_) => Holds::Pose,
                    None => Holds::Position,
                };
                let sample = PoseSample { holds, ..pose };
                samples.push((track, within_s.map_or(sample, |of| keyframe(sample, of))));
            }
        }
        let marks = marks.into_iter().map(|(event, time_s)| Mark {
            stamp: Stamp(0).after(time_s),
            event,
        });
        let marks: Vec<Mark> = marks.collect();
        let names = scene.of.scene.events.iter().map(|of| &of.name);
        for event in marks.iter().filter_map(|mark| mark.event.as_ref()) {
            // One of a repeated collision has a number after its name.
            let stem = event.trim_end_matches(|of: char| of.is_ascii_digit());
            let is_one_of = names.clone().any(|of| of == stem.trim_end());
            if !is_one_of {
                place("event", event, names.clone())?;
            }
        }
        let bytes = py.detach(|| scene.of.recording(&name, &samples, &marks));
        match bytes {
            Ok(bytes) => Ok(PyBytes::new(py, &bytes)),
            Err(error) => Err(errors::of_any(py, &error)),
        }
    }

    /// The same with a scene that has other goals.
    fn in_scene(&self, scene: &Scene) -> Self {
        Self {
            of: Arc::new(self.of.in_scene(&scene.of)),
        }
    }

    #[getter]
    fn bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, self.of.bytes())
    }

    #[getter]
    fn scene_toml(&self) -> String {
        String::from_utf8_lossy(self.of.scene_toml()).into_owned()
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.of.notes()
    }

    /// Where events may be.
    fn proposals(&self, py: Python<'_>, count: Option<usize>) -> PyResult<Vec<ProposedMark>> {
        let proposed = py.detach(|| self.of.propose(count));
        let proposed = proposed.map_err(|error| errors::of_any(py, &error))?;
        let scene = self.of.scene();
        let each = proposed.into_iter().map(|of| {
            let body = of.track.map(|track| scene.link_seen_by(track).name.clone());
            (of.event, of.time_s, body, of.score)
        });
        Ok(each.collect())
    }

    /// The motion as a preview has it.
    fn preview(&self, py: Python<'_>) -> PyResult<Estimate> {
        let mut watch = Watch::begin(None);
        let previewed = py.detach(|| self.of.preview(&mut watch));
        if let Some(raised) = watch.raised.take() {
            return Err(raised);
        }
        match previewed {
            Ok(of) => Ok(Estimate::new(self.of.clone(), (of, None), watch)),
            Err(error) => Err(errors::of_any(py, &error)),
        }
    }

    /// Estimates the motion without the interpreter; what a signal or `told` raises ends it.
    fn estimate(
        &self,
        py: Python<'_>,
        is_free_auto: bool,
        is_diagnosing: bool,
        deadline_s: Option<f64>,
        told: Option<Py<PyAny>>,
    ) -> PyResult<Estimate> {
        let mut watch = Watch::begin(limit(deadline_s)).telling(told);
        let estimated = py.detach(|| self.of.estimate(is_free_auto, is_diagnosing, &mut watch));
        if let Some(raised) = watch.raised.take() {
            return Err(raised);
        }
        match estimated {
            Ok(estimated) => Ok(Estimate::new(self.of.clone(), estimated, watch)),
            Err(error) => Err(errors::of_any(py, &error)),
        }
    }
}

/// A keyframe of a body: its time is within so many seconds of what was written, of which infinity is no bound.
fn keyframe(sample: PoseSample, within_s: f64) -> PoseSample {
    let within_ns = within_s
        .is_finite()
        .then_some((within_s * 1e9).round() as i64);
    // No time is before zero.
    let before_ns = within_ns.map(|of| of.min(sample.stamp.0));
    let open = OpenTime {
        before_ns,
        after_ns: within_ns,
    };
    PoseSample {
        from: SampleSource::Keyframe,
        open: (within_s > 0.0).then_some(open),
        ..sample
    }
}

impl Take {
    fn read(
        py: Python<'_>,
        read: impl FnOnce() -> anyhow::Result<TakeInMemory> + Send,
    ) -> PyResult<Self> {
        match py.detach(read) {
            Ok(take) => Ok(Self { of: Arc::new(take) }),
            Err(error) => Err(errors::of_any(py, &error)),
        }
    }
}
