//! Sequences of one body's bounces as simulations from the sketch propose them (paper §7's hybrid).
//!
//! A particle is what hit so far, and the flight after it: its state and how well that is known.
//! It is flown to where something touches first; each feature that may be the one is a child,
//! flown on from the nearest state in which it is. States about that one (the columns of the
//! covariance's factor, both ways) fly and bounce exactly, each at its own time, and say what the
//! flight after changes by; with that the samples of the next segment correct the flight before
//! the bounce, and so the one after, by damped Gauss–Newton steps. A particle's cost is half the
//! sum of squares so far: what the whole problem's comes to as far as later samples tell nothing
//! of earlier flights but by the last state. The best go on.

mod correction;

use self::correction::{Correction, Prior};
use enact::motion::{
    ArcGuess, Contacts, Guess, LinkIndex, Sample, Scene, Segment, Sketch, Timing, TrackIndex,
};
use enact::physics::contact::Frame;
use enact::physics::flow;
use enact::physics::impact::{ContactSet, Law, Side};
use enact::physics::state::{StateTangent, part};
use enact::physics::{Body, State};
use nalgebra::SMatrix;

type Matrix12 = SMatrix<f64, 12, 12>;

/// Particles that go on from a collision.
const BEAM: usize = 8;
/// Samples of a segment that are looked at, at most; they stand for all.
const SAMPLES: usize = 24;
/// Added to covariances, in units of the weights \[squared\]: rounding.
const FLOOR: f64 = 1e-6;
/// Contact is looked for so long after the last sample \[s\].
const REACH_S: f64 = 0.5;
/// A child whose samples cost more than this each is tried from the mark, too.
const GOOD: f64 = 3.0;
/// How far below the surface a start is put that would not touch \[m\], and how often.
const DIP_M: f64 = 0.005;
const DIPS: usize = 4;

/// What is proposed for.
pub struct Stage<'a> {
    scene: &'a Scene,
    sketch: &'a Sketch,
    segments: &'a [Segment],
    guesses: &'a [Guess],
    body: &'a Body,
    tempo_sd: Option<f64>,
    /// Of each collision in order: its event, and what may hit there.
    bounces: Vec<(usize, Vec<(ContactSet, Law)>)>,
}

/// A sequence so far.
#[derive(Clone, Debug)]
pub struct Particle {
    /// Index of the candidate at each collision.
    pub choice: Vec<usize>,
    /// Half the sum of squares.
    pub cost: f64,
    epoch_s: f64,
    state: State,
    covariance: Matrix12,
    /// Times of the first, middle and last sample of its segment.
    span_s: [f64; 3],
    /// Physical over acted time, mean of its segment.
    rate: f64,
}

impl<'a> Stage<'a> {
    /// For one body that bounces off the static world at every event but the first and last;
    /// `None` of other scenes.
    pub fn new(
        scene: &'a Scene,
        sketch: &'a Sketch,
        segments: &'a [Segment],
        guesses: &'a [Guess],
        open: &[(usize, Vec<Contacts>)],
    ) -> Option<Self> {
        let bounces = open.iter().map(|(event, candidates)| {
            let collision = scene.events[*event].kind.collision()?;
            let given = scene.law_of(collision);
            let law = Law {
                friction: given.friction,
                ..Law::frictionless(given.restitution)
            };
            let meetings = candidates.iter().map(|contacts| {
                let meeting = scene.contact_set_of(*event, contacts).ok()??;
                Some((meeting, law))
            });
            Some((*event, meetings.collect::<Option<Vec<_>>>()?))
        });
        let bounces = bounces.collect::<Option<Vec<_>>>()?;
        (segments.len() == bounces.len() + 1 && scene.links.len() == 1).then_some(Self {
            scene,
            sketch,
            segments,
            guesses,
            body: &scene.links[LinkIndex(0)].body,
            tempo_sd: match scene.timing {
                Timing::Unknown {
                    tempo_sd_per_sqrt_s,
                } => Some(tempo_sd_per_sqrt_s),
                Timing::Known | Timing::Edited => None,
            },
            bounces,
        })
    }

