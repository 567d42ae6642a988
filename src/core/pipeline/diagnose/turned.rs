//! How a tracker is turned on its body, by the body's own motion.
//!
//! A mount `M` that is taken for `M₀` makes the body's axes others by one rotation `E = M M₀⁻¹`: what is taken for
//! the body's orientation is `R̂ = R E`. In free flight the angular momentum `R I Rᵀ ω` is constant, so that with
//! the tensor `J = Eᵀ I E` of the wrong axes
//!
//! ```text
//! S_k = Σ_{i<k} R̂_i exp(φ_i/2) J φ_i = L t_k + c,    φ_i = log(R̂_iᵀ R̂_{i+1})
//! ```
//!
//! is a straight line: linear in `J`, in steady time where stamps are physical. Noise adds as much for every `E`.
//! The line tells `E` up to the turns that leave the tensor as it is: half turns about principal axes, any turn about
//! an axis of symmetry, and all turns of a body whose moments are equal. Goals of poses, which a performance ends
//! near, tell those.

use nalgebra::{Matrix3, Matrix6, SMatrix, SymmetricEigen, UnitQuaternion, Vector3, Vector6};

use super::facts::Facts;
use super::motion::TriedFlight;
use crate::math::Pose;
use crate::math::so3::{exp, log, matrix};
use crate::motion::{Quantity, Sees, TrackIndex};

/// Greatest share of what bends the line that another turn may leave, to be looked into.
const STRAIGHT: f64 = 0.5;
/// Moments nearer than this to one another, relative to the greatest, tell no axis.
const SAME_MOMENT: f64 = 0.02;
/// Least turn that is a mistake of its own, beyond what a mount is typed to \[rad\].
const LEAST_RAD: f64 = 0.1;
/// Step of the differences by which a search for a turn sees slopes, and last step of the search \[rad\].
const STEP_RAD: f64 = 1e-3;
const LAST_RAD: f64 = 1e-6;
/// Most steps of a search: along turns that change nothing there is no end.
const STEPS: usize = 30;
/// First damping of a step, relative to the curvature, the factor on it after one that fails, and the greatest.
const DAMPING: [f64; 3] = [1e-3, 10.0, 1e6];
/// Least number of samples of a flight.
const LEAST: usize = 6;
/// Most turns that are tried.
const MOST: usize = 6;

