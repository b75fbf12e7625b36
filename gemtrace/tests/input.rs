//! What the program says about bad input: each fault with its message.

mod support;

use gemtrace::{Error, import, scene_file};
use std::path::{Path, PathBuf};
use support::{assert_matches, cases};

/// Files in a folder of their own, gone with it.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Folder(tempfile::tempdir().expect("a temporary folder"))
    }

    fn with(self, name: &str, bytes: impl AsRef<[u8]>) -> Self {
        std::fs::write(self.0.path().join(name), bytes).expect("a temporary file");
        self
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn scene(&self, text: &str) -> Result<scene_file::LoadedScene, Error> {
        scene_file::parse(text, Path::new("scene.toml"), self.0.path())
    }
}

const CAMERA: &str = "format = 1\n[camera]\nposition = [0, -20, 20]\nlook_at = [0, 0, 0]\n";
const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// The message for a scene, which must be refused.
fn refused(text: &str) -> String {
    refused_in(&Folder::new(), text)
}

fn refused_in(folder: &Folder, text: &str) -> String {
    let error = folder.scene(text).expect_err(text);
    assert_eq!(error.exit_code(), 3);
    error.to_string().replace(&format!("{}/", folder.0.path().display()), "")
}

fn stone(lines: &str) -> String {
    format!("{CAMERA}[[stone]]\n{lines}\n")
}

fn mesh_error(name: &str, bytes: impl AsRef<[u8]>) -> String {
    import::mesh::read(Path::new(name), bytes.as_ref()).expect_err(name).to_string()
}

fn picture_error(name: &str, bytes: &[u8]) -> String {
    import::environment::read(Path::new(name), bytes).expect_err(name).to_string()
}

#[test]
fn the_cube_that_the_others_are_made_from_is_sound() {
    let (mesh, warnings) = import::mesh::read(Path::new("cube.obj"), CUBE.as_bytes()).unwrap();
    assert!(warnings.is_empty());
    assert!((mesh.volume() - 1.0).abs() < 1e-12 && mesh.facets().len() == 6);
}

#[test]
fn refused_scenes_say_what_is_wrong_and_where() {
    for (text, message) in cases(include_str!("data/refused-scenes.txt")) {
        assert_matches(&refused(&format!("{CAMERA}{text}")), &format!("scene.toml, {message}"));
    }
}

#[test]
fn missing_files_are_named_with_the_nearest() {
    let folder = Folder::new().with("brilliant.asc", "");
    let message = refused_in(&folder, &stone("cut = \"briliant.asc\"\nmaterial = \"diamond\""));
    assert_eq!(message, "scene.toml, line 6: briliant.asc: no such file; did you mean 'brilliant.asc'?");
    let missing = scene_file::load(&folder.path("none.toml")).unwrap_err();
    assert!(matches!(&missing, Error::File { message, .. } if message == "no such file"), "{missing}");
    let message = refused_in(&folder, &stone("mesh = \".\"\nmaterial = \"diamond\""));
    assert!(message.contains("folder"), "{message}");
}

#[test]
fn truncated_files_say_so() {
    let gem = include_bytes!("../../spectral-core/data/cuts/srb_diamond_57.gem");
    let gcs = include_bytes!("../../spectral-core/data/cuts/srb_diamond_57.gcs");
    for (name, bytes, message) in [
        ("a.gem", &gem[..gem.len() / 2], "not a complete GemCad design: byte *"),
        ("a.gcs", &gcs[..gcs.len() / 2], "not a Gem Cut Studio design: *"),
        ("a.asc", b"GemCad 5.0\n", "not a GemCad design: missing required 'g' (gear teeth) header line"),
    ] {
        let found = import::cut::read(Path::new(name), bytes).unwrap_err().to_string();
        assert_matches(&found, &format!("{name}: {message}"));
    }
    let exr = include_bytes!("../../scenes/environments/hall.exr");
    for share in [0.001, 0.3, 0.999] {
        let length = (exr.len() as f64 * share) as usize;
        let message = picture_error("a.exr", &exr[..length]);
        assert_matches(&message, "a.exr: not a complete OpenEXR file: *");
    }
    assert_eq!(picture_error("a.exr", b""), "a.exr: the file is empty");
    assert_eq!(picture_error("a.exr", b"II*\0"), "a.exr: not an OpenEXR, Radiance HDR, PNG or JPEG image");
    let mut stl = vec![0; 84 + 49];
    stl[80] = 2;
    assert_eq!(mesh_error("a.stl", stl), "a.stl: truncated: its header announces 2 triangles, it holds 0");
}

