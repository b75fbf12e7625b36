//! Beams of the modes of a crystal.

use super::{Beam, Carried, Follower};
use crate::reference::{Light, crystal::Mode};
use glam::DVec3;
use spectral_core::{
    beam::{Pencil, Piece, Polygon, Vectors},
    crystal::{Crystal, Form, Incidence, Wave, from_mode, into_mode, reflected},
    lattice::{CHOICES, MULTIPLIER, chosen, order},
    stokes::{StokesRow, align, any_axis},
};

/// Where the modes begin that an event at a surface sends on.
struct Start<'a> {
    /// The rays there, and their wave vectors on this side.
    pencil: &'a Pencil,
    vectors: &'a Vectors,
    /// Along the way of the incident light.
    normal: DVec3,
    polygon: &'a Polygon,
    depth: u32,
    choice: u32,
}

impl Follower<'_, '_> {
    fn crystal(&self) -> Option<(Crystal, [f64; 3])> {
        self.medium.crystal
    }

    /// Lists what a piece of a pixel sends into a crystal, whose surface has this normal into it; returns the radiance that it
    /// mirrors.
    pub(super) fn enter_crystal(&mut self, piece: &Piece, normal: DVec3) -> f64 {
        let Some((crystal, _)) = self.crystal() else { return 0.0 };
        let Pencil { origin, direction, .. } = piece.pencil;
        let along = direction.to_array();
        let turned = align(along, any_axis(along), normal.to_array());
        let row = StokesRow::eye().scaled(piece.area).rotated(turned.cos2, turned.sin2);
        let at = Incidence::aligned(along, normal.to_array(), turned.axis);
        let on = crystal.waves(at.q(), at.normal, 1.0);
        let [s, p] = at.enter(1.0, &on);
        let weights = [0, 1].map(|j| into_mode(row, [s.on[j], p.on[j]]));
        let (pencil, polygon, choice) = (&piece.pencil, &piece.polygon, order(self.walk.sample));
        let from = Start { pencil, vectors: &Vectors::in_air(pencil), normal, polygon, depth: 1, choice };
        self.go_on_as_modes(&from, weights, &on);
        self.walk.rays += 2;
        self.walk.light(origin, direction.reflect(normal)) * reflected(row, [s.back, p.back]).intensity()
    }

    /// Where a beam meets a facet from within: lists what is reflected; returns the radiance of what leaves. `there` are its rays
    /// at the facet.
    pub(super) fn leave_crystal(&mut self, beam: &Beam, there: &Pencil, normal: DVec3, distance: f64) -> f64 {
        let (Carried::Mode { weight, sheet, vectors }, Some((crystal, coefficients))) =
            (beam.carried, self.crystal())
        else {
            return 0.0;
        };
        let at = Incidence::new(vectors.vector.to_array(), normal.to_array());
        let Some(wave) = incident(&crystal, sheet, &vectors, &at) else {
            self.walk.energy.lost += weight;
            return 0.0;
        };
        let weight = weight * (-crystal.absorption(&wave, coefficients) * distance).exp();
        if self.is_last(beam) {
            return self.at_limit(beam, Light::Mode(Mode { weight, wave }), -normal, distance);
        }
        let back = crystal.reflections(&wave, &at);
        let out = at.leave(&wave, &back, [1.0, 0.0]);
        let weights = out.back.map(|a| weight * a.norm_sqr());
        let (polygon, depth) = (&beam.polygon, beam.depth + 1);
        let from = Start { pencil: there, vectors: &vectors, normal, polygon, depth, choice: beam.choice };
        self.go_on_as_modes(&from, weights, &back);
        let cos2 = 1.0 - at.tangential * at.tangential;
        if cos2 <= 0.0 {
            return 0.0;
        }
        self.walk.rays += 1;
        let along = DVec3::from(at.u) * at.tangential + normal * cos2.sqrt();
        self.walk.light(there.origin, along.normalize()) * from_mode(weight, out.on).intensity()
    }

    /// Lists two modes. If one carries less than the limit only one of them is followed, with the weight of both: each is chosen
    /// in proportion to its weight.
    fn go_on_as_modes(&mut self, from: &Start<'_>, mut weights: [f64; 2], waves: &[Wave; 2]) {
        let Some((crystal, _)) = self.crystal() else { return };
        let [first, second] = weights;
        if first.min(second) < self.limits.choice {
            let taken = usize::from(chosen(from.choice, 1) * (first + second) >= first);
            weights[taken] = first + second;
            weights[1 - taken] = 0.0;
        }
        let choice = from.choice * MULTIPLIER % CHOICES;
        let modes = weights.into_iter().zip(waves).enumerate();
        for (place, (weight, wave)) in modes.filter(|(_, (_, wave))| wave.propagates()) {
            let sheet = crystal.sheet(place, wave);
            let vectors = from.vectors.sent(from.normal, wave.wave_vector().into(), wave.ray().into());
            let pencil = from.pencil.of_mode(&crystal, sheet, &vectors);
            let carried = Carried::Mode { weight, sheet, vectors };
            self.go_on(Beam { pencil, polygon: *from.polygon, carried, depth: from.depth, choice });
        }
    }
}

/// The wave of these wave vectors. On a uniaxial crystal's axis both of its waves have the same N.
fn incident(crystal: &Crystal, sheet: usize, vectors: &Vectors, at: &Incidence) -> Option<Wave> {
    match crystal.form() {
        Form::Uniaxial(_) => Some(crystal.waves(at.q(), at.normal, 1.0)[sheet]).filter(Wave::propagates),
        Form::Biaxial(_) => crystal.incident(vectors.vector.to_array(), at),
    }
}
