//! What a traversal has still to visit.

/// A slab distance, and the number of a node that is entered there.
type Entry = (f32, u32);

/// Nodes still to visit, the nearest of each family on top.
///
/// The place in line holds what any sane tree needs; of a deeper one the bottom is moved elsewhere.
pub(super) struct Stack {
    place: [Entry; Stack::PLACE],
    len: usize,
    spilt: Vec<Entry>,
}

impl Stack {
    /// A power of two, so that a remainder by it costs nothing and needs no check.
    const PLACE: usize = 32;
    /// Most that a node adds.
    const FAMILY: usize = 7;

    #[inline(always)]
    pub fn new() -> Stack {
        Stack { place: [(0.0, 0); Stack::PLACE], len: 0, spilt: Vec::new() }
    }

    /// Of the `children` of a node, at least one, child i as bit i, pushes all but the nearest, which it gives.
    #[inline(always)]
    pub fn push_but_nearest(&mut self, mut children: u32, child: impl Fn(u32) -> Entry) -> Entry {
        let mut nearest = child(children.trailing_zeros());
        children &= children - 1;
        if children == 0 {
            return nearest;
        }
        if self.len + Stack::FAMILY > Stack::PLACE {
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

    /// Pushes an entry, and lets it sink beneath nearer ones down to `bottom`.
    #[inline(always)]
    fn insert(&mut self, bottom: usize, entry: Entry) {
        let mut at = self.len;
        while at > bottom && self.place[(at - 1) % Stack::PLACE].0 < entry.0 {
            self.place[at % Stack::PLACE] = self.place[(at - 1) % Stack::PLACE];
            at -= 1;
        }
        self.place[at % Stack::PLACE] = entry;
        self.len += 1;
    }

    #[inline(always)]
    pub fn pop(&mut self) -> Option<Entry> {
        if self.len == 0 {
            if self.spilt.is_empty() {
                return None;
            }
            self.refill();
        }
        self.len -= 1;
        Some(self.place[self.len % Stack::PLACE])
    }

    #[cold]
    #[inline(never)]
    fn spill(&mut self) {
        self.spilt.extend_from_slice(&self.place[..self.len]);
        self.len = 0;
    }

    #[cold]
    #[inline(never)]
    fn refill(&mut self) {
        let from = self.spilt.len().saturating_sub(Stack::PLACE / 2);
        self.len = self.spilt.len() - from;
        self.place[..self.len].copy_from_slice(&self.spilt[from..]);
        self.spilt.truncate(from);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_family_is_sorted_and_the_last_comes_first_however_many_there_are() {
        let mut stack = Stack::new();
        let mut expected = Vec::new();
        for family in 0..40u32 {
            // Distances 0, 3, 6, 1, 4, 7, 2, 5.
            let nearest = stack.push_but_nearest(0xff, |slot| ((slot * 3 % 8) as f32, 8 * family + slot));
            assert_eq!(nearest, (0.0, 8 * family));
            let mut others: Vec<Entry> =
                (1..8).map(|slot| ((slot * 3 % 8) as f32, 8 * family + slot)).collect();
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
