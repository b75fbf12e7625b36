use super::*;
use crate::{
    incidence::Incidence,
    planes::{BATCH, Beam, Exit},
};
use glam::DVec3;
use spectral_core::{
    material::Catalogue,
    mesh::Mesh,
    prepare::Geometry,
    scene::{Scene, Stone},
    shape::ShapeSpec,
};
use std::sync::Arc;

pub(crate) fn chain(shape: &str) -> (Chain, PreparedScene) {
    let (mesh, _): (Mesh, _) = ShapeSpec::by_name(shape).unwrap().cut().unwrap().solid().unwrap();
    let diamond = Catalogue::builtin().get("diamond").unwrap().clone();
    let stone = Stone { width: Some(6.5), ..Stone::new("stone", Arc::new(mesh), Arc::new(diamond)) };
    let background = Background::Transparent;
    let scene = Scene { width: 8, height: 8, background, ..Scene::in_studio(vec![stone]) };
    let scene = PreparedScene::new(&scene, &RenderSettings::default().with_samples(1)).unwrap();
    (Chain::new(&scene, Instructions::best()).expect("a convex stone"), scene)
}

/// Numbers from -1 to 1.
fn noise(seed: u32) -> impl FnMut() -> f32 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 23) as f32 - 1.0
    }
}

/// Sixteen rays, each traced with many guesses; every fourth one aims at a corner of the stone.
struct Guesses<'a>(&'a Chain, [[Row; 3]; 2], usize);

impl Task for Guesses<'_> {
    type Output = Vec<[Row; 4]>;

    #[inline(always)]
    fn run<V: Lanes>(self) -> Self::Output {
        let Guesses(chain, [origin, direction], count) = self;
        let (origin, direction) = (Triple::<V>::load(&origin), Triple::<V>::load(&direction));
        let mut results = Vec::new();
        for guess in 0..count {
            // The whole packet, and each half by itself.
            for lanes in [0xffff, 0x00ff, 0xff00] {
                let mut guess = [guess; 2];
                let exit = chain.planes.exit(origin, direction, lanes, &mut guess);
                let [x, y, z] = exit.point.stored();
                results.push([x, y, z, exit.distance.stored()]);
            }
        }
        results
    }
}

#[test]
fn what_a_ray_meets_depends_neither_on_the_guess_nor_on_its_neighbours() {
    for shape in ShapeSpec::NAMES {
        let (chain, scene) = chain(shape);
        let (geometry, mut noise) = (&scene.geometry, noise(9));
        for round in 0..60 {
            let rows = rays(geometry, &mut noise, round);
            let count = geometry.facets.len();
            let results = chain.instructions.run(Guesses(&chain, rows, count));
            for (k, result) in results.iter().enumerate() {
                for lane in (0..WIDTH).filter(|lane| [0xffff, 0x00ff, 0xff00][k % 3] >> lane & 1 == 1) {
                    for (found, expected) in result.iter().zip(&results[0]) {
                        assert_eq!(found.0[lane].to_bits(), expected.0[lane].to_bits(), "{shape}, guess {k}");
                    }
                }
            }
            for lane in 0..WIDTH {
                let [origin, along] =
                    rows.map(|row| DVec3::from(row.map(|coordinate| f64::from(coordinate.0[lane]))));
                let exact = geometry.facets.iter().map(|f| {
                    let towards = f.normal.dot(along);
                    if towards > 0.0 { (f.offset - f.normal.dot(origin)) / towards } else { f64::INFINITY }
                });
                let exact = exact.fold(f64::INFINITY, f64::min);
                let found = f64::from(results[0][3].0[lane]);
                assert!((found - exact).abs() < 1e-5 * geometry.radius, "{shape}: {found} for {exact}");
            }
        }
    }
}

/// Rays from anywhere in the stone; every fourth one aims at a corner.
fn rays(geometry: &Geometry, noise: &mut impl FnMut() -> f32, round: usize) -> [[Row; 3]; 2] {
    let mut rows = [[Row::default(); 3]; 2];
    for lane in 0..WIDTH {
        let origin = DVec3::from([noise(), noise(), noise()].map(f64::from)) * 0.4;
        let corner = geometry.positions[(round * WIDTH + lane) % geometry.positions.len()];
        let aim = DVec3::from([noise(), noise(), noise()].map(f64::from));
        let direction = if lane % 4 == 0 { corner - origin + aim * 1e-6 } else { aim };
        put(&mut rows[0], lane, origin.as_vec3().to_array());
        put(&mut rows[1], lane, direction.normalize().as_vec3().to_array());
    }
    rows
}

