//! What `enact export` writes is the motion of the estimate: read back with a reader of its own.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use enact::motion::Stamp;
use enact::wire::{Container, PoseFormat};
use enact_tools::replay::Program;
use serde_json::Value;
use tempfile::TempDir;

mod others;

mod glb;

use glb::{Glb, assert_well_made, at};

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));

/// Poses by their stamps \[ns\]: places, and quaternions with w last.
type Poses = BTreeMap<i64, ([f64; 3], [f64; 4])>;

/// A recording's estimate, made once for each test.
struct Made {
    folder: TempDir,
    estimate: PathBuf,
    report: Value,
}

impl Made {
    fn of(recording: &str) -> Self {
        let folder = TempDir::new().expect("folder");
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("recordings");
        let copy = folder.path().join(recording);
        fs::copy(root.join(recording), &copy).expect("copy");
        let replayed = ENACT.report(&copy, &[]);
        assert_eq!(replayed.said["verdict"], "physical", "{}", replayed.said);
        Self {
            estimate: replayed.output,
            report: replayed.said,
            folder,
        }
    }

    fn exported(&self, name: &str, options: &[&str]) -> Vec<u8> {
        let output = self.folder.path().join(name);
        let estimate = self.estimate.to_str().expect("UTF-8");
        let to = output.to_str().expect("UTF-8");
        let ran = enact(&[&["export", estimate, "-o", to][..], options].concat());
        assert!(ran.status.success(), "{ran:?}");
        fs::read(output).expect("the export")
    }

    fn poses(&self, topic: &str) -> Poses {
        let bytes = fs::read(&self.estimate).expect("read");
        let container = Container::new(bytes).expect("MCAP");
        let mut poses = Poses::new();
        let mut walk = container.walk();
        while let Some(message) = walk.next_message() {
            let channel = &container.channels()[&message.channel_id];
            if channel.topic != topic {
                continue;
            }
            let schema = container.schema_of(channel).expect("a schema");
            let format = PoseFormat::of(&schema.name, &channel.message_encoding);
            let mut found = Vec::new();
            let format = format.expect("poses");
            format.decode(message.data, &mut found).expect("a pose");
            let sample = found[0].sample(Stamp(0));
            let place = sample.position_m.into();
            poses.insert(sample.stamp.0, (place, sample.quaternion_xyzw));
        }
        assert!(poses.len() > 20, "{topic}");
        poses
    }
}

fn enact(arguments: &[&str]) -> Output {
    let mut command = Command::new(ENACT.0);
    command.args(arguments).output().expect("it runs")
}

/// What is simulated is on the line between the poses of the recording that are next to it.
fn assert_between(
    poses: &Poses,
    time_s: f64,
    since_s: impl Fn(&i64) -> f64,
    (place, turn): (&[f32], &[f32]),
) {
    let before = poses
        .iter()
        .rfind(|(stamp, _)| since_s(stamp) <= time_s + 1e-6);
    let after = poses
        .iter()
        .find(|(stamp, _)| since_s(stamp) >= time_s - 1e-6);
    let ((from, a), (to, b)) = (before.expect("a pose"), after.expect("a pose"));
    let length_s = (since_s(to) - since_s(from)).max(1e-9);
    let share = ((time_s - since_s(from)) / length_s).clamp(0.0, 1.0);
    let line = |a: &[f64], b: &[f64], sign: f64| -> Vec<f64> {
        let both = a.iter().zip(b);
        both.map(|(a, b)| a + share * (sign * b - a)).collect()
    };
    let off = |line: Vec<f64>, read: &[f32], sign: f64| {
        let both = line.iter().zip(read);
        both.map(|(a, b)| (a - sign * f64::from(*b)).abs())
            .fold(0.0, f64::max)
    };
    let off_m = off(line(&a.0, &b.0, 1.0), place, 1.0);
    let dot: f64 = a.1.iter().zip(&b.1).map(|(a, b)| a * b).sum();
    let turned = line(&a.1, &b.1, dot.signum());
    let off_turn = off(turned.clone(), turn, 1.0).min(off(turned, turn, -1.0));
    assert!(
        off_m < 1e-5 && off_turn < 2e-3,
        "{time_s} s: {off_m} {off_turn}"
    );
}

