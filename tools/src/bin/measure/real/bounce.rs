//! What the first impact of a real toss says of restitution and friction, and what would have been
//! predicted of it.

use anyhow::Result;
use enact::config::scene_from_toml;
use enact::motion::{Scene, Verdict};
use enact::physics::contact::{Contact, Feature};
use enact::physics::impact::{ContactSet, Law, Side};
use enact::physics::{Body, State, flow};
use nalgebra::{UnitQuaternion, Vector3};

use crate::tosses::{RATES_HZ, Toss, scene_toml, take};
use enact_tools::case::estimated;

/// As the cameras ran \[Hz\].
const RATE_HZ: f64 = RATES_HZ[0];
/// Half the side as these cameras see it: it rests at that height \[m\].
const HALF_M: f64 = 0.05125;
/// Gravity as they see it; every session is turned about z at random, so that no tilt is common
/// to all tosses [m/s²].
const GRAVITY_M_S2: f64 = 9.648;
/// White noise per axis, as documented \[mm\], \[°\].
const NOISE: (f64, f64) = (0.02, 0.025);
/// A corner nearer to the table than this may touch it \[m\].
const NEAR_M: f64 = 0.002;
/// Samples between the first impact and the next contact that an estimate needs.
const LEAST_AFTER: usize = 4;
/// A prediction goes on for so long after the impact \[s\], in steps of \[s\].
pub const AHEAD_S: f64 = 0.05;
const STEP_S: f64 = 2e-5;
/// Impacts of a prediction beyond which the cube chatters.
const IMPACTS_MAX: usize = 200;

/// The cube and its table, as these cameras see them.
pub struct Setting {
    /// All flights until the first impact.
    before: Scene,
    /// With the impact, restitution and friction free.
    with_impact: Scene,
    body: Body,
    /// Middles of the balls that the corners are, and their radius \[m\].
    corners_m: Vec<Vector3<f64>>,
    pub radius_m: f64,
}

/// The first impact of a toss as estimated.
pub struct Bounce {
    /// Value and standard deviation.
    pub restitution: (f64, Option<f64>),
    /// Value and standard deviation.
    pub friction: (f64, Option<f64>),
    /// Residuals after the impact, rms \[mm\], \[°\].
    pub residual: (f64, f64),
}

/// Errors of a prediction at a sample.
#[derive(Clone, Copy)]
pub struct Miss {
    /// Since the impact as predicted \[s\].
    pub after_s: f64,
    /// Of the centre \[mm\], of the orientation \[°\].
    pub position_mm: f64,
    pub orientation_deg: f64,
}

impl Setting {
    /// With that moment of inertia [kg m²] and corners rounded by that radius \[m\].
    pub fn new(moment_kg_m2: f64, radius_m: f64) -> Result<Self> {
        let text = scene_toml()?;
        let side_mm = 2e3 * HALF_M;
        let text = text
            .replace("104.8", &format!("{side_mm}"))
            .replace("52.4", &format!("{}", 0.5 * side_mm))
            .replace("8.1e-4", &format!("{moment_kg_m2:e}"));
        let (head, _) = text.split_once("[[event]]").unwrap_or((&text, ""));
        let (position_mm, orientation_deg) = NOISE;
        let head = format!(
            "gravity_m_s2 = [0, 0, {:?}]\n{head}\n[weights]\nposition_mm = {position_mm:?}\n\
             orientation_deg = {orientation_deg:?}\n",
            -GRAVITY_M_S2
        );
        let end = |name: &str| format!("[[event]]\nname = \"{name}\"\nkind = \"end\"\n");
        let impact = "[[event]]\nname = \"impact\"\nkind = \"collision\"\nbody = \"cube\"\n\
                      surface = \"table\"\nrestitution = 0.3\nfriction = 0.15\n";
        let free = "[[free]]\nquantity = \"impact.restitution\"\n\
                    [[free]]\nquantity = \"impact.friction\"\nlower = 0\nupper = 2\n";
        let with_impact = format!("{head}{impact}{}{free}", end("end"));
        let mut with_impact = scene_from_toml(&with_impact)?;
        let before = scene_from_toml(&format!("{head}{}", end("impact")))?;
        let mut corners_m = Vec::new();
        for feature in &mut with_impact.bodies[0].features {
            if let Feature::Point {
                point_m,
                radius_m: r,
            } = &mut feature.geometry
            {
                *point_m *= 1.0 - radius_m / HALF_M;
                *r = radius_m;
                corners_m.push(*point_m);
            }
        }
        Ok(Self {
            body: before.bodies[0].body,
            corners_m,
            radius_m,
            with_impact,
            before,
        })
    }

