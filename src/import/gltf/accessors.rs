//! Tables of numbers in a file's buffers (glTF 2.0, section 3.6.2).

use super::file::File;
use crate::error::Result;
use crate::files::memory;
use gltf::json::accessor::{Accessor, ComponentType, IndexComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Index, buffer};

/// Rows of equal length in the bytes of a view.
struct Rows<'a> {
    bytes: &'a [u8],
    stride: usize,
    component: ComponentType,
    /// Components a row.
    width: usize,
    count: usize,
}

impl<'a> Rows<'a> {
    /// `count` rows from byte `offset` of a view on; the message says why they are not there.
    fn find(
        file: &'a File<'_>,
        view: Index<buffer::View>,
        offset: u64,
        (component, width): (ComponentType, usize),
        count: usize,
    ) -> std::result::Result<Rows<'a>, String> {
        let (bytes, stride) = file.buffers.view(&file.root, view)?;
        let size = component.size() * width;
        let stride = stride.unwrap_or(size);
        let end = count.saturating_sub(1).checked_mul(stride).and_then(|last| last.checked_add(size));
        let bytes = usize::try_from(offset).ok().and_then(|offset| bytes.get(offset..)).unwrap_or_default();
        if count > 0 && end.is_none_or(|end| end > bytes.len()) {
            return Err(format!("its {count} elements reach beyond bufferViews[{}]", view.value()));
        }
        Ok(Rows { bytes, stride, component, width, count })
    }

    /// All components, row after row: whole numbers as they are, or as fractions of their largest value.
    fn numbers(&self, normalized: bool) -> impl Iterator<Item = f32> + '_ {
        let one = if normalized { largest(self.component) } else { 1.0 };
        (0..self.count * self.width).map(move |i| {
            let at = i / self.width * self.stride + i % self.width * self.component.size();
            let bytes = &self.bytes[at..];
            // Whole numbers up to 2^32 are exact in f64; fractions are rounded once.
            let value = match self.component {
                ComponentType::I8 => f64::from(bytes[0] as i8),
                ComponentType::U8 => f64::from(bytes[0]),
                ComponentType::I16 => f64::from(i16::from_le_bytes([bytes[0], bytes[1]])),
                ComponentType::U16 => f64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
                ComponentType::U32 => f64::from(self.word(at)),
                ComponentType::F32 => return f32::from_bits(self.word(at)),
            };
            (value / one).max(if normalized { -1.0 } else { f64::NEG_INFINITY }) as f32
        })
    }

    fn word(&self, at: usize) -> u32 {
        let bytes = &self.bytes[at..];
        u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
    }

    /// The first component of each row as a whole number; of a row of floats its bits.
    fn whole(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.count).map(move |i| {
            let at = i * self.stride;
            match self.component {
                ComponentType::I8 | ComponentType::U8 => self.bytes[at].into(),
                ComponentType::I16 | ComponentType::U16 => {
                    u16::from_le_bytes([self.bytes[at], self.bytes[at + 1]]).into()
                }
                ComponentType::U32 | ComponentType::F32 => self.word(at),
            }
        })
    }
}

/// The number that stands for 1 where whole numbers are fractions.
fn largest(component: ComponentType) -> f64 {
    match component {
        ComponentType::I8 => 127.0,
        ComponentType::U8 => 255.0,
        ComponentType::I16 => 32767.0,
        ComponentType::U16 => 65535.0,
        ComponentType::U32 | ComponentType::F32 => 1.0,
    }
}

impl File<'_> {
    /// The rows of accessor `index`, which must have `N` components each.
    pub fn vectors<const N: usize>(&self, index: Index<Accessor>) -> Result<Vec<[f32; N]>> {
        let number = index.value();
        self.read_vectors(index).map_err(|why| self.fault(format_args!("accessors[{number}]"), why))
    }

    fn read_vectors<const N: usize>(&self, index: Index<Accessor>) -> std::result::Result<Vec<[f32; N]>, String> {
        let (accessor, component, kind) = self.accessor(index)?;
        if kind.multiplicity() != N {
            return Err(format!("its elements are of type {kind:?} where {N} components are needed"));
        }
        let (count, layout) = (accessor.count.0 as usize, (component, N));
        let mut rows: Vec<[f32; N]> = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
                let found = Rows::find(self, view, offset, layout, count)?;
                let mut numbers = found.numbers(accessor.normalized);
                let row = |_| std::array::from_fn(|_| numbers.next().unwrap_or_default());
                (0..count).map(row).collect()
            }
            None => {
                let zeros = memory::table::<f32>(count.saturating_mul(N), "an accessor without data");
                zeros.map_err(|why| why.to_string())?.as_chunks().0.to_vec()
            }
        };
        if let Some(sparse) = &accessor.sparse {
            let Checked::Valid(IndexComponentType(kind)) = sparse.indices.component_type else { return Ok(rows) };
            let (places, count) = (&sparse.indices, sparse.count.0 as usize);
            let places = Rows::find(self, places.buffer_view, places.byte_offset.0, (kind, 1), count)?;
            let values = Rows::find(self, sparse.values.buffer_view, sparse.values.byte_offset.0, layout, count)?;
            let mut numbers = values.numbers(accessor.normalized);
            for place in places.whole() {
                let row =
                    rows.get_mut(place as usize).ok_or_else(|| format!("its sparse index {place} names no element"))?;
                row.fill_with(|| numbers.next().unwrap_or_default());
            }
        }
        Ok(rows)
    }

    /// The whole numbers of accessor `index`.
    pub fn indices(&self, index: Index<Accessor>) -> Result<Vec<u32>> {
        let read = || {
            let (accessor, component, kind) = self.accessor(index)?;
            let whole = matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32);
            let (Some(view), Type::Scalar, true) = (accessor.buffer_view, kind, whole) else {
                return Err("indices must be whole numbers of a buffer view".to_string());
            };
            let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
            Ok(Rows::find(self, view, offset, (component, 1), accessor.count.0 as usize)?.whole().collect())
        };
        read().map_err(|why| self.fault(format_args!("accessors[{}]", index.value()), why))
    }

    fn accessor(&self, index: Index<Accessor>) -> std::result::Result<(&Accessor, ComponentType, Type), String> {
        let accessor = self.root.accessors.get(index.value()).ok_or("there is none")?;
        match (accessor.component_type, accessor.type_) {
            (Checked::Valid(component), Checked::Valid(kind)) => Ok((accessor, component.0, kind)),
            _ => Err("its types are unknown".into()),
        }
    }
}
