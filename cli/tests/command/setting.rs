//! What stones stand on, how often and how they are held: `at`, `[pose]`, `[ground]`, and a coloured background.

use super::read::Png;
use super::support::{SCENE, Workplace, assert_matches};
use gemtrace::Session;
use gemtrace::scene_file::{self, LoadedScene};
use spectral_core::film::Film;
use spectral_core::prepare::{Geometry, PreparedScene};
use std::path::Path;
use std::sync::Arc;

/// Straight down, orthographic, one wavelength's radiance kept; stones and the rest are appended.
const DOWN: &str = include_str!("../data/down.toml");

fn load(text: &str) -> LoadedScene {
    load_from(text, Path::new("."))
}

fn load_from(text: &str, folder: &Path) -> LoadedScene {
    scene_file::parse(text, Path::new("a.toml"), folder).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// Fails unless the scene is refused with this message.
#[track_caller]
fn refused(text: &str, pattern: &str) {
    let error = scene_file::parse(text, Path::new("a.toml"), Path::new(".")).unwrap_err();
    assert_matches(&error.to_string(), pattern);
}

fn prepare(loaded: &LoadedScene) -> Arc<PreparedScene> {
    Arc::new(PreparedScene::new(&loaded.scene, &loaded.settings).unwrap())
}

fn film(loaded: &LoadedScene, backend: &str) -> Film {
    let scene = prepare(loaded);
    Session::open(backend).unwrap().film(&scene, &mut ()).unwrap().0
}

/// Whether two scenes are the same but for rounding.
fn alike(a: &Geometry, b: &Geometry) -> bool {
    let near = |a: glam::DVec3, b: glam::DVec3| (a - b).length() < 1e-12;
    a.triangles == b.triangles && a.positions.iter().zip(&b.positions).all(|(a, b)| near(*a, *b))
}

const GEM: &str = "[[stone]]\nshape = \"round-brilliant\"\nwidth = 2\nmaterial = \"ruby\"\n";

#[test]
fn copies_are_the_same_stones_listed_one_by_one() {
    let places = ["position = [-2, 0, 0]", "position = [2, 0.5, 0]\nrotation = [10, 20, 30]"];
    let listed: String = places.iter().map(|place| format!("{GEM}{place}\n")).collect();
    let at = "at = [{ position = [-2, 0, 0] }, { position = [2, 0.5, 0], rotation = [10, 20, 30] }]\n";
    let scene = SCENE.split("[[stone]]").next().unwrap().to_owned() + "[render]\nsamples = 1\n";
    let (listed, copies) = (load(&format!("{scene}{listed}")), load(&format!("{scene}{GEM}{at}")));
    assert!(Arc::ptr_eq(&copies.scene.stones[0].mesh, &copies.scene.stones[1].mesh));
    assert_eq!(copies.scene.stones[1].name, "stone 1 (shape), copy 2");
    assert_eq!(prepare(&listed).geometry.facets, prepare(&copies).geometry.facets);
    assert_eq!(film(&listed, "cpu"), film(&copies, "cpu"));
}

#[test]
fn copies_say_what_is_wrong_with_them() {
    let both = "[[stone]] 1 has both 'at' and 'position'; give 'position' in 'at'";
    for (lines, message) in [
        ("position = [0, 0, 1]\nat = [{ position = [0, 0, 0] }]", both),
        ("at = [{ positoin = [0, 0, 0] }]", "unknown key 'positoin'*did you mean 'position'?*"),
        ("at = []", "at = [] in [[stone]]: expected at least one*"),
    ] {
        refused(&format!("{DOWN}{GEM}{lines}\n"), &format!("*{message}"));
    }
}

#[test]
fn a_turn_and_a_tilt_are_rotations_about_the_middle() {
    // A brilliant stands about its own axis, so its middle in x and y is the origin.
    let middle = |text: &str| prepare(&load(text));
    let turned = middle(&format!("{DOWN}{GEM}[pose]\nturn = 30\n"));
    assert!(alike(&turned.geometry, &middle(&format!("{DOWN}{GEM}rotation = [0, 0, 30]\n")).geometry));
    // From above with +y upright, the axis to the right is +x; the origin follows the stone's box.
    let tilted = load(&format!("{DOWN}{GEM}[pose]\ntilt = 20\n"));
    let stone = &tilted.scene.stones[0];
    assert!((stone.rotation - glam::DVec3::new(20.0, 0.0, 0.0)).length() < 1e-12, "{}", stone.rotation);
    let (low, high) = load(&format!("{DOWN}{GEM}")).scene.stones[0].bounds().unwrap();
    let lever = (low.z + high.z) / 2.0;
    let (sin, cos) = 20.0_f64.to_radians().sin_cos();
    let expected = glam::DVec3::new(0.0, lever * sin, lever * (1.0 - cos));
    assert!((stone.position - expected).length() < 1e-12, "{} {expected}", stone.position);
}

#[test]
fn two_stones_turn_as_one() {
    let pair = format!("{DOWN}{GEM}at = [{{ position = [-3, 0, 0] }}, {{ position = [3, 0, 0] }}]\n");
    let stones = load(&format!("{pair}[pose]\nturn = 90\n")).scene.stones;
    for (stone, y) in stones.iter().zip([-3.0, 3.0]) {
        assert!((stone.position - glam::DVec3::new(0.0, y, 0.0)).length() < 1e-12, "{}", stone.position);
    }
    let both = load(&format!("{pair}[pose]\nturn = 25\ntilt = -40\n")).scene.stones;
    let apart = (both[0].position - both[1].position).length();
    assert!((apart - 6.0).abs() < 1e-12, "{apart}");
}

#[test]
fn absorbance_follows_size() {
    // A cube of 1 mm with no reflection, so that what passes is exp(−αd).
    let cube = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n\
        f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    let place = Workplace::holding(&[("cube.obj", cube)]);
    let scene = format!(
        "{DOWN}[[stone]]\nmesh = \"cube.obj\"\nposition = [-0.5, -0.5, 0]\nmaterial = \"air\"\n\
         [material.air]\nindex = 1.0\nabsorption = [{{ constant = 0.25 }}]\n[pose]\nsize = "
    );
    for size in [1.0, 2.0, 4.0, 12.0] {
        let film = film(&load_from(&format!("{scene}{size}\n"), place.folder.path()), "cpu");
        for (x, y) in [(0, 0), (1, 1), (2, 0)] {
            for found in film.radiance(x, y) {
                let absorbance = -f64::from(found).ln();
                assert!((absorbance / size - 0.25).abs() < 1e-6, "{size} mm: {absorbance}");
            }
        }
    }
}

#[test]
fn size_changes_nothing_that_has_no_thickness() {
    let scene = SCENE.replace("\"diamond\"", "\"m\"") + "[material.m]\nindex = 2.4\n";
    let small = load(&(scene.clone() + "[ground]\nmirror = true\nsize = 30\n"));
    let large = load(&(scene + "[ground]\nmirror = true\nsize = 30\n[pose]\nsize = 13.0\n"));
    // Twice as large: a power of two, so that nothing rounds otherwise. The gap above the ground stays.
    let (small, large) = (prepare(&small), prepare(&large));
    for (a, b) in small.geometry.positions.iter().zip(&large.geometry.positions) {
        assert!((*a * 2.0 - *b).length() < 0.02, "{a} {b}");
    }
}

#[test]
fn a_metal_ground_reflects_as_its_index_says() {
    let rows = "[[450.0, 1.4, 1.9], [550.0, 0.4, 2.5], [650.0, 0.15, 3.6]]";
    let ground = "[ground]\nmaterial = \"m\"\nheight = -1\nsize = 5\n";
    let scene = load(&format!("{DOWN}[material.m]\nconductor = {{ table = {rows} }}\n{ground}"));
    for backend in ["cpu", "reference"] {
        let radiance = film(&scene, backend).radiance(1, 1);
        for (found, (n, k)) in radiance.iter().zip([(1.4_f64, 1.9_f64), (0.4, 2.5), (0.15, 3.6)]) {
            let expected = ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k);
            assert!((f64::from(*found) - expected).abs() < 1e-6, "{backend}: {found} {expected}");
        }
    }
}

