// Which stones a ray is in: the twin of `prepare/nest.rs`.
//
// Six slots of 16 bits, two a word, hold ranks plus one (marks) in descending order; unused slots hold 0. Equal
// sets are equal words, the top is the first slot, and no length is kept.

alias Nest = vec3<u32>;

fn nest_mark(nest: Nest, slot: u32) -> u32 {
    return (nest[slot >> 1u] >> ((slot & 1u) << 4u)) & 0xffffu;
}

fn nest_is_empty(nest: Nest) -> bool {
    return nest.x == 0u;
}

// The mark of the stone that fills the space here; 0 is air.
fn nest_top(nest: Nest) -> u32 {
    return nest.x & 0xffffu;
}

fn nest_contains(nest: Nest, rank: u32) -> bool {
    let mark = rank + 1u;
    let low = nest & Nest(0xffffu);
    let high = nest >> Nest(16u);
    return any(low == Nest(mark)) || any(high == Nest(mark));
}

// The set after crossing the surface of the stone of this rank. When full, the lowest rank is forgotten.
fn nest_toggled(nest: Nest, rank: u32) -> Nest {
    let mark = rank + 1u;
    let inside = nest_contains(nest, rank);
    var after = Nest(0u);
    var before = 0xffffffffu;
    for (var slot = 0u; slot < NEST_CAPACITY; slot++) {
        let here = nest_mark(nest, slot);
        var kept = here;
        if here <= mark {
            if inside {
                kept = 0u;
                if slot + 1u < NEST_CAPACITY {
                    kept = nest_mark(nest, slot + 1u);
                }
            } else {
                kept = select(before, mark, before > mark);
            }
        }
        after[slot >> 1u] |= kept << ((slot & 1u) << 4u);
        before = here;
    }
    return after;
}
