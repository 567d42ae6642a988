//! The performance maker: its truths obey physics, its acting is as bad as its knobs say.

#[path = "../tools/perform/mod.rs"]
mod perform;

use perform::{Acting, Style, bounces, perform};

#[test]
fn goals_are_met_to_rounding() {
    for style in Style::ALL {
        let truth = style.truth();
        println!("{style:?} miss {:e} {:?} {}", truth.goal_miss(), truth.event_times_s, truth.duration_s);
        let p = perform(&truth, &Acting::default(), 7);
        println!("{} events", p.events.len());
        assert!(truth.goal_miss() < 1e-13);
    }
    for n in [1, 4, 12, 30, 100, 300, 1000] {
        let t = std::time::Instant::now();
        for s in 0..if n > 99 {3} else {30} {
        let b = bounces(n, s); let Ok(b)=b else {println!("{n} {s} FAIL");continue;};
        let w = b.arcs.iter().map(|a| a.state.angular_velocity_rad_s.norm()).fold(0.0, f64::max);
        let d = b.arcs.iter().take(n).map(|a| a.end_s-a.start_s).fold(1.0, f64::min);
        println!("{n} {:?} {w} {d} {:?}", b.duration_s, t.elapsed());}
    }
}
