//! Hands drawn at random are all kinds of hands, and a seed's is always the same.

use enact_tools::perform::Acting;

/// How many seeds: a share of them has a standard error of 2.5 %.
const SEEDS: u64 = 400;

fn drawn() -> impl Iterator<Item = Acting> {
    (0..SEEDS).map(Acting::drawn)
}

/// Within the range, and as often below its middle as above.
fn spread(knob: impl Fn(&Acting) -> f64, [least, most]: [f64; 2], middle: f64) {
    let values: Vec<f64> = drawn().map(|acting| knob(&acting)).collect();
    assert!(values.iter().all(|value| (least..=most).contains(value)));
    let below = values.iter().filter(|value| **value < middle).count() as f64;
    let share = below / SEEDS as f64;
    assert!((0.4..0.6).contains(&share), "{share} below {middle}");
}

#[test]
fn a_seed_gives_the_same_hand_and_another_seed_another() {
    let (hands, again): (Vec<_>, Vec<_>) = drawn().zip(drawn()).unzip();
    assert_eq!(hands, again);
    for (seed, hand) in hands.iter().enumerate() {
        assert_eq!(hand.check(), Ok(()));
        assert!(!hands[..seed].contains(hand), "seed {seed}");
    }
}

#[test]
fn drawn_hands_are_of_all_kinds_and_otherwise_usual() {
    spread(|acting| acting.kink_s, [0.004, 0.02], 0.012);
    spread(|acting| acting.distortion, [0.25, 2.0], 0.5_f64.sqrt());
    spread(|acting| acting.wander_pace, [0.3, 3.0], 0.9_f64.sqrt());
    let slowdowns = [0.5, 1.0, 2.0, 4.0];
    spread(|acting| acting.slowdown, [0.5, 4.0], 1.5);
    for slowdown in slowdowns {
        assert!(drawn().any(|acting| acting.slowdown == slowdown));
    }
    assert!(drawn().all(|acting| slowdowns.contains(&acting.slowdown)));
    for rate_hz in [30.0, 1000.0] {
        assert!(drawn().any(|acting| acting.rate_hz == rate_hz));
    }
    for acting in drawn() {
        assert!((30.0..=1000.0).contains(&acting.rate_hz));
        let usual = Acting::default();
        let otherwise = Acting {
            kink_s: usual.kink_s,
            distortion: usual.distortion,
            wander_pace: usual.wander_pace,
            slowdown: usual.slowdown,
            rate_hz: usual.rate_hz,
            ..acting
        };
        assert_eq!(otherwise, usual);
    }
}
