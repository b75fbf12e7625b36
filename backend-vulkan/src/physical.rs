//! The loader, physical devices, and what they offer or lack.

use crate::Intersection;
use ash::{khr, vk};
use spectral_core::{
    kernel::WORKGROUP,
    tracer::{DeviceInfo, Unusable},
};
use std::ffi::CStr;

/// What `trace` and `gather` bind at most.
const STORAGE_BUFFERS: u32 = 8;

/// The loader with an instance.
pub(crate) struct Driver {
    pub instance: ash::Instance,
    /// The library must stay for as long as its functions.
    _entry: ash::Entry,
}

impl Drop for Driver {
    fn drop(&mut self) {
        // SAFETY: alive; devices hold the driver they come from, so none is left.
        unsafe { self.instance.destroy_instance(None) };
    }
}

impl Driver {
    /// Fails where there is no loader, or none of Vulkan 1.3.
    pub fn load() -> Result<Self, Unusable> {
        // SAFETY: the system's Vulkan loader, whose initialisation asks nothing of the caller.
        Self::of(unsafe { ash::Entry::load() })
    }

    fn of(entry: Result<ash::Entry, ash::LoadingError>) -> Result<Self, Unusable> {
        let unusable = |reason| Unusable { name: "Vulkan loader".to_owned(), reason };
        // What the system says of the library names the file that it looked for.
        let entry = entry.map_err(|error| unusable(format!("it could not be loaded: {error}")))?;
        // SAFETY: valid; no arguments.
        let version = unsafe { entry.try_enumerate_instance_version() };
        if let Some(reason) = short_of_version(version.ok().flatten().unwrap_or(vk::API_VERSION_1_0)) {
            return Err(unusable(reason));
        }
        let application =
            vk::ApplicationInfo::default().application_name(c"gemtrace").api_version(vk::API_VERSION_1_3);
        let info = vk::InstanceCreateInfo::default().application_info(&application);
        // SAFETY: valid.
        let instance = unsafe { entry.create_instance(&info, None) }
            .map_err(|result| unusable(format!("it finds no driver that works: {}", reason(result))))?;
        Ok(Driver { instance, _entry: entry })
    }

    /// The devices that can run the kernel: hardware first.
    fn devices(&self) -> Vec<Physical> {
        let all = self.handles().into_iter().filter_map(|handle| Physical::new(self, handle).ok());
        let mut devices: Vec<_> = all.collect();
        devices.sort_by_key(|device| !device.hardware);
        devices
    }

    fn handles(&self) -> Vec<vk::PhysicalDevice> {
        // SAFETY: alive.
        unsafe { self.instance.enumerate_physical_devices() }.unwrap_or_default()
    }
}

/// A physical device that can run the kernel.
pub(crate) struct Physical {
    pub handle: vk::PhysicalDevice,
    pub name: String,
    driver: String,
    hardware: bool,
    pub memory: vk::PhysicalDeviceMemoryProperties,
    pub limits: Limits,
    /// The queue family to use.
    pub family: u32,
    /// Its own ray tracing.
    offered: Offered,
}

/// What a device has of the driver's ray tracing.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Offered {
    ray_query: bool,
    pipeline: bool,
}

/// What may be asked of a device.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Limits {
    /// Bytes of the largest storage buffer.
    pub storage: u64,
    /// Bytes of memory that a workgroup shares.
    pub workgroup_memory: u32,
    /// Whether compute shaders have the subgroup operations that the kernel uses.
    pub subgroups: bool,
    /// Texels along the edge of an image.
    pub image: u32,
    /// Triangles of an acceleration structure.
    pub triangles: u64,
    /// Alignment of the memory that the driver builds acceleration structures with.
    pub scratch_alignment: u64,
    /// Bytes by which rays know a shader.
    pub handle: u32,
    /// Alignment of handles in a table.
    pub handle_alignment: u32,
    /// Alignment of tables.
    pub table_alignment: u64,
}

