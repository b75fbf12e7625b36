//! Each function of the kernel against its Rust counterpart, on many inputs, on every GPU of this machine.

use accel::testing::Random;
use bytemuck::bytes_of;
use gemtrace_tests::gpu::{Row, entry, gpus, map, row};
use glam::{DVec3, Vec3};
use spectral_core::{
    environment::{Environment, LatLong, Source},
    fresnel::{Fresnel, conductor, dielectric},
    kernel::{FRESNEL, Form, LIGHT, LINE, NEST, SCENE, STOKES, block::Scene},
    prepare::Nest,
    stokes::{StokesRow, align, any_axis},
    upsample::smits::Weights,
};

const FORM: Form = Form { polarized: true, contacts: true, crystals: false, stack: 16 };

fn library(parts: &[&str]) -> String {
    FORM.constants() + &parts.join("\n")
}

/// The largest difference between two lists of numbers.
fn worst(found: &[Row], expected: &[Row]) -> f32 {
    assert_eq!(found.len(), expected.len());
    let pairs = found.iter().flatten().zip(expected.iter().flatten());
    pairs
        .map(|(f, e)| (f - e).abs())
        .fold(0.0, |worst, d| if d.is_nan() { f32::INFINITY } else { worst.max(d) })
}

const EVENT: &str = "out[0] = e.reflectance_s; out[1] = e.reflectance_p; out[2] = e.transmittance_s;
    out[3] = e.transmittance_p; out[4] = e.reflected_cross.x; out[5] = e.reflected_cross.y;
    out[6] = e.refracted_cross; out[7] = e.cos_t; out[8] = f32(e.tir);";

fn event(e: &Fresnel<f32>) -> Row {
    let [re, im] = e.reflected_cross;
    row(&[
        e.reflectance_s,
        e.reflectance_p,
        e.transmittance_s,
        e.transmittance_p,
        re,
        im,
        e.refracted_cross,
        e.cos_t,
        f32::from(u8::from(e.tir)),
    ])
}

/// Ratios of the refractive indices before and behind the surface: into and out of every gem, and between two gems.
const RATIOS: [f32; 10] = [1.0 / 2.65, 1.0 / 2.417, 1.0 / 1.5168, 0.9, 0.999, 1.0, 1.001, 1.3, 1.5168, 2.417];

#[test]
fn dielectrics() {
    let mut inputs = Vec::new();
    for eta in RATIOS {
        inputs.extend((0..=4000).map(|i| row(&[i as f32 / 4000.0, eta])));
        if eta > 1.0 {
            // On both sides of the critical angle, down to single steps of the cosine.
            let critical = (1.0 - 1.0 / (eta * eta)).sqrt();
            for scale in [1.0, 1e-2, 1e-4, 3e-6] {
                let beside = |i: i32| row(&[critical * (1.0 + scale * i as f32 / 2000.0), eta]);
                inputs.extend((-1000..1000).map(beside).filter(|r| r[0] <= 1.0));
            }
        }
    }
    // The Rust function computes cos²θ₂ in double precision. The kernel is as good if its result is that of the Rust
    // function for a cosine at most one step away, except for the rounding of the result itself.
    let twins = |i: &Row| {
        let c = i[0];
        [c.next_down().max(0.0), c, c.next_up().min(1.0)].map(|c| event(&dielectric(c, i[1])))
    };
    let expected: Vec<[Row; 3]> = inputs.iter().map(twins).collect();
    for gpu in gpus() {
        // In comparison the plain formula, to show the benefit of pairs of single-precision numbers.
        let plain = "out[9] = sqrt(max(1.0 - in[1] * in[1] * (1.0 - in[0] * in[0]), 0.0));";
        let body = format!("let e = dielectric(in[0], in[1]); {EVENT} {plain}");
        let found = map(&gpu, &library(&[FRESNEL]), &body, &[], &inputs);
        let beyond = |f: f32, twins: [f32; 3]| {
            let (low, high) = (twins.into_iter().fold(f, f32::min), twins.into_iter().fold(f, f32::max));
            let [low_twin, high_twin] =
                [f32::min, f32::max].map(|pick| twins.into_iter().fold(twins[0], pick));
            (low_twin - low).max(high - high_twin)
        };
        let worst: Vec<f32> = (0..9)
            .map(|at| {
                let pairs = found.iter().zip(&expected);
                pairs.map(|(f, e)| beyond(f[at], e.map(|twin| twin[at]))).fold(0.0, f32::max)
            })
            .collect();
        let cosine = |at: usize| {
            let refracted = found.iter().zip(&expected).filter(|(_, e)| e[1][8] == 0.0);
            refracted.map(|(f, e)| (f[at] - e[1][7]).abs()).fold(0.0, f32::max)
        };
        println!("dielectric, beyond a step of the cosine, by field: {worst:?}");
        println!("cos θ₂ off by at most {:e}, plain {:e}", cosine(7), cosine(9));
        assert!(worst.iter().all(|w| *w <= 6e-7), "{worst:?}");
        assert!(cosine(7) <= 5e-7 && cosine(9) > 1e-4);
    }
}

