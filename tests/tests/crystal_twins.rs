//! The kernel's crystals against `spectral_core::crystal` in double precision, on every GPU of this machine.

use accel::testing::Random;
use bytemuck::cast_slice;
use gemtrace_tests::gpu::{Row, entry, gpus, map, row};
use glam::{DMat3, DQuat, DVec3};
use spectral_core::{
    crystal::{Crystal, Incidence, Wave, from_mode, into_mode, reflected},
    kernel::{CRYSTAL, FRESNEL, Form, LINE, SCENE, STOKES, medium},
    stokes::StokesRow,
};

const FORM: Form = Form { polarized: true, contacts: true, crystals: true, stack: 16 };

/// Weak and strong ones of each kind: indices along the axes.
const INDICES: [[f64; 3]; 8] = [
    [1.768, 1.768, 1.760],
    [1.925, 1.925, 1.984],
    [1.658, 1.658, 1.486],
    [1.3, 2.2, 1.3],
    [1.610, 1.613, 1.620],
    [1.654, 1.671, 1.689],
    [2.0, 2.1, 2.3],
    [1.9, 1.5, 2.4],
];
const ABSORPTIONS: [f64; 3] = [0.2, 1.0, 0.5];

fn random_unit(random: &mut Random) -> DVec3 {
    random.direction().as_dvec3().normalize()
}

/// Rounded to what the kernel is given.
fn rounded(v: [f64; 3]) -> [f64; 3] {
    v.map(|x| f64::from(x as f32))
}

fn crystals(random: &mut Random) -> Vec<Crystal> {
    let turned = |indices: [f64; 3], random: &mut Random| {
        let turn = DQuat::from_axis_angle(random_unit(random), 6.0 * f64::from(random.unit()));
        Crystal::new(indices, DMat3::from_quat(turn).to_cols_array_2d())
    };
    INDICES.iter().map(|indices| turned(*indices, random)).collect()
}

fn library() -> String {
    let parts = [SCENE, LINE, FRESNEL, STOKES, &medium::crystal_declarations(), CRYSTAL];
    FORM.constants() + &parts.join("\n")
}

/// A body over inputs, with the crystals where the optics are: `crystal_at(VECTORS * number)`.
fn run(crystals: &[Crystal], body: &str, inputs: &[Row]) -> Vec<Vec<Row>> {
    let packed: Vec<Vec<[f32; 4]>> =
        crystals.iter().map(|c| medium::packed_crystal(Some(&(*c, ABSORPTIONS)))).collect();
    let library = format!("{}\nconst VECTORS: u32 = {}u;", library(), packed[0].len());
    let on = |gpu: &backend_wgpu::Gpu| {
        let buffer = gpu.filled("the crystals", cast_slice(&packed.concat())).expect("memory");
        map(gpu, &library, body, &[entry(2, buffer.as_entire_binding())], inputs)
    };
    gpus().iter().map(on).collect()
}

/// An incident mode at a surface.
struct Case {
    kind: usize,
    wave: Wave,
    normal: [f64; 3],
    /// Beyond the surface.
    other: usize,
    index: [f64; 2],
}

/// Modes of every crystal at random surfaces that they do not graze.
fn cases(crystals: &[Crystal], count: usize, random: &mut Random) -> Vec<Case> {
    let mut cases = Vec::new();
    while cases.len() < count {
        let kind = random.below(crystals.len());
        let direction = random_unit(random);
        let found = crystals[kind].waves([0.0; 3], direction.to_array(), 1.0)[random.below(2)];
        let normal = rounded(random_unit(random).as_vec3().normalize().as_dvec3().to_array());
        let (n, e) = (rounded(found.wave_vector()), rounded(found.electric.map(|x| x.re)));
        let h = DVec3::from(n).cross(e.into()).to_array();
        let [wave_vector, electric, magnetic] = [n, e, h].map(|v| v.map(Into::into));
        let wave = Wave { normal: wave_vector, electric, magnetic, flux: 1.0 }.at(normal);
        let size = DVec3::from(e).cross(h.into()).length();
        let metal = random.below(8) == 0;
        let index = if metal { [0.25, 3.1] } else { [[1.0, 1.33, 1.5, 1.9][random.below(4)], 0.0] };
        if wave.flux > 0.03 * size {
            cases.push(Case { kind, wave, normal, other: random.below(crystals.len()), index });
        }
    }
    cases
}

fn inputs(cases: &[Case]) -> Vec<Row> {
    let input = |case: &Case| {
        let numbers = [case.wave.wave_vector(), case.wave.electric.map(|x| x.re), case.normal].concat();
        let rest = [case.kind as f64, case.other as f64, case.index[0], case.index[1]];
        row(&numbers.iter().chain(&rest).map(|&x| x as f32).collect::<Vec<_>>())
    };
    cases.iter().map(input).collect()
}

