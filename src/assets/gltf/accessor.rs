//! Accessors: typed arrays in buffers, every offset and length checked before a byte is read.

use ::gltf::json::{
    accessor::{Accessor, ComponentType, Type, sparse::Sparse},
    validation::Checked,
};

use glam::{DAffine3, DMat4};

use super::{
    document::{Document, get},
    error::GltfProblem,
};
use crate::math::Vec3;

/// The most elements of an accessor without a buffer. It is all zeros, so the file's size does not limit it.
const MOST_ZEROS: usize = 1 << 22;

/// The layout of an accessor's bytes.
#[derive(Clone, Copy)]
struct AccessorLayout {
    component: ComponentType,
    normalized: bool,
    /// Components of an element.
    width: usize,
    count: usize,
}

impl AccessorLayout {
    fn of(accessor: &Accessor, index: usize) -> Result<Self, GltfProblem> {
        let (Checked::Valid(component), Checked::Valid(kind)) = (accessor.component_type, accessor.type_) else {
            return Err(GltfProblem::broken(format!("accessor {index} has an unknown type")));
        };
        if matches!(kind, Type::Mat2 | Type::Mat3 | Type::Mat4) {
            return Err(GltfProblem::broken(format!("accessor {index} holds matrices")));
        }
        let count = usize::try_from(accessor.count.0).unwrap_or(usize::MAX);
        Ok(Self {
            component: component.0,
            normalized: accessor.normalized,
            width: kind.multiplicity(),
            count,
        })
    }

    /// The layout of 4 x 4 floats.
    fn of_matrices(accessor: &Accessor, index: usize) -> Result<Self, GltfProblem> {
        let (Checked::Valid(component), Checked::Valid(Type::Mat4)) = (accessor.component_type, accessor.type_) else {
            return Err(GltfProblem::broken(format!("accessor {index} holds no 4 x 4 matrices")));
        };
        if component.0 != ComponentType::F32 {
            return Err(GltfProblem::broken(format!(
                "accessor {index} holds no matrices of floats"
            )));
        }
        Ok(Self {
            component: component.0,
            normalized: false,
            width: 16,
            count: usize::try_from(accessor.count.0).unwrap_or(usize::MAX),
        })
    }

    fn element(&self) -> usize {
        self.component.size() * self.width
    }

    fn number(&self, bytes: &[u8]) -> f32 {
        let scaled = |v: f32, most: f32| if self.normalized { (v / most).max(-1.0) } else { v };
        match (self.component, bytes) {
            (ComponentType::I8, &[b, ..]) => scaled(f32::from(b as i8), 127.0),
            (ComponentType::U8, &[b, ..]) => scaled(f32::from(b), 255.0),
            (ComponentType::I16, &[a, b, ..]) => scaled(f32::from(i16::from_le_bytes([a, b])), 32767.0),
            (ComponentType::U16, &[a, b, ..]) => scaled(f32::from(u16::from_le_bytes([a, b])), 65535.0),
            (ComponentType::U32, &[a, b, c, d, ..]) => u32::from_le_bytes([a, b, c, d]) as f32,
            (ComponentType::F32, &[a, b, c, d, ..]) => f32::from_le_bytes([a, b, c, d]),
            _ => unreachable!("an element has as many bytes as its type"),
        }
    }
}

/// Returns `count` elements of `size` bytes in a view.
fn elements(
    (bytes, stride): (&[u8], Option<usize>),
    offset: u64,
    (count, size): (usize, usize),
    what: impl Fn() -> String,
) -> Result<impl Iterator<Item = &[u8]>, GltfProblem> {
    let stride = stride.unwrap_or(size);
    if stride < size {
        return Err(GltfProblem::broken(format!(
            "{} has a stride of {stride} bytes for {size}",
            what()
        )));
    }
    let offset = usize::try_from(offset).ok();
    let end = count
        .checked_sub(1)
        .map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(size))
        .and_then(|length| length.checked_add(offset?));
    match (offset, end) {
        (Some(offset), Some(end)) if end <= bytes.len() => {
            Ok((0..count).map(move |i| &bytes[offset + i * stride..offset + i * stride + size]))
        }
        _ => Err(GltfProblem::broken(format!(
            "{} reaches past the end of its buffer view",
            what()
        ))),
    }
}

