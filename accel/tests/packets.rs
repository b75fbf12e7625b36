//! A packet of sixteen rays has the hits of its single rays, in every instruction set.

use accel::glam::Vec3;
use accel::lanes::{Lanes, Triple, WIDTH, put};
use accel::packet::{Accept, Hits, Rays};
use accel::testing::{self, Mesh, Random};
use accel::{Bvh, Instructions, Ray, Task};

const PACKETS: u64 = if cfg!(debug_assertions) { 100 } else { 3_000 };

struct Any;

impl<V: Lanes> Accept<V> for Any {
    #[inline(always)]
    fn accept(&self, _triangle: u32, hit: V::Mask) -> V::Mask {
        hit
    }
}

struct Closest<'a> {
    bvh: &'a Bvh,
    rays: &'a [(Vec3, Vec3); WIDTH],
    t_min: f32,
    lanes: u16,
}

impl Task for Closest<'_> {
    type Output = Hits;

    #[inline(always)]
    fn run<V: Lanes>(self) -> Hits {
        let mut rows = Default::default();
        let [origin, direction]: &mut [[_; 3]; 2] = &mut rows;
        for (lane, ray) in self.rays.iter().enumerate() {
            put(origin, lane, ray.0.to_array());
            put(direction, lane, ray.1.to_array());
        }
        let rays = Rays {
            origin: Triple::<V>::load(origin),
            direction: Triple::load(direction),
            t_min: self.t_min,
            lanes: self.lanes,
        };
        self.bvh.closest_of_packet(&rays, &Any, &mut Vec::new())
    }
}

/// Rays from one point, with targets spread by `spread` about a corner, an edge or an inner point of a triangle (`place`
/// 0, 1, 2).
fn rays(mesh: &Mesh, place: usize, random: &mut Random, spread: f32) -> [(Vec3, Vec3); WIDTH] {
    let [a, b, c] = mesh.corners(random.below(mesh.triangles.len()));
    let target = [a, (a + b) / 2.0, (a + b + c) / 3.0][place];
    let origin = target + random.direction() * random.unit();
    std::array::from_fn(|_| {
        let target = target + random.direction() * (spread * random.unit());
        (origin, (target - origin).normalize_or(Vec3::X))
    })
}

#[test]
fn a_packet_meets_what_its_rays_meet() {
    let meshes = [
        ("soup", testing::soup(800, 0.3, 1)),
        ("slivers", testing::slivers(800, 1e-3, 2)),
        ("icosphere", testing::icosphere(3)),
        ("torus", testing::torus(0.3, 24, 16)),
        ("stone", testing::stone(16)),
    ];
    for (name, mesh) in meshes {
        let bvh = mesh.bvh();
        let mut hits = 0;
        for k in 0..PACKETS {
            let mut random = Random(k);
            let place = random.below(3);
            let rays = rays(&mesh, place, &mut random, [0.0, 1e-3, 2.0][k as usize % 3]);
            let (t_min, set) = (-1e-6, Instructions::best());
            let whole = set.run(Closest { bvh: &bvh, rays: &rays, t_min, lanes: 0xffff });
            for lane in 0..WIDTH {
                let alone = set.run(Closest { bvh: &bvh, rays: &rays, t_min, lanes: 1 << lane });
                assert_eq!(alone.triangle[lane], whole.triangle[lane], "{name}, packet {k}, lane {lane}");
                assert_eq!(alone.t.0[lane].to_bits(), whole.t.0[lane].to_bits(), "{name}, packet {k}");
                let (origin, direction) = rays[lane];
                let ray = Ray { origin, direction, t_min, t_max: f32::INFINITY };
                let exact = bvh.closest_of_all(&ray, |_| true);
                let same = whole.lanes >> lane & 1 == u16::from(exact.is_some());
                let near = exact.is_none_or(|hit| (hit.t - whole.t.0[lane]).abs() < 1e-4);
                // For a start on the surface, a parameter near zero may fall on either side of t_min.
                let at_start = exact.is_some_and(|hit| hit.t.abs() < 1e-5) || whole.t.0[lane].abs() < 1e-5;
                // At a corner of the silhouette rounding decides whether a ray hits.
                let allowed = same && near || at_start || place < 2;
                assert!(allowed, "{name}, packet {k}, lane {lane}: {exact:?} {whole:?}");
                hits += usize::from(exact.is_some());
            }
            for set in Instructions::ALL.into_iter().filter(|set| set.available()) {
                let other = set.run(Closest { bvh: &bvh, rays: &rays, t_min, lanes: 0xffff });
                assert_eq!(other.triangle, whole.triangle, "{name}, packet {k}, {}", set.name());
                let bits = |hits: &Hits| hits.t.0.map(f32::to_bits);
                assert_eq!(bits(&other), bits(&whole), "{name}, {}", set.name());
            }
        }
        assert!(hits > PACKETS as usize, "{name}: only {hits} hits");
    }
}

#[test]
fn no_ray_leaves_a_closed_mesh() {
    for mesh in [testing::icosphere(4), testing::stone(24)] {
        let bvh = mesh.bvh();
        let mut random = Random(3);
        for _ in 0..PACKETS {
            let origin = random.point() * 0.2;
            let rays = std::array::from_fn(|lane| {
                let [a, b, c] = mesh.corners(random.below(mesh.triangles.len()));
                let target = match lane % 3 {
                    0 => a,
                    1 => a + (b - a) * random.unit(),
                    _ => (a + b + c) / 3.0,
                };
                (origin, (target - origin).normalize())
            });
            let hits =
                Instructions::best().run(Closest { bvh: &bvh, rays: &rays, t_min: 0.0, lanes: 0xffff });
            assert_eq!(hits.lanes, 0xffff, "{rays:?}");
        }
    }
}
