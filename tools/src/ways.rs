//! Scenes, and hands that act them, on which intervals are put to the test.

use std::rc::Rc;

use enact::math::Pose;
use enact::motion::{FreeParameter, Quantity, TrackIndex};
use enact::physics::{Body, Shape, contact};

use crate::case::Case;
use crate::hands::Hand;
use crate::perform::{Acting, Style, Truth, bounces, hat_box};

/// Side of the small die \[m\], and of the cube that bounces alike.
const DIE_M: f64 = 0.016;
const CUBE_M: f64 = 0.3;
/// Duration of a pencil's flight \[s\].
const FLIGHT_S: f64 = 0.35;
/// Lowest frequency of the performance maker's wander at a pace of one \[Hz\].
const LOW_HZ: f64 = 0.2;

/// A scene, acted in one way.
pub struct Way {
    /// What it is.
    pub name: String,
    /// How it is acted.
    pub acting: Acting,
    /// Another hand than the maker's own.
    pub hand: Option<Hand>,
    truth: Box<dyn Fn(u64) -> Truth>,
}

impl Way {
    /// Its performance of a seed; `None` where the real hand's data are not there.
    pub fn case(&self, seed: u64) -> Option<Case> {
        let truth = (self.truth)(seed);
        let Some(hand) = self.hand else {
            return Some(Case::new(&truth, &self.acting, seed));
        };
        let still = Acting {
            distortion: 0.0,
            ..self.acting
        };
        let mut case = Case::new(&truth, &still, seed);
        hand.lead_astray(&mut case.performance, &self.acting)?;
        Some(case)
    }
}

/// The same with the restitution of the first collision free, and gravity along z if asked for.
pub fn freed(mut truth: Truth, gravity: bool) -> Truth {
    let scene = &mut truth.scene;
    let mut events = scene.events.iter();
    let first = events.find_map(|event| event.kind.collision());
    let law = first.expect("a scene with a collision").law;
    let restitution = scene.contact_laws[law].restitution;
    let free = |name: &str, quantity, initial, lower| FreeParameter {
        name: name.into(),
        quantity,
        initial,
        lower,
        upper: f64::INFINITY,
        prior_sd: None,
    };
    let quantity = Quantity::Restitution { law };
    scene
        .parameters
        .push(free("restitution", quantity, 0.6, 0.0));
    truth.parameters.push(restitution);
    if gravity {
        let quantity = Quantity::Gravity { axis: 2 };
        let parameter = free("gravity", quantity, -9.81, f64::NEG_INFINITY);
        scene.parameters.push(parameter);
        truth.parameters.push(scene.gravity_m_s2.z);
    }
    truth
}

/// All lengths times `scale` and all times its root, so that gravity stays.
pub fn dilated(mut truth: Truth, scale: f64) -> Truth {
    let pace = scale.sqrt();
    for track in &mut truth.scene.tracks {
        track.link_from_tracker.translation.vector *= scale;
    }
    for link in &mut truth.scene.links {
        let moments = link.body.moments_kg_m2() * (scale * scale);
        link.body = Body::new(link.body.mass_kg(), moments).expect("moments as good as before");
        for feature in &mut link.features {
            if let contact::Feature::Point { point_m, .. } = &mut feature.geometry {
                *point_m *= scale;
            }
        }
        if let Shape::Cuboid { half_extents_m } = &mut link.shape {
            *half_extents_m *= scale;
        }
    }
    for arc in &mut truth.arcs {
        arc.epoch_s *= pace;
        arc.start_s *= pace;
        arc.end_s *= pace;
        arc.state.position_m *= scale;
        arc.state.velocity_m_s *= scale / pace;
        arc.state.angular_velocity_rad_s /= pace;
    }
    truth
        .event_times_s
        .iter_mut()
        .for_each(|time_s| *time_s *= pace);
    truth.duration_s *= pace;
    truth
}

