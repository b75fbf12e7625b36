//! Decoders of other crates, which may fail in any way.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static DECODING: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread is in a decoder whose panic is caught and told as an error: a panic hook may be silent then.
pub fn is_decoding() -> bool {
    DECODING.get()
}

/// Runs a decoder of another crate on bytes that nobody vouches for. A panic in it is an error like any other.
pub(crate) fn guarded<T>(decode: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    let before = DECODING.replace(true);
    let decoded = catch_unwind(AssertUnwindSafe(decode));
    DECODING.set(before);
    decoded.unwrap_or_else(|_| Err("it is damaged: its decoder gave up".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error() {
        std::panic::set_hook(Box::new(|_| assert!(is_decoding(), "only what is caught panics here")));
        let broken: Result<(), String> = guarded(|| panic!("out of range"));
        assert_eq!(broken.unwrap_err(), "it is damaged: its decoder gave up");
        assert!(guarded(|| Ok(is_decoding())) == Ok(true) && !is_decoding());
        drop(std::panic::take_hook());
    }
}
