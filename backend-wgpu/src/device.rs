//! Adapters, their limits, and what they say when they fail.

use pollster::block_on;
use spectral_core::{
    Error,
    kernel::WORKGROUP,
    tracer::{DeviceInfo, Unusable},
};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Storage buffers that the kernel binds.
const STORAGE_BUFFERS: u32 = 8;

/// The adapters of this machine that can run the kernel: hardware first; OpenGL last, and only for devices that no
/// other API offers. Empty where there is no driver, which is no error.
pub fn adapters() -> Vec<wgpu::Adapter> {
    let mut adapters = all();
    adapters.retain(|adapter| lacks(adapter).is_none());
    let infos: Vec<_> = adapters.iter().map(wgpu::Adapter::get_info).collect();
    let mut through_gl = infos.iter().map(|info| info.backend == wgpu::Backend::Gl && twice(info, &infos));
    adapters.retain(|_| !through_gl.next().unwrap_or_default());
    adapters.sort_by_key(|adapter| {
        let info = adapter.get_info();
        (info.device_type == wgpu::DeviceType::Cpu, info.backend == wgpu::Backend::Gl)
    });
    adapters
}

/// All adapters, whatever they can do.
fn all() -> Vec<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    block_on(instance.enumerate_adapters(wgpu::Backends::all()))
}

/// Whether another API offers the same device; OpenGL likes to append to its name.
fn twice(info: &wgpu::AdapterInfo, all: &[wgpu::AdapterInfo]) -> bool {
    all.iter().any(|other| other.backend != wgpu::Backend::Gl && info.name.starts_with(&other.name))
}

/// What an adapter lacks to run the kernel.
fn lacks(adapter: &wgpu::Adapter) -> Option<String> {
    if !adapter.get_downlevel_capabilities().flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
        return Some("it has no compute shaders".to_owned());
    }
    short_of(&adapter.limits())
}

/// The first limit that is below what the kernel needs.
fn short_of(limits: &wgpu::Limits) -> Option<String> {
    let needs = [
        ("storage buffers a shader", limits.max_storage_buffers_per_shader_stage, STORAGE_BUFFERS),
        ("invocations along a workgroup", limits.max_compute_workgroup_size_x, WORKGROUP),
        ("invocations a workgroup", limits.max_compute_invocations_per_workgroup, WORKGROUP),
    ];
    let short = needs.into_iter().find(|(_, has, needed)| has < needed);
    short.map(|(what, has, needed)| format!("it has {has} {what}; {needed} are needed"))
}

fn has_subgroups(adapter: &wgpu::Adapter) -> bool {
    adapter.features().contains(wgpu::Features::SUBGROUP)
}

/// Adapters that cannot run the kernel, and the lack of any.
pub(crate) fn unusable() -> Vec<Unusable> {
    let all = all();
    if all.is_empty() {
        let reason = "no driver of Vulkan, Metal, Direct3D 12 or OpenGL offers one on this machine";
        return vec![Unusable { name: "adapters".to_owned(), reason: reason.to_owned() }];
    }
    let unusable = |adapter: &wgpu::Adapter| {
        let info = adapter.get_info();
        let reason = lacks(adapter)?;
        Some(Unusable { name: format!("{} through {}", info.name, api(info.backend)), reason })
    };
    all.iter().filter_map(unusable).collect()
}

/// What this machine offers.
pub(crate) fn devices() -> Vec<DeviceInfo> {
    adapters().iter().enumerate().map(|(index, adapter)| describe(index, adapter)).collect()
}

/// What this machine offers that has subgroups; numbered as by [`devices`].
pub(crate) fn devices_with_subgroups() -> Vec<DeviceInfo> {
    let all = adapters();
    let able = all.iter().enumerate().filter(|(_, adapter)| has_subgroups(adapter));
    able.map(|(index, adapter)| describe(index, adapter)).collect()
}

/// The name of an interface, as its makers write it.
fn api(backend: wgpu::Backend) -> &'static str {
    match backend {
        wgpu::Backend::Vulkan => "Vulkan",
        wgpu::Backend::Metal => "Metal",
        wgpu::Backend::Dx12 => "Direct3D 12",
        wgpu::Backend::Gl => "OpenGL",
        wgpu::Backend::BrowserWebGpu => "WebGPU",
        wgpu::Backend::Noop => "nothing",
    }
}

fn describe(index: usize, adapter: &wgpu::Adapter) -> DeviceInfo {
    let info = adapter.get_info();
    let driver = format!("{} {}", info.driver, info.driver_info);
    DeviceInfo {
        backend: "wgpu",
        index,
        name: info.name,
        driver: driver.trim().to_owned(),
        api: api(info.backend),
        memory: 0,
        intersection: "SBVH, or facet planes for one convex stone, in compute shaders",
        hardware: info.device_type != wgpu::DeviceType::Cpu,
    }
}

/// An open device.
#[derive(Debug)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// What may be asked of it.
    pub limits: wgpu::Limits,
    /// Whether it has the operations of WGSL's subgroups.
    pub subgroups: bool,
    /// Compiled shaders by their text.
    pub(crate) pipelines: Mutex<HashMap<String, wgpu::ComputePipeline>>,
    name: String,
    /// The first failure that the driver reported.
    failure: Arc<Mutex<Option<String>>>,
}

impl Gpu {
    /// Opens one of [`WGPU`](crate::WGPU)'s devices.
    ///
    /// # Errors
    /// [`Error::Device`] where it is no longer there, or refuses.
    pub fn open(info: &DeviceInfo) -> Result<Self, Error> {
        let adapter = adapters()
            .into_iter()
            .nth(info.index)
            .filter(|adapter| adapter.get_info().name == info.name)
            .ok_or_else(|| failed(&info.name, "the device is no longer there"))?;
        Self::of(&adapter)
    }