const INCIDENT: &str = "
    let normal = vec3(in[6], in[7], in[8]);
    let at = incidence_of(vec3(in[0], in[1], in[2]), normal);
    let incident = wave_by_field(at, vec3(in[0], in[1], in[2]), vec3(in[3], in[4], in[5]));
    let crystal = crystal_at(VECTORS * u32(in[9]));
    let back = crystal_waves(crystal, at, -1.0);";

/// Median, 99th percentile and largest of the errors, each the largest of a row's.
fn spread(found: &[Row], expected: &[Row], columns: std::ops::Range<usize>) -> [f32; 3] {
    let error = |(f, e): (&Row, &Row)| {
        let worst = columns.clone().map(|i| (f[i] - e[i]).abs());
        worst.fold(0.0, |a, b| if b.is_nan() { f32::INFINITY } else { f32::max(a, b) })
    };
    let mut errors: Vec<f32> = found.iter().zip(expected).map(error).collect();
    errors.sort_by(f32::total_cmp);
    [errors[errors.len() / 2], errors[errors.len() * 99 / 100], errors[errors.len() - 1]]
}

fn check(what: &str, kind: usize, found: [f32; 3], most: [f32; 2]) {
    println!(
        "{what}, {:?}: median {:.1e}, 99 % {:.1e}, largest {:.1e}",
        INDICES[kind], found[0], found[1], found[2]
    );
    assert!(found[0] <= most[0] && found[1] <= most[1], "{what}, {:?}: {found:?}", INDICES[kind]);
}

/// Checks columns of the outputs for each kind of crystal.
fn check_kinds(cases: &[Case], found: &[Row], expected: &[Row], what: &str, columns: std::ops::Range<usize>) {
    for kind in 0..INDICES.len() {
        let of_kind = |rows: &[Row]| -> Vec<Row> {
            cases.iter().zip(rows).filter(|(case, _)| case.kind == kind).map(|(_, row)| *row).collect()
        };
        let spread = spread(&of_kind(found), &of_kind(expected), columns.clone());
        check(what, kind, spread, [1e-6, 2e-4]);
    }
}

/// The order of two waves is not promised where one is evanescent.
fn heavier_first<T>(shares: &mut [f64; 2], of: &mut [T; 2]) {
    if shares[0] < shares[1] {
        shares.swap(0, 1);
        of.swap(0, 1);
    }
}

#[test]
fn modes_that_leave() {
    let mut random = Random(11);
    let crystals = crystals(&mut random);
    let cases = cases(&crystals, 40_000, &mut random);
    let expected = |case: &Case| {
        let crystal = &crystals[case.kind];
        let at = Incidence::new(case.wave.wave_vector(), case.normal);
        let back = crystal.reflections(&case.wave, &at);
        let out = at.leave(&case.wave, &back, case.index);
        let row4 = from_mode(1.0, out.on).0;
        let mut shares = out.back.map(|a| a.norm_sqr());
        let mut rays = [0, 1].map(|j| if back[j].propagates() { back[j].ray() } else { [0.0; 3] });
        heavier_first(&mut shares, &mut rays);
        let absorption = crystal.absorption(&case.wave, ABSORPTIONS);
        let numbers = [&shares[..], &row4[..], &rays[0][..], &rays[1][..], &[absorption]].concat();
        row(&numbers.iter().map(|&x| x as f32).collect::<Vec<_>>())
    };
    let expected: Vec<Row> = cases.iter().map(expected).collect();
    let body = format!(
        "{INCIDENT}
        let scattered = boundary_leave(at, incident, back, in[11], in[12]);
        let row = weight_from_mode(scattered.on) / incident.flux;
        var waves = back;
        var amplitudes = scattered.back;
        if dot(amplitudes[0], amplitudes[0]) < dot(amplitudes[1], amplitudes[1]) {{
            waves = array(back[1], back[0]);
            amplitudes = array(scattered.back[1], scattered.back[0]);
        }}
        for (var j = 0u; j < 2u; j++) {{
            out[j] = dot(amplitudes[j], amplitudes[j]) / incident.flux;
            if waves[j].flux != 0.0 {{
                let ray = wave_ray(waves[j].normal, waves[j].electric);
                for (var k = 0u; k < 3u; k++) {{ out[6u + 3u * j + k] = ray[k]; }}
            }}
        }}
        for (var k = 0u; k < 4u; k++) {{ out[2u + k] = row[k]; }}
        let direction = wave_ray(incident.normal, incident.electric);
        out[12] = crystal_absorption(crystal, incident.normal, incident.electric, direction);"
    );
    for found in run(&crystals, &body, &inputs(&cases)) {
        check_kinds(&cases, &found, &expected, "absorption", 12..13);
        check_kinds(&cases, &found, &expected, "reflected", 0..2);
        check_kinds(&cases, &found, &expected, "row that leaves", 2..6);
        check_kinds(&cases, &found, &expected, "rays", 6..12);
    }
}

