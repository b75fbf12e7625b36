//! Surface events in double precision, lane by lane: evanescent waves, grazing incidence, metals, and crystals in contact.

use accel::lanes::{Row, WIDTH};
use spectral_core::{
    crystal::{self as core, Form, Incidence, Scattered, Wave, from_mode, into_mode, reflected},
    stokes::{StokesRow, align},
};

/// What is beyond a surface.
#[derive(Clone, Copy)]
pub(super) enum Beyond<'a> {
    /// An isotropic medium or a metal, n and k.
    Isotropic([f64; 2]),
    Crystal(&'a core::Crystal),
}

/// What lanes send on: the twin of [`Scattered`](super::Scattered).
#[derive(Default)]
pub(super) struct Sent {
    /// Of two modes on this side and two beyond: N, the ray and the weight.
    pub beams: [[Row; Self::BEAM]; 4],
    pub row: [Row; 4],
    pub axis: [Row; 3],
    pub direction: [Row; 3],
}

/// Puts a vector into a lane.
fn put(rows: &mut [Row], lane: usize, vector: impl IntoIterator<Item = f64>) {
    for (row, coordinate) in rows.iter_mut().zip(vector) {
        row.0[lane] = coordinate as f32;
    }
}

impl Sent {
    /// Numbers of a mode.
    pub const BEAM: usize = 7;

    /// Modes of the crystal that the light is in (`first` 0) or of that beyond (2).
    fn beams(
        &mut self,
        lane: usize,
        first: usize,
        crystal: &core::Crystal,
        waves: &[Wave; 2],
        weights: [f64; 2],
    ) {
        let turned = !in_order(crystal, waves);
        for (j, wave) in waves.iter().enumerate().filter(|(_, wave)| wave.propagates()) {
            let place = first + if turned { 1 - j } else { j };
            let numbers = wave.wave_vector().into_iter().chain(wave.ray()).chain([weights[j]]);
            put(&mut self.beams[place], lane, numbers);
        }
    }

    fn outside(&mut self, lane: usize, row: StokesRow<f64>, axis: [f64; 3], direction: [f64; 3]) {
        put(&mut self.row, lane, row.0);
        put(&mut self.axis, lane, axis);
        put(&mut self.direction, lane, direction);
    }
}

/// Whether the waves are in the order of the modes. A biaxial crystal's are not always: where one is evanescent, and where the
/// larger index has both.
fn in_order(crystal: &core::Crystal, waves: &[Wave; 2]) -> bool {
    let faster = |wave: &Wave| {
        let index = wave.index();
        let [fast, slow] = crystal.indices_along(wave.wave_vector().map(|x| x / index));
        (fast - index).abs() <= (slow - index).abs()
    };
    match (crystal.form(), waves.each_ref().map(Wave::propagates)) {
        (Form::Uniaxial(_), _) | (_, [false, false]) => true,
        (Form::Biaxial(_), [true, _]) => faster(&waves[0]),
        (Form::Biaxial(_), [false, true]) => !faster(&waves[1]),
    }
}

/// Vectors of single lanes.
fn lane(rows: &[Row; 3], lane: usize) -> [f64; 3] {
    [0, 1, 2].map(|i| f64::from(rows[i].0[lane]))
}

fn normalized(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / length)
}

fn each(lanes: u16) -> impl Iterator<Item = usize> {
    (0..WIDTH).filter(move |lane| lanes >> lane & 1 == 1)
}

/// What some lanes send on of a mode, given by N and its weight.
#[inline(never)]
pub(super) fn left<'a>(
    lanes: u16,
    exact: impl Fn(usize) -> &'a core::Crystal,
    (vectors, weights): (&[Row; 3], &Row),
    normals: &[Row; 3],
    beyond: impl Fn(usize) -> Beyond<'a>,
) -> Sent {
    let mut sent = Sent::default();
    for i in each(lanes) {
        let (vector, weight) = (lane(vectors, i), f64::from(weights.0[i]));
        let (crystal, n) = (exact(i), normalized(lane(normals, i)));
        let at = Incidence::new(vector, n);
        let Some(incident) = crystal.incident(vector, &at) else { continue };
        let back = crystal.reflections(&incident, &at);
        let reflected = |out: &Scattered| out.back.map(|a| weight * a.norm_sqr());
        match beyond(i) {
            Beyond::Crystal(other) => {
                let on = other.waves(at.q(), n, 1.0);
                let out = at.between(&incident, &back, &on);
                sent.beams(i, 0, crystal, &back, reflected(&out));
                sent.beams(i, 2, other, &on, out.on.map(|a| weight * a.norm_sqr()));
            }
            Beyond::Isotropic([index, k]) => {
                let out = at.leave(&incident, &back, [index, k]);
                sent.beams(i, 0, crystal, &back, reflected(&out));
                let cos2 = index * index - at.tangential * at.tangential;
                if k == 0.0 && cos2 > 0.0 {
                    let along = |k: usize| (at.u[k] * at.tangential + n[k] * cos2.sqrt()) / index;
                    sent.outside(i, from_mode(weight, out.on), at.s, [0, 1, 2].map(along));
                }
            }
        }
    }
    sent
}

/// What some lanes send on of a row; `here` are the indices of the medium that it is in.
#[inline(never)]
pub(super) fn entered<'a>(
    lanes: u16,
    exact: impl Fn(usize) -> &'a core::Crystal,
    (row, axis): (&[Row; 4], &[Row; 3]),
    [directions, normals]: [&[Row; 3]; 2],
    here: &Row,
) -> Sent {
    let mut sent = Sent::default();
    for i in each(lanes) {
        let row = StokesRow([0, 1, 2, 3].map(|k| f64::from(row[k].0[i])));
        let [direction, n] = [directions, normals].map(|rows| normalized(lane(rows, i)));
        let (crystal, here) = (exact(i), f64::from(here.0[i]));
        let turned = align(direction, lane(axis, i), n);
        let row = row.rotated(turned.cos2, turned.sin2);
        let at = Incidence::aligned(direction.map(|x| x * here), n, turned.axis);
        let on = crystal.waves(at.q(), n, 1.0);
        let [s, p] = at.enter(here, &on);
        let cosine: f64 = (0..3).map(|k| direction[k] * n[k]).sum();
        let mirrored = [0, 1, 2].map(|k| direction[k] - 2.0 * cosine * n[k]);
        sent.outside(i, reflected(row, [s.back, p.back]), at.s, mirrored);
        sent.beams(i, 2, crystal, &on, [0, 1].map(|j| into_mode(row, [s.on[j], p.on[j]])));
    }
    sent
}
