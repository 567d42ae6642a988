use super::*;

const MS: i64 = 1_000_000;
const START: i64 = 1_700_000_000_000_000_000;

/// A reading of a 200 Hz tracker: its driver's clock, its device's, our arrival.
fn reading(k: i64) -> StampReading {
    let truth = START + k * 5 * MS;
    StampReading {
        session: 1,
        sequence: k as u64,
        sample_ns: Some(truth),
        device_ns: Some(k * 5 * MS + 77),
        receipt_ns: truth + 2 * MS + (k * 7919 % 7) * MS / 10,
    }
}

fn stamps(source: Option<StampSource>, readings: &[StampReading]) -> (Vec<i64>, ClockQuality) {
    let mut clock = StreamClock::new(source);
    let stamps = readings
        .iter()
        .map(|reading| clock.stamp(reading).0)
        .collect();
    (stamps, clock.quality())
}

#[test]
fn the_drivers_times_are_taken_as_they_are() {
    // Late, out of order, with jitter, from another year than ours.
    let mut readings: Vec<StampReading> = (0..100).map(reading).collect();
    readings.swap(40, 43);
    for reading in &mut readings {
        reading.receipt_ns += 86_400_000 * 1_000 * MS;
    }
    let (stamps, quality) = stamps(None, &readings);
    let given: Vec<i64> = readings.iter().filter_map(|r| r.sample_ns).collect();
    assert_eq!(stamps, given);
    assert_eq!((quality.source, quality.steps), (Some("sample"), 0));
}

#[test]
fn what_the_first_sample_has_decides_where_nobody_said() {
    let without = |sample: bool, device: bool| StampReading {
        sample_ns: reading(0).sample_ns.filter(|_| sample),
        device_ns: reading(0).device_ns.filter(|_| device),
        ..reading(0)
    };
    for (sample, device, expected) in [
        (true, true, "sample"),
        (false, true, "device"),
        (false, false, "receipt"),
    ] {
        let (_, quality) = stamps(None, &[without(sample, device)]);
        assert_eq!(quality.source, Some(expected));
    }
}

#[test]
fn a_clock_that_is_set_does_not_tear_the_stamps_apart() {
    for source in [StampSource::Sample, StampSource::Device] {
        for step_ns in [
            -3_600_000 * MS,
            -100 * MS,
            -40 * MS,
            -12 * MS,
            12 * MS,
            40 * MS,
            300 * MS,
            900 * MS,
            3_600_000 * MS,
        ] {
            let readings: Vec<StampReading> = (0..1000)
                .map(|k| {
                    let add = |ns: Option<i64>| ns.map(|ns| ns + if k < 500 { 0 } else { step_ns });
                    StampReading {
                        sample_ns: add(reading(k).sample_ns),
                        device_ns: add(reading(k).device_ns),
                        ..reading(k)
                    }
                })
                .collect();
            let (stamps, quality) = stamps(Some(source), &readings);
            assert_eq!(quality.steps, 1, "{source:?} {step_ns}");
            for pair in stamps.windows(2) {
                let interval = pair[1] - pair[0];
                assert!(
                    (4 * MS..6 * MS).contains(&interval),
                    "{source:?} {step_ns}: {interval}"
                );
            }
        }
    }
}

