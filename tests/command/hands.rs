//! Bodies that a hand carries, throws, catches, puts down and picks up: the truth is a polynomial of the hand, then a flight in
//! closed form.

use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

use crate::phases::{GRAVITY_M_S2, Samples, assert_within, replayed};
use crate::program::enact;

const RATE_HZ: f64 = 120.0;

/// A place with its velocity and acceleration.
type Jet = [Vector3<f64>; 3];

/// The polynomial of fifth degree between two jets, some seconds apart.
fn between(from: &Jet, to: &Jet, lasts_s: f64, time_s: f64) -> Vector3<f64> {
    let (h, x) = (lasts_s, time_s / lasts_s);
    let [p, v, a] = [from[0], from[1] * h, from[2] * (h * h)];
    let way = to[0] - p - v - a * 0.5;
    let speed = to[1] * h - v - a;
    let force = to[2] * (h * h) - a;
    let cubic = way * 10.0 - speed * 4.0 + force * 0.5;
    let quartic = way * -15.0 + speed * 7.0 - force;
    let quintic = way * 6.0 - speed * 3.0 + force * 0.5;
    p + v * x + a * (0.5 * x * x) + cubic * x.powi(3) + quartic * x.powi(4) + quintic * x.powi(5)
}

fn still(place_m: Vector3<f64>) -> Jet {
    [place_m, Vector3::zeros(), Vector3::zeros()]
}

fn fallen(from: &Jet, time_s: f64) -> Vector3<f64> {
    from[0] + from[1] * time_s - Vector3::z() * (0.5 * GRAVITY_M_S2 * time_s * time_s)
}

/// A ball of 30 mm; it turns steadily about one axis, in the hand and in flight.
struct Throw {
    start: Jet,
    let_go: Jet,
    let_go_s: f64,
    turn: Vector3<f64>,
}

impl Throw {
    fn drawn(random: &mut ChaCha8Rng) -> Self {
        let mut within = |most: f64| Vector3::from_fn(|_, _| random.random_range(-most..most));
        let start_m = Vector3::z() + within(0.2);
        let let_go = [
            start_m + Vector3::new(0.3, 0.0, 0.3) + within(0.1),
            Vector3::new(1.5, 0.0, 1.8) + within(0.6),
            Vector3::new(0.0, 0.0, 8.0) + within(8.0),
        ];
        Self {
            start: still(start_m),
            let_go,
            turn: within(4.0),
            let_go_s: random.random_range(0.5..0.8),
        }
    }

    fn place_m(&self, time_s: f64) -> Vector3<f64> {
        match time_s - self.let_go_s {
            since_s if since_s < 0.0 => between(&self.start, &self.let_go, self.let_go_s, time_s),
            since_s => fallen(&self.let_go, since_s),
        }
    }

    fn orientation(&self, time_s: f64) -> UnitQuaternion<f64> {
        UnitQuaternion::from_scaled_axis(self.turn * time_s)
    }

    fn seen(
        &self,
        until_s: f64,
        place_m: impl Fn(f64) -> Vector3<f64>,
        random: &mut ChaCha8Rng,
    ) -> String {
        let mut samples = Samples::default();
        for sample in 0..=(until_s * RATE_HZ) as usize {
            let time_s = sample as f64 / RATE_HZ;
            samples.add(time_s, &place_m(time_s), &self.orientation(time_s), random);
        }
        samples.csv
    }
}

fn scene(stamps: &str, events: &[&str], more: &str) -> String {
    let changes = events.iter().map(|event| {
        format!("[[event]]\nname = \"{event}\"\nkind = \"change\"\nbody = \"ball\"\n")
    });
    format!(
        "name = \"in a hand\"\nhand = \"none\"\n[timing]\nstamps = \"{stamps}\"\n\
         [[body]]\nname = \"ball\"\nshape = {{ kind = \"sphere\", radius_mm = 30 }}\nmass_g = 60\n\
         [[event]]\nname = \"go\"\nkind = \"start\"\n{}\
         [[event]]\nname = \"end\"\nkind = \"end\"\n{more}",
        changes.collect::<String>()
    )
}