/// Other mounts of a tracker, turned by what flights and goals show, that which explains them most first; none where
/// it sees no orientation.
pub(super) fn mounts(facts: &Facts, track: TrackIndex) -> Vec<Pose> {
    let seen = &facts.scene.tracks[track];
    let turn = Quantity::TrackerOrientation { track, axis: 0 };
    let is_told = !facts.scene.is_held(seen.link) && facts.scene.untold(turn).is_none();
    if seen.sees != Sees::Pose || !is_told {
        return Vec::new();
    }
    let mut turns = by_flights(facts, track);
    let by_goals = facts.seen.iter().filter(|flight| flight.track == track);
    turns.extend(by_goals.filter_map(by_goal));
    let mut kept: Vec<UnitQuaternion<f64>> = Vec::new();
    for turn in turns {
        let is_new = kept.iter().all(|other| other.angle_to(&turn) > LEAST_RAD);
        if turn.angle() > LEAST_RAD && is_new {
            kept.push(turn);
        }
    }
    kept.truncate(MOST);
    let turned = kept.into_iter().map(|turn| {
        let given = seen.link_from_tracker;
        Pose::from_parts(given.translation, turn * given.rotation)
    });
    turned.collect()
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum TurnSymmetry {
    None,
    /// About this axis.
    Axis(usize),
    Sphere,
}

fn symmetry(moments: &Vector3<f64>) -> TurnSymmetry {
    let is_same =
        |a: usize, b: usize| (moments[a] - moments[b]).abs() < SAME_MOMENT * moments.max();
    match [is_same(1, 2), is_same(2, 0), is_same(0, 1)] {
        [false, false, false] => TurnSymmetry::None,
        [true, false, false] => TurnSymmetry::Axis(0),
        [false, true, false] => TurnSymmetry::Axis(1),
        [false, false, true] => TurnSymmetry::Axis(2),
        _ => TurnSymmetry::Sphere,
    }
}

/// The turn that brings what is taken for the body at the end of a flight to the pose that the scene asks there.
fn by_goal(flight: &TriedFlight) -> Option<UnitQuaternion<f64>> {
    let (_, last) = flight.readings.last()?;
    Some(flight.goal?.inverse() * last.seen.orientation()?)
}

/// Turns with which the angular momentum of the flights is steadier: all that the flights do not tell apart.
fn by_flights(facts: &Facts, track: TrackIndex) -> Vec<UnitQuaternion<f64>> {
    let scene = facts.scene;
    let body = &scene.links[scene.tracks[track].link].body;
    let moments = body.moments_kg_m2() / body.moments_kg_m2().max();
    let symmetry = symmetry(&moments);
    if symmetry == TurnSymmetry::Sphere {
        return Vec::new();
    }
    let of_track = facts.seen.iter().filter(|flight| flight.track == track);
    let bends: Vec<Bend> = of_track
        .filter_map(|flight| Bend::of(flight, facts.is_timed()))
        .collect();
    let bent = |turn: &UnitQuaternion<f64>| -> f64 {
        let turn = matrix(turn);
        let tensor = turn.transpose() * Matrix3::from_diagonal(&moments) * turn;
        bends.iter().map(|bend| bend.by(&tensor)).sum()
    };
    let as_said = bent(&UnitQuaternion::identity());
    let (best, left) = least(&bent);
    if left >= STRAIGHT * as_said {
        return Vec::new();
    }
    let half = |axis: usize| exp(&(Vector3::ith(axis, std::f64::consts::PI)));
    let mut alike: Vec<UnitQuaternion<f64>> = match symmetry {
        TurnSymmetry::Axis(axis) => {
            let across = half((axis + 1) % 3);
            [best, across * best]
                .map(|turn| least_about(axis, &turn))
                .into()
        }
        _ => {
            let halves = (0..3).map(|axis| half(axis) * best);
            std::iter::once(best).chain(halves).collect()
        }
    };
    alike.sort_by(|a, b| a.angle().total_cmp(&b.angle()));
    alike
}

/// The least of all turns that differ from one by a turn about an axis of the body.
fn least_about(axis: usize, turn: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    let q = turn.quaternion();
    let about_rad = -2.0 * q.imag()[axis].atan2(q.w);
    exp(&(Vector3::ith(axis, about_rad))) * turn
}

/// Turns from which a search finds any: those that bring axes to axes or halfway between.
fn starts() -> Vec<UnitQuaternion<f64>> {
    let quarter = std::f64::consts::FRAC_PI_4;
    let steps = || (0..4).map(move |step| f64::from(step) * 2.0 * quarter - quarter);
    let all = steps().flat_map(|x| {
        steps().flat_map(move |y| steps().map(move |z| UnitQuaternion::from_euler_angles(x, y, z)))
    });
    std::iter::once(UnitQuaternion::identity())
        .chain(all)
        .collect()
}

/// The turn at which a function is least, and its value there.
fn least(of: &dyn Fn(&UnitQuaternion<f64>) -> f64) -> (UnitQuaternion<f64>, f64) {
    let ends = starts().into_iter().map(|start| descended(start, of));
    ends.fold((UnitQuaternion::identity(), f64::INFINITY), |best, end| {
        if end.1 < best.1 { end } else { best }
    })
}

/// The turn near a start at which a function is least: Newton's steps with derivatives by central differences, damped as
/// Levenberg and Marquardt do.
fn descended(
    start: UnitQuaternion<f64>,
    of: &dyn Fn(&UnitQuaternion<f64>) -> f64,
) -> (UnitQuaternion<f64>, f64) {
    let (mut at, mut least) = (start, of(&start));
    let [mut damping, factor, most] = DAMPING;
    for _ in 0..STEPS {
        let there = |by: Vector3<f64>| of(&(at * exp(&by)));
        let step = |axis: usize| Vector3::ith(axis, STEP_RAD);
        let sides = [1.0, -1.0].map(|sign| [0, 1, 2].map(|axis| there(sign * step(axis))));
        let slope = Vector3::from_fn(|i, _| (sides[0][i] - sides[1][i]) / (2.0 * STEP_RAD));
        let curvature = Matrix3::from_fn(|i, j| {
            let both = match i == j {
                true => sides[0][i] + sides[1][i] - 2.0 * least,
                false => {
                    let corners = there(step(i) + step(j)) + there(-step(i) - step(j));
                    let of_sides = sides[0][i] + sides[0][j] + sides[1][i] + sides[1][j];
                    0.5 * (corners - of_sides + 2.0 * least)
                }
            };
            both / (STEP_RAD * STEP_RAD)
        });
        let scale = curvature.diagonal().abs().sum();
        let mut next = None;
        while next.is_none() && damping < most {
            let damped = curvature + Matrix3::identity() * (damping * scale);
            let by = damped.cholesky().map(|factor| -factor.solve(&slope));
            next = by
                .map(|by| (by, there(by)))
                .filter(|(_, lower)| *lower < least);
            damping *= if next.is_some() {
                factor.recip()
            } else {
                factor
            };
        }
        let Some((by, lower)) = next else {
            break;
        };
        (at, least) = (at * exp(&by), lower);
        if by.norm() < LAST_RAD {
            break;
        }
    }
    (at, least)
}

/// How far a flight's `S_k` are from a line, as a function of the tensor: of its six entries the quadratic forms
/// of each pair of axes.
struct Bend {
    forms: [[Matrix6<f64>; 3]; 3],
    /// Whether the line is one in time, so that nothing may be left of it.
    is_timed: bool,
}

impl Bend {
    /// `None` where the flight has too few readings.
    fn of(flight: &TriedFlight, is_timed: bool) -> Option<Self> {
        let turns: Vec<(f64, UnitQuaternion<f64>)> = flight
            .readings
            .iter()
            .filter_map(|(time_s, sample)| Some((*time_s, sample.seen.orientation()?)))
            .collect();
        if turns.len() < LEAST {
            return None;
        }
        let mut sum = SMatrix::<f64, 3, 6>::zeros();
        let mut rows = vec![sum];
        for pair in turns.windows(2) {
            let turned = log(&(pair[0].1.inverse() * pair[1].1));
            sum += matrix(&(pair[0].1 * exp(&(0.5 * turned)))) * acting_on(&turned);
            rows.push(sum);
        }
        // What is left of the mean, and of steady time where that is known.
        let count = rows.len() as f64;
        let mean: SMatrix<f64, 3, 6> = rows.iter().sum::<SMatrix<f64, 3, 6>>() / count;
        let mean_s = turns.iter().map(|(s, _)| s).sum::<f64>() / count;
        let square_s2: f64 = turns.iter().map(|(s, _)| (s - mean_s).powi(2)).sum();
        if !(square_s2 > 0.0) {
            return None;
        }
        let slope: SMatrix<f64, 3, 6> = rows
            .iter()
            .zip(&turns)
            .map(|(row, (s, _))| row * ((s - mean_s) / square_s2))
            .sum();
        let mut forms = [[Matrix6::zeros(); 3]; 3];
        for (row, (s, _)) in rows.iter().zip(&turns) {
            let left = match is_timed {
                true => row - mean - slope * (s - mean_s),
                false => row - mean,
            };
            for (a, forms) in forms.iter_mut().enumerate() {
                for (b, form) in forms.iter_mut().enumerate() {
                    *form += left.row(a).tr_mul(&left.row(b));
                }
            }
        }
        Some(Self { forms, is_timed })
    }

    /// For a tensor.
    fn by(&self, tensor: &Matrix3<f64>) -> f64 {
        let [xx, yy, zz] = [0, 1, 2].map(|axis| tensor[(axis, axis)]);
        let [xy, xz, yz] = [(0, 1), (0, 2), (1, 2)].map(|at| tensor[at]);
        let entries = Vector6::new(xx, yy, zz, xy, xz, yz);
        let of = |a: usize, b: usize| entries.dot(&(self.forms[a][b] * entries));
        if self.is_timed {
            return (0..3).map(|axis| of(axis, axis)).sum();
        }
        // Of an unknown tempo only the direction is known: what is across the longest axis of the scatter.
        let scatter = Matrix3::from_fn(of);
        let eigen = SymmetricEigen::new(0.5 * (scatter + scatter.transpose()));
        eigen.eigenvalues.sum() - eigen.eigenvalues.max()
    }
}

/// `J φ` as a linear function of the six entries of `J`: xx, yy, zz, xy, xz, yz.
fn acting_on(v: &Vector3<f64>) -> SMatrix<f64, 3, 6> {
    SMatrix::<f64, 3, 6>::new(
        v.x, 0.0, 0.0, v.y, v.z, 0.0, //
        0.0, v.y, 0.0, v.x, 0.0, v.z, //
        0.0, 0.0, v.z, 0.0, v.x, v.y,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::{Sample, Stamp};

    /// A free flight of a body with these moments, as it is seen in axes turned by `turn`.
    fn flight(moments: Vector3<f64>, turn: &UnitQuaternion<f64>) -> TriedFlight {
        let mut spin = Vector3::new(7.0, -5.0, 4.0);
        let mut at = UnitQuaternion::from_euler_angles(0.3, -1.0, 0.5);
        let step_s = 1e-5;
        let mut readings = Vec::new();
        for step in 0..60_000 {
            if step % 800 == 0 {
                let time_s = f64::from(step) * step_s;
                let sample = Sample::of_pose(Stamp(0), time_s, Vector3::zeros(), at * turn);
                readings.push((time_s, sample));
            }
            let momentum = moments.component_mul(&spin);
            spin += momentum.cross(&spin).component_div(&moments) * step_s;
            at *= exp(&(spin * step_s));
        }
        TriedFlight {
            track: TrackIndex(0),
            readings,
            goal: None,
        }
    }

    #[test]
    fn the_tensor_of_the_wrong_axes_keeps_the_line_straight() {
        let moments = Vector3::new(1.0, 0.6, 0.35);
        let turn = UnitQuaternion::from_euler_angles(1.0, 0.4, -2.2);
        let tensor = |turn: &UnitQuaternion<f64>| {
            let turn = matrix(turn);
            turn.transpose() * Matrix3::from_diagonal(&moments) * turn
        };
        for is_timed in [true, false] {
            let bend = Bend::of(&flight(moments, &turn), is_timed).unwrap();
            let bent = |of: &UnitQuaternion<f64>| bend.by(&tensor(of));
            let (found, left) = least(&bent);
            assert!(left < 0.01 * bent(&UnitQuaternion::identity()), "{left}");
            let off = (tensor(&found) - tensor(&turn)).norm();
            assert!(off < 0.02, "{is_timed}: {off}");
        }
    }

    #[test]
    fn a_turn_about_an_axis_of_symmetry_is_left_out() {
        let turn = exp(&Vector3::new(0.4, -0.2, 0.0));
        let about = exp(&Vector3::new(0.0, 0.0, 2.0)) * turn;
        let least = least_about(2, &about);
        assert!(least.angle() <= turn.angle() + 1e-9);
        let axis = |of: &UnitQuaternion<f64>| of.inverse() * Vector3::z();
        assert!((axis(&least) - axis(&turn)).norm() < 1e-9);
        assert_eq!(
            symmetry(&Vector3::new(1.0, 1.0, 0.3)),
            TurnSymmetry::Axis(2)
        );
        assert_eq!(
            symmetry(&Vector3::new(1.0, 0.995, 1.0)),
            TurnSymmetry::Sphere
        );
    }
}
