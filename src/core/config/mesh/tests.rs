use proptest::prelude::*;

use super::*;

/// A box of 1 × 2 × 3 as OBJ, its faces quadrilaterals.
const BOX_OBJ: &str = "\
v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nv 0 0 3\nv 1 0 3\nv 1 2 3\nv 0 2 3\n\
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

fn box_soup() -> Soup {
    obj::soup(BOX_OBJ.as_bytes()).expect("an OBJ")
}

/// The same as binary STL.
fn box_stl() -> Vec<u8> {
    let soup = box_soup();
    let mut bytes = vec![0; 80];
    bytes.extend((soup.triangles.len() as u32).to_le_bytes());
    for triangle in &soup.triangles {
        bytes.extend([0; 12]);
        for corner in triangle.map(|i| soup.corners[i as usize]) {
            bytes.extend(corner.iter().flat_map(|x| (*x as f32).to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

/// The same as binary glTF, below a node that moves and doubles it.
fn box_glb() -> Vec<u8> {
    let soup = box_soup();
    let mut blob: Vec<u8> = Vec::new();
    for corner in &soup.corners {
        blob.extend(corner.iter().flat_map(|x| (*x as f32).to_le_bytes()));
    }
    let indices = blob.len();
    for index in soup.triangles.iter().flatten() {
        blob.extend((*index as u16).to_le_bytes());
    }
    let (length, count) = (blob.len(), 3 * soup.triangles.len());
    while !blob.len().is_multiple_of(4) {
        blob.push(0);
    }
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"children":[1],"scale":[2,2,2],"translation":[5,0,0]}},{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "buffers":[{{"byteLength":{length}}}],
        "bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":{indices}}},
        {{"buffer":0,"byteOffset":{indices},"byteLength":{}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":8,"type":"VEC3","min":[0,0,0],"max":[1,2,3]}},
        {{"bufferView":1,"componentType":5123,"count":{count},"type":"SCALAR"}}]}}"#,
        length - indices
    );
    while json.len() % 4 != 0 {
        json.push(' ');
    }
    let mut bytes = b"glTF".to_vec();
    let total = 12 + 8 + json.len() + 8 + blob.len();
    bytes.extend([2_u32, total as u32].into_iter().flat_map(u32::to_le_bytes));
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json.as_bytes());
    bytes.extend((blob.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(blob);
    bytes
}

#[test]
fn every_format_gives_the_box() {
    for (bytes, format, unit_m, volume_m3, x_m) in [
        (
            BOX_OBJ.as_bytes().to_vec(),
            MeshFormat::Obj,
            0.01,
            6e-6,
            0.005,
        ),
        (box_stl(), MeshFormat::Stl, 0.001, 6e-9, 0.0005),
        (box_glb(), MeshFormat::Glb, 1.0, 48.0, 6.0),
    ] {
        // What is up in a file of glTF is y.
        let upright = match format {
            MeshFormat::Glb => [-3.0, 2.0],
            _ => [1.0, 1.5].map(|of| of * unit_m),
        };
        let mass = mesh(&bytes, format, unit_m, false)
            .expect("a mesh")
            .mass()
            .unwrap();
        assert!(
            (mass.volume_m3 / volume_m3 - 1.0).abs() < 1e-6,
            "{format:?} {mass:?}"
        );
        assert!(
            (mass.centre_m.x / x_m - 1.0).abs() < 1e-6,
            "{format:?} {mass:?}"
        );
        let found = [mass.centre_m.y, mass.centre_m.z];
        for (found, expected) in found.into_iter().zip(upright) {
            assert!((found / expected - 1.0).abs() < 1e-6, "{format:?} {mass:?}");
        }
    }
}

#[test]
fn what_is_no_solid_is_refused_with_what_to_do() {
    let said = |bytes: &[u8], format| mesh(bytes, format, 1.0, false).unwrap_err().to_string();
    let open = BOX_OBJ.replace("f 1 4 3 2\n", "");
    assert!(said(open.as_bytes(), MeshFormat::Obj).contains("not closed: 4 of its"));
    assert!(mesh(open.as_bytes(), MeshFormat::Obj, 1.0, true).is_ok());
    assert!(said(b"v 0 0 0\n", MeshFormat::Obj).contains("no triangles"));
    assert!(said(b"solid x\nendsolid x\n", MeshFormat::Stl).contains("no triangles"));
    let gltf = br#"{"asset":{"version":"2.0"}}"#;
    assert!(said(gltf, MeshFormat::Glb).contains("export it as .glb"));
    assert!(said(b"glTF", MeshFormat::Glb).contains("cannot be read as glTF"));
    // One digit of the JSON changed: a number of what is not there, or more of it than there is.
    for (of, digit, expected) in [
        (r#""count":3"#, b'9', "beyond the end"),
        (r#""POSITION":0"#, b'9', "corners are not in the file"),
        (r#""indices":1"#, b'9', "indices"),
        (r#""bufferView":0"#, b'9', "bufferView"),
        (r#""scene":0"#, b'9', "scene"),
        (r#""mesh":0"#, b'9', "mesh"),
    ] {
        let mut bytes = box_glb();
        let at = bytes.windows(of.len()).position(|own| own == of.as_bytes());
        bytes[at.expect(of) + of.len() - 1] = digit;
        let said = said(&bytes, MeshFormat::Glb);
        assert!(said.contains(expected), "{of}: {said}");
    }
}

proptest! {
    /// Whatever the bytes: a mesh or an error.
    #[test]
    fn damaged_files_never_panic(
        which in 0_usize..3,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..8),
        length in any::<prop::sample::Index>(),
        is_cut in any::<bool>(),
    ) {
        let (mut bytes, format) = match which {
            0 => (BOX_OBJ.as_bytes().to_vec(), MeshFormat::Obj),
            1 => (box_stl(), MeshFormat::Stl),
            _ => (box_glb(), MeshFormat::Glb),
        };
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if is_cut {
            bytes.truncate(length.index(bytes.len()));
        }
        if let Ok(mesh) = mesh(&bytes, format, 1.0, false) {
            prop_assert!(mesh.mass().is_ok_and(|mass| mass.volume_m3 > 0.0));
        }
    }
}
