//! Pictures read back by readers that know nothing of this program.

use exr::meta::attribute::AttributeValue;
use exr::prelude::{FlatImage, ReadChannels, ReadLayers, read};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// An EXR's channels and attributes.
pub struct Exr {
    pub channels: BTreeMap<String, Vec<f32>>,
    pub attributes: BTreeMap<String, String>,
    pub chromaticities: [[f32; 2]; 4],
}

impl Exr {
    pub fn open(path: &Path) -> Self {
        let image: FlatImage = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .from_file(path)
            .unwrap();
        let layer = &image.layer_data[0];
        let channels = layer.channel_data.list.iter();
        let c = image.attributes.chromaticities.unwrap();
        let other = layer.attributes.other.iter();
        Exr {
            channels: channels
                .map(|c| (c.name.to_string(), c.sample_data.values_as_f32().collect()))
                .collect(),
            attributes: other.map(|(key, value)| (key.to_string(), text(value))).collect(),
            chromaticities: [c.red, c.green, c.blue, c.white].map(|v| [v.0, v.1]),
        }
    }

    /// R, G, B, A of pixel `i`, counted row by row.
    pub fn pixel(&self, i: usize) -> [f32; 4] {
        ["R", "G", "B", "A"].map(|name| self.channels[name][i])
    }
}

fn text(value: &AttributeValue) -> String {
    match value {
        AttributeValue::Text(text) => text.to_string(),
        AttributeValue::F64(number) => number.to_string(),
        other => format!("{other:?}"),
    }
}

/// A PNG's samples, row by row, RGBA, and its text.
pub struct Png {
    pub width: u32,
    pub height: u32,
    pub samples: Vec<u16>,
    pub provenance: serde_json::Value,
    pub primaries: Option<u8>,
}

impl Png {
    pub fn open(path: &Path) -> Self {
        let mut reader = png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let frame = reader.next_frame(&mut bytes).unwrap();
        assert_eq!(frame.color_type, png::ColorType::Rgba);
        let samples = match frame.bit_depth {
            png::BitDepth::Eight => bytes.iter().map(|&b| u16::from(b)).collect(),
            _ => bytes.as_chunks::<2>().0.iter().map(|b| u16::from_be_bytes(*b)).collect(),
        };
        let info = reader.info();
        let provenance = info.utf8_text.iter().find(|chunk| chunk.keyword == "gemtrace").unwrap();
        Png {
            width: info.width,
            height: info.height,
            samples,
            provenance: serde_json::from_str(&provenance.get_text().unwrap()).unwrap(),
            primaries: info.coding_independent_code_points.map(|c| c.color_primaries),
        }
    }
}
