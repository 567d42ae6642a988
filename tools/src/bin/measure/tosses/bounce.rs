//! What the first impact of a real toss says of restitution and friction, and what would have been
//! predicted of it.

use anyhow::Result;
use enact::config::scene_from_toml;
use enact::motion::{LinkIndex, Scene, SegmentResidual, TakeEvent, Verdict};
use enact::physics::contact::{Contact, Feature};
use enact::physics::impact::{ContactSet, Law, Side};
use enact::physics::{Body, State, flow};
use nalgebra::{UnitQuaternion, Vector3};

use super::contacts::{Touched, contacts, first_impacts, orders};
use enact_tools::case::estimated;
use enact_tools::tosses::{RATES_HZ, Toss, end_toml, scene_toml};

/// As the cameras ran \[Hz\].
const RATE_HZ: f64 = RATES_HZ[0];
/// Half the side as these cameras see it: it rests at that height \[m\].
const HALF_M: f64 = 0.05125;
/// Gravity as they see it; every session is turned about z at random, so that no tilt is common
/// to all tosses [m/s²].
const GRAVITY_M_S2: f64 = 9.648;
/// White noise per axis, as documented \[mm\], \[°\].
const NOISE: (f64, f64) = (0.02, 0.025);
/// A prediction goes on for so long after the impact \[s\], in steps of \[s\].
pub const AHEAD_S: f64 = 0.05;
const STEP_S: f64 = 2e-5;
/// Impacts of a prediction beyond which the cube chatters.
const IMPACTS_MAX: usize = 200;

/// The law of all impacts of the cube.
const LAW_TOML: &str = "restitution = 0.3\nfriction = 0.15\n";
const FREE_LAW_TOML: &str = "[[free]]\nquantity = \"cube.restitution\"\n\
                             [[free]]\nquantity = \"cube.friction\"\nlower = 0\nupper = 2\n";

/// A sample.
type Pose = (Vector3<f64>, UnitQuaternion<f64>);

/// The cube and its table, as these cameras see them.
pub struct Setting {
    /// The scene's file up to its events.
    head: String,
    /// All flights until the first impact.
    before: Scene,
    body: Body,
    /// Middles of the balls that the corners are, their names, and their radius \[m\].
    corners_m: Vec<Vector3<f64>>,
    names: Vec<String>,
    pub radius_m: f64,
}

/// The first impact of a toss as estimated.
pub struct Bounce {
    /// Number of impacts that were estimated together.
    pub impacts: usize,
    /// Value and standard deviation.
    pub restitution: (f64, Option<f64>),
    /// Value and standard deviation.
    pub friction: (f64, Option<f64>),
    /// Residuals before the impact, rms \[mm\], \[°\].
    pub before: (f64, f64),
    /// Residuals after the impact.
    pub residual: (f64, f64),
}

/// Name of an impact.
pub fn impact_name(index: usize) -> String {
    match index {
        0 => "impact".to_owned(),
        later => format!("impact {}", later + 1),
    }
}

/// The samples of a toss until a place, with marks of impacts and of the end.
fn taken(toss: &Toss, impacts: &[Touched], end: f64) -> Vec<TakeEvent> {
    let samples = (end.ceil() as usize).min(toss.poses.len());
    let names: Vec<String> = (0..impacts.len()).map(impact_name).collect();
    let places = impacts.iter().map(|impact| impact.place);
    let mut marks: Vec<(f64, &str)> = places.zip(names.iter().map(String::as_str)).collect();
    marks.push((samples as f64 - 1.0, "end"));
    toss.take(RATE_HZ, samples, &marks)
}

