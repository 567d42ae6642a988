//! Bodies that tumble before they rest: the truth is a block that falls onto an edge, and rocks from edge to edge (Housner, "The
//! behavior of inverted pendulum structures during earthquakes", Bulletin of the Seismological Society of America 53, 1963).

use std::path::Path;

use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

use crate::phases::{GRAVITY_M_S2, STEP_S, Samples, replayed};
use crate::program::enact;

const RATE_HZ: f64 = 240.0;
/// Of the flight before the edge touches \[s\].
const FLIGHT_S: f64 = 0.15;
/// Of the rest at the end \[s\].
const REST_S: f64 = 0.4;

/// A cube that falls onto its left edge, with what it does then about the axis along y.
struct Rocking {
    /// Half of its side \[m\].
    half_m: f64,
    /// Where it touches: tilt \[rad\] and the velocities there.
    tilt_rad: f64,
    velocity_m_s: Vector3<f64>,
    spin_rad_s: f64,
    /// Tilts and the places of the edge that is touched, step by step from the touch on.
    rocks: Vec<(f64, f64, f64)>,
}

impl Rocking {
    fn drawn(random: &mut ChaCha8Rng) -> Self {
        loop {
            let mut of = Self {
                half_m: random.random_range(0.02..0.06),
                tilt_rad: random.random_range(0.15..0.4),
                velocity_m_s: Vector3::new(
                    random.random_range(-0.2..0.2),
                    0.0,
                    random.random_range(-1.6..-0.9),
                ),
                spin_rad_s: random.random_range(-2.0..2.0),
                rocks: Vec::new(),
            };
            if of.rock() {
                return of;
            }
        }
    }

    /// Vector from the left edge, or the right one, to the centre \[m\].
    fn arm_m(&self, tilt_rad: f64, side: f64) -> Vector3<f64> {
        let (sine, cosine) = tilt_rad.sin_cos();
        let [x, z] = [-side * self.half_m, self.half_m];
        Vector3::new(cosine * x - sine * z, 0.0, sine * x + cosine * z)
    }

    /// Fills the steps; whether it rocks to and fro, tilts little, and comes to rest.
    fn rock(&mut self) -> bool {
        let reach_m2 = 2.0 * self.half_m * self.half_m;
        let (mut tilt, mut side, mut edge_m) = (self.tilt_rad, -1.0, 0.0);
        let arm = self.arm_m(tilt, side);
        let moment = arm.x * self.velocity_m_s.z - arm.z * self.velocity_m_s.x;
        let mut rate = (reach_m2 / 3.0 * self.spin_rad_s + moment) / (4.0 / 3.0 * reach_m2);
        let most = 0.6;
        while self.rocks.len() < (2.0 / STEP_S) as usize {
            self.rocks.push((tilt, side, edge_m));
            rate -= STEP_S * 0.75 * GRAVITY_M_S2 * self.arm_m(tilt, side).x / reach_m2;
            tilt += STEP_S * rate;
            if tilt.abs() > most {
                return false;
            }
            // The other edge touches: tilts to the left are positive.
            if tilt * -side < 0.0 {
                (tilt, rate, side) = (0.0, 0.25 * rate, -side);
                edge_m += side * 2.0 * self.half_m;
                if rate.abs() < 0.02 {
                    self.rocks.push((0.0, side, edge_m));
                    return self.rocks.len() as f64 * STEP_S > 0.12;
                }
            }
        }
        false
    }

    fn rocks_s(&self) -> f64 {
        self.rocks.len() as f64 * STEP_S
    }

    fn pose(&self, time_s: f64) -> (Vector3<f64>, UnitQuaternion<f64>) {
        let since_s = time_s - FLIGHT_S;
        let (place_m, tilt) = if since_s < 0.0 {
            let fallen = -0.5 * GRAVITY_M_S2 * since_s * since_s * Vector3::z();
            let touched = self.arm_m(self.tilt_rad, -1.0);
            let tilt = self.tilt_rad + self.spin_rad_s * since_s;
            (touched + self.velocity_m_s * since_s + fallen, tilt)
        } else {
            let step = ((since_s / STEP_S) as usize).min(self.rocks.len() - 1);
            let (tilt, side, edge_m) = self.rocks[step];
            (self.arm_m(tilt, side) + Vector3::x() * edge_m, tilt)
        };
        let turn = UnitQuaternion::from_scaled_axis(Vector3::y() * -tilt);
        (place_m, turn)
    }

