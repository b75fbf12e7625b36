//! Loose triangles, as mesh files hold them.

use glam::DVec3;

/// Triangles whose corners are numbers of positions.
#[derive(Debug)]
pub(super) struct Soup {
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}
