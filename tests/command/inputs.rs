//! Inputs are never changed: whatever output is asked for of whatever command, no file that it reads is written.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use assert_cmd::cargo::cargo_bin;
use tempfile::TempDir;

/// Words of a command, in which `OUT` stands for the output, and the inputs among them.
const COMMANDS: &[(&str, &[&str])] = &[
    (
        "replay take.mcap --scene scene.toml -o OUT",
        &["take.mcap", "scene.toml"],
    ),
    (
        "replay take.mcap --scene scene.toml --publish --iceoryx2 iceoryx2.toml -o OUT",
        &["take.mcap", "scene.toml", "iceoryx2.toml"],
    ),
    (
        "predict take.mcap --scene scene.toml -o OUT",
        &["take.mcap", "scene.toml"],
    ),
    (
        "sketch keys.csv --scene scene.toml -o OUT",
        &["keys.csv", "scene.toml"],
    ),
    (
        "sketch take.mcap --scene scene.toml -o OUT",
        &["take.mcap", "scene.toml"],
    ),
    (
        "mark take.mcap --scene scene.toml --remove all --from marks.csv -o OUT",
        &["take.mcap", "scene.toml", "marks.csv"],
    ),
    (
        "mark take.mcap --scene scene.toml --propose -o OUT",
        &["take.mcap", "scene.toml"],
    ),
    (
        "import poses.csv more.csv --scene scene.toml -o OUT",
        &["poses.csv", "more.csv", "scene.toml"],
    ),
    (
        "import take.mcap --scene scene.toml -o OUT",
        &["take.mcap", "scene.toml"],
    ),
    ("export estimate.mcap --to csv -o OUT", &["estimate.mcap"]),
    (
        "export estimate.mcap --to events -o OUT",
        &["estimate.mcap"],
    ),
    ("export estimate.mcap --to bvh -o OUT", &["estimate.mcap"]),
    ("export estimate.mcap --to tum -o OUT", &["estimate.mcap"]),
    ("report estimate.mcap -o OUT", &["estimate.mcap"]),
    ("report estimate.mcap --svg OUT", &["estimate.mcap"]),
    (
        "calibrate pivot take.mcap --scene scene.toml -o OUT",
        &["take.mcap", "scene.toml"],
    ),
    (
        "calibrate plane take.mcap --scene scene.toml --tip tip.toml -o OUT",
        &["take.mcap", "scene.toml", "tip.toml"],
    ),
    (
        "calibrate gravity take.mcap --scene scene.toml -o OUT",
        &["take.mcap", "scene.toml"],
    ),
    (
        "scene calibrated scene.toml tip.toml -o OUT",
        &["scene.toml", "tip.toml"],
    ),
    ("scene from-urdf arm.urdf -o OUT", &["arm.urdf"]),
    (
        "scene new solid.obj --unit mm --mass-g 100 --lands +z -o OUT",
        &["solid.obj"],
    ),
];

struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        let bench = Self(TempDir::new().expect("a folder"));
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let recording = fs::read(root.join("recordings/pencil_tip.mcap")).expect("a recording");
        let scene = fs::read(root.join("config/pencil_tip.toml")).expect("a scene");
        fs::write(bench.path("take.mcap"), &recording).expect("write");
        fs::write(bench.path("scene.toml"), &scene).expect("write");
        for name in [
            "keys.csv",
            "marks.csv",
            "poses.csv",
            "more.csv",
            "tip.toml",
            "arm.urdf",
            "solid.obj",
            "iceoryx2.toml",
        ] {
            fs::write(bench.path(name), format!("this is {name}")).expect("write");
        }
        let replayed = bench.enact("replay take.mcap -o estimate.mcap", Stdio::null());
        assert_eq!(replayed.status.code(), Some(0));
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn enact(&self, words: &str, stdin: Stdio) -> Output {
        let mut command = Command::new(cargo_bin("enact"));
        command.args(words.split(' ')).current_dir(self.0.path());
        command.stdin(stdin).output().expect("it runs")
    }

    /// Everything that is in the folder, but links.
    fn files(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let entries = fs::read_dir(self.0.path()).expect("list");
        let paths = entries.map(|entry| entry.expect("an entry").path());
        let files = paths.filter(|path| fs::symlink_metadata(path).is_ok_and(|of| of.is_file()));
        files
            .map(|path| (path.clone(), fs::read(&path).expect("read")))
            .collect()
    }

    /// The command fails with the reason that is expected, and nothing has changed.
    fn refuses(&self, words: &str, stdin: Stdio) {
        let before = self.files();
        let ran = self.enact(words, stdin);
        let said = String::from_utf8_lossy(&ran.stderr);
        assert_eq!(ran.status.code(), Some(1), "{words}: {said}");
        // Scenes and calibrations replace nothing at all.
        let reasons = ["would replace an input", "is there already"];
        // A sketch is told by the ending of its name, before anything else.
        let endings = "expected a name that ends in .csv or .toml";
        let is_told = reasons.iter().any(|reason| said.contains(reason))
            || words.starts_with("sketch") && said.contains(endings);
        assert!(is_told, "{words}: {said}");
        assert!(self.files() == before, "{words} changed a file");
    }
}

