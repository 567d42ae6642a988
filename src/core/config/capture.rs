//! The table `[capture]`: how a live take is recorded.

use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;
use std::time::Duration;

use typed_index_collections::TiVec;

use super::error::{Fault, fault};
use super::number::{finite, index_of, positive, unique};
use super::raw::{Number, RawCapture, RawScene, RawTrackerClock, Text};
use crate::motion::{Scene, StampSource, TrackIndex};

const FOLDER: &str = "takes";
const CHUNK_MS: f64 = 100.0;
const SYNC_MS: f64 = 1000.0;

/// Longest period \[ms\]: it bounds what a crash may lose.
const PERIOD_LIMIT_MS: f64 = 60_000.0;

/// Longest pre-roll \[s\]: it is kept in memory.
const PRE_ROLL_LIMIT_S: f64 = 30.0;

/// Accepted rates of trackers \[Hz\].
const RATES_HZ: std::ops::RangeInclusive<f64> = 0.1..=1e5;

/// How a live take is recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct CaptureSettings {
    /// Folder of the takes.
    pub folder: PathBuf,
    /// Longest time that samples stay in an open chunk: what a killed process may lose.
    pub chunk: Duration,
    /// How often the journal is synced to disk: what a failing machine may lose in addition.
    pub sync: Duration,
    /// Address at which viewers and metrics are served; loopback is reached from this machine only.
    pub listen: IpAddr,
    /// Port of the WebSocket for viewers; 0: any free port, `None`: not served.
    pub viewer_port: Option<u16>,
    /// Port of health and metrics; 0: any free port, `None`: not served.
    pub metrics_port: Option<u16>,
    /// Pages in browsers that may watch besides those of this machine and of known viewers:
    /// `https://viewer.example`, or `*` for all.
    pub origins: Vec<String>,
    /// Names by which the ports may be asked besides `localhost` and addresses in numbers.
    pub hosts: Vec<String>,
    /// How much of what came before its start a take begins with.
    pub pre_roll: Duration,
    /// Source of the stamps, track by track; `None`: the first valid sample decides.
    pub stamps: TiVec<TrackIndex, Option<StampSource>>,
}

/// The checked table, or its defaults.
pub(super) fn capture(raw: &RawScene, scene: &Scene) -> Result<CaptureSettings, Fault> {
    let absent = RawCapture::default();
    let raw = raw.capture.as_ref().unwrap_or(&absent);
    let folder = match &raw.folder {
        Some(text) if text.get_ref().trim().is_empty() => {
            return fault(text.span(), "folder is empty, expected a path");
        }
        Some(text) => text.get_ref().clone(),
        None => FOLDER.to_owned(),
    };
    let listen = match &raw.listen {
        Some(text) => match text.get_ref().parse() {
            Ok(address) => address,
            Err(_) => {
                let given = text.get_ref();
                let expected = "expected an address such as \"127.0.0.1\"";
                return fault(text.span(), format!("listen is {given:?}, {expected}"));
            }
        },
        None => IpAddr::V4(Ipv4Addr::LOCALHOST),
    };
    let mut stamps: TiVec<TrackIndex, _> = scene.tracks.iter().map(|_| None).collect();
    let mut named: Vec<&str> = Vec::new();
    for tracker in &raw.tracker {
        let names = scene
            .tracks
            .keys()
            .map(|track| scene.tracks[track].name.as_str());
        let track = TrackIndex(index_of("body", &tracker.body, names)?);
        let name = scene.tracks[track].name.as_str();
        unique("tracker of", &tracker.body, name, named.iter().copied())?;
        named.push(name);
        stamps[track] = Some(stamp_source(tracker)?);
    }
    Ok(CaptureSettings {
        folder: PathBuf::from(folder),
        chunk: period("chunk_ms", raw.chunk_ms.as_ref(), CHUNK_MS)?,
        sync: period("sync_ms", raw.sync_ms.as_ref(), SYNC_MS)?,
        listen,
        viewer_port: port("viewer_port", raw.viewer_port.as_ref())?,
        metrics_port: port("metrics_port", raw.metrics_port.as_ref())?,
        origins: origins(raw.origins.as_deref().unwrap_or_default())?,
        hosts: hosts(raw.hosts.as_deref().unwrap_or_default())?,
        pre_roll: pre_roll(raw.pre_roll_s.as_ref())?,
        stamps,
    })
}