/// Rays that begin just below a facet and graze it towards one of its edges: the error of a point along its ray is large.
fn grazing(geometry: &Geometry, noise: &mut impl FnMut() -> f32, round: usize) -> [[Row; 3]; 2] {
    let mut rows = [[Row::default(); 3]; 2];
    for lane in 0..WIDTH {
        let triangle = geometry.triangles[(round * WIDTH + lane) % geometry.triangles.len()];
        let [a, b, c] = triangle.map(|corner| geometry.positions[corner as usize]);
        let origin = a * (1.0 - 2e-3 - 1e-3 * f64::from(noise()));
        let aim = b.lerp(c, 0.5 + 0.4 * f64::from(noise())) * (1.0 + 4e-6 * f64::from(noise()));
        put(&mut rows[0], lane, origin.as_vec3().to_array());
        put(&mut rows[1], lane, (aim - origin).normalize().as_vec3().to_array());
    }
    rows
}

#[test]
fn where_a_ray_grazes_a_facet_the_guess_does_not_show_either() {
    for shape in ShapeSpec::NAMES {
        let (chain, scene) = chain(shape);
        let mut noise = noise(3);
        for round in 0..300 {
            let rows = grazing(&scene.geometry, &mut noise, round);
            let results = chain.instructions.run(Guesses(&chain, rows, scene.geometry.facets.len()));
            for lane in 0..WIDTH {
                let whole = results.iter().step_by(3).map(|result| result.map(|row| row.0[lane].to_bits()));
                let distinct: std::collections::BTreeSet<_> = whole.collect();
                assert_eq!(distinct.len(), 1, "{shape}, round {round}, lane {lane}");
            }
        }
    }
}

/// Packets of rays, together and each by itself.
struct Company<'a>(&'a Chain, &'a [Beam]);

impl Task for Company<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Lanes>(self) {
        let mut exits = vec![Exit::<V>::nowhere(); self.1.len()];
        self.0.planes.exits(self.1, &mut exits);
        for (beam, exit) in self.1.iter().zip(&exits) {
            let [origin, direction] = [&beam.origin, &beam.direction].map(Triple::<V>::load);
            let alone = self.0.planes.exit(origin, direction, beam.alive, &mut [0; 2]);
            for (found, expected) in [(exit.point, alone.point), (exit.normal, alone.normal)] {
                for (found, expected) in found.stored().into_iter().zip(expected.stored()) {
                    for lane in (0..WIDTH).filter(|lane| beam.alive >> lane & 1 == 1) {
                        assert_eq!(found.0[lane].to_bits(), expected.0[lane].to_bits());
                    }
                }
            }
        }
    }
}

#[test]
fn what_a_ray_meets_does_not_depend_on_the_packets_it_goes_with() {
    for shape in ShapeSpec::NAMES {
        let (chain, scene) = chain(shape);
        let mut noise = noise(5);
        let beam = |round| {
            let [origin, direction] = rays(&scene.geometry, &mut noise, round);
            Beam { origin, direction, alive: (noise() * 1e6) as i32 as u16 | 1 << (round % WIDTH) }
        };
        let beams: Vec<Beam> = (0..BATCH).map(beam).collect();
        // With few rays left there is another way to search for them.
        for count in [1, 2, 7, 16, 33, BATCH] {
            for set in Instructions::ALL.into_iter().filter(|set| set.available()) {
                set.run(Company(&chain, &beams[..count]));
            }
        }
    }
}

