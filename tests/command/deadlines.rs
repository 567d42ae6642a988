//! A deadline is a deadline: whatever a command works on, it ends soon after, with the best so far or with a word.

use std::fmt::Write as _;
use std::fs;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

/// What is given, and how much longer a busy machine may take with the tests' slow build.
const LIMIT: &str = "2s";
const SOON: Duration = Duration::from_secs(25);

/// Runs the program in a folder; what it says, once it ends by itself in time.
fn enact(folder: &TempDir, arguments: &[&str]) -> Output {
    let begun = Instant::now();
    let mut command = Command::new(env!("CARGO_BIN_EXE_enact"));
    command.current_dir(folder.path()).args(arguments);
    // Into files, which take whatever is said while nobody reads.
    let into = |name: &str| fs::File::create(folder.path().join(name)).expect("a file");
    command.stdin(Stdio::piped());
    command.stdout(into("stdout")).stderr(into("stderr"));
    let mut child = command.spawn().expect("it runs");
    // Held open, and never written to.
    let stdin = child.stdin.take();
    while child.try_wait().expect("a process").is_none() {
        if begun.elapsed() > SOON {
            child.kill().expect("killed");
            panic!("{arguments:?} does not end");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    drop(stdin);
    let of = |name: &str| fs::read(folder.path().join(name)).expect("a file");
    Output {
        status: child.wait().expect("its end"),
        stdout: of("stdout"),
        stderr: of("stderr"),
    }
}

fn said(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    text(&output.stdout) + &text(&output.stderr)
}

/// A ball that bounces so often, each flight seen once.
fn bounces(folder: &TempDir, count: usize) {
    const PERIOD_S: f64 = 0.002;
    let mut scene =
        "name = \"many\"\n[timing]\nstamps = \"physical\"\n[[body]]\nname = \"b\"\nmass_g = 10\n\
                     restitution = 0.9\nshape = { kind = \"cuboid\", size_mm = [20, 30, 40] }\n\
                     [[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n"
            .to_owned();
    let mut rows = "event,t_s,x_m,y_m,z_m,qw,qx,qy,qz\n".to_owned();
    for index in 0..count {
        let _ = write!(
            scene,
            "[[event]]\nname = \"e{index}\"\nkind = \"collision\"\nbody = \"b\"\nsurface = \"table\"\n\
             feature = \"corner +x +y -z\"\n"
        );
        let at_s = PERIOD_S * index as f64;
        let _ = writeln!(rows, ",{},{},0,0.8,1,0,0,0", at_s, 1e-4 * index as f64);
        let _ = writeln!(rows, "e{index},{},,,,,,,", at_s + 0.5 * PERIOD_S);
    }
    scene += "[[event]]\nname = \"landing\"\nkind = \"end\"\n";
    let last_s = PERIOD_S * count as f64;
    let _ = writeln!(rows, ",{last_s},0,0,0.8,1,0,0,0\nlanding,{last_s},,,,,,,");
    fs::write(folder.path().join("many.toml"), scene).expect("written");
    fs::write(folder.path().join("many.csv"), rows).expect("written");
    let made = [
        "sketch",
        "many.csv",
        "--scene",
        "many.toml",
        "-o",
        "many.mcap",
    ];
    let output = enact(folder, &made);
    assert!(output.status.success(), "{}", said(&output));
}

#[test]
fn many_collisions_end_in_time_whatever_estimates_them() {
    let folder = TempDir::new().expect("folder");
    bounces(&folder, 300);
    for arguments in [
        vec!["replay", "many.mcap", "-o", "o.mcap", "--deadline", LIMIT],
        vec!["process", "many.mcap", "-o", "out", "--deadline", LIMIT],
        vec![
            "sketch",
            "many.mcap",
            "--estimated",
            "-o",
            "k.csv",
            "--deadline",
            LIMIT,
        ],
    ] {
        let output = enact(&folder, &arguments);
        let code = output.status.code();
        assert!(
            matches!(code, Some(1 | 3)),
            "{arguments:?}: {}",
            said(&output)
        );
        // No half of anything stays.
        for entry in fs::read_dir(folder.path()).expect("list").flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            assert!(!name.starts_with('.'), "{arguments:?}: {name}");
        }
    }
}

#[test]
fn a_body_of_many_corners_is_verified_in_time_and_else_called_plausible() {
    let folder = TempDir::new().expect("folder");
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let corner = |index: usize| {
        let z = 1.0 - 2.0 * (index as f64 + 0.5) / 300.0;
        let (sin, cos) = (golden * index as f64).sin_cos();
        let across = (1.0 - z * z).sqrt();
        format!(
            "[{:.4}, {:.4}, {:.4}]",
            30.0 * across * cos,
            30.0 * across * sin,
            30.0 * z
        )
    };
    let corners: Vec<String> = (0..300).map(corner).collect();
    let scene = format!(
        "name = \"hull\"\ngravity_m_s2 = [0, -9.80665, 0]\n[timing]\nstamps = \"physical\"\n[[body]]\nname = \"b\"\nmass_g = 10\n\
         moments_kg_m2 = [3.6e-6, 3.6e-6, 3.6e-6]\nshape = {{ kind = \"hull\", points_mm = [{}] }}\n\
         [[surface]]\nname = \"table\"\npoint_mm = [0, 0, 20]\nnormal = [0, 0, 1]\n\
         [[event]]\nname = \"landing\"\nkind = \"end\"\n",
        corners.join(", ")
    );
    fs::write(folder.path().join("hull.toml"), scene).expect("written");
    // It flies along the table and in it, so that every look is one into it: this scene's gravity is sideways.
    let mut rows = "t_s,x_m,y_m,z_m,qw,qx,qy,qz,event\n".to_owned();
    for index in 0..=50 {
        let t_s = f64::from(index) * 0.01;
        let fallen_m = 0.5 * 9.80665 * t_s * t_s;
        let _ = writeln!(rows, "{t_s},{},{},0.03,1,0,0,0,", 0.1 * t_s, -fallen_m);
    }
    rows += "0.5,,,,,,,,landing\n";
    fs::write(folder.path().join("hull.csv"), rows).expect("written");
    let made = [
        "sketch",
        "hull.csv",
        "--scene",
        "hull.toml",
        "-o",
        "hull.mcap",
    ];
    let output = enact(&folder, &made);
    assert!(output.status.success(), "{}", said(&output));
    for limit in ["300ms", LIMIT] {
        let arguments = ["replay", "hull.mcap", "-o", "o.mcap", "--deadline", limit];
        let output = enact(&folder, &arguments);
        let said = said(&output);
        assert_ne!(output.status.code(), Some(0), "{said}");
        let first = said.lines().next().unwrap_or_default();
        assert!(!first.contains("physical"), "{said}");
    }
}

#[test]
fn a_stdin_that_says_nothing_is_not_waited_for() {
    let folder = TempDir::new().expect("folder");
    for arguments in [
        vec!["replay", "-", "-o", "o.mcap", "--deadline", "200ms"],
        vec!["predict", "-", "-o", "o.mcap", "--deadline", "200ms"],
        vec!["inspect", "-", "--deadline", "200ms"],
        vec!["import", "-", "-o", "o.mcap", "--deadline", "200ms"],
    ] {
        let output = enact(&folder, &arguments);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        let said = said(&output);
        assert!(said.contains("give it more by --deadline"), "{said}");
    }
}

/// What a scene costs to read goes with its length: so many events are looked at in no time.
#[test]
fn a_scene_of_many_events_is_checked_in_time() {
    let folder = TempDir::new().expect("folder");
    let mut scene =
        "name = \"many\"\n[timing]\nstamps = \"physical\"\n[[body]]\nname = \"b\"\nmass_g = 10\n\
                     restitution = 0.9\nshape = { kind = \"sphere\", radius_mm = 10 }\n\
                     [[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n"
            .to_owned();
    for index in 0..50_000 {
        let _ = write!(
            scene,
            "[[event]]\nname = \"e{index}\"\nkind = \"collision\"\nbody = \"b\"\nsurface = \"table\"\n"
        );
    }
    fs::write(folder.path().join("many.toml"), scene).expect("written");
    let output = enact(&folder, &["scene", "check", "many.toml"]);
    assert_eq!(output.status.code(), Some(0));
}
