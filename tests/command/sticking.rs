//! Two bodies that fly, meet and are one: the truth is their balance of momentum and free rotations in small steps, by whole
//! tensors of inertia in place of principal axes.

use std::fmt::Write;
use std::path::Path;

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use serde_json::Value;

use crate::phases::{GRAVITY_M_S2, replayed};
use crate::program::enact;

const RATE_HZ: f64 = 240.0;
const STEP_S: f64 = 1e-4;

/// A body in flight: its angular momentum about its centre of mass stays as it is.
#[derive(Clone, Copy)]
struct Flying {
    mass_kg: f64,
    /// Tensor of inertia in its axes.
    inertia: Matrix3<f64>,
    place_m: Vector3<f64>,
    turn: UnitQuaternion<f64>,
    velocity_m_s: Vector3<f64>,
    turning: Vector3<f64>,
}

impl Flying {
    fn spin_rad_s(&self) -> Vector3<f64> {
        let inverse = self.inertia.try_inverse().expect("a tensor");
        self.turn * (inverse * (self.turn.inverse() * self.turning))
    }

    fn with_spin(mut self, spin_rad_s: Vector3<f64>) -> Self {
        self.turning = self.turn * (self.inertia * (self.turn.inverse() * spin_rad_s));
        self
    }

    fn after(mut self, duration_s: f64) -> Self {
        let steps = (duration_s.abs() / STEP_S).ceil().max(1.0);
        let h = duration_s / steps;
        for _ in 0..steps as usize {
            let turn = self.turn;
            self.turn = UnitQuaternion::from_scaled_axis(self.spin_rad_s() * (0.5 * h)) * turn;
            self.turn = UnitQuaternion::from_scaled_axis(self.spin_rad_s() * h) * turn;
        }
        let fall = Vector3::z() * -GRAVITY_M_S2;
        self.place_m += self.velocity_m_s * duration_s + fall * (0.5 * duration_s * duration_s);
        self.velocity_m_s += fall * duration_s;
        self
    }

    /// Both as one, in axes that are those of the world where they meet.
    fn with(&self, other: &Self) -> Self {
        let mass_kg = self.mass_kg + other.mass_kg;
        let mean = |one: Vector3<f64>, two: Vector3<f64>| {
            (one * self.mass_kg + two * other.mass_kg) / mass_kg
        };
        let place_m = mean(self.place_m, other.place_m);
        let mut both = Self {
            mass_kg,
            inertia: Matrix3::zeros(),
            place_m,
            turn: UnitQuaternion::identity(),
            velocity_m_s: mean(self.velocity_m_s, other.velocity_m_s),
            turning: Vector3::zeros(),
        };
        for of in [self, other] {
            let arm = of.place_m - place_m;
            let axes = of.turn.to_rotation_matrix();
            both.inertia += axes.matrix() * of.inertia * axes.matrix().transpose();
            let square = Matrix3::identity() * arm.norm_squared() - arm * arm.transpose();
            both.inertia += square * of.mass_kg;
            both.turning += of.turning + arm.cross(&of.velocity_m_s) * of.mass_kg;
        }
        both
    }
}

/// A block and a dart, as they are where they meet.
struct Meeting {
    bodies: [Flying; 2],
    shapes: [String; 2],
    hit_s: f64,
    end_s: f64,
}

