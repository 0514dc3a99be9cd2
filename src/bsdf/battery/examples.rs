//! Examples of all BSDFs.

use super::super::{
    Bsdf,
    beckmann::Beckmann,
    conductor::{Conductor, Reflectance},
    dielectric::{RoughDielectric, ThinDielectric},
    diffuse::{Lambert, OrenNayar},
    layered::{Boundary, Layers, hero_channel::HeroChannel},
    microfacet::{Facets, Ggx},
    phong::{Phong, PhongWeights},
    specular::{Mirror, SmoothDielectric},
    thin_film::ThinFilm,
};
use crate::math::{Rgb, Vec2, Vec3};

pub struct Example {
    pub name: String,
    pub bsdf: Bsdf,
    /// About how wide its narrowest lobe is that is not delta, as a perceived roughness; 0 where it
    /// has none.
    pub width: f32,
}

fn example(name: String, bsdf: Bsdf, width: f32) -> Example {
    Example { name, bsdf, width }
}

const ROUGHNESSES: [f32; 5] = [0.0, 0.1, 0.35, 0.7, 1.0];

fn facets(roughness: f32) -> Ggx {
    Ggx::from_roughness(roughness, 0.0)
}

pub fn glass(roughness: f32, ior: f32, reflectance: Rgb, transmittance: Rgb) -> Bsdf {
    let facets = facets(roughness);
    if facets.is_smooth() {
        return Bsdf::SmoothDielectric(SmoothDielectric {
            ior,
            reflectance,
            transmittance,
        });
    }
    Bsdf::RoughDielectric(RoughDielectric {
        facets,
        ior,
        reflectance,
        transmittance,
    })
}

/// Metals and glass of Beckmann's distribution that lose no energy.
fn beckmann_examples() -> Vec<Example> {
    let white = Rgb::WHITE;
    let reflectance = Reflectance::colored(white, white);
    let mut all = Vec::new();
    for (roughness, anisotropy) in [
        (0.0, 0.0),
        (0.1, 0.0),
        (0.35, 0.0),
        (0.35, 0.7),
        (0.7, 0.0),
        (0.7, 0.5),
        (1.0, 0.0),
    ] {
        let facets = Beckmann::from_roughness(roughness, anisotropy);
        let metal = Bsdf::BeckmannConductor(Conductor::new(facets, reflectance));
        let name = format!("beckmann conductor {roughness} {anisotropy}");
        all.push(example(name, metal, roughness));
    }
    for roughness in [0.1, 0.35, 0.7] {
        let facets = Beckmann::from_roughness(roughness, 0.0);
        for ior in [1.5, 0.7] {
            let boundary = RoughDielectric {
                facets,
                ior,
                reflectance: white,
                transmittance: white,
            };
            all.push(example(
                format!("beckmann glass {ior} {roughness}"),
                boundary.into(),
                roughness,
            ));
        }
        let pane = ThinDielectric {
            facets,
            ior: 1.5,
            reflectance: white,
            transmittance: white,
        };
        all.push(example(
            format!("beckmann pane {roughness}"),
            Bsdf::BeckmannPane(pane),
            roughness,
        ));
    }
    all
}

