//! An open device: submitting work, waiting for it, and what it says when it fails.

use crate::{
    Intersection,
    physical::{Driver, Limits, Physical, find, reason},
};
use ash::{khr, vk};
use spectral_core::{Error, tracer::DeviceInfo};
use std::mem::ManuallyDrop;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// An open device with one queue.
pub(crate) struct Gpu {
    pub device: ash::Device,
    /// Present where the device was opened for its own ray tracing.
    structures: Option<khr::acceleration_structure::Device>,
    /// Present where it was opened for pipelines of it.
    pipelines: Option<khr::ray_tracing_pipeline::Device>,
    pub limits: Limits,
    pub memory: vk::PhysicalDeviceMemoryProperties,
    /// Compiled pipelines, shared by those that are alike.
    pub cache: vk::PipelineCache,
    /// The queue family in use.
    pub family: u32,
    /// Tracers of one device may be in several threads.
    queue: Mutex<vk::Queue>,
    name: String,
    failed: AtomicBool,
    /// Outlives a failed device, which may still run in it.
    driver: ManuallyDrop<Driver>,
}

impl Drop for Gpu {
    fn drop(&mut self) {
        if self.failed.load(Ordering::Relaxed) {
            return;
        }
        // SAFETY: idle; whatever was made with this device held it, so nothing of it is left. The driver goes last and
        // is not used again.
        unsafe {
            self.device.destroy_pipeline_cache(self.cache, None);
            self.device.destroy_device(None);
            ManuallyDrop::drop(&mut self.driver);
        }
    }
}

impl Gpu {
    /// Opens one of [`VULKAN`](crate::VULKAN)'s devices for a form of intersection, the best it offers where none is asked for.
    pub fn open(info: &DeviceInfo, asked: Option<Intersection>) -> Result<(Arc<Self>, Intersection), Error> {
        let failed = |message: &str| Error::Device { device: info.name.clone(), message: message.to_owned() };
        let gone = || failed("the device is no longer there");
        let driver = Driver::load().map_err(|_| gone())?;
        let physical = find(&driver, info).ok_or_else(gone)?;
        let form = asked.unwrap_or(physical.forms()[0]);
        if !physical.offers(form) {
            let message =
                format!("this device has no {}; it has {}", form.name(), physical.forms()[0].name());
            return Err(failed(&message));
        }
        let gpu = Self::new(driver, &physical, form).map_err(|result| failed(reason(result)))?;
        Ok((Arc::new(gpu), form))
    }

    fn new(driver: Driver, physical: &Physical, form: Intersection) -> Result<Self, vk::Result> {
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(physical.family)
            .queue_priorities(&[1.0])];
        let extensions: Vec<_> = form.extensions().iter().map(|name| name.as_ptr()).collect();
        let (traced, piped) = (form != Intersection::Software, form == Intersection::Pipeline);
        let plain = vk::PhysicalDeviceFeatures::default().geometry_shader(piped);
        let mut addresses = vk::PhysicalDeviceVulkan12Features::default().buffer_device_address(traced);
        let mut maintenance = vk::PhysicalDeviceVulkan13Features::default().maintenance4(true);
        let mut structures =
            vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default().acceleration_structure(true);
        let mut query = vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true);
        let mut pipeline =
            vk::PhysicalDeviceRayTracingPipelineFeaturesKHR::default().ray_tracing_pipeline(true);
        let mut info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_extension_names(&extensions)
            .enabled_features(&plain)
            .push_next(&mut addresses)
            .push_next(&mut maintenance);
        info = match form {
            Intersection::RayQuery => info.push_next(&mut structures).push_next(&mut query),
            Intersection::Pipeline => info.push_next(&mut structures).push_next(&mut pipeline),
            Intersection::Software => info,
        };
        // SAFETY: valid: the device has said that it has what is asked for.
        let device = unsafe { driver.instance.create_device(physical.handle, &info, None) }?;
        // SAFETY: valid, the family and queue as the device was created with. A failure here leaks a device, whose
        // driver has no memory left.
        let (queue, cache) = unsafe {
            (
                device.get_device_queue(physical.family, 0),
                device.create_pipeline_cache(&vk::PipelineCacheCreateInfo::default(), None)?,
            )
        };
        let structures = traced.then(|| khr::acceleration_structure::Device::new(&driver.instance, &device));
        let pipelines = piped.then(|| khr::ray_tracing_pipeline::Device::new(&driver.instance, &device));
        Ok(Gpu {
            device,
            structures,
            pipelines,
            limits: physical.limits,
            memory: physical.memory,
            cache,
            family: physical.family,
            queue: Mutex::new(queue),
            name: physical.name.clone(),
            failed: AtomicBool::new(false),
            driver: ManuallyDrop::new(driver),
        })
    }

    /// The functions of acceleration structures.
    pub fn structures(&self) -> Result<&khr::acceleration_structure::Device, Error> {
        self.structures.as_ref().ok_or_else(|| self.error("opened without acceleration structures"))
    }

    /// The functions of ray-tracing pipelines.
    pub fn pipelines(&self) -> Result<&khr::ray_tracing_pipeline::Device, Error> {
        self.pipelines.as_ref().ok_or_else(|| self.error("opened without ray-tracing pipelines"))
    }

    /// The error that this device has failed with the given message.
    pub fn error(&self, message: impl AsRef<str>) -> Error {
        Error::Device { device: self.name.clone(), message: message.as_ref().to_owned() }
    }

    /// A failure of the API as an error that names what was being done.
    pub fn failure(&self, what: &str) -> impl FnOnce(vk::Result) -> Error {
        let error = move |name: &str, what: &str, result| Error::Device {
            device: name.to_owned(),
            message: format!("{what}: {}", reason(result)),
        };
        let (name, what) = (self.name.clone(), what.to_owned());
        move |result| error(&name, &what, result)
    }

    /// Whether what was made with this device may be destroyed: not where the device may still use it.
    pub fn releases(&self) -> bool {
        !self.failed.load(Ordering::Relaxed)
    }

    /// The device has failed or hangs: it is not used any more, and nothing of it is freed.
    pub fn abandon(&self) {
        self.failed.store(true, Ordering::Relaxed);
    }

    /// Sends recorded commands; the fence, which is not signalled, will say when they have ended.
    ///
    /// # Errors
    /// [`Error::Device`] where the driver refuses; the device can then not be used any more.
    pub fn submit(&self, commands: &[vk::CommandBuffer], fence: vk::Fence) -> Result<(), Error> {
        let submission = [vk::SubmitInfo::default().command_buffers(commands)];
        let queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: valid; what the commands use is alive until they have ended.
        unsafe { self.device.queue_submit(*queue, &submission, fence) }
            .map_err(self.failure("the work was refused"))
            .inspect_err(|_| self.abandon())
    }
}