impl Document<'_> {
    /// Returns the number of elements of an accessor.
    pub fn count(&self, index: usize) -> Result<usize, GltfProblem> {
        let accessor = get(&self.root.accessors, index, "accessor")?;
        Ok(usize::try_from(accessor.count.0).unwrap_or(usize::MAX))
    }

    /// Returns the numbers of an element of an accessor.
    pub fn width(&self, index: usize) -> Result<usize, GltfProblem> {
        let accessor = get(&self.root.accessors, index, "accessor")?;
        Ok(AccessorLayout::of(accessor, index)?.width)
    }

    /// The largest number of the type of an accessor's numbers, where they are whole numbers that are not normalised; else 1.
    pub fn largest(&self, index: usize) -> Result<f32, GltfProblem> {
        let layout = AccessorLayout::of(get(&self.root.accessors, index, "accessor")?, index)?;
        Ok(match layout.component {
            ComponentType::F32 => 1.0,
            ComponentType::U32 => u32::MAX as f32,
            _ if layout.normalized => 1.0,
            ComponentType::I8 => f32::from(i8::MAX),
            ComponentType::U8 => f32::from(u8::MAX),
            ComponentType::I16 => f32::from(i16::MAX),
            ComponentType::U16 => f32::from(u16::MAX),
        })
    }

    /// The affine matrices of an accessor of 4 x 4 floats.
    pub fn matrices(&self, index: usize) -> Result<Vec<DAffine3>, GltfProblem> {
        let accessor = get(&self.root.accessors, index, "accessor")?;
        let layout = AccessorLayout::of_matrices(accessor, index)?;
        self.read(index, accessor, layout, DAffine3::IDENTITY, |bytes| {
            let m: [f64; 16] = std::array::from_fn(|k| f64::from(layout.number(&bytes[4 * k..])));
            DAffine3::from_mat4(DMat4::from_cols_array(&m))
        })
    }

    /// An accessor of vectors.
    pub fn vectors(&self, index: usize) -> Result<Vec<Vec3>, GltfProblem> {
        Ok(self.floats::<3>(index)?.into_iter().map(Vec3::from_array).collect())
    }

    /// The least and the largest of the numbers of an accessor, for each place in an element.
    pub fn bounds(&self, index: usize) -> Result<(Vec<f32>, Vec<f32>), GltfProblem> {
        let accessor = get(&self.root.accessors, index, "accessor")?;
        let mut layout = AccessorLayout::of(accessor, index)?;
        // Bounds refer to the stored numbers.
        layout.normalized = false;
        let (width, size) = (layout.width, layout.component.size());
        let elements = self.read(index, accessor, layout, [0.0; 4], |bytes| {
            std::array::from_fn(|k| {
                if k < width {
                    layout.number(&bytes[k * size..])
                } else {
                    0.0
                }
            })
        })?;
        let mut bounds = (vec![f32::INFINITY; width], vec![f32::NEG_INFINITY; width]);
        for element in elements {
            for ((least, most), v) in bounds.0.iter_mut().zip(&mut bounds.1).zip(element) {
                (*least, *most) = (least.min(v), most.max(v));
            }
        }
        Ok(bounds)
    }

    /// The least and the largest of all numbers of an accessor and 0; NaN where one is not finite.
    pub fn range(&self, index: usize) -> Result<(f32, f32), GltfProblem> {
        let accessor = get(&self.root.accessors, index, "accessor")?;
        let layout = AccessorLayout::of(accessor, index)?;
        let (width, size) = (layout.width, layout.component.size());
        let elements = self.read(index, accessor, layout, (0.0, 0.0), |bytes| {
            let mut range = (f32::INFINITY, f32::NEG_INFINITY);
            for v in (0..width).map(|k| layout.number(&bytes[k * size..])) {
                if !v.is_finite() {
                    return (f32::NAN, f32::NAN);
                }
                range = (range.0.min(v), range.1.max(v));
            }
            range
        })?;
        let join = |(a, b): (f32, f32), (c, d): (f32, f32)| match c.is_nan() || a.is_nan() {
            true => (f32::NAN, f32::NAN),
            false => (a.min(c), b.max(d)),
        };
        Ok(elements.into_iter().fold((0.0, 0.0), join))
    }

    /// The last rows of the matrices of an accessor.
    pub fn matrix_bottoms(&self, index: usize) -> Result<Vec<[f32; 4]>, GltfProblem> {
        let accessor = get(&self.root.accessors, index, "accessor")?;
        let layout = AccessorLayout::of_matrices(accessor, index)?;
        self.read(index, accessor, layout, [0.0, 0.0, 0.0, 1.0], |bytes| {
            std::array::from_fn(|k| layout.number(&bytes[16 * k + 12..]))
        })
    }

    /// An accessor of `N` numbers an element.
    pub fn floats<const N: usize>(&self, index: usize) -> Result<Vec<[f32; N]>, GltfProblem> {
        let accessor = get(&self.root.accessors, index, "accessor")?;
        let layout = AccessorLayout::of(accessor, index)?;
        if layout.width != N {
            let width = layout.width;
            return Err(GltfProblem::broken(format!(
                "accessor {index} has {width} numbers an element instead of {N}"
            )));
        }
        let size = layout.component.size();
        self.read(index, accessor, layout, [0.0; N], |bytes| {
            std::array::from_fn(|k| layout.number(&bytes[k * size..]))
        })
    }

    /// The numbers of all elements of an accessor of `width` numbers an element, in a row.
    pub fn numbers(&self, index: usize, width: usize) -> Result<Vec<f32>, GltfProblem> {
        Ok(match width {
            4 => self.floats::<4>(index)?.into_flattened(),
            3 => self.floats::<3>(index)?.into_flattened(),
            2 => self.floats::<2>(index)?.into_flattened(),
            _ => self.floats::<1>(index)?.into_flattened(),
        })
    }

    /// An accessor of vertex numbers.
    pub fn indices(&self, index: usize) -> Result<Vec<u32>, GltfProblem> {
        let accessor = get(&self.root.accessors, index, "accessor")?;
        let layout = AccessorLayout::of(accessor, index)?;
        if layout.width != 1 || !is_unsigned(layout.component) {
            return Err(GltfProblem::broken(format!("accessor {index} cannot hold indices")));
        }
        self.read(index, accessor, layout, 0, unsigned)
    }

    fn read<T: Clone>(
        &self,
        index: usize,
        accessor: &Accessor,
        layout: AccessorLayout,
        zero: T,
        element: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, GltfProblem> {
        let (count, size) = (layout.count, layout.element());
        let memory = |count: usize| self.reserve((count as u64).saturating_mul(size_of::<T>() as u64));
        let mut values = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.map_or(0, |o| o.0);
                let what = || format!("accessor {index}");
                let found = elements(self.view(view.value())?, offset, (count, size), what)?;
                memory(count)?;
                found.map(&element).collect()
            }
            None if count > MOST_ZEROS => {
                return Err(GltfProblem::broken(format!(
                    "accessor {index} has {count} elements but no buffer view"
                )));
            }
            None => {
                memory(count)?;
                vec![zero; count]
            }
        };
        if let Some(sparse) = &accessor.sparse {
            self.replace(index, sparse, size, &mut values, element)?;
        }
        Ok(values)
    }

    /// Replaces the elements that a sparse accessor lists.
    fn replace<T>(
        &self,
        index: usize,
        sparse: &Sparse,
        size: usize,
        values: &mut [T],
        element: impl Fn(&[u8]) -> T,
    ) -> Result<(), GltfProblem> {
        let what = || format!("the sparse part of accessor {index}");
        let Checked::Valid(component) = sparse.indices.component_type else {
            return Err(GltfProblem::broken(format!(
                "{} has indices of an unknown type",
                what()
            )));
        };
        let count = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
        let (indices, offset) = (&sparse.indices, sparse.indices.byte_offset.0);
        let at = elements(
            self.view(indices.buffer_view.value())?,
            offset,
            (count, component.0.size()),
            what,
        )?;
        let (new, offset) = (&sparse.values, sparse.values.byte_offset.0);
        let new = elements(self.view(new.buffer_view.value())?, offset, (count, size), what)?;
        for (at, new) in at.zip(new) {
            let at = unsigned(at) as usize;
            let place = values
                .get_mut(at)
                .ok_or_else(|| GltfProblem::broken(format!("{} names element {at}, which is not there", what())))?;
            *place = element(new);
        }
        Ok(())
    }
}

fn is_unsigned(component: ComponentType) -> bool {
    matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32)
}

/// A whole number of one, two or four bytes.
fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |v, b| v << 8 | u32::from(*b))
}
