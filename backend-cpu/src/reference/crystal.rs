//! Surface events with a crystal on one side or both: up to four rays.

use super::{Light, Ray, Walk, surface::Crossing};
use glam::DVec3;
use spectral_core::{
    crystal::{Crystal, Incidence, Wave, from_mode, into_mode, reflected},
    lattice::choice,
    prepare::Medium,
    stokes::{StokesRow, align},
};

/// A mode of a crystal that a ray follows.
#[derive(Clone, Copy)]
pub(super) struct Mode {
    /// The throughput.
    pub weight: f64,
    pub wave: Wave,
}

impl Mode {
    /// Both modes of a crystal with the wave vector along a direction, of an eye that stands in it. Their rays differ from it.
    pub fn of_eye(crystal: &Crystal, direction: DVec3) -> [Self; 2] {
        let waves = crystal.waves([0.0; 3], direction.to_array(), 1.0);
        waves.map(|wave| Mode { weight: 0.5, wave })
    }

    pub fn direction(&self) -> DVec3 {
        self.wave.ray().into()
    }
}

impl Walk<'_> {
    /// Lists the rays that an event at a crystal sends on, from the ray's end.
    pub(super) fn send_on_at_crystal(
        &mut self,
        ray: &Ray,
        crossing: &Crossing,
        here: Medium,
        beyond: Medium,
    ) {
        let next =
            Ray { origin: ray.origin + ray.direction * crossing.distance, depth: ray.depth + 1, ..*ray };
        // The core's normal points along the light's way.
        let normal = -crossing.normal;
        match (&ray.light, &here.crystal, &beyond.crystal) {
            (Light::Row { row, axis }, _, Some((crystal, _))) => {
                let turned = align(ray.direction.to_array(), *axis, normal.to_array());
                let row = row.rotated(turned.cos2, turned.sin2);
                let wave_vector = (ray.direction * here.n).to_array();
                let at = Incidence::aligned(wave_vector, normal.to_array(), turned.axis);
                let on = crystal.waves(at.q(), at.normal, 1.0);
                let [s, p] = at.enter(here.n, &on);
                let back = self.row(reflected(row, [s.back, p.back]), &at);
                self.go_on(Ray { direction: ray.direction.reflect(normal), light: back, ..next });
                let weights = [0, 1].map(|j| into_mode(row, [s.on[j], p.on[j]]));
                self.go_on_as_modes(Ray { nest: crossing.after, ..next }, weights, &on);
            }
            (Light::Mode(mode), Some((crystal, _)), Some((other, _))) => {
                let (incident, at) = incidence(mode, normal);
                let back = crystal.reflections(&incident, &at);
                let on = other.waves(at.q(), at.normal, 1.0);
                let out = at.between(&incident, &back, &on);
                self.go_on_as_modes(next, out.back.map(|a| mode.weight * a.norm_sqr()), &back);
                let beyond = Ray { nest: crossing.after, ..next };
                self.go_on_as_modes(beyond, out.on.map(|a| mode.weight * a.norm_sqr()), &on);
            }
            (Light::Mode(mode), Some((crystal, _)), None) => {
                let (incident, at) = incidence(mode, normal);
                let back = crystal.reflections(&incident, &at);
                let out = at.leave(&incident, &back, [beyond.n, beyond.k]);
                self.go_on_as_modes(next, out.back.map(|a| mode.weight * a.norm_sqr()), &back);
                let cos2 = beyond.n * beyond.n - at.tangential * at.tangential;
                if !beyond.is_opaque() && cos2 > 0.0 {
                    let along = DVec3::from(at.u) * at.tangential + normal * cos2.sqrt();
                    let light = self.row(from_mode(mode.weight, out.on), &at);
                    self.go_on(Ray { direction: along.normalize(), light, nest: crossing.after, ..next });
                }
            }
            // A row travels outside crystals and a mode within.
            (Light::Row { .. }, _, None) | (Light::Mode(_), None, _) => {}
        }
    }

    /// A row in the plane of incidence; without polarisation only its intensity.
    fn row(&self, row: StokesRow<f64>, at: &Incidence) -> Light {
        let polarized = self.reference.scene.settings.polarized;
        let row = if polarized { row } else { StokesRow::eye().scaled(row.intensity()) };
        Light::Row { row, axis: at.s }
    }

    /// Two modes on one side of a surface. If one is lighter than `split` only one of them is followed, with the weight of
    /// both: each is chosen in proportion to its weight.
    fn go_on_as_modes(&mut self, from: Ray, mut weights: [f64; 2], waves: &[Wave; 2]) {
        let [first, second] = weights;
        if first.min(second) < self.reference.scene.settings.split {
            let taken = usize::from(choice(self.sample, from.depth - 1) * (first + second) >= first);
            weights[taken] = first + second;
            weights[1 - taken] = 0.0;
        }
        for (&weight, &wave) in weights.iter().zip(waves).filter(|(_, wave)| wave.propagates()) {
            let mode = Mode { weight, wave };
            self.go_on(Ray { direction: mode.direction(), light: Light::Mode(mode), ..from });
        }
    }
}

fn incidence(mode: &Mode, normal: DVec3) -> (Wave, Incidence) {
    let normal = normal.to_array();
    (mode.wave.at(normal), Incidence::new(mode.wave.wave_vector(), normal))
}
