//! The part of a scene before an event, or with some of its free quantities.

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
        scene.phases.retain(|phase| phase.events[0] < event);
        for phase in &mut scene.phases {
            phase.events[1] = phase.events[1].min(event);
        }
        // Laws that no collision has any more are still what bodies are made of, but nothing tells them.
        let has = |law| {
            let collisions = scene.events.iter().filter_map(|of| of.kind.collision());
            let mut phases = scene.phases.iter();
            collisions.into_iter().any(|collision| collision.law == law)
                || phases.any(|phase| phase.on_surface().is_some_and(|on| on.law == law))
        };
        let is_told = |quantity: Quantity| match quantity {
            Quantity::Restitution { law }
            | Quantity::Friction { law }
            | Quantity::TangentialRestitution { law } => has(law),
            _ => quantity.event().is_none_or(|of| of < event),
        };
        let told = self.parameters.iter().filter(|of| is_told(of.quantity));
        let told: Vec<Quantity> = told.map(|of| of.quantity).collect();
        scene.keep_parameters(|quantity| told.contains(&quantity));
        scene
    }

    /// Leaves of the free quantities these, and the cones of which both are left.
    pub(in crate::motion) fn keep_parameters(&mut self, is_kept: impl Fn(Quantity) -> bool) {
        let all = self.parameters.iter().enumerate();
        let kept = all.filter(|(_, free)| is_kept(free.quantity));
        let kept: Vec<usize> = kept.map(|(index, _)| index).collect();
        let place = |index: usize| kept.iter().position(|kept| *kept == index);
        let cone = |cone: &Cone| {
            let [a, b] = cone.parameters.map(place);
            Some(Cone {
                parameters: [a?, b?],
                limit: cone.limit,
            })
        };
        self.cones = self.cones.iter().filter_map(cone).collect();
        self.parameters = kept.iter().map(|i| self.parameters[*i].clone()).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::scene_from_toml;

    #[test]
    fn what_comes_after_is_not_in_it() {
        let bounce = |name: &str| {
            format!(
                "[[event]]\nname = \"{name}\"\nkind = \"collision\"\nbody = \"ball\"\nsurface = \"table\"\nrestitution = 0.5\n\
                 [[free]]\nquantity = \"{name}.restitution\"\n\
                 [[free]]\nquantity = \"{name}.tilt\"\ncone_deg = 5\n"
            )
        };
        let text = format!(
            "name = \"x\"\nsettle_s = 2\n[timing]\nstamps = \"physical\"\n\
             [[body]]\nname = \"ball\"\nshape = {{ kind = \"sphere\", radius_mm = 20 }}\nmass_g = 5\n\
             [[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n{}{}\
             [[event]]\nname = \"end\"\nkind = \"end\"\n\
             [[goal]]\nevent = \"end\"\nbody = \"ball\"\nposition_mm = [1, 2, 3]\n",
            bounce("one"),
            bounce("two")
        );
        let scene = scene_from_toml(&text).unwrap();
        let until = scene.until(1);
        let names: Vec<&str> = until
            .events
            .iter()
            .map(|event| event.name.as_str())
            .collect();
        assert_eq!(names, ["one", "two"]);
        assert_eq!(until.events[1].kind, EventKind::End);
        let free: Vec<&str> = until.parameters.iter().map(|of| of.name.as_str()).collect();
        assert_eq!(free, ["one.restitution", "one.tilt.0", "one.tilt.1"]);
        assert_eq!(until.cones.len(), 1);
        assert_eq!(until.cones[0].parameters, [1, 2]);
        assert!(until.goals.is_empty());
        let first = scene.until(0);
        assert!(first.parameters.is_empty() && first.cones.is_empty());
    }
}