impl Meeting {
    fn drawn(random: &mut ChaCha8Rng, speeds_m_s: [f64; 2]) -> Self {
        let mut within = |most: f64| Vector3::from_fn(|_, _| random.random_range(-most..most));
        let turns = [within(3.0), within(0.4)];
        let (side, slow) = (within(1.0), within(1.0));
        let (spin, dart_spin, off) = (within(5.0), within(3.0), within(0.02));
        let size_m = Vector3::from_fn(|_, _| random.random_range(0.06..0.2));
        let length_m = random.random_range(0.1..0.6);
        let radius_m = random.random_range(0.004..0.03);
        let masses_kg = [
            random.random_range(0.08..0.4),
            random.random_range(0.03..0.3),
        ];
        let squares = size_m.component_mul(&size_m) * (masses_kg[0] / 12.0);
        let block = Vector3::new(
            squares.y + squares.z,
            squares.z + squares.x,
            squares.x + squares.y,
        );
        let across_m2 = radius_m * radius_m / 4.0 + length_m * length_m / 12.0;
        let dart = Vector3::new(across_m2, across_m2, radius_m * radius_m / 2.0) * masses_kg[1];
        let way = side.normalize();
        let place_m = Vector3::new(0.2, -0.1, 1.3);
        let block = Flying {
            mass_kg: masses_kg[0],
            inertia: Matrix3::from_diagonal(&block),
            place_m,
            turn: UnitQuaternion::from_scaled_axis(turns[0]),
            velocity_m_s: slow + Vector3::z(),
            turning: Vector3::zeros(),
        };
        let block = block.with_spin(spin);
        let along = UnitQuaternion::rotation_between(&Vector3::z(), &way).unwrap_or_default();
        let [least, most] = speeds_m_s;
        let speed_m_s = random.random_range(least..most);
        let dart = Flying {
            mass_kg: masses_kg[1],
            inertia: Matrix3::from_diagonal(&dart),
            place_m: place_m - way * (0.5 * length_m + 0.4 * size_m.min()) + off,
            turn: along * UnitQuaternion::from_scaled_axis(turns[1]),
            velocity_m_s: block.velocity_m_s + way * speed_m_s + dart_spin * 0.1,
            turning: Vector3::zeros(),
        };
        let shape = format!(
            "{{ kind = \"cuboid\", size_mm = [{}, {}, {}] }}",
            size_m.x * 1e3,
            size_m.y * 1e3,
            size_m.z * 1e3
        );
        let dart_shape = format!(
            "{{ kind = \"cylinder\", length_mm = {}, radius_mm = {} }}",
            length_m * 1e3,
            radius_m * 1e3
        );
        let hit_s = random.random_range(0.25..0.45);
        Self {
            bodies: [block, dart.with_spin(dart_spin)],
            shapes: [shape, dart_shape],
            hit_s,
            end_s: hit_s + random.random_range(0.3..0.5),
        }
    }

    /// Both at a time.
    fn at(&self, time_s: f64) -> [Flying; 2] {
        let since_s = time_s - self.hit_s;
        if since_s <= 0.0 {
            return self.bodies.map(|of| of.after(since_s));
        }
        let [one, other] = &self.bodies;
        let whole = one.with(other);
        let then = whole.after(since_s);
        self.bodies.map(|of| {
            let arm = then.turn * (of.place_m - whole.place_m);
            Flying {
                place_m: then.place_m + arm,
                turn: then.turn * of.turn,
                velocity_m_s: then.velocity_m_s + then.spin_rad_s().cross(&arm),
                ..of
            }
        })
    }

    /// What trackers see, of hands that stray by so much.
    fn seen(&self, strays: [f64; 2], random: &mut ChaCha8Rng) -> String {
        let noise = Normal::new(0.0, 1.0).expect("a deviation");
        let mut csv = "body,t,x,y,z,qw,qx,qy,qz\n".to_owned();
        let mut waves = || -> Vec<(Vector3<f64>, f64, f64)> {
            let wave = |_| {
                let size = Vector3::from_fn(|_, _| noise.sample(random) * 0.5_f64.sqrt());
                (
                    size,
                    random.random_range(1.0..9.0),
                    random.random_range(0.0..6.0),
                )
            };
            (0..4).map(wave).collect()
        };
        let hands = [[waves(), waves()], [waves(), waves()]];
        let off = |waves: &[(Vector3<f64>, f64, f64)], time_s: f64| -> Vector3<f64> {
            let each = waves.iter();
            each.map(|(size, rate, from)| size * (rate * time_s + from).sin())
                .sum()
        };
        for sample in 0..=(self.end_s * RATE_HZ) as usize {
            let time_s = sample as f64 / RATE_HZ;
            for ((of, name), hand) in self.at(time_s).iter().zip(NAMES).zip(&hands) {
                let mut noisy = |sd: f64| Vector3::from_fn(|_, _| sd * noise.sample(random));
                let place_m = of.place_m + noisy(1e-3) + off(&hand[0], time_s) * strays[0];
                let turned = noisy(0.3_f64.to_radians()) + off(&hand[1], time_s) * strays[1];
                let turn = of.turn * UnitQuaternion::from_scaled_axis(turned);
                let [i, j, k, one]: [f64; 4] = turn.coords.into();
                let _ = writeln!(
                    csv,
                    "{name},{time_s:.6},{},{},{},{one},{i},{j},{k}",
                    place_m.x, place_m.y, place_m.z
                );
            }
        }
        csv
    }

