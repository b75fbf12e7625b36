//! Tiers, the facets of a design that are cut at one angle and one depth, and the figures of the whole.

use serde_json::{Value, json};
use spectral_core::cut::Proportions;
use spectral_core::mesh::{Mesh, Plane};

/// Facets of one tier agree in tilt to this, degrees, and in distance to this share of it.
const SAME_TILT: f64 = 0.005;
const SAME_DISTANCE: f64 = 1e-4;

/// Facets at one angle and distance from the centre.
pub struct Tier {
    /// The first name that the design gives to one of them; empty if it gives none.
    pub name: String,
    /// How many facets.
    pub facets: usize,
    /// Degrees between the outward normal and +z.
    pub tilt: f64,
    /// From the design's origin, in its unit.
    pub distance: f64,
}

impl Tier {
    /// Where on the stone it is.
    pub fn part(&self) -> &'static str {
        part(self.tilt)
    }

    /// The angle to the girdle's plane as cutters count it, 0 to 90 degrees on either side.
    pub fn angle(&self) -> f64 {
        self.tilt.min(180.0 - self.tilt)
    }

    /// For scripts.
    pub fn json(&self) -> Value {
        json!({ "name": self.name, "part": self.part(), "facets": self.facets, "angle": self.angle(),
                "distance": self.distance })
    }
}

/// Where on the stone a facet is whose outward normal is so many degrees from +z.
pub fn part(tilt: f64) -> &'static str {
    match tilt {
        t if (t - 90.0).abs() < 0.5 => "girdle",
        t if t < 0.5 => "table",
        t if t > 179.5 => "culet",
        t if t < 90.0 => "crown",
        _ => "pavilion",
    }
}

/// The tiers of a design, in the order in which they first appear.
pub fn group(facets: &[(&Plane, Option<&str>)]) -> Vec<Tier> {
    let mut tiers: Vec<Tier> = Vec::new();
    for (plane, name) in facets {
        let tilt = plane.normal.z.clamp(-1.0, 1.0).acos().to_degrees();
        let distance = plane.offset;
        let same = |tier: &&mut Tier| {
            (tier.tilt - tilt).abs() < SAME_TILT
                && (tier.distance - distance).abs() <= SAME_DISTANCE * distance.abs().max(tier.distance.abs())
        };
        match tiers.iter_mut().find(same) {
            Some(tier) => {
                tier.facets += 1;
                if tier.name.is_empty() {
                    tier.name = name.unwrap_or_default().to_owned();
                }
            }
            None => {
                tiers.push(Tier { name: name.unwrap_or_default().to_owned(), facets: 1, tilt, distance });
            }
        }
    }
    tiers
}

/// The figures of a closed solid whose table faces +z, in its unit of length, for scripts.
pub fn proportions(mesh: &Mesh) -> Value {
    let p = Proportions::of(mesh);
    json!({
        "convex": mesh.is_convex(),
        "shells": mesh.shells(),
        "facets": mesh.facets().len(),
        "triangles": mesh.triangles().len(),
        "vertices": mesh.positions().len(),
        "crown_facets": p.crown_facets,
        "girdle_facets": p.girdle_facets,
        "pavilion_facets": p.pavilion_facets,
        "width": p.width,
        "length": p.length,
        "table_percent": p.table_percent,
        "depth_percent": 100.0 * p.total_depth / p.width,
        "crown_height_percent": 100.0 * p.crown_height / p.width,
        "girdle_percent": 100.0 * p.girdle / p.width,
        "pavilion_depth_percent": 100.0 * p.pavilion_depth / p.width,
        "crown_angle": p.crown_angle,
        "pavilion_angle": p.pavilion_angle,
        "volume": p.volume,
        "area": mesh.area(),
    })
}
