//! The part of a scene before an event.

use super::event::{Event, EventKind};
use super::parameter::Cone;
use super::quantity::Quantity;
use super::whole::Scene;

impl Scene {
    /// The scene of a motion that ends at one of its events, which is then its end: what comes after is
    /// not in it, nor goals and free quantities of that, nor goals at rest.
    ///
    /// # Panics
    /// Where there is no such event.
    pub fn until(&self, event: usize) -> Self {
        let mut scene = self.clone();
        let name = scene.events[event].name.clone();
        scene.events.truncate(event);
        scene.events.push(Event::new(name, EventKind::End));
        scene
            .goals
            .retain(|goal| goal.events().all(|of| of < event));
        scene.rest_goals.clear();
        // Laws that no collision has any more are still what bodies are made of, but nothing tells them.
        let has = |law| {
            let collisions = scene.events.iter().filter_map(|of| of.kind.collision());
            collisions.into_iter().any(|collision| collision.law == law)
        };
        let is_told = |quantity: Quantity| match quantity {
            Quantity::Restitution { law } | Quantity::Friction { law } => has(law),
            _ => quantity.event().is_none_or(|of| of < event),
        };
        let kept: Vec<usize> = (0..self.parameters.len())
            .filter(|at| is_told(self.parameters[*at].quantity))
            .collect();
        let place = |at: usize| kept.iter().position(|of| *of == at);
        let cones = self.cones.iter().filter_map(|cone| {
            let [a, b] = cone.parameters;
            Some(Cone {
                parameters: [place(a)?, place(b)?],
                limit: cone.limit,
            })
        });
        scene.cones = cones.collect();
        scene.parameters = kept.iter().map(|at| self.parameters[*at].clone()).collect();
        scene
    }
}
