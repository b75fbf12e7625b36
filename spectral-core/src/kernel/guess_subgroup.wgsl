// As `guess_start.wgsl` for rays outside. For those inside, the invocations of a subgroup, which are wavelengths of one
// pixel sample or of neighbours, search together for the exit of one of them, a few planes each, and all try the
// facet that they find. Those whose rays leave elsewhere are left for the next round; one that was searched for and
// does not believe what was found, near an edge, and those who are left after the last, search for themselves.
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

// The facet that a ray from inside leaves by, nearly: every `step`-th plane from `first` on is this invocation's to
// compare. A distance and a facet share a word, so that one reduction finds both: the distance loses its last ten bits.
fn facets_share(origin: vec3<f32>, direction: vec3<f32>, first: u32, step: u32) -> u32 {
    var nearest = 0xffffffffu;
    for (var facet = first; facet < scene.facets; facet += step) {
        let plane = facet_plane(facet);
        let towards = inner(plane.xyz, direction);
        let t = max((plane.w - inner(plane.xyz, origin)) / towards, 0.0);
        if towards > 0.0 {
            nearest = min(nearest, (bitcast<u32>(t) & ~FACET_BITS) | facet);
        }
    }
    return subgroupMin(nearest) & FACET_BITS;
}

fn facets_guess(query: Query) -> Answer {
    let inside = !nest_is_empty(query.nest);
    let present = subgroupBallot(true);
    // This one at least is present, whatever a driver says: a step of 0 would never end.
    let step = max(ballot_count(present), 1u);
    let first = ballot_count(ballot_below(present, subgroup_lane));
    var facet = query.start;
    var answer = Answer(false, hit_none(query));
    var open = true;
    // Whether it is still to be searched for.
    var asks = inside;
    for (var round = 0u; round < GUESS_ROUNDS; round++) {
        let asking = subgroupBallot(asks);
        if any(asking != vec4(0u)) {
            let leader = ballot_first(asking);
            let origin = subgroupShuffle(query.origin, leader);
            let direction = subgroupShuffle(query.direction, leader);
            let found = facets_share(origin, direction, first, step);
            facet = select(facet, found, inside);
            asks = asks && subgroup_lane != leader;
        }
        if open {
            answer = facet_verify(query, facet);
            open = inside && !answer.known;
            asks = asks && open;
        }
        if !subgroupAny(asks) {
            break;
        }
    }
    return answer;
}

// Whether an invocation makes another turn of a loop that it needs while it is `alive`: all stay for as long as one needs
// it, since they search together.
fn guess_again(alive: bool) -> bool {
    return subgroupAny(alive);
}
