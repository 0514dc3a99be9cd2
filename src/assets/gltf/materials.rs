//! Materials: metallic-roughness and its extensions.
//!
//! Sources: Khronos, "glTF 2.0 Specification", section 3.9, and the texts of the KHR_materials extensions.

use std::{
    collections::{HashMap, HashSet},
    path::Path,
};

use ::gltf::json::Value;

use super::{
    document::{Document, get},
    error::GltfProblem,
    json::{number, numbers, unit},
    textures::{self, ModelImages, UvSets, uv_set},
};
use crate::{
    assets::{
        model::{Model, ModelMaterial, Treatment, UvSet},
        motion::{MaterialMotion, TextureMotion},
    },
    bsdf::layered::Boundary,
    material::{
        Sidedness, TangentNormals, medium,
        principled::{AlphaMode, Principled},
    },
    math::{Rgb, sorting},
    texture::{Color, Scalar, TextureId, bitmap::ColorSpace},
    value::{Channel, unique_names},
};

/// An index of refraction with nearly total reflection at normal incidence.
const MIRROR_IOR: f32 = 1e4;

/// The materials of the document that are used, each once.
#[derive(Default)]
pub(super) struct ModelMaterials {
    materials: HashMap<Option<usize>, usize>,
    images: ModelImages,
    /// The references to textures whose transforms are animated, by their materials and keys.
    animated: HashSet<(usize, &'static str)>,
    textures: HashMap<(usize, &'static str), TextureMotion>,
}

/// The materials and textures of a document that animations change.
#[derive(Default)]
pub(super) struct MovingLooks {
    pub materials: Vec<MaterialMotion>,
    /// The place of each material by its number in the document.
    pub material_places: HashMap<usize, usize>,
    pub textures: Vec<TextureMotion>,
    /// The place of each texture by the material and the key of its reference.
    pub texture_places: HashMap<(usize, &'static str), usize>,
}

/// A material of the document.
fn raw<'a>(document: &'a Document<'_>, material: Option<usize>) -> Result<&'a Value, GltfProblem> {
    let Some(index) = material else {
        return Ok(&Value::Null);
    };
    get(&document.root.materials, index, "material")?;
    Ok(&document.raw["materials"][index])
}

/// The unique names of all materials.
pub(super) fn names(document: &Document<'_>) -> Vec<String> {
    let materials = document.root.materials.iter();
    unique_names(materials.map(|material| material.name.as_deref().unwrap_or_default()))
}

/// The sets of texture coordinates that a material reads.
pub(super) fn uv_sets(document: &Document<'_>, material: Option<usize>) -> Result<UvSets, GltfProblem> {
    let raw = raw(document, material)?;
    // The set of the base colour comes first: of more than two sets it is kept.
    let base = raw.pointer("/pbrMetallicRoughness/baseColorTexture").map(uv_set);
    let mut sets: Vec<u32> = base.into_iter().collect();
    texture_infos(raw, &mut sets);
    let first = sets.first().copied().unwrap_or(0);
    Ok(UvSets {
        first,
        second: sets.into_iter().find(|set| *set != first),
    })
}

/// The texture coordinates for the tangents of a material: those of its normal map, else of its coat's, else of its anisotropy;
/// `None` if it needs no tangents.
pub(super) fn tangent_set(
    document: &Document<'_>,
    material: Option<usize>,
    sets: UvSets,
) -> Result<Option<UvSet>, GltfProblem> {
    let raw = raw(document, material)?;
    let brushed = raw.pointer("/extensions/KHR_materials_anisotropy");
    let coat = raw.pointer("/extensions/KHR_materials_clearcoat/clearcoatNormalTexture");
    let number = match (raw.get("normalTexture").or(coat), brushed) {
        (Some(map), _) => uv_set(map),
        (None, Some(brushed)) => brushed.get("anisotropyTexture").map_or(sets.first, uv_set),
        (None, None) => return Ok(None),
    };
    Ok(Some(sets.of(number).unwrap_or_default()))
}

/// Collects the sets of all texture references in a material. Recursion ends: the JSON reader accepts 128 levels at the most.
pub(super) fn texture_infos(value: &Value, sets: &mut Vec<u32>) {
    let Value::Object(map) = value else { return };
    for (key, value) in map {
        match key.as_str() {
            "occlusionTexture" | "thicknessTexture" | "extras" => {}
            _ if key.ends_with("Texture") => sets.push(uv_set(value)),
            _ => texture_infos(value, sets),
        }
    }
}

/// Converts a material.
struct Reader<'a, 'b> {
    document: &'a Document<'b>,
    images: &'a mut ModelImages,
    number: Option<usize>,
    animated: &'a HashSet<(usize, &'static str)>,
    textures: &'a mut HashMap<(usize, &'static str), TextureMotion>,
    sets: UvSets,
    path: &'a Path,
    model: &'a mut Model,
}

impl Reader<'_, '_> {
    fn texture(&mut self, from: &Value, key: &str, space: ColorSpace) -> Result<Option<TextureId>, GltfProblem> {
        let Some(info) = from.get(key) else { return Ok(None) };
        if self.sets.of(uv_set(info)).is_none() {
            let first = "a material reads two sets of texture coordinates at most, and this is a third";
            self.model.add_feature(key, "material", Treatment::InPart(first));
        }
        let is_it = |(material, own): &&(usize, &'static str)| Some(*material) == self.number && *own == key;
        let animated = self.animated.iter().find(is_it).copied();
        if let Some(known) = animated.and_then(|animated| self.textures.get(&animated)) {
            return Ok(Some(TextureId(known.texture as u32)));
        }
        let placed = self
            .images
            .place(
                self.document,
                (info, animated.is_some()),
                self.sets,
                space,
                self.path,
                self.model,
            )
            .map_err(|e| e.within(key))?;
        if let (Some(animated), Some(id)) = (animated, placed) {
            self.textures.insert(animated, textures::motion(info, id));
        }
        Ok(placed)
    }

    /// A colour times a texture's.
    fn color(&mut self, from: &Value, factor: &str, default: f32, texture: &str) -> Result<Color, GltfProblem> {
        let factor = Rgb::from_array(numbers(from, factor, [default; 3]).map(|v| v.max(0.0)));
        Ok(match self.texture(from, texture, ColorSpace::Srgb)? {
            None => Color::Constant(factor),
            Some(id) => Color::Tinted(id, factor),
        })
    }

    /// A number from 0 to 1 times the channel of a texture.
    fn scalar(
        &mut self,
        from: &Value,
        (factor, default): (&str, f32),
        texture: &str,
        channel: Channel,
    ) -> Result<Scalar, GltfProblem> {
        let factor = unit(from, factor, default);
        Ok(match self.texture(from, texture, ColorSpace::Raw)? {
            None => Scalar::Constant(factor),
            Some(id) => Scalar::Texture(id, channel, factor),
        })
    }

    fn surface(&mut self, material: &Value) -> Result<Principled, GltfProblem> {
        let none = Value::Null;
        let pbr = material.get("pbrMetallicRoughness").unwrap_or(&none);
        let metallic_roughness = "metallicRoughnessTexture";
        let mut surface = Principled {
            base_color: self.color(pbr, "baseColorFactor", 1.0, "baseColorTexture")?,
            metallic: self.scalar(pbr, ("metallicFactor", 1.0), metallic_roughness, Channel::B)?,
            roughness: self.scalar(pbr, ("roughnessFactor", 1.0), metallic_roughness, Channel::G)?,
            emissive: self.color(material, "emissiveFactor", 0.0, "emissiveTexture")?,
            normal: self
                .texture(material, "normalTexture", ColorSpace::Raw)?
                .map(Color::Texture),
            normal_scale: number(&material["normalTexture"], "scale", 1.0),
            alpha_mode: match material.get("alphaMode").and_then(Value::as_str) {
                None | Some("OPAQUE") => AlphaMode::Opaque,
                Some("MASK") => AlphaMode::Mask(number(material, "alphaCutoff", 0.5)),
                Some("BLEND") => AlphaMode::Blend,
                Some(other) => return Err(GltfProblem::broken(format!("the alpha mode {other} is unknown"))),
            },
            sidedness: match material.get("doubleSided").and_then(Value::as_bool) {
                Some(true) => Sidedness::Both,
                _ => Sidedness::Front,
            },
            ..Principled::default()
        };
        let [.., alpha] = numbers(pbr, "baseColorFactor", [1.0; 4]);
        surface.opacity = opacity(&surface.base_color, alpha);
        if surface.sidedness == Sidedness::Front {
            let why = Treatment::Unneeded("both sides are seen, unless its object has back_faces = \"file\"");
            self.model.add_feature("doubleSided = false", "material", why);
        }
        if material.get("occlusionTexture").is_some() {
            let why = Treatment::Unneeded("paths find the light in corners themselves");
            self.model.add_feature("occlusionTexture", "material", why);
        }
        let extensions = material.get("extensions").unwrap_or(&none);
        self.layers(extensions, &mut surface)?;
        self.clear(extensions, &mut surface)?;
        self.replacements(extensions, &mut surface)?;
        Ok(surface)
    }

    /// The extensions that add layers or change the reflection.
    fn layers(&mut self, extensions: &Value, surface: &mut Principled) -> Result<(), GltfProblem> {
        if let Some(coat) = extensions.get("KHR_materials_clearcoat") {
            let (factor, roughness) = (("clearcoatFactor", 0.0), ("clearcoatRoughnessFactor", 0.0));
            surface.clearcoat = self.scalar(coat, factor, "clearcoatTexture", Channel::R)?;
            surface.clearcoat_roughness = self.scalar(coat, roughness, "clearcoatRoughnessTexture", Channel::G)?;
            let normals = self.texture(coat, "clearcoatNormalTexture", ColorSpace::Raw)?;
            surface.clearcoat_normal = normals.map(|id| TangentNormals {
                color: Color::Texture(id),
                scale: number(&coat["clearcoatNormalTexture"], "scale", 1.0),
            });
        }
        if let Some(sheen) = extensions.get("KHR_materials_sheen") {
            let roughness = ("sheenRoughnessFactor", 0.0);
            surface.sheen_color = self.color(sheen, "sheenColorFactor", 0.0, "sheenColorTexture")?;
            surface.sheen_roughness = self.scalar(sheen, roughness, "sheenRoughnessTexture", Channel::A)?;
        }
        if let Some(specular) = extensions.get("KHR_materials_specular") {
            surface.specular = self.scalar(specular, ("specularFactor", 1.0), "specularTexture", Channel::A)?;
            surface.specular_color = self.color(specular, "specularColorFactor", 1.0, "specularColorTexture")?;
        }
        if let Some(film) = extensions.get("KHR_materials_iridescence") {
            let metres = |key: &str, nm: f32| number(film, key, nm).max(0.0) * 1e-9;
            let most = metres("iridescenceThicknessMaximum", 400.0);
            surface.iridescence = self.scalar(film, ("iridescenceFactor", 0.0), "iridescenceTexture", Channel::R)?;
            surface.iridescence_ior = number(film, "iridescenceIor", 1.3).max(1.0);
            surface.iridescence_thickness = [metres("iridescenceThicknessMinimum", 100.0), most];
            surface.iridescence_place = self.scalar(film, ("", 1.0), "iridescenceThicknessTexture", Channel::G)?;
        }
        if let Some(brushed) = extensions.get("KHR_materials_anisotropy") {
            let strength = ("anisotropyStrength", 0.0);
            surface.anisotropy = self.scalar(brushed, strength, "anisotropyTexture", Channel::B)?;
            surface.anisotropy_rotation = number(brushed, "anisotropyRotation", 0.0);
            let direction = self.texture(brushed, "anisotropyTexture", ColorSpace::Raw)?;
            surface.anisotropy_direction = direction.map(Color::Texture);
        }
        Ok(())
    }

    /// The extensions of transmission and emission.
    fn clear(&mut self, extensions: &Value, surface: &mut Principled) -> Result<(), GltfProblem> {
        if let Some(ior) = extensions.get("KHR_materials_ior") {
            let ior = number(ior, "ior", 1.5);
            // 0 means total reflection.
            surface.ior = if ior >= 1.0 { ior } else { MIRROR_IOR };
        }
        if let Some(clear) = extensions.get("KHR_materials_transmission") {
            let factor = ("transmissionFactor", 0.0);
            surface.transmission = self.scalar(clear, factor, "transmissionTexture", Channel::R)?;
        }
        if let Some(diffuse) = extensions.get("KHR_materials_diffuse_transmission") {
            let (factor, texture) = (("diffuseTransmissionFactor", 0.0), "diffuseTransmissionTexture");
            let (color, map) = ("diffuseTransmissionColorFactor", "diffuseTransmissionColorTexture");
            surface.diffuse_transmission = self.scalar(diffuse, factor, texture, Channel::A)?;
            surface.diffuse_transmission_color = self.color(diffuse, color, 1.0, map)?;
        }
        if let Some(volume) = extensions.get("KHR_materials_volume") {
            if number(volume, "thicknessFactor", 0.0) > 0.0 {
                surface.boundary = Boundary::Solid;
                let (color, distance) = attenuation(volume);
                if distance > 0.0 && distance.is_finite() {
                    surface.absorption = medium::absorption(color, distance);
                }
            }
            if volume.get("thicknessTexture").is_some() {
                let why = Treatment::Unneeded("paths travel through the body itself");
                self.model.add_feature("thicknessTexture", "material", why);
            }
        }
        if let Some(dispersion) = extensions.get("KHR_materials_dispersion") {
            surface.dispersion = number(dispersion, "dispersion", 0.0).max(0.0);
        }
        if let Some(strength) = extensions.get("KHR_materials_emissive_strength") {
            surface.emissive_strength = number(strength, "emissiveStrength", 1.0).max(0.0);
        }
        Ok(())
    }

    /// The extensions that replace the model of metal and roughness.
    fn replacements(&mut self, extensions: &Value, surface: &mut Principled) -> Result<(), GltfProblem> {
        if let Some(older) = extensions.get("KHR_materials_pbrSpecularGlossiness") {
            let texture = "specularGlossinessTexture";
            surface.base_color = self.color(older, "diffuseFactor", 1.0, "diffuseTexture")?;
            let [.., alpha] = numbers(older, "diffuseFactor", [1.0; 4]);
            surface.opacity = opacity(&surface.base_color, alpha);
            surface.metallic = Scalar::Constant(0.0);
            surface.ior = MIRROR_IOR;
            surface.specular_color = self.color(older, "specularFactor", 1.0, texture)?;
            let glossiness = unit(older, "glossinessFactor", 1.0);
            surface.roughness = match self.texture(older, texture, ColorSpace::Srgb)? {
                None => Scalar::Constant(1.0 - glossiness),
                Some(id) => Scalar::Inverted(id, Channel::A, glossiness),
            };
        }
        if extensions.get("KHR_materials_unlit").is_some() {
            // An unlit surface emits its colour and reflects nothing.
            *surface = Principled {
                emissive: surface.base_color,
                emissive_strength: 1.0,
                is_unlit: true,
                opacity: surface.opacity,
                alpha_mode: surface.alpha_mode,
                sidedness: Sidedness::Both,
                ..Principled::matte(Color::Constant(Rgb::BLACK))
            };
        }
        Ok(())
    }
}

/// The colour of white light in a volume after a distance, in m.
fn attenuation(volume: &Value) -> (Rgb, f32) {
    let distance = number(volume, "attenuationDistance", f32::INFINITY);
    (Rgb::from_array(numbers(volume, "attenuationColor", [1.0; 3])), distance)
}

/// The opacity of a base colour.
fn opacity(base_color: &Color, alpha: f32) -> Scalar {
    match base_color {
        Color::Constant(_) => Scalar::Constant(alpha.clamp(0.0, 1.0)),
        Color::Texture(id) | Color::Tinted(id, _) => Scalar::Texture(*id, Channel::A, alpha),
    }
}

impl ModelMaterials {
    /// The indices of the document's images that materials use.
    pub fn used_images(&self) -> Vec<usize> {
        self.images.used()
    }

