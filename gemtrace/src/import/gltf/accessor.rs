//! Numbers in buffers: interleaved, sparse, of any component type.

use glam::DVec3;
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::View;
use gltf::{Accessor, accessor::sparse::IndexType};

/// More elements are not read.
const MOST: usize = 1 << 28;

/// The bytes of all buffers.
pub(super) struct Buffers(pub Vec<Vec<u8>>);

impl Buffers {
    /// An accessor of three numbers each.
    pub fn points(&self, accessor: &Accessor) -> Result<Vec<DVec3>, String> {
        if accessor.dimensions() != Dimensions::Vec3 {
            return Err("positions are three numbers each, these are not".to_owned());
        }
        let numbers = self.numbers(accessor)?;
        Ok(numbers.as_chunks().0.iter().map(|p: &[f64; 3]| DVec3::from_array(*p)).collect())
    }

    /// An accessor of whole numbers.
    pub fn indices(&self, accessor: &Accessor) -> Result<Vec<u32>, String> {
        let whole = matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32);
        if accessor.dimensions() != Dimensions::Scalar || !whole {
            return Err("indices are whole numbers, these are not".to_owned());
        }
        Ok(self.numbers(accessor)?.into_iter().map(|v| v as u32).collect())
    }

    /// All numbers of an accessor, element by element.
    fn numbers(&self, accessor: &Accessor) -> Result<Vec<f64>, String> {
        let (count, width) = (accessor.count(), accessor.dimensions().multiplicity());
        let kind = (accessor.data_type(), accessor.normalized());
        if count > MOST {
            return Err(format!("an accessor of {count} elements; at most {MOST} are read"));
        }
        let mut numbers = match accessor.view() {
            Some(view) => {
                let element = width * kind.0.size();
                let stride = view.stride().unwrap_or(element);
                let bytes = self.bytes(&view, accessor.offset(), count, stride, element)?;
                let element = |k: usize| &bytes[k * stride..k * stride + element];
                (0..count).flat_map(|k| components(element(k), kind)).collect()
            }
            None => vec![0.0; count * width],
        };
        if let Some(sparse) = accessor.sparse() {
            let (places, values) = (sparse.indices(), sparse.values());
            let index = match places.index_type() {
                IndexType::U8 => DataType::U8,
                IndexType::U16 => DataType::U16,
                IndexType::U32 => DataType::U32,
            };
            let (count, size) = (sparse.count(), index.size());
            let at = self.bytes(&places.view(), places.offset(), count, size, size)?;
            let element = width * kind.0.size();
            let new = self.bytes(&values.view(), values.offset(), count, element, element)?;
            let at = components(&at[..count * size], (index, false));
            for (place, value) in
                at.zip(components(&new[..count * element], kind).collect::<Vec<_>>().chunks(width))
            {
                let slot = numbers.get_mut(place as usize * width..(place as usize + 1) * width);
                slot.ok_or("a sparse accessor changes an element that is not there")?.copy_from_slice(value);
            }
        }
        Ok(numbers)
    }

    /// The bytes of `count` elements of a view.
    fn bytes(
        &self,
        view: &View,
        offset: usize,
        count: usize,
        stride: usize,
        element: usize,
    ) -> Result<&[u8], String> {
        let beyond = || "an accessor reaches beyond its buffer".to_owned();
        let need = if count == 0 { 0 } else { (count - 1) * stride + element };
        let buffer = self.0.get(view.buffer().index()).ok_or_else(beyond)?;
        let whole =
            buffer.get(view.offset()..).and_then(|rest| rest.get(..view.length())).ok_or_else(beyond)?;
        whole.get(offset..).and_then(|rest| rest.get(..need)).ok_or_else(beyond)
    }
}

/// Little-endian components as numbers, normalised ones in −1 to 1 (glTF 2.0, 3.6.2.2 and 2.1.2 of KHR_mesh_quantization).
fn components(bytes: &[u8], (kind, normalised): (DataType, bool)) -> impl Iterator<Item = f64> {
    let number = move |b: &[u8]| -> (f64, f64) {
        let pair = || [b[0], b[1]];
        let four = || [b[0], b[1], b[2], b[3]];
        match kind {
            DataType::I8 => (f64::from(b[0] as i8), 127.0),
            DataType::U8 => (f64::from(b[0]), 255.0),
            DataType::I16 => (f64::from(i16::from_le_bytes(pair())), 32_767.0),
            DataType::U16 => (f64::from(u16::from_le_bytes(pair())), 65_535.0),
            DataType::U32 => (f64::from(u32::from_le_bytes(four())), 1.0),
            DataType::F32 => (f64::from(f32::from_le_bytes(four())), 1.0),
        }
    };
    bytes.chunks_exact(kind.size()).map(move |b| {
        let (value, most) = number(b);
        if normalised { (value / most).max(-1.0) } else { value }
    })
}
