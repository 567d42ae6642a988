//! What speaks against a motion, in words and in numbers.

use serde::{Deserialize, Serialize};

use super::units::{self, for_people};
use crate::motion::{About, Doubt, Place, Scene, Verdict};

/// One thing that speaks against a motion, in numbers and in words.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct DoubtLine {
    /// What was measured; see [`About`].
    pub quantity: String,
    /// What it is; `null` where the performance does not determine it.
    pub value: f64,
    /// What it may be.
    pub bound: f64,
    /// Unit of both.
    pub unit: String,
    /// The body, event or parameter where it is; none where it is of the whole motion.
    pub at: Option<String>,
    /// Physical time, where it is at one: the beginning of a flight.
    pub time_s: Option<f64>,
    /// The best verdict that it leaves: `physical` where it is only to be known.
    pub best: String,
    /// All of that as a sentence.
    pub text: String,
}

impl DoubtLine {
    /// With the scene's names.
    pub fn new(scene: &Scene, doubt: &Doubt) -> Self {
        Self {
            quantity: doubt.about.as_str().to_owned(),
            value: doubt.value,
            bound: doubt.bound,
            unit: unit(scene, doubt).to_owned(),
            at: doubt.place.name(scene).map(str::to_owned),
            time_s: doubt.place.time_s(),
            best: doubt.about.best().as_str().to_owned(),
            text: sentence(scene, doubt),
        }
    }

    /// Whether it takes the verdict `physical` back.
    pub fn is_grave(&self) -> bool {
        self.best != Verdict::Physical.as_str()
    }
}

/// The gravest doubt in words, if one takes the verdict `physical` back.
pub fn gravest(scene: &Scene, doubts: &[Doubt]) -> Option<String> {
    let first = doubts.iter().max_by_key(|doubt| doubt.about.best())?;
    (first.about.best() != Verdict::Physical).then(|| sentence(scene, first))
}

/// The unit of what was measured: of a quantity at the end of its range that of the quantity.
fn unit(scene: &Scene, doubt: &Doubt) -> &'static str {
    match (doubt.about, &doubt.place) {
        (About::AtBound, Place::Parameter(index)) => scene.parameters[*index].quantity.unit(),
        _ => doubt.about.unit(),
    }
}

