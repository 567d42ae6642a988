//! Stage 4c: past the sketch. The motion continues from the estimate's end by forward simulation
//! until it rests (paper §6.2.3: the pencil skitters in the mug). The only room that imports
//! rapier.
//!
//! Bodies have the mass, moments, force, drag and lift of the scene, obstacles and planes are fixed. Held
//! bodies are moved as they were tracked, and stand still where their tracks end.
//! Contacts are
//! rapier's, with the restitution and friction of the scene's bodies that have them: softened over millimetres, first order in the
//! step. That suffices to bring bodies to rest. Where the bodies' restitution and friction were fitted to how they come to rest it
//! predicts where (`docs/predict.md`); otherwise it is a way to rest, since none of it was performed.

mod convert;
mod joined;
mod material;

use nalgebra::{Unit, Vector3};
use rapier3d::math::{Pose as RapierPose, Rotation as RapierRotation, Vector as RapierVector};
use rapier3d::prelude::{
    ActiveHooks, ColliderBuilder, MassProperties, PhysicsWorld, RigidBody, RigidBodyBuilder,
    RigidBodyHandle,
};
use typed_index_collections::{TiSlice, TiVec};

use self::convert::{from_rapier, pose_of, to_rapier, to_rapier_pose};
use self::joined::{Joined, Moving, Tied};
pub use self::material::{FRICTION, FRICTION_SD, RESTITUTION, RESTITUTION_SD};
use self::material::{made_of, standing};
use crate::motion::{
    Estimate, JointTree, LinkIndex, MechanismIndex, Observer, Scene, Settled, SettledLink, Surface,
};
use crate::physics::tree::{Snapshot, Tree, TreeState};
use crate::physics::{Body, State};

/// Time between two poses \[s\], and the step of the simulation: at shorter ones rapier's bodies
/// do not fall asleep.
pub const INTERVAL_S: f64 = 1.0 / 240.0;

/// Angular damping [1/s]: without it rapier's cylinders and balls would roll for ever.
const ROLLING_PER_S: f64 = 1.0;

/// Prediction distance of contacts as a multiple of the longest way of any body in a step; rapier
/// searches pairs within half of it. With this a pencil does not pass through a wall of 4 mm at
/// 5 m/s, at a tenth of the cost of continuous collision detection, which sweeps a thin rotating
/// body among close walls by bisection in every step.
const STEPS_AHEAD: f64 = 2.0;

/// Greatest speed at which an overlap at the end of an estimate is resolved, in body radii per
/// second.
const PUSH_RADII_PER_S: f64 = 0.5;

/// Steps of rapier's solver in a step, where bodies are joined: with its usual four, thin ones burst.
const JOINED_SOLVER_STEPS: usize = 16;

/// What a simulation of joined bodies may gain by the order of its steps: of the kinetic energy at the
/// end of the estimate, and of a fall by their radii.
const GAIN: f64 = 0.2;

/// Slow is what moves at less than this share of the speed of a fall by its own radius,
const SLOW: f64 = 0.02;
/// for so many steps.
const SLOW_STEPS: usize = 12;

/// Simulates all links from the end of the estimate until they rest, for at most `limit_s`.
///
/// A link whose last arc ends earlier flies freely until the last of all ends. The first poses
/// are those of the estimate's end, bit for bit, of joined bodies to rounding. `None` where nothing moves or the estimate is
/// not finite. Where joined bodies gain energy, which no contact gives them, the simulation has failed:
/// it ends before, and they are not at rest.
pub fn settle(scene: &Scene, estimate: &Estimate, limit_s: f64) -> Option<Settled> {
    simulated(scene, estimate, limit_s, None, &mut ())
}

/// The same for as long as the observer lets it: what was not simulated is not at rest.
pub fn settle_until(
    scene: &Scene,
    estimate: &Estimate,
    limit_s: f64,
    observer: &mut dyn Observer,
) -> Option<Settled> {
    simulated(scene, estimate, limit_s, None, observer)
}

/// The same simulation, ended as soon as every link has been slow for a while, which is mostly
/// when it is known how they will lie: for comparisons of many. What is slow may still rest on an
/// edge, and [`Settled::at_rest`] is false.
pub fn settle_until_slow(scene: &Scene, estimate: &Estimate, limit_s: f64) -> Option<Settled> {
    simulated(scene, estimate, limit_s, Some(SLOW_STEPS), &mut ())
}

