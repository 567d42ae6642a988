//! What reports and tables say of collisions is what the bodies of the motion do: momentum and angular momentum are from its
//! flights, masses from its scene.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use enact::config::scene_from_toml;
use enact::motion::{LinkIndex, Scene};
use enact::wire::Container;
use enact::write::export::scene_of_estimate;
use enact_tools::replay::Program;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde_json::Value;
use tempfile::TempDir;

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));

fn vector(of: &Value) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| of[axis].as_f64().expect("a number"))
}

fn number(of: &Value) -> f64 {
    of.as_f64().unwrap_or_else(|| panic!("a number: {of}"))
}

/// A flight of a body by itself without drag: where it is, how fast, and its angular momentum, which stays \[world\].
struct Flight {
    spans_s: [f64; 2],
    epoch_s: f64,
    position_m: Vector3<f64>,
    velocity_m_s: Vector3<f64>,
    turn: UnitQuaternion<f64>,
    spin_rad_s: Vector3<f64>,
    angular_momentum: Vector3<f64>,
}

impl Flight {
    fn of(scene: &Scene, arc: &Value) -> Self {
        let link = link(scene, &arc["body"]);
        let of_link = &scene.links[link];
        let [w, i, j, k] = [0, 1, 2, 3].map(|at| number(&arc["orientation_wxyz"][at]));
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
        // Axes of the scene's body, and those of its principal moments.
        let given_from_link = of_link.link_from_given.rotation.inverse();
        let spin = vector(&arc["angular_velocity_body_rad_s"]);
        let of_axes = given_from_link.inverse() * spin;
        let momentum = of_link.body.moments_kg_m2().component_mul(&of_axes);
        Self {
            spans_s: [number(&arc["start_s"]), number(&arc["end_s"])],
            epoch_s: number(&arc["epoch_s"]),
            position_m: vector(&arc["position_m"]),
            velocity_m_s: vector(&arc["velocity_m_s"]),
            turn,
            spin_rad_s: turn * spin,
            angular_momentum: turn * given_from_link * momentum,
        }
    }

    fn place_m(&self, gravity: &Vector3<f64>, time_s: f64) -> Vector3<f64> {
        let since_s = time_s - self.epoch_s;
        self.position_m + self.velocity_m_s * since_s + gravity * (0.5 * since_s * since_s)
    }

    fn speed_m_s(&self, gravity: &Vector3<f64>, time_s: f64) -> Vector3<f64> {
        self.velocity_m_s + gravity * (time_s - self.epoch_s)
    }
}

fn link(scene: &Scene, name: &Value) -> LinkIndex {
    let mut links = scene.links.iter_enumerated();
    let found = links.find(|(_, of)| of.name.as_str() == name.as_str().expect("a name"));
    found.expect("a body of the scene").0
}

/// A recording's estimate, what its report says, and its scene.
struct Estimated {
    folder: TempDir,
    said: Value,
    scene: Scene,
}

impl Estimated {
    fn of(recording: &str) -> Self {
        let folder = TempDir::new().expect("a folder");
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("recordings");
        let copy = folder.path().join("x.mcap");
        fs::copy(root.join(recording), &copy).expect("copy");
        let replayed = ENACT.report(&copy, &[]);
        let container = Container::new(fs::read(&replayed.output).expect("read")).expect("MCAP");
        let mut report = None;
        let mut walk = container.walk();
        while let Some(message) = walk.next_message() {
            if container.channels()[&message.channel_id].topic == "/estimate/report" {
                report = Some(serde_json::from_slice::<Value>(message.data).expect("JSON"));
            }
        }
        let said = report.expect("a report");
        assert_eq!(said["events"], replayed.said["events"]);
        let text = String::from_utf8(scene_of_estimate(&container).expect("it").to_vec());
        fs::rename(&replayed.output, folder.path().join("x.estimate.mcap")).expect("rename");
        Self {
            folder,
            said,
            scene: scene_from_toml(&text.expect("UTF-8")).expect("a scene"),
        }
    }

