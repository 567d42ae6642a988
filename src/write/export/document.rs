//! A glTF document: its lists of nodes, meshes, materials and keys.

use std::collections::BTreeMap;
use std::f32::consts::FRAC_1_SQRT_2;

use serde_json::{Map, Value, json};

use super::buffer::{Buffer, VERTICES};
use super::frames::Key;
use crate::math::Pose;
use crate::motion::{PoseSample, Stamp};
use crate::physics::Shape;
use crate::visual::mesh;

/// Accessors of corners and of their indices; `None` of a shape without a surface.
pub(super) type Geometry = Option<[usize; 2]>;

/// A document as it grows.
pub(super) struct Document {
    /// The stamp of physical time zero.
    zero: Stamp,
    /// How long before that the file's times begin.
    pub(super) before_s: f64,
    buffer: Buffer,
    /// All but the one over them.
    nodes: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    channels: Vec<Value>,
    samplers: Vec<Value>,
}

impl Document {
    pub(super) fn new(zero: Stamp, before_s: f64) -> Self {
        Self {
            zero,
            before_s,
            buffer: Buffer::default(),
            nodes: Vec::new(),
            meshes: Vec::new(),
            materials: Vec::new(),
            channels: Vec::new(),
            samplers: Vec::new(),
        }
    }

    /// The surface of a shape at that pose.
    pub(super) fn geometry(&mut self, shape: &Shape, frame_from_shape: &Pose) -> Geometry {
        let mut corners: Vec<[f32; 3]> = Vec::new();
        let mut known: BTreeMap<[u32; 3], u32> = BTreeMap::new();
        let mut indices: Vec<u32> = Vec::new();
        for triangle in mesh(shape) {
            let of = triangle.map(|corner| {
                let at = frame_from_shape.transform_point(&corner.into());
                // One bit pattern for each number.
                let at: [f32; 3] = at.coords.map(|value| value as f32 + 0.0).into();
                *known.entry(at.map(f32::to_bits)).or_insert_with(|| {
                    corners.push(at);
                    corners.len() as u32 - 1
                })
            });
            // Of single precision some have no area.
            if of[0] != of[1] && of[1] != of[2] && of[2] != of[0] {
                indices.extend(of);
            }
        }
        if indices.is_empty() {
            return None;
        }
        let corners = self.buffer.floats(&corners, Some(VERTICES));
        Some([corners, self.buffer.indices(&indices)])
    }

    /// A geometry in a colour; colours have the names of what they stand for.
    fn mesh(&mut self, name: &str, geometry: Geometry, look: (&str, [f64; 4])) -> Option<usize> {
        let [corners, indices] = geometry?;
        let material = self.material(look.0, look.1);
        self.meshes.push(json!({
            "name": name,
            "primitives": [{
                "attributes": { "POSITION": corners },
                "indices": indices,
                "material": material,
            }],
        }));
        Some(self.meshes.len() - 1)
    }

    fn material(&mut self, name: &str, [r, g, b, a]: [f64; 4]) -> usize {
        let known = self.materials.iter().position(|of| of["name"] == name);
        known.unwrap_or_else(|| {
            let mut material = json!({
                "name": name,
                "pbrMetallicRoughness": {
                    "baseColorFactor": [linear(r), linear(g), linear(b), a],
                    "metallicFactor": 0.0,
                    "roughnessFactor": 0.7,
                },
            });
            if a < 1.0 {
                material["alphaMode"] = "BLEND".into();
            }
            self.materials.push(material);
            self.materials.len() - 1
        })
    }

    fn node(&mut self, name: &str, mesh: Option<usize>, mut node: Map<String, Value>) -> usize {
        node.insert("name".to_owned(), name.into());
        if let Some(mesh) = mesh {
            node.insert("mesh".to_owned(), mesh.into());
        }
        self.nodes.push(node.into());
        // After the one over all.
        self.nodes.len()
    }

    /// Something that stands where its corners say.
    pub(super) fn still(&mut self, name: &str, geometry: Geometry, look: (&str, [f64; 4])) {
        let mesh = self.mesh(name, geometry, look);
        self.node(name, mesh, Map::new());
    }

