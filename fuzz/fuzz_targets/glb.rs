#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| gemtrace_fuzz::fuzz("glb", bytes));