/// Until all rest, or until all have been slow for so many steps.
fn simulated(
    scene: &Scene,
    estimate: &Estimate,
    limit_s: f64,
    slow_steps: Option<usize>,
    observer: &mut dyn Observer,
) -> Option<Settled> {
    let [_, from_s] = estimate.extent_s()?;
    let states = scene.links.iter();
    let states = states.map(|link| last_state(scene, estimate, link.mechanism, from_s));
    let mut states: TiVec<LinkIndex, Option<State>> = states.collect();
    for held in &estimate.held {
        states[held.link] = Some(held.state(from_s));
    }
    let trees = trees(scene, estimate, from_s);
    for tree in &trees {
        let mut snapshot = Snapshot::new(&tree.model, &estimate.gravity_m_s2);
        snapshot.set(&tree.state);
        for (place, link) in tree.joined.links().enumerate() {
            states[link] = Some(snapshot.link_state(place));
        }
    }
    let mut simulation = Simulation::new(scene, estimate, &states)?;
    simulation.join(&trees, &states);
    let steps = (limit_s / INTERVAL_S).floor() as usize;
    let mut settled = Settled {
        from_s,
        interval_s: INTERVAL_S,
        links: states
            .iter()
            .map(|state| SettledLink {
                poses: state.iter().map(State::world_from_body).collect(),
            })
            .collect(),
        at_rest: false,
        is_predicted: false,
        spread: None,
        largest_speed_m_s: states
            .iter()
            .flatten()
            .map(|state| state.velocity_m_s.norm())
            .fold(0.0, f64::max),
    };
    let mut slow = 0;
    for _ in 0..steps {
        if observer.should_stop() {
            break;
        }
        simulation.lead(estimate, from_s);
        simulation.step();
        if simulation.has_burst() {
            break;
        }
        slow = if simulation.is_slow() { slow + 1 } else { 0 };
        for (link, moving) in settled.links.iter_mut().zip(&simulation.links) {
            let Some(handle) = *moving else { continue };
            let moving = &simulation.world.bodies[handle];
            link.poses.push(pose_of(moving));
            let speed_m_s = from_rapier(moving.linvel()).norm();
            settled.largest_speed_m_s = settled.largest_speed_m_s.max(speed_m_s);
        }
        if simulation.is_at_rest() {
            settled.at_rest = true;
            break;
        }
        if slow_steps.is_some_and(|steps| slow >= steps) {
            break;
        }
    }
    Some(settled)
}

/// A mechanism's state at a time that is not before its end.
fn last_state(
    scene: &Scene,
    estimate: &Estimate,
    mechanism: MechanismIndex,
    time_s: f64,
) -> Option<State> {
    let arcs = estimate.arcs.iter();
    let arcs = arcs.filter(|arc| arc.mechanism == mechanism);
    let last = arcs.max_by(|a, b| a.end_s.total_cmp(&b.end_s))?;
    Some(scene.flown(last, &estimate.gravity_m_s2, time_s))
}

/// Joined bodies in a state.
struct TreeMotion<'a> {
    joined: &'a JointTree,
    model: Tree,
    state: TreeState,
}

/// The joined bodies of an estimate at a time that is not before its end.
fn trees<'a>(scene: &'a Scene, estimate: &Estimate, time_s: f64) -> Vec<TreeMotion<'a>> {
    let motions = estimate.trees.iter().filter_map(|motion| {
        let joined = scene.joint_tree(motion.mechanism)?;
        let model = scene.tree_model_with(joined, &estimate.held);
        let state = motion.state(&model, &estimate.gravity_m_s2, time_s);
        Some(TreeMotion {
            joined,
            model,
            state,
        })
    });
    motions.collect()
}

struct Simulation {
    world: PhysicsWorld,
    trees: Vec<Joined>,
    /// Most energy that there can be \[J\]: infinite where something drives the bodies.
    most_j: f64,
    tied: Tied,
    links: TiVec<LinkIndex, Option<RigidBodyHandle>>,
    bodies: TiVec<LinkIndex, Body>,
    /// Number of steps so far.
    steps: usize,
    /// Radii of the spheres about the links' centres \[m\].
    radii_m: TiVec<LinkIndex, f64>,
    /// Least prediction distance of contacts \[m\].
    least_prediction_m: f64,
}

