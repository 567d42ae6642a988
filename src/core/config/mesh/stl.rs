//! STL.

use std::io::Cursor;

use super::{MeshError, Soup};

/// The triangles of a text or binary STL.
pub(super) fn soup(bytes: &[u8]) -> Result<Soup, MeshError> {
    let mesh = stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|error| MeshError::Format {
        format: "STL",
        reason: error.to_string(),
    })?;
    let corners = mesh.vertices.iter();
    let triangles = mesh.faces.iter();
    Ok(Soup {
        corners: corners.map(|p| p.0.map(f64::from)).collect(),
        triangles: triangles.map(|of| of.vertices.map(|i| i as u32)).collect(),
    })
}
