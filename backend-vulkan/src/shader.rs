//! WGSL to SPIR-V.

use naga::{
    back::spv,
    front::wgsl,
    valid::{Capabilities, ValidationFlags, Validator},
};

/// The shader's entry points as SPIR-V, or what is wrong with it.
///
/// No bounds are checked and no loops bounded: the text is ours, its indices come from buffers' own lengths and from
/// tables that were validated when the scene was prepared, guesses are compared with their number, and its loops end by
/// construction.
pub(crate) fn spirv(source: &str) -> Result<Vec<u32>, String> {
    let module = wgsl::parse_str(source).map_err(|e| e.emit_to_string(source))?;
    let able = Capabilities::RAY_QUERY
        | Capabilities::RAY_TRACING_PIPELINE
        | Capabilities::PRIMITIVE_INDEX
        | Capabilities::SUBGROUP;
    let info = Validator::new(ValidationFlags::all(), able)
        .validate(&module)
        .map_err(|e| e.emit_to_string(source))?;
    let options = spv::Options {
        lang_version: (1, 4),
        flags: spv::WriterFlags::empty(),
        fake_missing_bindings: true,
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::None,
        force_loop_bounding: false,
        ray_query_initialization_tracking: false,
        trace_ray_argument_validation: false,
        emit_int_div_checks: false,
        ..spv::Options::default()
    };
    spv::write_vec(&module, &info, &options, None).map_err(|e| e.to_string())
}

// From the SPIR-V specification, unified 1, section 3: opcodes, and the any-hit execution model.
const OP_ENTRY_POINT: u32 = 15;
const OP_FUNCTION: u32 = 54;
const OP_FUNCTION_END: u32 = 56;
const OP_RETURN: u32 = 253;
const OP_IGNORE_INTERSECTION_KHR: u32 = 4448;
const ANY_HIT_KHR: u32 = 5315;
/// Words before the first instruction.
const HEADER: usize = 5;

/// Makes every return of the any-hit entry point but the last ignore the candidate: WGSL has no word for that.
/// Both instructions end a block and take one word, so nothing else changes.
pub(crate) fn ignore_at_early_returns(words: &mut [u32]) -> Result<(), String> {
    let mut entry = None;
    let mut inside = false;
    let mut returns = Vec::new();
    let mut at = HEADER;
    while at < words.len() {
        let (opcode, length) = (words[at] & 0xffff, (words[at] >> 16) as usize);
        if length == 0 || at + length > words.len() {
            return Err(format!("word {at} of the shader begins no instruction"));
        }
        match opcode {
            OP_ENTRY_POINT if words[at + 1] == ANY_HIT_KHR => entry = Some(words[at + 2]),
            OP_FUNCTION => inside = Some(words[at + 2]) == entry,
            OP_FUNCTION_END => inside = false,
            OP_RETURN if inside => returns.push(at),
            _ => {}
        }
        at += length;
    }
    let [early @ .., _last] = &returns[..] else {
        return Err("the shader has no any-hit entry point".into());
    };
    for at in early {
        words[*at] = 1 << 16 | OP_IGNORE_INTERSECTION_KHR;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHADER: &str = "enable wgpu_ray_tracing_pipeline;
        enable primitive_index;
        struct Payload { kept: u32 }
        var<incoming_ray_payload> payload: Payload;
        @any_hit @incoming_payload(payload)
        fn consider(@builtin(primitive_index) primitive: u32) {
            if primitive > 7u { return; }
            payload.kept += 1u;
        }";

    fn count(words: &[u32], instruction: u32) -> usize {
        words.iter().filter(|word| **word == (1 << 16 | instruction)).count()
    }

    #[test]
    fn an_early_return_ignores_the_candidate() {
        let mut words = spirv(SHADER).expect("a valid shader");
        let returns = count(&words, OP_RETURN);
        ignore_at_early_returns(&mut words).expect("an any-hit shader");
        assert_eq!(count(&words, OP_IGNORE_INTERSECTION_KHR), 1);
        assert_eq!(count(&words, OP_RETURN), returns - 1);
    }

    #[test]
    fn a_shader_without_candidates_is_refused() {
        let mut words = spirv("@compute @workgroup_size(1) fn nothing() {}").expect("a valid shader");
        assert!(ignore_at_early_returns(&mut words).is_err());
    }
}
