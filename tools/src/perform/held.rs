//! Performances with bodies in the hand whose truth is known: a ball on a racket, a box and a paddle, a
//! die on a moving ramp.
//!
//! The hand moves by a sum of sines in place and turn; what flies bounces off it as off a body of a
//! million tonnes. Both are seen by trackers with white noise and clocks of their own.

use enact::config::scene_from_toml;
use enact::math::so3;
use enact::motion::{
    LinkIndex, Mark, PoseSample, Scene, Stamp, TakeEvent, Timing, Touching, TrackIndex,
};
use enact::physics::contact::{Contact, Frame};
use enact::physics::impact::{ContactSet, Law, Side};
use enact::physics::{Body, State, flow};
use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// What is played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Game {
    /// A ball is bounced on a racket three times.
    Racket,
    /// A box is hit by a paddle.
    Paddle,
    /// A die falls onto a ramp.
    Ramp,
}

impl Game {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Racket, Self::Paddle, Self::Ramp];

    /// Its name.
    pub fn as_str(self) -> &'static str {
        match self {
            Game::Racket => "racket",
            Game::Paddle => "paddle",
            Game::Ramp => "ramp",
        }
    }

    /// Its scene file.
    pub fn toml(self) -> &'static str {
        match self {
            Game::Racket => include_str!("../../../config/racket.toml"),
            Game::Paddle => include_str!("../../../config/paddle.toml"),
            Game::Ramp => include_str!("../../../config/ramp.toml"),
        }
    }

    fn hits(self) -> usize {
        match self {
            Game::Racket => 3,
            Game::Paddle | Game::Ramp => 1,
        }
    }
}

/// How trackers see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Samples a second.
    pub rate_hz: f64,
    /// Standard deviation of positions per axis \[m\].
    pub position_sd_m: f64,
    /// Standard deviation of orientations per axis \[rad\].
    pub orientation_sd_rad: f64,
    /// Speed of the hand [m/s]; at zero it stands still.
    pub speed_m_s: f64,
    /// Standard deviation of marks \[s\].
    pub mark_sd_s: f64,
    /// What the clock of the hand's tracker lacks \[s\].
    pub clock_offset_s: f64,
}

impl Default for Seen {
    fn default() -> Self {
        Self {
            rate_hz: 120.0,
            position_sd_m: 1e-3,
            orientation_sd_rad: 3e-3,
            speed_m_s: 1.5,
            mark_sd_s: 4e-3,
            clock_offset_s: 0.0,
        }
    }
}

/// A hand's motion: sines of place and turn about a pose.
#[derive(Clone, Debug)]
pub struct Swing {
    centre_m: Vector3<f64>,
    turn: UnitQuaternion<f64>,
    /// Amplitude, rate [rad/s] and phase, of the place and of the turn.
    waves: [Vec<(Vector3<f64>, f64, f64)>; 2],
    /// A stroke from rest to rest, if there is one.
    stroke: Option<Stroke>,
}

/// A way and a turn of least jerk (Flash and Hogan, Journal of Neuroscience 5, 1985).
#[derive(Clone, Copy, Debug)]
struct Stroke {
    begins_s: f64,
    lasts_s: f64,
    /// Of the place and of the turn.
    way: [Vector3<f64>; 2],
}

impl Stroke {
    /// The share of the way that is done, and its rate.
    fn done(&self, time_s: f64) -> [f64; 2] {
        let s = ((time_s - self.begins_s) / self.lasts_s).clamp(0.0, 1.0);
        let share = s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
        let rate = 30.0 * s * s * (1.0 - s) * (1.0 - s) / self.lasts_s;
        [share, rate]
    }
}