#[test]
fn a_mirror_shows_what_is_above() {
    let folder = tempfile::tempdir().unwrap();
    // 2 × 2 texels: 0.8 above the horizon, 0.1 below; seen at 45° either side, exactly.
    let halves = image::Rgb32FImage::from_fn(2, 2, |_, y| image::Rgb([[0.8, 0.1][y as usize]; 3]));
    halves.save(folder.path().join("halves.hdr")).unwrap();
    let scene = DOWN
        .replace("position = [0, 0, 50]", "position = [0, -50, 50]")
        .replace("uniform = [1, 1, 1]", "image = \"halves.hdr\"");
    let below = film(&load_from(&scene, folder.path()), "cpu").radiance(1, 1);
    let mirrored = format!("{scene}[ground]\nmirror = true\nheight = 0\nsize = 9\n");
    for backend in ["cpu", "reference"] {
        let above = film(&load_from(&mirrored, folder.path()), backend).radiance(1, 1);
        for (below, above) in below.iter().zip(&above) {
            assert!((above / below - 8.0).abs() < 0.02 && (above - 0.8).abs() < 4e-3, "{above} {below}");
        }
    }
}

#[test]
fn a_furnace_with_a_mirror_is_still_a_furnace() {
    let scene = DOWN.replace("samples = 1", "samples = 1\nthreshold = 1e-6").replace("0.5\n", "3.0\n")
        + &GEM.replace("ruby", "diamond")
        + "[ground]\nmirror = true\n";
    let loaded = load(&scene);
    assert_eq!(loaded.scene.stones.last().unwrap().name, "the ground");
    let film = film(&loaded, "cpu");
    for (x, y) in (0..9).map(|i| (i % 3, i / 3)) {
        for found in film.radiance(x, y) {
            assert!((found - 1.0).abs() < 2e-3, "{found}");
        }
    }
}