    /// Sequences, likeliest first.
    pub fn propose(&self) -> Vec<Particle> {
        let mut beam: Vec<Particle> = self.begin();
        for place in 0..self.bounces.len() {
            let mut children: Vec<Particle> = beam
                .iter()
                .flat_map(|particle| self.children(particle, place))
                .collect();
            children.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            // Different starts may come to the same.
            let mut kept: Vec<Particle> = Vec::new();
            for child in children {
                if kept.len() < BEAM && !kept.iter().any(|k| k.choice == child.choice) {
                    kept.push(child);
                }
            }
            beam = kept;
        }
        beam
    }

    fn begin(&self) -> Vec<Particle> {
        let mut firsts: Vec<&ArcGuess> = Vec::new();
        for guess in self.guesses {
            if !firsts.contains(&&guess.arcs[0]) {
                firsts.push(&guess.arcs[0]);
            }
        }
        let weights = &self.scene.weights;
        let particles = firsts.into_iter().filter_map(|first| {
            let fly = |z: &StateTangent| {
                let unit = |index: usize| match index / 3 % 2 {
                    0 => weights.position_m,
                    _ => weights.orientation_rad,
                };
                let by = StateTangent::from_fn(|index, _| unit(index) * z[index]);
                Some(first.state.retract(&by))
            };
            let prior = Prior {
                fly: &fly,
                start: StateTangent::zeros(),
                weight: 0.0,
                rate: None,
                shift_s: 0.0,
            };
            self.corrected(0, first, first.epoch_s, &prior)
        });
        particles.collect()
    }

    fn advance(&self, state: &State, duration_s: f64) -> State {
        flow::advance(self.body, &self.scene.gravity_m_s2, state, duration_s)
    }

    fn gap_m(&self, meeting: &ContactSet, state: &State) -> f64 {
        let gaps = meeting.as_slice().iter().map(|contact| {
            let touch = contact.touch(&Frame::of(state), &Frame::world());
            touch.map_or(f64::INFINITY, |touch| touch.gap_m)
        });
        gaps.fold(f64::INFINITY, f64::min)
    }

    /// When something touches first after the middle of a flight \[s\], and what.
    fn contact(&self, particle: &Particle, place: usize) -> Option<(f64, usize)> {
        const NEAR_M: f64 = 1e-6;
        const STEPS: usize = 200;
        let radius_m = self.scene.links[LinkIndex(0)].shape.radius_m();
        let [_, middle_s, last_s] = particle.span_s;
        let mut time_s = middle_s;
        for _ in 0..STEPS {
            let state = self.advance(&particle.state, time_s - particle.epoch_s);
            let gaps = self.bounces[place].1.iter().enumerate();
            let gaps = gaps.map(|(index, (meeting, _))| (self.gap_m(meeting, &state), index));
            let (gap_m, first) = gaps.min_by(|a, b| a.0.total_cmp(&b.0))?;
            if gap_m < NEAR_M {
                return Some((time_s, first));
            }
            // Nothing falls faster: v h + ½ g h² = gap.
            let speed_m_s =
                state.velocity_m_s.norm() + radius_m * state.angular_velocity_rad_s.norm();
            let gravity_m_s2 = self.scene.gravity_m_s2.norm();
            let root = (speed_m_s * speed_m_s + 2.0 * gravity_m_s2 * gap_m).sqrt();
            time_s += 2.0 * gap_m / (speed_m_s + root);
            if time_s > last_s + REACH_S {
                return None;
            }
        }
        None
    }

    /// When that comes down to the surface, near a time \[s\].
    fn crossing_s(&self, meeting: &ContactSet, state: &State, near_s: f64) -> Option<f64> {
        const STEP_S: f64 = 0.01;
        const LOOKS: i32 = 20;
        const CHORDS: usize = 4;
        let gap_m = |time_s: f64| self.gap_m(meeting, &self.advance(state, time_s));
        // The nearest interval in which it comes down, looking both ways from where it stands.
        let at = |look: i32| near_s + f64::from(look) * STEP_S;
        let [mut ahead_m, mut behind_m] = [gap_m(near_s); 2];
        let mut found = None;
        for look in 1..=LOOKS {
            let (next_m, last_m) = (gap_m(at(look)), gap_m(at(-look)));
            if last_m > 0.0 && behind_m <= 0.0 {
                found = Some((at(-look), last_m, at(1 - look), behind_m));
                break;
            }
            if ahead_m > 0.0 && next_m <= 0.0 {
                found = Some((at(look - 1), ahead_m, at(look), next_m));
                break;
            }
            (ahead_m, behind_m) = (next_m, last_m);
        }
        let (mut above_s, mut above_m, mut below_s, mut below_m) = found?;
        let mut time_s = above_s;
        for _ in 0..CHORDS {
            time_s = above_s + (below_s - above_s) * above_m / (above_m - below_m);
            let here_m = gap_m(time_s);
            if here_m.abs() < 1e-10 {
                break;
            }
            if here_m > 0.0 {
                (above_s, above_m) = (time_s, here_m);
            } else {
                (below_s, below_m) = (time_s, here_m);
            }
        }
        Some(time_s)
    }