fn sentence(scene: &Scene, doubt: &Doubt) -> String {
    let (value, bound) = (doubt.value, doubt.bound);
    let subject = match doubt.place.name(scene) {
        Some(name) => format!("`{name}`"),
        None => "the motion".to_owned(),
    };
    let inside = || match doubt.place {
        Place::Inside {
            against, time_s, ..
        } => (scene.name_of(against), time_s),
        _ => ("something", 0.0),
    };
    let percent = |part: f64| format!("{:.0} %", part * 100.0);
    match doubt.about {
        About::Overlap => {
            let (against, time_s) = inside();
            let [depth_mm, most_mm] = [value, bound].map(|m| m * 1e3);
            format!(
                "{subject} is {depth_mm:.1} mm inside `{against}` at {time_s:.3} s, expected at most \
                 {most_mm:.1} mm"
            )
        }
        About::KeptOut => {
            let (against, time_s) = inside();
            format!(
                "{subject} would be {:.1} mm inside `{against}` at {time_s:.3} s if nothing kept it out, and only just \
                 passes it: where it was hit there, a bounce is missing",
                value * 1e3
            )
        }
        About::EndTouches => format!(
            "the motion ends at {subject}, {:.0} ms before its mark: there it touches something of which no event tells. \
             Where it went on, a collision is missing",
            value * 1e3
        ),
        About::Rest => not_at_rest_so(scene, doubt, &subject),
        About::Steps => format!(
            "integrated with steps of half the length {subject} is {:.3} mm elsewhere, expected at most {:.3} mm",
            value * 1e3,
            bound * 1e3
        ),
        About::Gap => format!(
            "what hits is {:.3} mm from touching, expected at most {:.3} mm",
            value * 1e3,
            bound * 1e3
        ),
        About::Receding => format!(
            "what hits recedes at {value:.3} m/s before, expected at most {bound:.3}: it does not come near"
        ),
        About::Energy => format!(
            "an impact adds {} to the kinetic energy, expected nothing",
            percent(value)
        ),
        About::Pull => format!(
            "at {subject} one of the contacts pulls with {} of the greatest impulse: no contact can, expected fewer features",
            percent(value)
        ),
        About::Tips => format!(
            "{subject} tips: to stay on its face it would have to be pressed {:.1} mm beyond its outline, expected at most {:.1} mm",
            value * 1e3,
            bound * 1e3
        ),
        About::Slips => format!(
            "{subject} slips where it is said not to, or goes on where friction has stopped it, at {value:.3} m/s, expected at most {bound:.3}"
        ),
        About::Driven => format!(
            "{subject} tumbles and gains energy, as if lifted by {:.1} mm, expected at most {:.1} mm: something drives it",
            value * 1e3,
            bound * 1e3
        ),
        About::Untouched => format!(
            "{subject} is said to tumble where nothing of the scene is within {:.1} mm, expected something within {:.1} mm",
            value * 1e3,
            bound * 1e3
        ),
        About::Limit => format!(
            "{subject} is {:.1}° beyond its limits at {:.3} s, expected at most {:.1}°",
            value.to_degrees(),
            doubt.place.time_s().unwrap_or_default(),
            bound.to_degrees()
        ),
        About::WrongFeature => wrong_feature(scene, doubt, &subject),
        About::Speed => format!("{subject} moves at {value:.0} m/s, expected at most {bound:.0}"),
        About::Spin => format!("{subject} spins at {value:.0} rad/s, expected at most {bound:.0}"),
        About::Way => format!(
            "{subject} flies {value:.1} times as far as it was acted, expected at most {bound:.0}"
        ),
        About::Slowness => format!(
            "{subject} would be {value:.0} times as fast as it was acted, expected at most {bound:.0}"
        ),
        About::Haste => format!(
            "{subject} would be {value:.1} times as slow as it was acted, expected at most {bound:.1}"
        ),
        About::Residual => format!(
            "{subject} is {value:.0} times the scene's weights away from the samples, expected at \
             most {bound:.0}"
        ),
        About::Orientation => format!(
            "{subject} is turned by {:.0}° from the samples, expected at most {:.0}°",
            value.to_degrees(),
            bound.to_degrees()
        ),
        About::Alone => format!(
            "free flights miss the samples by {value:.0} times the scene's weights even one by one, \
             expected at most {bound:.0}"
        ),
        About::Misfit => format!(
            "the flights fit {value:.1} times worse together than each alone, expected at most \
             {bound:.1}: what joins them is wrong, or their weights"
        ),
        About::Fall => format!(
            "the flights fit {value:.1} times better with another acceleration than gravity's, \
             expected at most {bound:.0}: they do not fall freely, or times are not physical"
        ),
        About::FallDirection => format!(
            "the flights fall {:.0}° away from gravity, expected at most {:.0}°",
            value.to_degrees(),
            bound.to_degrees()
        ),
        About::AfterMark | About::BeforeMark => {
            let side = match doubt.about {
                About::AfterMark => "after",
                _ => "before",
            };
            format!(
                "{subject} is {:.0} ms {side} its mark, expected at most {:.0} ms",
                value * 1e3,
                bound * 1e3
            )
        }
        About::Led => {
            let goals = match doubt.place.name(scene) {
                Some(name) => format!("the goal at `{name}` asks"),
                None => "the goals ask".to_owned(),
            };
            format!(
                "{goals} for another motion than was acted: it is {value:.1} times as far from the samples as without"
            )
        }
        About::Gravity => format!(
            "gravity is {} off the scene's, expected at most {}",
            percent(value),
            percent(bound)
        ),
        About::GravitySpread if value.is_infinite() => {
            "gravity is not determined by the performance".to_owned()
        }
        About::GravitySpread => format!(
            "gravity is uncertain by {}, expected at most {}",
            percent(value),
            percent(bound)
        ),
        About::Outside => format!(
            "{subject} is compared with a sample {:.1} ms beyond the end of its flight: there were too \
             few others",
            value * 1e3
        ),
        About::AtBound => {
            let (factor, unit) = for_people(unit(scene, doubt));
            let end = units::bound(bound * factor);
            format!("{subject} is at the end of its range, {end} {unit}")
                .trim_end()
                .to_owned()
        }
        About::Ambiguity => format!(
            "the samples are {value:.1} times the scene's weights away on the whole: beyond {bound:.0} \
             another motion may fit better"
        ),
        About::Keyframes => format!(
            "the keyframes are {value:.1} times the scene's weights away, expected at most {bound:.1}: \
             so few poses do not tell whether they are rough or the motion is another; more keyframes \
             do, or weights as large as their errors"
        ),
        About::OpenTimes => format!(
            "{subject} needs known times of {value:.0} more of its keyframes: with fewer than two another \
             motion may pass through all of them"
        ),
        About::Rivals => {
            let others = match value as usize {
                1 => "another motion is".to_owned(),
                count => format!("{count} other motions are"),
            };
            format!(
                "{others} as near to the keyframes, and this is the one that turns least: one more \
                 keyframe, or a goal, decides"
            )
        }
    }
}

fn wrong_feature(scene: &Scene, doubt: &Doubt, subject: &str) -> String {
    let Place::Touch {
        link,
        expected,
        found,
        ..
    } = &doubt.place
    else {
        return format!("at {subject} another part leads");
    };
    let name = |feature: &usize| scene.links[*link].features[*feature].name.as_str();
    let found = match found {
        Some(found) => format!("`{}`", name(found)),
        None => "an unnamed part".to_owned(),
    };
    let expected: Vec<&str> = expected.iter().map(name).collect();
    let [lead_mm, most_mm] = [doubt.value, doubt.bound].map(|m| m * 1e3);
    format!(
        "at {subject} {found} leads `{}` by {lead_mm:.1} mm, expected at most {most_mm:.1} mm",
        expected.join(", ")
    )
}

fn not_at_rest_so(scene: &Scene, doubt: &Doubt, subject: &str) -> String {
    let Place::Rest { goal, shown, tried } = &doubt.place else {
        return format!("{subject} does not rest as it should");
    };
    let goal = &scene.rest_goals[*goal];
    let is_up =
        goal.direction.dot(&scene.gravity_m_s2) <= -(1.0 - 1e-9) * scene.gravity_m_s2.norm();
    let place = if is_up { "up" } else { "there" };
    let asked = &goal.name;
    let instead = match shown {
        Some(shown) => format!("rests with {shown} {place}"),
        None => "still moves at the limit".to_owned(),
    };
    format!(
        "no motion near the performance ends with {asked} of {subject} {place}: tried {tried}; this one \
         {instead}"
    )
}