#[test]
fn no_command_writes_what_it_reads() {
    let bench = Bench::new();
    for (words, inputs) in COMMANDS {
        for input in *inputs {
            let inside = bench.path(input);
            for output in [
                (*input).to_owned(),
                format!("./{input}"),
                inside.display().to_string(),
            ] {
                bench.refuses(&words.replace("OUT", &output), Stdio::null());
            }
        }
    }
}

#[cfg(unix)]
#[test]
fn no_command_writes_what_it_reads_through_a_link() {
    let bench = Bench::new();
    let (folder, _) = (bench.path("folder"), ());
    std::os::unix::fs::symlink(bench.0.path(), &folder).expect("a link");
    for (words, inputs) in COMMANDS {
        for input in *inputs {
            // The ending stays: it tells what a sketch is.
            let ending = Path::new(input).extension().expect("an ending");
            let link = format!("link.{}", ending.to_string_lossy());
            let _ = fs::remove_file(bench.path(&link));
            std::os::unix::fs::symlink(bench.path(input), bench.path(&link)).expect("a link");
            for output in [link.clone(), format!("folder/{input}")] {
                bench.refuses(&words.replace("OUT", &output), Stdio::null());
            }
            // And where the input is read through the link.
            let through = words.replace("OUT", input).replacen(input, &link, 1);
            bench.refuses(&through, Stdio::null());
            fs::remove_file(bench.path(&link)).expect("remove the link");
        }
    }
}

#[cfg(unix)]
#[test]
fn the_file_behind_stdin_is_not_written() {
    let bench = Bench::new();
    for (words, file) in [
        ("replay - --scene scene.toml -o take.mcap", "take.mcap"),
        ("import - --scene scene.toml -o poses.csv", "poses.csv"),
        ("mark - --propose -o take.mcap", "take.mcap"),
        ("export - --to csv -o estimate.mcap", "estimate.mcap"),
    ] {
        let stdin = fs::File::open(bench.path(file)).expect("open");
        bench.refuses(words, stdin.into());
    }
}

#[test]
fn the_estimates_of_a_folder_replace_no_scene() {
    let bench = Bench::new();
    // The scene bears the name that the estimate would have.
    fs::create_dir(bench.path("out")).expect("a folder");
    fs::copy(
        bench.path("scene.toml"),
        bench.path("out/take.estimate.mcap"),
    )
    .expect("copy");
    let before = fs::read(bench.path("out/take.estimate.mcap")).expect("read");
    bench.refuses(
        "process take.mcap --scene out/take.estimate.mcap -o out",
        Stdio::null(),
    );
    assert!(fs::read(bench.path("out/take.estimate.mcap")).expect("read") == before);
}

#[cfg(unix)]
fn mode(path: &Path) -> u32 {
    use std::os::unix::fs::PermissionsExt;
    fs::metadata(path).expect("there").permissions().mode() & 0o777
}

#[cfg(unix)]
fn allow(path: &Path, mode: u32) {
    use std::os::unix::fs::PermissionsExt;
    fs::set_permissions(path, fs::Permissions::from_mode(mode)).expect("permissions");
}

