//! The light as a texture.
//!
//! Texels are four single-precision numbers where they fit [`FULL_BYTES`], else halves: those cost 1e-4 of a radiance
//! (half a unit in their last place is 2⁻¹¹ of a texel), which is more than the rest of single precision together.

use crate::device::Gpu;
use half::f16;
use spectral_core::{
    Error,
    environment::{LatLong, Source},
};

/// The most memory that texels in single precision may take: an image of 8192 × 4096.
const FULL_BYTES: u64 = 512 << 20;
/// Texels are converted and uploaded in pieces of this many bytes.
const PIECE_BYTES: usize = 16 << 20;

/// The environment on the device.
#[derive(Debug)]
pub struct Light {
    /// The texture, lat-long.
    pub view: wgpu::TextureView,
    /// What a radiance is to be multiplied by: halves hold no more than 65,504, so brighter images are scaled.
    pub gain: f32,
}

/// Uploads the environment; a uniform one is in the scene's block, and its texture is never read.
///
/// # Errors
/// [`Error::Device`] for an image beyond the device's limits or memory.
pub fn upload(gpu: &Gpu, source: &Source) -> Result<Light, Error> {
    let black;
    let image: &LatLong = match source {
        Source::Image(image) => image,
        Source::Uniform(_) => {
            black = LatLong::new(1, 1, vec![[0.0; 3]])?.0;
            &black
        }
    };
    let (width, height) = (image.width(), image.height());
    let edge = gpu.limits.max_texture_dimension_2d;
    if width.max(height) > edge {
        let message = format!(
            "the environment has {width} × {height} texels; this device's images have at most {edge} an edge"
        );
        return Err(gpu.error(message));
    }
    let full = u64::from(width) * u64::from(height) * 16 <= FULL_BYTES;
    let format = if full { wgpu::TextureFormat::Rgba32Float } else { wgpu::TextureFormat::Rgba16Float };
    let texture = gpu.attempt("the environment", || create(gpu, width, height, format))?;
    let gain = if full { 1.0 } else { half_gain(image) };
    let encode = |texel: &[f32; 3]| -> Vec<u8> {
        let [r, g, b] = texel.map(|c| c / gain);
        if full {
            bytemuck::cast_slice(&[r, g, b, 0.0]).to_vec()
        } else {
            bytemuck::cast_slice(&[r, g, b, 0.0].map(f16::from_f32)).to_vec()
        }
    };
    let row_bytes = width as usize * if full { 16 } else { 8 };
    let rows = (PIECE_BYTES / row_bytes).max(1);
    for (piece, texels) in image.texels().chunks(rows * width as usize).enumerate() {
        let bytes: Vec<u8> = texels.iter().flat_map(encode).collect();
        let height = (texels.len() / width as usize) as u32;
        let to = wgpu::TexelCopyTextureInfo {
            texture: &texture,
            mip_level: 0,
            origin: wgpu::Origin3d { x: 0, y: (piece * rows) as u32, z: 0 },
            aspect: wgpu::TextureAspect::All,
        };
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(row_bytes as u32),
            rows_per_image: None,
        };
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        gpu.queue.write_texture(to, &bytes, layout, size);
    }
    Ok(Light { view: texture.create_view(&wgpu::TextureViewDescriptor::default()), gain })
}

fn create(gpu: &Gpu, width: u32, height: u32, format: wgpu::TextureFormat) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("environment"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

/// The power of two that brings the brightest texel into the range of halves.
fn half_gain(image: &LatLong) -> f32 {
    let brightest = image.texels().iter().flatten().copied().fold(0.0, f32::max);
    (brightest / f16::MAX.to_f32()).max(1.0).log2().ceil().exp2()
}