impl Simulation {
    fn new(
        scene: &Scene,
        estimate: &Estimate,
        states: &TiSlice<LinkIndex, Option<State>>,
    ) -> Option<Self> {
        if !states.iter().flatten().all(State::is_finite) {
            return None;
        }
        let mut world = PhysicsWorld::new();
        world.gravity = to_rapier(&estimate.gravity_m_s2);
        let radius_m = scene
            .links
            .iter()
            .map(|link| link.shape.radius_m())
            .fold(f64::INFINITY, f64::min);
        let parameters = &mut world.integration_parameters;
        parameters.dt = INTERVAL_S;
        parameters.length_unit = radius_m;
        parameters.normalized_max_linear_velocity = f64::MAX;
        parameters.max_ccd_substeps = 0;
        parameters.normalized_max_corrective_velocity = PUSH_RADII_PER_S;
        let least_prediction_m = parameters.prediction_distance();
        for obstacle in &scene.obstacles {
            let pose = to_rapier_pose(&obstacle.world_from_shape);
            let solid = obstacle.shape.solid().expect("scenes have valid shapes");
            let (shape, solid_from_shape) = solid.parts();
            world.insert_collider(
                standing(ColliderBuilder::new(shape.clone())).position(pose * *solid_from_shape),
                None,
            );
        }
        for (point_m, normal) in scene.surfaces.iter().filter_map(Surface::plane) {
            let pose = RapierPose::from_parts(to_rapier(&point_m), RapierRotation::IDENTITY);
            let plane = ColliderBuilder::halfspace(Unit::new_unchecked(to_rapier(&normal)));
            world.insert_collider(standing(plane).position(pose), None);
        }
        let links = scene
            .links
            .iter_enumerated()
            .zip(states)
            .map(|((index, link), state)| {
                let state = (*state)?;
                let body = if link.held.is_some() {
                    let pose = to_rapier_pose(&state.world_from_body());
                    RigidBodyBuilder::kinematic_position_based().pose(pose)
                } else {
                    moving(&link.body, &state)
                };
                let solid = link.solid();
                let (shape, solid_from_shape) = solid.parts();
                let hooks = match scene.joint_tree(link.mechanism) {
                    Some(_) => ActiveHooks::FILTER_CONTACT_PAIRS,
                    None => ActiveHooks::default(),
                };
                let collider = made_of(ColliderBuilder::new(shape.clone()), scene, index)
                    .density(0.0)
                    .position(*solid_from_shape)
                    .active_hooks(hooks);
                Some(world.insert(body, collider).0)
            });
        let links: TiVec<LinkIndex, Option<RigidBodyHandle>> = links.collect();
        let radii = scene.links.iter().map(|link| link.radius_m());
        Some(Self {
            world,
            trees: Vec::new(),
            most_j: f64::INFINITY,
            tied: Tied::default(),
            links,
            steps: 0,
            bodies: scene.links.iter().map(|link| link.body).collect(),
            radii_m: radii.collect(),
            least_prediction_m,
        })
    }

    /// Joins the links of trees, which are in these states.
    fn join(&mut self, trees: &[TreeMotion], states: &TiSlice<LinkIndex, Option<State>>) {
        if trees.is_empty() {
            return;
        }
        self.world.integration_parameters.num_solver_iterations = JOINED_SOLVER_STEPS;
        let links = self.links.iter().zip(states).zip(&self.bodies);
        let moving = links.map(|((handle, state), body)| {
            Some(Moving {
                handle: (*handle)?,
                state: (*state)?,
                moment_kg_m2: body.moments_kg_m2().max(),
            })
        });
        let moving: TiVec<LinkIndex, Option<Moving>> = moving.collect();
        for tree in trees {
            let (joined, model) = (tree.joined, &tree.model);
            self.tied.tie(joined, &moving);
            let joined = Joined::new(
                &mut self.world,
                joined,
                model,
                &tree.state,
                &moving,
                ROLLING_PER_S,
            );
            self.trees.push(joined);
        }
        let [kinetic_j, height_j, fall_j] = self.energies_j();
        let springs_j: f64 = self.trees.iter().map(|tree| tree.springs_j).sum();
        let mut bodies = self.bodies.iter();
        let is_forced = bodies.any(|body| body.force_m_s2() != Vector3::zeros());
        if !is_forced
            && !self
                .world
                .bodies
                .iter()
                .any(|(_, body)| body.is_kinematic())
        {
            let gain_j = GAIN * (kinetic_j + springs_j + fall_j);
            self.most_j = kinetic_j + height_j + springs_j + gain_j;
        }
    }

    /// Kinetic and potential energy, and what all gain in falling by their radii \[J\].
    fn energies_j(&self) -> [f64; 3] {
        let gravity_m_s2 = from_rapier(self.world.gravity);
        let links = self.links.iter().zip(&self.bodies).zip(&self.radii_m);
        let energies = links.filter_map(|((handle, body), radius_m)| {
            let handle = (*handle)?;
            let link = &self.world.bodies[handle];
            let (pose, mass_kg) = (pose_of(link), body.mass_kg());
            let spin = pose
                .rotation
                .inverse_transform_vector(&from_rapier(link.angvel()));
            let speeds = mass_kg * from_rapier(link.linvel()).norm_squared()
                + spin.dot(&body.moments_kg_m2().component_mul(&spin));
            let height = -mass_kg * gravity_m_s2.dot(&pose.translation.vector);
            Some([
                0.5 * speeds,
                height,
                mass_kg * gravity_m_s2.norm() * radius_m,
            ])
        });
        energies.fold([0.0; 3], |sum, of| [0, 1, 2].map(|at| sum[at] + of[at]))
    }

