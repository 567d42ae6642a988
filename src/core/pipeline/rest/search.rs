//! Search for the motion nearest to the performance that comes to rest as the scene asks.
//!
//! How a body comes to rest is a discontinuous function of the motion's first state: nothing to
//! differentiate. Each first state gives a whole motion by simulation: through the collisions of the
//! scene, then on until it rests. Motions near the performance are sampled by a Markov chain, as
//! Chenney and Forsyth ("Sampling plausible solutions to multi-body constraint problems", SIGGRAPH
//! 2000) do: Metropolis steps in whitened coordinates of the first state ([`Whitened`]), with the
//! objective as the energy, at a temperature that rises until one ends right. That one is brought
//! nearer by steps whose length follows their success (Rechenberg's (1+1) evolution strategy), as
//! long as it ends right and checks say of it no worse than of the best motion. Sample times, where they
//! are unknown, are solved for at the end, and what counts is what the continuation of that motion
//! shows.
//!
//! Scenes with goals at events, velocity gaps or several contacts at once have no such family of
//! motions, and none is found.

use nalgebra::DVector;

use crate::estimate::{Solved, Whitened};
use crate::math::random::Random;
use crate::motion::{Lie, MechanismIndex, Observer, RestWork, Scene, Verdict};
use crate::pipeline::perform::Performed;
use crate::settle::{settle, settle_until_slow};
use crate::verify::{is_met, lies, verify};

/// Chains whose results are compared, and chains in all where these find nothing.
const CHAINS: (usize, usize) = (2, 8);
/// Continuations of a chain, and its steps between two of them.
const CONTINUATIONS: usize = 400;
const WALK: usize = 6;
/// First and last temperature, in units of the objective.
const TEMPERATURES: (f64, f64) = (0.5, 5e3);
/// Factors on the length of a chain's steps after one that is taken and one that is not: a third is
/// taken.
const FACTORS: (f64, f64) = (1.1, 0.953);
/// Steps of the improvement; their first and least length as a share of the way from the best motion,
/// and factors after success and after failure.
const STEPS: usize = 200;
const STEP: (f64, f64) = (0.3, 0.005);
const STEP_FACTORS: (f64, f64) = (1.6, 0.92);

/// Searches for the motion nearest to the performance that comes to rest as the scene asks; adds to
/// the work.
pub(super) fn search(
    take: &Performed,
    limit_s: f64,
    work: &mut RestWork,
    observer: &mut dyn Observer,
) -> Option<Solved> {
    let mut seeker = Seeker::new(take, limit_s)?;
    let mut found: Vec<RestFound> = Vec::new();
    for chain in 0..CHAINS.1 {
        if observer.should_stop() || (chain >= CHAINS.0 && !found.is_empty()) {
            break;
        }
        if let Some(start) = seeker.sampled(observer) {
            found.push(seeker.improved(start, observer));
        }
    }
    found.sort_by(|a, b| a.price().total_cmp(&b.price()));
    let best = found
        .into_iter()
        .find_map(|found| seeker.finished(found, observer));
    work.continuations += seeker.continuations;
    work.motions += seeker.motions;
    best
}

/// A motion.
struct RestFound {
    /// Whitened coordinates of its first states.
    z: DVector<f64>,
    solved: Solved,
}

impl RestFound {
    /// The objective, with sample times as they are.
    fn price(&self) -> f64 {
        self.solved.estimate.objective
    }
}

struct Seeker<'a> {
    take: &'a Performed,
    /// With what was free as it was estimated.
    scene: Scene,
    limit_s: f64,
    flights: Vec<Whitened>,
    /// Number of doubts that checks have about the best motion.
    doubts: usize,
    random: Random,
    motions: usize,
    continuations: usize,
}

impl<'a> Seeker<'a> {
    fn new(take: &'a Performed, limit_s: f64) -> Option<Self> {
        let solved = &take.inferred.solved;
        let scene = take.inferred.scene.as_estimated(&solved.estimate);
        let mechanisms: Vec<MechanismIndex> = scene
            .mechanisms
            .keys()
            .filter(|of| !scene.is_apart(*of))
            .collect();
        Some(Self {
            take,
            limit_s,
            flights: solved.first_flights(&mechanisms)?,
            doubts: verify(&scene, &solved.estimate).doubts().len(),
            scene,
            random: Random::default(),
            motions: 0,
            continuations: 0,
        })
    }