    /// The index in the model of a material of the document, if it is used.
    pub fn place_of(&self, material: usize) -> Option<usize> {
        self.materials.get(&Some(material)).copied()
    }

    /// Without materials so far. `animated` are the texture references whose transforms are animated.
    pub fn new(animated: HashSet<(usize, &'static str)>) -> Self {
        Self {
            animated,
            ..Self::default()
        }
    }

    /// The motion of those of these materials that are used, and of textures.
    pub fn motions(
        &self,
        document: &Document<'_>,
        moved: impl IntoIterator<Item = usize>,
        model: &Model,
    ) -> MovingLooks {
        let mut looks = MovingLooks::default();
        let mut textures: Vec<_> = self.textures.iter().collect();
        sorting::sort_by_key(&mut textures, |(reference, _)| *reference);
        for (reference, motion) in textures {
            looks.texture_places.insert(*reference, looks.textures.len());
            looks.textures.push(*motion);
        }
        for number in moved {
            let Some(&material) = self.materials.get(&Some(number)) else {
                continue;
            };
            let volume = &document.raw["materials"][number]["extensions"]["KHR_materials_volume"];
            looks.material_places.insert(number, looks.materials.len());
            looks.materials.push(MaterialMotion {
                material,
                surface: model.materials[material].surface,
                attenuation: attenuation(volume),
            });
        }
        looks
    }

    /// Adds a material to `model`; returns its index. `has_colors` tells whether its mesh has vertex colours.
    pub fn place(
        &mut self,
        document: &Document<'_>,
        material: Option<usize>,
        has_colors: bool,
        path: &Path,
        model: &mut Model,
    ) -> Result<usize, GltfProblem> {
        let at = match self.materials.get(&material) {
            Some(known) => *known,
            None => {
                let raw = raw(document, material)?;
                let sets = uv_sets(document, material)?;
                let mut reader = Reader {
                    document,
                    images: &mut self.images,
                    number: material,
                    animated: &self.animated,
                    textures: &mut self.textures,
                    sets,
                    path,
                    model,
                };
                let place = || material.map_or_else(String::new, |i| format!("material {i}"));
                let surface = reader.surface(raw).map_err(|e| e.within(&place()))?;
                let name = raw.get("name").and_then(Value::as_str).unwrap_or_default().to_owned();
                model.materials.push(ModelMaterial {
                    name,
                    is_one_sided: surface.sidedness == Sidedness::Front,
                    surface,
                });
                let at = model.materials.len() - 1;
                self.materials.insert(material, at);
                at
            }
        };
        model.materials[at].surface.reads_vertices |= has_colors;
        Ok(at)
    }
}
