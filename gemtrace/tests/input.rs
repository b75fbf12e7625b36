//! What the program says about bad input: each fault with its message.

use gemtrace::{Error, import, scene_file};
use std::path::{Path, PathBuf};

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

#[test]
fn the_cube_that_the_others_are_made_from_is_sound() {
    let (mesh, warnings) = import::mesh::read(Path::new("cube.obj"), CUBE.as_bytes()).unwrap();
    assert!(warnings.is_empty());
    assert!((mesh.volume() - 1.0).abs() < 1e-12 && mesh.facets().len() == 6);
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
    let cut = |name: &str, bytes: &[u8]| import::cut::read(Path::new(name), bytes).unwrap_err().to_string();
    assert!(cut("a.gem", &gem[..gem.len() / 2]).starts_with("a.gem: not a complete GemCad design: byte "));
    let gcs = include_bytes!("../../spectral-core/data/cuts/srb_diamond_57.gcs");
    assert!(cut("a.gcs", &gcs[..gcs.len() / 2]).starts_with("a.gcs: not a Gem Cut Studio design: "));
    assert_eq!(
        cut("a.asc", b"GemCad 5.0\n"),
        "a.asc: not a GemCad design: missing required 'g' (gear teeth) header line"
    );
    let exr = include_bytes!("../../scenes/environments/hall.exr");
    let picture =
        |bytes: &[u8]| import::environment::read(Path::new("a.exr"), bytes).unwrap_err().to_string();
    for share in [0.001, 0.3, 0.999] {
        let length = (exr.len() as f64 * share) as usize;
        let message = picture(&exr[..length]);
        assert!(message.starts_with("a.exr: not a complete OpenEXR file: "), "{message}");
    }
    assert_eq!(picture(b""), "a.exr: the file is empty");
    assert_eq!(picture(b"II*\0"), "a.exr: not an OpenEXR, Radiance HDR or PNG image");
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
    let message = mesh_error("a.stl", &stl);
    assert!(
        message.starts_with("a.stl: ") && message.contains("vertex 1") && message.contains("NaN"),
        "{message}"
    );
}

#[test]
fn open_meshes_name_a_hole() {
    let message = mesh_error("a.obj", CUBE.replace("f 5 6 7 8\n", ""));
    assert!(message.starts_with("a.obj: ") && message.contains("4 edges"), "{message}");
}

#[test]
fn inverted_and_degenerate_meshes_are_repaired_with_a_warning() {
    let inverted: String = CUBE
        .lines()
        .map(|line| match line.strip_prefix("f ") {
            Some(corners) => format!("f {}\n", corners.split(' ').rev().collect::<Vec<_>>().join(" ")),
            None => format!("{line}\n"),
        })
        .collect();
    let (mesh, warnings) = import::mesh::read(Path::new("a.obj"), inverted.as_bytes()).unwrap();
    assert!(mesh.volume() > 0.99 && warnings.len() == 1, "{warnings:?}");
    assert!(warnings[0].message.starts_with("a.obj: "), "{}", warnings[0]);
    let degenerate = format!("{CUBE}f 1 2 2\nf 3 3 3\n");
    let (mesh, warnings) = import::mesh::read(Path::new("a.obj"), degenerate.as_bytes()).unwrap();
    assert_eq!(mesh.triangles().len(), 12);
    assert!(warnings[0].message.contains('2'), "{warnings:?}");
    let message = mesh_error("a.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 3 2 1\n");
    assert!(message.contains("no volume"), "{message}");
    assert!(mesh_error("a.obj", "").contains("no triangles"));
}

#[test]
fn cuts_must_close_and_have_a_gear() {
    let sample = include_str!("../../spectral-core/data/cuts/srb_diamond_57.asc");
    let open: String = sample.lines().filter(|l| !l.starts_with("a -4")).map(|l| format!("{l}\n")).collect();
    let folder = Folder::new().with("open.asc", open).with("gear.asc", sample.replace("g 96", "g 0"));
    let message = refused_in(&folder, &stone("cut = \"open.asc\"\nmaterial = \"diamond\""));
    assert!(
        message.starts_with("scene.toml, line 6: open.asc: ") && message.contains("towards -z"),
        "{message}"
    );
    let message = refused_in(&folder, &stone("cut = \"gear.asc\"\nmaterial = \"diamond\""));
    assert!(message.starts_with("scene.toml, line 6: gear.asc: ") && message.contains("line 2"), "{message}");
    assert!(message.contains("gear"), "{message}");
}

