//! A reader of binary glTF, as far as exports use it.

use serde_json::Value;

/// A GLB file taken apart.
pub struct Glb {
    /// Its description.
    pub json: Value,
    /// Its binary part.
    pub bytes: Vec<u8>,
}

impl Glb {
    /// Takes a file apart; its lengths and magic words must be right.
    pub fn read(file: &[u8]) -> Self {
        let number = |at: usize| {
            let bytes = file[at..at + 4].try_into().expect("four bytes");
            u32::from_le_bytes(bytes) as usize
        };
        assert_eq!(
            (&file[..4], number(4), number(8)),
            (&b"glTF"[..], 2, file.len())
        );
        let json = number(12);
        assert_eq!((&file[16..20], json % 4), (&b"JSON"[..], 0));
        let (text, rest) = (&file[20..20 + json], 20 + json);
        assert_eq!(&file[rest + 4..rest + 8], b"BIN\0");
        assert_eq!(rest + 8 + number(rest), file.len());
        let json: Value = serde_json::from_slice(text).expect("JSON");
        let bytes = file[rest + 8..].to_vec();
        assert_eq!(json["buffers"][0]["byteLength"], bytes.len());
        Self { json, bytes }
    }

    /// The numbers of an accessor, element by element.
    fn floats(&self, accessor: &Value) -> Vec<Vec<f32>> {
        let accessor = &self.json["accessors"][at(accessor)];
        assert_eq!(accessor["componentType"], 5126);
        let view = &self.json["bufferViews"][at(&accessor["bufferView"])];
        let (start, length) = (at(&view["byteOffset"]), at(&view["byteLength"]));
        let width = match accessor["type"].as_str() {
            Some("SCALAR") => 1,
            Some("VEC3") => 3,
            Some("VEC4") => 4,
            other => panic!("{other:?}"),
        };
        assert_eq!(at(&accessor["count"]) * 4 * width, length);
        let numbers = self.bytes[start..start + length].chunks(4);
        let numbers = numbers.map(|b| f32::from_le_bytes(b.try_into().expect("four")));
        let numbers: Vec<f32> = numbers.collect();
        numbers.chunks(width).map(<[f32]>::to_vec).collect()
    }

    /// Times, places and quaternions of the node of that name.
    pub fn keys(&self, name: &str) -> (Vec<f32>, Vec<Vec<f32>>, Vec<Vec<f32>>) {
        let animation = &self.json["animations"][0];
        let of = |path: &str| {
            let channels = animation["channels"].as_array().expect("channels");
            let mut channels = channels.iter().filter(|channel| {
                let target = &channel["target"];
                target["path"] == path && self.json["nodes"][at(&target["node"])]["name"] == name
            });
            let channel = channels
                .next()
                .unwrap_or_else(|| panic!("no {path} of {name}"));
            assert!(channels.next().is_none());
            let sampler = &animation["samplers"][at(&channel["sampler"])];
            assert_eq!(sampler["interpolation"], "LINEAR");
            (
                self.floats(&sampler["input"]),
                self.floats(&sampler["output"]),
            )
        };
        let ((times, places), (again, turns)) = (of("translation"), of("rotation"));
        assert_eq!(times, again);
        (times.concat(), places, turns)
    }
}

/// An index in the description.
pub fn at(index: &Value) -> usize {
    let index = index
        .as_u64()
        .unwrap_or_else(|| panic!("{index}: an index"));
    index as usize
}

/// Bounds of every accessor that has them are those of its numbers, and every mesh is well indexed.
pub fn assert_well_made(glb: &Glb) {
    let accessors = glb.json["accessors"].as_array().expect("accessors");
    for (index, accessor) in accessors.iter().enumerate() {
        if accessor["componentType"] != 5126 {
            continue;
        }
        let values = glb.floats(&index.into());
        for axis in 0..values[0].len() {
            let along = || values.iter().map(|value| value[axis]);
            let (least, most) = (
                along().fold(f32::INFINITY, f32::min),
                along().fold(f32::NEG_INFINITY, f32::max),
            );
            assert_eq!(accessor["min"][axis], f64::from(least));
            assert_eq!(accessor["max"][axis], f64::from(most));
        }
    }
    for mesh in glb.json["meshes"].as_array().expect("meshes") {
        let part = &mesh["primitives"][0];
        let corners = glb.floats(&part["attributes"]["POSITION"]).len();
        let indices = &accessors[at(&part["indices"])];
        let view = &glb.json["bufferViews"][at(&indices["bufferView"])];
        let (start, length) = (at(&view["byteOffset"]), at(&view["byteLength"]));
        let of = glb.bytes[start..start + length].chunks(4);
        let of: Vec<u32> = of
            .map(|b| u32::from_le_bytes(b.try_into().expect("four")))
            .collect();
        assert!(of.len().is_multiple_of(3) && of.len() == at(&indices["count"]));
        assert_eq!(
            of.iter().max().map(|last| *last as usize + 1),
            Some(corners)
        );
    }
}
