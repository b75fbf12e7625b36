//! Memory in large pages.
//!
//! A ray reads a large mesh here and there, and with pages of 4 KiB the processor has to look up anew where each of them
//! is. Linux maps large ones where it is asked to.

/// The size of a large page, and a multiple of that of any other.
const LARGE: usize = 2 << 20;

/// An empty vector with room for `count` items, in large pages where the system has them and the items fill one.
pub(crate) fn with_capacity<T>(count: usize) -> Vec<T> {
    if count.saturating_mul(size_of::<T>()) < LARGE {
        return Vec::with_capacity(count);
    }
    // The end of the last item is seldom that of a page.
    let items = Vec::with_capacity(count + LARGE / size_of::<T>());
    #[cfg(target_os = "linux")]
    advise(&items);
    items
}

/// Asks for large pages before any is touched. What the system answers is of no consequence.
#[cfg(target_os = "linux")]
fn advise<T>(items: &Vec<T>) {
    use rustix::mm::{Advice, madvise};

    let start = items.as_ptr().cast::<u8>();
    let before = start.align_offset(LARGE);
    let length = (items.capacity() * size_of::<T>()).saturating_sub(before) / LARGE * LARGE;
    if length > 0 {
        let start = start.wrapping_add(before).cast_mut();
        // SAFETY: whole pages within the vector's memory, of which the advice changes nothing that a program can see.
        let _ = unsafe { madvise(start.cast(), length, Advice::LinuxHugepage) };
    }
}