#[test]
fn a_start_beyond_a_plane_leaves_through_it_at_once() {
    struct Corner<'a>(&'a Chain, [f32; 3], [f32; 3]);
    impl Task for Corner<'_> {
        type Output = (f32, [f32; 3]);
        #[inline(always)]
        fn run<V: Lanes>(self) -> Self::Output {
            let (origin, direction) = (Triple::<V>::splat(self.1), Triple::splat(self.2));
            let exit = self.0.planes.exit(origin, direction, 1, &mut [0; 2]);
            let normal = exit.normal.stored();
            (exit.distance.lane(0), normal.map(|row| row.0[0]))
        }
    }
    let (chain, scene) = chain("step");
    let facet = &scene.geometry.facets[3];
    let on = scene.geometry.positions.iter().copied();
    let polygon: Vec<DVec3> = on.filter(|p| (facet.normal.dot(*p) - facet.offset).abs() < 1e-9).collect();
    let middle = polygon.iter().sum::<DVec3>() / polygon.len() as f64;
    assert!(polygon.len() >= 3, "a facet has corners");
    let start = (middle + facet.normal * 1e-7).as_vec3().to_array();
    let slanted = (facet.normal + 0.3 * facet.normal.any_orthonormal_vector()).normalize();
    let (distance, normal) = chain.instructions.run(Corner(&chain, start, slanted.as_vec3().to_array()));
    assert!((0.0..1e-6).contains(&distance), "{distance}");
    assert_eq!(normal, facet.normal.as_vec3().to_array());
}

/// The vector forms of Fresnel's equations and of Stokes rows against those of the core.
#[test]
fn events_are_those_of_the_core() {
    use spectral_core::{
        fresnel::dielectric,
        stokes::{StokesRow, align},
    };
    struct Event([f32; 3], [f32; 3], [f32; 3], f64);
    impl Task for Event {
        type Output = ([f32; 2], [f32; 2]);
        #[inline(always)]
        fn run<V: Lanes>(self) -> Self::Output {
            let Event(direction, normal, axis, n) = self;
            let (direction, normal) = (Triple::<V>::splat(direction), Triple::splat(normal));
            let [n1, n2, less] = [n, n * n, 1.0 - n * n].map(|v| V::splat(v as f32));
            let at = Incidence::new(normal.dot(direction), n1, n2, less);
            let axis = axis.map(|a| Row([a; WIDTH]));
            let start = Polarized::entering(V::splat(0.8), V::splat(0.3), &axis);
            let (inside, out) = start.reflected(direction, normal, &at);
            // A second event mixes all four components into the first.
            let (again, _) = inside.reflected(direction, normal, &at);
            let (mean, mean_out) =
                Mean::entering(V::splat(0.8), V::splat(0.0), &axis).reflected(direction, normal, &at);
            let lane = |v: V| v.lane(0);
            ([lane(again.intensity()), lane(out)], [lane(mean.intensity()), lane(mean_out)])
        }
    }
    let mut noise = noise(4);
    let mut vector = || DVec3::from([noise(), noise(), noise()].map(f64::from)).normalize();
    for _ in 0..20_000 {
        let (direction, mut normal, any) = (vector(), vector(), vector());
        if normal.dot(direction) < 0.0 {
            normal = -normal;
        }
        let axis = direction.cross(any).normalize();
        let n = f64::from((1.2 + any.x.abs() * 1.6) as f32);
        let cos = normal.dot(direction);
        let root = (1.0 - n * n * (1.0 - cos * cos)).abs().sqrt();
        if root < 1e-2 || cos < 1e-2 {
            continue; // there the rounding of the cosine itself decides
        }
        let event = dielectric(cos, n);
        let row = |row: StokesRow<f64>, axis: [f64; 3]| {
            let frame = align(direction.to_array(), axis, normal.to_array());
            (row.rotated(frame.cos2, frame.sin2), frame.axis)
        };
        let (first, e_s) = row(StokesRow([0.8, 0.3, 0.0, 0.0]), axis.to_array());
        let (second, _) = row(first.reflected(&event), e_s);
        let polarized = [second.reflected(&event).intensity(), first.refracted(&event).intensity()];
        let mean = [0.8 * event.reflectance(), 0.8 * event.transmittance()];
        let [d, m, a] = [direction, normal, axis].map(|v| v.as_vec3().to_array());
        let found = Instructions::best().run(Event(d, m, a, n));
        for (found, expected) in [(found.0, polarized), (found.1, mean)] {
            for k in 0..2 {
                let error = (f64::from(found[k]) - expected[k]).abs();
                // cos²θ₂ is off by ε n², its root by 1/(2 cos θ₂) of that, R by 4n as much.
                assert!(
                    error < 5.0 * f64::from(f32::EPSILON) * n.powi(3) / root.min(cos),
                    "cos {cos}, n {n}: {found:?} for {expected:?}"
                );
            }
        }
    }
}
