//! Many trackers at a high rate, on circles: whether anything is lost.

use std::time::Instant;

use enact::ingest::live::{NO_TIME, Node, PoseRecord};
use enact::write::TrackerPublisher;

use super::fault::Faulty;
use super::play::Sent;
use super::{Arguments, Director, now_ns, session, wait_until};

/// Samples per second of every tracker, where `--rate-hz` does not say.
const RATE_HZ: f64 = 1000.0;

/// Radius of the circles \[m\], and turns per second.
const RADIUS_M: f64 = 0.2;
const TURNS_HZ: f64 = 0.5;

pub fn run(arguments: &Arguments, node: &Node, trackers: usize) -> anyhow::Result<Sent> {
    let name = |k: usize| {
        arguments
            .names
            .get(k)
            .cloned()
            .unwrap_or(format!("t{}", k + 1))
    };
    let names: Vec<String> = (0..trackers)
        .map(|k| format!("/tracker/{}/pose", name(k)))
        .collect();
    let publisher = TrackerPublisher::open(node, &names, "/marks")?;
    let session = session();
    let mut director = Director::new(arguments, node, &publisher, session)?;
    director.begin(arguments)?;
    let mut faulty = Faulty::new(&arguments.faults);
    let mut sent = Sent::default();
    let rate_hz = arguments.manner.knobs.rate_hz.unwrap_or(RATE_HZ);
    let count = (arguments.seconds * rate_hz) as u64;
    let begun = Instant::now();
    for sequence in 0..count {
        let time_s = sequence as f64 / rate_hz;
        if arguments.rate > 0.0 {
            wait_until(begun, time_s / arguments.rate);
        }
        let now_ns = sent.at(now_ns());
        for topic in 0..trackers {
            let angle = std::f64::consts::TAU * TURNS_HZ * time_s + topic as f64;
            let record = PoseRecord {
                sequence,
                available_ns: now_ns,
                sample_ns: if arguments.no_sample_time {
                    NO_TIME
                } else {
                    now_ns
                },
                device_ns: (time_s * 1e9) as i64,
                position_m: [RADIUS_M * angle.cos(), RADIUS_M * angle.sin(), 1.0],
                quaternion_xyzw: [0.0, 0.0, (angle / 2.0).sin(), (angle / 2.0).cos()],
                flags: 1,
                session,
            };
            for (topic, record) in faulty.sent(topic, record) {
                publisher.pose(topic, record)?;
                sent.poses += 1;
            }
        }
    }
    director.end(arguments)?;
    Ok(sent)
}
