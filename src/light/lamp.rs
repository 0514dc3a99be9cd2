//! The common part of lights with a surface.
//!
//! They are no objects: they block no ray and cast no shadow. Light sampling finds them as any light; rays of the path that
//! meet their surface find them too ([`LightKind::seen`]), and pass on.

use std::f32::consts::{FRAC_PI_2, PI};

use super::{
    AreaBlock, LightBounds, LightKind, LightSample, LightTables, OrientationCone, PictureMap, Sidedness,
    area::{self, AreaSample},
    beam::{Beam, BeamScale},
    focus::Focus,
    is_facing,
    picture::{Picture, Screen},
};
use crate::{
    math::{Ray, Rgb, Vec2, Vec3, WorkingSpace},
    shape::{Shape, ShapeHit},
    value::{Finite, Problem, RgbFactor, Span, Spanned, Stops, UnitInterval},
};

/// The rays that find the surface of a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sight {
    /// Rays that come straight from the camera.
    pub camera: bool,
    /// Rays that a surface reflects or transmits.
    pub reflections: bool,
}

/// Declares the description of a light with a surface: its own keys, and those that all of them have.
macro_rules! lamp_desc {
    ($(#[$meta:meta])* pub struct $Name:ident { $( $(#[$own:meta])* pub $key:ident: $Type:ty, )* }) => {
        $(#[$meta])*
        #[derive(Clone, Debug, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct $Name {
            $( $(#[$own])* pub $key: $Type, )*
            pub power: Option<$crate::value::RgbFactor>,
            pub radiance: Option<$crate::value::RgbFactor>,
            pub temperature: Option<$crate::value::Spanned<$crate::value::Finite>>,
            pub exposure: Option<$crate::value::Stops>,
            #[serde(default)]
            pub camera: bool,
            pub reflections: Option<bool>,
        }

        impl $Name {
            /// The keys that all lights with a surface have; `span` is where the light is described.
            fn glow(&self, span: $crate::value::Span) -> $crate::light::lamp::Glow<'_> {
                $crate::light::lamp::Glow {
                    span,
                    power: self.power,
                    radiance: self.radiance,
                    temperature: &self.temperature,
                    exposure: self.exposure,
                    sight: $crate::light::lamp::Sight {
                        camera: self.camera,
                        reflections: self.reflections.unwrap_or(true),
                    },
                }
            }
        }
    };
}

pub(super) use lamp_desc;

/// The cosine from the normal below which the light of a file fades: within half a degree of its plane a flat surface is too narrow
/// for the intensity of the file.
const MIN_BEAM_COS: f32 = 0.01;

/// The largest extent of a light, in m. At ten thousand times this size single precision loses its position and half of its light.
const MAX_SIZE: f32 = 1e8;

/// The sides of a surface that emit, their directions and the picture that they show.
pub(super) struct Outlet<'a> {
    pub sidedness: Sidedness,
    /// The concentration about the normal of a surface that fills a rectangle.
    pub spread: Option<(&'a Spanned<UnitInterval>, Screen)>,
    /// The distribution of a file, by its scale.
    pub beam: Option<&'a dyn Fn(BeamScale) -> Result<Option<Beam>, Problem>>,
    /// The picture that it shows.
    pub picture: Option<Picture>,
}

impl Outlet<'_> {
    /// Outwards, the same in all directions.
    pub const PLAIN: Self = Self {
        sidedness: Sidedness::Front,
        spread: None,
        beam: None,
        picture: None,
    };
}

/// The description of the light that a surface emits.
pub(super) struct Glow<'a> {
    pub span: Span,
    pub power: Option<RgbFactor>,
    pub radiance: Option<RgbFactor>,
    pub temperature: &'a Option<Spanned<Finite>>,
    pub exposure: Option<Stops>,
    pub sight: Sight,
}

