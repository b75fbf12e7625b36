//! The heaviest chain of a ray: of all ways that its light can take, the one that most of it takes.

use super::surface::{Crossing, Surfaces};
use super::{Light, Ray, Reference, Walk, any_axis};
use glam::DVec3;
use spectral_core::camera::CameraRay;
use spectral_core::prepare::PreparedScene;
use spectral_core::stokes::StokesRow;
use spectral_core::tracer::{Energy, OpenOptions};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::sync::Arc;

/// Events that are looked at before the search is given up.
const MOST: usize = 4000;

/// What happens to a chain at a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// It enters a stone, or goes from one into another.
    In,
    /// It leaves all stones.
    Out,
    /// It is reflected, and other light goes on.
    Reflection,
    /// It is reflected, and none goes on.
    TotalReflection,
    /// It ends on something opaque that reflects less of it than is followed, or at the depth limit.
    End,
}

/// One event.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// Where, in the scene's local coordinates, mm.
    pub point: DVec3,
    /// The facet, an index into [`Geometry::facets`](spectral_core::prepare::Geometry::facets).
    pub facet: usize,
    /// What happens.
    pub kind: Kind,
    /// Between the arriving ray and the normal, degrees.
    pub angle: f64,
    /// The share of the ray's light that goes on along the chain.
    pub left: f64,
    /// The length of the segment that arrives, mm.
    pub length: f64,
    /// Whether that segment is inside a stone.
    pub inside: bool,
}

/// A chain, from the eye on.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Chain {
    /// In order.
    pub events: Vec<Event>,
    /// The direction in which it leaves the scene, unit; `None` if it ends inside.
    pub exit: Option<DVec3>,
}

/// The facet that a ray meets first, an index into the geometry's facets.
pub fn first_facet(scene: &PreparedScene, ray: &CameraRay) -> Option<usize> {
    let surfaces = Surfaces::new(&scene.geometry);
    let crossing = surfaces.next(ray.origin, ray.direction, scene.eye_nest)?;
    facet_at(scene, ray.origin + ray.direction * crossing.distance, crossing.normal)
}

/// Follows a ray at wavelength `line` of the first sample's. Light is lost along a chain and never gained, so the chain
/// whose end is found first, if the heaviest ray is always followed next, is the heaviest.
///
/// ```
/// use spectral_core::{material::Catalogue, mesh::{Mesh, Plane}, prepare::PreparedScene};
/// use spectral_core::{cut::Cut, scene::{Scene, Stone}, settings::RenderSettings};
/// use std::sync::Arc;
/// # let side = |azimuth| spectral_core::cut::CutFacet::from(Plane::from_angles(90.0, azimuth, 2.0));
/// # let mut facets: Vec<_> = [0.0, 90.0, 180.0, 270.0].map(side).into();
/// # facets.extend([0.0, -0.0].map(|angle| spectral_core::cut::CutFacet::from(Plane::from_angles(angle, 0.0, 1.0))));
/// let (plate, _) = Cut { facets, ..Cut::default() }.solid()?;
/// let glass = Arc::new(Catalogue::builtin().get("n-bk7")?.clone());
/// let mut scene = Scene::in_studio(vec![Stone::new("plate", Arc::new(plate), glass)]);
/// scene.camera.position = glam::DVec3::new(0.0, 0.0, 30.0);
/// scene.camera.up = glam::DVec3::Y;
/// let scene = Arc::new(PreparedScene::new(&scene, &RenderSettings::default())?);
/// let chain = backend_cpu::heaviest(&scene, &scene.view.ray(128.0, 128.0), 0);
/// let kinds: Vec<_> = chain.events.iter().map(|event| event.kind).collect();
/// assert_eq!(kinds, [backend_cpu::Kind::In, backend_cpu::Kind::Out]);
/// assert!((chain.events[1].length - 2.0).abs() < 1e-9 && chain.events[1].left > 0.9);
/// # Ok::<(), spectral_core::Error>(())
/// ```
pub fn heaviest(scene: &Arc<PreparedScene>, ray: &CameraRay, line: usize) -> Chain {
    let reference = Reference {
        device: super::super::device("reference", ""),
        surfaces: Surfaces::new(&scene.geometry),
        scene: Arc::clone(scene),
        options: OpenOptions::default(),
        facets: None,
        workers: None,
    };
    Search { reference: &reference, line, steps: Vec::new() }.follow(ray)
}

