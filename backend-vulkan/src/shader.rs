//! WGSL to SPIR-V.

use naga::{
    back::spv,
    front::wgsl,
    valid::{Capabilities, ValidationFlags, Validator},
};

/// The shader's only entry point as SPIR-V, or what is wrong with it.
///
/// No bounds are checked and no loops bounded: the text is ours, its indices come from buffers' own lengths and from
/// tables that were validated when the scene was prepared, and its loops end by construction.
pub(crate) fn spirv(source: &str) -> Result<Vec<u32>, String> {
    let module = wgsl::parse_str(source).map_err(|e| e.emit_to_string(source))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::RAY_QUERY)
        .validate(&module)
        .map_err(|e| e.emit_to_string(source))?;
    let options = spv::Options {
        lang_version: (1, 4),
        flags: spv::WriterFlags::empty(),
        fake_missing_bindings: true,
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::None,
        force_loop_bounding: false,
        ray_query_initialization_tracking: false,
        emit_int_div_checks: false,
        ..spv::Options::default()
    };
    spv::write_vec(&module, &info, &options, None).map_err(|e| e.to_string())
}
