//! What an import says and takes together: several files, marks of a file, a scene's timing, and how long it takes.

use std::fs;

use super::{Bench, RATE_HZ, SCENE, rows, truth};

/// A table of the drop, with its lengths in a unit of so many metres and times that go so many times as slowly.
fn drop_csv(unit_m: f64, slower: f64) -> String {
    let rows = rows(|index, of| {
        let ([qx, qy, qz, qw], p) = (of.quaternion_xyzw, of.position_m / unit_m);
        let time_s = index as f64 / RATE_HZ * slower;
        format!("{time_s:.6},{},{},{},{qx},{qy},{qz},{qw}", p.x, p.y, p.z)
    });
    format!("t,x,y,z,qx,qy,qz,qw\n{rows}")
}

#[test]
fn a_motion_acted_slowly_tells_no_unit() {
    // A tenth of gravity in millimetres is gravity in centimetres.
    let bench = Bench::new(&[("slow.csv", &drop_csv(1e-3, 10.0_f64.sqrt()))]);
    fs::write(
        bench.path("tempo.toml"),
        SCENE.replace("\"physical\"", "\"tempo\""),
    )
    .unwrap();
    let arguments = ["import", "slow.csv", "-o", "x.mcap", "--scene"];
    let ran = bench.enact(&[&arguments[..], &["tempo.toml"]].concat());
    assert_eq!(ran.code, Some(3), "{}", ran.stdout);
    assert!(!ran.stdout.contains("centimetres, not"), "{}", ran.stdout);
    assert!(
        ran.stdout.contains("is it --length-unit mm?"),
        "{}",
        ran.stdout
    );
    let ran = bench.enact(&[&arguments[..], &["tempo.toml", "--length-unit", "mm"]].concat());
    assert_eq!(ran.code, Some(0), "{}", ran.stdout);
    // Without a scene it is said that this may be.
    let ran = bench.enact(&["import", "slow.csv", "-o", "x.mcap"]);
    assert!(ran.stdout.contains("acted slower"), "{}", ran.stdout);
}

