//! The scene file as it is written: all keys with their units; only types are checked.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

pub(super) type Number = Spanned<f64>;
pub(super) type Triple = Spanned<[f64; 3]>;
pub(super) type Quadruple = Spanned<[f64; 4]>;
pub(super) type Text = Spanned<String>;
/// Lower and upper corner of a box.
pub(super) type Corners = Spanned<[[f64; 3]; 2]>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a scene")]
pub(super) struct RawScene {
    pub(super) name: Text,
    pub(super) gravity_m_s2: Option<Triple>,
    pub(super) marks_topic: Option<Text>,
    pub(super) timing: RawTiming,
    pub(super) velocity_gaps: Option<Text>,
    pub(super) settle_s: Option<Number>,
    pub(super) capture: Option<RawCapture>,
    pub(super) weights: Option<RawWeights>,
    #[serde(default)]
    pub(super) body: Vec<Spanned<RawBody>>,
    #[serde(default)]
    pub(super) joint: Vec<Spanned<RawJoint>>,
    #[serde(default)]
    pub(super) surface: Vec<RawSurface>,
    #[serde(default)]
    pub(super) obstacle: Vec<RawObstacle>,
    #[serde(default)]
    pub(super) event: Vec<Spanned<RawEvent>>,
    #[serde(default)]
    pub(super) goal: Vec<Spanned<RawGoal>>,
    #[serde(default)]
    pub(super) free: Vec<RawFree>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table with `stamps`")]
pub(super) struct RawTiming {
    pub(super) stamps: Text,
    pub(super) tempo_sd_per_sqrt_s: Option<Number>,
    pub(super) mark_sd_ms: Option<Number>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table of weights")]
pub(super) struct RawWeights {
    pub(super) position_mm: Option<Number>,
    pub(super) orientation_deg: Option<Number>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a body")]
pub(super) struct RawBody {
    pub(super) name: Text,
    pub(super) topic: Option<Text>,
    pub(super) shape: Spanned<RawShape>,
    pub(super) mass_g: Option<Number>,
    pub(super) mass_kg: Option<Number>,
    pub(super) density_kg_m3: Option<Number>,
    pub(super) moments_kg_m2: Option<Triple>,
    pub(super) tracker: Option<Spanned<RawTracker>>,
    #[serde(default)]
    pub(super) track: Vec<Spanned<RawTrack>>,
    pub(super) tracked: Option<Spanned<bool>>,
    pub(super) held: Option<Spanned<bool>>,
    pub(super) tracker_sd_mm: Option<Number>,
    pub(super) tracker_sd_deg: Option<Number>,
    pub(super) restitution: Option<Number>,
    pub(super) friction: Option<Number>,
    pub(super) force_m_s2: Option<Triple>,
    pub(super) drag_linear_per_s: Option<Number>,
    pub(super) drag_quadratic_per_m: Option<Number>,
    #[serde(default)]
    pub(super) features_mm: BTreeMap<Text, Triple>,
    #[serde(default)]
    pub(super) face: Vec<RawSurface>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a joint")]
pub(super) struct RawJoint {
    pub(super) name: Text,
    pub(super) kind: Text,
    pub(super) parent: Option<Text>,
    pub(super) child: Text,
    pub(super) parent_at_mm: Option<Triple>,
    pub(super) child_at_mm: Option<Triple>,
    pub(super) child_orientation_wxyz: Option<Quadruple>,
    pub(super) axis: Option<Triple>,
    pub(super) axes: Option<Spanned<[[f64; 3]; 2]>>,
    pub(super) damping_n_m_s: Option<Number>,
    pub(super) stiffness_n_m: Option<Number>,
    pub(super) limits_deg: Option<Spanned<Vec<[f64; 2]>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a track")]
pub(super) struct RawTrack {
    pub(super) name: Option<Text>,
    pub(super) topic: Option<Text>,
    pub(super) sees: Option<Text>,
    pub(super) point: Option<Text>,
    pub(super) axis: Option<Triple>,
    pub(super) tracker: Option<Spanned<RawTracker>>,
    pub(super) position_sd_mm: Option<Number>,
    pub(super) orientation_sd_deg: Option<Number>,
    pub(super) weights: Option<Text>,
}

#[derive(Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "a table with `position_mm` and `orientation_wxyz`"
)]
pub(super) struct RawTracker {
    pub(super) position_mm: Option<Triple>,
    pub(super) orientation_wxyz: Option<Quadruple>,
}

#[derive(Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "a shape such as { kind = \"sphere\", radius_mm = 10 }"
)]
pub(super) struct RawShape {
    pub(super) kind: Text,
    pub(super) size_mm: Option<Triple>,
    pub(super) radius_mm: Option<Number>,
    pub(super) length_mm: Option<Number>,
    pub(super) height_mm: Option<Number>,
    pub(super) points_mm: Option<Spanned<Vec<[f64; 3]>>>,
}

#[derive(Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "a table with `name`, `point_mm` and `normal`"
)]
pub(super) struct RawSurface {
    pub(super) name: Text,
    pub(super) point_mm: Triple,
    pub(super) normal: Triple,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an obstacle")]
pub(super) struct RawObstacle {
    pub(super) name: Text,
    pub(super) shape: Spanned<RawShape>,
    pub(super) position_mm: Triple,
    pub(super) orientation_wxyz: Option<Quadruple>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an event")]
pub(super) struct RawEvent {
    pub(super) name: Text,
    pub(super) kind: Text,
    pub(super) body: Option<Text>,
    pub(super) feature: Option<Text>,
    pub(super) features: Option<Spanned<Vec<Text>>>,
    pub(super) surface: Option<Text>,
    pub(super) other: Option<Text>,
    pub(super) other_feature: Option<Text>,
    pub(super) restitution: Option<Number>,
    pub(super) friction: Option<Number>,
    pub(super) count: Option<Spanned<RawCount>>,
    pub(super) time: Option<Text>,
    pub(super) time_sd_ms: Option<Number>,
    pub(super) earliest_ms: Option<Number>,
    pub(super) latest_ms: Option<Number>,
}

/// How often a collision happens: a number, or the least and the greatest.
#[derive(Deserialize)]
#[serde(untagged, expecting = "a number such as 6, or a range such as [4, 8]")]
pub(super) enum RawCount {
    Exact(usize),
    Range([usize; 2]),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a goal")]
pub(super) struct RawGoal {
    pub(super) event: Text,
    pub(super) body: Option<Text>,
    pub(super) joint: Option<Text>,
    pub(super) angles_deg: Option<Spanned<Vec<f64>>>,
    pub(super) angles_within_deg: Option<Spanned<[Vec<f64>; 2]>>,
    pub(super) after: Option<Spanned<bool>>,
    pub(super) position_mm: Option<Triple>,
    pub(super) position_within_mm: Option<Corners>,
    pub(super) within_mm: Option<Number>,
    pub(super) sd_mm: Option<Number>,
    pub(super) point_mm: Option<Triple>,
    pub(super) feature: Option<Text>,
    pub(super) contact: Option<Spanned<bool>>,
    pub(super) normal: Option<Triple>,
    pub(super) relative_to: Option<Text>,
    pub(super) orientation_wxyz: Option<Quadruple>,
    pub(super) axis: Option<Spanned<RawAxis>>,
    pub(super) direction: Option<Triple>,
    pub(super) within_deg: Option<Number>,
    pub(super) sd_deg: Option<Number>,
    pub(super) velocity_m_s: Option<Triple>,
    pub(super) velocity_within_m_s: Option<Corners>,
    pub(super) within_m_s: Option<Number>,
    pub(super) sd_m_s: Option<Number>,
    pub(super) spin_rad_s: Option<Triple>,
    pub(super) spin_within_rad_s: Option<Corners>,
    pub(super) within_rad_s: Option<Number>,
    pub(super) sd_rad_s: Option<Number>,
    pub(super) axes: Option<Text>,
    pub(super) at_rest: Option<Spanned<bool>>,
    pub(super) time_ms: Option<Number>,
    pub(super) time_within_ms: Option<Spanned<[f64; 2]>>,
    pub(super) since: Option<Text>,
    pub(super) sd_ms: Option<Number>,
    pub(super) face_up: Option<Text>,
    pub(super) labels: Option<Text>,
}

/// An axis of a body: a name such as `+z`, or three numbers.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "an axis such as \"+z\", a face's name, or three numbers"
)]
pub(super) enum RawAxis {
    Name(String),
    Vector([f64; 3]),
}

/// A free quantity, with a number of each key in each unit.
macro_rules! raw_free {
    ($($key:ident)*) => {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields, expecting = "a free quantity")]
        pub(super) struct RawFree {
            pub(super) quantity: Text,
            $($key: Option<Number>,)*
            pub(super) cone_deg: Option<Number>,
        }

