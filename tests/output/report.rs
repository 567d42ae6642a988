//! What `enact report` writes: a page that is complete in itself and says what the estimate says, and pictures that
//! are true.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use enact::motion::{About, Stamp};
use enact::wire::{Container, PoseFormat};
use enact_tools::perform::held::{Game, Seen, play};
use enact_tools::perform::recording::write_events_of;
use enact_tools::replay::Program;
use serde_json::Value;
use sha2::{Digest, Sha256};
use tempfile::TempDir;

use crate::program::enact;

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));

/// The estimate of a recording that comes along, made once for each test.
struct Made {
    folder: TempDir,
    estimate: PathBuf,
    report: Value,
}

impl Made {
    fn of(recording: &str) -> Self {
        Self::with_scene(recording, None)
    }

    fn with_scene(recording: &str, scene_toml: Option<&str>) -> Self {
        let folder = TempDir::new().expect("folder");
        let copy = folder.path().join(recording);
        fs::copy(root().join("recordings").join(recording), &copy).expect("copy");
        let mut options: Vec<String> = Vec::new();
        if let Some(text) = scene_toml {
            let scene = folder.path().join("scene.toml");
            fs::write(&scene, text).expect("scene");
            options = vec!["--scene".to_owned(), scene.display().to_string()];
        }
        let options: Vec<&str> = options.iter().map(String::as_str).collect();
        let replayed = ENACT.report(&copy, &options);
        assert!(replayed.output.exists(), "{}", replayed.said);
        Self {
            estimate: replayed.output,
            report: replayed.said,
            folder,
        }
    }

    /// Runs `report` on it in its folder.
    fn run(&self, options: &[&str]) -> Output {
        let name = self.estimate.file_name().and_then(|name| name.to_str());
        let arguments = [&["report", name.expect("a name")][..], options].concat();
        enact(self.folder.path(), &arguments)
    }

    /// The page, of which every drawing was parsed.
    fn page(&self, code: i32) -> (String, Vec<Drawing>) {
        let ran = self.run(&["-o", "x.html"]);
        assert_eq!(ran.status.code(), Some(code), "{ran:?}");
        let page = fs::read_to_string(self.folder.path().join("x.html")).expect("the page");
        let drawings = drawings(&page);
        (page, drawings)
    }
}

