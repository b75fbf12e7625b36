//! The stack of a traversal.

/// The slab distance at which a node is entered, and the index of the node.
type Entry = (f32, u32);

/// Nodes still to visit, with the nearest child of each node on top.
///
/// The array is large enough for ordinary trees. For deeper ones its contents move to the heap.
pub(crate) struct Stack {
    entries: [Entry; Stack::SIZE],
    len: usize,
    spilled: Vec<Entry>,
}

impl Stack {
    /// A power of two, so that the remainder is cheap and needs no bounds check.
    const SIZE: usize = 32;
    /// The most entries that one node adds.
    const CHILDREN: usize = 7;

    #[inline(always)]
    pub fn new() -> Stack {
        Stack { entries: [(0.0, 0); Stack::SIZE], len: 0, spilled: Vec::new() }
    }

    /// Pushes all `children` of a node (at least one, child i as bit i) except the nearest, which it returns.
    #[inline(always)]
    pub fn push_but_nearest(&mut self, mut children: u32, child: impl Fn(u32) -> Entry) -> Entry {
        let mut nearest = child(children.trailing_zeros());
        children &= children - 1;
        if children == 0 {
            return nearest;
        }
        if self.len + Stack::CHILDREN > Stack::SIZE {
            self.spill();
        }
        let bottom = self.len;
        while children != 0 {
            let mut other = child(children.trailing_zeros());
            children &= children - 1;
            if other.0 < nearest.0 {
                std::mem::swap(&mut other, &mut nearest);
            }
            self.insert(bottom, other);
        }
        nearest
    }

    /// Inserts an entry below the nearer ones, at `bottom` or above.
    #[inline(always)]
    fn insert(&mut self, bottom: usize, entry: Entry) {
        let mut at = self.len;
        while at > bottom && self.entries[(at - 1) % Stack::SIZE].0 < entry.0 {
            self.entries[at % Stack::SIZE] = self.entries[(at - 1) % Stack::SIZE];
            at -= 1;
        }
        self.entries[at % Stack::SIZE] = entry;
        self.len += 1;
    }

    #[inline(always)]
    pub fn pop(&mut self) -> Option<Entry> {
        if self.len == 0 {
            if self.spilled.is_empty() {
                return None;
            }
            self.refill();
        }
        self.len -= 1;
        Some(self.entries[self.len % Stack::SIZE])
    }

    #[cold]
    #[inline(never)]
    fn spill(&mut self) {
        self.spilled.extend_from_slice(&self.entries[..self.len]);
        self.len = 0;
    }

    #[cold]
    #[inline(never)]
    fn refill(&mut self) {
        let from = self.spilled.len().saturating_sub(Stack::SIZE / 2);
        self.len = self.spilled.len() - from;
        self.entries[..self.len].copy_from_slice(&self.spilled[from..]);
        self.spilled.truncate(from);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_come_nearest_first_and_later_nodes_before_earlier_ones() {
        let mut stack = Stack::new();
        let mut expected = Vec::new();
        for node in 0..40u32 {
            // Distances 0, 3, 6, 1, 4, 7, 2, 5.
            let nearest = stack.push_but_nearest(0xff, |slot| ((slot * 3 % 8) as f32, 8 * node + slot));
            assert_eq!(nearest, (0.0, 8 * node));
            let mut others: Vec<Entry> =
                (1..8).map(|slot| ((slot * 3 % 8) as f32, 8 * node + slot)).collect();
            others.sort_by(|a, b| b.0.total_cmp(&a.0));
            expected.extend(others);
        }
        assert_eq!(stack.push_but_nearest(0x10, |slot| (1.0, slot)), (1.0, 4));
        while let Some(entry) = stack.pop() {
            assert_eq!(Some(entry), expected.pop());
        }
        assert!(expected.is_empty());
    }
}
