//! A scene's text with calibrated values in it, everything else as it was written.

use nalgebra::Vector3;
use toml_edit::{Array, ArrayOfTables, DocumentMut, Item, Table, TableLike, Value};

use super::super::error::{Fault, SceneError};
use super::super::text::scene_from_toml;
use super::file::Calibration;

/// A scene with calibrated values.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibratedScene {
    /// Its text.
    pub toml: String,
    /// What changed: key, value before if there was one, value now.
    pub changes: Vec<String>,
}

/// Puts the values of calibrations, which come with the names of their files, into the text of a scene.
///
/// Bodies must be in the scene; surfaces and free quantities that are not are added. Comments and order
/// stay. What comes out is checked as any scene is. Fails with the place in the scene that is wrong then.
pub fn scene_calibrated(
    text: &str,
    calibrations: &[(String, Calibration)],
) -> Result<CalibratedScene, SceneError> {
    let at_start = |message: String| {
        let fault = Fault {
            span: 0..0,
            message,
        };
        SceneError::from_fault(text, fault)
    };
    toml::from_str::<toml::Table>(text).map_err(|error| SceneError::from_toml(text, &error))?;
    let parsed = text.parse::<DocumentMut>();
    let mut document = parsed.map_err(|error| at_start(error.to_string()))?;
    let mut changes = Vec::new();
    for (file, calibration) in calibrations {
        let written = toml::to_string(&calibration.scene);
        let written = written.map_err(|error| at_start(error.to_string()))?;
        let values = written.parse::<DocumentMut>();
        let values = values.map_err(|error| at_start(error.to_string()))?;
        let mut merger = Merger {
            file,
            kind: &calibration.kind,
            changes: &mut changes,
        };
        merger
            .merge(document.as_table_mut(), values.as_table(), "")
            .map_err(at_start)?;
    }
    let head: String = changes
        .iter()
        .map(|line| format!("# Calibrated: {line}\n"))
        .collect();
    let toml = format!("{head}{document}");
    scene_from_toml(&toml)?;
    Ok(CalibratedScene { toml, changes })
}

struct Merger<'a> {
    file: &'a str,
    kind: &'a str,
    changes: &'a mut Vec<String>,
}