impl Physical {
    /// Fails for a device that cannot run the kernel.
    fn new(driver: &Driver, handle: vk::PhysicalDevice) -> Result<Self, Unusable> {
        let instance = &driver.instance;
        // SAFETY: alive.
        let (plain, families, memory) = unsafe {
            (
                instance.get_physical_device_properties(handle),
                instance.get_physical_device_queue_family_properties(handle),
                instance.get_physical_device_memory_properties(handle),
            )
        };
        let name = text(plain.device_name_as_c_str());
        let unusable = |reason| Unusable { name: name.clone(), reason };
        let short = short_of_version(plain.api_version).or_else(|| short_of(&plain.limits));
        short.map_or(Ok(()), |reason| Err(unusable(reason)))?;
        let computes = |f: &vk::QueueFamilyProperties| f.queue_flags.contains(vk::QueueFlags::COMPUTE);
        let family = families.iter().position(computes);
        let family = family.ok_or_else(|| unusable("it has no queue that computes".to_owned()))? as u32;
        let offered = Offered::by(instance, handle);
        let mut about = vk::PhysicalDeviceDriverProperties::default();
        let mut structures = vk::PhysicalDeviceAccelerationStructurePropertiesKHR::default();
        let mut tables = vk::PhysicalDeviceRayTracingPipelinePropertiesKHR::default();
        let mut maintenance = vk::PhysicalDeviceMaintenance4Properties::default();
        let mut subgroups = vk::PhysicalDeviceSubgroupProperties::default();
        let mut all = vk::PhysicalDeviceProperties2::default()
            .push_next(&mut about)
            .push_next(&mut maintenance)
            .push_next(&mut subgroups);
        if offered.ray_query || offered.pipeline {
            all = all.push_next(&mut structures);
        }
        if offered.pipeline {
            all = all.push_next(&mut tables);
        }
        // SAFETY: valid: what is asked for belongs to 1.3 or to an extension that the device has.
        unsafe { instance.get_physical_device_properties2(handle, &mut all) };
        let limits = Limits {
            storage: u64::from(plain.limits.max_storage_buffer_range).min(maintenance.max_buffer_size),
            workgroup_memory: plain.limits.max_compute_shared_memory_size,
            subgroups: has_subgroups(&subgroups),
            image: plain.limits.max_image_dimension2_d,
            triangles: structures.max_primitive_count,
            scratch_alignment: u64::from(structures.min_acceleration_structure_scratch_offset_alignment)
                .max(1),
            handle: tables.shader_group_handle_size,
            handle_alignment: tables.shader_group_handle_alignment.max(1),
            table_alignment: u64::from(tables.shader_group_base_alignment).max(1),
        };
        let hardware = plain.device_type != vk::PhysicalDeviceType::CPU;
        let driver = driver_text(&about);
        Ok(Physical { handle, name, driver, hardware, memory, limits, family, offered })
    }

    pub fn offers(&self, form: Intersection) -> bool {
        match form {
            Intersection::RayQuery => self.offered.ray_query,
            Intersection::Pipeline => self.offered.pipeline,
            Intersection::Software => true,
        }
    }

    pub fn forms(&self) -> Vec<Intersection> {
        Intersection::ALL.into_iter().filter(|form| self.offers(*form)).collect()
    }

    fn describe(&self, index: usize) -> DeviceInfo {
        let local = |heap: &&vk::MemoryHeap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL);
        DeviceInfo {
            backend: "vulkan",
            index,
            name: self.name.clone(),
            driver: self.driver.clone(),
            api: "Vulkan",
            memory: self.memory.memory_heaps_as_slice().iter().filter(local).map(|heap| heap.size).sum(),
            intersection: self.forms()[0].name(),
            hardware: self.hardware,
        }
    }
}