    /// The least gap near a time \[m\].
    fn least_m(&self, meeting: &ContactSet, state: &State, near_s: f64) -> f64 {
        let looks = (-10..=10).map(|look| near_s + 0.01 * f64::from(look));
        let gaps = looks.map(|time_s| self.gap_m(meeting, &self.advance(state, time_s)));
        gaps.fold(f64::INFINITY, f64::min)
    }

    fn children(&self, particle: &Particle, place: usize) -> Vec<Particle> {
        let Some(factor) = particle.covariance.cholesky() else {
            return Vec::new();
        };
        let factor = factor.l();
        let (event, candidates) = &self.bounces[place];
        let range = self.segments[place].views[0].samples.clone();
        let last = &self.sketch.tracks[TrackIndex(0)].samples[range.end - 1];
        let marked_s =
            particle.span_s[2] + particle.rate * (self.sketch.marks_s[*event] - last.acted_s);
        let contact = self.contact(particle, place);
        let simulated = contact.map(|(time_s, _)| self.heights(particle, place, &factor, time_s));
        let marked = self.heights(particle, place, &factor, marked_s);
        let mut children = Vec::new();
        for candidate in 0..candidates.len() {
            let mut best: Option<Particle> = None;
            if let (Some((time_s, first)), Some(heights)) = (contact, &simulated) {
                // Both come down at once, which is the nearest that this one is first.
                let lead_m = heights.0[candidate] - heights.0[first];
                let lead_by = heights.1[candidate] - heights.1[first];
                let start = if candidate == first {
                    StateTangent::zeros()
                } else {
                    lead_by * (-lead_m / lead_by.norm_squared())
                };
                best = self.bounced(particle, place, candidate, (time_s, &factor, &start));
            }
            let is_good = |child: &Particle| {
                child.cost - particle.cost < GOOD * self.segments[place + 1].sample_count() as f64
            };
            if !best.as_ref().is_some_and(is_good) {
                let by = &marked.1[candidate];
                let mut start = by * (-marked.0[candidate] / by.norm_squared());
                for _ in 0..DIPS {
                    let state = particle.state.retract(&(factor * start));
                    let near_s = marked_s - particle.epoch_s;
                    let gap_m = self.least_m(&candidates[candidate].0, &state, near_s);
                    if gap_m > 0.0 {
                        start -= by * ((gap_m + DIP_M) / by.norm_squared());
                    }
                }
                let other = self.bounced(particle, place, candidate, (marked_s, &factor, &start));
                best = match (best, other) {
                    (Some(a), Some(b)) => Some(if a.cost <= b.cost { a } else { b }),
                    (a, b) => a.or(b),
                };
            }
            children.extend(best);
        }
        children
    }

    /// Gaps of what may touch at a time \[m\], and what they change by one standard deviation along
    /// each column of the factor.
    fn heights(
        &self,
        particle: &Particle,
        place: usize,
        factor: &Matrix12,
        time_s: f64,
    ) -> (Vec<f64>, Vec<StateTangent>) {
        let candidates = &self.bounces[place].1;
        let gaps = |state: &State| -> Vec<f64> {
            let there = self.advance(state, time_s - particle.epoch_s);
            let gap_m = |(meeting, _): &(ContactSet, Law)| self.gap_m(meeting, &there);
            candidates.iter().map(gap_m).collect()
        };
        let mut slopes = vec![StateTangent::zeros(); candidates.len()];
        for axis in 0..12 {
            let column: StateTangent = factor.column(axis).into();
            let ahead = gaps(&particle.state.retract(&column));
            let behind = gaps(&particle.state.retract(&-column));
            for (slope, (ahead, behind)) in slopes.iter_mut().zip(ahead.iter().zip(&behind)) {
                slope[axis] = 0.5 * (ahead - behind);
            }
        }
        (gaps(&particle.state), slopes)
    }

