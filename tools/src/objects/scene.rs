//! Scenes of a toss: its first flight alone, and through its first impact.

use anyhow::Result;
use enact::config::scene_from_toml;
use enact::motion::Scene;

use super::cut::steps;
use super::solid::Solid;
use crate::tosses::{FREE_LAW_TOML, Pose, end_toml};

/// Name of the event at which the first flight ends.
pub const IMPACT: &str = "impact";
/// Name of the last event.
pub const END: &str = "end";
/// No motion here depends on it: what is hit does not move \[kg\].
const MASS_KG: f64 = 0.3;
/// Steps at the end of a toss that show whether it rests, and the greatest of them at rest \[rad\].
const REST_STEPS: usize = 3;
const REST_RAD: f64 = 2.0 / 180.0 * std::f64::consts::PI;

/// How much samples and the height of the table are trusted: standard deviations.
#[derive(Clone, Copy, Debug)]
pub struct Trust {
    /// Of a sample's position, per axis \[mm\].
    pub position_mm: f64,
    /// Of its orientation \[°\].
    pub orientation_deg: f64,
    /// Of the table's height \[mm\].
    pub table_mm: f64,
}

fn head(solid: &Solid, trust: &Trust) -> String {
    let body_from_tracked = solid.tracked_from_body.inverse();
    let [x, y, z] = (body_from_tracked.translation.vector * 1e3).into();
    let q = body_from_tracked.rotation.coords;
    format!(
        "name = \"toss\"\nhand = \"none\"\n[timing]\nstamps = \"physical\"\n\
         [weights]\nposition_mm = {:?}\norientation_deg = {:?}\n\
         [[body]]\nname = \"thing\"\nshape = {}\nmass_kg = {MASS_KG:?}\n\
         tracker = {{ position_mm = [{x:?}, {y:?}, {z:?}], orientation_wxyz = [{:?}, {:?}, {:?}, {:?}] }}\n{}",
        trust.position_mm,
        trust.orientation_deg,
        solid.shape_toml,
        q.w,
        q.x,
        q.y,
        q.z,
        solid.features_toml
    )
}

/// The first flight alone: nothing touches.
pub fn flight(solid: &Solid, trust: &Trust, is_gravity_free: bool) -> Result<Scene> {
    let mut text = head(solid, trust) + &end_toml(IMPACT);
    if is_gravity_free {
        for axis in ["x", "y", "z"] {
            text += &format!("[[free]]\nquantity = \"gravity.{axis}\"\n");
        }
    }
    Ok(scene_from_toml(&text)?)
}

/// Through the first impact, whatever feature touches, with a law that is estimated, and the height of
/// the table with it.
pub fn impact(solid: &Solid, trust: &Trust, table_m: f64) -> Result<Scene> {
    let text = format!(
        "{}[[surface]]\nname = \"table\"\npoint_mm = [0, 0, {:?}]\nnormal = [0, 0, 1]\n\
         [[event]]\nname = \"{IMPACT}\"\nkind = \"collision\"\nbody = \"thing\"\nsurface = \"table\"\n\
         restitution = 0.3\nfriction = 0.3\n{}\
         {FREE_LAW_TOML}[[free]]\nquantity = \"table.height\"\nprior_sd = {:?}\n",
        head(solid, trust),
        table_m * 1e3,
        end_toml(END),
        trust.table_mm
    );
    Ok(scene_from_toml(&text)?)
}

/// Height of the lowest point of an object that rests at its end, over its last samples \[m\];
/// `None` where it still turns.
pub fn rest_height_m(solid: &Solid, poses: &[Pose]) -> Option<f64> {
    let last = &poses[poses.len().saturating_sub(REST_STEPS + 1)..];
    if !steps(last).iter().all(|step| step.norm() < REST_RAD) {
        return None;
    }
    let mut heights_m: Vec<f64> = last
        .iter()
        .map(|pose| solid.lowest_m(&solid.world_from_body(pose)))
        .collect();
    heights_m.sort_by(f64::total_cmp);
    Some(heights_m[heights_m.len() / 2])
}

/// Height of the lowest point at the first contact, half-way between two samples \[m\].
pub fn contact_height_m(solid: &Solid, poses: &[Pose], last_before: usize) -> f64 {
    let lowest_m = |index: usize| solid.lowest_m(&solid.world_from_body(&poses[index]));
    0.5 * (lowest_m(last_before) + lowest_m(last_before + 1))
}
