//! The bodies of a meeting at their contacts, and the impulses that the law gives.

use nalgebra::{Matrix3, Vector3};

use super::arm::{Arm, ArmVariation};
use super::coulomb::{Coulomb, CoulombVariation};
use super::error::ImpactError;
use super::meeting::{Impact, Law, MOST_CONTACTS, Meeting, Side, Velocities};
use super::newton::Newton;
use crate::math::so3;
use crate::physics::contact::{Contact, Degenerate, Frame, Touch, TouchDerivative};

/// A contact in the poses at hand.
#[derive(Clone, Copy)]
pub(super) struct Encounter {
    pub(super) touch: Touch,
    /// Derivatives of the touch, if they are wanted.
    rates: Option<TouchDerivative>,
    /// The normal that the impact sees [world].
    pub(super) normal: Vector3<f64>,
    /// Whether that may be tilted.
    pub(super) is_on_face: bool,
    /// Its derivative by the tilts, zero where there is none.
    pub(super) normal_by_tilt: [Vector3<f64>; 2],
    pub(super) arms: [Arm; 2],
}

/// How an encounter varies: with the pose of one of the bodies, or with a tilt.
#[derive(Clone, Copy)]
pub(super) struct Variation {
    pub(super) arms: [ArmVariation; 2],
    /// Change of the normal that the impact sees.
    pub(super) normal: Vector3<f64>,
}

impl Variation {
    pub(super) fn none() -> Self {
        let still = ArmVariation {
            turn: Vector3::zeros(),
            point: Vector3::zeros(),
        };
        Self {
            arms: [still; 2],
            normal: Vector3::zeros(),
        }
    }
}

impl Encounter {
    /// Derivatives of the touch, of an assembly that was made with them.
    pub(super) fn rates(&self) -> &TouchDerivative {
        self.rates.as_ref().expect("made with rates")
    }

    fn new(
        contact: &Contact,
        a: &Side,
        b: Option<&Side>,
        law: &Law,
        with_rates: bool,
    ) -> Result<Self, Degenerate> {
        let frames = (
            Frame::of(a.state),
            b.map_or_else(Frame::world, |b| Frame::of(b.state)),
        );
        let (touch, rates) = if with_rates {
            let (touch, rates) = contact.touch_derivative(&frames.0, &frames.1)?;
            (touch, Some(rates))
        } else {
            (contact.touch(&frames.0, &frames.1)?, None)
        };
        let arms = [Arm::new(Some(a), &touch.on_a_m), Arm::new(b, &touch.on_b_m)];
        let (normal, normal_by_tilt) = match contact.tilt_axes() {
            Some(axes) => {
                let axes = axes.map(|axis| arms[1].rotation * axis);
                tilted(&touch.normal, &axes, law)
            }
            None => (touch.normal, [Vector3::zeros(); 2]),
        };
        Ok(Self {
            touch,
            rates,
            normal,
            is_on_face: contact.tilt_axes().is_some(),
            normal_by_tilt,
            arms,
        })
    }

    /// Velocity of A's point relative to B's [m/s, world].
    pub(super) fn relative(&self, motion: &[Velocities; 2]) -> Vector3<f64> {
        self.arms[0].point_velocity(&motion[0]) - self.arms[1].point_velocity(&motion[1])
    }

    /// Change of [`Self::relative`] at fixed velocities of the bodies.
    pub(super) fn relative_change(&self, motion: &[Velocities; 2], by: &Variation) -> Vector3<f64> {
        self.arms[0].point_velocity_change(&motion[0], &by.arms[0])
            - self.arms[1].point_velocity_change(&motion[1], &by.arms[1])
    }

    /// What an impulse on A, and its opposite on B, add to the velocities.
    pub(super) fn kicks(&self, impulse: &Vector3<f64>) -> [Velocities; 2] {
        [self.arms[0].kick(impulse), self.arms[1].kick(&-impulse)]
    }

    fn kicks_change(
        &self,
        impulse: &Vector3<f64>,
        impulse_change: &Vector3<f64>,
        by: &Variation,
    ) -> [Velocities; 2] {
        [
            self.arms[0].kick_change(impulse, impulse_change, &by.arms[0]),
            self.arms[1].kick_change(&-impulse, &-impulse_change, &by.arms[1]),
        ]
    }

    fn mobility(&self) -> Matrix3<f64> {
        self.arms[0].mobility() + self.arms[1].mobility()
    }

    fn mobility_change(&self, impulse: &Vector3<f64>, by: &Variation) -> Vector3<f64> {
        self.arms[0].mobility_change(impulse, &by.arms[0])
            + self.arms[1].mobility_change(impulse, &by.arms[1])
    }
}