impl Swing {
    /// To and fro on a bent way of a metre, at a speed [m/s].
    pub fn to_and_fro(speed_m_s: f64, random: &mut ChaCha8Rng) -> Self {
        let rate = speed_m_s / 0.5;
        let mut wave = |size: f64, rate: f64| {
            let amplitude = Vector3::from_fn(|_, _| size * random.random_range(-1.0..1.0));
            (amplitude, rate, random.random_range(0.0..6.0))
        };
        Self {
            centre_m: Vector3::new(0.0, 0.0, 1.0),
            turn: UnitQuaternion::identity(),
            waves: [
                vec![
                    wave(0.5, rate),
                    wave(0.2, 1.3 * rate),
                    wave(0.1, 2.1 * rate),
                ],
                vec![wave(0.6, rate), wave(0.3, 1.7 * rate)],
            ],
            stroke: None,
        }
    }

    /// One stroke of 80 cm from rest to rest that is halfway at a time \[s\], with its greatest speed
    /// [m/s] there.
    pub fn stroke(speed_m_s: f64, halfway_s: f64, random: &mut ChaCha8Rng) -> Self {
        const WAY_M: f64 = 0.8;
        // A stroke of least jerk is 15/8 times as fast as in the mean.
        let lasts_s = 1.875 * WAY_M / speed_m_s;
        let mut direction = || Vector3::from_fn(|_, _| random.random_range(-1.0..1.0)).normalize();
        Self {
            stroke: Some(Stroke {
                begins_s: halfway_s - 0.5 * lasts_s,
                lasts_s,
                way: [direction() * WAY_M, direction() * 1.2],
            }),
            ..Self::at_rest()
        }
    }

    fn at_rest() -> Self {
        Self {
            centre_m: Vector3::new(0.0, 0.0, 1.0),
            turn: UnitQuaternion::identity(),
            waves: [Vec::new(), Vec::new()],
            stroke: None,
        }
    }

    /// The state at a time.
    pub fn state(&self, time_s: f64) -> State {
        let [place, turn] = [0, 1].map(|kind| {
            let waves = self.waves[kind].iter();
            waves.fold(
                [Vector3::zeros(); 2],
                |[value, slope], (amplitude, rate, phase)| {
                    let (sin, cos) = (rate * time_s + phase).sin_cos();
                    [value + amplitude * sin, slope + amplitude * (rate * cos)]
                },
            )
        });
        let [place, turn] = match &self.stroke {
            None => [place, turn],
            Some(stroke) => {
                let [share, rate] = stroke.done(time_s);
                let [way, angle] = stroke.way;
                [
                    [place[0] + way * share, place[1] + way * rate],
                    [turn[0] + angle * share, turn[1] + angle * rate],
                ]
            }
        };
        let (by, right) = so3::exp_and_right_jacobian(&turn[0]);
        State {
            position_m: self.centre_m + place[0],
            orientation: self.turn * by,
            velocity_m_s: place[1],
            angular_velocity_rad_s: right * turn[1],
        }
    }
}

/// A performance and what is true of it.
#[derive(Clone, Debug)]
pub struct HeldTake {
    /// The game's scene, with one event per hit.
    pub scene: Scene,
    /// What trackers and performer delivered.
    pub events: Vec<TakeEvent>,
    /// Times of the hits \[s\], from the first sample of all.
    pub hits_s: Vec<f64>,
    /// What touches at each hit.
    pub touching: Vec<Touching>,
    /// States of what flies after each hit.
    pub after: Vec<State>,
    /// The hand's motion, in the same time.
    pub swing: Swing,
}

/// Time zero on the clocks.
const ZERO_NS: i64 = 1_700_000_000_000_000_000;
/// Mass of the hand's body in the truth \[kg\].
const HEAVY_KG: f64 = 1e9;
/// Step of the search for a hit \[s\].
const STEP_S: f64 = 1e-4;
/// Longest flight \[s\].
const LONGEST_S: f64 = 1.5;
/// Shortest flight between two hits \[s\].
const SHORTEST_S: f64 = 0.15;

/// A performance of a game; `None` where what flies misses the hand's body with this seed.
pub fn play(game: Game, seen: &Seen, seed: u64) -> Option<HeldTake> {
    let scene = scene_from_toml(game.toml()).expect("a valid scene");
    play_in(&scene, game, seen, seed)
}