    fn scene(&self, hand: &str, factor: f64) -> String {
        let [block_g, dart_g] = [0, 1].map(|side: usize| self.bodies[side].mass_kg * 1e3);
        format!(
            "name = \"stuck\"\nhand = \"{hand}\"\n[timing]\nstamps = \"physical\"\n\
             [[body]]\nname = \"block\"\nshape = {}\nmass_g = {block_g}\n\
             [[body]]\nname = \"dart\"\nshape = {}\nmass_g = {}\n\
             [[event]]\nname = \"go\"\nkind = \"start\"\n\
             [[event]]\nname = \"hit\"\nkind = \"change\"\nbody = \"dart\"\n\
             [[event]]\nname = \"end\"\nkind = \"end\"\n\
             [[joint]]\nname = \"stuck\"\nkind = \"fixed\"\nparent = \"block\"\nchild = \"dart\"\nfrom = \"hit\"\n",
            self.shapes[0],
            self.shapes[1],
            dart_g * factor
        )
    }

    fn answer(&self, folder: &Path, scene: &str, csv: &str, off_s: f64) -> Value {
        let marks = [
            (0.0, "go"),
            (self.hit_s + off_s, "hit"),
            (self.end_s - 0.01, "end"),
        ];
        replayed(folder, scene, csv, &marks)
    }
}

const NAMES: [&str; 2] = ["block", "dart"];

/// When they met, and with which deviation.
fn hit(said: &Value) -> Option<(f64, f64)> {
    let events = said["events"].as_array().expect("events");
    let event = events.iter().find(|event| event["name"] == "hit")?;
    Some((event["time_s"].as_f64()?, event["time_sd_s"].as_f64()?))
}

/// Centre and orientation of a body.
type PoseOf = (Vector3<f64>, UnitQuaternion<f64>);

/// The exported poses of both at the same times after an event.
fn exported(folder: &Path, from_s: f64) -> Vec<(f64, [PoseOf; 2])> {
    let ran = enact(
        folder,
        &["export", "take.estimate.mcap", "--to", "csv", "-o", "x.csv"],
    );
    assert!(
        ran.status.success(),
        "{}",
        String::from_utf8_lossy(&ran.stderr)
    );
    let text = std::fs::read_to_string(folder.join("x.csv")).expect("a table");
    let mut rows = text.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<&str> = rows.next().expect("a header").split(',').collect();
    let column = |name: &str| header.iter().position(|of| *of == name).expect("a column");
    let mut found = std::collections::BTreeMap::<i64, [Option<_>; 2]>::new();
    for row in rows {
        let cells: Vec<&str> = row.split(',').collect();
        let number = |name: &str| cells[column(name)].parse::<f64>().expect("a number");
        let place_m = Vector3::new(number("x_m"), number("y_m"), number("z_m"));
        let turn =
            nalgebra::Quaternion::new(number("qw"), number("qx"), number("qy"), number("qz"));
        let at = (number("t_s") * 1e9).round() as i64;
        let side = NAMES.iter().position(|name| *name == cells[column("body")]);
        found.entry(at).or_default()[side.expect("a body")] =
            Some((place_m, UnitQuaternion::new_normalize(turn)));
    }
    let both = found.into_iter().filter_map(|(at, [one, other])| {
        let time_s = at as f64 * 1e-9;
        (time_s >= from_s).then_some((time_s, [one?, other?]))
    });
    both.collect()
}

/// Asserts that both go on as one to the end, where they are as in the truth.
fn assert_one(folder: &Path, meeting: &Meeting, hit_s: f64) {
    let poses = exported(folder, hit_s + 1e-6);
    assert!(poses.len() >= 6, "{}", poses.len());
    let between = |of: &[PoseOf; 2]| {
        let back = of[0].1.inverse();
        (back * (of[1].0 - of[0].0), back * of[1].1)
    };
    let first = between(&poses[0].1);
    for (time_s, both) in &poses {
        let now = between(both);
        assert!(
            (now.0 - first.0).norm() < 1e-5,
            "{time_s}: {} {}",
            now.0,
            first.0
        );
        assert!(now.1.angle_to(&first.1) < 1e-4, "{time_s}");
    }
    let (last_s, last) = poses[poses.len() - 1];
    assert!(last_s > meeting.end_s - 0.02, "{last_s}");
    for (told, truth) in last.iter().zip(meeting.at(last_s)) {
        let off_m = (told.0 - truth.place_m).norm();
        assert!(
            off_m < 2e-3 && told.1.angle_to(&truth.turn) < 0.02,
            "{off_m}"
        );
    }
    // Velocities, by the way over a while.
    let (from_s, from) = poses[0];
    let (to_s, to) = *poses
        .iter()
        .find(|(time_s, _)| *time_s > from_s + 0.1)
        .expect("it goes on");
    let (truth_from, truth_to) = (meeting.at(from_s.max(meeting.hit_s)), meeting.at(to_s));
    for side in 0..2 {
        let way_m = to[side].0 - from[side].0;
        let truth_m = truth_to[side].place_m - truth_from[side].place_m;
        let off_m_s = (way_m - truth_m).norm() / (to_s - from_s);
        assert!(off_m_s < 0.02, "{off_m_s}");
    }
}

