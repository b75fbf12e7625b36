//! Stones of scene files: which way is up, what the width is measured on, and what is remarked on.

use gemtrace::scene_file::{self, LoadedScene};
use std::path::Path;

/// An octagonal bipyramid, 4 across and 2.4 deep, with its table's normal along +y.
const Y_UP: &str = "v 2 0 0\nv 1.414214 0 1.414214\nv 0 0 2\nv -1.414214 0 1.414214\nv -2 0 0\n\
    v -1.414214 0 -1.414214\nv 0 0 -2\nv 1.414214 0 -1.414214\nv 0 0.7 0\nv 0 -1.7 0\n\
    f 2 1 9\nf 1 2 10\nf 3 2 9\nf 2 3 10\nf 4 3 9\nf 3 4 10\nf 5 4 9\nf 4 5 10\n\
    f 6 5 9\nf 5 6 10\nf 7 6 9\nf 6 7 10\nf 8 7 9\nf 7 8 10\nf 1 8 9\nf 8 1 10\n";

fn load(stone: &str) -> Result<LoadedScene, String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("stone.obj"), Y_UP).unwrap();
    let text = format!(
        "format = 1\ncamera = {{ position = [0, -20, 20], look_at = [0, 0, 0] }}\n[[stone]]\nmaterial = \"diamond\"\n{stone}\n"
    );
    scene_file::parse(&text, Path::new("scene.toml"), folder.path()).map_err(|e| e.to_string())
}

/// The extents of the first stone as it stands, and the remarks.
fn extents(stone: &str) -> ([f64; 3], Vec<String>) {
    let loaded = load(stone).unwrap();
    let (low, high) = loaded.scene.stones[0].bounds().unwrap();
    ((high - low).to_array(), loaded.warnings.into_iter().map(|w| w.message).collect())
}

#[test]
fn the_width_is_measured_with_the_right_axis_up() {
    for (stone, expected) in [
        ("mesh = \"stone.obj\"\nup = \"y\"\nwidth = 6", [6.0, 6.0, 3.6]),
        ("mesh = \"stone.obj\"\nup = \"y\"", [4.0, 4.0, 2.4]),
        ("mesh = \"stone.obj\"\nup = \"y\"\nwidth = 6\nrotation = [0, 0, 90]", [6.0, 6.0, 3.6]),
        ("mesh = \"stone.obj\"\nup = \"y\"\nwidth = 6\nrotation = [90, 0, 0]", [6.0, 3.6, 6.0]),
        ("mesh = \"stone.obj\"\nup = \"x\"\nwidth = 6", [6.0, 10.0, 10.0]),
        ("mesh = \"stone.obj\"\nup = \"z\"\nwidth = 6", [10.0, 6.0, 10.0]),
        ("mesh = \"stone.obj\"\nwidth = 6", [10.0, 6.0, 10.0]),
        ("mesh = \"stone.obj\"\nup = \"y\"\nat = [{ rotation = [0, 0, 45] }]\nwidth = 6", [6.0, 6.0, 3.6]),
        ("mesh = \"stone.obj\"\nup = \"y\"\n[pose]\nsize = 6", [6.0, 6.0, 3.6]),
    ] {
        let (found, warnings) = extents(stone);
        let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5);
        assert!(near, "{stone}: {found:?}");
        assert!(warnings.is_empty(), "{stone}: {warnings:?}");
    }
    // The point of the pavilion is down: the file's −y.
    let loaded = load("mesh = \"stone.obj\"\nup = \"y\"").unwrap();
    let (low, high) = loaded.scene.stones[0].bounds().unwrap();
    assert!((low.z + 1.7).abs() < 1e-9 && (high.z - 0.7).abs() < 1e-9, "{low} {high}");
}

#[test]
fn a_rotation_that_turns_a_mesh_upright_is_remarked_on() {
    let (found, warnings) = extents("mesh = \"stone.obj\"\nwidth = 6\nrotation = [90, 0, 0]");
    assert!((found[0] - 10.0).abs() < 1e-5, "{found:?}");
    assert!(warnings[0].contains("write up = \"y\" in place of that rotation"), "{warnings:?}");
    for quiet in
        ["rotation = [90, 0, 0]", "width = 6\nrotation = [20, 0, 0]", "width = 6\nrotation = [180, 0, 0]"]
    {
        let (_, warnings) = extents(&format!("mesh = \"stone.obj\"\n{quiet}"));
        assert!(warnings.is_empty(), "{quiet}: {warnings:?}");
    }
}

#[test]
fn an_axis_that_cannot_be_up_is_refused() {
    for (stone, expected) in [
        ("mesh = \"stone.obj\"\nup = \"w\"", "line 6: unknown axis 'w'; did you mean 'x'?"),
        ("mesh = \"stone.obj\"\nup = 2", "line 6: up = 2 in [[stone]]: expected one of 'x', 'y' and 'z'"),
        (
            "shape = \"step\"\nup = \"y\"",
            "line 6: 'up' is for a 'mesh'; the table of a 'shape' is always towards +z",
        ),
    ] {
        let error = load(stone).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
}

/// The point about which a scene's stones turn, and the first vertex of its stone as it is posed.
fn posed(pose: &str) -> [glam::DVec3; 2] {
    let text = format!(
        "format = 1\ncamera = {{ position = [0, -20, 20], look_at = [0, 0, 0] }}\n[film]\nexposure = -1.5\n\
         [[stone]]\nshape = \"step\"\nwidth = 6.0\nmaterial = \"quartz\"\nposition = [3, 0, 1]\n{pose}"
    );
    let loaded = scene_file::parse(&text, "a.toml".as_ref(), ".".as_ref()).unwrap();
    assert_eq!(loaded.exposure, -1.5);
    let placed = loaded.scene.stones[0].placed().unwrap();
    [loaded.pivot.unwrap(), placed.positions()[0]]
}

#[test]
fn a_pose_rotates_about_the_middle_of_the_stones() {
    let [pivot, vertex] = posed("");
    for angles in
        [[90.0, 0.0, 0.0], [0.0, 90.0, 0.0], [0.0, 0.0, 90.0], [20.0, -35.0, 110.0], [10.0, 90.0, 5.0]]
    {
        let [x, y, z] = angles.map(f64::to_radians);
        let turned = glam::DMat3::from_rotation_z(z)
            * glam::DMat3::from_rotation_y(y)
            * glam::DMat3::from_rotation_x(x);
        let [same, found] = posed(&format!("[pose]\nrotation = {angles:?}"));
        assert!((same - pivot).length() < 1e-12);
        assert!((found - pivot - turned * (vertex - pivot)).length() < 1e-9, "{angles:?}: {found}");
        // The turn follows.
        let [_, found] = posed(&format!("[pose]\nrotation = {angles:?}\nturn = 30"));
        let expected = glam::DMat3::from_rotation_z(30.0_f64.to_radians()) * turned * (vertex - pivot);
        assert!((found - pivot - expected).length() < 1e-9, "{angles:?}: {found}");
    }
}
