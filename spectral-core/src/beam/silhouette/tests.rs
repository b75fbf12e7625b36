use super::*;
use crate::{
    camera::{Camera, Projection},
    material::Catalogue,
    scene::{Scene, Stone},
    settings::RenderSettings,
    shape::ShapeSpec,
};
use std::sync::Arc;

/// A stone of a width in mm, tilted, under a camera at 40 mm, in a picture of 24 × 20 pixels.
fn scene(shape: &str, width: f64, tilt: DVec3, projection: Projection) -> PreparedScene {
    let (mesh, _) = ShapeSpec::by_name(shape).unwrap().cut().unwrap().solid().unwrap();
    let quartz = Catalogue::builtin().get("quartz").unwrap().isotropic();
    let mut stone = Stone::new(shape, Arc::new(mesh), Arc::new(quartz));
    (stone.width, stone.rotation) = (Some(width), tilt);
    let mut scene = Scene::in_studio(vec![stone]);
    let [position, look_at] = [DVec3::Z * 40.0, DVec3::ZERO];
    scene.camera = Camera { position, look_at, up: DVec3::Y, projection };
    (scene.width, scene.height) = (24, 20);
    PreparedScene::new(&scene, &RenderSettings::default().with_samples(1)).unwrap()
}

const VIEWS: [Projection; 2] =
    [Projection::Perspective { fov: 16.0 }, Projection::Orthographic { height: 11.0 }];

fn scenes() -> impl Iterator<Item = (String, PreparedScene)> {
    // From above; tilted; from the side, so that the table is edge-on; smaller than a pixel; partly outside of the picture.
    let cases = [
        (7.0, [0.0, 0.0, 0.0]),
        (7.0, [31.0, 8.0, 4.0]),
        (7.0, [90.0, 0.0, 0.0]),
        (0.1, [20.0, 0.0, 0.0]),
        (15.0, [12.0, 170.0, 0.0]),
    ];
    VIEWS.into_iter().flat_map(move |view| {
        cases.into_iter().flat_map(move |(width, tilt)| {
            ShapeSpec::NAMES.into_iter().map(move |shape| {
                (format!("{shape}, {width} mm, {tilt:?}, {view:?}"), scene(shape, width, tilt.into(), view))
            })
        })
    })
}

/// The area of the part of the stone's outline that lies in the picture, from the hull of its corners.
fn outline(scene: &PreparedScene) -> f64 {
    let projection = super::Projection::new(&scene.view);
    let mut points: Vec<_> = scene.geometry.positions.iter().map(|p| projection.place(*p).unwrap()).collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    // Andrew's monotone chain.
    let turn =
        |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let chain = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut hull: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while hull.len() > 1 && turn(hull[hull.len() - 2], hull[hull.len() - 1], point) <= 0.0 {
                hull.pop();
            }
            hull.push(point);
        }
        hull.pop();
        hull
    };
    let mut hull = chain(&mut points.iter().copied());
    hull.extend(chain(&mut points.iter().rev().copied()));
    let (width, height) = (f64::from(scene.width), f64::from(scene.height));
    let sides: [&dyn Fn([f64; 2]) -> f64; 4] =
        [&|p| -p[0], &|p| p[0] - width, &|p| -p[1], &|p| p[1] - height];
    for side in sides {
        let mut inside = Vec::new();
        for (a, b) in edges(&hull) {
            let (from, to) = (side(a), side(b));
            if from <= 0.0 {
                inside.push(a);
            }
            if (from <= 0.0) != (to <= 0.0) {
                inside.push([0, 1].map(|k| a[k] + from / (from - to) * (b[k] - a[k])));
            }
        }
        hull = inside;
    }
    let doubled = edges(&hull).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>();
    doubled.abs() / 2.0
}

