//! Motions whose first flight has a single keyframe, by shooting: velocities there are varied until
//! the simulated motion passes all keyframes, from a grid of starts.

use nalgebra::{DMatrix, DVector, SMatrix, SVector, Vector3};

use super::flown::KeyPose;
use super::follow::{KeyedCourse, Way, up};
use crate::motion::Observer;

/// Angular speeds of the starts [rad/s], about the axes and diagonals of the body.
const SPEEDS_RAD_S: [f64; 3] = [4.0, 9.0, 16.0];
/// Times from the keyframe to the collision that are tried where no clock tells \[s\].
const UNTIL_S: [f64; 4] = [0.05, 0.15, 0.3, 0.5];
/// Flights of all starts, their steps, and how many of these then go on, flight by flight, for how
/// many more.
const FLIGHTS: usize = 3;
const SCOUTED: usize = 5;
const CHOSEN: usize = 24;
const REFINED: usize = 30;
/// Displacements for derivatives: of velocities [m/s] and angular velocities [rad/s].
const NUDGES: [f64; 2] = [1e-6, 1e-5];
/// Motions whose velocities differ by less are the same [m/s and rad/s].
const SAME: f64 = 1e-2;
/// Flights that are simulated: after so many the best shot alone is led on, and after so many more it is not
/// refined. Motions of ten flights need half of the first.
const SIMULATED: [usize; 2] = [400_000, 800_000];
/// Sum of squares, in tolerances, below which no step is needed.
const EXACT: f64 = 1e-14;

type Six = SVector<f64, 6>;

/// A start on its way.
struct KeyedShot {
    velocities: Six,
    flights: usize,
    way: Way,
    off: DVector<f64>,
    damping: f64,
}

/// What was done so far, and who may end it.
struct ShotWork<'a> {
    /// Flights that were simulated.
    flights: usize,
    observer: &'a mut dyn Observer,
}

impl ShotWork<'_> {
    /// Whether the best shot alone is led on.
    fn is_long(&mut self) -> bool {
        self.flights > SIMULATED[0] || self.observer.should_stop()
    }

    /// Whether no shot is refined any more.
    fn is_over(&mut self) -> bool {
        self.flights > SIMULATED[1] || self.observer.should_stop()
    }
}

/// The motions that come nearest to the keyframes, where all impacts are known.
pub(super) fn ways(course: &KeyedCourse, most: usize, observer: &mut dyn Observer) -> Vec<Way> {
    let mut work = ShotWork {
        flights: 0,
        observer,
    };
    let mut starts = starts(course);
    // Of motions that are not determined one is as good as another.
    if course.numbers() < course.unknowns() {
        starts.truncate(1);
    }
    let mut shots: Vec<KeyedShot> = starts
        .into_iter()
        .filter_map(|velocities| shot(course, velocities, FLIGHTS, &mut work))
        .collect();
    for shot in &mut shots {
        descend(course, shot, SCOUTED, &mut work);
    }
    let order = |a: &KeyedShot, b: &KeyedShot| a.way.order(&b.way);
    shots.sort_by(order);
    let mut kept: Vec<KeyedShot> = Vec::new();
    for mut shot in shots {
        if kept.len() >= CHOSEN {
            break;
        }
        if is_new(&kept, &shot) {
            descend(course, &mut shot, REFINED, &mut work);
            if is_new(&kept, &shot) {
                kept.push(shot);
            }
        }
    }
    // The impacts of many flights amplify errors: the next one is met from where those before are.
    for flights in FLIGHTS + 1..=course.samples.len() {
        if work.is_long() {
            kept.truncate(1);
        }
        let longer = |old: KeyedShot| {
            if work.is_over() {
                return led_on(course, old);
            }
            let mut longer = shot(course, old.velocities, flights, &mut work)?;
            descend(course, &mut longer, REFINED, &mut work);
            Some(longer)
        };
        kept = kept.into_iter().filter_map(longer).collect();
        kept.sort_by(order);
        kept.truncate(2 * most);
    }
    kept.sort_by(order);
    kept.truncate(most);
    kept.into_iter().map(|shot| shot.way).collect()
}

/// A shot that goes on into the next flight as it is; none where that is not finite.
fn led_on(course: &KeyedCourse, shot: KeyedShot) -> Option<KeyedShot> {
    let way = course.handed_on(&shot.way);
    way.cost.is_finite().then_some(KeyedShot { way, ..shot })
}

fn is_new(known: &[KeyedShot], shot: &KeyedShot) -> bool {
    let mut known = known.iter();
    known.all(|other| (other.velocities - shot.velocities).norm() > SAME)
}

fn first<'a>(course: &'a KeyedCourse) -> &'a KeyPose {
    &course.samples[0][0]
}

