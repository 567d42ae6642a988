//! What the tracks show of a flight, in the solver's terms.

use nalgebra::{Matrix6, Vector3};

use super::nodes::Nodes;
use crate::estimate::problem::{ArcSample, Shows, View, unit};
use crate::math::so3;
use crate::motion::{Quantity, Sample, Scene, Seen, Sees, Segment, Sketch, Track};

/// A unit of so many metres or radians, since no performance reaches as far,
const NOTHING: f64 = 30.0;
/// and of so many times what would weigh as much as the scene's of the other kind, weighs samples to nothing.
const NOTHING_BESIDE: f64 = 1e4;

/// The views of a segment: of every track one, or one of each kind of sample where it has several.
pub(in crate::estimate) fn views(
    scene: &Scene,
    sketch: &Sketch,
    segment: &Segment,
    nodes: &Nodes,
) -> Vec<View> {
    let mut views = Vec::new();
    for of in &segment.views {
        let track = &scene.tracks[of.track];
        let covariances = &sketch.tracks[of.track].covariances;
        let mut kinds: Vec<View> = Vec::new();
        let begun = |shows: Shows| View {
            track: of.track,
            shows,
            samples: Vec::with_capacity(of.samples.len()),
            units: units(scene, track, shows),
            whitenings: Vec::new(),
            informations: Vec::new(),
            is_plain: covariances.is_empty() && is_plain(track, shows),
        };
        for (sample, index) in sketch.samples_of(of).iter().zip(of.samples.clone()) {
            let shows = shows(track, &sample.seen);
            let at = kinds.iter().position(|view| view.shows == shows);
            let at = at.unwrap_or_else(|| {
                kinds.push(begun(shows));
                kinds.len() - 1
            });
            let open = scene.parameter_of(Quantity::SampleTime {
                track: of.track,
                sample: index,
            });
            let placed = placed(sample, shows, nodes);
            kinds[at].samples.push(ArcSample { open, ..placed });
            if let Some(covariance) = covariances.get(index) {
                let whitening = whitening(covariance, shows);
                kinds[at].informations.push(whitening.tr_mul(&whitening));
                kinds[at].whitenings.push(whitening);
            }
        }
        if kinds.is_empty() {
            kinds.push(begun(expected(track)));
        }
        views.extend(kinds);
    }
    views
}

fn shows(track: &Track, seen: &Seen) -> Shows {
    match (seen, track.sees) {
        (Seen::Pose { .. }, _) => Shows::Pose,
        (Seen::Point(_), _) => Shows::Point,
        (Seen::Orientation(_), _) => Shows::Orientation,
        (Seen::Direction(_), Sees::Direction(axis)) => Shows::Direction(axis.into_inner()),
        (Seen::Direction(_), _) => unreachable!("directions are of tracks that see one"),
    }
}

/// What the samples of a track show where messages hold all that it sees.
fn expected(track: &Track) -> Shows {
    match track.sees {
        Sees::Pose => Shows::Pose,
        Sees::Point => Shows::Point,
        Sees::Orientation => Shows::Orientation,
        Sees::Direction(axis) => Shows::Direction(axis.into_inner()),
    }
}

/// The short form of residuals has no lever and no single axis.
fn is_plain(track: &Track, shows: Shows) -> bool {
    match shows {
        Shows::Pose | Shows::Orientation => true,
        Shows::Point => track.point_m() == Vector3::zeros(),
        Shows::Direction(_) => false,
    }
}

/// Units of residuals of places \[m\] and orientations \[rad\], infinite where they are not seen or weigh
/// nothing.
fn units(scene: &Scene, track: &Track, shows: Shows) -> [f64; 2] {
    let weights = track.weights(&scene.weights);
    let units = [weights.position_m, weights.orientation_rad];
    // What weighs as much as the scene's units of the other kind.
    let beside = [
        scene.weights.orientation_rad * (unit::POSITION_M / unit::ORIENTATION_RAD),
        scene.weights.position_m * (unit::ORIENTATION_RAD / unit::POSITION_M),
    ];
    std::array::from_fn(|kind| {
        let counts = units[kind] < NOTHING.max(NOTHING_BESIDE * beside[kind]);
        if shows.kinds()[kind] && counts {
            units[kind]
        } else {
            f64::INFINITY
        }
    })
}

fn placed(sample: &Sample, shows: Shows, nodes: &Nodes) -> ArcSample {
    let (node, share) = nodes.place(sample.acted_s);
    let orientation = match (sample.seen, shows) {
        (Seen::Direction(direction), Shows::Direction(axis)) => so3::between(&axis, &direction),
        (seen, _) => seen.orientation().unwrap_or_default(),
    };
    ArcSample {
        stamp: sample.stamp,
        position_m: sample.seen.position_m().unwrap_or_default(),
        orientation,
        node,
        share,
        open: None,
    }
}

/// `L⁻¹` of the covariance `L Lᵀ` of what is seen; zero in the rest.
fn whitening(covariance: &Matrix6<f64>, shows: Shows) -> Matrix6<f64> {
    let mut seen = *covariance;
    for (kind, is_seen) in shows.kinds().into_iter().enumerate() {
        if !is_seen {
            for at in 3 * kind..3 * kind + 3 {
                seen.row_mut(at).fill(0.0);
                seen.column_mut(at).fill(0.0);
                seen[(at, at)] = 1.0;
            }
        }
    }
    let factor = seen.cholesky().expect("cleaning keeps sound covariances");
    let mut inverse = Matrix6::identity();
    factor.l_dirty().solve_lower_triangular_mut(&mut inverse);
    for (kind, is_seen) in shows.kinds().into_iter().enumerate() {
        if !is_seen {
            inverse.rows_mut(3 * kind, 3).fill(0.0);
        }
    }
    inverse
}
