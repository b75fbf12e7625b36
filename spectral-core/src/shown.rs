//! Texts from outside as messages may show them.

/// The most characters of a value that a message shows.
const VALUE: usize = 80;
/// The most characters of anything else: a path, a line of a message.
const LINE: usize = 1000;

/// A value from outside, for a message: control characters are escaped, so that a terminal does not obey them, and the
/// middle of a long value is left out.
///
/// ```
/// assert_eq!(spectral_core::shown("a\u{1b}[2J\n"), r"a\u001b[2J\u000a");
/// assert_eq!(spectral_core::shown(&"x".repeat(1_000_000)).chars().count(), 80);
/// ```
pub fn shown(text: &str) -> String {
    shortened(text, VALUE).chars().map(|c| escaped(c, "")).collect()
}

/// A whole message or a path: as [`shown`], but line breaks stay, and a line may be longer.
pub fn shown_lines(text: &str) -> String {
    text.split('\n').map(|line| printable(&shortened(line, LINE))).collect::<Vec<_>>().join("\n")
}

/// Any text with its control characters escaped but for line breaks and tabs. The escapes are those of JSON and TOML.
pub fn printable(text: &str) -> String {
    text.chars().map(|c| escaped(c, "\n\t")).collect()
}

/// Control characters, and those that change the direction of writing, which can make one name look like another.
fn escaped(c: char, kept: &str) -> String {
    let turns = matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    if (c.is_control() || turns) && !kept.contains(c) {
        format!("\\u{:04x}", c as u32)
    } else {
        c.to_string()
    }
}

/// At most `most` characters: of a longer text the beginning, an ellipsis and the last quarter.
fn shortened(text: &str, most: usize) -> String {
    // Bytes first: they are known without counting.
    if text.len() <= most || text.chars().nth(most).is_none() {
        return text.to_owned();
    }
    let end: Vec<char> = text.chars().rev().take(most / 4).collect();
    let start = text.chars().take(most - 1 - end.len());
    start.chain(['…']).chain(end.into_iter().rev()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_terminal_is_told_nothing() {
        for c in ['\0', '\u{1b}', '\u{7f}', '\u{9b}', '\u{202e}', '\r'] {
            let text = format!("a{c}b");
            assert_eq!(printable(&text), format!("a\\u{:04x}b", c as u32));
            assert_eq!(shown(&text), printable(&text));
        }
        assert_eq!(shown_lines("größe 6.5 × 4 mm\n\tb"), "größe 6.5 × 4 mm\n\tb");
    }

    #[test]
    fn both_ends_of_a_long_text_are_shown() {
        let long = format!("{}.obj", "ä".repeat(400));
        let short = shown(&long);
        assert!(
            short.chars().count() == VALUE && short.starts_with("ää") && short.ends_with("ä.obj"),
            "{short}"
        );
        assert_eq!(shown_lines(&format!("{long}\n{long}")), format!("{long}\n{long}"));
    }
}
