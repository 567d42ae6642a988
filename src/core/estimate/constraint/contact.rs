//! Contact and approach at a collision (paper §5.2): `φ(Φ(q, τ)) = 0` for the gap of each contact,
//! and `n·v ≤ limit` for its normal speed.

use super::rows::{CollisionRows, STATE};
use crate::estimate::problem::unit;
use crate::estimate::reach::arc_end::{ArcEnd, ByState};
use crate::physics::impact::{Impact, ImpactDerivative};
use crate::physics::state::part;

impl CollisionRows<'_> {
    /// Gaps and approach speeds.
    pub(super) fn fill_contacts(&mut self, impact: &Impact, approach_limit_m_s: f64) {
        let (_, block) = &mut self.block;
        for contact in 0..self.places.approaches {
            if contact < self.places.contacts {
                block.values[contact] = impact.gaps_m[contact] / unit::POSITION_M;
            }
            let row = self.places.contacts + contact;
            block.values[row] = impact.speeds_m_s[contact] / unit::VELOCITY_M_S;
            block.bounds[row] = (f64::NEG_INFINITY, approach_limit_m_s / unit::VELOCITY_M_S);
        }
    }

    /// Derivatives of gaps and approach speeds by the arrivals.
    pub(super) fn fill_contact_derivatives(
        &mut self,
        derivative: &ImpactDerivative,
        before: &[Option<ArcEnd>; 2],
    ) {
        let (contacts, approaches) = (self.places.contacts, self.places.approaches);
        let gaps = derivative.gap[..contacts].iter();
        let speeds = derivative.speed[..approaches].iter();
        let units = [unit::POSITION_M, unit::VELOCITY_M_S];
        let gaps = gaps.map(|by| (by, 1.0 / units[0]));
        let speeds = speeds.map(|by| (by, 1.0 / units[1]));
        for (row, (by_arrivals, scale)) in gaps.chain(speeds).enumerate() {
            let (pattern, block) = &mut self.block;
            let (states, rest) = block
                .derivatives_mut(pattern, row)
                .split_at_mut(STATE * self.places.states);
            rest.fill(0.0);
            for (side, arrival) in before.iter().enumerate() {
                let Some(arrival) = arrival else { continue };
                let by = ByState::<1>::of(&by_arrivals[side], 0);
                let state = &mut states[STATE * side..][..STATE];
                arrival.chain(&by).put(0, scale, part::POSITION, state);
                rest[0] += arrival.by_time(&by)[0] * scale;
                for (axis, entry) in self.problem.free_gravity().zip(&mut rest[1..]) {
                    *entry += arrival.by_gravity(&by, axis)[0] * scale;
                }
            }
        }
    }
}