fn held(name: &str, from: &str, until: &str) -> String {
    format!(
        "[[phase]]\nname = \"{name}\"\nmotion = \"held\"\nbody = \"ball\"\nfrom = \"{from}\"\nuntil = \"{until}\"\n"
    )
}

fn event<'a>(said: &'a Value, name: &str) -> &'a Value {
    let mut events = said["events"].as_array().expect("events").iter();
    events.find(|of| of["name"] == name).expect("the event")
}

#[test]
fn the_moment_in_which_a_hand_lets_go_is_told() {
    let mut random = ChaCha8Rng::seed_from_u64(9600);
    for _ in 0..4 {
        let throw = Throw::drawn(&mut random);
        let end_s = throw.let_go_s + 0.4;
        let csv = throw.seen(end_s, |time_s| throw.place_m(time_s), &mut random);
        let mark_s = throw.let_go_s + random.random_range(-0.04..0.04);
        let folder = tempfile::tempdir().expect("a folder");
        let marks = [(0.0, "go"), (mark_s, "thrown"), (end_s - 0.01, "end")];
        for stamps in ["physical", "tempo"] {
            let carried = scene(stamps, &["thrown"], &held("carried", "go", "thrown"));
            let said = replayed(folder.path(), &carried, &csv, &marks);
            assert_eq!(said["verdict"], "physical", "{said}");
            assert_eq!(said["held"][0]["phase"], "carried");
            assert_eq!(said["segments"].as_array().map(Vec::len), Some(1));
            let thrown = event(&said, "thrown");
            match stamps {
                "physical" => {
                    assert_eq!(said["fits"], "yes", "{said}");
                    let truth_s = throw.let_go_s;
                    assert_within(thrown, "time_s", "time_sd_s", truth_s, 6e-3, "thrown");
                    assert_eq!(said["held"][0]["end_s"], thrown["time_s"]);
                }
                _ => {
                    let lasts_s = said["physical_s"].as_f64().expect("a duration");
                    assert!((lasts_s - end_s).abs() < 0.15 * end_s, "{lasts_s}");
                }
            }
        }
    }
}

#[test]
fn what_flies_from_the_beginning_was_in_no_hand() {
    let mut random = ChaCha8Rng::seed_from_u64(9610);
    let throw = Throw::drawn(&mut random);
    let flown = |time_s: f64| fallen(&throw.let_go, time_s);
    let csv = throw.seen(0.6, flown, &mut random);
    let folder = tempfile::tempdir().expect("a folder");
    let marks = [(0.0, "go"), (0.25, "thrown"), (0.59, "end")];
    let carried = scene("physical", &["thrown"], &held("carried", "go", "thrown"));
    let said = replayed(folder.path(), &carried, &csv, &marks);
    // A hand may move as what falls does: then nothing tells when it let go.
    let thrown = event(&said, "thrown");
    assert_eq!(thrown["time_is"], "undetermined", "{thrown}");
}

