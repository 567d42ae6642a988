//! Meshes of files: OBJ, STL, binary glTF.

mod glb;
mod obj;
mod stl;

use nalgebra::Vector3;
use thiserror::Error;

use crate::physics::ShapeError;
use crate::physics::shape::TriangleMesh;

/// Why a mesh is refused.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MeshError {
    /// The bytes are none of the format.
    #[error("cannot be read as {format}: {reason}")]
    Format {
        /// OBJ, STL or glTF.
        format: &'static str,
        /// What its reader says.
        reason: String,
    },
    /// The geometry is in another file.
    #[error(
        "its geometry is in another file or in its text, expected a binary glTF: export it as .glb"
    )]
    Elsewhere,
    /// Something of a glTF that is not read.
    #[error("has {0}, which is not read: export it as triangles without it")]
    NotRead(&'static str),
    /// There is nothing to make a solid of.
    #[error("has no triangles, expected a surface")]
    Empty,
    /// It is no solid.
    #[error(transparent)]
    Shape(#[from] ShapeError),
}

/// Formats of meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront OBJ.
    Obj,
    /// STL, as text or binary.
    Stl,
    /// glTF 2.0 in one binary file.
    Glb,
}

impl MeshFormat {
    /// By the ending of a file's name, in any case: `obj`, `stl`, `glb`, `gltf`.
    pub fn of_ending(ending: &str) -> Option<Self> {
        match ending.to_ascii_lowercase().as_str() {
            "obj" => Some(Self::Obj),
            "stl" => Some(Self::Stl),
            "glb" | "gltf" => Some(Self::Glb),
            _ => None,
        }
    }
}

/// Corners and triangles as a file has them.
#[derive(Clone, Debug, Default, PartialEq)]
struct Soup {
    corners: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

/// The closed surface in the bytes of a file, whose unit is so many metres; with `take_hull` its convex hull,
/// whatever is open.
///
/// Fails where the bytes are none of the format, and where the surface is no closed one.
pub(super) fn mesh(
    bytes: &[u8],
    format: MeshFormat,
    unit_m: f64,
    take_hull: bool,
) -> Result<TriangleMesh, MeshError> {
    let soup = match format {
        MeshFormat::Obj => obj::soup(bytes)?,
        MeshFormat::Stl => stl::soup(bytes)?,
        MeshFormat::Glb => glb::soup(bytes)?,
    };
    if soup.triangles.is_empty() {
        return Err(MeshError::Empty);
    }
    let corners = soup.corners.iter();
    let corners_m: Vec<Vector3<f64>> = corners.map(|p| Vector3::from(*p) * unit_m).collect();
    if take_hull {
        return Ok(TriangleMesh::hull(&corners_m)?);
    }
    // Corners of other objects of the file, which no triangle has, are none of it.
    let mut number = vec![None; corners_m.len()];
    let mut used = Vec::new();
    let mut triangles = Vec::with_capacity(soup.triangles.len());
    for triangle in &soup.triangles {
        let mut new = [0; 3];
        for (to, from) in new.iter_mut().zip(triangle) {
            let place = number.get_mut(*from as usize);
            let place = place.ok_or(ShapeError::Point {
                index: *from as usize,
            })?;
            *to = *place.get_or_insert_with(|| {
                used.push(corners_m[*from as usize]);
                used.len() as u32 - 1
            });
        }
        triangles.push(new);
    }
    Ok(TriangleMesh::new(&used, &triangles)?)
}

#[cfg(test)]
mod tests;