/// The same in the game's scene with other known quantities or timing.
pub fn play_in(scene: &Scene, game: Game, seen: &Seen, seed: u64) -> Option<HeldTake> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let swing = swing(game, seen, &mut random);
    let scene = scene.with_marks(game.hits() + 1);
    let first = thrown(game, &swing, &mut random);
    let (free, hand) = (LinkIndex(0), LinkIndex(1));
    let heavy = Body::new(HEAVY_KG, Vector3::repeat(HEAVY_KG)).expect("a body");
    let (mut hits_s, mut touching, mut after) = (Vec::new(), Vec::new(), Vec::new());
    let mut flights = vec![(0.0, first)];
    for hit in 0..game.hits() {
        let (from_s, state) = flights[hit];
        let least_s = if hit == 0 { 0.0 } else { SHORTEST_S };
        let at = first_touch(&scene, &swing, (from_s, &state), hit, least_s)?;
        let body = &scene.links[free].body;
        let before = flow::advance(body, &scene.gravity_m_s2, &state, at.time_s - from_s);
        let holds = swing.state(at.time_s);
        let collision = scene.events[hit].kind.collision().expect("a hit");
        let given = scene.law_of(collision);
        let law = Law {
            restitution: given.restitution,
            friction: given.friction,
            tangential_restitution: 0.0,
            tilt_rad: [0.0; 2],
        };
        let a = Side {
            body,
            state: &before,
        };
        let b = Side {
            body: &heavy,
            state: &holds,
        };
        let contacts = ContactSet::with_friction(&[at.contact]).expect("one contact");
        let impact = contacts.impact(&a, Some(&b), &law).ok()?;
        let state = State {
            velocity_m_s: impact.after[0].velocity_m_s,
            angular_velocity_rad_s: impact.after[0].angular_velocity_rad_s,
            ..before
        };
        if impact.speeds_m_s[0] > -0.3 || !is_inside(&scene, hand, &holds, &at) {
            return None;
        }
        hits_s.push(at.time_s);
        touching.push(at.touching);
        after.push(state);
        flights.push((at.time_s, state));
    }
    let (from_s, state) = flights[game.hits()];
    let end_s = ends_s(&scene, &swing, (from_s, &state), game.hits() - 1)?;
    let free_at = |time_s: f64| {
        let at = flights.iter().rposition(|(from_s, _)| *from_s <= time_s);
        let (from_s, state) = &flights[at.unwrap_or(0)];
        let body = &scene.links[free].body;
        flow::advance(body, &scene.gravity_m_s2, state, time_s - from_s)
    };
    let mut events = Vec::new();
    let count = (end_s * seen.rate_hz) as usize + 1;
    for (track, phase) in [(TrackIndex(0), 0.0), (TrackIndex(1), 0.37)] {
        for k in 0..count {
            let time_s = (k as f64 + phase) / seen.rate_hz;
            let state = match track.0 {
                0 => free_at(time_s),
                _ => swing.state(time_s),
            };
            let pose = state.world_from_body() * scene.tracks[track].link_from_tracker;
            let mut noise = |sd: f64| {
                Vector3::from_fn(|_, _| {
                    let one: f64 = random.sample(StandardNormal);
                    sd * one
                })
            };
            let position_m = pose.translation.vector + noise(seen.position_sd_m);
            let turn = pose.rotation * so3::exp(&noise(seen.orientation_sd_rad));
            let late_s = if track.0 == 1 {
                seen.clock_offset_s
            } else {
                0.0
            };
            events.push(TakeEvent::Pose {
                track,
                stream: 0,
                sample: PoseSample::new(
                    stamp(&scene, time_s - late_s),
                    position_m,
                    turn.coords.into(),
                ),
            });
        }
    }
    let mut mark = |time_s: f64, sd_s: f64| {
        let off: f64 = random.sample(StandardNormal);
        events.push(TakeEvent::Mark(Mark {
            stamp: stamp(&scene, time_s + sd_s * off),
            event: None,
        }));
    };
    for hit_s in &hits_s {
        mark(*hit_s, seen.mark_sd_s);
    }
    mark(end_s - 0.02, 0.0);
    Some(HeldTake {
        scene,
        events,
        hits_s,
        touching,
        after,
        swing,
    })
}

