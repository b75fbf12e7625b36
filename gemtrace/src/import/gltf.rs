//! glTF 2.0, text (.gltf) and binary (.glb), through the crate `gltf`: every mesh of the scene with its transforms, turned from
//! y-up to z-up. Units stay the file's. What it says of materials is read by `look`.
//!
//! Accessors are read here: the crate reads positions of 32-bit floats alone, and `KHR_mesh_quantization` has others.

mod accessor;

use super::soup::{Names, Soup};
use accessor::Buffers;
use glam::{DMat4, DVec3};
use gltf::buffer::Source;
use gltf::mesh::Mode;
use gltf::{Document, Gltf, Node};
use spectral_core::shown;

/// More triangles are not read.
const MOST: usize = 1 << 28;
/// Compressed geometry, which other programs can write out plainly.
const COMPRESSED: [&str; 2] = ["KHR_draco_mesh_compression", "EXT_meshopt_compression"];

/// A parsed file, without the buffers that are in other files.
pub(crate) struct File {
    pub document: Document,
    blob: Option<Vec<u8>>,
}

impl File {
    /// Parses the JSON.
    pub fn parse(bytes: &[u8]) -> Result<Self, String> {
        let refuse = |e: gltf::Error| format!("not a complete glTF file: {e}");
        let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(refuse)?;
        if let Some(name) = document.extensions_required().find(|name| COMPRESSED.contains(name)) {
            return Err(format!(
                "its meshes are compressed ({name}), which is not read: export without compression"
            ));
        }
        Ok(File { document, blob })
    }

    /// The files that hold its buffers, as paths from its own folder.
    pub fn links(&self) -> Result<Vec<String>, String> {
        let uris = self.document.buffers().filter_map(|buffer| match buffer.source() {
            Source::Uri(uri) if !uri.starts_with("data:") => Some(link(uri)),
            _ => None,
        });
        uris.collect()
    }

    fn buffers(mut self, open: super::mesh::Open) -> Result<(Document, Buffers), String> {
        let mut buffers = Vec::new();
        for buffer in self.document.buffers() {
            let bytes = match buffer.source() {
                Source::Bin => self.blob.take().ok_or("its binary part is missing")?,
                Source::Uri(uri) => match uri.strip_prefix("data:") {
                    Some(data) => decoded(data)?,
                    None => open(&link(uri)?)?,
                },
            };
            if bytes.len() < buffer.length() {
                let (held, length) = (bytes.len(), buffer.length());
                return Err(format!("truncated: a buffer of {length} bytes has {held}"));
            }
            buffers.push(bytes);
        }
        Ok((self.document, Buffers(buffers)))
    }
}

/// A relative path to a file beside or below; nothing else is opened for a file that somebody sent.
fn link(uri: &str) -> Result<String, String> {
    let (mut path, mut rest) = (Vec::new(), uri.as_bytes());
    while let [byte, after @ ..] = rest {
        let digits = after.first_chunk::<2>().and_then(|digits| std::str::from_utf8(digits).ok());
        let escaped = digits.filter(|_| *byte == b'%').and_then(|digits| u8::from_str_radix(digits, 16).ok());
        path.push(escaped.unwrap_or(*byte));
        rest = if escaped.is_some() { &after[2..] } else { after };
    }
    let path = String::from_utf8_lossy(&path).into_owned();
    let plain = |part: &str| !matches!(part, "" | "..") && !part.contains(['\\', ':', '\0']);
    if path.split('/').all(plain) {
        return Ok(path);
    }
    Err(format!("its buffer is in '{}': only files in its own folder or below are read", shown(uri)))
}

/// The bytes of a `data:` address, whose head is gone.
fn decoded(data: &str) -> Result<Vec<u8>, String> {
    use base64::{Engine as _, engine::general_purpose::STANDARD_NO_PAD};
    let text = data.split_once(";base64,").map(|(_, text)| text.trim_end_matches('='));
    let bytes = text.map(|text| STANDARD_NO_PAD.decode(text));
    bytes.and_then(Result::ok).ok_or_else(|| "a buffer within it is not base64".to_owned())
}

/// From the format's frame, where +y is up and +z towards the viewer, to ours.
pub(super) fn to_z_up(point: DVec3) -> DVec3 {
    DVec3::new(point.x, -point.z, point.y)
}

