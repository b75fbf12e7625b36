//! Runs a few lines of WGSL over a list of inputs, to compare the kernel's functions with their Rust counterparts.

use crate::device::is_required;
use backend_wgpu::{Gpu, adapters};
use bytemuck::{cast_slice, pod_collect_to_vec};
use wgpu::BufferUsages as Usage;

/// Inputs or outputs of an invocation.
pub type Row = [f32; 16];

/// All GPUs of this machine; there must be one only if `REQUIRE_BACKENDS` names wgpu.
///
/// # Panics
/// If wgpu is required and there is none, or one does not open.
pub fn gpus() -> Vec<Gpu> {
    let gpus: Vec<Gpu> = adapters().iter().map(|a| Gpu::of(a).expect("a device that opens")).collect();
    assert!(!gpus.is_empty() || !is_required("wgpu"), "REQUIRE_BACKENDS names wgpu, but there is no adapter");
    if gpus.is_empty() {
        eprintln!("skipped: no adapter on this machine");
    }
    gpus
}

/// `body` is the body of a function from `in: Row` to `out: Row` (a variable, zero at first), `library` the functions it
/// calls, and `scene` the resources of group 0 by binding.
///
/// # Panics
/// If the text is not valid or the device fails.
pub fn map(
    gpu: &Gpu,
    library: &str,
    body: &str,
    scene: &[wgpu::BindGroupEntry<'_>],
    inputs: &[Row],
) -> Vec<Row> {
    let source = format!(
        "{library}
        @group(1) @binding(0) var<storage, read> inputs: array<array<f32, 16>>;
        @group(1) @binding(1) var<storage, read_write> outputs: array<array<f32, 16>>;
        @compute @workgroup_size(64)
        fn twin(@builtin(global_invocation_id) id: vec3<u32>) {{
            if id.x >= arrayLength(&inputs) {{ return; }}
            let in = inputs[id.x];
            var out: array<f32, 16>;
            {body}
            outputs[id.x] = out;
        }}"
    );
    let device = &gpu.device;
    let pipeline = gpu
        .attempt("the twin", || {
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: None,
                source: wgpu::ShaderSource::Wgsl(source.as_str().into()),
            });
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: None,
                layout: None,
                module: &module,
                entry_point: None,
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        })
        .expect("a valid shader");
    let bytes = size_of_val(inputs) as u64;
    let from = gpu.buffer("inputs", bytes, Usage::STORAGE | Usage::COPY_DST).expect("memory");
    gpu.queue.write_buffer(&from, 0, cast_slice(inputs));
    let to = gpu.buffer("outputs", bytes, Usage::STORAGE | Usage::COPY_SRC).expect("memory");
    let back = gpu.buffer("read-back", bytes, Usage::MAP_READ | Usage::COPY_DST).expect("memory");
    let group = |index: u32, entries: &[wgpu::BindGroupEntry<'_>]| {
        let layout = pipeline.get_bind_group_layout(index);
        device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &layout, entries })
    };
    let own = group(1, &[entry(0, from.as_entire_binding()), entry(1, to.as_entire_binding())]);
    let scene = (!scene.is_empty()).then(|| group(0, scene));
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        if let Some(scene) = &scene {
            pass.set_bind_group(0, scene, &[]);
        }
        pass.set_bind_group(1, &own, &[]);
        pass.dispatch_workgroups((inputs.len() as u32).div_ceil(64), 1, 1);
    }
    encoder.copy_buffer_to_buffer(&to, 0, &back, 0, bytes);
    gpu.queue.submit([encoder.finish()]);
    back.slice(..).map_async(wgpu::MapMode::Read, |result| result.expect("mappable memory"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("a device that works");
    gpu.check().expect("a device that works");
    pod_collect_to_vec(&back.slice(..).get_mapped_range().expect("mapped memory"))
}

/// A resource at a binding.
pub fn entry(binding: u32, resource: wgpu::BindingResource<'_>) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource }
}

/// A row that begins with the given numbers.
pub fn row(numbers: &[f32]) -> Row {
    let mut row = [0.0; 16];
    row[..numbers.len()].copy_from_slice(numbers);
    row
}