/// Keys of a node are poses of the recording, to the last bit of single precision, up to where the motion is
/// simulated, and are there at its first and last; quaternions go on in sign. Returns the times of the keys,
/// physical.
fn assert_keys(glb: &Glb, name: &str, poses: &Poses, simulated_from_s: f64) -> Vec<f64> {
    let extras = &glb.json["asset"]["extras"];
    let zero_ns = extras["physical_zero_ns"].as_i64().expect("a stamp");
    let before_s = extras["physical_zero_s"].as_f64().expect("a time");
    let (times, places, turns) = glb.keys(name);
    assert!(times[0] >= 0.0 && times.windows(2).all(|pair| pair[0] < pair[1]));
    assert!(times.len() == places.len() && times.len() == turns.len());
    let since_s = |stamp: &i64| (stamp - zero_ns) as f64 * 1e-9 + before_s;
    for ((time_s, place), turn) in times.iter().zip(&places).zip(&turns) {
        let near = poses
            .iter()
            .filter(|(stamp, _)| (since_s(stamp) - f64::from(*time_s)).abs() < 1e-6);
        let is_same = near.clone().any(|(_, (position_m, quaternion))| {
            let quaternion = quaternion.map(|of| of as f32);
            let negative = quaternion.map(|of| -of);
            position_m.map(|of| of as f32)[..] == place[..]
                && [quaternion, negative].iter().any(|of| of[..] == turn[..])
        });
        if f64::from(*time_s) - before_s > simulated_from_s + 1e-6 {
            assert_between(poses, f64::from(*time_s), since_s, (place, turn));
        } else {
            assert!(is_same, "{name} at {time_s} s: {place:?} {turn:?}");
        }
    }
    for pair in turns.windows(2) {
        let dot: f32 = pair[0].iter().zip(&pair[1]).map(|(a, b)| a * b).sum();
        assert!(dot >= 0.0, "{name}: {pair:?}");
    }
    let ends =
        [poses.keys().next(), poses.keys().next_back()].map(|of| since_s(of.expect("a pose")));
    let found = [times[0], times[times.len() - 1]].map(f64::from);
    for (end, found) in ends.iter().zip(found) {
        assert!((end - found).abs() < 1e-6, "{name}: {end} {found}");
    }
    times.iter().map(|of| f64::from(*of) - before_s).collect()
}

#[test]
fn a_pencils_glb_has_its_poses_at_frames_and_impacts_and_its_ghost() {
    let made = Made::of("pencil_tip.mcap");
    let file = made.exported("x.glb", &["--to", "glb", "--ghost"]);
    let glb = Glb::read(&file);
    let poses = made.poses("/estimate/pencil/pose");
    let simulated_from_s = made.report["settled"]["from_s"].as_f64();
    let simulated_from_s = simulated_from_s.expect("what follows is simulated");
    let times_s = assert_keys(&glb, "pencil", &poses, simulated_from_s);
    let last_s = times_s[times_s.len() - 1];
    for frame in 0..=(last_s * 24.0) as usize {
        let frame_s = frame as f64 / 24.0;
        assert!(
            times_s.iter().any(|of| (of - frame_s).abs() < 1e-6),
            "{frame}"
        );
    }
    let events = made.report["events"].as_array().expect("events");
    assert_eq!(events.len(), 2);
    for event in events {
        let event_s = event["time_s"].as_f64().expect("a time");
        assert!(
            times_s.iter().any(|of| (of - event_s).abs() < 1e-6),
            "{event}"
        );
    }
    assert_keys(
        &glb,
        "pencil acted",
        &made.poses("/sketch/pencil/pose"),
        f64::INFINITY,
    );
    assert_well_made(&glb);
    // The ghost has the body's surface, seen through.
    let mesh = |name: &str| {
        let mut meshes = glb.json["meshes"].as_array().expect("meshes").iter();
        let mesh = meshes.find(|mesh| mesh["name"] == name).expect("a mesh");
        let part = &mesh["primitives"][0];
        let material = &glb.json["materials"][at(&part["material"])];
        (part["attributes"].clone(), material["alphaMode"].clone())
    };
    let (body, ghost) = (mesh("pencil"), mesh("pencil acted"));
    assert_eq!((body.0, body.1), (ghost.0, Value::Null));
    assert_eq!(ghost.1, "BLEND");
    let over = &glb.json["nodes"][0];
    let quarter = f64::from(std::f32::consts::FRAC_1_SQRT_2);
    assert_eq!(
        over["rotation"],
        serde_json::json!([-quarter, 0.0, 0.0, quarter])
    );
    let below = over["children"].as_array().expect("children").len();
    assert_eq!(
        below + 1,
        glb.json["nodes"].as_array().expect("nodes").len()
    );
    let asset = &glb.json["asset"];
    let version = concat!("enact ", env!("CARGO_PKG_VERSION"));
    assert_eq!(asset["generator"], version);
    let command = asset["extras"]["command"].as_str().expect("a command");
    assert!(command.starts_with("enact export ") && command.ends_with("--to glb --ghost"));
    let digits = asset["extras"]["scene_sha256"].as_str().expect("a hash");
    assert!(digits.len() == 64 && digits.chars().all(|c| c.is_ascii_hexdigit()));
    assert_eq!(file, made.exported("x.glb", &["--to", "glb", "--ghost"]));
}

