//! One answer from many takes.

use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use enact::service::{
    AskedNames, FitInput, FitJob, FitQuestion, FitStop, FittedTakes, HoldOut, JoinedBlocks,
    SceneInMemory, TakeBlock, fit, join, reduce,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors;
use crate::take::Take;

/// So often it is looked for signals.
const BETWEEN: Duration = Duration::from_millis(20);

/// A recording: a file, or a take.
#[derive(FromPyObject)]
pub enum Input {
    File(PathBuf),
    Take {
        #[pyo3(item)]
        name: PathBuf,
        #[pyo3(item)]
        core: Py<Take>,
    },
}

/// How takes are held out: a share of them, or files.
#[derive(FromPyObject)]
pub enum Held {
    Share(f64),
    Files(Vec<PathBuf>),
}

fn input(of: Input) -> FitInput {
    match of {
        Input::File(path) => FitInput::File(path),
        Input::Take { name, core } => {
            let take = &core.get().of;
            let toml = String::from_utf8_lossy(take.scene_toml()).into_owned();
            let (scene, file) = (take.scene().clone(), None);
            FitInput::Bytes {
                name,
                bytes: take.bytes().to_vec(),
                scene: Some(Box::new(SceneInMemory { scene, toml, file })),
            }
        }
    }
}

/// An answer as texts: JSON of it and of its takes, and the calibration.
type Texts = (String, String, String);

fn texts(fitted: &FittedTakes) -> PyResult<Texts> {
    let refused = |error: serde_json::Error| PyValueError::new_err(error.to_string());
    let line = serde_json::to_string(&fitted.line).map_err(refused)?;
    let takes = serde_json::to_string(&fitted.takes).map_err(refused)?;
    Ok((line, takes, fitted.toml.clone()))
}

/// What takes share. Without the interpreter; what a signal raises ends it between takes.
#[pyfunction]
pub fn fit_takes(
    py: Python<'_>,
    inputs: Vec<Input>,
    shared: Vec<String>,
    drawn: Vec<String>,
    hold_out: Option<Held>,
) -> PyResult<Texts> {
    let stop = FitStop::default();
    let job = FitJob {
        inputs: inputs.into_iter().map(input).collect(),
        scene: None,
        shared,
        drawn,
        hold_out: hold_out.map(|held| match held {
            Held::Share(share) => HoldOut::Share(share),
            Held::Files(files) => HoldOut::Files(files),
        }),
        output: None,
        page: None,
        stop: stop.clone(),
    };
    let (fitted, raised) = py.detach(|| {
        thread::scope(|scope| {
            let working = scope.spawn(|| fit(&job));
            let mut raised: Option<PyErr> = None;
            while !working.is_finished() {
                thread::sleep(BETWEEN);
                if raised.is_none() {
                    raised = Python::attach(|py| py.check_signals()).err();
                    raised.iter().for_each(|_| stop.set());
                }
            }
            (working.join(), raised)
        })
    });
    if let Some(raised) = raised {
        return Err(raised);
    }
    match fitted {
        Ok(Ok(fitted)) => texts(&fitted),
        Ok(Err(error)) => Err(errors::of_any(py, &error)),
        Err(panic) => std::panic::resume_unwind(panic),
    }
}

/// The block of a take, JSON; none of one that the question does not ask.
#[pyfunction]
pub fn reduce_take<'py>(
    py: Python<'py>,
    of: Input,
    shared: Vec<String>,
    drawn: Vec<String>,
    question: Option<&[u8]>,
) -> PyResult<Option<Bound<'py, PyBytes>>> {
    let refused = |what: &str, error: &serde_json::Error| {
        PyValueError::new_err(format!("{what}: {error}, expected what join gave"))
    };
    let names = AskedNames::new(&shared, &drawn).map_err(|error| errors::of_any(py, &error))?;
    let question: Option<FitQuestion> = question
        .map(serde_json::from_slice)
        .transpose()
        .map_err(|error| refused("question", &error))?;
    let of = input(of);
    let block = py.detach(|| reduce(&of, None, &names, question.as_ref()));
    let Some(block) = block.map_err(|error| errors::of_any(py, &error))? else {
        return Ok(None);
    };
    let text = serde_json::to_vec(&block).map_err(|error| refused("block", &error))?;
    Ok(Some(PyBytes::new(py, &text)))
}

/// The answer of blocks, or the question that comes next.
#[pyfunction]
pub fn join_blocks(
    py: Python<'_>,
    blocks: Vec<Vec<u8>>,
) -> PyResult<(Option<Vec<u8>>, Option<Texts>)> {
    let each = blocks.iter().enumerate().map(|(at, block)| {
        serde_json::from_slice(block).map_err(|error| {
            PyValueError::new_err(format!("blocks[{at}]: {error}, expected what reduce gave"))
        })
    });
    let blocks: Vec<TakeBlock> = each.collect::<PyResult<_>>()?;
    match py.detach(|| join(&blocks, None, None)) {
        Ok(JoinedBlocks::Fitted(fitted)) => Ok((None, Some(texts(&fitted)?))),
        Ok(JoinedBlocks::Asks(question)) => {
            let text = serde_json::to_vec(&question);
            let text = text.map_err(|error| PyValueError::new_err(error.to_string()))?;
            Ok((Some(text), None))
        }
        Err(error) => Err(errors::of_any(py, &error)),
    }
}
