//! What the whole-renderer tests share: solids with known answers, light that tells where a ray went,
//! renders by every way through the code, and the statistics they are judged by.
//!
//! The tests themselves are in `tests/`; each states the equation it holds the renderer to.

#![forbid(unsafe_code)]

pub mod agreement;
pub mod compare;
pub mod device;
pub mod gallery;
pub mod gpu;
pub mod light;
pub mod mitsuba;
pub mod render;
pub mod scene;
pub mod solid;
