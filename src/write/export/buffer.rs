//! The binary part of a glTF file, and the list of what is where in it.

use serde_json::{Map, Value, json};

/// Vertices, and indices of them (glTF's `bufferView.target`).
pub(super) const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// glTF's numbers of its kinds of components.
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;

/// Bytes with the views and accessors that say what they are.
#[derive(Default)]
pub(super) struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Adds vectors of floats with their least and greatest components; returns their accessor.
    pub(super) fn floats<const N: usize>(
        &mut self,
        values: &[[f32; N]],
        target: Option<u32>,
    ) -> usize {
        let bytes = values
            .iter()
            .flatten()
            .flat_map(|value| value.to_le_bytes());
        let bound = |pick: fn(f32, f32) -> f32| -> Vec<f64> {
            let start = values.first().copied().unwrap_or([0.0; N]);
            let all = values.iter().fold(start, |bound, value| {
                std::array::from_fn(|axis| pick(bound[axis], value[axis]))
            });
            all.map(f64::from).to_vec()
        };
        let kind = match N {
            1 => "SCALAR",
            3 => "VEC3",
            _ => "VEC4",
        };
        let (min, max) = (bound(f32::min), bound(f32::max));
        let accessor = json!({
            "componentType": FLOAT,
            "count": values.len(),
            "type": kind,
            "min": min,
            "max": max,
        });
        self.add(bytes.collect(), target, accessor)
    }

    /// Adds indices of vertices; returns their accessor.
    pub(super) fn indices(&mut self, indices: &[u32]) -> usize {
        let bytes = indices.iter().flat_map(|index| index.to_le_bytes());
        let accessor = json!({
            "componentType": UNSIGNED_INT,
            "count": indices.len(),
            "type": "SCALAR",
        });
        self.add(bytes.collect(), Some(INDICES), accessor)
    }

    /// All components have four bytes, so that every view is aligned.
    fn add(&mut self, bytes: Vec<u8>, target: Option<u32>, mut accessor: Value) -> usize {
        let mut view = json!({
            "buffer": 0,
            "byteOffset": self.bytes.len(),
            "byteLength": bytes.len(),
        });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        accessor["bufferView"] = self.views.len().into();
        self.bytes.extend(bytes);
        self.views.push(view);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// The file: header, JSON padded with blanks, bytes.
    pub(super) fn into_glb(self, mut root: Map<String, Value>) -> Vec<u8> {
        root.insert(
            "buffers".to_owned(),
            json!([{ "byteLength": self.bytes.len() }]),
        );
        root.insert("bufferViews".to_owned(), self.views.into());
        root.insert("accessors".to_owned(), self.accessors.into());
        let mut text = Value::Object(root).to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let chunks: [(&[u8; 4], &[u8]); 2] = [(b"JSON", &text), (b"BIN\0", &self.bytes)];
        let length: usize = chunks.iter().map(|(_, bytes)| 8 + bytes.len()).sum();
        let mut file = b"glTF".to_vec();
        file.extend(2_u32.to_le_bytes());
        file.extend(size(12 + length));
        for (kind, bytes) in chunks {
            file.extend(size(bytes.len()));
            file.extend(kind);
            file.extend(bytes);
        }
        file
    }
}

/// A length, which glTF limits to 4 GiB; frames are limited to far less.
fn size(length: usize) -> [u8; 4] {
    let length = u32::try_from(length).expect("less than 4 GiB");
    length.to_le_bytes()
}