/// Whether compute shaders have what the kernel asks of subgroups.
fn has_subgroups(subgroups: &vk::PhysicalDeviceSubgroupProperties<'_>) -> bool {
    use vk::SubgroupFeatureFlags as Operations;
    let needed = Operations::BASIC
        | Operations::VOTE
        | Operations::BALLOT
        | Operations::SHUFFLE
        | Operations::ARITHMETIC;
    subgroups.supported_stages.contains(vk::ShaderStageFlags::COMPUTE)
        && subgroups.supported_operations.contains(needed)
}

fn text(name: Result<&CStr, impl Sized>) -> String {
    name.map_or_else(|_| String::new(), |name| name.to_string_lossy().into_owned())
}

fn driver_text(about: &vk::PhysicalDeviceDriverProperties<'_>) -> String {
    let name = text(about.driver_name_as_c_str());
    format!("{name} {}", text(about.driver_info_as_c_str())).trim().to_owned()
}

impl Offered {
    fn by(instance: &ash::Instance, handle: vk::PhysicalDevice) -> Self {
        // SAFETY: alive.
        let extensions =
            unsafe { instance.enumerate_device_extension_properties(handle) }.unwrap_or_default();
        let has = |name: &CStr| extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
        let all = |form: Intersection| form.extensions().iter().all(|name| has(name));
        let mut structures = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default();
        let mut query = vk::PhysicalDeviceRayQueryFeaturesKHR::default();
        let mut pipeline = vk::PhysicalDeviceRayTracingPipelineFeaturesKHR::default();
        let mut features = vk::PhysicalDeviceFeatures2::default();
        if has(khr::acceleration_structure::NAME) {
            features = features.push_next(&mut structures);
        }
        if all(Intersection::RayQuery) {
            features = features.push_next(&mut query);
        }
        if all(Intersection::Pipeline) {
            features = features.push_next(&mut pipeline);
        }
        // SAFETY: valid: the device has the extensions asked about.
        unsafe { instance.get_physical_device_features2(handle, &mut features) };
        let numbered = features.features.geometry_shader == vk::TRUE;
        let structures = structures.acceleration_structure == vk::TRUE;
        Offered {
            ray_query: structures && query.ray_query == vk::TRUE,
            // The number of a triangle is a matter of geometry shaders where naga writes it for any-hit shaders.
            pipeline: structures && numbered && pipeline.ray_tracing_pipeline == vk::TRUE,
        }
    }
}

impl Intersection {
    /// The extensions that it needs.
    pub(crate) fn extensions(self) -> &'static [&'static CStr] {
        match self {
            Intersection::RayQuery => &[
                khr::acceleration_structure::NAME,
                khr::deferred_host_operations::NAME,
                khr::ray_query::NAME,
            ],
            Intersection::Pipeline => &[
                khr::acceleration_structure::NAME,
                khr::deferred_host_operations::NAME,
                khr::ray_tracing_pipeline::NAME,
            ],
            Intersection::Software => &[],
        }
    }
}

/// What this machine offers.
pub(crate) fn devices() -> Vec<DeviceInfo> {
    let Ok(driver) = Driver::load() else { return Vec::new() };
    driver.devices().iter().enumerate().map(|(index, device)| device.describe(index)).collect()
}

/// Devices that cannot run the kernel, and the lack of a loader or of any device.
pub(crate) fn unusable() -> Vec<Unusable> {
    let driver = match Driver::load() {
        Ok(driver) => driver,
        Err(unusable) => return vec![unusable],
    };
    let handles = driver.handles();
    if handles.is_empty() {
        let reason = "the loader is there, and no driver that it knows offers a device";
        return vec![Unusable { name: "devices".to_owned(), reason: reason.to_owned() }];
    }
    handles.into_iter().filter_map(|handle| Physical::new(&driver, handle).err()).collect()
}

/// In what way a version of the API is too old.
fn short_of_version(version: u32) -> Option<String> {
    let (major, minor) = (vk::api_version_major(version), vk::api_version_minor(version));
    (version < vk::API_VERSION_1_3).then(|| format!("it has Vulkan {major}.{minor}; 1.3 is needed"))
}