impl Glow<'_> {
    /// The lamp of this surface.
    ///
    /// # Errors
    /// The light has no strength or two, it is too small, or its temperature is out of range.
    pub fn lamp(self, shape: Shape, outlet: &Outlet<'_>) -> Result<Lamp, Problem> {
        if shape.area() < f32::MIN_POSITIVE {
            return Err(without_area(self.span));
        }
        let bounds = shape.bounds();
        if (bounds.max - bounds.min).max_element() > MAX_SIZE {
            let problem = Problem::at(self.span, format!("the light is too large: at most {MAX_SIZE:e} m"));
            return Err(problem.with_help("light from one side is a `sun`, and from all sides the background"));
        }
        let factor = super::temperature::factor(self.temperature, self.exposure)?;
        let sidedness = outlet.sidedness;
        let (scale, sides) = match (self.power, sidedness) {
            (None, _) => (BeamScale::File, 1.0),
            (Some(_), Sidedness::Both) => (BeamScale::Power, 2.0),
            (Some(_), Sidedness::Front) => (BeamScale::FrontPower, 1.0),
        };
        let beam = outlet.beam.map_or(Ok(None), |beam| beam(scale))?;
        let radiance = match (self.power, self.radiance) {
            (_, Some(_)) if beam.is_some() => {
                let message = "a light with `ies` has no `radiance`";
                return Err(Problem::at(self.span, message).with_help("change its strength by `exposure` or `power`"));
            }
            (power, _) if beam.is_some() => power.map_or(Rgb::WHITE, |power| power.0) / shape.area(),
            (Some(power), None) => power.0 / (PI * shape.area() * sides),
            (None, Some(radiance)) => radiance.0,
            (None, None) => return Err(Problem::at(self.span, "give its strength by `power` or by `radiance`")),
            (Some(_), Some(_)) => return Err(Problem::at(self.span, "`power` and `radiance` are both given")),
        };
        if let Some((spread, _)) = outlet.spread.filter(|_| beam.is_some()) {
            return Err(Problem::at(spread.span(), "`spread` and `ies` are both given"));
        }
        Ok(Lamp {
            shape,
            radiance: radiance * factor,
            sidedness,
            focus: outlet
                .spread
                .and_then(|(spread, screen)| Focus::new(spread.get_ref().0, screen)),
            picture: outlet.picture.map(|picture| Picture {
                keeps_power: self.power.is_some() || beam.is_some(),
                ..picture
            }),
            beam,
            sight: self.sight,
        })
    }
}

/// The problem of a light whose surface is too small, described at `span`.
pub(super) fn without_area(span: Span) -> Problem {
    let problem = Problem::at(span, "the light has no area: it is too small for its place");
    problem.with_help("make it larger, or write a light of the kind `point`")
}

/// A light with a surface, which emits alike everywhere unless it shows a picture.
#[derive(Clone, Copy, Debug)]
pub struct Lamp {
    shape: Shape,
    /// In W m^-2 sr^-1, without focus; with a beam the radiance by its intensity, in m^-2.
    radiance: Rgb,
    sidedness: Sidedness,
    focus: Option<Focus>,
    beam: Option<Beam>,
    picture: Option<Picture>,
    sight: Sight,
}

impl Lamp {
    /// The radiance in the unit direction `w` with this cosine from the normal, in W m^-2 sr^-1.
    #[inline]
    fn towards(&self, tables: &LightTables<'_>, front_cos: f32, w: Vec3) -> Rgb {
        let cos = if self.sidedness == Sidedness::Both {
            front_cos.abs()
        } else {
            front_cos
        };
        if cos <= 0.0 {
            return Rgb::BLACK;
        }
        match (&self.focus, &self.beam) {
            (None, None) => self.radiance,
            (Some(focus), _) => self.radiance * focus.factor(w),
            // Seen from afar the surface has the intensity of the beam.
            (None, Some(beam)) => self.radiance * (beam.intensity(tables, w) / cos.max(MIN_BEAM_COS)),
        }
    }

