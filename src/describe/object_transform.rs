//! The place of an object.

use serde::Deserialize;

use super::rotation::RotationDesc;
use crate::{
    math::{DAffine3, DMat3, DVec3, Transform, transform},
    value::{Coordinate, List, OneOrEach, Point, Problem, Span},
};

/// An object's place: `scale` first, then `rotate` (degrees about the fixed x, y and z axes in this order), then
/// `translate` (m); or `matrix`, four rows of four numbers, the last `0 0 0 1`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TransformDesc {
    translate: Option<Point>,
    rotate: Option<RotationDesc>,
    pub(super) scale: Option<OneOrEach<Coordinate, 3>>,
    matrix: Option<List<List<Coordinate, 4>, 4>>,
}

impl TransformDesc {
    /// Returns the map from the object's own space to the world, which has an inverse.
    pub fn compile(&self, span: Span) -> Result<DAffine3, Problem> {
        if self.matrix.is_some() && (self.translate.is_some() || self.rotate.is_some() || self.scale.is_some()) {
            let message = "`matrix` stands alone, without `translate`, `rotate` and `scale`";
            return Err(Problem::at(span, message));
        }
        let map = match &self.matrix {
            Some(rows) => transform::from_rows(rows.0.map(|row| row.0.map(|v| v.0))),
            None => {
                let rotation = self.rotate.unwrap_or_default().matrix();
                let scale = self.scale.map_or(DVec3::ONE, |s| DVec3::from(s.0.map(|v| v.0)));
                Some(DAffine3 {
                    matrix3: rotation * DMat3::from_diagonal(scale),
                    translation: self.translate.map_or(DVec3::ZERO, |p| p.0),
                })
            }
        };
        map.filter(|map| Transform::new(*map).is_some()).ok_or_else(|| {
            Problem::at(span, "the transform has no inverse").with_help("it flattens its object; no scale may be 0")
        })
    }
}
