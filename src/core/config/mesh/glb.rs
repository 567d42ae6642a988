//! Binary glTF: the meshes of the default scene, at their places. glTF is y-up by its specification (3.4); a scene is
//! z-up, and so is what comes out of here.

use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;
use gltf::{Accessor, Document, Gltf, Node, Semantic};
use nalgebra::{Matrix4, Point3};

use super::{MeshError, Soup};

/// Deepest nesting of nodes: deeper is a circle.
const DEPTH: usize = 64;

/// Most corners and triangles of all nodes together: what a decomposition can still work on. Many nodes may
/// show one mesh.
const MOST: usize = 10_000_000;

/// From glTF's axes, y up and z ahead, to those of a scene: x, −z, y.
const Z_UP: Matrix4<f64> = Matrix4::new(
    1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0,
);

pub(super) fn soup(bytes: &[u8]) -> Result<Soup, MeshError> {
    let (document, blob) = checked(bytes)?;
    let blob = blob.ok_or(MeshError::Elsewhere)?;
    let mut soup = Soup::default();
    let scene = document.default_scene();
    let scene = scene.or_else(|| document.scenes().next());
    for node in scene.ok_or(MeshError::Empty)?.nodes() {
        add(&node, &Z_UP, &blob, 0, &mut soup)?;
    }
    Ok(soup)
}

/// The validated file and its binary part.
///
/// The library's own validation looks the positions' bounds up before it has checked that there is such
/// an accessor, and panics where there is none (gltf-json 1.4.1, `primitive_validate_hook`): that is
/// checked here first.
fn checked(bytes: &[u8]) -> Result<(Document, Option<Vec<u8>>), MeshError> {
    let said = |error: gltf::Error| format(error.to_string());
    let file = Gltf::from_slice_without_validation(bytes).map_err(said)?;
    let root = file.document.into_json();
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let mut accessors = primitives.flat_map(|primitive| primitive.attributes.values());
    if accessors.any(|accessor| root.get(*accessor).is_none()) {
        return Err(format("a mesh whose corners are not in the file"));
    }
    Ok((Document::from_json(root).map_err(said)?, file.blob))
}

fn format(reason: impl Into<String>) -> MeshError {
    MeshError::Format {
        format: "glTF",
        reason: reason.into(),
    }
}

/// Appends the meshes of a node and of those below it.
fn add(
    node: &Node,
    world_from_parent: &Matrix4<f64>,
    blob: &[u8],
    depth: usize,
    soup: &mut Soup,
) -> Result<(), MeshError> {
    if depth > DEPTH {
        return Err(format("nodes below one another in a circle"));
    }
    let own = Matrix4::from(node.transform().matrix()).map(f64::from);
    let world_from_node = world_from_parent * own;
    for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
        if primitive.mode() != Mode::Triangles {
            return Err(MeshError::NotRead("lines, points, strips or fans"));
        }
        let Some(positions) = primitive.get(&Semantic::Positions) else {
            continue;
        };
        let first = soup.corners.len();
        let corners = Elements::new(&positions, blob, DataType::F32, Dimensions::Vec3)?;
        let count = corners.count;
        let indices: Vec<u32> = match primitive.indices() {
            None => (0..count as u32).collect(),
            Some(accessor) => {
                let data = accessor.data_type();
                let elements = Elements::new(&accessor, blob, data, Dimensions::Scalar)?;
                let number = |bytes: &[u8]| {
                    let digits = bytes.iter().rev();
                    digits.fold(0_u32, |sum, byte| sum << 8 | u32::from(*byte))
                };
                (0..elements.count)
                    .map(|at| number(elements.at(at)))
                    .collect()
            }
        };
        if first + count > MOST || soup.triangles.len() + indices.len() / 3 > MOST {
            return Err(format("more than ten million corners or triangles"));
        }
        if indices.iter().any(|index| *index as usize >= count) {
            return Err(format("a triangle with a corner that is not there"));
        }
        for at in 0..count {
            let bytes = corners.at(at);
            let number = |axis: usize| {
                let own = &bytes[4 * axis..4 * axis + 4];
                f64::from(f32::from_le_bytes([own[0], own[1], own[2], own[3]]))
            };
            let point = Point3::new(number(0), number(1), number(2));
            soup.corners
                .push(world_from_node.transform_point(&point).coords.into());
        }
        let triangles = indices.chunks_exact(3);
        let numbered = |t: &[u32]| [t[0], t[1], t[2]].map(|index| index + first as u32);
        soup.triangles.extend(triangles.map(numbered));
    }
    for child in node.children() {
        add(&child, &world_from_node, blob, depth + 1, soup)?;
    }
    Ok(())
}

/// The elements of an accessor, which lie within the file.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl<'a> Elements<'a> {
    /// Fails where they are of another kind, compressed or sparse, or not all in the file.
    fn new(
        accessor: &Accessor,
        blob: &'a [u8],
        data: DataType,
        dimensions: Dimensions,
    ) -> Result<Self, MeshError> {
        if accessor.data_type() != data || accessor.dimensions() != dimensions {
            return Err(MeshError::NotRead(
                "positions or indices of an unusual type",
            ));
        }
        if accessor.sparse().is_some() {
            return Err(MeshError::NotRead("sparse data"));
        }
        let Some(view) = accessor.view() else {
            return Err(MeshError::NotRead("data that are not in the file"));
        };
        if !matches!(view.buffer().source(), gltf::buffer::Source::Bin) {
            return Err(MeshError::Elsewhere);
        }
        let (size, count) = (accessor.size(), accessor.count());
        let stride = view.stride().unwrap_or(size);
        let missing = || format("data that go beyond the end of the file");
        let from = view.offset().checked_add(accessor.offset());
        let from = from.ok_or_else(missing)?;
        let length = count.saturating_sub(1).checked_mul(stride);
        let length = length.and_then(|length| length.checked_add(size));
        let to = length.and_then(|length| from.checked_add(length));
        let bytes = blob
            .get(from..to.ok_or_else(missing)?)
            .ok_or_else(missing)?;
        Ok(Self {
            bytes,
            stride,
            size,
            count,
        })
    }

    fn at(&self, index: usize) -> &'a [u8] {
        let from = index * self.stride;
        &self.bytes[from..from + self.size]
    }
}