/// What there is of a drawing to compare.
struct Drawing {
    label: String,
    /// Classes and data of its paths.
    paths: Vec<(String, String)>,
    texts: Vec<String>,
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn sha256(path: &Path) -> String {
    let digest = Sha256::digest(fs::read(path).expect("read"));
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A drawing as XML has it.
fn drawing(text: &str) -> Drawing {
    let document = roxmltree::Document::parse(text).unwrap_or_else(|error| panic!("{error}"));
    let named = |name: &'static str| {
        // What is played is not there until somebody plays it.
        let is_played = |node: &roxmltree::Node| {
            let mut above = node.ancestors();
            above.any(|of| of.attribute("class") == Some("played"))
        };
        let all = document.descendants().filter(move |node| !is_played(node));
        all.filter(move |node| {
            node.has_tag_name(("http://www.w3.org/2000/svg", name)) || node.has_tag_name(name)
        })
    };
    let of =
        |node: roxmltree::Node, name: &str| node.attribute(name).unwrap_or_default().to_owned();
    Drawing {
        label: of(document.root_element(), "aria-label"),
        paths: named("path")
            .map(|node| (of(node, "class"), of(node, "d")))
            .collect(),
        texts: named("text")
            .filter_map(|node| node.text().map(str::to_owned))
            .collect(),
    }
}

/// All drawings of a page.
fn drawings(page: &str) -> Vec<Drawing> {
    let mut all = Vec::new();
    let mut rest = page;
    while let Some(begin) = rest.find("<svg") {
        let end = begin + rest[begin..].find("</svg>").expect("an end") + "</svg>".len();
        all.push(drawing(&rest[begin..end]));
        rest = &rest[end..];
    }
    all
}

/// Corners of a path.
fn corners(data: &str) -> Vec<[f64; 2]> {
    let commands = data.split(['M', 'L', 'Z']).filter(|part| !part.is_empty());
    let points = commands.map(|part| {
        let mut numbers = part
            .split(' ')
            .map(|of| of.parse::<f64>().expect("a number"));
        [(); 2].map(|()| numbers.next().expect("two numbers"))
    });
    points.collect()
}

/// Whatever the page is of, it needs nothing from elsewhere and no script but the one that plays the motion.
fn assert_complete(page: &str) {
    assert!(page.starts_with("<!doctype html>") && page.trim_end().ends_with("</html>"));
    let player = format!("<script class=\"player\">{}</script>", enact::page::PLAYER);
    assert_eq!(page.matches(&player).count(), 1, "the script that plays");
    let lower = page.replace(&player, "").to_lowercase();
    for needed in [
        "<script",
        "<img",
        "<link",
        "<iframe",
        "@import",
        "url(",
        "src=",
        " onload=\"",
    ] {
        assert!(!lower.contains(needed), "{needed}");
    }
    let elsewhere = lower.match_indices("http").map(|(at, _)| &lower[at..]);
    for place in elsewhere {
        let is_name =
            place.starts_with("http://www.w3.org/2000/svg") || place.starts_with("http-equiv");
        assert!(is_name, "{:?}", &place[..place.len().min(60)]);
    }
    let ids = lower.matches(" id=").count();
    assert_eq!(ids, 0, "an id that might be there twice");
}

#[test]
fn a_page_is_complete_and_says_what_the_estimate_says() {
    let made = Made::of("pencil_tip.mcap");
    let (page, drawings) = made.page(0);
    assert_complete(&page);
    let views: Vec<&str> = drawings.iter().map(|of| of.label.as_str()).collect();
    for view in ["three-quarter", "front", "side", "top"] {
        let label = format!("pencil, tip first, {view} view");
        assert!(views.contains(&label.as_str()), "{views:?}");
    }
    // Verdict, durations, events, flights, as the program says them.
    assert!(page.contains("physical") && page.contains("fits well") && page.contains("determined"));
    let report = &made.report;
    let number =
        |value: &Value, decimals: usize| format!("{:.decimals$}", value.as_f64().expect("it"));
    for seconds in [&report["physical_s"], &report["acted_s"]] {
        assert!(
            page.contains(&format!("{} s", number(seconds, 3))),
            "{seconds}"
        );
    }
    for event in report["events"].as_array().expect("events") {
        let name = event["name"].as_str().expect("a name");
        assert!(page.contains(&format!("<bdi>{name}</bdi>")), "{name}");
        for time in ["time_s", "acted_s"] {
            let time = format!("<td class=\"n\">{} s</td>", number(&event[time], 3));
            assert!(page.contains(&time), "{name}: {time}");
        }
    }
    for segment in report["segments"].as_array().expect("flights") {
        let residual = format!(
            "{} samples, root mean square {} mm, {}°",
            segment["samples"],
            number(&segment["residual_mm"], 2),
            number(&segment["residual_deg"], 2)
        );
        assert!(page.contains(&residual), "{residual}");
    }
    // Two charts for each flight, and the time map.
    let charts = |begin: &str| {
        views
            .iter()
            .filter(|label| label.starts_with(begin))
            .count()
    };
    assert_eq!(charts("Distance of the motion of pencil"), 4);
    assert_eq!(charts("Acted time against physical time"), 1);
    // The same again, byte for byte.
    let (again, _) = made.page(0);
    assert!(page == again);
}

#[test]
fn charts_show_the_residuals_that_the_estimate_has() {
    let made = Made::of("pencil_tip.mcap");
    let (_, drawings) = made.page(0);
    let charts = drawings
        .iter()
        .filter(|of| of.label.starts_with("Distance"));
    let flights = made.report["segments"].as_array().expect("flights");
    for (index, chart) in charts.enumerate() {
        let key = ["residual_mm", "residual_deg"][index % 2];
        let expected = flights[index / 2][key].as_f64().expect("a residual");
        // A dot per sample; its height is in the scale of the ticks, by two levels that have numbers.
        let (_, dots) = chart
            .paths
            .iter()
            .rfind(|(class, _)| class.starts_with('b'))
            .expect("dots");
        let heights: Vec<f64> = dots
            .split('M')
            .filter(|part| !part.is_empty())
            .map(|part| {
                part.trim_end_matches("h0")
                    .split(' ')
                    .nth(1)
                    .expect("y")
                    .parse()
                    .expect("y")
            })
            .collect();
        assert_eq!(
            heights.len() as u64,
            flights[index / 2]["samples"].as_u64().expect("samples")
        );
        let (_, grid) = chart
            .paths
            .iter()
            .find(|(class, _)| class == "gr")
            .expect("a grid");
        let lines: Vec<f64> = corners(grid).iter().step_by(2).map(|[_, y]| *y).collect();
        let ticks: Vec<f64> = chart
            .texts
            .iter()
            .take(lines.len())
            .map(|of| of.parse().expect("a tick"))
            .collect();
        let per_px = (ticks[1] - ticks[0]) / (lines[0] - lines[1]);
        let squares = heights
            .iter()
            .map(|y| ((lines[0] - y) * per_px + ticks[0]).powi(2));
        let rms = (squares.sum::<f64>() / heights.len() as f64).sqrt();
        assert!(
            (rms / expected - 1.0).abs() < 0.02,
            "{key}: {rms}, {expected}"
        );
    }
}

/// Poses of a topic.
fn places(file: &Path, topic: &str) -> Vec<[f64; 3]> {
    let container = Container::new(fs::read(file).expect("read")).expect("MCAP");
    let mut all = Vec::new();
    let mut walk = container.walk();
    while let Some(message) = walk.next_message() {
        let channel = &container.channels()[&message.channel_id];
        if channel.topic == topic {
            let schema = container.schema_of(channel).expect("a schema");
            let format = PoseFormat::of(&schema.name, &channel.message_encoding).expect("poses");
            let mut found = Vec::new();
            format.decode(message.data, &mut found).expect("a pose");
            all.push(found[0].sample(Stamp(0)).position_m.into());
        }
    }
    assert!(all.len() > 20);
    all
}

#[test]
fn a_picture_shows_where_the_motion_is_to_scale() {
    let made = Made::of("pencil_tip.mcap");
    let ran = made.run(&["--svg", "x.svg", "--view", "front"]);
    assert!(ran.status.success(), "{ran:?}");
    assert!(
        !made.estimate.with_extension("html").exists(),
        "no page was asked for"
    );
    let text = fs::read_to_string(made.folder.path().join("x.svg")).expect("a picture");
    let picture = drawing(&text);
    // The scale: its name and how long it is drawn.
    let name = picture
        .texts
        .iter()
        .find(|text| text.ends_with(" mm"))
        .expect("a scale");
    let length_m: f64 = name
        .trim_end_matches(" mm")
        .parse::<f64>()
        .expect("a length")
        * 1e-3;
    let bars = picture.paths.iter().filter(|(class, _)| class == "ax");
    let bar = bars
        .map(|(_, data)| corners(data))
        .find(|points| points.len() == 6)
        .expect("a scale");
    let px_per_m = (bar[3][0] - bar[2][0]) / length_m;
    // The front is looked at along y: x to the right, z up.
    for (class, topic) in [
        ("b0 no", "/estimate/pencil/pose"),
        ("gl no", "/sketch/pencil/pose"),
    ] {
        let (_, data) = picture
            .paths
            .iter()
            .find(|(of, _)| of == class)
            .expect("a way");
        let drawn = corners(data);
        let places = places(&made.estimate, topic);
        let on_picture = |place: &[f64; 3]| [place[0] * px_per_m, -place[2] * px_per_m];
        let first = on_picture(&places[0]);
        let shift = [drawn[0][0] - first[0], drawn[0][1] - first[1]];
        for corner in &drawn {
            let near = places.iter().map(|place| {
                let [x, y] = on_picture(place);
                (x + shift[0] - corner[0]).hypot(y + shift[1] - corner[1])
            });
            let near_px = near.fold(f64::INFINITY, f64::min);
            assert!(
                near_px < 0.5,
                "{topic}: {corner:?} is {near_px} px from every pose"
            );
        }
        let last = on_picture(places.last().expect("a pose"));
        let end = drawn.last().expect("an end");
        let off_px = (last[0] + shift[0] - end[0]).hypot(last[1] + shift[1] - end[1]);
        assert!(off_px < 0.5, "{topic}: ends {off_px} px from the last pose");
    }
    // Bodies, ghosts and events are drawn, and events have their names.
    let count = |class: &str| picture.paths.iter().filter(|(of, _)| of == class).count();
    assert!(
        count("gh") > 8 && count("cr") > 8,
        "{} {}",
        count("gh"),
        count("cr")
    );
    assert_eq!(count("ev no"), 2);
    for name in ["bounce 0.345 s", "landing 0.795 s"] {
        assert!(
            picture.texts.iter().any(|text| text == name),
            "{:?}",
            picture.texts
        );
    }
    // Another view is another picture.
    let side = made.run(&["--svg", "-", "--view", "side"]);
    assert!(side.status.success() && side.stderr.is_empty(), "{side:?}");
    assert_ne!(side.stdout, text.into_bytes());
}

#[test]
fn every_kind_of_recording_has_its_page() {
    // The file, the exit code, the number of flights with charts in mm and of those in °, and words.
    let kinds: [(&str, i32, [usize; 2], &[&str]); 5] = [
        (
            "chain.mcap",
            0,
            [1, 0],
            &[
                "rod 3",
                "spin of <bdi>rod 1</bdi>|spin of rod 1",
                "not all of it",
            ],
        ),
        (
            "die.mcap",
            3,
            [7, 7],
            &["plausible", "Physics had to be bent at"],
        ),
        (
            "hat_box.mcap",
            0,
            [5, 5],
            &["meeting.restitution", "95 % interval"],
        ),
        (
            "hat_box_bent.mcap",
            3,
            [5, 5],
            // It has more goals than physics meets.
            &["for another motion than was acted", "plausible"],
        ),
        (
            "pencil_eraser.mcap",
            0,
            [2, 2],
            &["At rest", "tempo of its own"],
        ),
    ];
    for (recording, code, charts, words) in kinds {
        let made = Made::of(recording);
        let (page, drawings) = made.page(code);
        assert_complete(&page);
        for alternatives in words {
            assert!(
                alternatives.split('|').any(|word| page.contains(word)),
                "{recording}: {alternatives}"
            );
        }
        for (unit, count) in ["mm", "°"].into_iter().zip(charts) {
            let label = format!("from its samples in {unit},");
            let found = drawings
                .iter()
                .filter(|of| of.label.contains(&label))
                .count();
            assert_eq!(found, count, "{recording}: charts in {unit}");
        }
    }
}

#[test]
fn what_is_in_the_hand_is_told_from_what_flies() {
    let mut takes = (100..).filter_map(|seed| play(Game::Racket, &Seen::default(), seed));
    let take = takes.next().expect("a take");
    let folder = TempDir::new().expect("folder");
    let recording = folder.path().join("racket.mcap");
    write_events_of(&take.scene, Game::Racket.toml(), &take.events, &recording).expect("write");
    let replayed = ENACT.report(&recording, &[]);
    let made = Made {
        folder,
        estimate: replayed.output,
        report: replayed.said,
    };
    let (page, drawings) = made.page(0);
    assert_complete(&page);
    assert!(
        page.contains("<bdi>racket</bdi>, in the hand")
            && page.contains("<bdi>racket</bdi> is in the hand:")
    );
    // The ball flies four times, and is drawn at its three bounces and its end; so is the racket.
    let events = made.report["events"].as_array().expect("events");
    let concerned: usize = events
        .iter()
        .map(|event| event["bodies"].as_array().expect("bodies").len())
        .sum();
    let front = drawings
        .iter()
        .find(|of| of.label.ends_with("front view"))
        .expect("a view");
    let outlined = front
        .paths
        .iter()
        .filter(|(class, _)| class == "ev no")
        .count();
    assert_eq!((events.len(), outlined), (4, concerned));
    let flights = drawings
        .iter()
        .filter(|of| of.label.contains("motion of ball from its samples in mm"));
    assert_eq!(flights.count(), 4);
}

#[test]
fn names_of_a_file_end_no_element() {
    let toml = fs::read_to_string(root().join("config/pencil_tip.toml")).expect("a scene");
    let hostile = "</title></svg><script>alert(1)</script>";
    let quotes = "\\\" onload=\\\"alert(2)\\\" x='";
    let direction = "\\u202egnitset & <b>&amp;";
    let toml = toml
        .replace(
            "name = \"pencil, tip first\"",
            &format!("name = \"{hostile}\""),
        )
        .replace("name = \"bounce\"", &format!("name = \"{quotes}\""))
        .replace("name = \"landing\"", &format!("name = \"{direction}\""))
        .replace("event = \"landing\"", &format!("event = \"{direction}\""))
        .replace("name = \"table\"", "name = \"]]><table>\"")
        .replace("surface = \"table\"", "surface = \"]]><table>\"");
    let made = Made::with_scene("pencil_tip.mcap", Some(&toml));
    let (page, drawings) = made.page(0);
    assert_complete(&page);
    assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt;"));
    assert!(!page.contains('\u{202e}'), "text is turned round");
    // Four views, four charts, the time map, signs of the legend.
    assert!(drawings.len() > 10, "{}", drawings.len());
    assert!(
        drawings
            .iter()
            .any(|of| of.label.starts_with("</title></svg><script>"))
    );
    let ran = made.run(&["--svg", "x.svg"]);
    assert!(ran.status.success(), "{ran:?}");
    let text = fs::read_to_string(made.folder.path().join("x.svg")).expect("a picture");
    assert!(drawing(&text).label.starts_with(hostile));
}

#[test]
fn what_is_made_says_from_what() {
    let made = Made::of("pencil_tip.mcap");
    let recording = sha256(&made.folder.path().join("pencil_tip.mcap"));
    let estimate = sha256(&made.estimate);
    let (page, _) = made.page(0);
    let outputs = [
        ("svg", vec!["report", "--svg"]),
        ("glb", vec!["export", "--to", "glb", "-o"]),
        ("csv", vec!["export", "--to", "csv", "-o"]),
        ("tum", vec!["export", "--to", "tum", "-o"]),
    ];
    let name = made
        .estimate
        .file_name()
        .and_then(|name| name.to_str())
        .expect("a name");
    let mut files = vec![("html", page.into_bytes())];
    for (ending, words) in outputs {
        let output = format!("x.{ending}");
        let arguments = [&[words[0], name][..], &words[1..], &[output.as_str()]].concat();
        let bytes = || {
            let ran = enact(made.folder.path(), &arguments);
            assert!(ran.status.success(), "{ran:?}");
            fs::read(made.folder.path().join(&output)).expect("a file")
        };
        let first = bytes();
        assert!(first == bytes(), "{ending}: not the same twice");
        files.push((ending, first));
    }
    let program = concat!("enact ", env!("CARGO_PKG_VERSION"));
    let folder = made.folder.path().display().to_string();
    for (ending, bytes) in &files {
        let text = String::from_utf8_lossy(bytes);
        for said in [
            program,
            &estimate,
            &recording,
            "enact replay pencil_tip.mcap",
        ] {
            assert!(text.contains(said), "{ending}: {said}");
        }
        assert!(!text.contains(&folder), "{ending}: where it was made");
    }
    // And so does the estimate, which is the same by `process`.
    let ran = enact(
        made.folder.path(),
        &["process", "pencil_tip.mcap", "-o", "all"],
    );
    assert!(ran.status.success(), "{ran:?}");
    let processed = made.folder.path().join("all/pencil_tip.estimate.mcap");
    assert_eq!(sha256(&processed), estimate);
}

#[test]
fn what_cannot_be_reported_is_said_and_leaves_no_file() {
    let made = Made::of("pencil_tip.mcap");
    let before = sha256(&made.estimate);
    let name = made
        .estimate
        .file_name()
        .and_then(|name| name.to_str())
        .expect("a name");
    fs::write(made.folder.path().join("none.mcap"), b"no recording").expect("write");
    let cases: [(&[&str], i32, &str); 6] = [
        (
            &["pencil_tip.mcap"],
            1,
            "has no estimate, expected what `enact replay`",
        ),
        (&["none.mcap", "-o", "x.html"], 1, "not an MCAP file"),
        (&["missing.mcap", "-o", "x.html"], 1, "cannot read"),
        (&[name, "-o", name], 1, "expected another name"),
        (
            &[name, "-o", "x", "--svg", "x"],
            1,
            "expected another name for one of them",
        ),
        (&[name, "--view", "front"], 2, "--svg"),
    ];
    let list = || fs::read_dir(made.folder.path()).expect("a folder").count();
    let count = list();
    for (arguments, code, said) in cases {
        let ran = enact(made.folder.path(), &[&["report"][..], arguments].concat());
        assert_eq!(ran.status.code(), Some(code), "{arguments:?}: {ran:?}");
        let errors = String::from_utf8_lossy(&ran.stderr);
        assert!(errors.contains(said), "{arguments:?}: {errors}");
        assert_eq!(list(), count, "{arguments:?}");
    }
    assert_eq!(sha256(&made.estimate), before);
}

#[test]
fn a_page_goes_beside_its_estimate_and_into_a_pipe() {
    let made = Made::of("pencil_tip.mcap");
    let ran = made.run(&["--format", "ndjson"]);
    assert!(ran.status.success(), "{ran:?}");
    let said: Value = serde_json::from_slice(&ran.stdout).expect("JSON");
    let output = made.estimate.with_extension("html");
    let name = output
        .file_name()
        .and_then(|name| name.to_str())
        .expect("a name");
    assert_eq!(said["outputs"], serde_json::json!([name]));
    assert_eq!(said["verdict"], "physical");
    let piped = made.run(&["-o", "-"]);
    assert!(
        piped.status.success() && piped.stderr.is_empty(),
        "{piped:?}"
    );
    // All but the command.
    let without = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes).into_owned();
        let lines = text.lines().filter(|line| !line.contains("enact report"));
        lines.map(str::to_owned).collect::<Vec<_>>()
    };
    let file = fs::read(&output).expect("the page");
    assert_eq!(without(&piped.stdout), without(&file));
}