/// A hand in slow motion takes this many times as long.
pub const SLOW: f64 = 2.5;

/// Where the tempo is unknown, all is acted slowly.
fn stamp(scene: &Scene, time_s: f64) -> Stamp {
    let slow = match scene.timing {
        Timing::Unknown { .. } => SLOW,
        Timing::Known | Timing::Edited => 1.0,
    };
    Stamp(ZERO_NS + (time_s * slow * 1e9).round() as i64)
}

fn swing(game: Game, seen: &Seen, random: &mut ChaCha8Rng) -> Swing {
    let mut phase = || random.random_range(0.0..std::f64::consts::TAU);
    let wave = |amplitude: [f64; 3], rate: f64, phase: f64| (Vector3::from(amplitude), rate, phase);
    let v = seen.speed_m_s;
    let mut swing = match game {
        // Up and down, with small tilts.
        Game::Racket => Swing {
            centre_m: Vector3::new(0.0, 0.0, 1.0),
            turn: UnitQuaternion::identity(),
            waves: [
                vec![
                    wave([0.0, 0.0, v / 9.0], 9.0, phase()),
                    wave([0.01, 0.015, 0.0], 4.0, phase()),
                ],
                vec![wave([0.02, 0.01, 0.1], 5.0, phase())],
            ],
            stroke: None,
        },
        // Across, face forward.
        Game::Paddle => Swing {
            centre_m: Vector3::new(0.0, 0.0, 1.0),
            turn: UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2),
            waves: [
                vec![wave([v / 6.0, 0.0, 0.02], 6.0, -0.3 + 0.1 * phase().sin())],
                vec![wave([0.1, 0.3, 0.1], 5.0, phase())],
            ],
            stroke: None,
        },
        Game::Ramp => Swing {
            centre_m: Vector3::new(0.0, 0.0, 0.8),
            turn: UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.35),
            waves: [
                vec![
                    wave([v / 5.0, 0.0, 0.0], 5.0, phase()),
                    wave([0.0, 0.03, 0.05], 7.0, phase()),
                ],
                vec![wave([0.05, 0.08, 0.05], 6.0, phase())],
            ],
            stroke: None,
        },
    };
    if v == 0.0 {
        swing.waves = [Vec::new(), Vec::new()];
    }
    swing
}

/// The first state of what flies, at time zero.
fn thrown(game: Game, swing: &Swing, random: &mut ChaCha8Rng) -> State {
    let mut vary = |size: f64| size * random.random_range(-1.0..1.0);
    let turn = Vector3::new(vary(1.5), vary(1.5), vary(1.5));
    let spin = Vector3::new(vary(8.0), vary(8.0), vary(8.0));
    let (position_m, velocity_m_s) = match game {
        Game::Racket => (
            Vector3::new(0.0, 0.0, 1.45 + vary(0.05)),
            Vector3::new(vary(0.02), vary(0.02), 0.5 + vary(0.3)),
        ),
        // Tossed up so that it hangs before the paddle.
        Game::Paddle => (
            Vector3::new(0.22 + vary(0.03), vary(0.02), 0.75),
            Vector3::new(-0.5 + vary(0.2), 0.0, 2.2),
        ),
        Game::Ramp => {
            let below = swing.state(0.3).position_m;
            (
                Vector3::new(below.x + vary(0.03), below.y + vary(0.02), 1.25),
                Vector3::new(vary(0.1), vary(0.1), vary(0.2)),
            )
        }
    };
    State {
        position_m,
        orientation: so3::exp(&turn),
        velocity_m_s,
        angular_velocity_rad_s: spin,
    }
}