    /// Its samples; `lifted` adds to its height.
    fn seen(&self, random: &mut ChaCha8Rng, lifted: impl Fn(f64) -> f64) -> String {
        let mut samples = Samples::default();
        for sample in 0..=((FLIGHT_S + self.rocks_s() + REST_S) * RATE_HZ) as usize {
            let time_s = sample as f64 / RATE_HZ;
            let (place_m, turn) = self.pose(time_s);
            let place_m = place_m + Vector3::z() * lifted(time_s);
            samples.add(time_s, &place_m, &turn, random);
        }
        samples.csv
    }

    fn scene(&self, events: &str, phases: &str) -> String {
        let side_mm = 2e3 * self.half_m;
        format!(
            "name = \"tumbles\"\nhand = \"none\"\n[timing]\nstamps = \"physical\"\n\
             [[body]]\nname = \"die\"\nshape = {{ kind = \"cuboid\", size_mm = [{side_mm}, {side_mm}, {side_mm}] }}\nmass_g = 80\n\
             [[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
             [[event]]\nname = \"go\"\nkind = \"start\"\n{events}\
             [[event]]\nname = \"end\"\nkind = \"end\"\n{phases}"
        )
    }
}

fn change(name: &str) -> String {
    format!("[[event]]\nname = \"{name}\"\nkind = \"change\"\nbody = \"die\"\n")
}

fn tumble(from: &str, until: &str) -> String {
    format!(
        "[[phase]]\nname = \"tumbling\"\nmotion = \"tumble\"\nbody = \"die\"\nfrom = \"{from}\"\nuntil = \"{until}\"\n"
    )
}

/// A flight, a tumble and a rest.
fn whole(of: &Rocking) -> String {
    let rest = "[[phase]]\nname = \"resting\"\nmotion = \"rest\"\nbody = \"die\"\nsurface = \"table\"\n\
                feature = \"face -z\"\nfrom = \"still\"\nuntil = \"end\"\n";
    let phases = tumble("touches", "still") + rest;
    of.scene(&(change("touches") + &change("still")), &phases)
}

