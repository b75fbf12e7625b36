//! Kinds of files that are not what they seem: other encodings of text, headers with a stray line, deep data, cube maps.

use exr::meta::attribute::EnvironmentMap;
use exr::prelude::{Encoding, Image, Layer, LayerAttributes, SpecificChannels, Vec2, WritableImage};
use gemtrace::{import, scene_file};
use spectral_core::shape::ShapeSpec;
use std::fmt::Write;
use std::io::Cursor;
use std::path::Path;

const ASC: &str = include_str!("../../spectral-core/data/cuts/srb_diamond_57.asc");
const GCS: &str = include_str!("../../spectral-core/data/cuts/srb_diamond_57.gcs");

/// A stone as OBJ, PLY and STL text.
fn meshes() -> [(&'static str, String); 3] {
    let (mesh, _) = ShapeSpec::by_name("step").unwrap().cut().unwrap().solid().unwrap();
    let (points, triangles) = (mesh.positions(), mesh.triangles());
    let (mut obj, mut stl) = (String::new(), "solid stone\n".to_owned());
    let mut ply = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        points.len(),
        triangles.len()
    );
    for p in points {
        writeln!(obj, "v {} {} {}", p.x, p.y, p.z).unwrap();
        writeln!(ply, "{} {} {}", p.x, p.y, p.z).unwrap();
    }
    for t in triangles {
        writeln!(obj, "f {} {} {}", t[0] + 1, t[1] + 1, t[2] + 1).unwrap();
        writeln!(ply, "3 {} {} {}", t[0], t[1], t[2]).unwrap();
        stl += "facet normal 0 0 0\nouter loop\n";
        for p in t.map(|v| points[v as usize]) {
            writeln!(stl, "vertex {} {} {}", p.x, p.y, p.z).unwrap();
        }
        stl += "endloop\nendfacet\n";
    }
    [("a.obj", obj), ("a.ply", ply), ("a.stl", stl + "endsolid stone\n")]
}

/// A text in UTF-8 and in both orders of UTF-16, each with its mark.
fn encodings(text: &str) -> [Vec<u8>; 3] {
    let units = || "\u{feff}".encode_utf16().chain(text.encode_utf16());
    let utf8 = format!("\u{feff}{text}").into_bytes();
    [utf8, units().flat_map(u16::to_le_bytes).collect(), units().flat_map(u16::to_be_bytes).collect()]
}

#[test]
fn text_is_read_in_any_unicode_encoding_with_a_mark() {
    for (name, text) in meshes() {
        let read =
            |bytes: &[u8]| import::mesh::read(Path::new(name), bytes).unwrap_or_else(|e| panic!("{e}"));
        let plain = read(text.as_bytes());
        for bytes in encodings(&text) {
            assert_eq!(read(&bytes), plain, "{name}");
        }
    }
    for (name, text) in [("a.asc", ASC), ("a.gcs", GCS)] {
        let read = |bytes: &[u8]| import::cut::read(Path::new(name), bytes).unwrap_or_else(|e| panic!("{e}"));
        let plain = read(text.as_bytes());
        for bytes in encodings(text) {
            assert_eq!(read(&bytes), plain, "{name}");
        }
    }
    let scene = "format = 1 # Größe, 𝔊\ncamera = { position = [0, -20, 20], look_at = [0, 0, 0] }\n";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    for bytes in encodings(scene) {
        std::fs::write(&path, &bytes).unwrap();
        let loaded = scene_file::load(&path).unwrap();
        assert_eq!(loaded.hash, scene_file::parse(scene, &path, folder.path()).unwrap().hash);
    }
    // Half a character, and half a pair.
    let [_, little, _] = encodings(scene);
    for broken in [&little[..little.len() - 1], &[0xFF, 0xFE, 0x00, 0xD8, 0x20, 0x00]] {
        std::fs::write(&path, broken).unwrap();
        let error = scene_file::load(&path).unwrap_err().to_string();
        assert!(error.contains("is not UTF-8 text"), "{error}");
    }
}

#[test]
fn faults_of_a_ply_file_are_said_in_one_sentence() {
    let [_, (_, ply), _] = meshes();
    for (from, to, expected) in [
        (
            "element vertex",
            "made by an old exporter\nelement vertex",
            "line 3 of the header, 'made by an old exporter',",
        ),
        ("float y", "floot y", "line 5 of the header, 'property floot y',"),
        ("format ascii 1.0", "format text 1.0", "line 2 of the header, 'format text 1.0',"),
        ("end_header", "end", "line 9 of the header, 'end',"),
        ("ply\n", "plz\n", "not a PLY file: its first line is not 'ply'"),
        ("\n3 0 ", "\n3 x ", "has not what the header says of the element 'face'"),
    ] {
        let error =
            import::mesh::read(Path::new("a.ply"), ply.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
        assert!(!error.contains(['\n', '{', '}']) && !error.contains("Error"), "{error}");
    }
}

#[test]
fn a_guide_tier_is_remarked_on() {
    let guide = GCS.replacen("guide=\"false\"", "guide=\"true\"", 1);
    let (_, warnings) = import::cut::read(Path::new("a.gcs"), guide.as_bytes()).unwrap();
    assert!(
        warnings.iter().any(|w| w.message.contains("is a guide tier; it is taken for facets")),
        "{warnings:?}"
    );
    let (_, warnings) = import::cut::read(Path::new("a.gcs"), GCS.as_bytes()).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
}

#[test]
fn deep_data_and_cube_maps_are_refused_by_name() {
    let refused =
        |bytes: &[u8]| import::environment::read(Path::new("a.exr"), bytes).unwrap_err().to_string();
    let deep = refused(include_bytes!("data/deep.exr"));
    assert!(deep.contains("it holds deep data"), "{deep}");
    let written = |map| {
        let attributes = LayerAttributes { environment_map: map, ..LayerAttributes::default() };
        let channels = SpecificChannels::rgb(|_: Vec2<usize>| (1.0_f32, 1.0_f32, 1.0_f32));
        let mut bytes = Cursor::new(Vec::new());
        let layer = Layer::new((4, 24), attributes, Encoding::UNCOMPRESSED, channels);
        Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    };
    let cube = refused(&written(Some(EnvironmentMap::Cube)));
    assert!(cube.contains("it is a cube map"), "{cube}");
    let map = written(Some(EnvironmentMap::LatitudeLongitude));
    assert!(import::environment::read(Path::new("a.exr"), map).is_ok());
}
