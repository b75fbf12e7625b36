//! Light models: surroundings that are a formula, by which cutters compare designs.
//!
//! A model gives a radiance from 0 to 1 in every direction about its zenith; a head hides the light behind it.
//! Sources for each are in `docs/light-models.md`. Backends read texels, so a model is drawn as an image, each
//! texel with the mean over its area: see [`LightModel::image`] for what that costs.

mod drawing;
mod pattern;

pub use pattern::Pattern;

use super::LatLong;
use crate::Error;
use glam::DVec3;

/// The viewer's head, which is dark and hides the light behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Head {
    /// From the middle of the head to its edge as seen from the stone, degrees.
    pub half_angle: f64,
    /// Unit direction from the stone to the viewer.
    pub towards: DVec3,
}

/// Light from every direction by a formula.
///
/// ```
/// use glam::DVec3;
/// use spectral_core::environment::{LightModel, Pattern};
/// let model = LightModel::new(Pattern::Cos).with_head(10.0);
/// let at = |degrees: f64| model.rgb(DVec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos()))[0];
/// assert_eq!((at(9.9), at(90.1)), (0.0, 0.0));
/// assert!((at(60.0) - 0.5).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct LightModel {
    /// The light above the horizon.
    pub pattern: Pattern,
    /// Unit direction of the zenith.
    pub zenith: DVec3,
    /// What stands between the stone and the light, if anything does.
    pub head: Option<Head>,
    /// Linear sRGB of all directions below the horizon.
    pub below: [f64; 3],
}

impl LightModel {
    /// The pattern about +z, without a head.
    pub fn new(pattern: Pattern) -> Self {
        let below = pattern.below();
        LightModel { pattern, zenith: DVec3::Z, head: None, below }
    }

    /// The same with a head of this half-angle (degrees) at the zenith.
    #[must_use]
    pub fn with_head(self, half_angle: f64) -> Self {
        let head = Some(Head { half_angle, towards: self.zenith });
        LightModel { head, ..self }
    }

    /// Linear sRGB in a unit direction away from the stone.
    pub fn rgb(&self, direction: DVec3) -> [f64; 3] {
        self.rgb_among(direction, &self.pattern.spots())
    }

    /// The same with the pattern's spots worked out before.
    fn rgb_among(&self, direction: DVec3, spots: &[[f64; 3]]) -> [f64; 3] {
        let up = direction.dot(self.zenith).clamp(-1.0, 1.0);
        if up <= 0.0 {
            return self.below;
        }
        if self.head.is_some_and(|head| direction.dot(head.towards) > head.half_angle.to_radians().cos()) {
            return [0.0; 3];
        }
        self.pattern.rgb(self.across(direction), up, spots)
    }

    /// The direction's components level with the horizon, in a frame that is the world's x and y for a zenith of +z.
    fn across(&self, direction: DVec3) -> [f64; 2] {
        if self.zenith == DVec3::Z {
            return [direction.x, direction.y];
        }
        // The shortest turn that takes the zenith to +z.
        let turned = glam::DQuat::from_rotation_arc(self.zenith, DVec3::Z) * direction;
        [turned.x, turned.y]
    }

    /// The model as an image.
    ///
    /// Where all depends on the angle from +z alone it has [`ROWS`](Self::ROWS) rows, and edges (the horizon, the
    /// head's) are blurred over two rows, 0.04°; else it is 2048 × 1024, and they are blurred over two texels, 0.35°.
    /// Either way no light is lost or gained by it to first order: irradiance is right to 10⁻⁶ of the brightest
    /// radiance along the rows, and to 10⁻⁴ in the other image.
    ///
    /// # Errors
    /// [`Error::Value`] as [`validate`](Self::validate).
    pub fn image(&self) -> Result<LatLong, Error> {
        self.validate()?;
        Ok(if self.is_zonal() { drawing::zones(self) } else { drawing::texels(self) })
    }

    /// Rows of the image of a model that depends on the angle from +z alone.
    pub const ROWS: u32 = 8192;

    fn is_zonal(&self) -> bool {
        let up = |v: DVec3| v == DVec3::Z;
        self.pattern.is_zonal() && up(self.zenith) && self.head.is_none_or(|head| up(head.towards))
    }

    /// Angles from +z, degrees, at which a zonal model jumps.
    fn edges(&self) -> impl Iterator<Item = f64> + '_ {
        self.pattern.edges().into_iter().chain([90.0]).chain(self.head.map(|head| head.half_angle))
    }

    /// Refuses figures that no light can have.
    ///
    /// # Errors
    /// [`Error::Value`] for angles, counts and colours outside their bounds, and directions not of length 1.
    pub fn validate(&self) -> Result<(), Error> {
        self.pattern.validate()?;
        if let Some(head) = self.head {
            if !(head.half_angle > 0.0 && head.half_angle <= 90.0) {
                let expected = "a half-angle in degrees, above 0 and at most 90";
                return Err(Error::value("environment.head_shadow", head.half_angle, expected));
            }
            check_direction("environment.head", head.towards)?;
        }
        check_direction("environment.zenith", self.zenith)?;
        if !self.below.iter().all(|c| (0.0..=1e12).contains(c)) {
            let expected = "three linear sRGB values from 0 to 1e12";
            return Err(Error::value("environment.below", format!("{:?}", self.below), expected));
        }
        Ok(())
    }
}

