//! What the fuzz targets have in common.

pub mod attempt;

use gemtrace::import;
use std::sync::Once;

/// One input of a target. A panic that the program itself catches and tells as an error is no finding.
pub fn fuzz(target: &str, bytes: &[u8]) {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        // The one of libfuzzer ends the process at every panic.
        let fatal = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !import::is_decoding() {
                fatal(panic);
            }
        }));
    });
    attempt::run(target, bytes);
}
