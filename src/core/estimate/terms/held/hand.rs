//! What a body's own tracker shows of the hand that lets go of it, or takes it.

use super::inverse_root;
use crate::estimate::problem::{HeldState, Problem};
use crate::estimate::unknowns::point::Point;
use crate::estimate::wander::Process;
use crate::physics::State;
use crate::physics::state::part;

/// By so many standard deviations per axis an acceleration differs from that of a flight where a hand is seen to let go: of a
/// thousand that do not differ, one does so.
const SHOWN: f64 = 4.0;

impl HeldState {
    /// Takes in that a hand strays so from what is meant, in place and turn, in units of these: the smoothed state errs with it.
    pub fn stray(&mut self, errors: &[Process; 2], units: [f64; 2]) {
        if !self.strays {
            return;
        }
        let mut covariance = self.covariance;
        let parts = [
            [part::POSITION, part::VELOCITY],
            [part::ORIENTATION, part::ANGULAR_VELOCITY],
        ];
        for ((process, unit), at) in errors.iter().zip(units).zip(parts) {
            let strayed = [process.stray_variance(), process.stray_rate_variance()];
            for (at, variance) in at.into_iter().zip(strayed) {
                for axis in at..at + 3 {
                    covariance[(axis, axis)] += unit * unit * variance;
                }
            }
        }
        self.root = inverse_root(&covariance) * self.motion.counted.sqrt();
    }

    /// Whether its tracker shows that a hand lets go of it at a point, or takes it: that it is accelerated otherwise than in flight,
    /// by more than so many deviations of that. Where it is not, nothing tells when that is.
    pub fn shows_hand(&self, problem: &Problem, point: &Point, arc: usize) -> bool {
        let Some(meeting) = self.motion.meeting(self.event) else {
            return false;
        };
        let clock = self.clock(problem, point);
        let driven = self.mounted(clock.acted_s, &point.parameters).driven;
        let there = driven.at_rate(clock.rate);
        let body = problem.body_of(arc);
        let gravity = problem.gravity(&point.parameters);
        let State {
            velocity_m_s,
            angular_velocity_rad_s: omega,
            ..
        } = there.state;
        let spin = there.state.orientation * omega;
        let flown = body.pull_m_s2(&gravity) + body.air_m_s2(&velocity_m_s, &spin);
        let moments = body.moments_kg_m2();
        let turned = -omega
            .cross(&moments.component_mul(&omega))
            .component_div(&moments);
        let off = [
            there.acceleration_m_s2 - flown,
            there.angular_acceleration_rad_s2 - turned,
        ];
        let mut each = off.iter().zip(meeting.acceleration_sds);
        let squared = clock.rate * clock.rate;
        each.any(|(off, sd)| off.norm() > SHOWN * sd * squared)
    }
}