#[test]
fn vertices_must_be_finite() {
    let with = |x: &str| CUBE.replace("v 1 1 0", &format!("v 1 {x} 0"));
    assert_eq!(mesh_error("a.obj", with("nan")), "a.obj: line 3: vertex (1, NaN, 0) is not finite");
    assert_eq!(mesh_error("a.obj", with("-inf")), "a.obj: line 3: vertex (1, -inf, 0) is not finite");
    assert_eq!(mesh_error("a.obj", with("1e999")), "a.obj: line 3: vertex (1, inf, 0) is not finite");
    let mut stl = vec![0; 80];
    stl.extend(1u32.to_le_bytes());
    for v in [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, f32::NAN, 0.0, 0.0, 0.0, 1.0, 0.0] {
        stl.extend(v.to_le_bytes());
    }
    stl.extend([0, 0]);
    assert_matches(&mesh_error("a.stl", &stl), "a.stl: *vertex 1*NaN*");
}

#[test]
fn open_meshes_name_a_hole() {
    assert_matches(&mesh_error("a.obj", CUBE.replace("f 5 6 7 8\n", "")), "a.obj: *4 edges*");
}

#[test]
fn inverted_and_degenerate_meshes_are_repaired_with_a_warning() {
    let (vertices, faces) = CUBE.split_at(CUBE.find('f').unwrap());
    let inverted = |face: &str| format!("f {}\n", face[2..].split(' ').rev().collect::<Vec<_>>().join(" "));
    let inverted = vertices.to_owned() + &faces.lines().map(inverted).collect::<String>();
    let (mesh, warnings) = import::mesh::read(Path::new("a.obj"), inverted.as_bytes()).unwrap();
    assert!(mesh.volume() > 0.99 && warnings.len() == 1, "{warnings:?}");
    assert!(warnings[0].message.starts_with("a.obj: "), "{}", warnings[0]);
    let degenerate = format!("{CUBE}f 1 2 2\nf 3 3 3\n");
    let (mesh, warnings) = import::mesh::read(Path::new("a.obj"), degenerate.as_bytes()).unwrap();
    assert_eq!(mesh.triangles().len(), 12);
    assert!(warnings[0].message.contains('2'), "{warnings:?}");
    let flat = "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 3 2 1\n";
    assert_matches(&mesh_error("a.obj", flat), "*no volume*");
    assert!(mesh_error("a.obj", "").contains("no triangles"));
}

#[test]
fn cuts_must_close_and_have_a_gear() {
    let sample = include_str!("../../spectral-core/data/cuts/srb_diamond_57.asc");
    let open: String = sample.lines().filter(|l| !l.starts_with("a -4")).map(|l| format!("{l}\n")).collect();
    let folder = Folder::new().with("open.asc", open).with("gear.asc", sample.replace("g 96", "g 0"));
    for message in ["open.asc: *towards -z*", "gear.asc: *line 2*gear*"] {
        let lines = format!("cut = \"{}\"\nmaterial = \"diamond\"", &message[..8]);
        assert_matches(&refused_in(&folder, &stone(&lines)), &format!("scene.toml, line 6: {message}"));
    }
}

#[test]
fn absorption_tables_are_read_and_their_lines_named() {
    let text = stone(
        "shape = \"step\"\nmaterial = \"m\"\nwidth = 5\n[material.m]\nindex = 1.5\nabsorption = \"t.csv\"",
    );
    let folder = Folder::new().with("t.csv", "nm,a\n400,0.1\n700,0.3\n");
    let loaded = folder.scene(&text).unwrap();
    assert!((loaded.scene.stones[0].material.absorption(550.0) - 0.2).abs() < 1e-12);
    assert_eq!(loaded.files.iter().map(|file| &file.path).collect::<Vec<_>>(), [&folder.path("t.csv")]);
    let folder = Folder::new().with("t.csv", "nm,a\n400,0.1\n700,six\n");
    assert_matches(&refused_in(&folder, &text), "scene.toml, line 9: t.csv, line 3: *");
}