    /// The motion at `z`, if all of its collisions happen.
    fn motion(&mut self, z: &DVector<f64>) -> Option<Solved> {
        self.motions += 1;
        let mut from = 0;
        let parts = self.flights.iter().map(|flight| {
            let part = z.rows(from, flight.dimension()).into_owned();
            from += flight.dimension();
            (flight, part)
        });
        let parts: Vec<(&Whitened, DVector<f64>)> = parts.collect();
        let moved = self
            .take
            .inferred
            .solved
            .simulated(self.take.performance(), &parts)?;
        let is_motion = moved.estimate.verdict == Verdict::Physical;
        is_motion.then_some(moved)
    }

    /// Whether a motion seems to end right.
    fn seems_right(&mut self, solved: &Solved) -> bool {
        self.continuations += 1;
        let scene = &self.scene;
        let settled = settle_until_slow(scene, &solved.estimate, self.limit_s);
        settled.is_some_and(|settled| {
            let lies = lies(scene, &settled);
            lies.iter().all(|lie: &Lie| lie.is_shown)
        })
    }

    /// Whether a motion ends right, and checks say of it no worse than of the best one.
    fn is_sound(&mut self, solved: &Solved) -> bool {
        let scene = &self.scene;
        if verify(scene, &solved.estimate).doubts().len() > self.doubts {
            return false;
        }
        self.continuations += 1;
        let settled = settle(scene, &solved.estimate, self.limit_s);
        settled.is_some_and(|settled| is_met(scene, &settled))
    }

    /// A step of a standard normal distribution, of length one in the mean square.
    fn step(&mut self) -> DVector<f64> {
        let count: usize = self.flights.iter().map(Whitened::dimension).sum();
        let random = &mut self.random;
        DVector::from_fn(count, |_, _| random.normal()) / (count.max(1) as f64).sqrt()
    }

    /// The first sound motion of a chain that ends right.
    fn sampled(&mut self, observer: &mut dyn Observer) -> Option<RestFound> {
        let mut at = RestFound {
            z: self.step() * 0.0,
            solved: self.take.inferred.solved.clone(),
        };
        let mut length = 1.0;
        let (first, last) = TEMPERATURES;
        for test in 0..CONTINUATIONS {
            if observer.should_stop() {
                return None;
            }
            let share = test as f64 / CONTINUATIONS as f64;
            let temperature = first * (last / first).powf(share);
            for _ in 0..WALK {
                let z = &at.z + self.step() * length;
                let draw = 0.5 * (1.0 + self.random.signed());
                let next = self.motion(&z).filter(|next| {
                    let rise = next.estimate.objective - at.price();
                    draw < (-0.5 * rise / temperature).exp()
                });
                match next {
                    Some(solved) => {
                        at = RestFound { z, solved };
                        length *= FACTORS.0;
                    }
                    None => length *= FACTORS.1,
                }
            }
            if self.seems_right(&at.solved) && self.is_sound(&at.solved) {
                return Some(at);
            }
        }
        None
    }

    /// A motion nearer to the performance that ends right too.
    fn improved(&mut self, mut best: RestFound, observer: &mut dyn Observer) -> RestFound {
        let mut length = STEP.0;
        for _ in 0..STEPS {
            if observer.should_stop() {
                break;
            }
            // A step to the side, and towards the best motion of all.
            let way = best.z.norm();
            let z = (&best.z + self.step() * (length * way)) * (1.0 - 0.5 * length);
            let better = self.motion(&z).filter(|moved| {
                moved.estimate.objective < best.price()
                    && self.seems_right(moved)
                    && self.is_sound(moved)
            });
            length *= match better {
                Some(solved) => {
                    best = RestFound { z, solved };
                    STEP_FACTORS.0
                }
                None => STEP_FACTORS.1,
            };
            length = length.clamp(STEP.1, STEP.0);
        }
        best
    }

    /// The motion with its sample times, if it still ends right.
    fn finished(&mut self, found: RestFound, observer: &mut dyn Observer) -> Option<Solved> {
        if !found.solved.times_are_unknown() {
            return Some(found.solved);
        }
        let timed = found
            .solved
            .with_sample_times(self.take.performance(), observer)?;
        let is_motion = timed.estimate.verdict == Verdict::Physical;
        (is_motion && self.is_sound(&timed)).then_some(timed)
    }
}