#[test]
fn conductors() {
    let mut inputs = Vec::new();
    for (n, k) in [(0.29, 2.863), (0.05, 4.2), (1.5, 7.6), (2.0, 2.0), (3.0, 0.01), (1.0, 1e-4)] {
        for n1 in [1.0, 1.33, 2.417] {
            inputs.extend((0..=1000).map(|i| row(&[i as f32 / 1000.0, n1, n, k])));
        }
    }
    let expected: Vec<Row> = inputs.iter().map(|i| event(&conductor(i[0], i[1], i[2], i[3]))).collect();
    for gpu in gpus() {
        let body = format!("let e = conductor(in[0], in[1], in[2], in[3]); {EVENT}");
        let found = map(&gpu, &library(&[FRESNEL]), &body, &[], &inputs);
        let (weak, metals): (Vec<_>, Vec<_>) =
            found.iter().zip(&expected).zip(&inputs).partition(|(_, input)| input[3] < 1e-3);
        let [weak, metals] = [weak, metals]
            .map(|list| list.iter().map(|((f, e), _)| worst(&[**f], &[**e])).fold(0.0, f32::max));
        println!("conductor, largest difference: {metals:e}, weak absorber {weak:e}");
        assert!(metals <= 1e-6, "{metals}");
        // Not a metal: seen from diamond it has a critical angle, where double precision is more accurate.
        assert!(weak <= 3e-5, "{weak}");
    }
}

#[test]
fn stokes_rows() {
    let mut random = Random(7);
    let unit = |v: Vec3| v.normalize();
    let inputs: Vec<Row> = (0..20_000)
        .map(|_| {
            let direction = unit(random.direction());
            // Half of them within a hundredth of normal incidence.
            let spread = if random.unit() < 0.5 { 0.01 } else { 1.0 };
            let normal = unit(-direction + random.direction() * spread);
            let [d, n] = [direction.to_array(), normal.to_array()];
            let row4 = [1.0, random.unit() - 0.5, random.unit() - 0.5, random.unit() - 0.5];
            let eta = 0.4 + 2.0 * random.unit();
            row(&[&d[..], &n[..], &row4[..], &[eta]].concat())
        })
        .collect();
    let three = |r: &Row, at: usize| [r[at], r[at + 1], r[at + 2]];
    let expected: Vec<Row> = inputs
        .iter()
        .map(|i| {
            let (direction, normal) = (three(i, 0), three(i, 3));
            let axis = any_axis(direction);
            let frame = align(direction, axis, normal);
            let cos_i = -(direction[0] * normal[0] + direction[1] * normal[1] + direction[2] * normal[2]);
            let event = dielectric(cos_i, i[10]);
            let turned = StokesRow([i[6], i[7], i[8], i[9]]).rotated(frame.cos2, frame.sin2);
            let (back, on) = (turned.reflected(&event), turned.refracted(&event));
            row(&[&axis[..], &frame.axis[..], &[frame.cos2, frame.sin2], &back.0[..], &on.0[..]].concat())
        })
        .collect();
    let body = "
        let direction = vec3(in[0], in[1], in[2]);
        let normal = vec3(in[3], in[4], in[5]);
        let axis = any_axis(direction);
        let frame = aligned(direction, axis, normal);
        let event = dielectric(-dot(direction, normal), in[10]);
        let turned = row_rotated(vec4(in[6], in[7], in[8], in[9]), frame.cos2, frame.sin2);
        let back = row_reflected(turned, event);
        let on = row_refracted(turned, event);
        for (var i = 0; i < 3; i++) { out[i] = axis[i]; out[3 + i] = frame.axis[i]; }
        out[6] = frame.cos2;
        out[7] = frame.sin2;
        for (var i = 0; i < 4; i++) { out[8 + i] = back[i]; out[12 + i] = on[i]; }";
    for gpu in gpus() {
        let found = map(&gpu, &library(&[FRESNEL, STOKES]), body, &[], &inputs);
        let mut errors: Vec<f32> = found.iter().zip(&expected).map(|(f, e)| worst(&[*f], &[*e])).collect();
        errors.sort_by(f32::total_cmp);
        let (median, last) = (errors[errors.len() / 2], errors[errors.len() - 1]);
        println!("Stokes rows: median {median:e}, largest {last:e}");
        // Near normal incidence and the critical angle the last digit of a dot product is magnified.
        assert!(median <= 1e-6 && errors[errors.len() * 99 / 100] <= 1e-4, "{median} {last}");
    }
}

