//! What is to be rendered, as a person describes it; [`PreparedScene`](crate::prepare::PreparedScene) is
//! what backends render.

use crate::{
    Error,
    camera::{Camera, Projection},
    environment::{Environment, LatLong},
    material::Material,
    mesh::{Mesh, Placement},
};
use glam::{DMat3, DVec3};
use std::sync::Arc;

/// What a pixel shows where its primary ray meets no stone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Background {
    /// The environment itself.
    #[default]
    Environment,
    /// Nothing: black with alpha 0, for compositing.
    Transparent,
}

/// The axis of a mesh's file that points up in the world, where +z is the normal of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Up {
    /// The file's x.
    X,
    /// The file's y, as in most programs for modelling.
    Y,
    /// The file's z.
    #[default]
    Z,
}

impl Up {
    /// The names of the axes, as scenes have them.
    pub const NAMES: [&str; 3] = ["x", "y", "z"];

    /// The axis of a name.
    ///
    /// ```
    /// use {glam::DVec3, spectral_core::scene::Up};
    /// let y = Up::by_name("y")?;
    /// assert_eq!(y.matrix() * DVec3::Y, DVec3::Z);
    /// assert!(Up::by_name("w").is_err());
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Unknown`] with the valid names.
    pub fn by_name(name: &str) -> Result<Self, Error> {
        match name {
            "x" => Ok(Up::X),
            "y" => Ok(Up::Y),
            "z" => Ok(Up::Z),
            _ => Err(Error::unknown("axis", name, Self::NAMES)),
        }
    }

    /// The rotation that brings the axis to +z. It exchanges coordinates, so it rounds nothing.
    pub fn matrix(self) -> DMat3 {
        match self {
            Up::X => DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::Y),
            Up::Y => DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y),
            Up::Z => DMat3::IDENTITY,
        }
    }
}

/// How a crystal lies in a stone, in the frame of the file. Vectors have any length above 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Orientation {
    /// The optic axis of a uniaxial crystal.
    OpticAxis(DVec3),
    /// x and y of a crystal, made perpendicular; z is x × y, along which a uniaxial crystal has its optic axis.
    Axes([DVec3; 2]),
}

/// A stone (or a piece of metal): a closed mesh, a material, and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Stone {
    /// For messages: "stone 2 (ring.obj)".
    pub name: String,
    /// Shape in the file's own units and frame.
    pub mesh: Arc<Mesh>,
    /// The axis of the mesh that is the table's normal; everything below is said of the mesh with this axis as +z.
    pub up: Up,
    /// Scale about the file's origin until the smaller of the x and y extents is this many mm; `None`
    /// takes the mesh's units as mm.
    pub width: Option<f64>,
    /// Degrees about x, then y, then z, right-handed, before `position`.
    pub rotation: DVec3,
    /// mm.
    pub position: DVec3,
    /// What it is made of.
    pub material: Arc<Material>,
    /// How its crystal lies in it, turned with `rotation`; `None` takes the axes of the file's frame, so the optic axis
    /// along the table's normal. What is isotropic needs none.
    pub orientation: Option<Orientation>,
    /// Where stones overlap, the one with the higher priority fills the space; among equals the smaller
    /// volume, so that an inclusion lies inside its host wherever it is listed; then the later one.
    pub priority: i32,
}

impl Stone {
    /// A stone at the origin as its mesh stands, in mm.
    pub fn new(name: impl Into<String>, mesh: Arc<Mesh>, material: Arc<Material>) -> Self {
        Stone {
            name: name.into(),
            mesh,
            up: Up::Z,
            width: None,
            rotation: DVec3::ZERO,
            position: DVec3::ZERO,
            material,
            orientation: None,
            priority: 0,
        }
    }

    /// The mesh in the world: R·(scale·up·file) + position, in mm.
    ///
    /// # Errors
    /// [`Error::Value`] for a width, rotation or position that is not usable.
    pub fn placed(&self) -> Result<Mesh, Error> {
        let (rotation, scale, position) = self.place()?;
        self.mesh.transformed(rotation, scale, position)
    }

    /// Whether [`placed`](Self::placed) would give a mesh, without making one.
    ///
    /// # Errors
    /// As there.
    pub fn check_place(&self) -> Result<(), Error> {
        self.placement().map(drop)
    }

    /// The least and the greatest corner of the box about the stone as it stands in the world, mm.
    ///
    /// # Errors
    /// As [`placed`](Self::placed), without making a mesh.
    pub fn bounds(&self) -> Result<(DVec3, DVec3), Error> {
        Ok(self.placement()?.bounds(&self.mesh, 0..self.mesh.triangles().len() as u32))
    }

    /// How the mesh is placed, which keeps it within the range of coordinates.
    pub(crate) fn placement(&self) -> Result<Placement, Error> {
        let (rotation, scale, position) = self.place()?;
        let placement = Placement::new(rotation, scale, position)?;
        self.crystal_axes()?;
        placement.check(&self.mesh).map(|()| placement)
    }

    /// The axes x, y and z of its crystal in the world, unit.
    ///
    /// # Errors
    /// [`Error::Value`] for axes without a direction or parallel to each other, and for a biaxial crystal of which only
    /// one axis is given.
    pub fn crystal_axes(&self) -> Result<[DVec3; 3], Error> {
        let (rotation, ..) = self.place()?;
        let [x, z] = match self.orientation {
            None => [DVec3::X, DVec3::Z].map(|axis| self.up.matrix().transpose() * axis),
            Some(Orientation::OpticAxis(axis)) => {
                if self.material.axes.len() > 1 {
                    let expected = "a biaxial crystal needs crystal_axes = [x, y]";
                    return Err(self.axis_error("optic_axis", &[axis], expected));
                }
                [axis.any_orthogonal_vector(), axis]
            }
            Some(Orientation::Axes([x, y])) => [x, x.cross(y)],
        };
        let unit = |v: DVec3| v.is_finite().then(|| v.try_normalize()).flatten();
        let (Some(x), Some(z)) = (unit(x), unit(z)) else { return Err(self.no_direction()) };
        Ok([x, z.cross(x), z].map(|axis| rotation * axis))
    }

    fn no_direction(&self) -> Error {
        match self.orientation {
            Some(Orientation::Axes(axes)) => {
                self.axis_error("crystal_axes", &axes, "two directions [x, y] that are not parallel")
            }
            Some(Orientation::OpticAxis(axis)) => {
                self.axis_error("optic_axis", &[axis], "a direction [x, y, z]")
            }
            None => self.axis_error("optic_axis", &[], "a direction [x, y, z]"),
        }
    }

    fn axis_error(&self, key: &str, axes: &[DVec3], expected: &str) -> Error {
        let shown: Vec<String> = axes.iter().map(ToString::to_string).collect();
        Error::value(format!("{}: {key}", self.name), shown.join(", "), expected)
    }

    /// Rotation, scale and translation.
    fn place(&self) -> Result<(DMat3, f64, DVec3), Error> {
        let field = |key: &str| format!("{}: {key}", self.name);
        for (key, v) in [("rotation", self.rotation), ("position", self.position)] {
            if !v.is_finite() || v.abs().max_element() > 1e9 {
                return Err(Error::value(field(key), v, "three finite numbers, at most 1e9 in size"));
            }
        }
        let angles = self.rotation * std::f64::consts::PI / 180.0;
        let rotation = DMat3::from_rotation_z(angles.z)
            * DMat3::from_rotation_y(angles.y)
            * DMat3::from_rotation_x(angles.x);
        // A product with the identity may change the sign of a zero.
        let rotation = if self.up == Up::Z { rotation } else { rotation * self.up.matrix() };
        Ok((rotation, self.scale()?, self.position))
    }

    /// The smaller of the mesh's x and y extents with [`up`](Self::up) as +z, in the file's unit.
    pub fn file_width(&self) -> f64 {
        let (low, high) = self.mesh.bounds();
        (self.up.matrix() * (high - low)).abs().truncate().min_element()
    }

    fn scale(&self) -> Result<f64, Error> {
        let Some(width) = self.width else { return Ok(1.0) };
        if !(width.is_finite() && width > 0.0 && width <= 1e6) {
            let what = format!("{}: width", self.name);
            return Err(Error::value(what, width, "a width in mm, above 0 and at most 1e6"));
        }
        Ok(width / self.file_width())
    }
}

/// A scene: a camera, the light, the stones, and the size of the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The eye.
    pub camera: Camera,
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// What is seen past the stones.
    pub background: Background,
    /// The light.
    pub environment: Environment,
    /// What stands in it; none is allowed and shows the environment alone.
    pub stones: Vec<Stone>,
}

impl Scene {
    /// Stones of a few carats as a jeweller looks at them: from 30 mm above and a little to the side, in the
    /// built-in studio, 256 × 256 pixels.
    ///
    /// Every field can be changed afterwards.
    ///
    /// ```
    /// use spectral_core::{material::Catalogue, scene::{Scene, Stone}, shape::ShapeSpec};
    /// use spectral_core::{prepare::PreparedScene, settings::RenderSettings};
    /// use std::sync::Arc;
    /// let (mesh, _) = ShapeSpec::by_name("round-brilliant")?.cut()?.solid()?;
    /// let diamond = Catalogue::builtin().get("diamond")?.clone();
    /// let mut stone = Stone::new("the diamond", Arc::new(mesh), Arc::new(diamond));
    /// stone.width = Some(6.5);
    /// let scene = Scene { width: 32, height: 32, ..Scene::in_studio(vec![stone]) };
    /// let prepared = PreparedScene::new(&scene, &RenderSettings::default())?;
    /// assert!(prepared.lone_convex_stone().is_some());
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    pub fn in_studio(stones: Vec<Stone>) -> Self {
        Scene {
            camera: Camera {
                position: DVec3::new(3.0, -11.0, 28.0),
                look_at: DVec3::ZERO,
                up: DVec3::Z,
                projection: Projection::Perspective { fov: 14.0 },
            },
            width: 256,
            height: 256,
            background: Background::Environment,
            environment: Environment::image(LatLong::studio()),
            stones,
        }
    }
}