        impl RawFree {
            /// The number at a key, if it is given.
            pub(super) fn number(&self, key: &str) -> Option<&Number> {
                match key {
                    $(stringify!($key) => self.$key.as_ref(),)*
                    _ => None,
                }
            }
        }
    };
}

raw_free! {
    initial initial_m_s2 initial_deg initial_mm initial_ms initial_percent
    initial_per_s initial_per_m
    lower lower_m_s2 lower_deg lower_mm lower_ms lower_percent lower_per_s lower_per_m
    upper upper_m_s2 upper_deg upper_mm upper_ms upper_percent upper_per_s upper_per_m
    prior_sd prior_sd_m_s2 prior_sd_deg prior_sd_mm prior_sd_ms prior_sd_percent
    prior_sd_per_s prior_sd_per_m
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table of capture settings")]
pub(super) struct RawCapture {
    pub(super) folder: Option<Text>,
    pub(super) chunk_ms: Option<Number>,
    pub(super) sync_ms: Option<Number>,
    pub(super) listen: Option<Text>,
    pub(super) viewer_port: Option<Number>,
    pub(super) metrics_port: Option<Number>,
    pub(super) origins: Option<Vec<Text>>,
    pub(super) pre_roll_s: Option<Number>,
    #[serde(default)]
    pub(super) tracker: Vec<RawTrackerClock>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table with `body` and `stamps`")]
pub(super) struct RawTrackerClock {
    pub(super) body: Text,
    pub(super) stamps: Text,
    pub(super) rate_hz: Option<Number>,
}
