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
        ground: Option<Ground>,
    },
}

/// Where the ground's picture lies, in the world and in the image.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ground {
    /// mm.
    pub height: f32,
    /// Of the first texel, mm.
    pub low: [f32; 2],
    /// Texels a mm.
    pub per_mm: f32,
    /// The last texel that has a next.
    pub last: f32,
    /// The first row.
    pub row: f32,
}

impl Light {
    pub fn new(environment: &Environment) -> Self {
        match &environment.source {
            Source::Uniform(rgb) => Light::Uniform(rgb.map(|c| c as f32)),
            Source::Image(image) => {
                let turn = (environment.rotation / 360.0).rem_euclid(1.0) as f32;
                let ground = environment.ground.as_deref().map(|ground| Ground {
                    height: ground.height as f32,
                    low: ground.low().map(|v| v as f32),
                    per_mm: (1.0 / ground.step()) as f32,
                    last: (ground.edge() - 2) as f32,
                    row: image.sky()[1] as f32,
                });
                Light::Image { image: image.clone(), turn, ground }
            }
        }
    }
}