#[test]
fn absurd_environments_are_refused_before_they_are_read() {
    let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec();
    png.extend(u32::MAX.wrapping_shr(1).to_be_bytes());
    png.extend(100_000u32.to_be_bytes());
    png.extend([8, 2, 0, 0, 0, 0xB4, 0xF6, 0xBF, 0x27]);
    let message = picture_error("a.png", &png);
    assert!(message.contains("GiB") || message.contains("not a complete image"), "{message}");
    let hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n";
    let message = picture_error("a.hdr", hdr.as_bytes());
    assert_eq!(message, "a.hdr: 60000 × 60000 texels would need 40.2 GiB; 1 to 536870912 texels are read");
    let message = picture_error("a.hdr", hdr.replace("60000", "20000").as_bytes());
    assert_matches(&message, "*20000 × 20000 texels (4.5 GiB) are more than 53 bytes can hold*");
}

#[test]
fn light_models_stand_about_their_zenith_and_heads_before_the_camera() {
    use glam::DVec3;
    let light = |lines: &str| {
        let text = format!("{CAMERA}[environment]\n{lines}\n");
        Folder::new().scene(&text).expect(lines).scene.environment
    };
    // The camera of these scenes stands half-way between -y and +z.
    let eye = DVec3::new(0.0, -1.0, 1.0).normalize();
    let iso = light("model = \"iso\"\nhead_shadow = 10.0");
    assert_eq!(
        [eye, DVec3::Z, DVec3::Y + DVec3::Z * 0.1, -DVec3::Z].map(|d| iso.rgb(d.normalize())[0]),
        [0.0, 1.0, 1.0, 0.0]
    );
    let aset = light("model = \"aset\"\nzenith = \"camera\"\nbelow = [1, 1, 1]");
    assert_eq!(aset.rgb(eye), [0.0, 0.0, 1.0]);
    assert_eq!(aset.rgb(-eye), [1.0; 3]);
    // Elevations of 45° and a little more or less.
    assert_eq!(aset.rgb((DVec3::Z + DVec3::Y * 0.05).normalize()), [0.0, 1.0, 0.0]);
    assert_eq!(aset.rgb((DVec3::Z - DVec3::Y * 0.05).normalize()), [1.0, 0.0, 0.0]);
    assert_ne!(light("model = \"random-patch\""), light("model = \"random-patch\"\nseed = 2"));
}

#[test]
fn the_format_must_be_known() {
    let second = "line 1: format = 2 in the scene: expected the version of the scene format, 1";
    for (text, message) in [
        (&CAMERA[11..], "line 1: a scene begins with 'format = 1', which is missing here"),
        (CAMERA.replace('1', "2").as_str(), second),
        ("format = 1\n", "*the scene needs 'camera'*"),
        ("format = 1\n[camera]\nposition = [1, 1, 1]\n", "*line 2: [camera] needs 'look_at'*"),
    ] {
        assert_matches(&refused(text), &format!("scene.toml, {message}"));
    }
    let folder = Folder::new().with("latin.toml", b"format = 1\n# caf\xe9\n");
    let error = scene_file::load(&folder.path("latin.toml")).unwrap_err();
    assert!(error.to_string().ends_with("line 2 is not UTF-8 text"), "{error}");
}

#[test]
fn a_file_that_is_named_again_is_decoded_again_only_if_it_has_changed() {
    let text = stone("mesh = \"cube.obj\"\nmaterial = \"diamond\"");
    let folder = Folder::new().with("cube.obj", CUBE);
    let mut assets = scene_file::Assets::default();
    let mut load = || {
        let loaded = assets.parse(&text, Path::new("scene.toml"), folder.0.path()).unwrap();
        (loaded.scene.stones[0].mesh.clone(), loaded.hash)
    };
    let [(first, hash), (second, same)] = [load(), load()];
    assert!(std::sync::Arc::ptr_eq(&first, &second) && hash == same);
    std::fs::write(folder.path("cube.obj"), format!("{CUBE}# larger\n")).unwrap();
    let (third, other) = load();
    assert!(!std::sync::Arc::ptr_eq(&first, &third) && hash != other);
}