#[test]
fn the_ground_lies_beneath_the_lowest_stone() {
    let loaded = load(&format!("{DOWN}{GEM}[ground]\nmaterial = \"rose-gold\"\n"));
    let [stone, ground] = &loaded.scene.stones[..] else { panic!("a stone and the ground") };
    let ((low, _), (_, top)) = (stone.bounds().unwrap(), ground.bounds().unwrap());
    assert!((low.z - top.z - 0.01).abs() < 1e-12);
    let geometry = &prepare(&loaded).geometry;
    assert!(low.z - top.z > 2.0 * Geometry::CONTACT * geometry.radius, "not in optical contact");
    for (text, wanted) in [
        ("[ground]\n", "[ground] needs exactly one of 'diffuse', 'material' and 'mirror'"),
        ("[ground]\nmirror = true\n", "needs 'height' in a scene without stones"),
        ("[ground]\nmirror = true\nheight = 0\n", "needs 'size' in a scene without stones"),
        ("[ground]\ndiffuse = 1.2\nheight = 0\n", "expected a reflectance from 0 to 1"),
        ("[ground]\ndiffuse = [0.1, 0.2]\nheight = 0\n", "expected a reflectance from 0 to 1"),
        ("[ground]\ndiffuse = 0.5\n", "needs 'height' in a scene without stones"),
        ("[ground]\ndiffuse = 0.5\nheight = 0\nsize = 3\n", "reaches to the horizon; leave 'size' out"),
        ("[ground]\nmirorr = true\n", "did you mean 'mirror'?"),
        ("[ground]\nmirror = true\nheight = 0\nsize = -3\n", "expected a width in mm, above 0"),
    ] {
        refused(&format!("{DOWN}{text}"), &format!("*{wanted}*"));
    }
}

#[test]
fn a_background_has_the_colour_it_was_given() {
    let colour = |text: &str| SCENE.replace("height = 16", &format!("height = 16\nbackground = {text}"));
    for (given, exposure) in [("\"#ff8000\"", "0"), ("\"#FF8000\"", "2"), ("[1.0, 0.2158605, 0.0]", "-1")] {
        let place = Workplace::with(&colour(given));
        place.render(&["a.png"], &["--exposure", exposure]).unwrap();
        let png = Png::open(&place.path("a.png"));
        assert_eq!(png.samples[..4], [255, 128, 0, 255], "{given}");
        assert!(png.samples.chunks(4).all(|pixel| pixel[3] == 255));
        let middle = &png.samples[4 * (8 * 24 + 12)..][..3];
        assert_ne!(middle, [255, 128, 0]);
    }
    let expected = "*background = \"#ff80\" in [film]: expected a colour \"#rrggbb\"*";
    refused(&colour("\"#ff80\""), expected);
    refused(&colour("\"transparant\""), "*did you mean 'transparent'?*\"#rrggbb\"*");
    refused(&colour("[1, 2]"), "*three linear sRGB values*");
}

#[test]
fn a_diffuse_ground_without_stones_returns_its_share_of_uniform_light() {
    for (albedo, expected) in [("1.0", 1.0_f32), ("0.25", 0.25)] {
        let loaded = load(&format!("{DOWN}[ground]\ndiffuse = {albedo}\nheight = -2\n"));
        for backend in ["cpu", "reference"] {
            for found in film(&loaded, backend).radiance(1, 1) {
                assert!((found - expected).abs() < 1e-6, "{backend}, {albedo}: {found}");
            }
        }
    }
}

#[test]
fn a_stone_casts_a_shadow_that_moves_with_it() {
    let scene = |pose: &str| {
        let text =
            SCENE.replace("samples = 4", "samples = 1") + "[ground]\ndiffuse = 0.5\nheight = -4\n" + pose;
        film(&load(&text), "cpu")
    };
    let still = scene("");
    // The corner is far from the stone, the pixel beside the girdle is not.
    let [corner, beside] = [(0, 0), (4, 8)].map(|(x, y)| still.xyz(x, y)[1]);
    assert!(beside < 0.97 * corner, "{beside} {corner}");
    assert_eq!(still, scene("[pose]\nturn = 0.0\n"));
}