/// Root mean square over some flights \[mm\], \[°\].
fn rms(flights: &[SegmentResidual]) -> (f64, f64) {
    let count: usize = flights.iter().map(|flight| flight.samples).sum();
    let of = |value: fn(&SegmentResidual) -> Option<f64>| {
        let squares = flights.iter();
        let sum: f64 = squares
            .map(|f| f.samples as f64 * value(f).expect("poses").powi(2))
            .sum();
        (sum / count.max(1) as f64).sqrt()
    };
    let (position_m, orientation_rad) = (of(|f| f.position_rms_m), of(|f| f.orientation_rms_rad));
    (1e3 * position_m, orientation_rad.to_degrees())
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
        let text = scene_toml();
        let side_mm = 2e3 * HALF_M;
        let text = text
            .replace("104.8", &format!("{side_mm}"))
            .replace("52.4", &format!("{}", 0.5 * side_mm))
            .replace("8.1e-4", &format!("{moment_kg_m2:e}"))
            .replace("mass_kg", &format!("{LAW_TOML}mass_kg"));
        let (head, _) = text.split_once("[[event]]").unwrap_or((&text, ""));
        let (position_mm, orientation_deg) = NOISE;
        let head = format!(
            "gravity_m_s2 = [0, 0, {:?}]\n{head}\n[weights]\nposition_mm = {position_mm:?}\n\
             orientation_deg = {orientation_deg:?}\n",
            -GRAVITY_M_S2
        );
        let before = scene_from_toml(&format!("{head}{}", end_toml("impact")))?;
        let link = &before.links[LinkIndex(0)];
        let (mut corners_m, mut names) = (Vec::new(), Vec::new());
        for feature in link.candidate_features() {
            let feature = &link.features[feature];
            if let Feature::Point { point_m, .. } = feature.geometry {
                corners_m.push(point_m * (1.0 - radius_m / HALF_M));
                names.push(feature.name.clone());
            }
        }
        Ok(Self {
            body: link.body,
            head,
            before,
            corners_m,
            names,
            radius_m,
        })
    }

    /// Moment of inertia [kg m²].
    pub fn moment_kg_m2(&self) -> f64 {
        self.body.moments_kg_m2().x
    }

    /// Heights of the corners over the table \[m\].
    pub fn heights_m(&self, (position_m, orientation): &Pose) -> Vec<f64> {
        let corners = self.corners_m.iter();
        corners
            .map(|corner| (position_m + orientation * corner).z - self.radius_m)
            .collect()
    }

    /// Restitution and friction of the first impact, estimated through those that follow it closely.
    pub fn bounce(&self, toss: &Toss) -> Result<Bounce, String> {
        let poses = toss.poses.iter();
        let heights_m: Vec<Vec<f64>> = poses.map(|pose| self.heights_m(pose)).collect();
        let all = contacts(&heights_m);
        let (impacts, end) = first_impacts(&all, toss.poses.len())
            .ok_or_else(|| format!("{} contacts without a long flight", all.len()))?;
        let mut first = None;
        for order in orders(&impacts) {
            let tried = self.bounce_off(toss, &order, end);
            if tried.is_ok() {
                return tried;
            }
            first = first.or(Some(tried));
        }
        first.expect("at least one order")
    }

    /// The first impacts of a toss as a take: the text of its scene with the law free, the scene, samples and marks. `None`
    /// where no long flight follows them.
    pub fn first_impact(&self, toss: &Toss) -> Option<(String, Scene, Vec<TakeEvent>)> {
        let poses = toss.poses.iter();
        let heights_m: Vec<Vec<f64>> = poses.map(|pose| self.heights_m(pose)).collect();
        let (impacts, end) = first_impacts(&contacts(&heights_m), toss.poses.len())?;
        let toml = self.toml_of(&impacts);
        let scene = scene_from_toml(&toml).ok()?;
        Some((toml, scene, taken(toss, &impacts, end)))
    }

    /// The estimate of some impacts, each at its corner, and a flight that ends before a place.
    fn bounce_off(&self, toss: &Toss, impacts: &[Touched], end: f64) -> Result<Bounce, String> {
        let scene = self.with_impacts(impacts).map_err(|e| e.to_string())?;
        let events = taken(toss, impacts, end);
        let outcome = estimated(&scene, &events, &mut ()).map_err(|e| e.to_string())?;
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
        let (before, after) = estimate.residuals.split_at(1);
        Ok(Bounce {
            impacts: impacts.len(),
            restitution: parameter("cube.restitution"),
            friction: parameter("cube.friction"),
            before: rms(before),
            residual: rms(after),
        })
    }

    /// The scene with these impacts, their law free.
    pub fn with_impacts(&self, impacts: &[Touched]) -> Result<Scene> {
        let mut scene = scene_from_toml(&self.toml_of(impacts))?;
        for feature in &mut scene.links[LinkIndex(0)].features {
            if let Feature::Point { point_m, radius_m } = &mut feature.geometry {
                *point_m *= 1.0 - self.radius_m / HALF_M;
                *radius_m = self.radius_m;
            }
        }
        Ok(scene)
    }

    fn toml_of(&self, impacts: &[Touched]) -> String {
        let mut text = self.head.clone();
        for (index, impact) in impacts.iter().enumerate() {
            let name = impact_name(index);
            let corner = &self.names[impact.corner];
            text += &format!(
                "[[event]]\nname = {name:?}\nkind = \"collision\"\nbody = \"cube\"\n\
                 feature = {corner:?}\nsurface = \"table\"\n"
            );
        }
        format!("{text}{}{FREE_LAW_TOML}", end_toml("end"))
    }

    /// The state of the first flight, and its time.
    fn flown(&self, toss: &Toss) -> Result<(State, f64), String> {
        let outcome = toss
            .first_flight(&self.before, RATE_HZ)
            .map_err(|e| e.to_string())?;
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
            tangential_restitution: 0.0,
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
