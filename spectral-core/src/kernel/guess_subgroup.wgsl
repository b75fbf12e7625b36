// As `guess_start.wgsl` for rays outside. For those inside, the invocations of a subgroup, which are wavelengths of one
// pixel sample or of neighbours, search together for the exit of one of them, a few planes each, and all try the
// facet that they find. Those whose rays leave elsewhere are left for the next round. After some ten reflections the
// wavelengths are so far apart that a round serves few: then each searches by itself.
//
// Invocations that have nothing to guess help to search, but nothing depends on who takes part: it is a guess, and what
// an absent invocation gives is one that fails.

// The invocation's number in its subgroup.
var<private> subgroup_lane: u32;

// Invocations of a ballot.
fn ballot_count(ballot: vec4<u32>) -> u32 {
    let counts = countOneBits(ballot);
    return counts.x + counts.y + counts.z + counts.w;
}

// Those of a ballot whose number is below one.
fn ballot_below(ballot: vec4<u32>, lane: u32) -> vec4<u32> {
    let first = vec4(0u, 32u, 64u, 96u);
    let bits = clamp(vec4(lane), first, first + 32u) - first;
    // A shift by 32 is none.
    let mask = select((vec4(1u) << bits) - 1u, vec4(0xffffffffu), bits == vec4(32u));
    return ballot & mask;
}

// The lowest number in a ballot that is not empty.
fn ballot_first(ballot: vec4<u32>) -> u32 {
    if ballot.x != 0u {
        return firstTrailingBit(ballot.x);
    }
    if ballot.y != 0u {
        return 32u + firstTrailingBit(ballot.y);
    }
    return select(96u + firstTrailingBit(ballot.w), 64u + firstTrailingBit(ballot.z), ballot.z != 0u);
}

fn facets_guess(query: Query) -> Answer {
    let inside = !nest_is_empty(query.nest);
    let present = subgroupBallot(true);
    // This one at least is present, whatever a driver says: a step of 0 would never end.
    let step = max(ballot_count(present), 1u);
    let first = ballot_count(ballot_below(present, subgroup_lane));
    var answer = Answer(false, hit_none(query));
    if !inside {
        answer = facet_verify(query, query.start);
    }
    var open = inside;
    var asking = subgroupBallot(open);
    var left = ballot_count(asking);
    while left > 0u {
        let leader = ballot_first(asking);
        let origin = subgroupShuffle(query.origin, leader);
        let direction = subgroupShuffle(query.direction, leader);
        let nearest = subgroupMax(facets_nearest(origin, direction, first, step));
        if open {
            answer = facet_verify(query, u32(nearest) & FACET_BITS);
            // One that does not believe what was found for itself, near an edge, asks no more.
            open = !answer.known && subgroup_lane != leader;
        }
        asking = subgroupBallot(open);
        let before = left;
        left = ballot_count(asking);
        if left > FEW_LEFT && (before - left) * ROUND_SERVES < before {
            break;
        }
    }
    if open {
        answer = facets_own(query);
    }
    return answer;
}

// Whether an invocation makes another turn of a loop that it needs while it is `alive`: all stay for as long as one needs
// it, since they search together.
fn guess_again(alive: bool) -> bool {
    return subgroupAny(alive);
}