    /// The picture with its light.
    #[inline]
    fn shown<'a>(&self, tables: &LightTables<'a>) -> Option<(&Picture, &'a PictureMap)> {
        self.picture.as_ref().zip(tables.picture)
    }

    /// The factor of the radiance at a point of the surface.
    #[inline]
    fn tint(&self, tables: &LightTables<'_>, p: Vec3) -> Option<Rgb> {
        let (picture, map) = self.shown(tables)?;
        Some(picture.factor(&tables.textures, map, p))
    }

    /// Samples a point of the surface as it is seen from `from`.
    #[inline]
    fn sample_point(&self, tables: &LightTables<'_>, from: Vec3, u: Vec2) -> Option<AreaSample> {
        let of_focus = self.focus.as_ref().and_then(|focus| focus.sample(from, u));
        let of_picture = || {
            self.shown(tables)
                .and_then(|(picture, map)| picture.sample(map, from, u))
        };
        let chosen = of_focus.or_else(of_picture);
        chosen.unwrap_or_else(|| area::sample_shape(&self.shape, None, from, u).map(|(point, _)| point))
    }

    /// The point of the surface whose parallel beam meets `from`.
    fn foot(&self, focus: &Focus, from: Vec3) -> Option<AreaSample> {
        let shines = |point: &AreaSample| self.sidedness == Sidedness::Both || point.front_cos(from) > 0.0;
        focus.foot(from).filter(shines)
    }

    /// The light of a parallel beam.
    fn sample_beam(&self, tables: &LightTables<'_>, focus: &Focus, from: Vec3) -> Option<LightSample> {
        let point = self.foot(focus, from)?;
        // All light of a square metre goes through a square metre.
        let irradiance = self.radiance * PI;
        let tint = self.tint(tables, point.p);
        let li = tint.map_or(irradiance, |tint| irradiance * tint);
        let sample = point.light(from, li).filter(|_| !li.is_black())?;
        Some(LightSample { pdf: None, ..sample })
    }

    /// The focus of a parallel beam, if it has one.
    #[inline]
    fn parallel(&self) -> Option<&Focus> {
        self.focus.as_ref().filter(|focus| focus.is_parallel())
    }

    /// The directions of the light, and the largest intensity there, of a flat surface.
    fn flat_bounds(&self, tables: &LightTables<'_>, normal: Vec3) -> (OrientationCone, f32) {
        let flat = OrientationCone::flat(normal, self.sidedness);
        let Some(beam) = &self.beam else {
            let widest = self.focus.map_or(0.0, |focus| focus.widest());
            let directions = OrientationCone { cos_e: widest, ..flat };
            return (directions, self.towards(tables, 1.0, normal).mean() * self.shape.area());
        };
        let largest = self.radiance.mean() * self.shape.area() * beam.max_intensity(tables);
        // One side is dark, whatever the file says.
        let most = if self.sidedness == Sidedness::Both {
            PI
        } else {
            FRAC_PI_2
        };
        (beam.directions(tables, most), largest)
    }
}

impl LightKind for Lamp {
    #[inline]
    fn sample(&self, tables: &LightTables<'_>, from: Vec3, u: Vec2) -> Option<LightSample> {
        if let Some(focus) = self.parallel() {
            return self.sample_beam(tables, focus, from);
        }
        let point = self.sample_point(tables, from, u)?;
        sample_surface(&point, from, self.sight, |cos, wi| {
            let radiance = self.towards(tables, cos, -wi);
            if radiance.is_black() {
                return radiance;
            }
            self.tint(tables, point.p).map_or(radiance, |tint| radiance * tint)
        })
    }

