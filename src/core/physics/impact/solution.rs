//! Impulses of an impact by the law, velocities after it, and changes of both.

use nalgebra::Vector3;

use super::contact_set::ContactSet;
use super::contact_state::{ContactState, PoseChange};
use super::coulomb::{Coulomb, CoulombChange};
use super::error::ImpactError;
use super::landing::{self, Landing};
use super::law::{Impact, Law, MOST_CONTACTS, Side, Velocities};
use super::newton::Newton;
use super::rows::{Change, ImpactRows, RowsChange};
use crate::math::so3;
use crate::physics::contact::Frame;

/// Which law gave the impulses.
#[expect(
    clippy::large_enum_variant,
    reason = "it lives on the stack for one impact; a box would allocate"
)]
enum SolvedContact {
    /// Rows are the world's axes at the one contact.
    Coulomb(Coulomb),
    /// Rows are the contacts' normals.
    Newton(Newton),
    /// Rows are the contacts' normals, along which no impulses are told: velocities are given as a whole.
    Landing(Landing),
}

/// An impact solved for its impulses.
pub(super) struct ImpactSolution<'a> {
    states: [Option<ContactState<'a>>; MOST_CONTACTS],
    /// Frames of A and of B.
    pub(super) frames: [Frame; 2],
    pub(super) rows: ImpactRows,
    pub(super) before: [Velocities; 2],
    solved: SolvedContact,
    /// Along the rows [N s].
    impulses: Vector3<f64>,
}

impl<'a> ImpactSolution<'a> {
    pub(super) fn new(
        contacts: &'a ContactSet,
        a: &Side,
        b: Option<&Side>,
        law: &Law,
    ) -> Result<Self, ImpactError> {
        let frames = [
            Frame::of(a.state),
            b.map_or_else(Frame::world, |b| Frame::of(b.state)),
        ];
        let rotations = frames.map(|frame| so3::matrix(&frame.orientation));
        let before = [
            Velocities::of(a.state),
            b.map_or_else(Velocities::default, |b| Velocities::of(b.state)),
        ];
        let mut states = [const { None }; MOST_CONTACTS];
        let mut rows = ImpactRows::new(a, b);
        for (index, contact) in contacts.as_slice().iter().enumerate() {
            let touch = contact.touch(&frames[0], &frames[1]).map_err(|reason| {
                ImpactError::Degenerate {
                    contact: index,
                    reason,
                }
            })?;
            let state = ContactState::new(contact, touch, rotations, law);
            if contacts.has_friction() && !contacts.is_landing() {
                for axis in 0..3 {
                    let direction = Vector3::ith(axis, 1.0);
                    rows.set(axis, direction, state.levers(&direction));
                }
            } else {
                let normal = state.normal;
                rows.set(index, normal, state.levers(&normal));
            }
            states[index] = Some(state);
        }
        let (speeds, delassus) = (rows.speeds(&before), rows.delassus());
        let solved = match &states[0] {
            Some(first) if contacts.is_landing() => {
                SolvedContact::Landing(Landing::new(a, &first.normal, law))
            }
            Some(only) if contacts.has_friction() => {
                SolvedContact::Coulomb(Coulomb::new(law, &only.normal, &speeds, &delassus)?)
            }
            _ => {
                let count = contacts.as_slice().len();
                SolvedContact::Newton(Newton::new(law.restitution, count, &speeds, &delassus)?)
            }
        };
        let impulses = match &solved {
            SolvedContact::Coulomb(law) => law.impulse(),
            SolvedContact::Newton(law) => law.impulses(),
            SolvedContact::Landing(_) => Vector3::zeros(),
        };
        Ok(Self {
            states,
            frames,
            rows,
            before,
            solved,
            impulses,
        })
    }