    /// A floor of covariances.
    fn floor(&self) -> Matrix12 {
        let (length, angle) = (
            self.scene.weights.position_m,
            self.scene.weights.orientation_rad,
        );
        let mut floor = Matrix12::zeros();
        for axis in 0..3 {
            floor[(part::POSITION + axis, part::POSITION + axis)] = FLOOR * length * length;
            floor[(part::VELOCITY + axis, part::VELOCITY + axis)] = FLOOR * length * length;
            floor[(part::ORIENTATION + axis, part::ORIENTATION + axis)] = FLOOR * angle * angle;
            let spin = part::ANGULAR_VELOCITY + axis;
            floor[(spin, spin)] = FLOOR * angle * angle;
        }
        floor
    }

    /// Flies to its contact, bounces, and is corrected by the samples after: how it flew before
    /// is found with them, in standard deviations from where it was thought to be.
    fn bounced(
        &self,
        particle: &Particle,
        place: usize,
        candidate: usize,
        (near_s, factor, start): (f64, &Matrix12, &StateTangent),
    ) -> Option<Particle> {
        let (event, candidates) = &self.bounces[place];
        let (meeting, law) = &candidates[candidate];
        let near_s = near_s - particle.epoch_s;
        let begun = particle.state.retract(&(factor * start));
        let after_s = self.crossing_s(meeting, &begun, near_s)?;
        // As if it had been on that flight at one time for all.
        let fly = |z: &StateTangent| {
            let state = particle.state.retract(&(factor * z));
            let own_s = self.crossing_s(meeting, &state, after_s)?;
            let before = self.advance(&state, own_s);
            let side = Side {
                body: self.body,
                state: &before,
            };
            let impact = meeting.impact(&side, None, law).ok()?;
            let after = State {
                velocity_m_s: impact.after[0].velocity_m_s,
                angular_velocity_rad_s: impact.after[0].angular_velocity_rad_s,
                ..before
            };
            Some(self.advance(&after, after_s - own_s))
        };
        let epoch_s = particle.epoch_s + after_s;
        let arc = place + 1;
        let guess = &self.guesses[0];
        let prior = Prior {
            fly: &fly,
            start: *start,
            weight: 1.0,
            rate: Some(particle.rate),
            shift_s: match self.tempo_sd {
                Some(_) => epoch_s - guess.event_times_s[*event],
                None => 0.0,
            },
        };
        let corrected = self.corrected(arc, &guess.arcs[arc], epoch_s, &prior)?;
        Some(Particle {
            choice: [&particle.choice[..], &[candidate]].concat(),
            cost: particle.cost + corrected.cost,
            ..corrected
        })
    }

    /// A flight that is known so well, corrected by the samples of its segment.
    fn corrected(
        &self,
        arc: usize,
        guess: &ArcGuess,
        epoch_s: f64,
        prior: &Prior,
    ) -> Option<Particle> {
        let range = self.segments[arc].views[0].samples.clone();
        let all = &self.sketch.tracks[TrackIndex(0)].samples[range];
        let count = all.len().min(SAMPLES);
        let spread = |index: usize| index * (all.len() - 1) / (count - 1).max(1);
        let samples: Vec<Sample> = (0..count).map(|i| all[spread(i)]).collect();
        let start_s: Vec<f64> = (0..count)
            .map(|i| guess.sample_times_s[spread(i)] + prior.shift_s)
            .collect();
        let before_s = arc.checked_sub(1).map_or(0.0, |before| {
            let range = self.segments[before].views[0].samples.clone();
            let samples = &self.sketch.tracks[TrackIndex(0)].samples[range];
            0.5 * (samples[0].acted_s + samples[samples.len() - 1].acted_s)
        });
        let middle_s = 0.5 * (samples[0].acted_s + samples[count - 1].acted_s);
        let correction = Correction {
            stage: self,
            samples: &samples,
            weight: all.len() as f64 / count as f64,
            epoch_s,
            prior,
            rate_sd: self.tempo_sd.map(|sd| sd * (middle_s - before_s).sqrt()),
        };
        let (cost, state, times_s, covariance) = correction.solved(start_s)?;
        Some(Particle {
            choice: Vec::new(),
            cost,
            epoch_s,
            state,
            covariance,
            span_s: [times_s[0], times_s[count / 2], times_s[count - 1]],
            rate: correction.rate(&times_s),
        })
    }
}