fn check_direction(what: &str, direction: DVec3) -> Result<(), Error> {
    if direction.is_normalized() {
        return Ok(());
    }
    Err(Error::value(what, direction, "a direction of length 1"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::Environment;
    use std::f64::consts::PI;

    /// ∫ L cos θ dΩ over the upper hemisphere of what a backend would read, by the midpoint rule.
    fn irradiance(model: &LightModel, zenith_steps: u32, azimuth_steps: u32) -> f64 {
        let environment = Environment::image(model.image().unwrap());
        let step = PI / 2.0 / f64::from(zenith_steps);
        let ring = |i: u32| {
            let (sin, cos) = ((f64::from(i) + 0.5) * step).sin_cos();
            let mean = (0..azimuth_steps)
                .map(|k| {
                    let (y, x) = (2.0 * PI * (f64::from(k) + 0.5) / f64::from(azimuth_steps)).sin_cos();
                    environment.rgb(DVec3::new(sin * x, sin * y, cos))[1]
                })
                .sum::<f64>()
                / f64::from(azimuth_steps);
            2.0 * PI * mean * sin * cos * step
        };
        (0..zenith_steps).map(ring).sum()
    }

    #[test]
    fn the_irradiance_of_each_model_is_its_closed_form() {
        // With c = cos h for a head of half-angle h: 2π ∫₀ᶜ f(u) u du.
        for half_angle in [0.0_f64, 10.0, 16.3] {
            let (s, c) = half_angle.to_radians().sin_cos();
            let h = half_angle.to_radians();
            let sc2 = PI * PI / 4.0 - PI * (h / 2.0 - (4.0 * h).sin() / 8.0);
            for (pattern, exact) in [
                (Pattern::Iso, PI * c * c),
                (Pattern::Cos, 2.0 * PI / 3.0 * c.powi(3)),
                (Pattern::Sc2, sc2),
                (Pattern::Dome { half_angle: 60.0 }, PI * (0.75 - s * s)),
            ] {
                let mut model = LightModel::new(pattern.clone());
                if half_angle > 0.0 {
                    model = model.with_head(half_angle);
                }
                let found = irradiance(&model, 100_000, 1);
                assert!((found - exact).abs() < 1e-6, "{pattern:?}, head {half_angle}°: {found}, {exact}");
            }
        }
    }

    #[test]
    fn a_tilted_model_has_the_light_of_an_upright_one() {
        let head = Head { half_angle: 20.0, towards: DVec3::new(0.6, 0.0, 0.8) };
        // The head lies wholly above the horizon: it takes away π sin²h of the projected solid angle, times its own
        // cosine to the zenith.
        let model = LightModel { head: Some(head), ..LightModel::new(Pattern::Iso) };
        let exact = PI * (1.0 - 20f64.to_radians().sin().powi(2) * 0.8);
        let found = irradiance(&model, 1000, 1000);
        assert!((found - exact).abs() < 1e-4 * PI, "{found}, {exact}");
    }

    #[test]
    fn spots_cover_what_they_should() {
        // Each spot of half-angle r at the elevation whose sine is z gives z·π sin²r.
        let (count, radius) = (12, 3.0_f64);
        let model = LightModel::new(Pattern::Spots { count, radius });
        let mean_height = 0.5;
        let exact = f64::from(count) * mean_height * PI * radius.to_radians().sin().powi(2);
        let found = irradiance(&model, 1000, 1000);
        assert!((found - exact).abs() < 2e-3 * exact, "{found}, {exact}");
    }

    #[test]
    fn zones_and_texels_draw_the_same_light() {
        let model = LightModel::new(Pattern::Aset).with_head(10.0);
        let texels = Environment::image(drawing::texels(&model));
        let zones = Environment::image(drawing::zones(&model));
        for k in 0..1800 {
            let degrees = f64::from(k) * 0.1 + 0.05;
            // Edges are sharper in one than in the other.
            if model.edges().any(|edge| (edge - degrees).abs() < 0.4) {
                continue;
            }
            let (sin, cos) = degrees.to_radians().sin_cos();
            let direction = DVec3::new(sin * 0.6, sin * 0.8, cos);
            for (a, b) in zones.rgb(direction).into_iter().zip(texels.rgb(direction)) {
                assert!((a - b).abs() < 1e-6, "{degrees}°");
            }
        }
    }

    #[test]
    fn patches_are_a_function_of_the_seed() {
        let light = |seed| LightModel::new(Pattern::RandomPatch { seed });
        let direction = DVec3::new(0.3, -0.4, 0.75_f64.sqrt());
        assert_eq!(light(7).rgb(direction), light(7).rgb(direction));
        assert_ne!(light(7).rgb(direction), light(8).rgb(direction));
        // The grid's middle is its value 8 · 17 + 8; worked out apart from this program.
        assert_eq!(light(1).rgb(DVec3::Z)[0].to_bits(), 0x3fed_02dc_76de_c112);
        let mean = irradiance(&light(1), 200, 200) / PI;
        assert!((mean - 0.5).abs() < 0.1, "{mean}");
    }

    #[test]
    fn impossible_figures_are_refused() {
        for model in [
            LightModel::new(Pattern::Iso).with_head(0.0),
            LightModel::new(Pattern::Iso).with_head(f64::NAN),
            LightModel::new(Pattern::Dome { half_angle: 91.0 }),
            LightModel::new(Pattern::Spots { count: 0, radius: 2.0 }),
            LightModel::new(Pattern::Spots { count: 5, radius: 0.1 }),
            LightModel { zenith: DVec3::splat(1.0), ..LightModel::new(Pattern::Cos) },
            LightModel { below: [-1.0; 3], ..LightModel::new(Pattern::Cos) },
        ] {
            assert!(model.image().is_err(), "{model:?}");
        }
        let error = Pattern::by_name("izo").unwrap_err().to_string();
        assert_eq!(error, "unknown light model 'izo'; did you mean 'iso'?");
    }
}
