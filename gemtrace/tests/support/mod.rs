//! Tables of messages: a text and the message that it must bring about, in a file of many.

/// The cases of a file: each a text and, on a line that begins with `=>`, the pattern of its message. Lines that begin
/// with `###` are comments; empty lines before a text do not belong to it.
pub fn cases(file: &str) -> impl Iterator<Item = (String, &str)> {
    let mut text = String::new();
    file.lines().filter_map(move |line| {
        if let Some(pattern) = line.strip_prefix("=> ") {
            return Some((std::mem::take(&mut text), pattern));
        }
        let left_out = line.starts_with("###") || text.is_empty() && line.is_empty();
        if !left_out {
            text += line;
            text += "\n";
        }
        None
    })
}

/// Fails unless `found` is `pattern`, in which `*` stands for any text.
#[track_caller]
pub fn assert_matches(found: &str, pattern: &str) {
    assert!(matches(found, pattern), "{found}\nwhere this was expected:\n{pattern}");
}

fn matches(text: &str, pattern: &str) -> bool {
    let Some((first, rest)) = pattern.split_once('*') else { return text == pattern };
    let after = text.strip_prefix(first);
    after.is_some_and(|text| {
        text.char_indices().map(|(at, _)| at).chain([text.len()]).any(|at| matches(&text[at..], rest))
    })
}