#[test]
fn nests() {
    let mut random = Random(3);
    let (mut inputs, mut expected) = (Vec::new(), Vec::new());
    for walk in 0..200 {
        let mut nest = Nest::default();
        for _ in 0..50 {
            let rank = random.below(if walk % 2 == 0 { 9 } else { Nest::MOST_STONES }) as u32;
            let after = nest.toggled(rank);
            let half = |word: u32| [(word & 0xffff) as f32, (word >> 16) as f32];
            let halves = |nest: Nest| nest.marks().map(half).concat();
            inputs.push(row(&[&halves(nest)[..], &[rank as f32]].concat()));
            let flags = [nest.contains(rank), nest.is_empty()].map(|flag| f32::from(u8::from(flag)));
            let top = nest.top().map_or(0, |rank| rank + 1) as f32;
            expected.push(row(&[&halves(after)[..], &flags[..], &[top]].concat()));
            nest = after;
        }
    }
    let body = "
        var nest = Nest(0u);
        for (var i = 0u; i < 3u; i++) { nest[i] = u32(in[2u * i]) | (u32(in[2u * i + 1u]) << 16u); }
        let rank = u32(in[6]);
        let after = nest_toggled(nest, rank);
        for (var i = 0u; i < 3u; i++) {
            out[2u * i] = f32(after[i] & 0xffffu);
            out[2u * i + 1u] = f32(after[i] >> 16u);
        }
        out[6] = f32(nest_contains(nest, rank));
        out[7] = f32(nest_is_empty(nest));
        out[8] = f32(nest_top(nest));";
    for gpu in gpus() {
        assert_eq!(map(&gpu, &library(&[NEST]), body, &[], &inputs), expected);
    }
}

#[test]
fn expansion_of_colours() {
    let bases = [1.0, 0.9, 0.8, 0.7, 0.3, 0.2, 0.1].map(|b: f32| b * 1.25);
    let steps = [0.0, 0.2, 0.5, 0.5, 1.0, 7.0];
    let mut inputs = Vec::new();
    for r in steps {
        for g in steps {
            inputs.extend(steps.map(|b| row(&[&[r, g, b][..], &bases[..]].concat())));
        }
    }
    let mixed = |i: &Row| {
        let rgb = [i[0], i[1], i[2]].map(f64::from);
        row(&[Weights::new(rgb).mix(&bases.map(f64::from)) as f32])
    };
    let expected: Vec<Row> = inputs.iter().map(mixed).collect();
    let body = "
        let basis = Basis(vec4(in[3], in[4], in[5], in[6]), vec3(in[7], in[8], in[9]));
        out[0] = basis_expand(basis, vec3(in[0], in[1], in[2]));";
    for gpu in gpus() {
        let worst = worst(&map(&gpu, &library(&[SCENE, LINE]), body, &[], &inputs), &expected);
        assert!(worst <= 2e-6, "{worst}");
    }
}

#[test]
fn look_ups_of_light() {
    let image = LatLong::studio();
    let mut environment = Environment::image(image);
    environment.rotation = 33.0;
    let Source::Image(image) = &environment.source else { unreachable!("an image") };
    let mut directions: Vec<DVec3> = (0..20_000)
        .map(|k| {
            let z = 1.0 - 2.0 * f64::from(k) / 19_999.0;
            let (sin, cos) = (2.399_963 * f64::from(k)).sin_cos();
            let r = (1.0 - z * z).max(0.0).sqrt();
            DVec3::new(r * cos, r * sin, z)
        })
        .collect();
    directions.extend([DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z]);
    let inputs: Vec<Row> = directions.iter().map(|d| row(&d.as_vec3().to_array())).collect();
    let block = Scene { turn: 33.0 / 360.0, image: 1, gain: 1.0, sky: image.sky(), ..Scene::default() };
    let body = "
        let rgb = light_rgb(vec3(0.0), vec3(in[0], in[1], in[2]));
        out[0] = rgb.x; out[1] = rgb.y; out[2] = rgb.z;";
    for gpu in gpus() {
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let scene = gpu.buffer("scene", size_of::<Scene>() as u64, usage).expect("memory");
        gpu.queue.write_buffer(&scene, 0, bytes_of(&block));
        let light = backend_wgpu::upload(&gpu, &environment.source).expect("memory");
        let entries =
            [entry(0, scene.as_entire_binding()), entry(1, wgpu::BindingResource::TextureView(&light.view))];
        let found = map(&gpu, &library(&[SCENE, LIGHT]), body, &entries, &inputs);
        let mut errors = Vec::new();
        for (found, input) in found.iter().zip(&inputs) {
            let direction = DVec3::new(f64::from(input[0]), f64::from(input[1]), f64::from(input[2]));
            let exact = environment.rgb(direction.normalize());
            errors.extend((0..3).map(|c| (f64::from(found[c]) - exact[c]).abs() / exact[c].max(0.1)));
        }
        errors.sort_by(f64::total_cmp);
        let (median, last) = (errors[errors.len() / 2], errors[errors.len() - 1]);
        println!("light, {} × {}: median {median:e}, largest {last:e}", image.width(), image.height());
        assert!(median <= 1e-6 && last <= 2e-3, "{median} {last}");
    }
}