#[test]
fn unknown_materials_get_the_nearest_of_the_scenes_and_the_catalogues() {
    let shape = "shape = \"step\"\nwidth = 5";
    let message = refused(&stone(&format!("{shape}\nmaterial = \"dimond\"")));
    assert_eq!(message, "scene.toml, line 8: unknown material 'dimond'; did you mean 'diamond'?");
    let own = "[material.pink-glass]\ncauchy = [1.5, 0.004]";
    let message = refused(&stone(&format!("{shape}\nmaterial = \"pinkglass\"\n{own}")));
    assert!(message.ends_with("did you mean 'pink-glass'?"), "{message}");
    let message = refused(&stone(&format!("{shape}\nmaterial = \"granite\"\n{own}")));
    assert!(message.contains("valid: pink-glass, ") && message.contains("diamond"), "{message}");
}

#[test]
fn materials_are_checked_where_they_stand() {
    let own = |lines: &str| {
        refused(&stone(&format!("shape = \"step\"\nmaterial = \"m\"\nwidth = 5\n[material.m]\n{lines}")))
    };
    let message = own("cauchy = [1.5, -0.004]");
    assert!(message.starts_with("scene.toml, line ") && message.contains("'m'"), "{message}");
    let message = own("cauchi = [1.5, 0.004]");
    assert_eq!(message, "scene.toml, line 10: unknown key 'cauchi'; did you mean 'cauchy'?");
    let message = own("index = 1.5\nabsorption = [{ centre = 500, sigma = 20, peek = 1 }]");
    assert_eq!(message, "scene.toml, line 11: unknown key 'peek'; did you mean 'peak'?");
    let message = own("index = 1.5\nabsorption = \"none.csv\"");
    assert_eq!(message, "scene.toml, line 9: none.csv: no such file");
    let message = own("index = \"high\"");
    assert!(
        message.starts_with("scene.toml, line 10: invalid type: string \"high\", expected f64"),
        "{message}"
    );
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
    let message = refused_in(&folder, &text);
    assert!(message.starts_with("scene.toml, line 9: t.csv, line 3: "), "{message}");
}

#[test]
fn films_of_no_size_and_of_absurd_size_are_refused() {
    let film = |lines: &str| refused(&format!("{CAMERA}[film]\n{lines}\n"));
    assert!(
        film("width = 0").starts_with("scene.toml, line 5: film size: 0 × 512 is not valid; at least 1 × 1")
    );
    let message = film("width = 99999999\nheight = 65536");
    assert!(message.contains("it would need 195312.5 GiB"), "{message}");
    let message = film("height = 99999999999");
    assert_eq!(
        message,
        "scene.toml, line 6: height = 99999999999 in [film]: expected a whole number of pixels, from 1 to 65536"
    );
    assert!(film("width = -1").contains("width = -1 in [film]: expected a whole number"));
    let spectral =
        "[film]\nwidth = 65536\nheight = 65536\n[render]\nspectral = true\nwavelengths = { count = 1024 }";
    assert!(refused(&format!("{CAMERA}{spectral}\n")).contains("GiB"));
}

#[test]
fn absurd_environments_are_refused_before_they_are_read() {
    let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec();
    png.extend(u32::MAX.wrapping_shr(1).to_be_bytes());
    png.extend(100_000u32.to_be_bytes());
    png.extend([8, 2, 0, 0, 0, 0xB4, 0xF6, 0xBF, 0x27]);
    let message = import::environment::read(Path::new("a.png"), &png).unwrap_err().to_string();
    assert!(message.contains("GiB") || message.contains("not a complete image"), "{message}");
    let hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n";
    let message = import::environment::read(Path::new("a.hdr"), hdr.as_bytes()).unwrap_err().to_string();
    assert_eq!(message, "a.hdr: 60000 × 60000 texels would need 40.2 GiB; 1 to 536870912 texels are read");
    let hdr = hdr.replace("60000", "20000");
    let message = import::environment::read(Path::new("a.hdr"), hdr.as_bytes()).unwrap_err().to_string();
    assert!(message.contains("20000 × 20000 texels (4.5 GiB) are more than 53 bytes can hold"), "{message}");
}

