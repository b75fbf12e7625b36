// No guess: every ray is searched for.

fn facets_guess(query: Query) -> Answer {
    return Answer(false, hit_none(query));
}

// Whether an invocation makes another turn of a loop that it needs while it is `alive`.
fn guess_again(alive: bool) -> bool {
    return alive;
}
