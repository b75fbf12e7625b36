//! The kernel's form of a [`Medium`], made from its figures.

use super::wgsl;
use crate::{
    crystal::{Biaxial, Crystal, Form, Uniaxial},
    prepare::Medium,
};

/// A member of a structure, a number or a vector, with its values.
type Figure = (&'static str, Vec<f64>);

/// Vectors of four numbers that a medium takes in the optics; in scenes with crystals, those of its crystal follow.
pub(super) fn vectors(crystals: bool) -> usize {
    VECTORS + if crystals { crystal_vectors() } else { 0 }
}

/// Vectors of a medium's own figures.
pub(super) const VECTORS: usize = Medium::FIGURES.div_ceil(4);

fn crystal_vectors() -> usize {
    let numbers: usize = crystal_figures(None).iter().map(|(_, values)| values.len()).sum();
    numbers.div_ceil(4)
}

fn medium_figures(medium: &Medium) -> Vec<Figure> {
    medium.figures().map(|(name, value)| (name, vec![value])).into()
}

/// What the kernel's `Crystal` stands for. No crystal is of kind 0.
const UNIAXIAL: f64 = 1.0;
const BIAXIAL: f64 = 2.0;

/// A crystal as `crystal/*.wgsl` takes it: its axes, which in a biaxial crystal stand in the order of their indices; the
/// optic axes; ε of the ordinary wave or ε_y; Δ or ε_z − ε_y; ε_x − ε_y; and A and B of the index surface.
fn crystal_figures(crystal: Option<&(Crystal, [f64; 3])>) -> Vec<Figure> {
    let (mut order, mut kind, mut optic, mut scalars) = ([0, 1, 2], 0.0, [[0.0; 3]; 2], [0.0; 5]);
    let (mut axes, mut index, mut absorption) = ([[0.0; 3]; 3], [0.0; 3], [0.0; 3]);
    if let Some((crystal, coefficients)) = crystal {
        let indices = crystal.indices();
        match *crystal.form() {
            Form::Uniaxial(Uniaxial { ordinary, difference, axis }) => {
                (kind, optic) = (UNIAXIAL, [axis; 2]);
                scalars = [ordinary, difference, 0.0, 0.0, 0.0];
            }
            Form::Biaxial(Biaxial { optic: both, sheet: [mean, half], middle, .. }) => {
                order.sort_by(|&a, &b| indices[a].total_cmp(&indices[b]));
                let [low, mid, high] = order.map(|k| indices[k]);
                let difference = |a: f64, b: f64| (a - b) * (a + b);
                (kind, optic) = (BIAXIAL, both);
                scalars = [middle, difference(high, mid), difference(low, mid), mean, half];
            }
        }
        (axes, index) = (order.map(|k| crystal.axes()[k]), order.map(|k| indices[k]));
        absorption = order.map(|k| coefficients[k]);
    }
    let [middle, difference, lower, mean, half] = scalars.map(|value| vec![value]);
    let ([x, y, z], [first, second]) = (axes.map(Vec::from), optic.map(Vec::from));
    let (index, absorption) = (index.into(), absorption.into());
    vec![
        ("x", x),
        ("y", y),
        ("z", z),
        ("first", first),
        ("second", second),
        ("index", index),
        ("absorption", absorption),
        ("kind", vec![kind]),
        ("middle", middle),
        ("difference", difference),
        ("lower", lower),
        ("mean", mean),
        ("half", half),
    ]
}

/// A structure, and the function that reads it from a place in `optics`.
fn structure(name: &str, function: &str, figures: &[Figure]) -> String {
    let kind = |values: &[f64]| {
        if values.len() == 1 { "f32".to_owned() } else { format!("vec{}<f32>", values.len()) }
    };
    let fields: Vec<String> =
        figures.iter().map(|(name, values)| format!("{name}: {}", kind(values))).collect();
    let mut numbers = (0..).map(|i| format!("v{}[{}]", i / 4, i % 4));
    let mut read = Vec::new();
    for (_, values) in figures {
        let parts: Vec<String> = numbers.by_ref().take(values.len()).collect();
        let whole = parts.join(", ");
        read.push(if parts.len() == 1 { whole } else { format!("{}({whole})", kind(values)) });
    }
    let count = figures.iter().map(|(_, values)| values.len()).sum::<usize>().div_ceil(4);
    let vectors: Vec<String> = (0..count).map(|i| format!("let v{i} = optics[first + {i}u];")).collect();
    let [fields, read] = [fields, read].map(|list| list.join(", "));
    let vectors = vectors.join(" ");
    format!(
        "struct {name} {{ {fields} }}\n\
         fn {function}(first: u32) -> {name} {{ {vectors} return {name}({read}); }}\n"
    )
}

/// The structure `Medium`, the constant `AIR`, and `medium_at`, which reads a medium from a place in `optics`.
pub(super) fn declarations() -> String {
    let air: Vec<String> = Medium::AIR.figures().iter().map(|(_, value)| wgsl(*value as f32)).collect();
    let air = format!("const AIR = Medium({});\n", air.join(", "));
    structure("Medium", "medium_at", &medium_figures(&Medium::AIR)) + &air
}

/// The structure `Crystal`, and `crystal_at`, which reads a crystal from a place in `optics`.
pub fn crystal_declarations() -> String {
    format!(
        "const BIAXIAL: f32 = {};\nconst CRYSTAL_OFFSET: u32 = {VECTORS}u;\n{}",
        wgsl(BIAXIAL as f32),
        structure("Crystal", "crystal_at", &crystal_figures(None))
    )
}

/// Numbers in vectors of four; what is left of the last one is 0.
fn in_vectors(figures: &[Figure]) -> Vec<[f32; 4]> {
    let numbers: Vec<f32> =
        figures.iter().flat_map(|(_, values)| values).map(|&value| value as f32).collect();
    numbers.chunks(4).map(|four| std::array::from_fn(|i| four.get(i).copied().unwrap_or(0.0))).collect()
}

/// A crystal with its absorption coefficients as `crystal_at` reads it.
pub fn packed_crystal(crystal: Option<&(Crystal, [f64; 3])>) -> Vec<[f32; 4]> {
    in_vectors(&crystal_figures(crystal))
}

/// The medium as the kernel reads it.
pub(super) fn packed(medium: &Medium, crystals: bool) -> Vec<[f32; 4]> {
    let mut vectors = in_vectors(&medium_figures(medium));
    if crystals {
        vectors.extend(packed_crystal(medium.crystal.as_ref()));
    }
    vectors
}
