//! What is estimated beside the motion.

use schemars::JsonSchema;
use serde::Deserialize;

use super::value::{Number, Text};

/// A free quantity, with a number of each key in each unit.
macro_rules! raw_free {
    ($($about:literal: $($key:ident)*;)*) => {
        /// A quantity that is estimated. Its keys end in the unit of the quantity; the documentation of
        /// `enact::config` lists all quantities.
        ///
        /// ```toml
        /// [[free]]
        /// quantity = "bounce.restitution"
        /// lower = 0.5
        /// upper = 0.9
        /// ```
        #[derive(Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, expecting = "a free quantity")]
        #[schemars(rename = "free")]
        pub(in crate::config) struct RawFree {
            /// Its name, such as `bounce.restitution` or `table.height`.
            pub(in crate::config) quantity: Text,
            $($(#[doc = $about] $key: Option<Number>,)*)*
            /// Half the opening of a cone in which both tilts of a normal are.
            pub(in crate::config) cone_deg: Option<Number>,
        }

        impl RawFree {
            /// The number at a key, if it is given.
            pub(in crate::config) fn number(&self, key: &str) -> Option<&Number> {
                match key {
                    $($(stringify!($key) => self.$key.as_ref(),)*)*
                    _ => None,
                }
            }
        }
    };
}

raw_free! {
    "Where it begins. Default: what the scene says, or 0, or of a factor 1.":
    initial initial_m_s2 initial_deg initial_mm initial_ms initial_percent
    initial_per_s initial_per_m;
    "Least value. Default: the least there is.":
    lower lower_m_s2 lower_deg lower_mm lower_ms lower_percent lower_per_s lower_per_m;
    "Greatest value. Default: the greatest there is.":
    upper upper_m_s2 upper_deg upper_mm upper_ms upper_percent upper_per_s upper_per_m;
    "How well it is known beforehand, as a standard deviation about where it begins. Default: not at all.":
    prior_sd prior_sd_m_s2 prior_sd_deg prior_sd_mm prior_sd_ms prior_sd_percent
    prior_sd_per_s prior_sd_per_m;
}