/// An event that was found, and the one before it.
struct Step {
    event: Event,
    before: Option<usize>,
}

struct Search<'a> {
    reference: &'a Reference,
    line: usize,
    steps: Vec<Step>,
}

/// A ray that waits, heaviest first; among equals the one that was found first.
struct Waiting {
    ray: Ray,
    after: Option<usize>,
    number: usize,
}

impl Search<'_> {
    fn follow(mut self, ray: &CameraRay) -> Chain {
        let scene = &self.reference.scene;
        let light = Light::Row { row: StokesRow::eye(), axis: any_axis(ray.direction.to_array()) };
        let start =
            Ray { origin: ray.origin, direction: ray.direction, light, nest: scene.eye_nest, depth: 0 };
        let (table, line) = (scene.table(0), self.line);
        let (reference, pending) = (self.reference, Vec::new());
        let mut walk =
            Walk { reference, table, sample: 0, line, pending, rays: 0, energy: Energy::default() };
        walk.start(start);
        let mut waiting: BinaryHeap<Waiting> = BinaryHeap::new();
        let first = walk.pending.drain(..).map(|ray| Waiting { ray, after: None, number: 0 });
        waiting.extend(first);
        let mut number = 1;
        while let Some(Waiting { ray, after, .. }) = waiting.pop() {
            let Some(crossing) = reference.surfaces.next(ray.origin, ray.direction, ray.nest) else {
                return self.chain(after, Some(ray.direction));
            };
            if self.steps.len() >= MOST {
                return self.chain(after, None);
            }
            walk.event(ray, &crossing);
            let event = end(scene, &ray, &crossing);
            let on = walk.pending.iter().any(|child| child.nest != crossing.before);
            if walk.pending.is_empty() {
                // The rest of this way is too weak to be followed, or leaves at the depth limit.
                self.steps.push(Step { event, before: after });
                return self.chain(Some(self.steps.len() - 1), None);
            }
            for child in walk.pending.drain(..) {
                let kind = kind(&child, &crossing, on);
                let event = Event { kind, left: child.light.intensity(), ..event };
                self.steps.push(Step { event, before: after });
                waiting.push(Waiting { ray: child, after: Some(self.steps.len() - 1), number });
                number += 1;
            }
        }
        Chain::default()
    }

    fn chain(&self, last: Option<usize>, exit: Option<DVec3>) -> Chain {
        let mut events = Vec::new();
        let mut at = last;
        while let Some(step) = at.map(|at| &self.steps[at]) {
            events.push(step.event);
            at = step.before;
        }
        events.reverse();
        Chain { events, exit }
    }
}

/// What happened to a ray that came from a surface; `on` says whether others go on through it.
fn kind(child: &Ray, crossing: &Crossing, on: bool) -> Kind {
    match (child.nest == crossing.before, child.nest.is_empty()) {
        (true, _) if on => Kind::Reflection,
        (true, _) => Kind::TotalReflection,
        (false, true) => Kind::Out,
        (false, false) => Kind::In,
    }
}

/// The event at which a ray ends, unless something goes on from it.
fn end(scene: &PreparedScene, ray: &Ray, crossing: &Crossing) -> Event {
    let point = ray.origin + ray.direction * crossing.distance;
    Event {
        point,
        facet: facet_at(scene, point, crossing.normal).unwrap_or_default(),
        kind: Kind::End,
        angle: (-ray.direction.dot(crossing.normal)).clamp(-1.0, 1.0).acos().to_degrees(),
        left: ray.light.intensity(),
        length: crossing.distance,
        inside: !ray.nest.is_empty(),
    }
}

/// The facet on whose plane a point lies, with this normal on one side or the other.
fn facet_at(scene: &PreparedScene, point: DVec3, normal: DVec3) -> Option<usize> {
    let facets = scene.geometry.facets.iter().enumerate();
    let alike = facets.filter(|(_, facet)| facet.normal.dot(normal).abs() > 1.0 - 1e-9);
    let off = |facet: &spectral_core::prepare::FacetPlane| (facet.normal.dot(point) - facet.offset).abs();
    alike.min_by(|a, b| off(a.1).total_cmp(&off(b.1))).map(|(index, _)| index)
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        let weight = self.ray.light.intensity().total_cmp(&other.ray.light.intensity());
        weight.then(other.number.cmp(&self.number))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Waiting {}
