// The guess of a camera ray is the facet that `prime` has seen it come to, that of a ray inside the nearest plane.

fn facets_guess(query: Query) -> Answer {
    if nest_is_empty(query.nest) {
        return facet_verify(query, query.start);
    }
    return facets_own(query);
}

// Whether an invocation makes another turn of a loop that it needs while it is `alive`.
fn guess_again(alive: bool) -> bool {
    return alive;
}
