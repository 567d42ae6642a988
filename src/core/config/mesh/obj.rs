//! Wavefront OBJ.

use std::io::Cursor;

use super::{MeshError, Soup};

/// All objects of a file together; faces with more than three corners become triangles. Materials are not read.
pub(super) fn soup(bytes: &[u8]) -> Result<Soup, MeshError> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..tobj::LoadOptions::default()
    };
    let no_materials = |_: &std::path::Path| Ok(Default::default());
    let (models, _) =
        tobj::load_obj_buf(&mut Cursor::new(bytes), &options, no_materials).map_err(|error| {
            MeshError::Format {
                format: "OBJ",
                reason: error.to_string(),
            }
        })?;
    let mut soup = Soup::default();
    for model in models {
        let first = soup.corners.len() as u32;
        let corners = model.mesh.positions.chunks_exact(3);
        soup.corners.extend(corners.map(|p| [p[0], p[1], p[2]]));
        let triangles = model.mesh.indices.chunks_exact(3);
        let triangles = triangles.map(|t| [t[0], t[1], t[2]].map(|i| i.saturating_add(first)));
        soup.triangles.extend(triangles);
    }
    Ok(soup)
}
