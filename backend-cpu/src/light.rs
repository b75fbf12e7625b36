//! The environment of a scene in single precision.

use spectral_core::environment::{Environment, LatLong, Source};
use std::sync::Arc;

/// The environment; illuminant and scale are in the spectral lines' bases already.
#[derive(Debug, Clone)]
pub(crate) enum Light {
    Uniform([f32; 3]),
    /// An image and its rotation, in turns.
    Image {
        image: Arc<LatLong>,
        turn: f32,
    },
}

impl Light {
    pub fn new(environment: &Environment) -> Self {
        match &environment.source {
            Source::Uniform(rgb) => Light::Uniform(rgb.map(|c| c as f32)),
            Source::Image(image) => {
                let turn = (environment.rotation / 360.0).rem_euclid(1.0) as f32;
                Light::Image { image: image.clone(), turn }
            }
        }
    }
}
