//! A probe.
use super::reference::{self, Pair};
use super::*;
use crate::physics::Body;
use nalgebra::Vector3;

#[test]
fn probe() {
    for (moments, omega, duration) in [
        ([1.0, 2.0, 3.0], [0.01, 5.0, 0.01], 40.0),
        ([1.0, 2.0, 3.0], [0.01, 5.0, 0.01], 1.0),
        ([1.0, 2.0, 3.0], [3.0, -7.0, 5.0], 1.0),
        ([1.0, 2.0, 3.0], [3.0, -7.0, 5.0], 10.0),
        ([3.0, 2.0, 1.0], [1e-5, -7.0, 1e-5], 10.0),
        ([1.0, 2.0, 3.0], [1e-3, 7.0, 1e-4], 60.0),
        ([1.0, 2.0, 3.0], [1e-3, 7.0, 5.7735e-4], 60.0),
        ([1.0, 1.001, 1.9], [1.0, 7.0, 0.03], 60.0),
        ([3.0, 2.0, 1.0], [300.0, -700.0, 500.0], 1.0),
    ] {
        let body = Body::new(1.0, moments.into()).unwrap();
        let w: Vector3<f64> = omega.into();
        let want = reference::turn(moments, &reference::epoch(omega.map(Pair::from)), duration);
        let t = turn(&body, &nalgebra::UnitQuaternion::identity(), &w, duration);
        let q = t.orientation.into_inner();
        let dq: f64 = [q.w, q.i, q.j, q.k]
            .iter()
            .zip(&want[..4])
            .map(|(a, b)| {
                let s = if q.w * want[0].0 < 0.0 { -1.0 } else { 1.0 };
                ((s * a - b.0) - b.1).powi(2)
            })
            .sum::<f64>()
            .sqrt()
            * 2.0;
        let dw: f64 = (0..3)
            .map(|i| ((t.angular_velocity_rad_s[i] - want[4 + i].0) - want[4 + i].1).powi(2))
            .sum::<f64>()
            .sqrt();
        println!(
            "{moments:?} {omega:?} {duration}: dR {dq:.2e} dw {dw:.2e}  condition R {:.2e} w {:.2e}",
            t.orientation_by_angular_velocity.norm() * w.norm() * 1.1e-16,
            t.angular_velocity_by_angular_velocity.norm() * w.norm() * 1.1e-16
        );
    }
}