#[test]
fn unknown_keys_get_their_line_and_the_nearest_name() {
    let cases = [
        (format!("{CAMERA}fow = 14\n"), "line 5: unknown key 'fow' in [camera]; did you mean 'fov'?"),
        (
            format!("{CAMERA}[rendering]\n"),
            "line 5: unknown key 'rendering' in the scene; did you mean 'render'?",
        ),
        (stone("widht = 6.5"), "line 6: unknown key 'widht' in [[stone]]; did you mean 'width'?"),
        (
            format!("{CAMERA}[film]\nalpha = true\n"),
            "line 6: unknown key 'alpha' in [film]; valid: width, height, background",
        ),
        (
            stone("shape = { name = \"step\", tabel = 0.5 }\nmaterial = \"ruby\""),
            "line 6: unknown key 'tabel'; did you mean 'table'?",
        ),
        (
            format!("{CAMERA}[render]\nwavelengths = {{ counts = 3 }}\n"),
            "line 6: unknown key 'counts' in wavelengths; did you mean 'count'?",
        ),
    ];
    for (text, message) in cases {
        assert_eq!(refused(&text), format!("scene.toml, {message}"));
    }
}

#[test]
fn wrong_types_and_values_name_line_key_value_and_what_would_do() {
    let after = |lines: &str| refused(&format!("{CAMERA}{lines}\n"));
    for (lines, message) in [
        ("fov = \"wide\"", "line 5: fov = \"wide\" in [camera]: expected the full angle, degrees"),
        ("fov = nan", "line 5: fov = nan in [camera]: expected the full angle, degrees"),
        ("fov = 200", "line 5: camera.fov: 200 is not valid; an angle between 0 and 180 degrees"),
        ("up = [0, 1]", "line 5: up = [0, 1] in [camera]: expected three numbers [x, y, z]"),
        (
            "[render]\nsamples = 1.5",
            "line 6: samples = 1.5 in [render]: expected a whole number of samples a pixel",
        ),
        ("[render]\nsamples = 0", "line 6: samples: 0 is not valid; a whole number from 1 to 65536"),
        ("[render]\npolarized = 1", "line 6: polarized = 1 in [render]: expected true or false"),
        ("[render]\nleftover = \"keep\"", "line 6: unknown leftover 'keep'; valid: exit, drop"),
        (
            "[render]\nwavelengths = 3",
            "line 6: wavelengths = 3 in [render]: expected wavelengths: { count = 32",
        ),
        (
            "[render]\nwavelengths = [500, 400]",
            "line 6: wavelengths[1]: 400 is not valid; a list must ascend",
        ),
        ("[render]\nquality = \"drft\"", "line 6: unknown quality 'drft'; did you mean 'draft'"),
        ("[render]\ntolerance = -1", "line 6: tolerance: -1 is not valid; a colour difference from 0"),
        ("[render]\nthreshold = 1", "line 6: threshold: 1 is not valid; a throughput from 0"),
        (
            "[environment]\nilluminant = \"D50\"",
            "line 6: unknown illuminant 'D50'; valid: D65, A, E, or the name of a table file",
        ),
        (
            "[environment]\npreset = \"sudio\"",
            "line 6: unknown environment preset 'sudio'; did you mean 'studio'?",
        ),
        ("[environment]\nmodel = \"izo\"", "line 6: unknown light model 'izo'; did you mean 'iso'?"),
        (
            "[environment]\nmodel = \"cos\"\nhead_shadow = 95",
            "line 7: environment.head_shadow: 95 is not valid; a half-angle in degrees",
        ),
        (
            "[environment]\nmodel = \"cos\"\nhead_shadwo = 9",
            "line 7: unknown key 'head_shadwo' in [environment]; did you mean 'head_shadow'?",
        ),
        ("[environment]\nmodel = \"cos\"\nseed = 3", "line 7: unknown key 'seed' in [environment]; valid: "),
        (
            "[environment]\nmodel = \"random-patch\"\nseed = -3",
            "line 7: seed = -3 in [environment]: expected a whole number from 0 upwards",
        ),
        (
            "[environment]\nmodel = \"spots\"\nradius = 0.1",
            "line 7: environment.radius: 0.1 is not valid; a half-angle in degrees, from 0.5 to 45",
        ),
        (
            "[environment]\nmodel = \"aset\"\nzenith = [0, 0, 0]",
            "line 7: zenith = [0, 0, 0] in [environment]: expected a direction [x, y, z], or \"camera\"",
        ),
        ("[environment]\nhead_shadow = 10", "line 6: unknown key 'head_shadow' in [environment]"),
        ("[environment]\nuniform = [1, -1, 1]", "line 6: environment.uniform: [1.0, -1.0, 1.0] is not valid"),
        ("stone = 3", "line 5: unknown key 'stone' in [camera]"),
        (
            "[stone]\nwidth = 3",
            "line 5: stone = a table in the scene: expected tables, each under its own [[stone]]",
        ),
        (
            "[[stone]]\nshape = \"step\"\nmaterial = 3",
            "line 7: material = 3 in [[stone]]: expected the name of a material",
        ),
        (
            "[[stone]]\nshape = \"round\"\nmaterial = \"ruby\"",
            "line 6: unknown shape 'round'; valid: round-brilliant",
        ),
        ("film = 3", "line 5: unknown key 'film' in [camera]"),
        ("fov = ", "line 5: "),
    ] {
        let found = after(lines);
        assert!(found.starts_with(&format!("scene.toml, {message}")), "{lines}:\n{found}\n{message}");
    }
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
fn alternatives_exclude_each_other() {
    let cases = [
        (
            format!("{CAMERA}fov = 14\northographic = 8\n"),
            "line 6: [camera] has both 'fov' and 'orthographic'; it takes exactly one of 'fov' and 'orthographic'",
        ),
        (
            stone("cut = \"a.asc\"\nmesh = \"a.obj\"\nmaterial = \"ruby\""),
            "line 7: [[stone]] has both 'cut' and 'mesh'; it takes exactly one of 'cut', 'mesh' and 'shape'",
        ),
        (stone("material = \"ruby\""), "line 5: [[stone]] 1 needs exactly one of 'cut', 'mesh' and 'shape'"),
        (stone("shape = \"step\""), "line 5: [[stone]] 1 needs 'material': the name of a material"),
        (
            format!("{CAMERA}[environment]\npreset = \"studio\"\nuniform = [1, 1, 1]\n"),
            "line 7: [environment] has both 'preset' and 'uniform'; it takes exactly one of 'image', 'uniform', 'preset' and 'model'",
        ),
        (
            stone("cut = \"a.obj\"\nmaterial = \"ruby\""),
            "line 6: cut = \"a.obj\" in [[stone]]: expected a cut (.asc, .gem, .gcs) file; write mesh = … for this one",
        ),
        (
            format!("{CAMERA}[render]\nwavelengths = [500.0]\njitter = true\n"),
            "line 7: a list of wavelengths cannot jitter; give a count and a range, or jitter = false",
        ),
    ];
    for (text, message) in cases {
        assert_eq!(refused(&text), format!("scene.toml, {message}"));
    }
}

#[test]
fn the_format_must_be_known() {
    let text = CAMERA.replace("format = 1\n", "");
    assert_eq!(refused(&text), "scene.toml, line 1: a scene begins with 'format = 1', which is missing here");
    let message = refused(&CAMERA.replace("format = 1", "format = 2"));
    assert_eq!(
        message,
        "scene.toml, line 1: format = 2 in the scene: expected the version of the scene format, 1"
    );
    assert!(refused("format = 1\n").contains("the scene needs 'camera'"));
    assert!(
        refused("format = 1\n[camera]\nposition = [1, 1, 1]\n").contains("line 2: [camera] needs 'look_at'")
    );
    let folder = Folder::new().with("latin.toml", b"format = 1\n# caf\xe9\n");
    let error = scene_file::load(&folder.path("latin.toml")).unwrap_err();
    assert!(error.to_string().ends_with("line 2 is not UTF-8 text"), "{error}");
}

#[test]
fn stones_must_have_a_size_and_a_place() {
    let with = |lines: &str| refused(&stone(&format!("shape = \"step\"\nmaterial = \"ruby\"\n{lines}")));
    let message = with("width = 0");
    assert!(message.starts_with("scene.toml, line 8: stone 1 (shape): width: 0 is not valid"), "{message}");
    assert!(
        with("width = 5\nname = \"the ruby\"\nposition = [1e12, 0, 0]")
            .starts_with("scene.toml, line 10: the ruby: position")
    );
    assert!(with("priority = 1e3").contains("priority = 1e3 in [[stone]]: expected a whole number"));
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
