//! Motions with one bounce, built from the instant of the impact.

use enact::math::so3;
use enact::motion::{
    ArcEstimate, EventKind, Goal, GoalTarget, LinkIndex, MechanismIndex, Scene, Surface,
};
use enact::physics::{Body, State, contact};
use nalgebra::{UnitQuaternion, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::perform::encounter::{Encounter, still};
use crate::perform::truth::Flight;
use crate::perform::{Style, Truth, simulate};

/// The random numbers of a seed, apart from those of the performance.
pub fn rng(seed: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(1000);
    rng
}

/// Three normal numbers.
pub fn normal3(rng: &mut impl Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| StandardNormal.sample(rng))
}

/// A direction, any.
pub fn direction(rng: &mut impl Rng) -> Vector3<f64> {
    normal3(rng).normalize()
}

/// The motion of the scene's one body through that state at its one bounce; its pose at the end
/// becomes the only goal. An error where a simulation says that the contact is earlier.
pub fn hit(scene: &Scene, at: &State, before_s: f64, after_s: f64) -> Result<Truth, String> {
    let mut scene = scene.clone();
    let meet = Encounter::of(&scene, &[], 0).ok_or("no bounce of a corner")?;
    let flight = Flight::of(&scene, LinkIndex(0));
    let initial = flight.advance(at, -before_s);
    let (after, _) = meet.after(at, &still());
    let end = flight.advance(&after, after_s);
    let duration_s = before_s + after_s;
    let end_event = scene.events.iter().position(|e| e.kind == EventKind::End);
    scene.goals = vec![Goal {
        event: end_event.ok_or("no end")?,
        link: LinkIndex(0),
        target: GoalTarget::Pose {
            world_from_body: end.world_from_body(),
        },
    }];
    let arc = |state: State, start_s: f64, end_s: f64| ArcEstimate {
        mechanism: MechanismIndex(0),
        epoch_s: start_s,
        state,
        start_s,
        end_s,
        support: None,
        certainty: None,
    };
    let simulated =
        simulate(&scene, &[], &[initial], duration_s).map_err(|error| error.to_string())?;
    if (simulated.event_times_s[0] - before_s).abs() > 1e-6 {
        return Err("the contact point goes through the surface earlier".into());
    }
    Ok(Truth {
        scene,
        is_physical: true,
        parameters: Vec::new(),
        arcs: vec![
            arc(initial, 0.0, before_s),
            arc(after, before_s, duration_s),
        ],
        event_times_s: vec![before_s, duration_s],
        duration_s,
    })
}

/// The state in which the pencil of a style hits the table.
pub fn at_impact(truth: &Truth) -> State {
    let arc = &truth.arcs[0];
    Flight::of(&truth.scene, LinkIndex(0)).advance(&arc.state, truth.event_times_s[0] - arc.epoch_s)
}

/// Moments of a pencil, in parts of that about its middle.
pub const PENCIL: [f64; 3] = [1.0, 1.0, 2.3e-3];

/// A pencil thrown up along a wall, its tip towards the wall, which it meets at that speed along
/// the wall's normal; of these moments, in parts of the pencil's own.
pub fn wall(
    approach_m_s: f64,
    restitution: f64,
    moments: [f64; 3],
    seed: u64,
) -> Result<Truth, String> {
    let mut scene = Style::Tip.truth().scene;
    let body = &mut scene.links[LinkIndex(0)].body;
    let moments_kg_m2 = Vector3::from(moments) * body.moments_kg_m2().x;
    *body = Body::new(body.mass_kg(), moments_kg_m2).map_err(|error| error.to_string())?;
    scene.obstacles.clear();
    scene.surfaces = vec![Surface {
        name: "wall".to_owned(),
        geometry: contact::Feature::face(Vector3::zeros(), Vector3::x()),
        obstacle: None,
    }];
    for law in &mut scene.contact_laws {
        law.restitution = restitution;
    }
    let mut rng = rng(seed);
    // The tip is at the lower end of the body's third axis, which leads away from the wall.
    let toward = UnitQuaternion::rotation_between(&Vector3::z(), &Vector3::x());
    let toward = toward.ok_or("opposite axes")?;
    let orientation = so3::exp(&(normal3(&mut rng) * 0.2)) * toward;
    let tip_m = Vector3::new(0.0, 0.0, -0.095);
    let mut state = State {
        position_m: Vector3::new(0.0, 0.1, 1.0) - orientation * tip_m,
        orientation,
        velocity_m_s: Vector3::new(0.0, 0.2, 1.0),
        angular_velocity_rad_s: normal3(&mut rng).component_mul(&Vector3::new(1.0, 1.0, 6.0)),
    };
    let meet = Encounter::of(&scene, &[], 0).ok_or("no bounce of a corner")?;
    state.velocity_m_s.x = -approach_m_s - meet.speed_m_s(&state, &still());
    hit(&scene, &state, 0.35, 0.4)
}