    fn flights(&self, body: &Value) -> Vec<Flight> {
        let arcs = self.said["arcs"].as_array().expect("arcs").iter();
        let own = arcs.filter(|arc| arc["body"] == *body);
        own.map(|arc| Flight::of(&self.scene, arc)).collect()
    }

    fn exported(&self, to: &str, name: &str, options: &[&str]) -> String {
        let mut command = Command::new(ENACT.0);
        command.current_dir(self.folder.path());
        command.args(["export", "x.estimate.mcap", "--to", to, "-o", name]);
        let ran = command.args(options).output().expect("it runs");
        // A motion that is not physical is exported all the same.
        let is_done = matches!(ran.status.code(), Some(0 | 3));
        assert!(is_done, "{ran:?}");
        fs::read_to_string(self.folder.path().join(name)).expect("the export")
    }
}

/// Rows of a table by the names of its columns.
fn rows(csv: &str) -> Vec<BTreeMap<String, String>> {
    let mut lines = csv.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let rows = lines.map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), header.len(), "{line}");
        let both = header.iter().zip(cells);
        both.map(|(name, cell)| ((*name).to_owned(), cell.to_owned()))
            .collect()
    });
    rows.collect()
}

/// What a collision gives each body, and how fast its points of contact come and go.
fn assert_balance(of: &Estimated, event: &Value) {
    let (time_s, gravity) = (number(&event["time_s"]), vector(&of.said["gravity_m_s2"]));
    let impacts = event["impacts"].as_array().expect("impacts");
    assert_eq!(impacts.len(), 1, "{event}");
    let impact = &impacts[0];
    let (point_m, normal) = (vector(&impact["point_m"]), vector(&impact["normal"]));
    let impulse = vector(&impact["impulse_n_s"]);
    let size = number(&impact["impulse_size_n_s"]);
    assert!(
        (size - impulse.norm()).abs() < 1e-12 && size > 1e-4,
        "{impact}"
    );
    let mut points_m_s = [Vector3::zeros(); 2];
    for (sign, body) in [1.0, -1.0]
        .iter()
        .zip(event["bodies"].as_array().expect("bodies"))
    {
        let mass_kg = of.scene.links[link(&of.scene, body)].body.mass_kg();
        let flights = of.flights(body);
        let find = |at: usize| flights.iter().find(|flight| flight.spans_s[at] == time_s);
        let (before, after) = (find(1).expect("it arrives"), find(0).expect("it leaves"));
        let gained = |of: fn(&Flight, &Vector3<f64>, f64) -> Vector3<f64>| {
            of(after, &gravity, time_s) - of(before, &gravity, time_s)
        };
        let momentum = gained(Flight::speed_m_s) * mass_kg;
        let off = (momentum - impulse * *sign).norm() / size;
        assert!(off < 1e-6, "{body} {event}: {off}");
        let centre_m = before.place_m(&gravity, time_s);
        let turned = after.angular_momentum - before.angular_momentum;
        let expected = (point_m - centre_m).cross(&impulse) * *sign;
        let off = (turned - expected).norm() / turned.norm().max(1e-3 * size);
        assert!(off < 1e-5, "{body} {event}: {off}");
        // Where a flight begins or ends at its epoch its spin there is what the report says.
        for (at, flight) in [before, after].into_iter().enumerate() {
            let spin = match flight.epoch_s == time_s {
                true => flight.spin_rad_s,
                false => spun(of, body, flight, time_s),
            };
            let arm_m = point_m - centre_m;
            let speed = flight.speed_m_s(&gravity, time_s) + spin.cross(&arm_m);
            points_m_s[at] += speed * *sign;
        }
    }
    let [before, after] = points_m_s;
    let across = |of: Vector3<f64>| (of - normal * normal.dot(&of)).norm();
    for (told, expected) in [
        ("approach_m_s", -normal.dot(&before)),
        ("slip_m_s", across(before)),
        ("parting_m_s", normal.dot(&after)),
        ("slip_after_m_s", across(after)),
    ] {
        let off = (number(&impact[told]) - expected).abs();
        assert!(off < 1e-4, "{told} {event}: {off}");
    }
    assert!(number(&impact["approach_m_s"]) > 0.0);
    assert!((normal.norm() - 1.0).abs() < 1e-12);
    assert_eq!(vector(&impact["moment_n_m_s"]), Vector3::zeros());
}