#[test]
fn what_accelerates_sideways_tells_no_unit() {
    // On a rig, at 371 units a second squared along x.
    let text = rows(|index, _| {
        let s = index as f64 / RATE_HZ;
        format!("{s:.3},{:.3},1,1725", 185.8 * s * s)
    });
    let bench = Bench::new(&[("rig.csv", &format!("t,x_mm,y_mm,z_mm\n{text}"))]);
    let ran = bench.enact(&["import", "rig.csv", "-o", "x.mcap"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stdout);
    let bare = format!("t,x,y,z\n{text}");
    fs::write(bench.path("rig.csv"), bare).unwrap();
    let ran = bench.enact(&["import", "rig.csv", "-o", "x.mcap"]);
    assert!(!ran.stdout.contains("inches"), "{}", ran.stdout);
}

#[test]
fn files_that_count_frames_have_one_zero() {
    let of_frames = |from: usize| {
        let all = rows(|index, of| {
            let ([qx, qy, qz, qw], p) = (of.quaternion_xyzw, of.position_m);
            format!("{},{},{},{},{qx},{qy},{qz},{qw}", index + 1, p.x, p.y, p.z)
        });
        let left: Vec<&str> = all.lines().skip(from).collect();
        format!("frame,x,y,z,qx,qy,qz,qw\n{}\n", left.join("\n"))
    };
    let bench = Bench::new(&[("a.csv", &of_frames(0)), ("b.csv", &of_frames(49))]);
    let json = bench.json(&["import", "a.csv", "b.csv", "--rate", "200", "-o", "x.mcap"]);
    assert_eq!(json["bodies"][1]["poses"], 62);
    let spans = |json: &serde_json::Value| {
        [
            &json["bodies"][0]["duration_s"],
            &json["bodies"][1]["duration_s"],
        ]
        .map(|of| of.as_f64().unwrap())
    };
    assert!(
        (spans(&json)[0] - 0.55).abs() < 1e-9 && (spans(&json)[1] - 0.305).abs() < 1e-9,
        "{json}"
    );
    // The second begins with its 50th frame: what is cut there is the same in both.
    let json = bench.json(&[
        "import", "a.csv", "b.csv", "--rate", "200", "--end", "0.2451", "-o", "x.mcap",
    ]);
    assert_eq!(
        (&json["bodies"][0]["poses"], &json["bodies"][1]["poses"]),
        (&50.into(), &1.into()),
        "{json}"
    );
    // A clock of another day is none that they have together.
    let later = drop_csv(1.0, 1.0).replace("\n0.", "\n1000.");
    fs::write(bench.path("c.csv"), later).unwrap();
    fs::write(bench.path("d.csv"), drop_csv(1.0, 1.0)).unwrap();
    let ran = bench.enact(&["import", "c.csv", "d.csv", "-o", "x.mcap"]);
    assert_eq!(ran.code, Some(3), "{}", ran.stdout);
    assert!(
        ran.stdout.contains("are their clocks different?"),
        "{}",
        ran.stdout
    );
}

#[test]
fn events_of_a_file_are_marks_and_bodies_that_the_scene_has_not_are_left_out() {
    let rows = rows(|index, of| {
        let p = of.position_m * 1e3;
        format!(
            "{}\t{:.5}\t{}\t{}\t{}\t1\t1\t1\t",
            index + 1,
            index as f64 / RATE_HZ,
            p.x,
            p.y,
            p.z
        )
    });
    let text = format!(
        "NO_OF_FRAMES\t111\nFREQUENCY\t200\nDATA_INCLUDED\t3D\nEVENT\tbounce\t64\t0.315\nEVENT\tclap\t3\t0.01\nMARKER_NAMES\tball\trig\n\
         Frame\tTime\tball X\tball Y\tball Z\trig X\trig Y\trig Z\t\n{rows}"
    );
    let bench = Bench::new(&[("take.tsv", &text)]);
    let features = "features_mm = { south = [0, 0, -20] }\n";
    let track = "[[body.track]]\ntopic = \"/ball\"\nsees = \"point\"\npoint = \"centre\"\n";
    fs::write(
        bench.path("points.toml"),
        SCENE.replace(features, &format!("{features}{track}")),
    )
    .unwrap();
    let json = bench.json(&[
        "import",
        "take.tsv",
        "--scene",
        "points.toml",
        "-o",
        "x.mcap",
    ]);
    assert_eq!(
        (&json["marks"], json["bodies"].as_array().unwrap().len()),
        (&1.into(), 1),
        "{json}"
    );
    assert_eq!(json["against"].as_array().unwrap().len(), 0, "{json}");
    let said = json["warnings"].to_string();
    for piece in [
        "no bodies of these names (--topic NAME=TOPIC takes them): rig",
        "\\\"clap\\\" is left out",
        "axes and units agree",
    ] {
        assert!(said.contains(piece), "{piece}: {said}");
    }
    let listed = bench.json(&["inspect", "x.mcap"]);
    assert_eq!(listed["marks"][0]["event"], "bounce", "{listed}");
    assert!(
        (listed["marks"][0]["time_s"].as_f64().unwrap() - 0.315).abs() < 1e-9,
        "{listed}"
    );
    // By hand goes before.
    let json = bench.json(&[
        "import",
        "take.tsv",
        "--scene",
        "points.toml",
        "-o",
        "x.mcap",
        "--mark",
        "0.31:bounce",
    ]);
    assert_eq!(json["marks"], 1, "{json}");
}

#[test]
fn rows_that_go_back_are_said_before_they_are_sorted() {
    let one = drop_csv(1.0, 1.0);
    let (head, rows) = one.split_once('\n').unwrap();
    let bench = Bench::new(&[("log.csv", &format!("{head}\n{rows}{rows}"))]);
    let ran = bench.enact(&["import", "log.csv", "-o", "x.mcap"]);
    assert_eq!(ran.code, Some(3), "{}", ran.stdout);
    assert!(
        ran.stdout
            .contains("times go back by 0.550 s at line 113: two takes"),
        "{}",
        ran.stdout
    );
}

#[test]
fn held_poses_are_counted_and_said() {
    let mut held = String::new();
    let one = drop_csv(1.0, 1.0);
    let mut pose = "";
    for (index, line) in one.lines().enumerate() {
        let Some((time, cells)) = line.split_once(',').filter(|_| index > 0) else {
            held += &format!("{line}\n");
            continue;
        };
        if index % 4 == 1 {
            pose = cells;
        }
        held += &format!("{time},{pose}\n");
    }
    let bench = Bench::new(&[("held.csv", &held)]);
    let ran = bench.enact(&["import", "held.csv", "-o", "x.mcap"]);
    assert_eq!(ran.code, Some(3), "{}", ran.stdout);
    assert!(
        ran.stdout
            .contains("83 of 111 poses are exactly the one before, up to 3 in a row"),
        "{}",
        ran.stdout
    );
}

#[test]
fn many_rows_take_time_in_proportion() {
    let one = truth();
    let mut text = String::from("t,x,y,z,qx,qy,qz,qw\n");
    for row in 0..30_000_usize {
        let of = &one[row % one.len()];
        let ([qx, qy, qz, qw], p) = (of.quaternion_xyzw, of.position_m);
        let wobble = 1e-4 * (12.9 * row as f64).sin();
        let time_s = row as f64 / RATE_HZ;
        text += &format!(
            "{time_s:.3},{:.6},{:.6},{:.6},{qx:.6},{qy:.6},{qz:.6},{qw:.6}\n",
            p.x + wobble,
            p.y,
            p.z - wobble
        );
    }
    let bench = Bench::new(&[("long.csv", &text)]);
    let began = std::time::Instant::now();
    let json = bench.json(&["import", "long.csv", "-o", "x.mcap"]);
    let took_s = began.elapsed().as_secs_f64();
    assert_eq!(json["bodies"][0]["poses"], 30_000);
    assert!(
        json["bodies"][0]["flights"].as_array().unwrap().len() > 240,
        "{took_s}"
    );
    // Of a program without optimisation, on a machine that does other work as well; a search that is cubic takes hours.
    assert!(took_s < 60.0, "{took_s} s");
}

#[test]
fn texts_of_other_encodings_are_read_and_packed_files_are_refused_with_a_way_on() {
    let plain = drop_csv(1.0, 1.0);
    let bench = Bench::new(&[("ball.csv", &plain)]);
    let utf16: Vec<u8> = plain.encode_utf16().flat_map(u16::to_le_bytes).collect();
    fs::write(
        bench.path("utf16.csv"),
        [&[0xff, 0xfe][..], &utf16].concat(),
    )
    .unwrap();
    let named = plain.lines().map(|line| match line.starts_with('t') {
        true => format!("{line},Winkel [°]\n"),
        false => format!("{line},0\n"),
    });
    let latin: Vec<u8> = named
        .collect::<String>()
        .chars()
        .map(|of| of as u8)
        .collect();
    fs::write(bench.path("latin.csv"), &latin).unwrap();
    let ran = bench.enact(&["import", "latin.csv", "-o", "x.mcap"]);
    assert_eq!(ran.code, Some(0), "{}{}", ran.stdout, ran.stderr);
    assert!(ran.stdout.contains("Latin-1"), "{}", ran.stdout);
    let ran = bench.enact(&["import", "utf16.csv", "-o", "x.mcap"]);
    assert_eq!(ran.code, Some(0), "{}{}", ran.stdout, ran.stderr);
    assert!(ran.stdout.contains("UTF-16"), "{}", ran.stdout);
    for (name, begins, next) in [
        ("take.csv.gz", &b"\x1f\x8b\x08\x00"[..], "gunzip -c"),
        ("take.xlsx", b"PK\x03\x04", "save the sheet as CSV"),
        ("take.h5", b"\x89HDF\r\n", "to_csv"),
        ("take.json", b"{\"frames\": []}", "a line per pose"),
    ] {
        fs::write(bench.path(name), begins).unwrap();
        let ran = bench.enact(&["import", name, "-o", "y.mcap"]);
        assert_eq!(ran.code, Some(1), "{name}");
        assert!(ran.stderr.contains(next), "{name}: {}", ran.stderr);
    }
}