/// The normal turned by the law's tilt about these axes [world], and its derivatives.
pub(super) fn tilted(
    normal: &Vector3<f64>,
    axes: &[Vector3<f64>; 2],
    law: &Law,
) -> (Vector3<f64>, [Vector3<f64>; 2]) {
    if law.tilt_rad == [0.0; 2] {
        return (*normal, axes.map(|axis| axis.cross(normal)));
    }
    let tilt = axes[0] * law.tilt_rad[0] + axes[1] * law.tilt_rad[1];
    let (turn, left) = so3::exp_and_left_jacobian(&tilt);
    let tilted = turn * normal;
    (tilted, axes.map(|axis| (left * axis).cross(&tilted)))
}

/// Which law gave the impulses.
enum Solution {
    Coulomb(Coulomb),
    Newton(Newton),
}

/// Bodies, contacts and impulses.
pub(super) struct Assembly {
    encounters: [Encounter; MOST_CONTACTS],
    count: usize,
    /// How many bodies move.
    pub(super) bodies: usize,
    pub(super) before: [Velocities; 2],
    solution: Solution,
}

impl Assembly {
    pub(super) fn new(
        meeting: &Meeting,
        a: &Side,
        b: Option<&Side>,
        law: &Law,
        with_rates: bool,
    ) -> Result<Self, ImpactError> {
        let contacts = meeting.contacts();
        let at = |contact: usize| {
            Encounter::new(&contacts[contact], a, b, law, with_rates)
                .map_err(|reason| ImpactError::Degenerate { contact, reason })
        };
        let mut encounters = [at(0)?; MOST_CONTACTS];
        for contact in 1..contacts.len() {
            encounters[contact] = at(contact)?;
        }
        let before = [
            Velocities::of(a.state),
            b.map_or_else(Velocities::default, |b| Velocities::of(b.state)),
        ];
        let solution = if meeting.has_friction() {
            let only = &encounters[0];
            let velocity = only.relative(&before);
            Solution::Coulomb(Coulomb::new(law, &only.normal, &velocity, &only.mobility()))
        } else {
            let all = &encounters[..contacts.len()];
            Solution::Newton(Newton::new(law.restitution, all, &before)?)
        };
        Ok(Self {
            encounters,
            count: contacts.len(),
            bodies: 1 + usize::from(b.is_some()),
            before,
            solution,
        })
    }

    pub(super) fn encounters(&self) -> &[Encounter] {
        &self.encounters[..self.count]
    }

    /// Impulses on A at the contacts [N s, world].
    fn impulses(&self) -> [Vector3<f64>; MOST_CONTACTS] {
        match &self.solution {
            Solution::Coulomb(law) => [law.impulse(), Vector3::zeros(), Vector3::zeros()],
            Solution::Newton(law) => self.along_normals(&law.impulses()),
        }
    }

    fn along_normals(&self, impulses: &Vector3<f64>) -> [Vector3<f64>; MOST_CONTACTS] {
        let mut result = [Vector3::zeros(); MOST_CONTACTS];
        for (contact, encounter) in self.encounters().iter().enumerate() {
            result[contact] = encounter.normal * impulses[contact];
        }
        result
    }

    pub(super) fn impact(&self) -> Impact {
        let impulses = self.impulses();
        let mut impact = Impact {
            after: self.before,
            sticks: matches!(&self.solution, Solution::Coulomb(law) if law.sticks()),
            ..Impact::default()
        };
        for (contact, encounter) in self.encounters().iter().enumerate() {
            impact.gaps_m[contact] = encounter.touch.gap_m;
            let relative = encounter.relative(&self.before);
            impact.speeds_m_s[contact] = encounter.touch.normal.dot(&relative);
            impact.normal_impulses_n_s[contact] = encounter.normal.dot(&impulses[contact]);
        }
        let kicks = self.kicks(&impulses);
        for body in 0..self.bodies {
            impact.after[body].add_scaled(&kicks[body], 1.0);
        }
        impact
    }

    /// What impulses at the contacts add to the velocities.
    pub(super) fn kicks(&self, impulses: &[Vector3<f64>; MOST_CONTACTS]) -> [Velocities; 2] {
        let mut sum = [Velocities::default(); 2];
        for (encounter, impulse) in self.encounters().iter().zip(impulses) {
            for (sum, kick) in sum.iter_mut().zip(encounter.kicks(impulse)) {
                sum.add_scaled(&kick, 1.0);
            }
        }
        sum
    }

    /// Derivative of the impulses by the restitution.
    pub(super) fn by_restitution(&self) -> [Vector3<f64>; MOST_CONTACTS] {
        match &self.solution {
            Solution::Coulomb(law) => [law.by_restitution(), Vector3::zeros(), Vector3::zeros()],
            Solution::Newton(law) => self.along_normals(law.plastic()),
        }
    }

