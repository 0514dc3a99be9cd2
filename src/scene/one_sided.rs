//! Surfaces whose backs are black or not there, in a scene.

use super::{BackFaces, ObjectBackFaces, ObjectId, Scene, SurfaceInteraction, two_sided_reason};
use crate::{geometry::Hit, material::MaterialId, math::Ray};

impl Scene {
    /// Whether rays pass the backs of some surfaces.
    pub fn culls_backs(&self) -> bool {
        self.used_backs.culled
    }

    /// Whether the backs of some surfaces are black.
    pub fn has_black_backs(&self) -> bool {
        self.used_backs.black
    }

    /// Whether a ray meets a back that is not there.
    #[inline]
    pub fn is_culled(&self, ray: &Ray, hit: &Hit) -> bool {
        self.used_backs.culled && self.meets_back(BackFaces::Culled, ray, hit)
    }

    /// Whether a ray meets a back that is black.
    #[inline]
    pub fn is_black_back(&self, ray: &Ray, hit: &Hit) -> bool {
        self.used_backs.black && self.meets_back(BackFaces::Black, ray, hit)
    }

    /// Gives the surface the material of black backs, if the viewer sees one.
    pub(crate) fn blacken_back(&self, surface: &mut SurfaceInteraction) {
        if surface.ng.dot(surface.wo) < 0.0
            && self.back_faces(surface.object, surface.material) == BackFaces::Black
            && let Some(black) = self.shading.black
        {
            surface.material = black;
        }
    }

    fn meets_back(&self, backs: BackFaces, ray: &Ray, hit: &Hit) -> bool {
        self.back_faces(self.object_of(hit), self.material_of(hit)) == backs && {
            let surface = self.surface(ray, hit);
            surface.ng.dot(surface.wo) < 0.0
        }
    }

    /// The backs of surfaces of this object and this material.
    fn back_faces(&self, object: ObjectId, material: MaterialId) -> BackFaces {
        let of_material = self.shading.back_faces.get(material.0 as usize);
        let of_material = of_material.copied().unwrap_or_default();
        let backs = match self.geometry.objects[object.0 as usize].back_faces {
            None => of_material.own,
            Some(ObjectBackFaces::Shaded) => BackFaces::Shaded,
            Some(ObjectBackFaces::Black) => BackFaces::Black,
            Some(ObjectBackFaces::Culled) => BackFaces::Culled,
            Some(ObjectBackFaces::File) => of_material.in_file,
        };
        match two_sided_reason(self.material(material)) {
            Some(_) => BackFaces::Shaded,
            None => backs,
        }
    }
}
