use super::*;
use crate::testing::Random;
use crate::{Instructions, Task, lanes::Lanes};
use glam::DVec3;

const NODES: u64 = if cfg!(debug_assertions) { 2_000 } else { 50_000 };

struct Enter<'a> {
    ray: &'a ScaledRay,
    first: f32,
    last: f32,
    node: &'a CwBvhNode,
}

impl Task for Enter<'_> {
    type Output = Entries;

    #[inline(always)]
    fn run<V: Lanes>(self) -> Entries {
        V::Slabs::new(self.ray, self.first).enter(self.node, self.last)
    }
}

/// Eight boxes, some of them flat, in the builder's unit cube.
fn node(random: &mut Random) -> CwBvhNode {
    let mut node = CwBvhNode {
        p: (random.point() * 2.0 - 1.0) * 0.5,
        e: [0; 3].map(|_| 127 - 9 - random.below(14) as u8),
        ..CwBvhNode::default()
    };
    let sides = [
        (&mut node.child_min_x, &mut node.child_max_x),
        (&mut node.child_min_y, &mut node.child_max_y),
        (&mut node.child_min_z, &mut node.child_max_z),
    ];
    for (low, high) in sides {
        for child in 0..8 {
            low[child] = random.below(256) as u8;
            high[child] = low[child] + random.below(256 - usize::from(low[child])) as u8;
        }
    }
    node
}

/// A ray at or close past a corner of one of the boxes.
fn ray(node: &CwBvhNode, random: &mut Random) -> Ray {
    let target =
        Vec3::from(node.child_aabb(random.below(8)).min) + random.direction() * (1e-6 * random.unit());
    let origin = target + random.direction() * [1e-3, 1.0, 1e3][random.below(3)];
    let mut direction = target - origin;
    if random.below(4) == 0 {
        direction[random.below(3)] = [0.0, -0.0, 1e-12, -1e-30][random.below(4)];
    }
    let t_min = [0.0, -2.0, f32::NEG_INFINITY, 0.5][random.below(4)];
    let t_max = [f32::INFINITY, 1.0, 0.9][random.below(3)];
    Ray { origin, direction, t_min, t_max }
}

/// The interval of parameters for which a ray is in a box widened by `by`, in double precision; inverted if it never is.
fn exact(ray: &Ray, [low, high]: [DVec3; 2], by: f64) -> [f64; 2] {
    let (o, d) = (DVec3::from(ray.origin), DVec3::from(ray.direction));
    let mut range = [f64::from(ray.t_min), f64::from(ray.t_max)];
    for axis in 0..3 {
        let (low, high) = (low[axis] - by - o[axis], high[axis] + by - o[axis]);
        if d[axis] == 0.0 {
            if low > 0.0 || high < 0.0 {
                return [f64::INFINITY, f64::NEG_INFINITY];
            }
            continue;
        }
        let (a, b) = (low / d[axis], high / d[axis]);
        range = [range[0].max(a.min(b)), range[1].min(a.max(b))];
    }
    range
}

#[test]
fn boxes_are_widened_as_the_derivation_says() {
    let u = 2.0_f64.powi(-24);
    let sets = || Instructions::ALL.into_iter().filter(|set| set.available());
    let mut counts = [0; 2];
    for seed in 0..NODES {
        let random = &mut Random(seed);
        let node = node(random);
        let ray = ray(&node, random);
        if !ray.is_proper() {
            continue;
        }
        let scaled = ScaledRay::new(&ray, 1.0);
        let reach = f64::from(ray.origin.abs().max_element()) + 1.0;
        let size = f64::from(ray.direction.abs().max_element());
        // Where the clamp applies, the box is larger than that.
        let plain = ray.direction.to_array().iter().all(|d| f64::from(d.abs()) > 1e-6 * size);
        let (first, last) = (scaled.first(ray.t_min), scaled.last(ray.t_max));
        for set in sets() {
            let entries = set.run(Enter { ray: &scaled, first, last, node: &node });
            for child in 0..8 {
                let bounds = node.child_aabb(child);
                let bounds = [bounds.min, bounds.max].map(|p| DVec3::from(Vec3::from(p)));
                let hit = entries.hit >> child & 1 == 1;
                let context = || format!("{}, node {seed}, child {child}: {ray:?}", set.name());
                // Of the 48 the derivation uses 27 for hits, 5 for the slab distances and 2 for the clamp.
                let [enter, leave] = exact(&ray, bounds, 41.0 * u * reach);
                if enter <= leave {
                    assert!(hit, "missed: {}", context());
                    assert!(f64::from(entries.near[child]) <= enter * size, "entered late: {}", context());
                    counts[0] += 1;
                }
                // In the other direction 48 and those 5 apply; the interval itself is rounded too.
                let [enter, leave] = exact(&ray, bounds, 55.0 * u * reach);
                if plain && enter > leave + 1e-6 * leave.abs() {
                    assert!(!hit, "met: {}", context());
                    counts[1] += 1;
                }
            }
        }
    }
    assert!(counts.iter().all(|&count| count > NODES / 2), "too few cases: {counts:?}");
}