fn origins(given: &[Text]) -> Result<Vec<String>, Fault> {
    let is_origin = |text: &str| {
        let host = text.split_once("://").map(|(_, host)| host);
        text == "*" || host.is_some_and(|host| !host.is_empty() && !host.contains('/'))
    };
    let checked = given.iter().map(|text| {
        let origin = text.get_ref();
        if is_origin(origin) {
            return Ok(origin.clone());
        }
        let expected = "expected \"https://viewer.example\", without a path, or \"*\"";
        fault(text.span(), format!("origin {origin:?}: {expected}"))
    });
    checked.collect()
}

fn hosts(given: &[Text]) -> Result<Vec<String>, Fault> {
    let is_name = |text: &str| {
        let is_of_name = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_');
        !text.is_empty() && text.chars().all(is_of_name)
    };
    let checked = given.iter().map(|text| match text.get_ref() {
        name if is_name(name) => Ok(name.clone()),
        name => {
            let expected = "expected the name of this machine, \"mocap.local\", without a port";
            fault(text.span(), format!("host {name:?}: {expected}"))
        }
    });
    checked.collect()
}

fn pre_roll(given: Option<&Number>) -> Result<Duration, Fault> {
    let Some(number) = given else {
        return Ok(Duration::ZERO);
    };
    let span_s = finite("pre_roll_s", number)?;
    if !(0.0..=PRE_ROLL_LIMIT_S).contains(&span_s) {
        return fault(
            number.span(),
            format!("pre_roll_s is {span_s}, expected 0 to {PRE_ROLL_LIMIT_S}"),
        );
    }
    Ok(Duration::from_secs_f64(span_s))
}

fn stamp_source(raw: &RawTrackerClock) -> Result<StampSource, Fault> {
    let source = match (raw.stamps.get_ref().as_str(), &raw.rate_hz) {
        ("sequence", Some(rate)) => {
            let rate_hz = positive("rate_hz", rate)?;
            if !RATES_HZ.contains(&rate_hz) {
                let expected = "expected 0.1 to 100000";
                return fault(rate.span(), format!("rate_hz is {rate_hz}, {expected}"));
            }
            return Ok(StampSource::Sequence { rate_hz });
        }
        ("sequence", None) => {
            return fault(raw.stamps.span(), "stamps by sequence want rate_hz");
        }
        ("sample", _) => StampSource::Sample,
        ("device", _) => StampSource::Device,
        ("receipt", _) => StampSource::Receipt,
        (other, _) => {
            return fault(
                raw.stamps.span(),
                format!(
                    "stamps are {other:?}, expected \"sample\", \"device\", \"sequence\" or \"receipt\""
                ),
            );
        }
    };
    match &raw.rate_hz {
        Some(rate) => fault(
            rate.span(),
            format!("rate_hz does not apply to stamps by {}", source.as_str()),
        ),
        None => Ok(source),
    }
}

fn period(what: &str, given: Option<&Number>, default_ms: f64) -> Result<Duration, Fault> {
    let Some(number) = given else {
        return Ok(Duration::from_secs_f64(default_ms / 1e3));
    };
    let period_ms = positive(what, number)?;
    if !(1.0..=PERIOD_LIMIT_MS).contains(&period_ms) {
        return fault(
            number.span(),
            format!("{what} is {period_ms} ms, expected 1 to {PERIOD_LIMIT_MS}"),
        );
    }
    Ok(Duration::from_secs_f64(period_ms / 1e3))
}