/// The angular velocity at a time \[world\], by steps of the free rotation with a constant angular momentum.
fn spun(of: &Estimated, body: &Value, flight: &Flight, time_s: f64) -> Vector3<f64> {
    const STEPS: usize = 20_000;
    let link = &of.scene.links[link(&of.scene, body)];
    let moments = link.body.moments_kg_m2();
    let mut turn = flight.turn * link.link_from_given.rotation.inverse();
    let step_s = (time_s - flight.epoch_s) / STEPS as f64;
    let spin = |turn: &UnitQuaternion<f64>| {
        let in_body = turn.inverse() * flight.angular_momentum;
        turn * in_body.component_div(&moments)
    };
    for _ in 0..STEPS {
        let half = UnitQuaternion::from_scaled_axis(spin(&turn) * (0.5 * step_s)) * turn;
        turn = UnitQuaternion::from_scaled_axis(spin(&half) * step_s) * turn;
    }
    spin(&turn)
}

#[test]
fn impulses_are_what_bodies_gain() {
    let mut collisions = 0;
    for recording in ["pencil_tip.mcap", "pencil_eraser.mcap", "hat_box.mcap"] {
        let of = Estimated::of(recording);
        for event in of.said["events"].as_array().expect("events") {
            match event["kind"].as_str() {
                Some("collision") => {
                    assert_balance(&of, event);
                    collisions += 1;
                }
                _ => assert_eq!(event["impacts"], serde_json::json!([])),
            }
        }
    }
    assert!(collisions >= 4, "{collisions}");
}

#[test]
fn the_table_of_events_says_what_the_report_says() {
    let of = Estimated::of("hat_box.mcap");
    let table = rows(&of.exported("events", "x.events.csv", &[]));
    let events = of.said["events"].as_array().expect("events");
    assert_eq!(table.len(), events.len());
    for (row, event) in table.iter().zip(events) {
        assert_eq!(row["event"], event["name"].as_str().expect("a name"));
        assert_eq!(row["kind"], event["kind"].as_str().expect("a kind"));
        let cell = |name: &str| row[name].parse::<f64>().expect("a number");
        assert_eq!(cell("t_s"), number(&event["time_s"]));
        let Some(impact) = event["impacts"].get(0) else {
            assert_eq!(
                (row["impulse_n_s"].as_str(), row["body"].as_str()),
                ("", "")
            );
            continue;
        };
        assert_eq!(row["body"], event["bodies"][0].as_str().expect("a body"));
        assert_eq!(
            row["other"],
            event["bodies"]
                .get(1)
                .map_or("", |of| of.as_str().expect("it"))
        );
        assert_eq!(
            row["contact"],
            impact["contact"].as_str().expect("a contact")
        );
        for (column, pointer) in [
            ("x_m", "/point_m/0"),
            ("z_m", "/point_m/2"),
            ("nz", "/normal/2"),
            ("approach_m_s", "/approach_m_s"),
            ("slip_m_s", "/slip_m_s"),
            ("parting_m_s", "/parting_m_s"),
            ("slip_after_m_s", "/slip_after_m_s"),
            ("jx_n_s", "/impulse_n_s/0"),
            ("jz_n_s", "/impulse_n_s/2"),
            ("impulse_n_s", "/impulse_size_n_s"),
            ("mz_n_m_s", "/moment_n_m_s/2"),
        ] {
            assert_eq!(
                cell(column),
                number(impact.pointer(pointer).expect(pointer))
            );
        }
    }
}
