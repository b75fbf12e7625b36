//! The file of a part: some rows of a film, with all that is needed to write the picture once the other parts are there.
//!
//! It is an OpenEXR of those rows alone, one below the other, in 32-bit floats without loss: the sums `X`, `Y`, `Z`
//! and `coverage`, the number of `samples`, and for spectral films the sums of radiance, `S0000`, `S0001` and so on. The
//! attribute `gemtrace.part` holds a [`Header`] as JSON.

use crate::import::{self, picture};
use crate::output::exr::{channel, image, text};
use crate::{Error, output};
use exr::meta::attribute::AttributeValue;
use exr::prelude::{
    AnyChannel, AnyChannels, FlatSamples, Layer, LayerAttributes, ReadChannels, ReadLayers, Vec2,
    WritableImage, read as read_exr,
};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use spectral_core::color::{RgbSpace, Tone};
use spectral_core::film::{Film, PixelSums};
use spectral_core::tracer::{DeviceInfo, Energy, TraceReport};
use spectral_core::wavelength::WavelengthGrid;
use std::io::Cursor;
use std::path::Path;

const ATTRIBUTE: &str = "gemtrace.part";

/// What a part says of itself and of its picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Which shard this is, such as "3/8".
    pub shard: String,
    /// The same in all parts of a picture.
    pub picture: PictureHeader,
    /// What was done for this part.
    pub work: Contribution,
}

/// How the picture is to be written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PictureHeader {
    /// Columns of the picture.
    pub width: u32,
    /// Rows of the picture.
    pub height: u32,
    /// Wavelengths that the film keeps, nm; none unless it is spectral.
    pub spectral: Vec<f64>,
    /// The colour space's name.
    pub space: String,
    /// Bits a channel of the PNG.
    pub bits: u32,
    /// Stops that the PNG is brightened by.
    pub exposure: f64,
    /// How the PNG shows what a screen cannot.
    #[serde(default)]
    pub tone: Tone,
    /// Whether alpha is coverage.
    pub transparent: bool,
    /// The colour behind what is transparent, linear sRGB.
    pub backdrop: Option<[f64; 3]>,
    /// The files to be written, from the folder of the part on.
    pub outputs: Vec<String>,
    /// The picture's provenance but for what depends on the [`Contribution`].
    pub facts: Map<String, Value>,
}

/// What one machine contributed to a picture.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Contribution {
    /// Backend, name and driver of the devices, in order.
    pub devices: Vec<[String; 3]>,
    /// Segments traced.
    pub rays: u64,
    /// [`Energy`]: started, dropped by depth and by threshold, left at the limit, lost.
    pub energy: [f64; 5],
}

impl Contribution {
    /// What a report says.
    pub fn new(devices: &[DeviceInfo], report: &TraceReport) -> Self {
        let facts = |d: &DeviceInfo| [d.backend.to_owned(), d.name.clone(), d.driver.clone()];
        let e = &report.energy;
        let energy = [e.started, e.dropped_depth, e.dropped_threshold, e.left_at_limit, e.lost];
        Contribution { devices: devices.iter().map(facts).collect(), rays: report.rays, energy }
    }

    /// Adds another machine's.
    pub fn add(&mut self, other: &Contribution) {
        for device in &other.devices {
            if !self.devices.contains(device) {
                self.devices.push(device.clone());
            }
        }
        self.rays = self.rays.saturating_add(other.rays);
        self.energy.iter_mut().zip(other.energy).for_each(|(sum, part)| *sum += part);
    }

    /// The account of the energy.
    pub fn energy(&self) -> Energy {
        let [started, dropped_depth, dropped_threshold, left_at_limit, lost] = self.energy;
        Energy { started, dropped_depth, dropped_threshold, left_at_limit, lost }
    }
}

/// Writes the rows of a film.
///
/// # Errors
/// [`Error::Output`] if the file cannot be written.
pub fn write(path: &Path, header: &Header, film: &Film, rows: &[u32]) -> Result<u64, Error> {
    let header = serde_json::to_string(header).map_err(|e| Error::output(path, e))?;
    let pixels = || rows.iter().flat_map(|y| (0..film.width()).map(move |x| (x, *y)));
    let floats = |name: &str, value: &dyn Fn(u32, u32) -> f32| {
        channel(name, pixels().map(|(x, y)| value(x, y)).collect())
    };
    let samples = pixels().map(|(x, y)| film.sums(x, y).samples).collect();
    let mut channels = vec![
        floats("X", &|x, y| film.sums(x, y).xyz[0]),
        floats("Y", &|x, y| film.sums(x, y).xyz[1]),
        floats("Z", &|x, y| film.sums(x, y).xyz[2]),
        floats("coverage", &|x, y| film.sums(x, y).coverage),
        AnyChannel::new("samples", FlatSamples::U32(samples)),
    ];
    channels.extend(
        (0..film.wavelength_count()).map(|k| floats(&spectral(k), &|x, y| film.radiance_sums(x, y)[k])),
    );
    let mut attributes = LayerAttributes::default();
    attributes.other.insert(text(ATTRIBUTE), AttributeValue::Text(text(&header)));
    let image = image(Vec2(film.width() as usize, rows.len()), attributes, channels.into_iter());
    output::write_file(path, |file| image.write().to_unbuffered(file).map_err(|e| e.to_string()))
}