#[test]
fn a_hand_catches_what_flies() {
    let mut random = ChaCha8Rng::seed_from_u64(9620);
    for _ in 0..3 {
        let throw = Throw::drawn(&mut random);
        let caught_s = random.random_range(0.35..0.5);
        let met = fallen(&throw.let_go, caught_s);
        let arriving = throw.let_go[1] - Vector3::z() * (GRAVITY_M_S2 * caught_s);
        let taken = [met, arriving * 0.2, Vector3::zeros()];
        let rest = still(met + arriving * 0.05);
        let lasts_s = 0.4;
        let place_m = |time_s: f64| match time_s - caught_s {
            since_s if since_s < 0.0 => fallen(&throw.let_go, time_s),
            since_s => between(&taken, &rest, lasts_s, since_s.min(lasts_s)),
        };
        let csv = throw.seen(caught_s + lasts_s, place_m, &mut random);
        let mark_s = caught_s + random.random_range(-0.03..0.03);
        let folder = tempfile::tempdir().expect("a folder");
        let marks = [
            (0.0, "go"),
            (mark_s, "caught"),
            (caught_s + lasts_s - 0.01, "end"),
        ];
        let scene = scene("physical", &["caught"], &held("taken", "caught", "end"));
        let said = replayed(folder.path(), &scene, &csv, &marks);
        assert_eq!(said["verdict"], "physical", "{said}");
        let caught = event(&said, "caught");
        // A slow tracker does not say to which side a sample belongs.
        assert_within(caught, "time_s", "time_sd_s", caught_s, 6e-3, "caught");
    }
}

#[test]
fn what_a_hand_puts_down_lies_and_is_picked_up() {
    let mut random = ChaCha8Rng::seed_from_u64(9630);
    let lies = Vector3::new(0.1, -0.1, 0.03);
    let put = [lies, Vector3::new(0.0, 0.0, -0.2), Vector3::zeros()];
    let away = still(lies + Vector3::new(0.2, 0.1, 0.3));
    let [put_s, picked_s] = [0.6, 1.2];
    let place_m = |time_s: f64| match time_s {
        time_s if time_s < put_s => between(&away, &put, put_s, time_s),
        time_s if time_s < picked_s => lies,
        time_s => between(&still(lies), &away, 0.6, time_s - picked_s),
    };
    let mut throw = Throw::drawn(&mut random);
    throw.turn = Vector3::zeros();
    let csv = throw.seen(1.79, place_m, &mut random);
    let lying = "[[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
                 [[phase]]\nname = \"lies\"\nmotion = \"rest\"\nbody = \"ball\"\nsurface = \"table\"\nfrom = \"put\"\nuntil = \"picked\"\n";
    let phases = held("down", "go", "put") + lying + &held("up", "picked", "end");
    let scene = scene("physical", &["put", "picked"], &phases);
    let folder = tempfile::tempdir().expect("a folder");
    let marks = [(0.0, "go"), (0.62, "put"), (1.19, "picked"), (1.78, "end")];
    let said = replayed(folder.path(), &scene, &csv, &marks);
    assert_eq!(said["verdict"], "physical", "{said}");
    let put = event(&said, "put");
    assert_within(put, "time_s", "time_sd_s", put_s, 0.01, "put");
    let picked = event(&said, "picked");
    assert_within(picked, "time_s", "time_sd_s", picked_s, 0.03, "picked");
    let [down, up] = [0, 1].map(|at| &said["held"][at]);
    assert_eq!(
        (&down["phase"], &up["phase"]),
        (&"down".into(), &"up".into())
    );
}

/// A mug in a tracked hand, which nothing sees by itself.
const GRIPPED: &str = "name = \"gripped\"\n[timing]\nstamps = \"physical\"\n\
    [[body]]\nname = \"hand\"\nheld = true\nshape = { kind = \"sphere\", radius_mm = 40 }\n\
    [[body]]\nname = \"mug\"\ntracked = false\nshape = { kind = \"cylinder\", length_mm = 95, radius_mm = 40 }\nmass_g = 300\n\
    [[joint]]\nname = \"grip\"\nkind = \"fixed\"\nparent = \"hand\"\nparent_at_mm = [0, 100, 0]\nchild = \"mug\"\nuntil = \"thrown\"\n\
    [[event]]\nname = \"go\"\nkind = \"start\"\n\
    [[event]]\nname = \"thrown\"\nkind = \"change\"\nbody = \"mug\"\n\
    [[event]]\nname = \"end\"\nkind = \"end\"\n";