#[test]
fn modes_between_crystals() {
    let mut random = Random(12);
    let crystals = crystals(&mut random);
    let cases = cases(&crystals, 40_000, &mut random);
    let expected = |case: &Case| {
        let at = Incidence::new(case.wave.wave_vector(), case.normal);
        let back = crystals[case.kind].reflections(&case.wave, &at);
        let on = crystals[case.other].waves(at.q(), at.normal, 1.0);
        let out = at.between(&case.wave, &back, &on);
        row(&[out.back, out.on].map(|pair| pair.iter().map(|a| a.norm_sqr() as f32).sum()))
    };
    let expected: Vec<Row> = cases.iter().map(expected).collect();
    let body = format!(
        "{INCIDENT}
        let on = crystal_waves(crystal_at(VECTORS * u32(in[10])), at, 1.0);
        let scattered = boundary_between(incident, back, on);
        out[0] = (dot(scattered.back[0], scattered.back[0]) + dot(scattered.back[1], scattered.back[1])) / incident.flux;
        out[1] = (dot(scattered.on[0], scattered.on[0]) + dot(scattered.on[1], scattered.on[1])) / incident.flux;"
    );
    for found in run(&crystals, &body, &inputs(&cases)) {
        check_kinds(&cases, &found, &expected, "in contact", 0..2);
    }
}

#[test]
fn rows_that_enter() {
    let mut random = Random(13);
    let crystals = crystals(&mut random);
    let mut cases = Vec::new();
    let (mut inputs, mut expected) = (Vec::new(), Vec::new());
    while inputs.len() < 40_000 {
        let kind = random.below(crystals.len());
        let direction = rounded(random_unit(&mut random).to_array());
        let normal = rounded(random_unit(&mut random).to_array());
        let n = f64::from([1.0f32, 1.4, 2.0][random.below(3)]);
        if DVec3::from(direction).dot(normal.into()) < 0.03 {
            continue;
        }
        let part = |random: &mut Random| f64::from(random.unit() - 0.5);
        let row4 =
            [1.0, part(&mut random), part(&mut random), part(&mut random)].map(|x| f64::from(x as f32));
        let at = Incidence::new(direction.map(|x| x * n), normal);
        let on = crystals[kind].waves(at.q(), normal, 1.0);
        let [s, p] = at.enter(n, &on);
        let back = reflected(StokesRow(row4), [s.back, p.back]).0;
        let mut weights = [0, 1].map(|j| into_mode(StokesRow(row4), [s.on[j], p.on[j]]));
        heavier_first(&mut weights, &mut [(); 2]);
        let single = |numbers: &[f64]| row(&numbers.iter().map(|&x| x as f32).collect::<Vec<_>>());
        expected.push(single(&[&back[..], &weights[..]].concat()));
        inputs.push(single(&[&direction[..], &normal, &row4, &[n, kind as f64]].concat()));
        let wave = on[0];
        cases.push(Case { kind, wave, normal, other: kind, index: [n, 0.0] });
    }
    let body = "
        let direction = vec3(in[0], in[1], in[2]);
        let at = incidence_of(direction * in[10], vec3(in[3], in[4], in[5]));
        let row = vec4(in[6], in[7], in[8], in[9]);
        let on = crystal_waves(crystal_at(VECTORS * u32(in[11])), at, 1.0);
        let scattered = boundary_enter(at, in[10], in[10] * dot(direction, at.normal), on);
        let mirrored = weight_reflected(row, scattered[0].back, scattered[1].back);
        for (var k = 0u; k < 4u; k++) { out[k] = mirrored[k]; }
        let first = weight_into_mode(row, array(scattered[0].on[0], scattered[1].on[0]));
        let second = weight_into_mode(row, array(scattered[0].on[1], scattered[1].on[1]));
        out[4] = max(first, second);
        out[5] = min(first, second);";
    for found in run(&crystals, body, &inputs) {
        check_kinds(&cases, &found, &expected, "row that is reflected", 0..4);
        check_kinds(&cases, &found, &expected, "modes that enter", 4..6);
    }
}