    /// Opens an adapter.
    ///
    /// # Errors
    /// [`Error::Device`] where it refuses.
    pub fn of(adapter: &wgpu::Adapter) -> Result<Self, Error> {
        let name = adapter.get_info().name;
        let limits = adapter.limits();
        let subgroups = has_subgroups(adapter);
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("gemtrace"),
            required_features: adapter.features() & wgpu::Features::SUBGROUP,
            required_limits: limits.clone(),
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) =
            block_on(adapter.request_device(&descriptor)).map_err(|e| failed(&name, &e.to_string()))?;
        let failure = Arc::new(Mutex::new(None));
        let first = failure.clone();
        device.on_uncaptured_error(Arc::new(move |error| note(&first, plain(&error))));
        let first = failure.clone();
        device.set_device_lost_callback(move |_, message| {
            note(&first, format!("the device was lost: {message}"));
        });
        Ok(Gpu { device, queue, limits, subgroups, pipelines: Mutex::default(), name, failure })
    }

    /// The error that this device has failed with the given message.
    pub fn error(&self, message: impl AsRef<str>) -> Error {
        failed(&self.name, message.as_ref())
    }

    /// Fails if the driver has reported a failure.
    ///
    /// # Errors
    /// [`Error::Device`].
    pub fn check(&self) -> Result<(), Error> {
        match &*self.failure.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(message) => Err(self.error(message)),
            None => Ok(()),
        }
    }

    /// A storage buffer of `bytes`, at least one block of 256, to be written by the host, and read back if `read`.
    ///
    /// # Errors
    /// [`Error::Device`] where it exceeds the device's limits or memory.
    pub fn storage(&self, what: &str, bytes: u64, read: bool) -> Result<wgpu::Buffer, Error> {
        let size = bytes.next_multiple_of(16).max(256);
        let limit = self.largest_buffer();
        if size > limit {
            let mib = |bytes: u64| bytes.div_ceil(1 << 20);
            let message =
                format!("{what} need {} MiB; this device binds at most {} MiB", mib(size), mib(limit));
            return Err(self.error(message));
        }
        let mut usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        if read {
            usage |= wgpu::BufferUsages::COPY_SRC;
        }
        self.buffer(what, size, usage)
    }

    /// A storage buffer with the given contents.
    ///
    /// # Errors
    /// As [`Gpu::storage`].
    pub fn filled(&self, what: &str, contents: &[u8]) -> Result<wgpu::Buffer, Error> {
        let buffer = self.storage(what, contents.len() as u64, false)?;
        self.queue.write_buffer(&buffer, 0, contents);
        Ok(buffer)
    }

    /// Waits for a submission for at most `patience`; whether it has ended.
    ///
    /// # Errors
    /// [`Error::Device`] where the device fails.
    pub fn poll(&self, submission: &wgpu::SubmissionIndex, patience: Duration) -> Result<bool, Error> {
        let wait =
            wgpu::PollType::Wait { submission_index: Some(submission.clone()), timeout: Some(patience) };
        let ended = match self.device.poll(wait) {
            Ok(_) => true,
            Err(wgpu::PollError::Timeout) => false,
            Err(e) => return Err(self.error(e.to_string())),
        };
        self.check().map(|()| ended)
    }

    /// A buffer, or the device's refusal.
    ///
    /// # Errors
    /// [`Error::Device`].
    pub fn buffer(&self, what: &str, size: u64, usage: wgpu::BufferUsages) -> Result<wgpu::Buffer, Error> {
        self.attempt(what, || {
            self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(what),
                size,
                usage,
                mapped_at_creation: false,
            })
        })
    }

    /// Bytes of the largest storage buffer.
    pub fn largest_buffer(&self) -> u64 {
        self.limits.max_storage_buffer_binding_size.min(self.limits.max_buffer_size)
    }

    /// Makes something on the device; its failure becomes an error that names `what`.
    ///
    /// # Errors
    /// [`Error::Device`].
    pub fn attempt<T>(&self, what: &str, make: impl FnOnce() -> T) -> Result<T, Error> {
        // Natively the driver's refusals come before the call returns, in the handler that `Gpu::of` sets.
        let made = make();
        let failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner).take();
        failure.map_or(Ok(made), |message| Err(self.error(format!("{what}: {message}"))))
    }
}

fn failed(device: &str, message: &str) -> Error {
    Error::Device { device: device.to_owned(), message: message.to_owned() }
}

fn note(first: &Mutex<Option<String>>, message: String) {
    first.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(message);
}

fn plain(error: &wgpu::Error) -> String {
    match error {
        wgpu::Error::OutOfMemory { .. } => "the device has no memory left".to_owned(),
        wgpu::Error::Validation { description, .. } | wgpu::Error::Internal { description, .. } => {
            description.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_device_says_which_interface_it_is_reached_through() {
        for (adapter, device) in adapters().iter().zip(devices()) {
            assert_eq!(device.api, api(adapter.get_info().backend));
        }
        assert_eq!(api(wgpu::Backend::Gl), "OpenGL");
    }

    #[test]
    fn what_a_device_is_short_of_is_named_with_what_is_needed() {
        let enough = wgpu::Limits::default();
        assert_eq!(short_of(&enough), None);
        let few = wgpu::Limits { max_storage_buffers_per_shader_stage: 4, ..enough.clone() };
        assert_eq!(short_of(&few).expect("short"), "it has 4 storage buffers a shader; 8 are needed");
        let small = wgpu::Limits { max_compute_invocations_per_workgroup: 32, ..enough };
        assert_eq!(short_of(&small).expect("short"), "it has 32 invocations a workgroup; 64 are needed");
    }
}