fn starts(course: &KeyedCourse) -> Vec<Six> {
    let sample = first(course);
    let later = course.samples[1..].iter().find_map(|flight| flight.first());
    let mut spins = vec![Vector3::zeros()];
    for speed_rad_s in SPEEDS_RAD_S {
        for corner in 0..27_i32 {
            let along = [corner % 3, corner / 3 % 3, corner / 9].map(|at| f64::from(at - 1));
            if let Some(axis) = Vector3::from(along).try_normalize(0.5) {
                spins.push(axis * speed_rad_s);
            }
        }
    }
    let up = up(course.scene);
    let mut starts = Vec::new();
    for until_s in course.until_s(&UNTIL_S) {
        let lasts_s = course.between_s().unwrap_or(2.0 * until_s);
        let way_m = later.map_or(Vector3::zeros(), |later| {
            later.position_m - sample.position_m
        });
        let along = (way_m - up * way_m.dot(&up)) / lasts_s;
        for spin in &spins {
            let mut velocities = Six::zeros();
            velocities.fixed_rows_mut::<3>(3).copy_from(spin);
            // So fast that the feature is on the surface when it is marked.
            let gap_m = |climb_m_s: f64| {
                let mut velocities = velocities;
                velocities
                    .fixed_rows_mut::<3>(0)
                    .copy_from(&(along + up * climb_m_s));
                course.gap_m(&course.begun(&velocities), sample.acted_s + until_s)
            };
            let (Some(level_m), Some(climbing_m)) = (gap_m(0.0), gap_m(1.0)) else {
                continue;
            };
            let climb_m_s = -level_m / (climbing_m - level_m);
            if climb_m_s.is_finite() {
                velocities
                    .fixed_rows_mut::<3>(0)
                    .copy_from(&(along + up * climb_m_s));
                starts.push(velocities);
            }
        }
    }
    starts
}

fn shot(
    course: &KeyedCourse,
    velocities: Six,
    flights: usize,
    work: &mut ShotWork,
) -> Option<KeyedShot> {
    let (way, off) = simulated(course, &velocities, flights, work)?;
    Some(KeyedShot {
        velocities,
        flights,
        way,
        off,
        damping: 1e-2,
    })
}

/// The motion from some velocities over so many flights, and its differences from all keyframes but
/// the first.
fn simulated(
    course: &KeyedCourse,
    velocities: &Six,
    flights: usize,
    work: &mut ShotWork,
) -> Option<(Way, DVector<f64>)> {
    work.flights += flights;
    let mut way = Way {
        flights: vec![course.begun(velocities)],
        offsets_s: vec![0.0],
        ends_s: Vec::new(),
        cost: 0.0,
    };
    let mut off: Vec<f64> = Vec::new();
    for samples in course.samples.iter().take(flights).skip(1) {
        way = course.handed_on(&way);
        let (flown, _) = way.last();
        for sample in samples {
            let state = flown.at(course.scene, course.mechanism, sample.acted_s);
            off.extend(course.off(sample, &state).iter());
        }
    }
    off.push(
        (way.cost - off.iter().map(|r| r * r).sum::<f64>())
            .max(0.0)
            .sqrt(),
    );
    way.cost.is_finite().then(|| (way, DVector::from_vec(off)))
}

/// Levenberg and Marquardt's steps, with derivatives by differences.
fn descend(course: &KeyedCourse, shot: &mut KeyedShot, steps: usize, work: &mut ShotWork) {
    for _ in 0..steps {
        if shot.way.cost < EXACT || work.is_over() {
            return;
        }
        let mut columns = DMatrix::zeros(shot.off.len(), 6);
        for column in 0..6 {
            let step = NUDGES[column / 3];
            let mut nudged = shot.velocities;
            nudged[column] += step;
            let Some((_, off)) = simulated(course, &nudged, shot.flights, work) else {
                return;
            };
            columns.set_column(column, &((off - &shot.off) / step));
        }
        let square: SMatrix<f64, 6, 6> = columns.tr_mul(&columns).fixed_view::<6, 6>(0, 0).into();
        let slope: Six = columns.tr_mul(&shot.off).fixed_rows::<6>(0).into();
        let mut improved = false;
        for _ in 0..6 {
            let mut damped = square;
            for k in 0..6 {
                damped[(k, k)] += shot.damping * (square[(k, k)] + 1e-6);
            }
            let Some(factor) = damped.cholesky() else {
                shot.damping *= 10.0;
                continue;
            };
            let trial = shot.velocities - factor.solve(&slope);
            match simulated(course, &trial, shot.flights, work) {
                Some((way, off)) if way.cost < shot.way.cost => {
                    (shot.velocities, shot.way, shot.off) = (trial, way, off);
                    shot.damping *= 0.2;
                    improved = true;
                    break;
                }
                _ => shot.damping *= 5.0,
            }
        }
        if !improved {
            return;
        }
    }
}