    fn bounds(&self, tables: &LightTables<'_>) -> Option<LightBounds> {
        if self.parallel().is_some() {
            return None;
        }
        let bounds = self.shape.bounds();
        let Some(normal) = self.shape.flat_normal() else {
            // The mean projected area of a convex body is a quarter of its surface (Cauchy).
            return Some(LightBounds {
                bounds,
                directions: OrientationCone::ALL,
                power: self.radiance.mean() * self.shape.area() * 0.25,
            });
        };
        let (directions, power) = self.flat_bounds(tables, normal);
        let power = self
            .shown(tables)
            .map_or(power, |(picture, map)| power * picture.mean_factor(map));
        Some(LightBounds {
            bounds,
            directions,
            power,
        })
    }

    fn reaches(&self, p: Vec3, n: Vec3) -> bool {
        self.parallel().is_none_or(|focus| {
            let point = self.foot(focus, p);
            point.is_some_and(|point| is_facing(n, point.p - p))
        })
    }

    fn strength(&self) -> (Rgb, &'static str) {
        (self.radiance, "W m^-2 sr^-1")
    }

    fn convert_colors(&mut self, space: WorkingSpace) {
        self.radiance = space.from_rec709(self.radiance);
    }

    fn has_size(&self) -> bool {
        self.parallel().is_none()
    }

    fn surface(&self) -> Option<(Shape, Sight)> {
        self.has_size().then_some((self.shape, self.sight))
    }

    #[inline]
    fn seen(&self, tables: &LightTables<'_>, from: Vec3, w: Vec3, hit: &ShapeHit) -> (Rgb, f32) {
        let (radiance, pdf) = see_surface(&self.shape, from, w, hit, |cos| self.towards(tables, cos, -w));
        let p = from + w * hit.t;
        let of_focus = self.focus.as_ref().and_then(|focus| focus.pdf(from, p));
        let Some((picture, map)) = self.shown(tables) else {
            return (radiance, of_focus.unwrap_or(pdf));
        };
        let tint = picture.factor(&tables.textures, map, p);
        let chosen = of_focus.or_else(|| picture.pdf(map, from, p));
        (radiance * tint, chosen.unwrap_or(pdf))
    }

    fn picture(&self) -> Option<&Picture> {
        self.picture.as_ref()
    }

    #[inline]
    fn put_in_block(&self, lane: usize, block: &mut AreaBlock) -> bool {
        let is_even = self.focus.is_none() && self.beam.is_none() && self.picture.is_none();
        let is_plain = is_even && self.sight.reflections;
        block.set_emission(lane, self.radiance, self.sidedness);
        is_plain && self.shape.put_in_block(lane, &mut block.points)
    }
}

/// The light at `from` of a sampled point of a surface; `radiance` is that at a cosine from the normal and against
/// the unit direction to the light.
///
/// Where rays of reflections do not find the surface, light sampling must find all of its light, so that the sample
/// has no density to weigh it against.
#[inline]
pub(super) fn sample_surface(
    point: &AreaSample,
    from: Vec3,
    sight: Sight,
    radiance: impl Fn(f32, Vec3) -> Rgb,
) -> Option<LightSample> {
    let sample = point.light(from, Rgb::BLACK)?;
    let li = radiance(-point.ng.dot(sample.wi), sample.wi);
    let (li, pdf) = if sight.reflections {
        (li, sample.pdf)
    } else {
        (li / point.pdf, None)
    };
    (!li.is_black()).then_some(LightSample { li, pdf, ..sample })
}

/// The radiance that a surface sends to `from` from the hit of the ray along the unit direction `w`, and the density with which
/// [`area::sample_shape`] samples `w`, in sr^-1; `radiance` is that at a cosine from the normal.
#[inline]
pub(super) fn see_surface(
    shape: &Shape,
    from: Vec3,
    w: Vec3,
    hit: &ShapeHit,
    radiance: impl Fn(f32) -> Rgb,
) -> (Rgb, f32) {
    let ng = shape.surface(&Ray::new(from, w), hit).ng;
    (radiance(-ng.dot(w)), area::pdf_shape(shape, None, from, w, hit))
}

#[cfg(test)]
mod tests;
