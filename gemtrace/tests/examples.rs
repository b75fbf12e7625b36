//! The examples do what their heads say.

#[allow(dead_code, reason = "an example has its own entry point")]
#[path = "../examples/built_scene.rs"]
mod built_scene;
#[allow(dead_code, reason = "as above")]
#[path = "../examples/many.rs"]
mod many;
#[allow(dead_code, reason = "as above")]
#[path = "../examples/progress.rs"]
mod progress;
#[allow(dead_code, reason = "as above")]
#[path = "../examples/scene_file.rs"]
mod scene_file;

const SCENE: &str = "format = 1
camera = { position = [0, -20, 20], look_at = [0, 0, 0] }
film = { width = 24, height = 16 }
render = { quality = 'draft' }
[[stone]]
shape = 'step'
width = 6.5
material = 'emerald'
";

#[test]
fn every_example_writes_its_picture() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("scene.toml"), SCENE).unwrap();
    scene_file::render(&path("scene.toml"), &path("a.png")).unwrap();
    progress::render(&path("scene.toml"), &path("b.exr")).unwrap();
    built_scene::render(&path("c.png")).unwrap();
    let sums = ["turned", "fresh"].map(|mode| many::render(&path("scene.toml"), mode, 3).unwrap());
    assert!(sums[0] == sums[1] && many::render(&path("scene.toml"), "same", 3).unwrap() > 0.0);
    assert_eq!(image::image_dimensions(path("a.png")).unwrap(), (24, 16));
    assert!(path("b.exr").exists());
    let ruby = image::open(path("c.png")).unwrap().into_rgb8();
    let [red, green, _] = ruby.get_pixel(48, 48).0;
    assert!(red > green, "a ruby is red: {:?}", ruby.get_pixel(48, 48));
}
