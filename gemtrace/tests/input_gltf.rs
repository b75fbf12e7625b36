//! glTF as exporters write it: every layout gives the solid that its OBJ gives.

use gemtrace::import::mesh::{self, Selection};
use gemtrace::scene_file;
use glam::DVec3;
use serde_json::{Value, json};
use spectral_core::mesh::Mesh;
use spectral_core::shape::ShapeSpec;
use std::path::Path;

fn stone() -> Mesh {
    ShapeSpec::by_name("step").unwrap().cut().unwrap().solid().unwrap().0
}

/// A file that is being written.
#[derive(Default)]
struct File {
    bin: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl File {
    fn view(&mut self, bytes: &[u8], stride: Option<usize>) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len() });
        if let Some(stride) = stride {
            view["byteStride"] = stride.into();
        }
        self.bin.extend(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Positions in the format's frame, 32-bit floats.
    fn positions(&mut self, points: &[DVec3]) -> usize {
        let view = self.view(&floats(points), None);
        self.accessor(
            json!({ "bufferView": view, "componentType": 5126, "count": points.len(), "type": "VEC3" }),
        )
    }

    fn indices(&mut self, triangles: &[[u32; 3]]) -> usize {
        let bytes: Vec<u8> =
            triangles.as_flattened().iter().flat_map(|v| (*v as u16).to_le_bytes()).collect();
        let (view, count) = (self.view(&bytes, None), 3 * triangles.len());
        self.accessor(json!({ "bufferView": view, "componentType": 5123, "count": count, "type": "SCALAR" }))
    }

    /// The document with its nodes; the first is the scene's root.
    fn document(&self, primitive: Value, nodes: Value, uri: Option<&str>) -> Value {
        let mut buffer = json!({ "byteLength": self.bin.len() });
        if let Some(uri) = uri {
            buffer["uri"] = uri.into();
        }
        json!({
            "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": nodes,
            "meshes": [{ "name": "stone", "primitives": [primitive] }],
            "accessors": self.accessors, "bufferViews": self.views, "buffers": [buffer],
        })
    }
}

fn floats(points: &[DVec3]) -> Vec<u8> {
    points.iter().flat_map(|p| p.to_array()).flat_map(|c| (c as f32).to_le_bytes()).collect()
}

