//! The kernel's form of a [`Medium`], made from its figures.

use super::wgsl;
use crate::prepare::Medium;

/// Vectors of four numbers that a medium takes in the optics.
pub(super) const VECTORS: usize = Medium::FIGURES.div_ceil(4);

/// The structure `Medium`, the constant `AIR`, and `medium_at`, which reads a medium from a place in `optics`.
pub(super) fn declarations() -> String {
    let figures = Medium::AIR.figures();
    let fields: Vec<String> = figures.iter().map(|(name, _)| format!("{name}: f32")).collect();
    let air: Vec<String> = figures.iter().map(|(_, value)| wgsl(*value as f32)).collect();
    let vectors: Vec<String> = (0..VECTORS).map(|i| format!("let v{i} = optics[first + {i}u];")).collect();
    let read: Vec<String> = (0..figures.len()).map(|i| format!("v{}[{}]", i / 4, i % 4)).collect();
    let [fields, air, read] = [fields, air, read].map(|list| list.join(", "));
    let vectors = vectors.join(" ");
    format!(
        "struct Medium {{ {fields} }}\nconst AIR = Medium({air});\n\
         fn medium_at(first: u32) -> Medium {{ {vectors} return Medium({read}); }}\n"
    )
}

/// The medium as the kernel reads it; what is left of the last vector is 0.
pub(super) fn packed(medium: &Medium) -> [[f32; 4]; VECTORS] {
    let mut vectors = [[0.0; 4]; VECTORS];
    for (slot, (_, value)) in vectors.as_flattened_mut().iter_mut().zip(medium.figures()) {
        *slot = value as f32;
    }
    vectors
}