impl Merger<'_> {
    /// Puts all values of a table into another; `place` is where they are.
    fn merge(
        &mut self,
        into: &mut dyn TableLike,
        from: &dyn TableLike,
        place: &str,
    ) -> Result<(), String> {
        for (key, item) in from.iter().filter(|(key, _)| !is_identity(key)) {
            let here = if place.is_empty() {
                key.to_owned()
            } else {
                format!("{place}.{key}")
            };
            if let Some(tables) = item.as_array_of_tables() {
                for table in tables {
                    self.merge_named(into, key, table, &here)?;
                }
            } else if let Some(table) = item.as_table_like() {
                let target = self.table(into, key, &here)?;
                self.merge(target, table, &here)?;
            } else if let Some(value) = item.as_value() {
                self.set(into, key, value, &here);
            }
        }
        Ok(())
    }

    /// The table under a key, made if it is not there. The tracker of a body that lists its only track
    /// without a name is that track's.
    fn table<'t>(
        &self,
        into: &'t mut dyn TableLike,
        key: &str,
        here: &str,
    ) -> Result<&'t mut dyn TableLike, String> {
        let tracks = into.get("track").and_then(Item::as_array_of_tables);
        let in_track = key == "tracker" && tracks.is_some_and(|tracks| tracks.len() == 1);
        let owner: &mut dyn TableLike = if in_track {
            let tracks = into.get_mut("track").and_then(Item::as_array_of_tables_mut);
            tracks
                .and_then(|tracks| tracks.get_mut(0))
                .ok_or_else(|| format!("{here}: expected one track"))?
        } else {
            into
        };
        let empty = || Item::Value(Value::InlineTable(toml_edit::InlineTable::new()));
        owner
            .entry(key)
            .or_insert_with(empty)
            .as_table_like_mut()
            .ok_or_else(|| format!("{here} is no table, expected one"))
    }

    fn set(&mut self, into: &mut dyn TableLike, key: &str, value: &Value, here: &str) {
        let mut value = value.clone();
        let text = |value: &Value| value.to_string().trim().to_owned();
        let now = text(&value);
        let before = into.get(key).and_then(Item::as_value);
        let was = match before {
            Some(before) => {
                *value.decor_mut() = before.decor().clone();
                format!(", was {}", text(before))
            }
            None => {
                value.decor_mut().clear();
                String::new()
            }
        };
        into.insert(key, Item::Value(value));
        // The same said otherwise.
        if key == "orientation_wxyz" {
            into.remove("rpy_deg");
        }
        let (file, kind) = (self.file, self.kind);
        self.changes
            .push(format!("{here} = {now}{was} ({kind}, {file})"));
    }

    /// Puts a table into the one of the same name in an array of tables.
    fn merge_named(
        &mut self,
        into: &mut dyn TableLike,
        key: &str,
        from: &Table,
        here: &str,
    ) -> Result<(), String> {
        let identity = |table: &Table| -> Option<String> {
            let named = table.iter().find(|(key, _)| is_identity(key));
            named.and_then(|(_, item)| item.as_str().map(str::to_owned))
        };
        let name = identity(from).unwrap_or_default();
        let here = format!("{here} {name:?}");
        let tables = into
            .entry(key)
            .or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()))
            .as_array_of_tables_mut()
            .ok_or_else(|| format!("{key} is no array of tables, expected [[{key}]]"))?;
        let names: Vec<String> = tables.iter().filter_map(identity).collect();
        let mut present = tables.iter_mut();
        if let Some(table) = present.find(|of| identity(of).as_deref() == Some(&name)) {
            let from = in_the_middle(table, from).unwrap_or_else(|| from.clone());
            return self.merge(table, &from, &here);
        }
        drop(present);
        if matches!(key, "body" | "track" | "event") {
            return Err(format!(
                "{} is about the {key} {name:?}, which the scene does not have, expected one of {}",
                self.file,
                names.join(", ")
            ));
        }
        let mut added = from.clone();
        // After everything that is there already.
        added.set_position(None);
        added.decor_mut().set_prefix("\n");
        tables.push(added);
        let (file, kind) = (self.file, self.kind);
        self.changes.push(format!("{here} added ({kind}, {file})"));
        Ok(())
    }
}

/// A plane for a board: its point is the board's middle, which a plane that was touched does not tell. It stays where
/// it is but for its distance from the plane. `None` where the surface is no board.
fn in_the_middle(board: &Table, plane: &Table) -> Option<Table> {
    board.get("size_mm")?;
    let vector = |table: &Table, key: &str| -> Option<Vector3<f64>> {
        let array = table.get(key)?.as_array()?;
        let number = |value: &Value| value.as_float().or(value.as_integer().map(|x| x as f64));
        let numbers: Option<Vec<f64>> = array.iter().map(number).collect();
        numbers
            .filter(|numbers| numbers.len() == 3)
            .map(|numbers| Vector3::from_column_slice(&numbers))
    };
    let middle_mm = vector(board, "point_mm")?;
    let normal = vector(plane, "normal")?.try_normalize(0.0)?;
    let above_mm = normal.dot(&(middle_mm - vector(plane, "point_mm")?));
    let moved_mm = (middle_mm - normal * above_mm).map(|x| (x * 1e6).round() / 1e6 + 0.0);
    let mut plane = plane.clone();
    plane.insert(
        "point_mm",
        Item::Value(moved_mm.iter().copied().collect::<Array>().into()),
    );
    Some(plane)
}

fn is_identity(key: &str) -> bool {
    matches!(key, "name" | "quantity")
}