/// The triangles of all meshes in the file's scene, each with the names of its node and those above it, of its mesh and of
/// its material.
pub(super) fn read(bytes: &[u8], open: super::mesh::Open) -> Result<Soup, String> {
    let (document, buffers) = File::parse(bytes)?.buffers(open)?;
    let mut soup = Soup::default();
    visit(&document, &mut |node, transform, above| add(&mut soup, &buffers, node, transform, above))?;
    if soup.triangles.is_empty() {
        return Err("it holds no triangles".to_owned());
    }
    Ok(soup)
}

/// What is done with a node, its transform and the names of the nodes above it.
type Visitor<'v, 'a> = dyn FnMut(&Node<'a>, DMat4, &[String]) -> Result<(), String> + 'v;

/// Calls `then` with each node of the scene, its transform and the names of the nodes above it.
pub(super) fn visit<'a>(document: &'a Document, then: &mut Visitor<'_, 'a>) -> Result<(), String> {
    let mut seen = vec![false; document.nodes().len()];
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let mut open: Vec<(Node, DMat4, Vec<String>)> = match scene {
        Some(scene) => scene.nodes().map(|node| (node, DMat4::IDENTITY, Vec::new())).collect(),
        None => return Err("it holds no scene".to_owned()),
    };
    open.reverse();
    while let Some((node, above, names)) = open.pop() {
        if std::mem::replace(&mut seen[node.index()], true) {
            return Err(format!("node {} hangs below two others: nodes form a tree", node.index()));
        }
        let own = DMat4::from_cols_array_2d(&node.transform().matrix().map(|column| column.map(f64::from)));
        let transform = above * own;
        then(&node, transform, &names)?;
        let names = [vec![name(&node)], names].concat();
        let children: Vec<Node> = node.children().collect();
        open.extend(children.into_iter().rev().map(|child| (child, transform, names.clone())));
    }
    Ok(())
}

/// What a node is called.
pub(super) fn name(node: &Node) -> String {
    node.name().map_or_else(|| format!("node {}", node.index()), str::to_owned)
}

fn add(
    soup: &mut Soup,
    buffers: &Buffers,
    node: &Node,
    transform: DMat4,
    above: &[String],
) -> Result<(), String> {
    let Some(mesh) = node.mesh() else { return Ok(()) };
    // A reflection turns triangles inside out.
    let mirrored = transform.determinant() < 0.0;
    for primitive in mesh.primitives() {
        if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            continue;
        }
        let positions = primitive.get(&gltf::Semantic::Positions).ok_or("a mesh has no positions")?;
        let start = soup.positions.len();
        let points = buffers.points(&positions)?;
        soup.positions.extend(points.iter().map(|p| to_z_up(transform.transform_point3(*p))));
        let corners = match primitive.indices() {
            Some(indices) => buffers.indices(&indices)?,
            None => (0..points.len() as u32).collect(),
        };
        if let Some(beyond) = corners.iter().find(|c| **c as usize >= points.len()) {
            return Err(format!("vertex {beyond} is not there; the mesh has {}", points.len()));
        }
        let triangles = triangles(primitive.mode(), &corners);
        if soup.triangles.len() + triangles.len() > MOST || soup.positions.len() > u32::MAX as usize {
            return Err(format!("more than {MOST} triangles"));
        }
        let objects = [&[name(node)], above].concat();
        let groups = mesh.name().map(str::to_owned).into_iter().collect();
        let material = primitive.material().name().map(str::to_owned);
        soup.begin(Names { objects, groups, material });
        soup.triangles.extend(triangles.into_iter().map(|[a, b, c]| {
            let [a, b, c] = [a, b, c].map(|corner| start as u32 + corner);
            if mirrored { [a, c, b] } else { [a, b, c] }
        }));
    }
    Ok(())
}

/// Corners as triangles (glTF 2.0, 3.7.2.1).
fn triangles(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let turn = |(k, c): (usize, &[u32])| [c[0], c[1 + k % 2], c[2 - k % 2]];
            corners.windows(3).enumerate().map(turn).collect()
        }
        Mode::TriangleFan => {
            let rest = corners.get(1..).unwrap_or_default();
            rest.windows(2).map(|c| [corners[0], c[0], c[1]]).collect()
        }
        _ => corners.as_chunks().0.to_vec(),
    }
}
