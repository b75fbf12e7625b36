// The guess of a ray outside is the facet that it starts on, or that the host has seen it come to: half of all rays
// have just left the stone and meet nothing more. Of rays inside nothing is guessed.

fn facets_guess(query: Query) -> Answer {
    if nest_is_empty(query.nest) {
        return facet_verify(query, query.start);
    }
    return Answer(false, hit_none(query));
}

// Whether an invocation makes another turn of a loop that it needs while it is `alive`.
fn guess_again(alive: bool) -> bool {
    return alive;
}
