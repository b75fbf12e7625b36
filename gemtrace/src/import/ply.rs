//! PLY, text and binary, through the crate `ply-rs-bw`.

use super::{soup::Soup, utf8};
use glam::DVec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Property, PropertyAccess, PropertyAccessResult};
use spectral_core::{mesh::polygon, shown};
use std::io::{BufRead, Cursor, ErrorKind};

/// The triangles of a PLY file, or what is wrong with it.
pub(super) fn read(bytes: &[u8]) -> Result<Soup, String> {
    let bytes = &*utf8(bytes);
    let mut reader = Reader::new(Cursor::new(bytes));
    let header = Parser::<Skipped>::new().read_header(&mut reader).map_err(|e| in_header(&e, bytes))?;
    if let Some(element) = header.elements.get("vertex")
        && let Some(axis) = ["x", "y", "z"].iter().find(|axis| !element.properties.contains_key(**axis))
    {
        return Err(format!("its vertices have no property '{axis}'"));
    }
    let mut payload = Payload { line: reader.line(), source: reader.into_inner(), encoding: header.encoding };
    let mut soup = Soup::default();
    // Faces that come before their vertices.
    let mut early = Vec::new();
    let mut vertices_are_read = false;
    for (name, element) in &header.elements {
        check(element, bytes.len())?;
        match name.as_str() {
            "vertex" => {
                payload.each(element, |_, Vertex(v)| {
                    soup.positions.push(v.into());
                    Ok(())
                })?;
                vertices_are_read = true;
            }
            "face" if vertices_are_read => payload.each(element, |number, Face(corners)| {
                triangles_of(number, &soup.positions, &corners, &mut soup.triangles)
            })?,
            "face" => payload.each(element, |_, Face(corners)| {
                early.push(corners);
                Ok(())
            })?,
            _ => payload.each(element, |_, Skipped| Ok(()))?,
        }
    }
    for (number, corners) in early.iter().enumerate() {
        triangles_of(number, &soup.positions, corners, &mut soup.triangles)?;
    }
    Ok(soup)
}

/// What follows the header.
struct Payload<'a> {
    source: Cursor<&'a [u8]>,
    encoding: Encoding,
    /// Of a text file the line that was read last, from 1.
    line: usize,
}

impl Payload<'_> {
    /// Hands the elements over one by one, with their numbers: a list of them would weigh several times the mesh.
    fn each<E: PropertyAccess>(
        &mut self,
        element: &ElementDef,
        mut take: impl FnMut(usize, E) -> Result<(), String>,
    ) -> Result<(), String> {
        let parser = Parser::<E>::new();
        let mut text = String::new();
        for number in 0..element.count {
            let read = match self.encoding {
                Encoding::BinaryBigEndian => parser.read_big_endian_element(&mut self.source, element),
                Encoding::BinaryLittleEndian => parser.read_little_endian_element(&mut self.source, element),
                Encoding::Ascii => {
                    text.clear();
                    self.line += 1;
                    match self.source.read_line(&mut text) {
                        Ok(0) => Err(std::io::Error::from(ErrorKind::UnexpectedEof).into()),
                        Ok(_) => parser.read_ascii_element(&text, element),
                        Err(error) => Err(error.into()),
                    }
                }
            };
            take(number, read.map_err(|error| self.complaint(error, element, number))?)?;
        }
        Ok(())
    }

    fn complaint(&self, error: ParseError, element: &ElementDef, number: usize) -> String {
        let (name, count) = (shown(&element.name), element.count);
        if error.kind() == ErrorKind::UnexpectedEof {
            return format!(
                "not a complete PLY file: Unexpected end of file while reading element '{name}' \
                 (expected {count}, got {number})"
            );
        }
        let place = match self.encoding {
            Encoding::Ascii => format!("line {}", self.line),
            _ => format!("'{name}' {number}"),
        };
        format!("not a complete PLY file: {place} has not what the header says of the element '{name}'")
    }
}