/// White noise and nothing else; the pencil is tracked at its centre, so that it stays white.
fn white(style: Style) -> (Truth, Acting) {
    let mut scene = style.truth().scene;
    scene.tracks[TrackIndex(0)].link_from_tracker = Pose::identity();
    let truth = style.truth_in(&scene).expect("the style's own scene");
    let acting = Acting {
        distortion: 0.0,
        mark_error_s: 0.0,
        ..Acting::timing_known()
    };
    (truth, acting)
}

/// The maker's hand with a correlation time of so many flights.
fn wander(flights: f64) -> Acting {
    Acting {
        wander_pace: 1.0 / (std::f64::consts::TAU * LOW_HZ * FLIGHT_S * flights),
        ..Acting::timing_known()
    }
}

/// Hands that are not the maker's.
const HANDS: [(&str, Hand); 6] = [
    ("rough, 0.1 flights", Hand::Rough(0.1 * FLIGHT_S)),
    ("rough, 1 flight", Hand::Rough(FLIGHT_S)),
    ("rough, 5 flights", Hand::Rough(5.0 * FLIGHT_S)),
    ("slow sinusoids", Hand::Sinusoids([0.2, 1.0])),
    ("drift", Hand::Drift),
    ("real hand", Hand::Real),
];

/// Every way.
pub fn all() -> Vec<Way> {
    let mut ways: Vec<Way> = Vec::new();
    for style in Style::ALL {
        let plain = Rc::new(style.truth());
        let bouncy = Rc::new(freed(style.truth(), false));
        let heavy = Rc::new(freed(style.truth(), true));
        let scenes = [
            ("", plain),
            (", restitution free", bouncy),
            (", restitution and gravity free", heavy),
        ];
        let mut add = |what: String, acting: Acting, hand, truth: &Rc<Truth>| {
            let timing = if acting.is_timing_known() {
                "known"
            } else {
                "unknown"
            };
            let truth = truth.clone();
            ways.push(Way {
                name: format!("{}, {timing}{what}", style.as_str()),
                acting,
                hand,
                truth: Box::new(move |_| (*truth).clone()),
            });
        };
        let (truth, acting) = white(style);
        add(", white noise".into(), acting, None, &Rc::new(truth));
        for (free, truth) in &scenes {
            add((*free).into(), Acting::timing_known(), None, truth);
            add((*free).into(), Acting::default(), None, truth);
        }
        for (free, truth) in [&scenes[0], &scenes[2]] {
            for flights in [0.2, 1.0, 2.0, 5.0] {
                let what = format!("{free}, wander of {flights} flights");
                add(what, wander(flights), None, truth);
            }
            for (name, hand) in HANDS {
                let what = format!("{free}, {name}");
                add(what, Acting::timing_known(), Some(hand), truth);
            }
            for (name, hand) in &HANDS[4..] {
                add(
                    format!("{free}, {name}"),
                    Acting::default(),
                    Some(*hand),
                    truth,
                );
            }
        }
    }
    let mut add = |name: String, acting: Acting, truth: Box<dyn Fn(u64) -> Truth>| {
        ways.push(Way {
            name,
            acting,
            hand: None,
            truth,
        });
    };
    let hat = || Box::new(|_| hat_box::truth());
    add("hat and box, known".into(), Acting::timing_known(), hat());
    add("hat and box, unknown".into(), Acting::default(), hat());
    for count in [4, 8] {
        let cube = move |seed| bounces(count, seed).expect("a bouncing cube");
        add(
            format!("cube, known, {count} bounces"),
            Acting::timing_known(),
            Box::new(cube),
        );
        // A die is held in the fingertips.
        let small = Acting {
            distortion: 0.1,
            rate_hz: 240.0,
            ..Acting::timing_known()
        };
        let die = move |seed| dilated(cube(seed), DIE_M / CUBE_M);
        add(
            format!("die of 16 mm, known, {count} bounces"),
            small,
            Box::new(die),
        );
    }
    ways
}