fn spectral(k: usize) -> String {
    format!("S{k:04}")
}

/// A part that has been read.
#[derive(Debug, Clone)]
pub struct Part {
    /// What it says of itself.
    pub header: Header,
    layer: Layer<AnyChannels<FlatSamples>>,
}

/// Reads a part from the bytes of its file.
///
/// # Errors
/// What is wrong with it, for people.
pub fn decode(bytes: &[u8]) -> Result<Part, String> {
    let outline = import::guarded(|| picture::own_exr(bytes))?;
    let text = match outline.own_attributes.other.get(&text(ATTRIBUTE)) {
        Some(AttributeValue::Text(text)) => text.to_string(),
        _ => return Err(format!("it has no attribute '{ATTRIBUTE}'")),
    };
    let header: Header = serde_json::from_str(&text).map_err(|e| format!("'{ATTRIBUTE}': {e}"))?;
    header.picture.check().map_err(|e| e.to_string())?;
    let expected = FIXED + header.picture.spectral.len();
    let channels = outline.channels.list.len();
    if channels != expected {
        return Err(format!("it has {channels} channels, where {expected} are expected"));
    }
    let layers = read_exr().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
    let reader = layers.all_attributes().non_parallel();
    let image = import::guarded(|| reader.from_buffered(Cursor::new(bytes)).map_err(|e| e.to_string()))?;
    Ok(Part { header, layer: image.layer_data })
}

impl PictureHeader {
    /// Whether it can be a picture's.
    fn check(&self) -> Result<(), spectral_core::Error> {
        Film::check_size(self.width, self.height, self.spectral.len())?;
        if !self.spectral.is_empty() {
            WavelengthGrid::list(self.spectral.clone())?;
        }
        RgbSpace::by_name(&self.space).map(drop)
    }
}

/// The channels of every part: `X`, `Y`, `Z`, `coverage`, `samples`.
const FIXED: usize = 5;

impl Part {
    /// Whether it has as many rows of its picture.
    ///
    /// # Errors
    /// What it has instead, for people.
    pub fn check(&self, rows: usize) -> Result<(), String> {
        let Vec2(width, height) = self.layer.size;
        if (width, height) != (self.header.picture.width as usize, rows) {
            let expected = format!("{} × {rows}", self.header.picture.width);
            return Err(format!("its size is {width} × {height} pixels, where {expected} are expected"));
        }
        Ok(())
    }

    /// Puts its rows, as many as [`check`](Self::check) was asked about, where they belong.
    ///
    /// # Errors
    /// What does not fit, for people.
    pub fn place(&self, film: &mut Film, rows: &[u32]) -> Result<(), String> {
        let layer = &self.layer;
        let Vec2(width, height) = layer.size;
        let channel = |name: &str| {
            let found = layer.channel_data.list.iter().find(|channel| channel.name.eq(name));
            found.map(|channel| &channel.sample_data).ok_or_else(|| format!("it has no channel '{name}'"))
        };
        let floats = |name: &str| match channel(name)? {
            FlatSamples::F32(values) => Ok(values.as_slice()),
            _ => Err(format!("its channel '{name}' is not of 32-bit floats")),
        };
        let FlatSamples::U32(samples) = channel("samples")? else {
            return Err("its channel 'samples' is not of whole numbers".to_owned());
        };
        let [x, y, z, coverage] = [floats("X")?, floats("Y")?, floats("Z")?, floats("coverage")?];
        let planes =
            (0..film.wavelength_count()).map(|k| floats(&spectral(k))).collect::<Result<Vec<_>, _>>()?;
        for i in 0..width * height {
            let sums = PixelSums { xyz: [x[i], y[i], z[i]], coverage: coverage[i], samples: samples[i] };
            let radiance: Vec<f32> = planes.iter().map(|plane| plane[i]).collect();
            let (column, row) = ((i % width) as u32, rows[i / width]);
            film.set_sums(column, row, sums, &radiance).map_err(|e| e.to_string())?;
        }
        Ok(())
    }
}
