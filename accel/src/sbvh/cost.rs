//! The cheapest way to build a subtree from wide nodes (Ylitie, Karras & Laine 2017, section 4.1); see `wide`.

use bytemuck::{Pod, Zeroable};

/// Most references of one leaf in the node format.
pub(crate) const LEAF: u32 = 3;
/// The cost of a triangle test; visiting a node costs 1.
const TRIANGLE: f32 = 0.3;

/// `C(n, i)` of one node for `i` from 1 to 7.
pub(crate) struct Costs {
    forest: [f32; 7],
    references: u32,
}

/// How `C(n, i)` is reached for each number `i` of trees, as bits. For `i = 1`: whether it is a wide leaf, and how many of
/// the wide node's eight children come from the left (0 stands for 1). For larger `i`: how many trees come from the left,
/// or [`Form::FEWER`] if `i − 1` trees cost no more. A binary leaf has its own form.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub(crate) struct Form(u32);

impl Form {
    /// A binary leaf.
    pub const LEAF: Form = Form(1 << 31);
    const GATHERED: u32 = 1 << 30;
    const FEWER: u32 = 7;

    /// How many of at most `i + 1` trees come from the left and from the right, each minus one; `None` if the subtree is
    /// one tree.
    pub fn shares(self, i: usize) -> Option<(usize, usize)> {
        let i = (1..=i).rev().find(|&i| self.code(i) != Form::FEWER)?;
        let left = self.code(i) as usize;
        Some((left, i - left - 1))
    }

    /// The same for the eight children of a wide node; meaningless for a binary leaf.
    pub fn children(self) -> (usize, usize) {
        let left = (self.code(0) as usize).min(6);
        (left, 6 - left)
    }

    /// Whether the subtree as one tree is a leaf of up to three references.
    pub fn is_gathered(self) -> bool {
        self.0 & (Form::GATHERED | Form::LEAF.0) != 0
    }

    fn code(self, i: usize) -> u32 {
        if self == Form::LEAF { Form::FEWER } else { (self.0 >> (3 * i)) & 7 }
    }
}

impl Costs {
    /// Costs of a binary leaf whose box has this half area.
    pub fn leaf(half_area: f32) -> Costs {
        Costs { forest: [half_area * TRIANGLE; 7], references: 1 }
    }

    /// Form and costs of an inner node.
    pub fn inner(half_area: f32, left: &Costs, right: &Costs) -> (Form, Costs) {
        let cheapest = |trees: usize, limit: f32| {
            (0..trees).fold((limit, Form::FEWER), |best, k| {
                let cost = left.forest[k] + right.forest[trees - 1 - k];
                if cost < best.0 { (cost, k as u32) } else { best }
            })
        };
        let references = left.references + right.references;
        let gathered =
            if references <= LEAF { references as f32 * half_area * TRIANGLE } else { f32::INFINITY };
        let (shared, code) = cheapest(7, f32::INFINITY);
        let node = shared + half_area;
        let mut form = code;
        let mut forest = [node; 7];
        if gathered < node {
            form |= Form::GATHERED;
            forest[0] = gathered;
        }
        for i in 1..7 {
            let (cost, code) = cheapest(i, forest[i - 1]);
            forest[i] = cost;
            form |= code << (3 * i);
        }
        (Form(form), Costs { forest, references })
    }
}