/// The examples that lose no energy.
pub fn white_examples() -> Vec<Example> {
    let white = Rgb::WHITE;
    let mut all = vec![
        example("lambert".into(), Bsdf::Lambert(Lambert { albedo: white }), 1.0),
        example("mirror".into(), Bsdf::Mirror(Mirror { reflectance: white }), 1.0),
    ];
    all.extend(beckmann_examples());
    for roughness in ROUGHNESSES {
        let facets = facets(roughness);
        let mut add = |name: &str, bsdf: Bsdf| all.push(example(format!("{name} {roughness}"), bsdf, roughness));
        let albedo = white;
        add("oren-nayar", Bsdf::OrenNayar(OrenNayar { albedo, roughness }));
        let reflectance = Reflectance::colored(white, white);
        add("conductor", Bsdf::Conductor(Conductor::new(facets, reflectance)));
        for ior in [1.1_f32, 1.5, 2.4, 0.7] {
            let bsdf = glass(roughness, ior, white, white);
            // Where the index is near 1, what passes is hardly scattered.
            let width = if ior == 1.1 { 0.3 * roughness } else { roughness };
            all.push(example(format!("glass {ior} {roughness}"), bsdf, width));
        }
        let mut add = |name: &str, bsdf: Bsdf| all.push(example(format!("{name} {roughness}"), bsdf, roughness));
        add(
            "pane",
            Bsdf::ThinDielectric(ThinDielectric {
                facets,
                ior: 1.5,
                reflectance: white,
                transmittance: white,
            }),
        );
        let diffuse = Layers {
            facets,
            ..Layers::default()
        };
        let mut add = |name: &str, layers: Layers| add(name, layers.into());
        add("plastic", diffuse);
        add("dense plastic", Layers { ior: 2.4, ..diffuse });
        let metal = Layers {
            metallic: 1.0,
            ..diffuse
        };
        add("metal", metal);
        let clear = Layers {
            transmission: 1.0,
            boundary: Boundary::Solid,
            ..diffuse
        };
        add("clear", clear);
        add("dense clear", Layers { ior: 2.4, ..clear });
        let prism = Layers {
            dispersion: 4.0,
            ..clear
        };
        let hero = HeroChannel::choose(Rgb::new(0.0, 1.0, 0.0), 0.5).expect("green");
        // A path of green light meets what is white for green.
        let white_for_green = prism.for_channel(hero);
        add("prism", white_for_green);
        let sheet = Layers {
            boundary: Boundary::ThinWalled,
            ..clear
        };
        add("sheet", sheet);
        let coated = |base: Layers| Layers {
            coat: 1.0,
            coat_facets: Ggx::from_roughness(0.6, 0.0),
            ..base
        };
        add("coated metal", coated(metal));
        add("coated plastic", coated(diffuse));
        let tilted = |base: Layers| Layers {
            coat_normal: Vec3::new(0.36, -0.48, 0.8),
            ..coated(base)
        };
        add("metal under a tilted coat", tilted(metal));
        let smooth = Layers {
            coat_facets: Ggx::SMOOTH,
            ..tilted(diffuse)
        };
        add("plastic under a smooth tilted coat", smooth);
        let leaf = Layers {
            diffuse_transmission: 0.6,
            ..diffuse
        };
        add("leaf", leaf);
        add(
            "wax",
            Layers {
                boundary: Boundary::Solid,
                ..coated(leaf)
            },
        );
        let dusty = |base: Layers| Layers {
            sheen: white,
            sheen_roughness: roughness,
            ..base
        };
        add("dusty plastic", dusty(diffuse));
        add("dusty coated metal", dusty(coated(metal)));
        let mixed = Layers {
            metallic: 0.4,
            transmission: 0.5,
            ..diffuse
        };
        add("mixed", dusty(coated(mixed)));
    }
    all
}

/// All of them, and some that are coloured, directed or dark.
pub fn examples() -> Vec<Example> {
    let mut all = white_examples();
    let (rose, sea) = (Rgb::new(0.9, 0.4, 0.3), Rgb::new(0.2, 0.5, 0.6));
    for roughness in [0.1, 0.35, 0.7, 1.0] {
        let mut add = |name: &str, bsdf: Bsdf| all.push(example(format!("{name} {roughness}"), bsdf, roughness));
        let brushed = Ggx::from_roughness(roughness, 0.6);
        let gold = Reflectance::Measured {
            eta: Rgb::new(0.21, 0.43, 1.38),
            k: Rgb::new(3.272, 2.455, 1.914),
        };
        let conductor = |facets, reflectance| Bsdf::Conductor(Conductor::new(facets, reflectance));
        add("gold", conductor(facets(roughness), gold));
        add("brushed rose", conductor(brushed, Reflectance::colored(rose, sea)));
        add("green glass", glass(roughness, 1.5, rose, sea));
        let albedo = rose;
        add("oren-nayar rose", Bsdf::OrenNayar(OrenNayar { albedo, roughness }));
        let all_of_it = Layers {
            base_color: rose,
            metallic: 0.3,
            transmission: 0.4,
            diffuse_transmission: 0.3,
            diffuse_transmission_color: sea,
            facets: brushed,
            rotation: Vec2::new(0.6, 0.8),
            ior: 1.7,
            dispersion: 0.0,
            hero: None,
            boundary: Boundary::Solid,
            specular: 0.8,
            specular_color: sea,
            thin_film: ThinFilm {
                weight: 0.7,
                ior: 1.4,
                thickness: 450e-9,
                ..ThinFilm::NONE
            },
            coat: 0.5,
            coat_facets: facets(0.5),
            coat_normal: Vec3::new(0.0, 0.6, 0.8),
            sheen: sea,
            sheen_roughness: 0.5,
        };
        add("everything", all_of_it.into());
        let sheet = Layers {
            boundary: Boundary::ThinWalled,
            ..all_of_it
        };
        add("everything on a sheet", sheet.into());
        let opaque = Layers {
            transmission: 0.0,
            diffuse_transmission: 0.0,
            ..all_of_it
        };
        add("everything opaque", opaque.into());
    }
    for shininess in [0.0, 4.0, 200.0] {
        let weights = PhongWeights {
            diffuse: rose * 0.3,
            specular: Rgb::gray(0.4),
            reflect: Rgb::BLACK,
            transmit: Rgb::BLACK,
        };
        let plastic = Bsdf::Phong(Phong::new(weights, shininess, 1.5));
        let width = if shininess > 100.0 { 0.2 } else { 1.0 };
        all.push(example(format!("phong {shininess}"), plastic, width));
        let clear = PhongWeights {
            reflect: Rgb::gray(0.2),
            transmit: sea,
            ..weights
        };
        let clear = Bsdf::Phong(Phong::new(clear, shininess, 1.5));
        all.push(example(format!("clear phong {shininess}"), clear, width));
    }
    all
}