fn marks(of: &Rocking, off_s: f64) -> [(f64, &'static str); 4] {
    let still_s = FLIGHT_S + of.rocks_s();
    let end_s = still_s + REST_S - 0.01;
    [
        (0.0, "go"),
        (FLIGHT_S + off_s, "touches"),
        (still_s, "still"),
        (end_s, "end"),
    ]
}

fn doubts(said: &Value) -> Vec<&str> {
    let doubts = said["doubts"].as_array().expect("doubts").iter();
    doubts.filter_map(|of| of["quantity"].as_str()).collect()
}

#[test]
fn a_block_that_rocks_is_followed_from_its_flight_to_its_rest() {
    let folder = tempfile::tempdir().expect("a folder");
    for seed in 0..5 {
        let mut random = ChaCha8Rng::seed_from_u64(9700 + seed);
        let of = Rocking::drawn(&mut random);
        let csv = of.seen(&mut random, |_| 0.0);
        let off_s = random.random_range(-0.015..0.015);
        let said = replayed(folder.path(), &whole(&of), &csv, &marks(&of, off_s));
        assert_eq!(said["verdict"], "physical", "{seed}: {}", said["doubts"]);
        assert_eq!(said["fits"], "yes", "{seed}");
        let held = &said["held"][0];
        assert_eq!(held["motion"], "tumble");
        let note = said["fit_note"].as_str().expect("a note");
        assert!(note.contains("`die` tumbles for"), "{note}");
        let began_s = held["start_s"].as_f64().expect("a beginning");
        assert!((began_s - FLIGHT_S).abs() < 0.01, "{seed}: {began_s}");
        for flight in said["segments"].as_array().expect("segments") {
            let left_mm = flight["residual_mm"].as_f64().expect("a residual");
            assert!(left_mm < 1.0, "{seed}: {flight}");
        }
    }
}

#[test]
fn what_is_lifted_or_touches_nothing_does_not_tumble() {
    let folder = tempfile::tempdir().expect("a folder");
    for seed in 0..3 {
        let mut random = ChaCha8Rng::seed_from_u64(9710 + seed);
        let of = Rocking::drawn(&mut random);
        // A hand lifts it by more than it fell, and puts it back.
        let lifted = |time_s: f64| {
            let share = ((time_s - FLIGHT_S) / of.rocks_s()).clamp(0.0, 1.0);
            0.25 * (std::f64::consts::PI * share).sin().powi(4)
        };
        let csv = of.seen(&mut random, lifted);
        let said = replayed(folder.path(), &whole(&of), &csv, &marks(&of, 0.0));
        assert!(doubts(&said).contains(&"driven"), "{seed}: {said}");
        assert_ne!(said["verdict"], "physical");
        // It is caught in the air.
        let csv = of.seen(&mut random, |_| 0.3);
        let caught = of.scene(&change("touches"), &tumble("touches", "end"));
        let [go, touches, _, end] = marks(&of, 0.0);
        let said = replayed(folder.path(), &caught, &csv, &[go, touches, end]);
        assert!(doubts(&said).contains(&"untouched"), "{seed}: {said}");
        assert_ne!(said["verdict"], "physical");
    }
}

fn told(folder: &Path, command: &str) -> Value {
    let ran = enact(folder, &command.split(' ').collect::<Vec<_>>());
    let said = String::from_utf8_lossy(&ran.stderr);
    serde_json::from_slice(&ran.stdout).unwrap_or_else(|_| panic!("{command}: {said}"))
}

#[test]
fn a_tumble_and_a_rest_are_proposed_and_fit() {
    let folder = tempfile::tempdir().expect("a folder");
    for seed in 0..3 {
        let mut random = ChaCha8Rng::seed_from_u64(9720 + seed);
        let of = Rocking::drawn(&mut random);
        std::fs::write(folder.path().join("scene.toml"), of.scene("", "")).expect("a scene");
        let csv = of.seen(&mut random, |_| 0.0);
        std::fs::write(folder.path().join("poses.csv"), csv).expect("a table");
        let run = |command: &str| {
            let ran = enact(folder.path(), &command.split(' ').collect::<Vec<_>>());
            assert!(
                ran.status.success(),
                "{}",
                String::from_utf8_lossy(&ran.stderr)
            );
        };
        run("import poses.csv --scene scene.toml -o take.mcap");
        let found = told(folder.path(), "mark take.mcap --propose --format ndjson");
        let phases = found["phases"].as_array().expect("phases").iter();
        let motions: Vec<&str> = phases.filter_map(|of| of["motion"].as_str()).collect();
        assert_eq!(motions, ["tumble", "rest"], "{seed}: {found}");
        let pasted = found["scene_toml"].as_str().expect("a scene");
        std::fs::write(folder.path().join("pasted.toml"), pasted).expect("a scene");
        run("mark take.mcap --scene pasted.toml --propose -o marked.mcap");
        let said = told(
            folder.path(),
            "replay marked.mcap --scene pasted.toml --format ndjson",
        );
        assert_eq!(said["verdict"], "physical", "{seed}: {}", said["doubts"]);
        assert_eq!(said["fits"], "yes", "{seed}");
        for file in ["take.mcap", "marked.mcap"] {
            std::fs::remove_file(folder.path().join(file)).expect("a take");
        }
    }
}

#[test]
fn scenes_in_which_nothing_can_tumble_are_refused() {
    let mut random = ChaCha8Rng::seed_from_u64(9730);
    let of = Rocking::drawn(&mut random);
    let right = whole(&of);
    let refused = |scene: String, expected: &str| {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("scene.toml"), scene).expect("a scene");
        let ran = enact(folder.path(), &["scene", "check", "scene.toml"]);
        let said = String::from_utf8_lossy(&ran.stderr).into_owned();
        assert!(!ran.status.success() && said.contains(expected), "{said}");
    };
    refused(
        right.replace("\"physical\"", "\"tempo\""),
        "expected stamps = \"physical\"",
    );
    refused(
        right.replace("\"tumble\"\n", "\"tumble\"\nfriction = 0.2\n"),
        "friction is of what stays on a surface",
    );
    refused(
        of.scene("", &tumble("go", "end")),
        "is in the hand, or tumbles, from the start to the end",
    );
    let hit = "[[event]]\nname = \"touches\"\nkind = \"collision\"\nbody = \"die\"\nsurface = \"table\"\nrestitution = 0.3\n";
    refused(
        right.replace(&change("touches"), hit),
        "what a hand carries, or tumbles, begins and ends at changes",
    );
}
