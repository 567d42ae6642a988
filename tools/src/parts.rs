//! Performances of which trackers see parts: the centre of mass, points, orientations, directions; one
//! tracker or several, at rates and on clocks of their own.

use enact::math::Pose;
use enact::motion::{
    Covariance, FreeParameter, Holds, LinkIndex, PoseSample, Quantity, Scene, Seen, Sees, Sketch,
    Stamp, TakeEvent, Track, TrackIndex, Weighing, Weights,
};
use nalgebra::{UnitQuaternion, UnitVector3, Vector3};

use crate::case::Case;

/// What trackers see of the first body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Its pose, as it was performed.
    Pose,
    /// Its centre of mass.
    Centre,
    /// The same from a pose whose orientation has a weight of nothing.
    Unweighed,
    /// Its first feature.
    Point,
    /// Both its ends: the first feature and what is opposite.
    Ends,
    /// Its orientation.
    Orientation,
    /// Its centre of mass, and the direction of its longest axis.
    Axis,
    /// Its pose by one tracker, its centre by another at a third of the rate whose clock is late.
    LateCentre,
    /// Its pose with covariances in the messages, three times as good along one axis.
    Covariances,
}

/// By how much the clock of the second tracker is late \[s\].
pub const LATE_S: f64 = 0.011;

impl Part {
    /// All of them.
    pub const ALL: [Part; 9] = [
        Part::Pose,
        Part::Centre,
        Part::Unweighed,
        Part::Point,
        Part::Ends,
        Part::Orientation,
        Part::Axis,
        Part::LateCentre,
        Part::Covariances,
    ];

    /// Whether it leaves the motion so open that it is found slowly.
    pub fn is_slow(self) -> bool {
        matches!(self, Part::Point | Part::Ends | Part::Axis)
    }

    /// Its name on pages.
    pub fn as_str(self) -> &'static str {
        match self {
            Part::Pose => "pose",
            Part::Centre => "centre of mass",
            Part::Unweighed => "pose, orientation weighed to nothing",
            Part::Point => "one point",
            Part::Ends => "two points",
            Part::Orientation => "orientation",
            Part::Axis => "centre of mass and direction",
            Part::LateCentre => "pose, and centre on another clock",
            Part::Covariances => "pose with covariances",
        }
    }

    /// The scene with these tracks, and the take of a performance as they see it.
    pub fn seen(self, case: &Case) -> (Scene, Vec<TakeEvent>) {
        let mut scene = case.scene().clone();
        let sketch = case.performance.sketch();
        let link = LinkIndex(0);
        let end_m = scene.links[link].features[0].geometry.place_m();
        let axis = UnitVector3::new_normalize(Vector3::ith(
            scene.links[link].body.moments_kg_m2().imin(),
            1.0,
        ));
        let own = scene.weights;
        let kinds: Vec<(Sees, Vector3<f64>, Weighing)> = match self {
            Part::Pose => vec![(Sees::Pose, Vector3::zeros(), Weighing::Scene)],
            Part::Unweighed => {
                let nothing = Weights {
                    orientation_rad: 1e6,
                    ..own
                };
                vec![(Sees::Pose, Vector3::zeros(), Weighing::Own(nothing))]
            }
            Part::Centre => vec![(Sees::Point, Vector3::zeros(), Weighing::Scene)],
            Part::Point => vec![(Sees::Point, end_m, Weighing::Scene)],
            Part::Ends => vec![
                (Sees::Point, end_m, Weighing::Scene),
                (Sees::Point, -end_m, Weighing::Scene),
            ],
            Part::Orientation => vec![(Sees::Orientation, Vector3::zeros(), Weighing::Scene)],
            Part::Axis => vec![
                (Sees::Point, Vector3::zeros(), Weighing::Scene),
                (Sees::Direction(axis), Vector3::zeros(), Weighing::Scene),
            ],
            Part::LateCentre => vec![
                (Sees::Pose, Vector3::zeros(), Weighing::Scene),
                (Sees::Point, Vector3::zeros(), Weighing::Scene),
            ],
            Part::Covariances => vec![(Sees::Pose, Vector3::zeros(), Weighing::Messages)],
        };
        scene.tracks = kinds
            .iter()
            .enumerate()
            .map(|(number, (sees, place_m, weighing))| Track {
                name: format!("{}.{number}", scene.links[link].name),
                topic: format!("/part/{number}"),
                link,
                link_from_tracker: Pose::from_parts((*place_m).into(), UnitQuaternion::identity()),
                sees: *sees,
                weighing: *weighing,
            })
            .collect();
        let marks = case.performance.events.iter();
        let marks = marks.filter(|event| matches!(event, TakeEvent::Mark(_)));
        let mut events: Vec<TakeEvent> = marks.cloned().collect();
        for (track, of) in scene.tracks.iter_enumerated() {
            events.extend(self.readings(&sketch, (track, of), own));
        }
        if self == Part::LateCentre {
            scene.parameters.push(FreeParameter {
                name: "late".into(),
                quantity: Quantity::ClockOffset {
                    track: TrackIndex(1),
                },
                initial: 0.0,
                lower: f64::NEG_INFINITY,
                upper: f64::INFINITY,
                prior_sd: None,
            });
        }
        (scene, events)
    }

    fn readings(
        self,
        sketch: &Sketch,
        (track, of): (TrackIndex, &Track),
        weights: Weights,
    ) -> Vec<TakeEvent> {
        let is_late = self == Part::LateCentre && track == TrackIndex(1);
        let samples = sketch.tracks[TrackIndex(0)].samples.iter();
        let readings = samples.enumerate().filter_map(|(number, sample)| {
            let Seen::Pose {
                position_m,
                orientation,
            } = sample.seen
            else {
                return None;
            };
            if is_late && number % 3 != 1 {
                return None;
            }
            let (place_m, holds) = match of.sees {
                Sees::Pose => (position_m, Holds::Pose),
                Sees::Point => (position_m + orientation * of.point_m(), Holds::Position),
                Sees::Orientation => (Vector3::zeros(), Holds::Orientation),
                Sees::Direction(axis) => ((orientation * axis).into_inner(), Holds::Direction),
            };
            let late_ns = if is_late { (LATE_S * 1e9) as i64 } else { 0 };
            let q = orientation.quaternion();
            let quaternion_xyzw = [q.i, q.j, q.k, q.w];
            let mut reading =
                PoseSample::new(Stamp(sample.stamp.0 + late_ns), place_m, quaternion_xyzw);
            reading.holds = holds;
            if self == Part::Covariances {
                let mut rows = [0.0; 36];
                for axis in 0..6 {
                    let unit = [weights.position_m, weights.orientation_rad][axis / 3];
                    let better = if axis % 3 == 0 { 3.0 } else { 1.0 };
                    rows[7 * axis] = (unit / better).powi(2);
                }
                reading.covariance = Some(Covariance::of_rows(&rows));
            }
            Some(TakeEvent::Pose {
                track,
                stream: 0,
                sample: reading,
            })
        });
        readings.collect()
    }
}
