//! `gemtrace view` in a real browser. Chromium and axe-core are installed by `test.sh`; without a browser nothing is tested, unless
//! `REQUIRE_BROWSER` is set.
#![cfg(all(unix, feature = "view"))]

mod access;
mod browser;
mod hand;
mod place;
mod reach;
mod timing;