fn port(what: &str, given: Option<&Number>) -> Result<Option<u16>, Fault> {
    let Some(number) = given else {
        return Ok(None);
    };
    let value = finite(what, number)?;
    if value.fract() != 0.0 || !(0.0..=f64::from(u16::MAX)).contains(&value) {
        return fault(
            number.span(),
            format!("{what} is {value}, expected a whole number from 0 to 65535"),
        );
    }
    Ok(Some(value as u16))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::capture_from_toml;

    const SCENE: &str = r#"name = "x"
[timing]
stamps = "tempo"
[[body]]
name = "ball"
shape = { kind = "sphere", radius_mm = 10 }
mass_g = 6.0
"#;

    fn settings(table: &str) -> Result<CaptureSettings, String> {
        capture_from_toml(&format!("{SCENE}{table}"))
            .map(|(_, settings)| settings)
            .map_err(|error| error.to_string())
    }

    #[test]
    fn what_is_left_out_has_the_documented_default() {
        let settings = settings("").expect("valid");
        assert_eq!(settings.folder, PathBuf::from("takes"));
        assert_eq!(settings.chunk, Duration::from_millis(100));
        assert_eq!(settings.sync, Duration::from_secs(1));
        assert_eq!(settings.stamps.raw, [None]);
        assert_eq!((settings.viewer_port, settings.metrics_port), (None, None));
    }

    #[test]
    fn nothing_but_loopback_is_listened_on_unless_it_is_asked_for() {
        let ports = "[capture]\nviewer_port = 8765\nmetrics_port = 0\n";
        let given = settings(ports).expect("valid");
        assert_eq!(
            (given.viewer_port, given.metrics_port),
            (Some(8765), Some(0))
        );
        assert!(given.listen.is_loopback());
        assert!(given.origins.is_empty() && given.pre_roll.is_zero());
        let more =
            settings("[capture]\norigins = [\"https://a.example\", \"*\"]\npre_roll_s = 2\n");
        let more = more.expect("valid");
        assert_eq!(more.origins, ["https://a.example", "*"]);
        assert_eq!(more.pre_roll, Duration::from_secs(2));
        let asked = settings(&format!("{ports}listen = \"0.0.0.0\"\n")).expect("valid");
        assert!(asked.listen.is_unspecified());
    }

    #[test]
    fn every_source_can_be_said() {
        for (line, expected) in [
            ("stamps = \"sample\"", StampSource::Sample),
            ("stamps = \"device\"", StampSource::Device),
            ("stamps = \"receipt\"", StampSource::Receipt),
            (
                "stamps = \"sequence\"\nrate_hz = 250",
                StampSource::Sequence { rate_hz: 250.0 },
            ),
        ] {
            let table = format!("[[capture.tracker]]\nbody = \"ball\"\n{line}\n");
            assert_eq!(
                settings(&table).expect("valid").stamps.raw,
                [Some(expected)]
            );
        }
    }

    #[test]
    fn mistakes_are_answered_where_they_are_also_when_only_the_scene_is_wanted() {
        for (table, expected) in [
            ("[capture]\nchunk_ms = 0\n", "scene:9:12: chunk_ms is 0"),
            ("[capture]\nchunk = 5\n", "scene:9:1: unknown key `chunk`"),
            (
                "[capture]\nlisten = \"everywhere\"\n",
                "scene:9:10: listen is \"everywhere\"",
            ),
            (
                "[capture]\nviewer_port = 65536\n",
                "scene:9:15: viewer_port is 65536",
            ),
            (
                "[capture]\nmetrics_port = 0.5\n",
                "scene:9:16: metrics_port is 0.5",
            ),
            ("[capture]\nfolder = \"\"\n", "scene:9:10: folder is empty"),
            (
                "[capture]\nhosts = [\"mocap.local:9464\"]\n",
                "host \"mocap.local:9464\": expected the name of this machine",
            ),
            (
                "[capture]\norigins = [\"viewer.example\"]\n",
                "scene:9:12: origin \"viewer.example\"",
            ),
            (
                "[capture]\npre_roll_s = 31\n",
                "scene:9:14: pre_roll_s is 31, expected 0 to 30",
            ),
            (
                "[[capture.tracker]]\nbody = \"bal\"\nstamps = \"device\"\n",
                "scene:9:8: unknown body \"bal\"",
            ),
            (
                "[[capture.tracker]]\nbody = \"ball\"\nstamps = \"sequence\"\n",
                "scene:10:10: stamps by sequence want rate_hz",
            ),
            (
                "[[capture.tracker]]\nbody = \"ball\"\nstamps = \"device\"\nrate_hz = 5\n",
                "scene:11:11: rate_hz does not apply",
            ),
        ] {
            let error = settings(table).expect_err(table);
            assert!(error.contains(expected), "{error}");
            let of_scene = crate::config::scene_from_toml(&format!("{SCENE}{table}"));
            assert_eq!(of_scene.expect_err(table).to_string(), error);
        }
    }
}