/// Before a stream has a cadence, only steps back of its clock are detected; after a restart of the
/// publisher sequence numbers do not help either.
#[test]
fn a_clock_that_is_set_back_is_noticed_without_cadence_and_over_a_restart() {
    const HOUR: i64 = 3_600_000 * MS;
    // Intervals of 1 to 41 ms, and every fifth of 200 ms.
    let mut at = START;
    let uneven: Vec<i64> = (0..400_i64)
        .map(|k| {
            at += if k % 5 == 0 { 200 } else { 1 + k * 7919 % 41 } * MS;
            at
        })
        .collect();
    for (is_uneven, has_restart, from) in [
        (true, false, 10),
        (true, false, 200),
        (false, true, 200),
        (true, true, 10),
    ] {
        let readings: Vec<StampReading> = (0..400)
            .map(|k| {
                let is_after = k >= from;
                let even = reading(k as i64);
                let truth = if is_uneven {
                    uneven[k]
                } else {
                    START + k as i64 * 5 * MS
                };
                let begins = has_restart && is_after;
                StampReading {
                    session: 1 + u32::from(begins),
                    sequence: if begins { k - from } else { k } as u64,
                    sample_ns: Some(truth - if is_after { HOUR } else { 0 }),
                    receipt_ns: truth + 2 * MS,
                    ..even
                }
            })
            .collect();
        let (stamps, quality) = stamps(Some(StampSource::Sample), &readings);
        let case = format!("uneven {is_uneven}, restart {has_restart}, from {from}");
        assert_eq!(quality.steps, 1, "{case}");
        assert_eq!(quality.restarts, u64::from(has_restart), "{case}");
        for (stamp, reading) in stamps.iter().zip(&readings) {
            let delay_ns = reading.receipt_ns - stamp;
            assert!((0..10 * MS).contains(&delay_ns), "{case}: {delay_ns} ns");
        }
    }
}

/// The clock of a take is never set; if it were, stamps by arrival would stand still.
#[test]
fn stamps_by_arrival_never_go_back() {
    let mut readings: Vec<StampReading> = (0..600).map(reading).collect();
    for reading in &mut readings[300..] {
        reading.receipt_ns -= 3_600_000 * MS;
    }
    let (stamps, quality) = stamps(Some(StampSource::Receipt), &readings);
    assert!(stamps.is_sorted() && quality.steps > 0);
}

/// Readings with those times and arrivals \[ns\], numbered in that order.
fn readings(times: impl IntoIterator<Item = (i64, i64)>) -> Vec<StampReading> {
    let reading = |(k, (time_ns, receipt_ns)): (usize, (i64, i64))| StampReading {
        session: 1,
        sequence: k as u64,
        sample_ns: Some(START + time_ns),
        device_ns: Some(time_ns),
        receipt_ns: START + receipt_ns,
    };
    times.into_iter().enumerate().map(reading).collect()
}

#[test]
fn what_only_looks_like_a_step_is_none() {
    // Any number of nanoseconds below a bound, always the same.
    let noise = |k: i64, below: i64| k.wrapping_mul(7_046_029_254_386_353_131).rem_euclid(below);
    // 200 Hz; every hundredth interval is a hole of 300 ms that no number tells of.
    let holed = |k: i64| k * 5 * MS + k / 100 * 300 * MS;
    let played = |percent: i64| {
        let at = move |k| (holed(k), holed(k) * 100 / percent + noise(k, MS));
        readings((0..2000).map(at))
    };
    let cases = [
        ("holes", played(100)),
        ("holes, a little faster", played(105)),
        ("holes, four times as fast", played(400)),
        ("at once", readings((0..2000).map(|k| (holed(k), k * 1000)))),
        (
            "the last sample before a hole is late by as much",
            readings((0..2000).map(|k| {
                let late = if k % 100 == 99 {
                    298 * MS
                } else {
                    noise(k, MS)
                };
                (holed(k), holed(k) + late)
            })),
        ),
        (
            "delays of up to 40 ms",
            readings((0..2000).scan(0, |last, k| {
                *last = (k * 5 * MS + noise(k, 40 * MS)).max(*last);
                Some((k * 5 * MS, *last))
            })),
        ),
        (
            "stalls of 30 ms",
            readings((0..2000).map(|k| {
                let time_ns = k * 5 * MS;
                let held = (k % 50 < 6).then_some((k - k % 50 + 6) * 5 * MS);
                (time_ns, held.unwrap_or(time_ns) + noise(k, MS))
            })),
        ),
        (
            "uneven readings",
            readings((0..2000).map(|k| {
                let time_ns = k * 50 * MS + noise(k, 45 * MS);
                (time_ns, time_ns + noise(k, 2 * MS))
            })),
        ),
        (
            "stamps off by up to 8 ms",
            readings((0..2000).map(|k| (k * 5 * MS + noise(k, 8 * MS), k * 5 * MS + 9 * MS))),
        ),
    ];
    for (name, readings) in cases {
        for source in [StampSource::Sample, StampSource::Device] {
            let (stamps, quality) = stamps(Some(source), &readings);
            assert_eq!(quality.steps, 0, "{name}, {source:?}");
            if source == StampSource::Sample {
                let given = readings.iter().filter_map(|r| r.sample_ns);
                assert!(given.eq(stamps), "{name}");
            }
        }
    }
}