#[test]
fn every_link_of_a_chain_is_where_its_poses_are() {
    let made = Made::of("chain.mcap");
    let glb = Glb::read(&made.exported("x.glb", &["--to", "glb", "--fps", "60"]));
    let nodes = glb.json["nodes"].as_array().expect("nodes");
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("config/chain.toml"));
    let scene = enact::config::scene_from_toml(&text.expect("a scene")).expect("a scene");
    assert!(scene.links.len() > 2);
    for link in &scene.links {
        assert!(nodes.iter().any(|node| node["name"] == link.name.as_str()));
        let topic = format!("/estimate/{}/pose", link.name);
        assert_keys(&glb, &link.name, &made.poses(&topic), f64::INFINITY);
    }
    assert_well_made(&glb);
    // Trajectories, one for each.
    made.exported_many(
        &scene
            .links
            .iter()
            .map(|link| link.name.as_str())
            .collect::<Vec<_>>(),
    );
}

impl Made {
    fn exported_many(&self, names: &[&str]) {
        let output = self.folder.path().join("way.tum");
        let (from, to) = (self.estimate.to_str(), output.to_str());
        let arguments = [
            "export",
            from.expect("UTF-8"),
            "--to",
            "tum",
            "-o",
            to.expect("UTF-8"),
        ];
        let ran = enact(&arguments);
        assert!(ran.status.success(), "{ran:?}");
        assert!(!output.exists());
        for name in names {
            let text = fs::read_to_string(self.folder.path().join(format!("way.{name}.tum")));
            let poses = self.poses(&format!("/estimate/{name}/pose"));
            let text = text.expect("a trajectory");
            let mut rows = 0;
            for line in text.lines().filter(|line| !line.starts_with('#')) {
                let cells: Vec<&str> = line.split(' ').collect();
                let (seconds, nanoseconds) = cells[0].split_once('.').expect("a time");
                let stamp: i64 = format!("{seconds}{nanoseconds:0<9}")
                    .parse()
                    .expect("a stamp");
                let (place, [x, y, z, w]) = &poses[&stamp];
                let read: Vec<f64> = cells[1..]
                    .iter()
                    .map(|of| of.parse().expect("number"))
                    .collect();
                assert_eq!(&read[..3], place);
                let dot = read[3] * x + read[4] * y + read[5] * z + read[6] * w;
                assert!((dot.abs() - 1.0).abs() < 1e-12, "{line}");
                rows += 1;
            }
            assert!(rows > 20, "{name}");
        }
    }
}