/// The first limit that is below what the kernel needs.
fn short_of(limits: &vk::PhysicalDeviceLimits) -> Option<String> {
    let needs = [
        ("storage buffers a shader", limits.max_per_stage_descriptor_storage_buffers, STORAGE_BUFFERS),
        ("invocations a workgroup", limits.max_compute_work_group_invocations, WORKGROUP),
    ];
    let short = needs.into_iter().find(|(_, has, needed)| has < needed);
    short.map(|(what, has, needed)| format!("it has {has} {what}; {needed} are needed"))
}

/// What this machine offers that has a form of intersection, which is named for it; numbered as by [`devices`].
pub(crate) fn devices_with(form: Intersection) -> Vec<DeviceInfo> {
    let Ok(driver) = Driver::load() else { return Vec::new() };
    let all = driver.devices().into_iter().enumerate();
    all.filter(|(_, device)| device.offers(form))
        .map(|(index, device)| DeviceInfo { intersection: form.name(), ..device.describe(index) })
        .collect()
}

/// What this machine offers that has subgroups; numbered as by [`devices`].
pub(crate) fn devices_with_subgroups() -> Vec<DeviceInfo> {
    let Ok(driver) = Driver::load() else { return Vec::new() };
    let all = driver.devices().into_iter().enumerate();
    all.filter(|(_, device)| device.limits.subgroups).map(|(index, device)| device.describe(index)).collect()
}

/// The device that a description is of, if it is still there.
pub(crate) fn find(driver: &Driver, info: &DeviceInfo) -> Option<Physical> {
    driver.devices().into_iter().nth(info.index).filter(|device| device.name == info.name)
}

/// A failure of the API in words.
pub(crate) fn reason(result: vk::Result) -> &'static str {
    match result {
        vk::Result::ERROR_OUT_OF_HOST_MEMORY => "the driver has no memory left",
        vk::Result::ERROR_OUT_OF_DEVICE_MEMORY => "the device has no memory left",
        vk::Result::ERROR_DEVICE_LOST => "the device was lost",
        vk::Result::ERROR_INITIALIZATION_FAILED => "the driver could not open the device",
        vk::Result::ERROR_TOO_MANY_OBJECTS => "the driver allows no more objects",
        vk::Result::ERROR_FEATURE_NOT_PRESENT | vk::Result::ERROR_EXTENSION_NOT_PRESENT => {
            "the driver refuses a feature that it lists"
        }
        _ => "the driver reports a failure of its own",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_loader_is_named_with_the_file_looked_for() {
        // SAFETY: there is no such library, so none is initialised.
        let entry = unsafe { ash::Entry::load_from("libvulkan-that-is-not-here.so.1") };
        let unusable = Driver::of(entry).err().expect("no loader");
        assert_eq!(unusable.name, "Vulkan loader");
        let reason = unusable.reason;
        assert!(
            reason.starts_with("it could not be loaded: ") && reason.contains("not-here.so.1"),
            "{reason}"
        );
    }

    #[test]
    fn what_a_device_is_short_of_is_named_with_what_is_needed() {
        assert_eq!(short_of_version(vk::API_VERSION_1_3), None);
        let old = short_of_version(vk::make_api_version(0, 1, 1, 200)).expect("too old");
        assert_eq!(old, "it has Vulkan 1.1; 1.3 is needed");
        let limits = vk::PhysicalDeviceLimits {
            max_per_stage_descriptor_storage_buffers: 4,
            max_compute_work_group_invocations: 128,
            ..Default::default()
        };
        assert_eq!(short_of(&limits).expect("short"), "it has 4 storage buffers a shader; 8 are needed");
        let enough = vk::PhysicalDeviceLimits { max_per_stage_descriptor_storage_buffers: 8, ..limits };
        assert_eq!(short_of(&enough), None);
    }
}
