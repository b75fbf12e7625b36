//! Scenes and settings for tests: one line each.

use crate::solid;
use glam::DVec3;
use spectral_core::{
    absorption::{Absorption, Term},
    camera::{Camera, Projection},
    dispersion::Dispersion,
    environment::Environment,
    material::{Axis, Catalogue, Kind, Material},
    mesh::Mesh,
    scene::{Background, Orientation, Scene, Stone},
    settings::{Area, Coverage, Leftover, RenderSettings},
    spectrum::{Ends, Tabulated},
    wavelength::WavelengthGrid,
};
use std::sync::Arc;

/// A scene before its environment, `size` × `size` pixels.
pub fn scene(camera: Camera, size: u32, environment: Environment, stones: Vec<Stone>) -> Scene {
    Scene { camera, width: size, height: size, background: Background::Environment, environment, stones }
}

/// A camera at `position` that looks at the origin with a field of view of `fov` degrees.
pub fn eye(position: DVec3, fov: f64) -> Camera {
    Camera {
        position,
        look_at: DVec3::ZERO,
        up: upright(position),
        projection: Projection::Perspective { fov },
    }
}

/// Parallel rays from `position` towards the origin, over an image `height` mm high.
pub fn parallel(position: DVec3, height: f64) -> Camera {
    let projection = Projection::Orthographic { height };
    Camera { position, look_at: DVec3::ZERO, up: upright(position), projection }
}

/// Parallel rays, `height` mm high, about the ray from `origin` along `direction`. With one pixel it is that ray alone.
pub fn probe(origin: DVec3, direction: DVec3, height: f64) -> Camera {
    let projection = Projection::Orthographic { height };
    Camera { position: origin, look_at: origin + direction, up: upright(direction), projection }
}

fn upright(view: DVec3) -> DVec3 {
    if view.normalize().z.abs() > 0.9 { DVec3::Y } else { DVec3::Z }
}

/// A stone in the position of its mesh.
pub fn stone(mesh: Arc<Mesh>, material: Material) -> Stone {
    Stone::new("stone", mesh, Arc::new(material))
}

/// The stone at a position.
pub fn at(stone: Stone, position: [f64; 3]) -> Stone {
    Stone { position: position.into(), ..stone }
}

/// A built-in cut, 6.5 mm wide.
pub fn gem(cut: &str, material: Material) -> Stone {
    Stone { width: Some(6.5), ..stone(solid::cut(cut), material) }
}

/// A colourless material of one index at every wavelength.
pub fn glass(n: f64) -> Material {
    tinted(n, 0.0)
}

/// A material of one index and one Napierian absorption coefficient (1/mm) at every wavelength.
pub fn tinted(n: f64, absorption: f64) -> Material {
    let terms = if absorption > 0.0 { vec![Term::Constant(absorption)] } else { vec![] };
    let absorption = Absorption::new(terms).expect("a valid coefficient");
    Material::new("test", Kind::Dielectric { dispersion: Dispersion::Constant(n), absorption })
}

/// A colourless crystal of these indices: one is isotropic, two are o and e, three are x, y and z.
pub fn crystal(indices: &[f64]) -> Material {
    pleochroic(indices, &vec![0.0; indices.len()])
}

/// A crystal of these indices, with an absorption coefficient (1/mm) for each.
pub fn pleochroic(indices: &[f64], absorptions: &[f64]) -> Material {
    let axis = |(&n, &absorption): (&f64, &f64)| {
        let terms = if absorption > 0.0 { vec![Term::Constant(absorption)] } else { vec![] };
        let absorption = Absorption::new(terms).expect("a valid coefficient");
        Axis { dispersion: Dispersion::Constant(n), absorption }
    };
    let axes = indices.iter().zip(absorptions).skip(1).map(axis).collect();
    Material { axes, ..tinted(indices[0], absorptions[0]) }
}

/// A crystal with its third axis, the optic one of a uniaxial crystal, along a direction.
pub fn lying(stone: Stone, z: [f64; 3]) -> Stone {
    let z = DVec3::from(z);
    let axes = [z.any_orthogonal_vector(), z.cross(z.any_orthogonal_vector())];
    Stone { orientation: Some(Orientation::Axes(axes)), ..stone }
}

/// A metal of one complex index n + ik.
pub fn metal(n: f64, k: f64) -> Material {
    let constant = |v: f64| Tabulated::new(vec![550.0], vec![v], Ends::Extend).expect("a valid table");
    Material::new("test", Kind::Conductor { n: constant(n), k: constant(k) })
}

/// A built-in material.
pub fn material(name: &str) -> Material {
    Catalogue::builtin().get(name).expect("a built-in material").isotropic()
}

/// One sample a pixel at the given wavelengths (nm), a depth limit of 64, no threshold, and the radiance kept.
pub fn settings(nm: &[f64]) -> RenderSettings {
    RenderSettings {
        coverage: Coverage::Points,
        area: Area { offsets: 1, tolerance: 0.0, split: 0.0 },
        samples: 1,
        tolerance: 0.0,
        wavelengths: WavelengthGrid::list(nm.to_vec()).expect("ascending wavelengths"),
        jitter: false,
        max_depth: 64,
        leftover: Leftover::Exit,
        threshold: 0.0,
        split: 0.0,
        polarized: true,
        spectral: true,
    }
}

/// Fresnel's reflectances (s, p) from air into index `n` at `angle` degrees.
pub fn reflectances(n: f64, angle: f64) -> [f64; 2] {
    let (sin, c) = angle.to_radians().sin_cos();
    let t = (1.0 - (sin / n).powi(2)).sqrt();
    [((c - n * t) / (c + n * t)).powi(2), ((n * c - t) / (n * c + t)).powi(2)]
}

/// Asserts that two numbers differ by at most `tolerance`.
pub fn close(found: f64, expected: f64, tolerance: f64, what: impl std::fmt::Display) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found} instead of {expected}");
}

/// The same picture by another algorithm: a speck of its own material inside the first stone is no optical surface, but
/// then the stone is not alone.
pub fn with_speck(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    let host = scene.stones[0].placed().expect("a placeable stone");
    let (low, high) = host.bounds();
    let size = 1e-2 * (high - low);
    let centre = host.positions().iter().sum::<DVec3>() / host.positions().len() as f64;
    let speck = solid::cuboid(centre - size, centre + size * DVec3::new(1.0, 1.1, 1.2));
    scene.stones.push(Stone::new("speck", speck, scene.stones[0].material.clone()));
    scene
}