    /// Moment of inertia [kg m²].
    pub fn moment_kg_m2(&self) -> f64 {
        self.body.moments_kg_m2().x
    }

    /// Heights of the corners over the table \[m\].
    fn heights_m(&self, position_m: &Vector3<f64>, orientation: &UnitQuaternion<f64>) -> Vec<f64> {
        let corners = self.corners_m.iter();
        corners
            .map(|corner| (position_m + orientation * corner).z - self.radius_m)
            .collect()
    }

    /// The samples until something touches again after the first impact.
    fn until_next_contact(&self, toss: &Toss) -> usize {
        let heights_m = |index: usize| {
            let (position_m, orientation) = &toss.poses[index];
            self.heights_m(position_m, orientation)
        };
        let first = heights_m(toss.flight.min(toss.poses.len() - 1));
        let hit = (0..first.len()).min_by(|a, b| first[*a].total_cmp(&first[*b]));
        let mut last_m = f64::NEG_INFINITY;
        for index in toss.flight + 1..toss.poses.len() {
            let heights_m = heights_m(index);
            let touches = heights_m.iter().enumerate().any(|(corner, height_m)| {
                let comes_back = Some(corner) != hit || *height_m < last_m;
                *height_m < NEAR_M && comes_back
            });
            if touches {
                return index;
            }
            last_m = hit.map_or(last_m, |hit| heights_m[hit]);
        }
        toss.poses.len()
    }

    /// Restitution and friction of the first impact.
    pub fn bounce(&self, toss: &Toss) -> Result<Bounce, String> {
        let end = self.until_next_contact(toss);
        let after = end - toss.flight;
        if after < LEAST_AFTER {
            return Err(format!("{after} samples before the next contact"));
        }
        let marks = [
            (toss.flight as f64 - 0.5, "impact"),
            (end as f64 - 1.0, "end"),
        ];
        let events = take(toss, RATE_HZ, end, &marks);
        let outcome = estimated(&self.with_impact, &events, &mut ()).map_err(|e| e.to_string())?;
        let estimate = &outcome.estimate;
        if estimate.verdict != Verdict::Physical {
            return Err(format!(
                "{}: {}",
                estimate.verdict.as_str(),
                enact::report::reason_text(&outcome.scene, &estimate.reason)
            ));
        }
        let parameter = |name: &str| {
            let mut all = estimate.parameters.iter();
            let found = all.find(|parameter| parameter.name == name);
            found.map_or((f64::NAN, None), |parameter| {
                (parameter.value, parameter.sd)
            })
        };
        let last = estimate.residuals.last();
        Ok(Bounce {
            restitution: parameter("impact.restitution"),
            friction: parameter("impact.friction"),
            residual: last.map_or((f64::NAN, f64::NAN), |residual| {
                let degrees = residual.orientation_rms_rad.to_degrees();
                (1e3 * residual.position_rms_m, degrees)
            }),
        })
    }

    /// The state of the first flight, and its time.
    fn flown(&self, toss: &Toss) -> Result<(State, f64), String> {
        let marks = [(toss.flight as f64 - 1.0, "impact")];
        let events = take(toss, RATE_HZ, toss.flight, &marks);
        let outcome = estimated(&self.before, &events, &mut ()).map_err(|e| e.to_string())?;
        let arc = &outcome.estimate.arcs[0];
        Ok((arc.state, arc.epoch_s))
    }