    /// A node with keys.
    pub(super) fn moving(
        &mut self,
        name: &str,
        geometry: Geometry,
        look: (&str, [f64; 4]),
        keys: &[Key],
    ) {
        let keys = self.timed(keys);
        let places = keys
            .iter()
            .map(|(_, sample)| single::<3>(sample.position_m.into()));
        let places: Vec<[f32; 3]> = places.collect();
        let turns = keys
            .iter()
            .map(|(_, sample)| single(sample.quaternion_xyzw));
        let turns: Vec<[f32; 4]> = turns.collect();
        let times: Vec<[f32; 1]> = keys.iter().map(|(time_s, _)| [*time_s]).collect();
        let (Some(place), Some(turn)) = (places.first(), turns.first()) else {
            return;
        };
        let at_first = Map::from_iter([
            ("translation".to_owned(), json!(place.map(f64::from))),
            ("rotation".to_owned(), json!(turn.map(f64::from))),
        ]);
        let mesh = self.mesh(name, geometry, look);
        let node = self.node(name, mesh, at_first);
        let input = self.buffer.floats(&times, None);
        let outputs = [
            ("translation", self.buffer.floats(&places, None)),
            ("rotation", self.buffer.floats(&turns, None)),
        ];
        for (path, output) in outputs {
            self.channels.push(json!({
                "sampler": self.samplers.len(),
                "target": { "node": node, "path": path },
            }));
            self.samplers.push(json!({
                "input": input,
                "output": output,
                "interpolation": "LINEAR",
            }));
        }
    }

    /// Keys with their times in the file, which increase in single precision too: of two at one time
    /// the exact one stays.
    fn timed<'k>(&self, keys: &'k [Key]) -> Vec<(f32, &'k PoseSample)> {
        let mut timed: Vec<(f32, &Key)> = Vec::new();
        for key in keys {
            let time_s = key.sample.stamp.seconds_since(self.zero) + self.before_s;
            let time_s = time_s.max(0.0) as f32;
            match timed.last() {
                Some((before_s, before)) if time_s <= *before_s => {
                    if key.is_exact && !before.is_exact {
                        timed.pop();
                        timed.push((time_s, key));
                    }
                }
                _ => timed.push((time_s, key)),
            }
        }
        let timed = timed.into_iter().map(|(time_s, key)| (time_s, &key.sample));
        timed.collect()
    }

    /// The file.
    pub(super) fn finish(self, scene: &str, program: &str, extras: Value) -> Vec<u8> {
        let below: Vec<usize> = (1..=self.nodes.len()).collect();
        // A quarter turn about x: z becomes y.
        let quarter = f64::from(FRAC_1_SQRT_2);
        let mut over = json!({ "name": "z up", "rotation": [-quarter, 0.0, 0.0, quarter] });
        if !below.is_empty() {
            over["children"] = below.into();
        }
        let nodes: Vec<Value> = [over].into_iter().chain(self.nodes).collect();
        let mut root = Map::from_iter([
            (
                "asset".to_owned(),
                json!({ "version": "2.0", "generator": program, "extras": extras }),
            ),
            ("scene".to_owned(), json!(0)),
            (
                "scenes".to_owned(),
                json!([{ "name": scene, "nodes": [0] }]),
            ),
            ("nodes".to_owned(), nodes.into()),
        ]);
        // Empty lists are not allowed.
        for (name, list) in [("meshes", self.meshes), ("materials", self.materials)] {
            if !list.is_empty() {
                root.insert(name.to_owned(), list.into());
            }
        }
        if !self.channels.is_empty() {
            let animation = json!({
                "name": scene,
                "channels": self.channels,
                "samplers": self.samplers,
            });
            root.insert("animations".to_owned(), json!([animation]));
        }
        self.buffer.into_glb(root)
    }
}

fn single<const N: usize>(values: [f64; N]) -> [f32; N] {
    values.map(|value| value as f32)
}

/// A colour's component as glTF wants it, proportional to light, of one as screens have it (sRGB).
fn linear(component: f64) -> f64 {
    if component <= 0.04045 {
        component / 12.92
    } else {
        ((component + 0.055) / 1.055).powf(2.4)
    }
}