fn triangles_of(
    face: usize,
    positions: &[DVec3],
    corners: &[i64],
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), String> {
    let corners = corners
        .iter()
        .map(|&c| match u32::try_from(c) {
            Ok(index) if (index as usize) < positions.len() => Ok(index),
            _ => Err(format!(
                "face {face}: vertex {c} is not there; the file has {}, counted from 0",
                positions.len()
            )),
        })
        .collect::<Result<Vec<_>, String>>()?;
    if corners.len() < 3 {
        return Err(format!("face {face}: it has {} corners and needs at least 3", corners.len()));
    }
    polygon::triangulate(positions, &corners, triangles).map_err(|m| format!("face {face}: {m}"))
}

/// An element without properties takes no bytes, so a header could announce any number of them; all others
/// end with the file.
fn check(element: &ElementDef, bytes: usize) -> Result<(), String> {
    if element.count > bytes {
        let (name, count) = (shown(&element.name), element.count);
        return Err(format!("truncated: its header announces {count} '{name}' elements, in {bytes} bytes"));
    }
    Ok(())
}

/// What is wrong with a header. The crate's own messages show its parser's structures.
fn in_header(error: &ParseError, bytes: &[u8]) -> String {
    let number = error.line().unwrap_or(1);
    if error.kind() == ErrorKind::UnexpectedEof {
        return "not a complete PLY file: its header has no end, a line 'end_header'".to_owned();
    }
    if number == 1 {
        return "not a PLY file: its first line is not 'ply'".to_owned();
    }
    let line = bytes.split(|byte| *byte == b'\n').nth(number - 1).unwrap_or_default();
    let line = shown(String::from_utf8_lossy(line).trim());
    format!(
        "line {number} of the header, '{line}', is no line of a PLY file: there are 'format', 'comment', 'obj_info', \
         'element', 'property' and 'end_header', each with what belongs to it"
    )
}

struct Vertex([f64; 3]);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Vertex([0.0; 3])
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let axis = match name {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            _ => return PropertyAccessResult::Ignored,
        };
        self.0[axis] = match value {
            Property::Char(v) => v.into(),
            Property::UChar(v) => v.into(),
            Property::Short(v) => v.into(),
            Property::UShort(v) => v.into(),
            Property::Int(v) => v.into(),
            Property::UInt(v) => v.into(),
            Property::Float(v) => v.into(),
            Property::Double(v) => v,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

struct Face(Vec<i64>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Face(Vec::new())
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        self.0 = match value {
            Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Skipped
    }

    fn set_property(&mut self, _: &str, _: Property) -> PropertyAccessResult {
        PropertyAccessResult::Ignored
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty double y\n\
        property int z\nproperty uchar red\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0 9\n1 0 0 9\n0 1.5 0 9\n0 0 1 9\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";

    #[test]
    fn text_files_with_any_number_type() {
        let soup = read(TETRAHEDRON.as_bytes()).unwrap();
        assert_eq!(soup.triangles.len(), 4);
        assert_eq!(soup.positions[2], DVec3::new(0.0, 1.5, 0.0));
    }

    #[test]
    fn messages_say_what_is_missing() {
        let refused = |text: String, message: &str| {
            let error = read(text.as_bytes()).unwrap_err();
            assert!(error.contains(message), "{error}");
        };
        refused(TETRAHEDRON.replace("3 2 0 3\n", ""), "Unexpected end of file while reading element 'face'");
        refused(TETRAHEDRON.replace("3 2 0 3", "3 2 0 9"), "face 3: vertex 9 is not there; the file has 4");
        refused(TETRAHEDRON.replace("double y", "double w"), "no property 'y'");
        let hollow = "ply\nformat binary_little_endian 1.0\nelement nothing 4000000000\nend_header\n";
        refused(hollow.into(), "announces 4000000000 'nothing' elements");
    }
}
