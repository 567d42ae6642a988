//! Meshes: vertices of OBJ files, and the frame in which their hull is a body: its centre of mass, its
//! principal axes.

use anyhow::{Context, Result, ensure};
use enact::math::Pose;
use enact::physics::shape::hull_triangles;
use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

/// The vertices of an OBJ file, `v x y z`; all else is passed over.
pub fn vertices(obj: &str) -> Result<Vec<Vector3<f64>>> {
    let lines = obj.lines().filter_map(|line| line.strip_prefix("v "));
    let vertex = |line: &str| {
        let numbers = line.split_whitespace().take(3).map(str::parse);
        let numbers: Vec<f64> = numbers.collect::<Result<_, _>>().context(line.to_owned())?;
        ensure!(numbers.len() == 3, "a vertex of {} numbers", numbers.len());
        Ok(Vector3::from_column_slice(&numbers))
    };
    lines.map(vertex).collect()
}

/// The pose of a hull's principal axes at its centre of mass, in the frame of its points: from the
/// tetrahedra between the origin and each triangle.
pub fn mesh_from_body(points_m: &[Vector3<f64>]) -> Result<Pose> {
    let (mut volume_m3, mut first_m4, mut second_m5) =
        (0.0, Vector3::zeros(), Matrix3::<f64>::zeros());
    for [a, b, c] in hull_triangles(points_m)? {
        let volume = a.dot(&b.cross(&c)) / 6.0;
        let sum = a + b + c;
        volume_m3 += volume;
        first_m4 += sum * (volume / 4.0);
        let squares = [sum, a, b, c].map(|v| v * v.transpose());
        second_m5 += squares.iter().sum::<Matrix3<f64>>() * (volume / 20.0);
    }
    ensure!(volume_m3 > 0.0, "a mesh without volume");
    let centre_m = first_m4 / volume_m3;
    let about_centre = second_m5 / volume_m3 - centre_m * centre_m.transpose();
    let mut axes = about_centre.symmetric_eigen().eigenvectors;
    if axes.determinant() < 0.0 {
        axes.set_column(2, &-axes.column(2));
    }
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix(&axes));
    Ok(Pose::from_parts(Translation3::from(centre_m), turn))
}
