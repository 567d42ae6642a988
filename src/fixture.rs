//! A scene, its estimate and its sketch, for the tests of rooms that say, sample and write them.

use nalgebra::{UnitQuaternion, Vector3};

use crate::config::scene_from_toml;
use crate::motion::{
    ArcEstimate, Counters, DurationEstimate, End, Estimate, EventEstimate, FitUntold, Gap,
    MechanismIndex, ParameterEstimate, Progress, Sample, SampleCounts, SampleTime, Scene,
    SegmentResidual, Sketch, Stamp, TrackIndex, TrackSketch, Undetermined, Verdict,
};
use crate::physics::State;

pub(crate) const SCENE_TOML: &str = r#"
name = "pencil"
[timing]
stamps = "tempo"
[[body]]
name = "pencil"
shape = { kind = "cylinder", length_mm = 190, radius_mm = 3.75 }
mass_g = 6.0
features_mm = { tip = [0, 0, -95] }
[[surface]]
name = "table"
point_mm = [0, 0, 0]
normal = [0, 0, 1]
[[obstacle]]
name = "mug floor"
shape = { kind = "cylinder", length_mm = 5, radius_mm = 44 }
position_mm = [0, 0, 2.5]
[[event]]
name = "bounce"
kind = "collision"
body = "pencil"
feature = "tip"
surface = "table"
restitution = 0.75
[[event]]
name = "landing"
kind = "end"
[[goal]]
event = "landing"
body = "pencil"
position_mm = [0, 0, 100]
orientation_wxyz = [1, 0, 0, 0]
"#;

/// First stamp of the take \[ns\].
pub(crate) const FIRST_NS: i64 = 1_700_000_000_000_000_000;

pub(crate) fn scene() -> Scene {
    scene_from_toml(SCENE_TOML).expect("a valid scene")
}

fn state(z: f64, vz: f64) -> State {
    State {
        position_m: Vector3::new(0.1, 0.0, z),
        orientation: UnitQuaternion::identity(),
        velocity_m_s: Vector3::new(0.0, 0.0, vz),
        angular_velocity_rad_s: Vector3::new(0.0, 12.0, 0.0),
    }
}

/// Twenty samples acted in 1.9 s of a motion of 0.475 s: physical time is a quarter of acted.
pub(crate) fn sketch() -> Sketch {
    let samples = (0..20)
        .map(|k| {
            Sample::of_pose(
                Stamp(FIRST_NS + k * 100_000_000),
                k as f64 * 0.1,
                Vector3::new(0.1, 0.0, 0.3 + 0.01 * k as f64),
                UnitQuaternion::identity(),
            )
        })
        .collect();
    Sketch {
        origin: Stamp(FIRST_NS),
        tracks: [TrackSketch::new(samples)].into_iter().collect(),
        marks_s: vec![0.8, 1.9],
        contacts_s: Default::default(),
        cuts_sd_s: Default::default(),
        marks: vec![None; 2],
    }
}

pub(crate) fn estimate() -> Estimate {
    let arc = |epoch_s, state, start_s, end_s| ArcEstimate {
        mechanism: MechanismIndex(0),
        epoch_s,
        state,
        start_s,
        end_s,
        support: None,
        certainty: None,
    };
    let event = |event, time_s, acted_s, sd_s| EventEstimate {
        contact_s: 0.0,
        event,
        time_s,
        sd_s,
        is_fixed: sd_s.is_none(),
        at_bound: None,
        acted_s,
        gap: Gap::default(),
        leaning: None,
    };
    Estimate {
        verdict: Verdict::Physical,
        reason: End::Converged(Progress::default()).into(),
        doubts: Vec::new(),
        fit: Err(FitUntold::NotAsked),
        suspects: Vec::new(),
        objective: 1.5,
        gravity_m_s2: Vector3::new(0.0, 0.0, -9.80665),
        arcs: vec![
            arc(0.1, state(0.35, -1.0), 0.0, 0.2),
            arc(0.2, state(0.2, 2.0), 0.2, 0.475),
        ],
        held: Vec::new(),
        grips: Vec::new(),
        trees: Vec::new(),
        events: vec![event(0, 0.2, 0.8, Some(0.001)), event(1, 0.475, 1.9, None)],
        parameters: vec![ParameterEstimate {
            name: "bounce.restitution".to_owned(),
            value: 0.75,
            sd: None,
            at_bound: None,
            lower: 0.0,
            upper: f64::INFINITY,
        }],
        residuals: vec![
            SegmentResidual {
                track: TrackIndex(0),
                samples: 8,
                arc: 0,
                position_rms_m: Some(0.01),
                orientation_rms_rad: Some(0.02),
            };
            2
        ],
        sample_times: (0..20)
            .map(|k| SampleTime {
                track: TrackIndex(0),
                stamp: Stamp(FIRST_NS + k * 100_000_000),
                time_s: k as f64 * 0.025,
                is_open: false,
            })
            .collect(),
        duration: DurationEstimate {
            duration_s: 0.475,
            sd_s: Some(0.012),
        },
        rivals: 0,
        contact_rivals: Vec::new(),
        undetermined: vec![Undetermined::Parameter(0)],
        counters: Counters::default(),
    }
}

pub(crate) fn counts() -> SampleCounts {
    SampleCounts {
        read: 20,
        used: 20,
        ..SampleCounts::default()
    }
}
