//! How far a prediction may be off: it is repeated from states and with materials drawn from what is known of them.
//!
//! States are drawn from their covariance at the end of what was seen, materials from the standard deviations that the scene
//! states; a body without a material has one that is hardly known. The same scene and take give the same draws. What
//! the simulation itself has wrong is not in it, unless the deviations of the materials cover that (`docs/predict.md`).

use nalgebra::{DVector, Vector3};
use typed_index_collections::TiVec;

use crate::estimate::LastState;
use crate::math::Pose;
use crate::math::random::Random;
use crate::motion::{ContactLaw, Estimate, LinkIndex, LinkSpread, Observer, Scene, Spread};
use crate::settle::{FRICTION, FRICTION_SD, RESTITUTION, RESTITUTION_SD, settle};
use crate::verify::up_name;

/// Number of motions that are simulated.
const DRAWS: usize = 32;
/// Least friction of a draw: nothing slides for ever.
const FRICTION_MIN: f64 = 0.01;

/// Where drawn motions come to rest; `None` where none could be simulated. `known` are the last states of all mechanisms.
pub(super) fn spread(
    scene: &Scene,
    estimate: &Estimate,
    known: &[LastState],
    limit_s: f64,
    observer: &mut dyn Observer,
) -> Option<Spread> {
    let mut random = Random::default();
    let mut drawn_scene = scene.clone();
    let mut drawn = estimate.clone();
    let laws = laws(scene);
    let mut ends: TiVec<LinkIndex, Vec<Pose>> = scene.links.iter().map(|_| Vec::new()).collect();
    let (mut draws, mut at_rest) = (0, 0);
    for _ in 0..DRAWS {
        if observer.should_stop() {
            break;
        }
        drawn_scene.contact_laws = laws.iter().map(|law| other(law, &mut random)).collect();
        for state in known {
            let numbers = DVector::from_fn(LastState::NUMBERS, |_, _| random.normal());
            let mut arcs = drawn.arcs.iter_mut().rev();
            if let Some(last) = arcs.find(|arc| arc.mechanism == state.mechanism) {
                last.state = state.draw(&numbers);
            }
        }
        let Some(settled) = settle(&drawn_scene, &drawn, limit_s) else {
            continue;
        };
        draws += 1;
        at_rest += usize::from(settled.at_rest);
        for (ends, link) in ends.iter_mut().zip(&settled.links) {
            ends.extend(link.poses.last());
        }
    }
    let up = -estimate
        .gravity_m_s2
        .try_normalize(0.0)
        .unwrap_or(-Vector3::z());
    let links = ends.iter_enumerated().filter_map(|(index, ends)| {
        let link = &scene.links[index];
        let named = ends.iter().map(|end| up_name(link, &end.rotation, &up));
        let named: Vec<String> = named.collect();
        LinkSpread::new(index, ends, &named).filter(|_| link.held.is_none())
    });
    let links: Vec<LinkSpread> = links.collect();
    let is_of_link = |law: &&ContactLaw| scene.links.iter().any(|link| link.name == law.name);
    let exact = laws.iter().filter(|law| law.is_exact()).filter(is_of_link);
    (!links.is_empty()).then_some(Spread {
        draws,
        at_rest,
        exact: exact.map(|law| law.name.clone()).collect(),
        links,
    })
}

/// What bodies are made of, those of which the scene does not say it too.
fn laws(scene: &Scene) -> Vec<ContactLaw> {
    let mut laws: Vec<ContactLaw> = scene.contact_laws.iter().cloned().collect();
    for link in &scene.links {
        if laws.iter().all(|law| law.name != link.name) {
            laws.push(ContactLaw {
                friction: FRICTION,
                restitution_sd: RESTITUTION_SD,
                friction_sd: FRICTION_SD,
                ..ContactLaw::frictionless(link.name.clone(), RESTITUTION)
            });
        }
    }
    laws
}

/// A law as it may be as well.
fn other(law: &ContactLaw, random: &mut Random) -> ContactLaw {
    let [restitution, friction] = [random.normal(), random.normal()];
    let restitution = law.restitution + law.restitution_sd * restitution;
    let friction = match law.friction_sd > 0.0 {
        true => (law.friction + law.friction_sd * friction).max(FRICTION_MIN),
        false => law.friction,
    };
    ContactLaw {
        restitution: restitution.clamp(0.0, law.most_restitution()),
        friction,
        ..law.clone()
    }
}