#[cfg(unix)]
#[test]
fn an_output_is_as_private_as_what_it_is_made_of() {
    let bench = Bench::new();
    fs::write(bench.path("plain"), "").expect("write");
    let usual = mode(&bench.path("plain"));
    let made = |words: &str, output: &str| {
        let _ = fs::remove_file(bench.path(output));
        let ran = bench.enact(words, Stdio::null());
        let said = String::from_utf8_lossy(&ran.stderr);
        assert!(matches!(ran.status.code(), Some(0 | 3)), "{words}: {said}");
        mode(&bench.path(output))
    };
    let csv = "t,x,y,z,qx,qy,qz,qw\n0,0,0,1,0,0,0,1\n0.01,0,0,1.1,0,0,0,1\n0.02,0,0,1.2,0,0,0,1\n";
    fs::write(bench.path("poses.csv"), csv).expect("write");
    let commands = [
        ("replay take.mcap -o x.mcap", "take.mcap", "x.mcap"),
        (
            "replay take.mcap --scene scene.toml -o x.mcap",
            "scene.toml",
            "x.mcap",
        ),
        (
            "mark take.mcap --remove all -o x.mcap",
            "take.mcap",
            "x.mcap",
        ),
        ("import take.mcap -o x.mcap", "take.mcap", "x.mcap"),
        ("import poses.csv -o x.mcap", "poses.csv", "x.mcap"),
        ("sketch take.mcap -o x.csv", "take.mcap", "x.csv"),
        (
            "export estimate.mcap --to csv -o x.csv",
            "estimate.mcap",
            "x.csv",
        ),
        ("report estimate.mcap -o x.html", "estimate.mcap", "x.html"),
    ];
    for (words, input, output) in commands {
        assert_eq!(made(words, output), usual, "{words}");
        let before = mode(&bench.path(input));
        allow(&bench.path(input), 0o600);
        assert_eq!(made(words, output), 0o600, "{words}");
        allow(&bench.path(input), before);
    }
    // What is replaced keeps who may read it.
    for kept in [0o600, 0o640] {
        fs::write(bench.path("x.mcap"), "old").expect("write");
        allow(&bench.path("x.mcap"), kept);
        let ran = bench.enact("replay take.mcap -o x.mcap", Stdio::null());
        assert_eq!(ran.status.code(), Some(0));
        assert_eq!(mode(&bench.path("x.mcap")), kept);
    }
}

#[test]
fn what_is_written_names_files_and_no_folders() {
    let bench = Bench::new();
    let folder = bench.0.path().display().to_string();
    let inside = |name: &str| bench.path(name).display().to_string();
    for (words, output) in [
        (
            format!("replay {} -o x.mcap", inside("take.mcap")),
            "x.mcap",
        ),
        (
            format!(
                "export {} --to csv -o {}",
                inside("estimate.mcap"),
                inside("x.csv")
            ),
            "x.csv",
        ),
        (
            format!("report {} -o {}", inside("estimate.mcap"), inside("x.html")),
            "x.html",
        ),
        (
            format!("scene new pencil -o {}", inside("x.toml")),
            "x.toml",
        ),
    ] {
        let ran = bench.enact(&words, Stdio::null());
        assert_eq!(ran.status.code(), Some(0), "{words}");
        let bytes = fs::read(bench.path(output)).expect("read");
        let has = |bytes: &[u8]| {
            bytes
                .windows(folder.len())
                .any(|of| of == folder.as_bytes())
        };
        assert!(!has(&bytes), "{words}");
    }
    // Chunks of a recording are packed: what is in it is said by what is made of it.
    let exported = bench.enact("export x.mcap --to csv -o -", Stdio::null());
    let said = String::from_utf8_lossy(&exported.stdout);
    assert!(
        said.contains("take.mcap") && !said.contains(&folder),
        "{said}"
    );
}

#[cfg(unix)]
#[test]
fn what_has_no_end_is_refused_at_once() {
    let bench = Bench::new();
    let long = "a".repeat(3 << 20);
    fs::write(
        bench.path("long.csv"),
        format!("t,x,y,z\n0,1,2,3\n{long}\n"),
    )
    .expect("write");
    let zeros = format!("t,x,y,z\n0,1,2,{}\n", "\0".repeat(200_000));
    fs::write(bench.path("zeros.csv"), zeros).expect("write");
    let cell = format!(
        "t,x,y,z\n0,1,2,3\n0.1,1,2,3\n0.2,1,2,{}\n",
        "é".repeat(200_000)
    );
    fs::write(bench.path("cell.csv"), cell).expect("write");
    for (words, expected) in [
        (
            "replay /dev/zero -o x.mcap",
            "a device, expected a regular file",
        ),
        ("replay take.mcap --scene /dev/zero -o x.mcap", "a device"),
        ("inspect /dev/zero", "a device"),
        ("import /dev/zero -o x.mcap", "a device"),
        ("scene check /dev/zero", "a device"),
        ("mark take.mcap --from /dev/zero -o x.mcap", "a device"),
        (
            "import long.csv -o x.mcap",
            "long.csv:3: the line is longer than",
        ),
        ("import zeros.csv -o x.mcap", "expected"),
        ("import cell.csv -o x.mcap", "cell.csv:4"),
    ] {
        let ran = bench.enact(words, Stdio::null());
        let said = String::from_utf8_lossy(&ran.stderr);
        assert_eq!(ran.status.code(), Some(1), "{words}: {said}");
        assert!(said.contains(expected), "{words}: {said}");
        assert!(said.len() < 20_000, "{words}: {} bytes", said.len());
    }
}
