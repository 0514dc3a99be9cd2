//! Light takes the same way back.

use super::{
    super::{
        Bsdf, BsdfKind, albedo,
        beckmann::Beckmann,
        dielectric::RoughDielectric,
        diffuse::{Lambert, OrenNayar},
        fresnel,
        layered::Layers,
        microfacet::{Facets, Ggx},
        phong::{Phong, PhongWeights},
    },
    *,
};

const PAIRS: [(f32, f32, f32); 4] = [(0.9, 0.3, 1.0), (0.5, 0.6, 3.0), (0.05, 0.7, 2.2), (0.2, 0.1, 0.4)];

#[test]
fn diffuse_and_phong_bsdfs_are_reciprocal() {
    let gray = Rgb::gray(0.6);
    let weights = PhongWeights {
        diffuse: gray * 0.5,
        specular: gray,
        reflect: Rgb::BLACK,
        transmit: Rgb::BLACK,
    };
    let reciprocal = [
        Bsdf::Lambert(Lambert { albedo: gray }),
        Bsdf::OrenNayar(OrenNayar {
            albedo: gray,
            roughness: 0.8,
        }),
        Bsdf::Phong(Phong::new(weights, 12.0, 1.5)),
    ];
    for bsdf in reciprocal {
        for (a, b, turn) in PAIRS {
            let (wo, wi) = (direction(a, 0.3), direction(b, 0.3 + turn));
            let (there, back) = (bsdf.eval(wo, wi).f_cos() / wi.z, bsdf.eval(wi, wo).f_cos() / wo.z);
            assert!(close(there, back, 1e-4), "{bsdf:?}: {there:?} {back:?}");
        }
    }
}

#[test]
fn light_that_passes_a_diffuse_base_takes_the_same_way_back() {
    let leaf = Bsdf::from(Layers {
        diffuse_transmission: 0.7,
        diffuse_transmission_color: Rgb::new(0.2, 0.6, 0.1),
        facets: Ggx::from_roughness(0.4, 0.5),
        ..Layers::default()
    });
    for (a, b, turn) in PAIRS {
        let (wo, wi) = (direction(a, 0.3), direction(-b, 0.3 + turn));
        let (there, back) = (leaf.eval(wo, wi), leaf.eval(wi, wo));
        assert!(there.glossy.is_black() && !there.diffuse.is_black());
        assert!(close(there.diffuse / b, back.diffuse / a, 1e-4), "{there:?} {back:?}");
    }
}

/// Checks that light takes the same way back off these facets, and through them but for the square of the index.
fn check_facets(facets: &impl Facets, tolerance: f32) {
    let eta = 1.4;
    for (a, b, turn) in PAIRS {
        let (wo, wi) = (direction(a, 0.3), direction(b, 0.3 + turn));
        let f = |wo, wi: Vec3| facets.reflection(wo, wi).map(|f| f.pdf * f.masking / wi.z).unwrap();
        assert!((f(wo, wi) / f(wi, wo) - 1.0).abs() < tolerance);
        let h = facets.sample_normal(wo, Vec2::new(0.3, 0.6));
        let through = fresnel::refract(wo, h, eta).unwrap();
        if through.z >= 0.0 {
            continue;
        }
        let there = facets.transmission(wo, through, eta).unwrap();
        let back = facets.transmission(-through, -wo, 1.0 / eta).unwrap();
        let ratio = (there.pdf * there.masking / -through.z) / (back.pdf * back.masking / wo.z);
        assert!((ratio / (eta * eta) - 1.0).abs() < 2.0 * tolerance, "{ratio}");
    }
}

#[test]
fn single_bounces_off_facets_are_reciprocal() {
    for (roughness, anisotropy) in [(0.3, 0.0), (0.6, 0.7)] {
        check_facets(&Ggx::from_roughness(roughness, anisotropy), 1e-4);
    }
    // No smoother facets scatter these pairs.
    for (roughness, anisotropy) in [(1.0, 0.0), (0.9, 0.4)] {
        check_facets(&Beckmann::from_roughness(roughness, anisotropy), 1e-3);
    }
}

#[test]
fn what_passes_a_facet_passes_back_but_for_the_square_of_the_index() {
    let eta = 1.5;
    for roughness in [0.3, 0.8] {
        let facets = Ggx::from_roughness(roughness, 0.0);
        let glass = RoughDielectric {
            facets,
            ior: eta,
            reflectance: Rgb::WHITE,
            transmittance: Rgb::WHITE,
        };
        for (a, b, turn) in PAIRS {
            let (wo, wi) = (direction(a, 0.0), direction(-b, turn));
            let there = glass.eval(wo, wi).glossy.g * albedo::clear(&facets, wo, eta).fresnel / b;
            let inside = fresnel::mirrored(wi);
            let back = glass.eval(wi, wo).glossy.g * albedo::clear(&facets, inside, 1.0 / eta).fresnel / a;
            assert!((there - back * eta * eta).abs() <= 1e-3 * there, "{there} {back}");
        }
    }
}
