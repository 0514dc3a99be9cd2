//! Lamps with a measured distribution of their light, in the world.

use std::f32::consts::PI;

use super::{
    LightFind, OrientationCone, Sidedness, aim,
    profile::{Profile, ProfileId},
    tables::LightTables,
};
use crate::{
    math::{Vec3, trig},
    value::{Direction, Problem, Spanned},
};

/// The strength of a beam.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BeamScale {
    /// The intensities of the file.
    File,
    /// All light of the file together is 1 W.
    Power,
    /// All light that leaves the front of the lamp is 1 W.
    FrontPower,
}

/// The file of a lamp's profile.
#[derive(Clone, Copy, Debug)]
pub struct IesFile<'a> {
    /// Its path, relative to the scene file.
    pub name: &'a Spanned<String>,
    /// The sides of the lamp that shine.
    pub sidedness: Sidedness,
}

impl IesFile<'_> {
    /// Whether all light of the file, which has this profile, goes where the lamp does not shine.
    pub fn is_dark(&self, profile: &Profile) -> bool {
        self.sidedness == Sidedness::Front && profile.front_power() < f32::MIN_POSITIVE
    }
}

/// A profile, turned to the world.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    profile: ProfileId,
    scale: BeamScale,
    /// Unit vectors: to the right as seen along the axis, up, and the axis in which the lamp shines.
    frame: [Vec3; 3],
}

impl Beam {
    /// The beam of a lamp that shines along the unit `axis`, with `up` above, if it has a file.
    ///
    /// # Errors
    /// There is no such file.
    pub(super) fn new(
        ies: &Option<Spanned<String>>,
        (axis, up): (Vec3, Option<Direction>),
        scale: BeamScale,
        find: &LightFind<'_>,
    ) -> Result<Option<Self>, Problem> {
        let Some(file) = ies else {
            return Ok(None);
        };
        let [right, up] = aim::across(axis, up);
        Ok(Some(Self {
            profile: (find.profile)(file)?,
            scale,
            frame: [right.as_vec3(), up.as_vec3(), axis],
        }))
    }

    fn profile<'a>(&self, tables: &LightTables<'a>) -> &'a Profile {
        &tables.profiles[self.profile.0 as usize]
    }

    /// The factor of the profile's intensities.
    #[inline]
    fn factor(&self, profile: &Profile) -> f32 {
        let power = match self.scale {
            BeamScale::File => return 1.0,
            BeamScale::Power => profile.power(),
            BeamScale::FrontPower => profile.front_power(),
        };
        // A lamp that shines backwards only has no light at its front.
        if power >= f32::MIN_POSITIVE { 1.0 / power } else { 0.0 }
    }

    /// The intensity in the unit direction `w`, in W sr^-1 with the scale of the file, else in sr^-1.
    #[inline]
    pub(super) fn intensity(&self, tables: &LightTables<'_>, w: Vec3) -> f32 {
        let profile = self.profile(tables);
        let local = Vec3::from_array(self.frame.map(|axis| axis.dot(w)));
        profile.intensity(local) * self.factor(profile)
    }

    /// The largest intensity.
    pub(super) fn max_intensity(&self, tables: &LightTables<'_>) -> f32 {
        let profile = self.profile(tables);
        profile.cone().max * self.factor(profile)
    }

    /// The directions of the light, up to an angle to the axis in radians.
    pub(super) fn directions(&self, tables: &LightTables<'_>, most: f32) -> OrientationCone {
        let cone = self.profile(tables).cone();
        let axis = self.frame[2];
        if most < PI && cone.is_backward {
            return OrientationCone {
                cos_o: trig::cos(most),
                cos_e: 1.0,
                ..OrientationCone::flat(axis, Sidedness::Front)
            };
        }
        let end = cone.end.min(most);
        OrientationCone {
            axis: if cone.is_backward { -axis } else { axis },
            cos_o: trig::cos(cone.full.min(end)),
            cos_e: trig::cos((end - cone.full).max(0.0)),
            sidedness: Sidedness::Front,
        }
    }
}

#[cfg(test)]
mod tests;