/// The picture in the documents is what its command makes, but for what it says of the bytes of the file.
#[test]
fn the_picture_of_the_documents_is_what_its_command_makes() {
    let folder = TempDir::new().expect("folder");
    for sub in ["recordings", "docs"] {
        fs::create_dir(folder.path().join(sub)).expect("a folder");
    }
    let recording = "recordings/pencil_tip.mcap";
    fs::copy(root().join(recording), folder.path().join(recording)).expect("copy");
    let document = fs::read_to_string(root().join("docs/report.md")).expect("the document");
    let mut commands = document
        .lines()
        .map(str::trim)
        .filter(|line| line.contains("pencil_tip"));
    for wanted in ["replay", "report"] {
        let line = commands.next().expect("a command");
        let words: Vec<&str> = line.split_whitespace().collect();
        assert_eq!(words[..2], ["enact", wanted], "{line}");
        let ran = enact(folder.path(), &words[1..]);
        assert!(ran.status.success(), "{ran:?}");
    }
    let path = "docs/strobe_pencil_tip.svg";
    let [made, kept] =
        [folder.path(), root()].map(|root| fs::read_to_string(root.join(path)).expect(path));
    let drawn = |text: &str| {
        let (before, rest) = text.split_once("<metadata>").expect("notes");
        let (notes, after) = rest.split_once("</metadata>").expect("notes");
        assert!(
            notes.contains("SHA-256") && notes.contains("--svg strobe_pencil_tip.svg"),
            "{notes}"
        );
        format!("{before}{after}")
    };
    assert!(
        drawn(&made) == drawn(&kept),
        "{path} is another; see docs/report.md"
    );
}

/// The schema names every quantity that may be doubted.
#[test]
fn the_schema_knows_every_doubt() {
    let schema: Value = serde_json::from_str(enact::report::REPORT_SCHEMA).expect("JSON");
    let named = &schema["properties"]["doubts"]["items"]["properties"]["quantity"]["enum"];
    let named: BTreeSet<&str> = (named.as_array().expect("names").iter())
        .filter_map(Value::as_str)
        .collect();
    assert_eq!(named, About::ALL.map(About::as_str).into());
    let places = About::ALL.map(|about| about as usize);
    assert!(places.into_iter().eq(0..=About::Rest as usize));
}