#[test]
fn a_stall_of_delivery_is_no_step() {
    for source in [StampSource::Sample, StampSource::Device] {
        let readings: Vec<StampReading> = (0..1000)
            .map(|k| {
                // Everything measured within a second comes at its end, at once.
                let held = (400..600).contains(&k);
                let receipt_ns = if held {
                    START + 3000 * MS
                } else {
                    reading(k).receipt_ns
                };
                StampReading {
                    receipt_ns,
                    ..reading(k)
                }
            })
            .collect();
        let (stamps, quality) = stamps(Some(source), &readings);
        assert_eq!(quality.steps, 0, "{source:?}");
        for (k, pair) in stamps.windows(2).enumerate() {
            let interval = pair[1] - pair[0];
            // The envelope may rise by a thousandth of the stall.
            assert!(
                (3 * MS..7 * MS).contains(&interval),
                "{source:?} {k}: {interval}"
            );
        }
    }
}

#[test]
fn a_restart_goes_on_from_arrival() {
    let mut readings: Vec<StampReading> = (0..200).map(reading).collect();
    for (k, reading) in readings[100..].iter_mut().enumerate() {
        reading.session = 2;
        reading.sequence = k as u64;
        reading.device_ns = Some(k as i64 * 5 * MS);
    }
    let rate = StampSource::Sequence { rate_hz: 200.0 };
    for source in [StampSource::Device, rate, StampSource::Receipt] {
        let (stamps, quality) = stamps(Some(source), &readings);
        assert_eq!((quality.restarts, quality.steps), (1, 0));
        for (stamp, reading) in stamps.iter().zip(&readings).skip(20) {
            let delay = reading.receipt_ns - stamp;
            assert!((-MS..3 * MS).contains(&delay), "{source:?}: {delay}");
        }
    }
}

#[test]
fn numbers_at_a_rate_are_stamps() {
    let mut readings: Vec<StampReading> = (0..400).map(reading).collect();
    // A hole, and one that comes late.
    readings.drain(100..150);
    readings.swap(200, 201);
    let source = StampSource::Sequence { rate_hz: 200.0 };
    let (stamps, _) = stamps(Some(source), &readings);
    for (stamp, reading) in stamps.iter().zip(&readings) {
        let truth = START + reading.sequence as i64 * 5 * MS;
        assert!((stamp - truth - 2 * MS).abs() < MS, "{}", stamp - truth);
    }
}

#[test]
fn no_numbers_break_it() {
    let extremes = [i64::MIN + 1, -1, 0, 1, i64::MAX];
    for source in [
        StampSource::Sample,
        StampSource::Device,
        StampSource::Sequence { rate_hz: 1e-3 },
        StampSource::Receipt,
    ] {
        let mut clock = StreamClock::new(Some(source));
        for (k, a) in extremes.into_iter().enumerate() {
            for b in extremes {
                clock.stamp(&StampReading {
                    session: k as u32 % 2,
                    sequence: a as u64,
                    sample_ns: Some(b),
                    device_ns: (b != 0).then_some(a),
                    receipt_ns: START,
                });
            }
        }
        assert!(clock.quality().delay_sd_ms.is_finite());
    }
}
