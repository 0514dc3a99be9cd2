//! The directions of lights that point somewhere.

use crate::{
    math::{DVec3, Vec3},
    value::{Direction, Point, Problem, Spanned},
};

/// The unit axis of a light at `position`, by the one of the two that is given.
///
/// # Errors
/// Both are given or none, or `target` is at `position`.
pub(super) fn axis(
    kind: &str,
    position: &Spanned<Point>,
    target: &Option<Spanned<Point>>,
    direction: &Option<Spanned<Direction>>,
) -> Result<Vec3, Problem> {
    match (target, direction) {
        (Some(target), None) => (target.get_ref().0 - position.get_ref().0)
            .try_normalize()
            .map(|d| d.as_vec3())
            .ok_or_else(|| Problem::at(target.span(), "`target` lies at `position`")),
        (None, Some(direction)) => Ok(direction.get_ref().0),
        (Some(_), Some(direction)) => Err(Problem::at(direction.span(), "`target` and `direction` are both given")),
        (None, None) => {
            let message = format!("a {kind} needs `target` or `direction`");
            Err(Problem::at(position.span(), message))
        }
    }
}

/// Unit vectors to the right and upwards, as seen along the unit `axis` with `up` above.
pub(super) fn across(axis: Vec3, up: Option<Direction>) -> [DVec3; 2] {
    let axis = axis.as_dvec3().normalize_or(DVec3::NEG_Y);
    // For an axis along `up`, -z is above.
    let up = up.map_or(DVec3::Y, |up| up.0.as_dvec3());
    let right = axis.cross(up);
    let right = if right.length() > 1e-4 {
        right
    } else {
        axis.cross(DVec3::NEG_Z)
    };
    let right = if right.length() > 1e-4 {
        right
    } else {
        axis.cross(DVec3::X)
    };
    let right = right.normalize();
    [right, right.cross(axis)]
}
