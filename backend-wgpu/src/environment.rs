//! The light as a texture.

use crate::device::Gpu;
use spectral_core::{Error, environment::Source, kernel::texel::Texels};

/// The environment on the device.
#[derive(Debug)]
pub struct Light {
    /// The texture, lat-long.
    pub view: wgpu::TextureView,
    /// What a texel is to be multiplied by.
    pub gain: f32,
}

/// Uploads the environment; a uniform one is in the scene's block, and its texture is never read.
///
/// # Errors
/// [`Error::Device`] for an image beyond the device's limits or memory.
pub fn upload(gpu: &Gpu, source: &Source) -> Result<Light, Error> {
    let texels = Texels::of(source);
    let (width, height) = (texels.width, texels.height);
    let edge = gpu.limits.max_texture_dimension_2d;
    if width.max(height) > edge {
        let message = format!(
            "the environment has {width} × {height} texels; this device's images have at most {edge} an edge"
        );
        return Err(gpu.error(message));
    }
    let texture = gpu.attempt("the environment", || create(gpu, &texels))?;
    for (row, bytes) in texels.pieces() {
        let to = wgpu::TexelCopyTextureInfo {
            texture: &texture,
            mip_level: 0,
            origin: wgpu::Origin3d { x: 0, y: row, z: 0 },
            aspect: wgpu::TextureAspect::All,
        };
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(texels.row_bytes()),
            rows_per_image: None,
        };
        let height = bytes.len() as u32 / texels.row_bytes();
        gpu.queue.write_texture(
            to,
            &bytes,
            layout,
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
    }
    Ok(Light { view: texture.create_view(&wgpu::TextureViewDescriptor::default()), gain: texels.gain })
}

fn create(gpu: &Gpu, texels: &Texels<'_>) -> wgpu::Texture {
    let format =
        if texels.full { wgpu::TextureFormat::Rgba32Float } else { wgpu::TextureFormat::Rgba16Float };
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("environment"),
        size: wgpu::Extent3d { width: texels.width, height: texels.height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}