    pub(super) fn states(&self) -> impl Iterator<Item = &ContactState<'a>> {
        self.states.iter().flatten()
    }

    pub(super) fn impact(&self) -> Impact {
        let mut impact = Impact {
            after: self.before,
            sticks: match &self.solved {
                SolvedContact::Coulomb(law) => law.sticks(),
                SolvedContact::Landing(landing) => landing.sticks,
                SolvedContact::Newton(_) => false,
            },
            ..Impact::default()
        };
        let pressing = match &self.solved {
            SolvedContact::Landing(landing) => {
                impact.after[0] = landing.velocities();
                self.pressing(&impact.after[0])
            }
            _ => self.impulses,
        };
        for (contact, state) in self.states().enumerate() {
            impact.gaps_m[contact] = state.touch.gap_m;
            impact.speeds_m_s[contact] = state.speed(&self.before);
            impact.normal_impulses_n_s[contact] = match &self.solved {
                SolvedContact::Coulomb(_) => state.normal.dot(&self.impulses),
                SolvedContact::Newton(_) | SolvedContact::Landing(_) => pressing[contact],
            };
        }
        // Of a flat landing they are zero.
        let velocity_changes = self.rows.velocity_changes(&self.impulses);
        for body in 0..self.rows.bodies {
            impact.after[body].velocity_m_s += velocity_changes[body].velocity_m_s;
            impact.after[body].angular_velocity_rad_s +=
                velocity_changes[body].angular_velocity_rad_s;
        }
        impact
    }

    /// The velocities after a flat landing; `None` of what is told by impulses along rows.
    pub(super) fn landing(&self) -> Option<&Landing> {
        match &self.solved {
            SolvedContact::Landing(landing) => Some(landing),
            _ => None,
        }
    }

    /// Impulses along the normals of a flat landing's contacts [N s].
    fn pressing(&self, after: &Velocities) -> Vector3<f64> {
        let mut states = self.states();
        let points_m = [(); MOST_CONTACTS].map(|()| {
            let state = states.next().expect("three contacts");
            self.frames[0].orientation * state.touch.on_a_m
        });
        let normal = self.states().next().expect("three contacts").normal;
        let [momentum, turned] = self.gained(after);
        landing::pressing(&points_m, &normal, &momentum, &turned)
    }

    /// What A gains of momentum [N s], and of angular momentum about its centre of mass [N m s, world].
    pub(super) fn gained(&self, after: &Velocities) -> [Vector3<f64>; 2] {
        let [before, _] = &self.before;
        let inertia = self.rows.of_a();
        let spun = after.angular_velocity_rad_s - before.angular_velocity_rad_s;
        [
            (after.velocity_m_s - before.velocity_m_s) / inertia.mass_per_kg,
            self.frames[0].orientation * spun.component_div(&inertia.moments_per_kg_m2),
        ]
    }

    /// Impulse on A at a contact [N s, world]; of a flat landing its part along the normal.
    pub(super) fn impulse_at(
        &self,
        contact: usize,
        state: &ContactState,
        impact: &Impact,
    ) -> Vector3<f64> {
        match &self.solved {
            SolvedContact::Coulomb(_) => self.impulses,
            SolvedContact::Newton(_) | SolvedContact::Landing(_) => {
                state.normal * impact.normal_impulses_n_s[contact]
            }
        }
    }

    /// Changes of the impulses with the poses; `normals` are the changes of the tilted normals.
    pub(super) fn impulses_change<const C: usize>(
        &self,
        normals: &[Change<C>; MOST_CONTACTS],
        by: &RowsChange<C>,
    ) -> Change<C> {
        let velocity = self.rows.speeds_change(&self.before, by);
        match &self.solved {
            SolvedContact::Coulomb(law) => law.change(&CoulombChange {
                normal: normals[0],
                velocity,
                delassus_normal: self.rows.delassus_change(law.normal(), by),
                delassus_stuck: self.rows.delassus_change(&law.stuck(), by),
                delassus_rigid: Change::zeros(),
            }),
            SolvedContact::Newton(law) => {
                law.change(&velocity, &self.rows.delassus_change(&self.impulses, by))
            }
            SolvedContact::Landing(_) => Change::zeros(),
        }
    }

    /// Impulses along the rows [N s].
    pub(super) fn impulses(&self) -> &Vector3<f64> {
        &self.impulses
    }

    /// Changes of the impulses under changes of the rows' speeds.
    pub(super) fn impulses_by_speeds<const C: usize>(&self, speeds: Change<C>) -> Change<C> {
        match &self.solved {
            SolvedContact::Coulomb(law) => law.by_velocity(speeds),
            SolvedContact::Newton(law) => law.by_speeds(&speeds),
            SolvedContact::Landing(_) => Change::zeros(),
        }
    }

    /// Changes of the impulses by `ln` of one body's mass and of its three moments.
    pub(super) fn impulses_by_inertia(&self, body: usize) -> Change<4> {
        let delassus = |impulses: &Vector3<f64>| -> Change<4> {
            self.rows.of_body(body) * self.rows.velocity_changes_by_inertia(body, impulses)
        };
        match &self.solved {
            SolvedContact::Coulomb(law) => law.change(&CoulombChange {
                normal: Change::zeros(),
                velocity: Change::zeros(),
                delassus_normal: delassus(law.normal()),
                delassus_stuck: delassus(&law.stuck()),
                delassus_rigid: Change::zeros(),
            }),
            SolvedContact::Newton(law) => law.change(&Change::zeros(), &delassus(&self.impulses)),
            SolvedContact::Landing(_) => Change::zeros(),
        }
    }

    /// Derivatives of the impulses by restitution, friction and tangential restitution.
    pub(super) fn impulses_by_law(&self) -> Change<3> {
        match &self.solved {
            SolvedContact::Coulomb(law) => Change::from_columns(&[
                law.by_restitution(),
                law.by_friction(),
                law.by_tangential_restitution(),
            ]),
            SolvedContact::Newton(law) => {
                Change::from_columns(&[law.by_restitution(), Vector3::zeros(), Vector3::zeros()])
            }
            SolvedContact::Landing(_) => Change::zeros(),
        }
    }

    /// Changes of the rows with the states, given the changes of their normals.
    pub(super) fn rows_change<const C: usize>(
        &self,
        normals: &[Change<C>; MOST_CONTACTS],
        poses: &[Option<PoseChange<C>>; MOST_CONTACTS],
    ) -> RowsChange<C> {
        let mut levers = [[Change::zeros(); 3]; 2];
        let is_axes = matches!(self.solved, SolvedContact::Coulomb(_));
        for (contact, (state, by)) in self.states().zip(poses.iter().flatten()).enumerate() {
            for body in 0..self.rows.bodies {
                let sign = [1.0, -1.0][body];
                if is_axes {
                    for axis in 0..3 {
                        let direction = Vector3::ith(axis, 1.0);
                        levers[body][axis] = state.lever_change(body, &direction, None, by) * sign;
                    }
                } else {
                    let turned = Some(&normals[contact]);
                    levers[body][contact] =
                        state.lever_change(body, &state.normal, turned, by) * sign;
                }
            }
        }
        RowsChange {
            directions: (!is_axes).then_some(*normals),
            levers,
        }
    }
}