    /// Derivative of the impulses by the coefficient of friction.
    pub(super) fn by_friction(&self) -> [Vector3<f64>; MOST_CONTACTS] {
        match &self.solution {
            Solution::Coulomb(law) => [law.by_friction(), Vector3::zeros(), Vector3::zeros()],
            Solution::Newton(_) => [Vector3::zeros(); MOST_CONTACTS],
        }
    }

    /// Change of the impulses as the velocities before change.
    pub(super) fn impulses_by_velocities(
        &self,
        change: &[Velocities; 2],
    ) -> [Vector3<f64>; MOST_CONTACTS] {
        match &self.solution {
            Solution::Coulomb(law) => {
                let velocity = self.encounters[0].relative(change);
                let change = law.change(&CoulombVariation {
                    normal: Vector3::zeros(),
                    velocity,
                    mobility_normal: Vector3::zeros(),
                    mobility_stuck: Vector3::zeros(),
                });
                [change, Vector3::zeros(), Vector3::zeros()]
            }
            Solution::Newton(law) => {
                let mut speeds = Vector3::zeros();
                for (contact, encounter) in self.encounters().iter().enumerate() {
                    speeds[contact] = encounter.normal.dot(&encounter.relative(change));
                }
                self.along_normals(&law.change(&speeds, &Vector3::zeros()))
            }
        }
    }

    /// Change of the velocities after as the encounters vary and the velocities before do not.
    pub(super) fn after_change(&self, by: &[Variation; MOST_CONTACTS]) -> [Velocities; 2] {
        let (impulses, changes) = match &self.solution {
            Solution::Coulomb(law) => {
                let (encounter, by) = (&self.encounters[0], &by[0]);
                let change = law.change(&CoulombVariation {
                    normal: by.normal,
                    velocity: encounter.relative_change(&self.before, by),
                    mobility_normal: encounter.mobility_change(&encounter.normal, by),
                    mobility_stuck: encounter.mobility_change(&law.stuck(), by),
                });
                let mut changes = [Vector3::zeros(); MOST_CONTACTS];
                changes[0] = change;
                (self.impulses(), changes)
            }
            Solution::Newton(law) => self.newton_change(law, by),
        };
        self.kicks_change(&impulses, &changes, by)
    }

    fn kicks_change(
        &self,
        impulses: &[Vector3<f64>; MOST_CONTACTS],
        changes: &[Vector3<f64>; MOST_CONTACTS],
        by: &[Variation; MOST_CONTACTS],
    ) -> [Velocities; 2] {
        let mut sum = [Velocities::default(); 2];
        for (contact, encounter) in self.encounters().iter().enumerate() {
            let kicks = encounter.kicks_change(&impulses[contact], &changes[contact], &by[contact]);
            for (sum, kick) in sum.iter_mut().zip(kicks) {
                sum.add_scaled(&kick, 1.0);
            }
        }
        sum
    }

    /// The impulses and their changes: `Λ δp = −(1 + e) δ(J V) − δΛ p` with `Λ = J M⁻¹ Jᵀ` and
    /// `δΛ p = δJ ΔV + J M⁻¹ δJᵀ p`.
    fn newton_change(
        &self,
        law: &Newton,
        by: &[Variation; MOST_CONTACTS],
    ) -> ([Vector3<f64>; MOST_CONTACTS], [Vector3<f64>; MOST_CONTACTS]) {
        let along = law.impulses();
        let impulses = self.along_normals(&along);
        let mut turned = [Vector3::zeros(); MOST_CONTACTS];
        for contact in 0..self.count {
            turned[contact] = by[contact].normal * along[contact];
        }
        let added = self.kicks(&impulses);
        let redirected = self.kicks_change(&impulses, &turned, by);
        let (mut speeds, mut mobility_impulses) = (Vector3::zeros(), Vector3::zeros());
        for (contact, encounter) in self.encounters().iter().enumerate() {
            let row_change = |motion: &[Velocities; 2]| {
                by[contact].normal.dot(&encounter.relative(motion))
                    + encounter
                        .normal
                        .dot(&encounter.relative_change(motion, &by[contact]))
            };
            speeds[contact] = row_change(&self.before);
            mobility_impulses[contact] =
                row_change(&added) + encounter.normal.dot(&encounter.relative(&redirected));
        }
        let change = law.change(&speeds, &mobility_impulses);
        let mut changes = self.along_normals(&change);
        for contact in 0..self.count {
            changes[contact] += turned[contact];
        }
        (impulses, changes)
    }
}
