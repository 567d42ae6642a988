use super::*;
use crate::math::differentiate;
use crate::physics::state::StateTangent;
use crate::physics::{Support, flow};

fn bodies() -> [Body; 2] {
    [
        Body::new(0.08, Vector3::new(3e-4, 4e-4, 5e-4)).unwrap(),
        Body::new(0.025, Vector3::new(1e-3, 1e-3, 2e-7)).unwrap(),
    ]
}

fn states() -> [State; 2] {
    let one = State {
        position_m: Vector3::new(0.1, -0.2, 0.9),
        orientation: UnitQuaternion::from_euler_angles(0.4, -1.1, 2.0),
        velocity_m_s: Vector3::new(1.5, 0.7, 0.1),
        angular_velocity_rad_s: Vector3::new(3.0, -7.0, 5.0),
    };
    let other = State {
        position_m: Vector3::new(-0.2, -0.15, 1.0),
        orientation: UnitQuaternion::from_euler_angles(-0.5, -1.0, 1.0),
        velocity_m_s: Vector3::new(-0.4, 8.2, 0.6),
        angular_velocity_rad_s: Vector3::new(-1.0, 2.0, 0.5),
    };
    [one, other]
}

fn joined() -> Pose {
    Pose::from_parts(
        Vector3::new(-0.3, 0.1, 0.05).into(),
        UnitQuaternion::from_euler_angles(0.3, 0.8, -0.4),
    )
}

fn moved(x: &[f64]) -> [State; 2] {
    let [one, other] = states();
    let [by, other_by] = [&x[..12], &x[12..]].map(StateTangent::from_column_slice);
    [one.retract(&by), other.retract(&other_by)]
}

#[test]
fn derivatives_of_rows_are_those_of_differences() {
    let [one, other] = bodies();
    let rows = |of: usize, states: [&State; 2]| match of {
        0 => PairRows::momenta([&one, &other], states, 7e-4),
        _ => PairRows::slip(states),
    };
    for of in 0..2 {
        let [first, second] = states();
        let exact = rows(of, [&first, &second]);
        let numeric = differentiate::jacobian(6, 24, |x| {
            let [first, second] = moved(x);
            let values = rows(of, [&first, &second]).values;
            values.iter().copied().collect()
        });
        for row in 0..6 {
            for column in 0..24 {
                let exact = exact.by[column / 12][(row, column % 12)];
                let found = numeric[row][column];
                let error = (exact - found).abs();
                assert!(
                    error < 1e-6 * (1.0 + exact.abs()),
                    "{of} {row} {column}: {exact} for {found}"
                );
            }
        }
    }
}

#[test]
fn a_part_moves_with_the_whole() {
    let [one, other] = bodies();
    let parts = StuckPart::both([&one, &other], &joined()).unwrap();
    let [mut first, _] = states();
    first.velocity_m_s.z = 2.0;
    let whole = parts[0].of_whole(&first);
    let second = parts[1].of_body(&whole);
    let pose = first.world_from_body().inverse() * second.world_from_body();
    assert!((pose.inverse() * joined()).translation.vector.norm() < 1e-14);
    assert!((pose.inverse() * joined()).rotation.angle() < 1e-7);
    assert!(PairRows::slip([&first, &second]).values.norm() < 1e-13);
    // The momenta of both are those of the whole.
    let momenta = PairRows::momenta([&one, &other], [&first, &second], 1.0).values;
    let spin = parts[0]
        .moments_kg_m2
        .component_mul(&whole.angular_velocity_rad_s);
    assert!((momenta.fixed_rows::<3>(0) - whole.velocity_m_s).norm() < 1e-13);
    assert!((momenta.fixed_rows::<3>(3) - whole.orientation * spin).norm() < 1e-15);
    let [one, other] = [(one, parts[0]), (other, parts[1])]
        .map(|(body, part)| body.with_support(Some(Support::Stuck(part))));
    let gravity = Vector3::new(0.3, 0.0, -9.8);
    for duration_s in [0.0, 0.4, -0.7] {
        let after = [(one, first), (other, second)]
            .map(|(body, state)| flow::advance(&body, &gravity, &state, duration_s));
        assert!(PairRows::slip([&after[0], &after[1]]).values.norm() < 1e-11);
        let then = after[0].world_from_body().inverse() * after[1].world_from_body();
        assert!((then.translation.vector - joined().translation.vector).norm() < 1e-12);
        let flown = flow::advance(&parts[0].whole(), &gravity, &whole, duration_s);
        assert!(parts[0].of_whole(&after[0]).minus(&flown).norm() < 1e-11);
    }
}

#[test]
fn derivatives_of_a_part_in_flight_are_those_of_differences() {
    let [one, other] = bodies();
    let part = StuckPart::both([&one, &other], &joined()).unwrap()[0];
    let body = one.with_support(Some(Support::Stuck(part)));
    let gravity = Vector3::new(0.3, 0.0, -9.8);
    let [state, _] = states();
    for duration_s in [0.35, -0.2] {
        let mut supported = flow::Supported::new(&body, &gravity, &state).unwrap();
        let exact = supported.carried(duration_s);
        let end = supported.at(duration_s);
        assert!(exact.state.minus(&end).norm() < 1e-12);
        let numeric = differentiate::jacobian(12, 16, |x| {
            let from = state.retract(&StateTangent::from_column_slice(&x[..12]));
            let pull = gravity + Vector3::from_column_slice(&x[12..15]);
            let there = flow::advance(&body, &pull, &from, duration_s + x[15]);
            there.minus(&end).iter().copied().collect()
        });
        for row in 0..12 {
            for column in 0..16 {
                let exact = match column {
                    0..12 => exact.by_state[(row, column)],
                    15 => exact.rate[row],
                    _ => exact.by_pull[column - 12][row],
                };
                let error = (exact - numeric[row][column]).abs();
                assert!(
                    error < 1e-5 * (1.0 + exact.abs()),
                    "{row} {column}: {exact} for {}",
                    numeric[row][column]
                );
            }
        }
    }
}