#[test]
fn a_table_has_the_poses_by_frame_and_goes_through_a_pipe() {
    let made = Made::of("pencil_tip.mcap");
    let text = made.exported("x.csv", &["--to", "csv", "--ghost"]);
    let text = String::from_utf8(text).expect("UTF-8");
    let mut lines = text.lines();
    let comment = lines.next().expect("a comment");
    assert!(
        comment.starts_with("# enact ") && comment.contains("SHA-256"),
        "{comment}"
    );
    let from = lines.next().expect("a comment");
    assert!(
        from.starts_with("# estimated by enact ") && from.contains("from \"pencil_tip.mcap\""),
        "{from}"
    );
    let header = "t_s,stamp_ns,body,motion,event,x_m,y_m,z_m,qw,qx,qy,qz,sd_x_m,sd_y_m,sd_z_m,\
        sd_turn_x_rad,sd_turn_y_rad,sd_turn_z_rad,sd_vx_m_s,sd_vy_m_s,sd_vz_m_s,sd_wx_rad_s,sd_wy_rad_s,sd_wz_rad_s";
    assert_eq!(lines.next(), Some(header));
    let (estimate, acted) = (
        made.poses("/estimate/pencil/pose"),
        made.poses("/sketch/pencil/pose"),
    );
    let (mut events, mut acted_rows, mut simulated_rows) = (Vec::new(), 0, 0);
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let stamp: i64 = cells[1].parse().expect("a stamp");
        assert_eq!(cells[2], "pencil");
        let poses = match cells[3] {
            "acted" => {
                acted_rows += 1;
                &acted
            }
            "simulated" => {
                // Between poses of the recording, as in the other test.
                simulated_rows += 1;
                continue;
            }
            other => {
                assert_eq!(other, "estimate");
                &estimate
            }
        };
        let read: Vec<f64> = cells[5..12]
            .iter()
            .map(|of| of.parse().expect("number"))
            .collect();
        let (place, [x, y, z, w]) = &poses[&stamp];
        assert_eq!(&read[..3], place, "{line}");
        let dot = read[3] * w + read[4] * x + read[5] * y + read[6] * z;
        assert!((dot.abs() - 1.0).abs() < 1e-12, "{line}");
        if !cells[4].is_empty() {
            events.push(cells[4].to_owned());
        }
    }
    assert_eq!(events, ["bounce", "landing"]);
    assert_eq!(acted_rows, acted.len());
    assert!(simulated_rows > 10, "{simulated_rows}");
    let estimate = made.estimate.to_str().expect("UTF-8");
    let piped = enact(&["export", estimate, "--to", "csv", "--ghost", "-o", "-"]);
    assert!(
        piped.status.success() && piped.stderr.is_empty(),
        "{piped:?}"
    );
    let piped = String::from_utf8(piped.stdout).expect("UTF-8");
    // All but the comment, which has the command.
    assert_eq!(
        piped.split_once('\n').map(|of| of.1),
        text.split_once('\n').map(|of| of.1)
    );
}

#[test]
fn what_cannot_be_exported_is_said_and_leaves_no_file() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("recordings/pencil_tip.mcap");
    let recording = root.to_str().expect("UTF-8");
    let folder = TempDir::new().expect("folder");
    let output = folder.path().join("x.glb");
    let output = output.to_str().expect("UTF-8");
    let made = Made::of("pencil_tip.mcap");
    let estimate = made.estimate.to_str().expect("UTF-8");
    let no_such = folder.path().join("none.mcap");
    let no_such = no_such.to_str().expect("UTF-8");
    let cases: [(&[&str], i32, &str); 6] = [
        (
            &[recording, "--to", "glb", "-o", output],
            1,
            "has no estimate, expected what `enact replay`",
        ),
        (&[no_such, "--to", "glb", "-o", output], 1, "cannot read"),
        (
            &[estimate, "--to", "glb", "-o", "/dev/null"],
            1,
            "is a device",
        ),
        (
            &[estimate, "--to", "glb", "-o", estimate],
            1,
            "expected another name",
        ),
        (
            &[estimate, "--to", "glb", "--fps", "1e9", "-o", output],
            1,
            "frame rate 1000000000 Hz",
        ),
        (&[estimate, "-o", output], 2, "--to"),
    ];
    for (arguments, code, words) in cases {
        let ran = enact(&[&["export"][..], arguments].concat());
        let said = String::from_utf8_lossy(&ran.stderr);
        assert_eq!(ran.status.code(), Some(code), "{arguments:?}: {said}");
        assert!(said.contains(words), "{arguments:?}: {said}");
    }
    assert_eq!(fs::read_dir(folder.path()).expect("list").count(), 0);
}