#[test]
fn what_a_tracked_hand_grips_flies_on_as_the_hand_moved() {
    let mut random = ChaCha8Rng::seed_from_u64(9640);
    let throw = Throw::drawn(&mut random);
    let rest = still(throw.let_go[0] + throw.let_go[1] * 0.1);
    let place_m = |time_s: f64| match time_s - throw.let_go_s {
        since_s if since_s < 0.0 => throw.place_m(time_s),
        since_s => between(&throw.let_go, &rest, 0.4, since_s.min(0.4)),
    };
    let end_s = throw.let_go_s + 0.35;
    let csv = throw.seen(end_s, place_m, &mut random);
    let folder = tempfile::tempdir().expect("a folder");
    let marks = [
        (0.0, "go"),
        (throw.let_go_s, "thrown"),
        (end_s - 0.01, "end"),
    ];
    let said = replayed(folder.path(), GRIPPED, &csv, &marks);
    assert_eq!(said["verdict"], "physical", "{said}");
    assert_eq!(said["fits"], "unknown", "{said}");
    let grips = said["held"].as_array().expect("both");
    assert_eq!(grips[1]["phase"], "grip");
    // The mug is 100 mm from the tracker, with which it turns.
    let lever = throw.orientation(throw.let_go_s) * Vector3::new(0.0, 0.1, 0.0);
    let swing = (throw.orientation(throw.let_go_s) * throw.turn).cross(&lever);
    let let_go = [
        throw.let_go[0] + lever,
        throw.let_go[1] + swing,
        Vector3::zeros(),
    ];
    let expected = fallen(&let_go, end_s - 0.01 - throw.let_go_s);
    let output = std::fs::read_dir(folder.path()).expect("a folder");
    let mut output = output.map(|of| of.expect("a file").path());
    let output = output.find(|path| path.extension().is_some_and(|of| of == "mcap"));
    let output = output.expect("the motion").display().to_string();
    let ran = enact(
        folder.path(),
        &["export", &output, "--to", "csv", "-o", "out.csv"],
    );
    assert!(
        ran.status.success(),
        "{}",
        String::from_utf8_lossy(&ran.stderr)
    );
    let table = std::fs::read_to_string(folder.path().join("out.csv")).expect("a table");
    let last = table.lines().rfind(|line| line.contains("mug,estimate"));
    let numbers = last.expect("the mug").split(',').skip(5).take(3);
    let numbers: Vec<f64> = numbers.map(|of| of.parse().expect("a number")).collect();
    let off_m = (Vector3::from_vec(numbers) - expected).norm();
    assert!(off_m < 0.08, "{off_m}");
}

#[test]
fn what_hands_cannot_do_is_refused_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let one = |more: &str| scene("physical", &["thrown"], more);
    let carried = held("carried", "go", "thrown");
    let tracked = GRIPPED.replace("tracked = false\n", "");
    for (scene, expected) in [
        (one(&held("carried", "go", "end")), "is between both events"),
        (
            one(&(carried.clone() + &held("still", "thrown", "end"))),
            "before and after the event, expected one phase",
        ),
        (
            scene("physical", &[], &held("carried", "go", "end")),
            "nothing of it is estimated",
        ),
        (
            one(&(carried.clone() + "friction = 0.1\n")),
            "friction is of",
        ),
        (
            one(&carried).replace("mass_g = 60\n", "mass_g = 60\ntracked = false\n"),
            "no tracker sees",
        ),
        (tracked, "has a tracker of its own"),
        (
            GRIPPED.replace("\"fixed\"", "\"ball\""),
            "does not move in it",
        ),
        (
            GRIPPED.replace("until = \"thrown\"\n", ""),
            "let go at the `until` of its joint",
        ),
    ] {
        std::fs::write(folder.path().join("scene.toml"), &scene).expect("a scene");
        let ran = enact(folder.path(), &["scene", "check", "scene.toml"]);
        let said = String::from_utf8_lossy(&ran.stderr);
        assert!(
            !ran.status.success() && said.contains(expected),
            "{scene}\n{expected}: {said}"
        );
    }
}
