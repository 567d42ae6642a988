//! Joined bodies that go into something, led out of it as bodies by themselves are.

use super::tried::{Tried, TriedField};
use crate::estimate::tree::{Detail, Solved};
use crate::motion::{Doubt, Estimate, Fits, Observer, Penetration, Scene, Touch};
use crate::pipeline::keep_out::{Leadable, goes_into_something, kept_out, only_overlaps};

/// A motion on its way out.
struct LeadableTrees<'f> {
    field: &'f TriedField<'f>,
    scene: Scene,
    solved: Solved,
    estimate: Estimate,
    /// What touches what at its events.
    touches: Vec<Touch>,
}

impl Leadable for LeadableTrees<'_> {
    fn scene(&self) -> &Scene {
        &self.scene
    }

    fn estimate(&self) -> &Estimate {
        &self.estimate
    }

    /// Of what hits at an event the time of that may be wrong, and not the way: such a motion is not led out.
    fn keep_apart(&mut self, found: &[Penetration], observer: &mut dyn Observer) -> bool {
        let is_hit = |of: &Penetration| {
            let mut touches = self.touches.iter();
            touches.any(|touch| touch.link == of.link && touch.against == of.against)
        };
        if found.iter().any(is_hit) {
            return false;
        }
        let scene = self.scene.as_estimated(&self.estimate);
        let solved = &mut self.solved;
        let is_apart = solved.keep_apart(&scene, &self.estimate, found, observer);
        if is_apart {
            let detail = Detail::Motion;
            self.estimate = self.field.estimate(&self.scene, solved, detail, observer);
        }
        is_apart
    }

    fn just_passed(&self) -> Vec<Doubt> {
        self.solved.just_passed(self.scene.tolerance_m)
    }

    fn errs_in_time(&self) -> bool {
        self.solved.errs_in_time()
    }
}

impl TriedField<'_> {
    /// The motion out of what it goes into, if nothing else speaks against it, and such a motion is as near to the performance.
    pub(super) fn kept_out(&self, tried: Tried, observer: &mut dyn Observer) -> Tried {
        if !only_overlaps(&tried.estimate) {
            return tried;
        }
        let start = LeadableTrees {
            field: self,
            scene: tried.scene.clone(),
            solved: tried.solved.clone(),
            estimate: tried.estimate.clone(),
            touches: tried
                .verification
                .as_ref()
                .map_or_else(Vec::new, |of| of.touches.clone()),
        };
        let Some(led) = kept_out(start, observer) else {
            return tried;
        };
        let mut out = self.refined(led.scene, led.solved, observer);
        let is_well = out.estimate.fits() != Fits::No;
        if !is_well || goes_into_something(out.verification.as_ref()) {
            return tried;
        }
        // Of a motion whose contacts were inferred all that was tried counts.
        let [before, after] = [&tried, &out].map(|of| of.solved.solution.work);
        let mut counters = tried.estimate.counters;
        counters.iterations += after.iterations - before.iterations;
        counters.evaluations += after.evaluations - before.evaluations;
        counters.factorisations += after.factorisations - before.factorisations;
        out.estimate.counters = counters;
        if !tried.estimate.contact_rivals.is_empty() {
            out.estimate.is_rivalled_by(tried.estimate.contact_rivals);
        }
        out
    }
}
