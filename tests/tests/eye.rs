//! A camera on a surface stands outside, for every backend.

use backend_vulkan::VULKAN;
use backend_wgpu::WGPU;
use gemtrace_tests::prelude::*;

/// The mean radiance over the picture.
fn mean(picture: &Picture) -> f64 {
    let lines = picture.first_line();
    lines.iter().sum::<f64>() / lines.len() as f64
}

fn compare(what: &str, camera: Camera, stones: &[Stone]) {
    let scene = scene(camera, 24, studio(), stones.to_vec());
    let settings = RenderSettings { threshold: 1e-3, max_depth: 24, ..settings(&[550.0]) };
    let prepared = PreparedScene::new(&scene, &settings).unwrap_or_else(|e| panic!("{what}: {e}"));
    let remarks: Vec<_> = prepared.warnings.iter().map(|w| w.message.as_str()).collect();
    assert!(remarks.iter().any(|w| w.contains("which counts as outside")), "{what}: {remarks:?}");
    let reference = render(&REFERENCE, &scene, &settings);
    for backend in [CPU, WGPU, VULKAN].iter().filter(|backend| !(backend.devices)().is_empty()) {
        let (found, expected) = (mean(&render(backend, &scene, &settings)), mean(&reference));
        let difference = (found / expected - 1.0).abs();
        assert!(difference < 2e-3, "{what}: {found} by {}, {expected} by the reference", backend.name);
    }
    assert!(reference.report.energy.lost == 0.0, "{what}");
}

fn looking(position: DVec3, direction: DVec3) -> Camera {
    let projection = Projection::Perspective { fov: 40.0 };
    Camera { position, look_at: position + direction, up: DVec3::new(0.1, 0.2, 1.0), projection }
}

#[test]
fn a_camera_on_a_facet_an_edge_or_a_corner_sees_what_every_backend_sees() {
    let cube = stone(cuboid(DVec3::splat(-1.0), DVec3::ONE), material("diamond"));
    let gem = gem("round-brilliant", material("diamond"));
    let mesh = gem.placed().unwrap();
    let table = mesh.facets().iter().position(|f| f.plane.normal.z > 0.999).unwrap() as u32;
    let on_table = mesh.triangles().iter().zip(mesh.facet_of()).find(|(_, f)| **f == table).unwrap().0;
    let corners = on_table.map(|v| mesh.positions()[v as usize]);
    let middle = corners.iter().sum::<DVec3>() / 3.0;
    let star = stone(star(5, 1.0, 2.0, 1.0), glass(1.5));
    let notch = glam::DVec2::from_angle(std::f64::consts::PI / 5.0).extend(0.0);
    let cases = [
        ("a face", &cube, DVec3::new(0.0, -1.0, 0.0)),
        ("a face, off the middle", &cube, DVec3::new(0.3, -1.0, -0.2)),
        ("an edge", &cube, DVec3::new(0.2, -1.0, 1.0)),
        ("a corner", &cube, DVec3::new(-1.0, -1.0, 1.0)),
        ("a nanometre inside", &cube, DVec3::new(0.1, -1.0 + 1e-6, 0.2)),
        ("a nanometre outside", &cube, DVec3::new(0.1, -1.0 - 1e-6, 0.2)),
        ("the table", &gem, middle),
        ("an edge of the table", &gem, (corners[0] + corners[1]) / 2.0),
        ("a corner of the table", &gem, corners[0]),
        ("a notch of a star", &star, notch),
        ("a face of a star", &star, DVec3::new(0.2, 0.1, 0.5)),
    ];
    for (what, stone, place) in cases {
        for direction in
            [-place + DVec3::new(0.1, 0.05, -0.02), place + DVec3::new(0.1, 0.05, 0.02), DVec3::X]
        {
            compare(
                &format!("{what} towards {direction}"),
                looking(place, direction),
                std::slice::from_ref(stone),
            );
        }
    }
}

#[test]
fn a_camera_between_stones_that_touch_is_in_one_of_them() {
    let left = stone(cuboid(DVec3::new(-1.0, -1.0, -1.0), DVec3::new(0.0, 1.0, 1.0)), material("diamond"));
    let right = stone(cuboid(DVec3::new(0.0, -1.0, -1.0), DVec3::new(1.0, 1.0, 1.0)), glass(1.5));
    for direction in [DVec3::X, DVec3::NEG_X, DVec3::new(0.3, 1.0, 0.2)] {
        compare(
            "the face between",
            looking(DVec3::new(0.0, 0.1, 0.2), direction),
            &[left.clone(), right.clone()],
        );
    }
}

#[test]
fn the_image_plane_of_parallel_rays_may_cut_a_stone() {
    let stones = [gem("round-brilliant", material("diamond"))];
    let seen = |distance: f64| {
        let direction = DVec3::new(0.1, 0.2, -1.0).normalize();
        let camera = probe(direction * -distance, direction, 7.0);
        let scene = scene(camera, 32, studio(), stones.to_vec());
        let settings = RenderSettings { threshold: 1e-3, ..settings(&[550.0]) };
        [&CPU, &REFERENCE].map(|backend| mean(&render(backend, &scene, &settings)))
    };
    let [far, reference] = seen(20.0);
    close(far, reference, 2e-3 * far, "far away");
    for distance in [-1.0, 0.0, 0.5, 1.0] {
        for mean in seen(distance) {
            close(mean, far, 2e-3 * far, distance);
        }
    }
}
