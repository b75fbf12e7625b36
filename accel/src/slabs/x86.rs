//! The slab test in AVX registers.
//!
//! Values of [`Eight`] are made only in functions that [`crate::instructions`] calls after it has detected AVX2 and FMA.
//! Every `SAFETY` comment here relies on that.

use super::{Entries, ScaledRay, Slabs};
use obvhs::cwbvh::node::CwBvhNode;
use std::arch::x86_64::*;
use std::mem::offset_of;
use std::ptr;

/// One register holds a coordinate of eight children.
#[derive(Clone, Copy, Debug)]
pub struct Eight {
    first: __m256,
    axes: [Axis; 3],
}

/// The ray-dependent part along one axis.
#[derive(Clone, Copy, Debug)]
struct Axis {
    inverse: __m256,
    /// The slab distance of coordinate 0, minus and plus the widening.
    near: __m256,
    far: __m256,
    /// Byte offsets in a node of the coordinates at which the ray enters and leaves.
    sides: [usize; 2],
}

/// Byte offsets of the children's least and largest coordinates along each axis.
const SIDES: [[usize; 2]; 3] = [
    [offset_of!(CwBvhNode, child_min_x), offset_of!(CwBvhNode, child_max_x)],
    [offset_of!(CwBvhNode, child_min_y), offset_of!(CwBvhNode, child_max_y)],
    [offset_of!(CwBvhNode, child_min_z), offset_of!(CwBvhNode, child_max_z)],
];

/// Byte offset of the cell exponents along x, y and z; another byte follows.
const EXPONENTS: usize = offset_of!(CwBvhNode, e);

impl Slabs for Eight {
    #[inline(always)]
    fn new(ray: &ScaledRay, first: f32) -> Self {
        // SAFETY: called only with AVX2; no pointers.
        let first = unsafe { _mm256_set1_ps(first) };
        Eight { first, axes: [Axis::new(ray, 0), Axis::new(ray, 1), Axis::new(ray, 2)] }
    }

    #[inline(always)]
    fn enter(&self, node: &CwBvhNode, last: f32) -> Entries {
        let [x, y, z] = &self.axes;
        let p = node.p.to_array();
        let mut entries = Entries { near: [0.0; 8], hit: 0 };
        // SAFETY: values of this type exist only with AVX2. The four bytes from the exponents on belong to the node. The
        // store writes eight numbers to memory with their alignment.
        unsafe {
            // A power of two is given by its exponent, the eight bits below the sign.
            let exponents = ptr::from_ref(node).byte_add(EXPONENTS).cast::<i32>().read_unaligned();
            let exponents = _mm256_set1_epi32(exponents);
            let mask = _mm256_set1_epi32(0xff << 23);
            let cells = [
                _mm256_srli_epi32::<1>(_mm256_slli_epi32::<24>(exponents)),
                _mm256_and_si256(_mm256_slli_epi32::<15>(exponents), mask),
                _mm256_and_si256(_mm256_slli_epi32::<7>(exponents), mask),
            ];
            let [x, y, z] =
                [x.sides(node, p[0], cells[0]), y.sides(node, p[1], cells[1]), z.sides(node, p[2], cells[2])];
            // If one operand is NaN, the result is the second one, so NaN does not narrow the interval.
            let near = _mm256_max_ps(_mm256_max_ps(y[0], z[0]), _mm256_max_ps(x[0], self.first));
            let far = _mm256_min_ps(_mm256_min_ps(y[1], z[1]), _mm256_min_ps(x[1], _mm256_set1_ps(last)));
            _mm256_store_ps(entries.near.as_mut_ptr(), near);
            entries.hit = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_NGT_UQ>(near, far)) as u32;
        }
        entries
    }

    #[inline(always)]
    fn prefetch<T>(items: &[T], index: usize) {
        let item = items.as_ptr().wrapping_add(index).cast::<i8>();
        // SAFETY: a prefetch does not fault, wherever it points.
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(item);
            _mm_prefetch::<_MM_HINT_T0>(item.wrapping_add(64));
        }
    }
}

impl Axis {
    #[inline(always)]
    fn new(ray: &ScaledRay, axis: usize) -> Axis {
        let inverse = ray.inverse[axis];
        let zero = -(ray.origin[axis] * inverse);
        let widening = ray.widening[axis];
        let [low, high] = SIDES[axis];
        // SAFETY: called only with AVX2; no pointers.
        unsafe {
            Axis {
                inverse: _mm256_set1_ps(inverse),
                near: _mm256_set1_ps(zero - widening),
                far: _mm256_set1_ps(zero + widening),
                sides: if inverse >= 0.0 { [low, high] } else { [high, low] },
            }
        }
    }

    /// The slab distances at which boxes are entered and left, for the node's corner and cell.
    #[inline(always)]
    fn sides(&self, node: &CwBvhNode, p: f32, cell: __m256i) -> [__m256; 2] {
        let [enter, leave] = [side(node, self.sides[0]), side(node, self.sides[1])];
        // SAFETY: values of this type exist only with AVX2 and FMA; no pointers.
        unsafe {
            let p = _mm256_set1_ps(p);
            let step = _mm256_mul_ps(_mm256_castsi256_ps(cell), self.inverse);
            [
                _mm256_fmadd_ps(enter, step, _mm256_fmadd_ps(p, self.inverse, self.near)),
                _mm256_fmadd_ps(leave, step, _mm256_fmadd_ps(p, self.inverse, self.far)),
            ]
        }
    }
}

/// The eight bytes at an offset into a node.
#[inline(always)]
fn side(node: &CwBvhNode, offset: usize) -> __m256 {
    // SAFETY: called only with AVX2, and with an offset from `SIDES`, which eight bytes of the node follow.
    unsafe {
        let bytes = _mm_loadl_epi64(ptr::from_ref(node).byte_add(offset).cast());
        _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(bytes))
    }
}