    /// Whether, with joined bodies, there is more energy than there can be, or none that is a number.
    fn has_burst(&self) -> bool {
        let [kinetic_j, height_j, _] = self.energies_j();
        let is_sound = kinetic_j + height_j <= self.most_j;
        !self.trees.is_empty() && !is_sound
    }

    /// Moves held bodies to where they are after the next step.
    fn lead(&mut self, estimate: &Estimate, from_s: f64) {
        self.steps += 1;
        let time_s = from_s + self.steps as f64 * INTERVAL_S;
        for held in &estimate.held {
            if let Some(handle) = self.links[held.link] {
                let pose = to_rapier_pose(&held.state(time_s).world_from_body());
                self.world.bodies[handle].set_next_kinematic_position(pose);
            }
        }
    }

    fn step(&mut self) {
        self.push();
        let fastest_m_s = self
            .links
            .iter()
            .zip(&self.radii_m)
            .filter_map(|(handle, radius_m)| {
                let body = &self.world.bodies[(*handle)?];
                Some(body.linvel().length() + body.angvel().length() * radius_m)
            })
            .fold(0.0, f64::max);
        let way_m = (fastest_m_s + self.world.gravity.length() * INTERVAL_S) * INTERVAL_S;
        let prediction_m = (STEPS_AHEAD * way_m).max(self.least_prediction_m);
        let parameters = &mut self.world.integration_parameters;
        parameters.normalized_prediction_distance = prediction_m / parameters.length_unit;
        self.world.step_with_events(&self.tied, &());
    }

    /// Sets the forces and moments of this step, which are constant in it.
    fn push(&mut self) {
        for tree in &self.trees {
            tree.stretch(&mut self.world);
        }
        for (handle, body) in self.links.iter().zip(&self.bodies) {
            let Some(handle) = *handle else { continue };
            if self
                .world
                .multibody_joints
                .rigid_body_link(handle)
                .is_some()
            {
                resist(&mut self.world.bodies[handle], body);
            }
            if body.is_ballistic() && body.force_m_s2() == Vector3::zeros() {
                continue;
            }
            let moving = &mut self.world.bodies[handle];
            let velocity = from_rapier(moving.linvel());
            let spin = from_rapier(moving.angvel());
            let acceleration = body.acceleration_m_s2(&Vector3::zeros(), &velocity, &spin);
            moving.reset_forces(false);
            moving.add_force(to_rapier(&(acceleration * body.mass_kg())), false);
        }
    }

    /// Whether no point of any link is faster than a small share of what it gains in falling by its
    /// radius.
    fn is_slow(&self) -> bool {
        let gravity_m_s2 = self.world.gravity.length();
        let mut links = self.links.iter().zip(&self.radii_m);
        links.all(|(handle, radius_m)| {
            handle.is_none_or(|handle| {
                let body = &self.world.bodies[handle];
                let speed_m_s = body.linvel().length() + body.angvel().length() * radius_m;
                speed_m_s <= SLOW * (2.0 * gravity_m_s2 * radius_m).sqrt()
            })
        })
    }

    fn is_at_rest(&self) -> bool {
        let mut links = self.links.iter().flatten();
        links.all(|handle| {
            let body = &self.world.bodies[*handle];
            body.is_sleeping() || body.is_kinematic() && body.linvel().length() == 0.0
        })
    }
}

/// A dynamic body in a state, with the scene's mass and moments.
fn moving(body: &Body, state: &State) -> RigidBodyBuilder {
    let spin = state.orientation * state.angular_velocity_rad_s;
    RigidBodyBuilder::dynamic()
        .pose(to_rapier_pose(&state.world_from_body()))
        .linvel(to_rapier(&state.velocity_m_s))
        .angvel(to_rapier(&spin))
        .additional_mass_properties(MassProperties::new(
            RapierVector::ZERO,
            body.mass_kg(),
            to_rapier(&body.moments_kg_m2()),
        ))
        .angular_damping(ROLLING_PER_S)
}

/// Slows the rotation of a link as that of a body by itself is: rapier does not do that in
/// multibodies.
fn resist(link: &mut RigidBody, body: &Body) {
    let orientation = pose_of(link).rotation;
    let spin_rad_s = orientation.inverse_transform_vector(&from_rapier(link.angvel()));
    let momentum = orientation * body.moments_kg_m2().component_mul(&spin_rad_s);
    link.reset_torques(false);
    link.add_torque(to_rapier(&(-ROLLING_PER_S * momentum)), false);
}

#[cfg(test)]
mod tests;
