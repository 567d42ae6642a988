//! How fast a recording goes through: read, taken for a scene, written with an estimate; against
//! copying the same file, message by message, with the `mcap` crate and the same compression.
//!
//! ```text
//! cargo run --release -p enact-tools --bin throughput -- [MESSAGES] [RUNS]
//! ```
//!
//! Both read the whole file into memory first and end with `fsync`. Times are the least of the
//! runs, which alternate.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use enact::config::scene_from_toml;
use enact::ingest::Recording;
use enact::motion::{
    ArcEstimate, Counters, DurationEstimate, End, Estimate, FitUntold, Mark, MechanismIndex,
    PoseSample, Progress, SampleCounts, Sketch, Stamp, Verdict,
};
use enact::physics::State;
use enact::report::Reported;
use enact::write::{DEFAULT_FRAME_RATE_HZ, EstimateFile, RecordingWriter, write_estimate};
use nalgebra::{UnitQuaternion, Vector3};
use typed_index_collections::TiVec;

const SCENE: &str = r#"
name = "throughput"
[timing]
stamps = "physical"
[[body]]
name = "pencil"
shape = { kind = "cylinder", length_mm = 190, radius_mm = 3.75 }
mass_g = 6.0
[[event]]
name = "start"
kind = "start"
[[event]]
name = "end"
kind = "end"
"#;

/// A second of motion: what is added to the file is little, what is copied is much.
fn estimate() -> Estimate {
    Estimate {
        verdict: Verdict::Physical,
        reason: End::Converged(Progress::default()).into(),
        doubts: Vec::new(),
        fit: Err(FitUntold::NotAsked),
        suspects: Vec::new(),
        objective: 0.0,
        gravity_m_s2: Vector3::new(0.0, 0.0, -9.80665),
        arcs: vec![ArcEstimate {
            mechanism: MechanismIndex(0),
            epoch_s: 0.0,
            state: State {
                position_m: Vector3::zeros(),
                orientation: UnitQuaternion::identity(),
                velocity_m_s: Vector3::zeros(),
                angular_velocity_rad_s: Vector3::zeros(),
            },
            start_s: 0.0,
            end_s: 1.0,
            support: None,
            certainty: None,
        }],
        held: Vec::new(),
        grips: Vec::new(),
        trees: Vec::new(),
        events: Vec::new(),
        duration: DurationEstimate {
            duration_s: 1.0,
            sd_s: Some(0.0),
        },
        parameters: Vec::new(),
        residuals: Vec::new(),
        sample_times: Vec::new(),
        rivals: 0,
        contact_rivals: Vec::new(),
        undetermined: Vec::new(),
        counters: Counters::default(),
    }
}

fn make(path: &Path, messages: i64) -> Result<()> {
    let mut recording = RecordingWriter::create(path)?;
    recording.attach("scene.toml", "application/toml", SCENE.as_bytes())?;
    for k in 0..messages {
        let stamp = Stamp(1_700_000_000_000_000_000 + k * 1_000_000);
        let t = k as f64 * 1e-3;
        let sample = PoseSample::new(
            stamp,
            Vector3::new(t.sin(), (1.3 * t).cos(), (0.7 * t).sin()),
            [0.0, 0.0, (0.5 * t).sin(), (0.5 * t).cos()],
        );
        recording.pose("/tracker/pencil/pose", "world", stamp, &sample)?;
        if k == 0 {
            let mark = Mark { stamp, event: None };
            recording.mark("/marks", stamp, &mark)?;
        }
    }
    Ok(recording.finish()?)
}

fn copy(input: &Path, output: &Path) -> Result<u64> {
    let bytes = std::fs::read(input)?;
    let mut writer = mcap::WriteOptions::new()
        .compression(Some(mcap::Compression::Zstd))
        .compression_level(1)
        .compression_threads(0)
        .create(BufWriter::with_capacity(1 << 20, File::create(output)?))?;
    let mut count = 0;
    for message in mcap::MessageStream::new(&bytes)? {
        writer.write(&message?)?;
        count += 1;
    }
    writer.finish()?;
    let mut file = writer.into_inner();
    file.flush()?;
    file.get_ref().sync_all()?;
    Ok(count)
}

fn process(input: &Path, output: &Path) -> Result<u64> {
    let scene = scene_from_toml(SCENE)?;
    let recording = Recording::open(input)?;
    let take = recording.take(&scene)?;
    let sketch = Sketch {
        origin: Stamp(1_700_000_000_000_000_000),
        tracks: TiVec::new(),
        marks_s: Vec::new(),
        contacts_s: Default::default(),
        cuts_sd_s: Default::default(),
        marks: Vec::new(),
    };
    let written = write_estimate(
        output,
        &EstimateFile {
            input: recording.container(),
            made_of: &[input],
            of: Reported {
                scene: &scene,
                inferred: &[],
                sketch: &sketch,
                counts: &SampleCounts::default(),
                estimate: &estimate(),
                verification: None,
                settled: None,
                diagnoses: &[],
                seen: &[],
                freed: &[],
                rest: None,
            },
            scene_toml: recording.scene_toml().context("a scene")?,
            provenance: None,
            world_frame: "world",
            log_offset_ns: take.report.log_offset_ns.unwrap_or(0),
            frame_rate_hz: DEFAULT_FRAME_RATE_HZ,
        },
    )?;
    ensure!(take.events.len() as u64 == written.copied);
    Ok(written.copied)
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let messages: i64 = arguments
        .next()
        .map_or(Ok(2_000_000), |text| text.parse())?;
    let runs: usize = arguments.next().map_or(Ok(5), |text| text.parse())?;
    let directory = tempfile::tempdir()?;
    let input = directory.path().join("in.mcap");
    make(&input, messages)?;
    let size_mb = std::fs::metadata(&input)?.len() as f64 * 1e-6;
    let (mut copying_s, mut ours_s) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..runs {
        let begin = Instant::now();
        let copied = copy(&input, &directory.path().join("copy.mcap"))?;
        copying_s = copying_s.min(begin.elapsed().as_secs_f64());
        let begin = Instant::now();
        let ours = process(&input, &directory.path().join("out.mcap"))?;
        ours_s = ours_s.min(begin.elapsed().as_secs_f64());
        ensure!(copied == ours, "{copied} messages copied, {ours} processed");
    }
    println!("messages            {messages} poses, {size_mb:.1} MB compressed");
    println!(
        "copying with mcap   {copying_s:.3} s  {:.0} k/s",
        messages as f64 / copying_s / 1e3
    );
    println!(
        "read, taken, written {ours_s:.3} s  {:.0} k/s",
        messages as f64 / ours_s / 1e3
    );
    println!("speed ratio         {:.2}", copying_s / ours_s);
    Ok(())
}