/// When a performance ends: a third of a second after the last hit, or before what flies is hit again;
/// `None` where that is at once.
fn ends_s(scene: &Scene, swing: &Swing, flight: (f64, &State), hit: usize) -> Option<f64> {
    const LASTS_S: f64 = 0.35;
    const LEAST_S: f64 = 0.15;
    const APART_S: f64 = 0.003;
    let (from_s, _) = flight;
    if gap(scene, swing, flight, hit, from_s + APART_S)?.gap_m <= 0.0 {
        return None;
    }
    let again_s = first_touch(scene, swing, flight, hit, APART_S).map(|at| at.time_s - 0.02);
    let end_s = again_s.map_or(from_s + LASTS_S, |again_s| again_s.min(from_s + LASTS_S));
    (end_s > from_s + LEAST_S).then_some(end_s)
}

/// A contact and when it happens.
struct At {
    time_s: f64,
    contact: Contact,
    touching: Touching,
    on_hand_m: Vector3<f64>,
    gap_m: f64,
}

/// The contact of what flies with the face of the hand's body whose gap is least, at a time of a flight.
fn gap(
    scene: &Scene,
    swing: &Swing,
    (from_s, state): (f64, &State),
    hit: usize,
    time_s: f64,
) -> Option<At> {
    let collision = scene.events[hit].kind.collision()?;
    let (free, hand) = (&scene.links[LinkIndex(0)], &scene.links[LinkIndex(1)]);
    let other = collision.contacts[0].other?;
    let face = hand.features[other].geometry;
    let flying = flow::advance(&free.body, &scene.gravity_m_s2, state, time_s - from_s);
    let (a, b) = (Frame::of(&flying), Frame::of(&swing.state(time_s)));
    let points = free.features.iter().enumerate();
    let points = points.filter(|(_, feature)| feature.geometry.kind() == "point");
    let each = points.filter_map(|(index, feature)| {
        let contact = Contact::new(feature.geometry, face).ok()?;
        let touch = contact.touch(&a, &b).ok()?;
        Some(At {
            time_s,
            contact,
            touching: Touching {
                feature: Some(index),
                other: Some(other),
            },
            on_hand_m: touch.on_b_m,
            gap_m: touch.gap_m,
        })
    });
    each.min_by(|a, b| a.gap_m.total_cmp(&b.gap_m))
}

/// The first time at which a corner of what flies touches the face of the hand's body.
fn first_touch(
    scene: &Scene,
    swing: &Swing,
    flight: (f64, &State),
    hit: usize,
    least_s: f64,
) -> Option<At> {
    let at = |time_s: f64| gap(scene, swing, flight, hit, time_s);
    let mut apart_s = flight.0 + least_s.max(STEP_S);
    if at(apart_s)?.gap_m <= 0.0 {
        return None;
    }
    let steps = (LONGEST_S / STEP_S) as usize;
    for _ in 0..steps {
        let next_s = apart_s + STEP_S;
        if at(next_s)?.gap_m > 0.0 {
            apart_s = next_s;
            continue;
        }
        let mut inside_s = next_s;
        for _ in 0..60 {
            let middle_s = 0.5 * (apart_s + inside_s);
            if at(middle_s)?.gap_m > 0.0 {
                apart_s = middle_s;
            } else {
                inside_s = middle_s;
            }
        }
        return at(inside_s);
    }
    None
}

/// Whether the point of contact is on the hand's body, off its edges.
fn is_inside(scene: &Scene, hand: LinkIndex, _: &State, at: &At) -> bool {
    const EDGE_M: f64 = 0.01;
    use enact::physics::Shape::{Cuboid, Cylinder};
    let p = &at.on_hand_m;
    match scene.links[hand].shape {
        Cylinder { radius_m, .. } => p.xy().norm() < radius_m - EDGE_M,
        Cuboid { half_extents_m } => {
            p.x.abs() < half_extents_m.x - EDGE_M && p.y.abs() < half_extents_m.y - EDGE_M
        }
        _ => false,
    }
}