    /// What the first flight and a law predict of the time after the first impact; without a law the
    /// cube flies on through the table.
    pub fn misses(&self, toss: &Toss, law: Option<(f64, f64)>) -> Result<Vec<Miss>, String> {
        let (mut state, mut epoch_s) = self.flown(toss)?;
        let mut now_s = (toss.flight as f64 - 1.0) / RATE_HZ;
        let mut impact_s = None;
        let mut impacts = 0;
        let mut misses = Vec::new();
        let mut next = toss.flight;
        while impact_s.is_none_or(|impact_s| now_s < impact_s + AHEAD_S) {
            now_s += STEP_S;
            if impact_s.is_none() && now_s > (toss.flight as f64 + 2.0) / RATE_HZ {
                return Err("no impact is predicted within two samples".to_owned());
            }
            let mut at = self.advanced(&state, now_s - epoch_s);
            if let Some(corner) = self.arriving(&at) {
                impact_s = impact_s.or(Some(now_s));
                impacts += 1;
                if let Some((restitution, friction)) = law
                    && impacts <= IMPACTS_MAX
                {
                    at = self.struck(&at, corner, restitution, friction)?;
                    (state, epoch_s) = (at, now_s);
                }
            }
            let Some((position_m, orientation)) = toss.poses.get(next) else {
                break;
            };
            if now_s >= next as f64 / RATE_HZ {
                next += 1;
                if let Some(impact_s) = impact_s {
                    misses.push(Miss {
                        after_s: now_s - impact_s,
                        position_mm: 1e3 * (at.position_m - position_m).norm(),
                        orientation_deg: at.orientation.angle_to(orientation).to_degrees(),
                    });
                }
            }
        }
        Ok(misses)
    }

    fn advanced(&self, state: &State, duration_s: f64) -> State {
        flow::advance(&self.body, &self.before.gravity_m_s2, state, duration_s)
    }

    /// The lowest corner that is in the table and goes on into it.
    fn arriving(&self, state: &State) -> Option<Vector3<f64>> {
        let down_m = state.orientation.inverse_transform_vector(&Vector3::z()) * self.radius_m;
        let height_m = |corner: &Vector3<f64>| {
            (state.position_m + state.orientation * corner).z - self.radius_m
        };
        let sinks = |corner: &&Vector3<f64>| {
            let spin = state.angular_velocity_rad_s.cross(&(*corner - down_m));
            height_m(corner) <= 0.0 && (state.velocity_m_s + state.orientation * spin).z < 0.0
        };
        let sinking = self.corners_m.iter().filter(sinks);
        let lowest = sinking.min_by(|a, b| height_m(a).total_cmp(&height_m(b)));
        lowest.copied()
    }

    fn struck(
        &self,
        state: &State,
        corner_m: Vector3<f64>,
        restitution: f64,
        friction: f64,
    ) -> Result<State, String> {
        let table = Feature::face(Vector3::zeros(), Vector3::z());
        let corner = Feature::Point {
            point_m: corner_m,
            radius_m: self.radius_m,
        };
        let contact = Contact::new(corner, table).map_err(|e| e.to_string())?;
        let meeting = ContactSet::with_friction(&[contact]).map_err(|e| e.to_string())?;
        let law = Law {
            restitution,
            friction,
            tilt_rad: [0.0; 2],
        };
        let side = Side {
            body: &self.body,
            state,
        };
        let impact = meeting
            .impact(&side, None, &law)
            .map_err(|e| e.to_string())?;
        Ok(State {
            velocity_m_s: impact.after[0].velocity_m_s,
            angular_velocity_rad_s: impact.after[0].angular_velocity_rad_s,
            ..*state
        })
    }
}
