//! The performance maker: its truths obey physics, its acting is as bad as its knobs say.

#[path = "../tools/perform/mod.rs"]
mod perform;

use perform::{Acting, Style, bounces, perform};

#[test]
fn goals_are_met_to_rounding() {
    for style in Style::ALL {
        let truth = style.truth();
        println!(
            "{style:?} miss {:e} {:?} {}",
            truth.goal_miss(),
            truth.event_times_s,
            truth.duration_s
        );
        let p = perform(&truth, &Acting::default(), 7);
        println!("{} events", p.events.len());
        assert!(truth.goal_miss() < 1e-13);
    }
    for n in [1, 4, 12, 100, 1000] {
        let t = std::time::Instant::now();
        let b = bounces(n, 1);
        println!("{n} {:?} {:?}", b.map(|b| b.duration_s), t.elapsed());
    }
}
