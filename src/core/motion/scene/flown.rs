//! Where a body by itself is.

use nalgebra::Vector3;

use super::whole::Scene;
use crate::motion::estimate::ArcEstimate;
use crate::physics::{Body, State, flow};

impl Scene {
    /// The equations of motion on an arc.
    pub fn body_on(&self, arc: &ArcEstimate) -> Body {
        self.body_of(arc.mechanism).with_support(arc.support)
    }

    /// The state of what flies on an arc at a physical time \[s\], within the arc or beyond it, in that gravity [m/s², world].
    ///
    /// # Panics
    /// Of a tree, which has no arcs.
    pub fn flown(&self, arc: &ArcEstimate, gravity_m_s2: &Vector3<f64>, time_s: f64) -> State {
        let body = self.body_on(arc);
        flow::advance(&body, gravity_m_s2, &arc.state, time_s - arc.epoch_s)
    }
}