/// The container of a .glb (glTF 2.0, 4.4).
fn glb(document: &Value, bin: &[u8]) -> Vec<u8> {
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bin = bin.to_vec();
    bin.resize(bin.len().next_multiple_of(4), 0);
    let length = 12 + 8 + text.len() + 8 + bin.len();
    let mut file = b"glTF".to_vec();
    file.extend([2, length as u32, text.len() as u32].into_iter().flat_map(u32::to_le_bytes));
    file.extend(b"JSON");
    file.extend(text);
    file.extend((bin.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(bin);
    file
}

/// Positions in the format's frame, where +y is up.
fn y_up(mesh: &Mesh) -> Vec<DVec3> {
    mesh.positions().iter().map(|p| DVec3::new(p.x, p.z, -p.y)).collect()
}

/// Every layout: its name, and its bytes as .glb.
fn layouts(stone: &Mesh) -> Vec<(&'static str, Vec<u8>)> {
    let (points, triangles) = (y_up(stone), stone.triangles());
    let root = || json!([{ "mesh": 0, "name": "gem" }]);
    let plain = |nodes: Value, points: &[DVec3]| {
        let mut file = File::default();
        let primitive = json!({ "attributes": { "POSITION": file.positions(points) }, "indices": file.indices(triangles) });
        glb(&file.document(primitive, nodes, None), &file.bin)
    };
    let mut all = vec![("plain", plain(root(), &points))];

    let mut file = File::default();
    let mixed: Vec<u8> = floats(&points).chunks(12).flat_map(|p| [p, [7; 12].as_slice()].concat()).collect();
    let view = file.view(&mixed, Some(24));
    let count = points.len();
    let at =
        file.accessor(json!({ "bufferView": view, "componentType": 5126, "count": count, "type": "VEC3" }));
    let normal = file.accessor(json!({ "bufferView": view, "byteOffset": 12, "componentType": 5126, "count": count, "type": "VEC3" }));
    let primitive =
        json!({ "attributes": { "POSITION": at, "NORMAL": normal }, "indices": file.indices(triangles) });
    all.push(("interleaved", glb(&file.document(primitive, root(), None), &file.bin)));

    let mut file = File::default();
    let moved: Vec<DVec3> =
        points.iter().enumerate().map(|(k, p)| if k < 5 { DVec3::ZERO } else { *p }).collect();
    let at = file.positions(&moved);
    let (places, values) = (file.view(&[0, 1, 2, 3, 4], None), file.view(&floats(&points[..5]), None));
    file.accessors[at]["sparse"] = json!({ "count": 5, "indices": { "bufferView": places, "componentType": 5121 }, "values": { "bufferView": values } });
    let primitive = json!({ "attributes": { "POSITION": at }, "indices": file.indices(triangles) });
    all.push(("sparse", glb(&file.document(primitive, root(), None), &file.bin)));

    let mut file = File::default();
    let whole: Vec<u8> = points
        .iter()
        .flat_map(|p| (*p * 20_000.0).round().to_array().into_iter().chain([0.0]))
        .flat_map(|c| (c as i16).to_le_bytes())
        .collect();
    let view = file.view(&whole, Some(8));
    let at = file.accessor(json!({ "bufferView": view, "componentType": 5122, "normalized": true, "count": count, "type": "VEC3" }));
    let primitive = json!({ "attributes": { "POSITION": at }, "indices": file.indices(triangles) });
    let scale = 32_767.0 / 20_000.0;
    let mut document = file.document(primitive, json!([{ "mesh": 0, "scale": [scale, scale, scale] }]), None);
    document["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    document["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    all.push(("quantized", glb(&document, &file.bin)));

    let quarter = std::f64::consts::FRAC_1_SQRT_2;
    let nested = json!([
        { "name": "root", "children": [1], "scale": [2.0, 2.0, 2.0], "translation": [1.0, 2.0, 3.0] },
        { "name": "turned", "children": [2], "rotation": [0.0, quarter, 0.0, quarter] },
        { "name": "gem", "mesh": 0, "matrix": [0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 4, 5, 6, 1] },
    ]);
    all.push(("nested transforms", plain(nested, &points)));
    all.push(("negative scale", plain(json!([{ "mesh": 0, "scale": [-1.0, 1.0, 1.0] }]), &points)));

    // trimesh: 32-bit indices before positions, a world node above.
    let mut file = File::default();
    let long: Vec<u8> = triangles.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
    let view = file.view(&long, None);
    let corners = file.accessor(json!({ "bufferView": view, "componentType": 5125, "count": 3 * triangles.len(), "type": "SCALAR", "min": [0], "max": [count - 1] }));
    let primitive =
        json!({ "attributes": { "POSITION": file.positions(&points) }, "indices": corners, "mode": 4 });
    let world = json!([{ "name": "world", "children": [1] }, { "name": "geometry_0", "mesh": 0 }]);
    all.push(("trimesh", glb(&file.document(primitive, world, None), &file.bin)));

    // Blender: a vertex for every corner, so that each has its own normal and texture coordinates, a material with extensions.
    let mut file = File::default();
    let corners: Vec<DVec3> = triangles.as_flattened().iter().map(|v| points[*v as usize]).collect();
    let own: Vec<[u32; 3]> = (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let attributes = json!({ "POSITION": file.positions(&corners), "NORMAL": file.positions(&corners) });
    let primitive = json!({ "attributes": attributes, "indices": file.indices(&own), "material": 0 });
    let mut document = file.document(primitive, json!([{ "mesh": 0, "name": "Diamond.001" }]), None);
    document["materials"] = json!([{
        "name": "ice", "doubleSided": true, "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0 },
        "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_ior": { "ior": 2.4 } },
    }]);
    document["extensionsUsed"] = json!(["KHR_materials_transmission", "KHR_materials_ior"]);
    all.push(("Blender", glb(&document, &file.bin)));

    // three.js: no indices, a matrix on every node.
    let mut file = File::default();
    let primitive = json!({ "mode": 4, "attributes": { "POSITION": file.positions(&corners) } });
    let nodes = json!([{ "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] }]);
    all.push(("three.js", glb(&file.document(primitive, nodes, None), &file.bin)));
    all
}

fn obj(mesh: &Mesh) -> String {
    let points = mesh.positions().iter().map(|p| format!("v {} {} {}\n", p.x as f32, p.y as f32, p.z as f32));
    let faces = mesh.triangles().iter().map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1));
    points.chain(faces).collect()
}

#[test]
fn every_layout_has_the_volume_of_its_obj() {
    let stone = stone();
    let (wanted, _) = mesh::read(Path::new("a.obj"), obj(&stone)).unwrap();
    let layouts = layouts(&stone);
    assert!(layouts.len() >= 9);
    for (name, bytes) in layouts {
        let (found, warnings) =
            mesh::read(Path::new("a.glb"), bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        // Sixteen bits of the quantised one round to 2.5e-5.
        let most = if name == "quantized" { 1e-4 } else { 1e-6 };
        assert!((found.volume() / wanted.volume() - 1.0).abs() < most, "{name}: {}", found.volume());
        assert_eq!(found.facets().len(), wanted.facets().len(), "{name}");
        assert!(!warnings.iter().any(|w| w.message.contains("inside out")), "{name}: {warnings:?}");
        // The table's normal is +z again.
        let height = |mesh: &Mesh| mesh.bounds().1.z - mesh.bounds().0.z;
        assert!((height(&found) / height(&wanted) - 1.0).abs() < 1e-3, "{name}");
    }
}

#[test]
fn buffers_may_be_within_or_beside() {
    use base64::{Engine as _, engine::general_purpose::STANDARD};
    let stone = stone();
    let mut file = File::default();
    let points = y_up(&stone);
    let primitive = json!({ "attributes": { "POSITION": file.positions(&points) }, "indices": file.indices(stone.triangles()) });
    let root = || json!([{ "mesh": 0, "name": "gem" }]);
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("parts")).unwrap();
    std::fs::write(folder.path().join("parts/the stone.bin"), &file.bin).unwrap();
    let data = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&file.bin));
    for uri in [data.as_str(), "parts/the%20stone.bin"] {
        let path = folder.path().join("a.gltf");
        let document = file.document(primitive.clone(), root(), Some(uri)).to_string();
        std::fs::write(&path, &document).unwrap();
        let (found, _) = mesh::read(&path, document.as_bytes()).unwrap();
        assert!((found.volume() / stone.volume() - 1.0).abs() < 1e-6);
        let text = "format = 1\ncamera = { position = [0, -20, 20], look_at = [0, 0, 0] }\n[[stone]]\nmesh = 'a.gltf'\nmaterial = 'ruby'\n";
        let loaded = scene_file::parse(text, "scene.toml".as_ref(), folder.path()).unwrap();
        // What is beside belongs to the input, too.
        assert_eq!(loaded.files.len(), if uri.starts_with("data:") { 1 } else { 2 });
    }
    for (uri, message) in [
        ("../a.bin", "only files in its own folder or below"),
        ("/etc/hostname", "only files in its own folder or below"),
        ("https://example.org/a.bin", "only files in its own folder or below"),
        ("gone.bin", "no such file"),
        ("data:,x", "is not base64"),
        ("data:x;base64,AAAA", "truncated: a buffer of"),
    ] {
        let document = file.document(primitive.clone(), root(), Some(uri)).to_string();
        let error = mesh::read(&folder.path().join("a.gltf"), document.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(message), "{uri}: {error}");
    }
}

#[test]
fn damaged_files_are_errors() {
    let whole = layouts(&stone()).remove(0).1;
    for end in (0..whole.len()).step_by(97) {
        assert!(mesh::read(Path::new("a.glb"), &whole[..end]).is_err(), "{end}");
    }
    let text = |change: &dyn Fn(&mut Value)| {
        let mut file = File::default();
        let (points, triangles) = (y_up(&stone()), stone().triangles().to_vec());
        let primitive = json!({ "attributes": { "POSITION": file.positions(&points) }, "indices": file.indices(&triangles) });
        let mut document = file.document(primitive, json!([{ "mesh": 0, "children": [1] }, {}]), None);
        change(&mut document);
        mesh::read(Path::new("a.glb"), glb(&document, &file.bin)).unwrap_err().to_string()
    };
    let changes: [(Change, &str); 7] = [
        (&|d| d["nodes"][1]["children"] = json!([0]), "nodes form a tree"),
        (&|d| d["accessors"][0]["count"] = json!(1_000_000), "reaches beyond its buffer"),
        (&|d| d["accessors"][1]["componentType"] = json!(5126), "indices are whole numbers"),
        (&|d| d["bufferViews"][0]["byteLength"] = json!(1 << 30), "reaches beyond its buffer"),
        (&|d| d["nodes"][0]["mesh"] = json!(9), "damaged"),
        (&|d| d["meshes"][0]["primitives"][0]["mode"] = json!(0), "it holds no triangles"),
        (&|d| d["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]), "export without compression"),
    ];
    for (change, message) in changes {
        let error = text(change);
        assert!(error.contains(message), "{message}: {error}");
    }
}

/// What is done to a document.
type Change<'a> = &'a dyn Fn(&mut Value);

/// Two meshes below one node.
fn two() -> Vec<u8> {
    let stone = stone();
    let mut file = File::default();
    let points = y_up(&stone);
    let primitive = |file: &mut File, material: usize| json!({ "attributes": { "POSITION": file.positions(&points) }, "indices": file.indices(stone.triangles()), "material": material });
    let (gem, setting) = (primitive(&mut file, 0), primitive(&mut file, 1));
    let nodes = json!([
        { "name": "ring", "children": [1, 2, 3] }, { "name": "gem", "mesh": 0 },
        { "name": "setting", "mesh": 1, "translation": [9, 0, 0], "scale": [2, 2, 2] },
        { "name": "eye", "camera": 0, "translation": [0, 30, 0], "rotation": [-std::f64::consts::FRAC_1_SQRT_2, 0, 0, std::f64::consts::FRAC_1_SQRT_2] },
    ]);
    let mut document = file.document(gem, nodes, None);
    document["meshes"].as_array_mut().unwrap().push(json!({ "primitives": [setting] }));
    document["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }]);
    document["animations"] = json!([{ "channels": [], "samplers": [] }]);
    document["materials"] = json!([
        { "name": "pink ice", "extensions": {
            "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_ior": { "ior": 1.77 },
            "KHR_materials_dispersion": { "dispersion": 0.25 },
            "KHR_materials_volume": { "attenuationColor": [0.8, 0.2, 0.3], "attenuationDistance": 4.0 } } },
        { "name": "yellow", "pbrMetallicRoughness": { "baseColorFactor": [1.0, 0.77, 0.31, 1], "roughnessFactor": 0.3 } },
    ]);
    glb(&document, &file.bin)
}

#[test]
fn one_of_several_is_chosen_by_any_of_its_names() {
    let path = Path::new("ring.glb");
    let volume = |object: &str| {
        let selection = Selection { object: Some(object.to_owned()), ..Selection::default() };
        mesh::read_part(path, two(), &selection).map(|(mesh, _)| mesh.volume())
    };
    let (all, warnings) = mesh::read(path, two()).unwrap();
    let remark =
        "it holds 2 objects: gem, setting, of 2 materials: pink ice, yellow; together they are one stone";
    assert!(warnings.iter().any(|w| w.message.contains(remark)), "{warnings:?}");
    let gem = volume("gem").unwrap();
    assert!((all.volume() / gem - 9.0).abs() < 1e-5 && (volume("setting").unwrap() / gem - 8.0).abs() < 1e-5);
    assert_eq!((volume("pink ice").unwrap(), volume("stone").unwrap()), (gem, gem));
    assert!((volume("ring").unwrap() / all.volume() - 1.0).abs() < 1e-12);
    let error = volume("gems").unwrap_err().to_string();
    assert_eq!(error, "ring.glb: unknown object 'gems'; did you mean 'gem'?");

    let text = "o band\nusemtl gold\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n\
                o gem\nusemtl diamond\nv 5 0 0\nv 7 0 0\nv 5 2 0\nv 5 0 2\nf 5 7 6\nf 5 6 8\nf 6 7 8\nf 7 5 8\n";
    for (object, volume) in [("band", 1.0), ("gold", 1.0), ("gem", 8.0), ("diamond", 8.0)] {
        let selection = Selection { object: Some(object.to_owned()), ..Selection::default() };
        let (mesh, warnings) = mesh::read_part(Path::new("a.obj"), text, &selection).unwrap();
        assert!((mesh.volume() * 6.0 - volume).abs() < 1e-12 && warnings.is_empty(), "{object}");
    }
    let (_, warnings) = mesh::read(Path::new("a.obj"), text).unwrap();
    assert!(
        warnings[0].message.contains("2 objects: band, gem, of 2 materials: gold, diamond"),
        "{warnings:?}"
    );
}

#[test]
fn a_scene_is_written_from_what_a_file_holds() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ring.glb");
    std::fs::write(&path, two()).unwrap();
    let text = scene_file::sketch(&path, "ring.glb").unwrap();
    let loaded = scene_file::parse(&text, "ring.toml".as_ref(), folder.path())
        .unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert_eq!(loaded.scene.stones.len(), 2);
    let [gem, setting] = loaded.scene.stones.as_slice() else { panic!("two stones") };
    // n_d, V = 20/0.25 and the colour at its distance.
    assert!((gem.material.index(587.56) - 1.77).abs() < 1e-5);
    let abbe = (gem.material.index(587.56) - 1.0) / (gem.material.index(486.13) - gem.material.index(656.27));
    assert!((abbe - 80.0).abs() < 0.1, "{abbe}");
    assert!(gem.material.absorption(640.0) < gem.material.absorption(520.0));
    assert!(setting.material.is_conductor() && text.contains("nearest measured metal is gold"), "{text}");
    assert!((loaded.scene.camera.position - DVec3::new(0.0, 0.0, 30.0)).length() < 1e-5, "{text}");
    let down = (loaded.scene.camera.look_at - loaded.scene.camera.position).normalize();
    assert!(
        (down + DVec3::Z).length() < 1e-5 && text.contains("Left out") && text.contains("1 animation"),
        "{text}"
    );
}
