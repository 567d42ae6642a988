//! The beginning of a scene: the part up to the last marked event.

use super::scene::{Scene, Timing};

impl Scene {
    /// The scene with only its first `count` events: goals and parameters of later ones are
    /// dropped, and parameters that only later events would tell. Write out a repeated collision first ([`Scene::with_marks`]).
    pub fn first_events(&self, count: usize) -> Scene {
        let mut scene = self.clone();
        scene.events.truncate(count);
        scene.phases.retain(|phase| phase.events[1] < count);
        scene
            .goals
            .retain(|goal| goal.events().all(|event| event < count));
        let cut = scene.clone();
        scene.keep_parameters(|quantity| {
            let is_there = quantity.event().is_none_or(|event| event < count);
            is_there && cut.untold(quantity).is_none()
        });
        // Of what only later events would tell apart the last stays as the scene has it.
        while let Some(last) = scene
            .told_together()
            .and_then(|of| of.parameters.last().copied())
        {
            let last = scene.parameters[last].quantity;
            scene.keep_parameters(|quantity| quantity != last);
        }
        scene
    }

    /// Number of events marked by marks with these names: as many as there are marks, and at least
    /// up to the last named one. For an edited sketch all, since it has no marks.
    pub fn events_marked<'a>(&self, names: impl Iterator<Item = Option<&'a str>>) -> usize {
        if self.timing == Timing::Edited {
            return self.events.len();
        }
        let (mut count, mut last) = (0, 0);
        for name in names {
            count += 1;
            let named = name.and_then(|name| self.events.iter().position(|e| e.name == name));
            last = last.max(named.map_or(0, |event| event + 1));
        }
        last.max(count).min(self.events.len())
    }
}

#[cfg(test)]
mod tests {
    use crate::config::scene_from_toml;
    use crate::motion::Cone;

    #[test]
    fn later_events_take_their_goals_and_parameters_with_them() {
        let toml = include_str!("../../../config/hat_box.toml");
        let scene = scene_from_toml(toml).expect("valid");
        let whole = scene.first_events(scene.events.len());
        assert_eq!(whole, scene);
        for count in 0..scene.events.len() {
            let part = scene.first_events(count);
            assert_eq!(part.events[..], scene.events[..count]);
            assert!(part.goals.iter().all(|goal| goal.event < count));
            let of_event = |event: usize| {
                let parameters = part.parameters.iter();
                parameters
                    .filter(|p| p.quantity.event() == Some(event))
                    .count()
            };
            assert!((count..scene.events.len()).all(|event| of_event(event) == 0));
            // A cone still holds the same two.
            for cone in &part.cones {
                let names = cone.parameters.map(|p| part.parameters[p].name.clone());
                let is_it = |other: &Cone| {
                    other.parameters.map(|p| scene.parameters[p].name.clone()) == names
                };
                assert!(scene.cones.iter().any(is_it), "{names:?}");
            }
        }
        assert!(!scene.cones.is_empty() && scene.first_events(0).parameters.is_empty());
    }

    #[test]
    fn marks_stand_for_events_in_order_or_by_name() {
        let toml = include_str!("../../../config/pencil_tip.toml");
        let scene = scene_from_toml(toml).expect("valid");
        let marked = |names: &[Option<&str>]| scene.events_marked(names.iter().copied());
        assert_eq!(marked(&[]), 0);
        assert_eq!(marked(&[None]), 1);
        assert_eq!(marked(&[Some("bounce")]), 1);
        assert_eq!(marked(&[Some("landing")]), 2);
        assert_eq!(marked(&[None, Some("landing"), None]), 2);
    }
}