fn pixels(scene: &PreparedScene) -> impl Iterator<Item = (u32, u32)> + use<> {
    let (width, height) = (scene.width, scene.height);
    (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
}

#[test]
fn pieces_tile_every_pixel_and_the_whole_outline() {
    for (what, scene) in scenes() {
        let silhouette = Silhouette::new(&scene).expect("a lone convex stone");
        let (mut pieces, mut covered, mut full) = (Vec::new(), 0.0, 0);
        for (x, y) in pixels(&scene) {
            let rest = silhouette.pieces(x, y, &mut pieces);
            let areas: f64 = pieces.iter().map(|piece| piece.area).sum();
            match rest {
                None => assert_eq!(areas, 1.0, "{what}, {x} {y}"),
                Some(rest) => assert!((areas + rest.area - 1.0).abs() < 1e-15, "{what}, {x} {y}"),
            }
            for piece in &pieces {
                // The largest takes what is too small to be followed.
                assert!((piece.polygon.area() - piece.area).abs() < 1e-7, "{what}, {x} {y}: {piece:?}");
                assert!(
                    piece.polygon.centroid().iter().all(|c| c.abs() < 1e-9),
                    "{what}, {x} {y}: {piece:?}"
                );
            }
            full += usize::from(rest.is_none());
            covered += areas;
        }
        let exact = outline(&scene);
        assert!((covered - exact).abs() < 1e-6 * exact.max(1e-2), "{what}: {covered} of {exact}");
        assert_eq!(full > 0, exact > 9.0, "{what}: {full} of {exact}");
    }
}

#[test]
fn rays_of_a_piece_enter_by_its_facet() {
    for (what, scene) in scenes() {
        let silhouette = Silhouette::new(&scene).unwrap();
        let stone = &scene.geometry.stones[0];
        let mut pieces = Vec::new();
        for (x, y) in pixels(&scene) {
            let rest = silhouette.pieces(x, y, &mut pieces);
            let place = |[u, v]: [f64; 2]| scene.view.ray(f64::from(x) + 0.5 + u, f64::from(y) + 0.5 + v);
            for piece in pieces.iter().filter(|piece| piece.area > 1e-7) {
                let (point, facet) = scene.geometry.entry(stone, &place(piece.centroid)).expect("it enters");
                assert_eq!(facet, piece.facet, "{what}, {x} {y}");
                assert!(piece.pencil.origin.abs_diff_eq(point, 1e-9), "{what}, {x} {y}");
            }
            // Of a narrow rim the centroid may lie on the stone.
            if let Some(rest) = rest.filter(|rest| rest.area > 0.9) {
                assert_eq!(scene.geometry.entry(stone, &place(rest.centroid)), None, "{what}, {x} {y}");
            }
        }
    }
}

#[test]
fn coverage_is_that_of_many_points() {
    const SIDE: u32 = 64;
    for (what, scene) in scenes().filter(|(what, _)| what.starts_with("step")) {
        let silhouette = Silhouette::new(&scene).unwrap();
        let stone = &scene.geometry.stones[0];
        let mut pieces = Vec::new();
        for (x, y) in pixels(&scene).filter(|(x, y)| x % 5 == 2 && y % 3 == 1) {
            let rest = silhouette.pieces(x, y, &mut pieces).map_or(0.0, |rest| rest.area);
            let at = |k: u32| (f64::from(k) + 0.5) / f64::from(SIDE);
            let points = (0..SIDE * SIDE).map(|k| [at(k % SIDE), at(k / SIDE)]);
            let meets = |[u, v]: [f64; 2]| {
                scene.geometry.entry(stone, &scene.view.ray(f64::from(x) + u, f64::from(y) + v)).is_some()
            };
            let share = points.filter(|place| meets(*place)).count() as f64 / f64::from(SIDE * SIDE);
            assert!((share - (1.0 - rest)).abs() < 0.5 / f64::from(SIDE), "{what}, {x} {y}: {share}, {rest}");
        }
    }
}

#[test]
fn a_stone_that_reaches_behind_the_camera_has_none() {
    let near = |projection, z: f64| {
        let mut scene = scene("step", 7.0, DVec3::ZERO, projection);
        let camera =
            Camera { position: DVec3::new(0.0, 0.0, z), look_at: DVec3::X * 9.0, up: DVec3::Y, projection };
        scene.view = camera.view(24, 20).unwrap();
        Silhouette::new(&scene).is_some()
    };
    // Sideways past the stone, from above its middle.
    assert_eq!(VIEWS.map(|view| near(view, 5.0)), [false, false]);
    let silhouette = |scene: &PreparedScene| Silhouette::new(scene).is_some();
    assert_eq!(VIEWS.map(|view| silhouette(&scene("step", 7.0, DVec3::ZERO, view))), [true, true]);
}