#[test]
fn when_a_dart_sticks_in_a_block_is_told() {
    let (mut told, mut fitting, mut count) = (0, 0, 0);
    for seed in 0..30 {
        let mut random = ChaCha8Rng::seed_from_u64(9700 + seed);
        let meeting = Meeting::drawn(&mut random, [2.0, 8.0]);
        let csv = meeting.seen([0.0; 2], &mut random);
        let off_s = random.random_range(-0.02..0.02);
        let folder = tempfile::tempdir().expect("a folder");
        let said = meeting.answer(folder.path(), &meeting.scene("none", 1.0), &csv, off_s);
        assert_eq!(said["verdict"], "physical", "{seed}: {said}");
        fitting += usize::from(said["fits"] == "yes");
        let (time_s, sd_s) = hit(&said).expect("a time");
        let off_s = (time_s - meeting.hit_s).abs();
        count += 1;
        told += usize::from(off_s < 0.01 && off_s < 3.0 * sd_s + 2e-5);
        if seed < 6 {
            assert_one(folder.path(), &meeting, time_s);
        }
    }
    assert!(told * 100 >= count * 95, "{told} of {count}");
    assert!(fitting * 100 >= count * 95, "{fitting} of {count}");
}

#[test]
fn hands_that_stray_leave_it_told() {
    let (mut told, mut near, mut count) = (0, 0, 0);
    for seed in 0..10 {
        let mut random = ChaCha8Rng::seed_from_u64(9800 + seed);
        let meeting = Meeting::drawn(&mut random, [1.5, 4.0]);
        let csv = meeting.seen([0.008, 0.03], &mut random);
        let folder = tempfile::tempdir().expect("a folder");
        let said = meeting.answer(folder.path(), &meeting.scene("acted", 1.0), &csv, 0.01);
        let found = hit(&said);
        assert_ne!(said["verdict"], "failed", "{seed}: {said}");
        let Some((time_s, sd_s)) = found else {
            continue;
        };
        let off_s = (time_s - meeting.hit_s).abs();
        count += 1;
        near += usize::from(off_s < 0.02);
        told += usize::from(off_s < 3.0 * sd_s + 2e-5);
    }
    assert!(
        count >= 9 && near >= 8 && told >= 8,
        "{near}, {told} of {count}"
    );
}

#[test]
fn a_mass_that_is_wrong_does_not_fit() {
    for seed in 0..6 {
        let mut random = ChaCha8Rng::seed_from_u64(9900 + seed);
        let meeting = Meeting::drawn(&mut random, [3.0, 8.0]);
        let csv = meeting.seen([0.0; 2], &mut random);
        let folder = tempfile::tempdir().expect("a folder");
        for factor in [3.0, 1.0 / 3.0] {
            let scene = meeting.scene("none", factor);
            let said = meeting.answer(folder.path(), &scene, &csv, 0.0);
            let is_well = said["verdict"] == "physical" && said["fits"] == "yes";
            assert!(!is_well, "{seed} × {factor}: {said}");
        }
    }
}

#[test]
fn what_hits_without_rebound_is_said_to_stick() {
    let mut random = ChaCha8Rng::seed_from_u64(9950);
    let meeting = Meeting::drawn(&mut random, [3.0, 6.0]);
    let csv = meeting.seen([0.0; 2], &mut random);
    let scene = meeting.scene("none", 1.0);
    let scene = &scene[..scene.find("[[joint]]").expect("the joint")];
    let scene = scene.replace(
        "kind = \"change\"\nbody = \"dart\"",
        "kind = \"collision\"\nbody = \"dart\"\nother = \"block\"\nrestitution = 0\nfriction = 10",
    );
    let folder = tempfile::tempdir().expect("a folder");
    let said = meeting.answer(folder.path(), &scene, &csv, 0.0);
    let hint = &said["diagnoses"][0];
    assert_eq!(hint["cause"], "stuck_together", "{said}");
    let value = hint["value"].as_str().expect("a joint");
    assert!(
        value.contains("parent = \"block\", child = \"dart\", from = \"hit\""),
        "{value}"
    );
}
