//! The attributes by which compositors recognise Cryptomatte layers.
//!
//! Source: Friedman and Jones, "Cryptomatte Specification", version 1.2.0.

use std::collections::BTreeMap;

use crate::{
    film::PlaneSpec,
    math::hash,
    output::{Attribute, Value},
    scene::{Matte, MatteTable},
};

/// The attributes of a plane of mattes; none for other planes.
pub(super) fn attributes(plane: &PlaneSpec) -> Vec<Attribute> {
    let Some(mattes) = &plane.mattes else {
        return Vec::new();
    };
    let attribute = |what: &str, value: String| Attribute::new(name(&plane.name, what), value);
    vec![
        attribute("name", plane.name.clone()),
        attribute("hash", "MurmurHash3_32".to_owned()),
        attribute("conversion", "uint32_to_float32".to_owned()),
        attribute(MANIFEST, manifest(mattes)),
    ]
}

const MANIFEST: &str = "manifest";

/// The name of an attribute of a pass.
fn name(pass: &str, what: &str) -> String {
    let key = format!("{:08x}", hash::name_as_float(pass).to_bits());
    format!("cryptomatte/{}/{what}", &key[..7])
}

/// The mattes of a pass by the attributes of a file.
pub(super) fn table<'a>(mut attributes: impl Iterator<Item = &'a Attribute>, pass: &str) -> Option<MatteTable> {
    let name = name(pass, MANIFEST);
    let Value::String(json) = &attributes.find(|attribute| attribute.name == name)?.value else {
        return None;
    };
    let ids: BTreeMap<String, String> = serde_json::from_str(json).ok()?;
    let matte = |(name, id): (String, String)| {
        let id = u32::from_str_radix(&id, 16).ok()?;
        Some(Matte { name, id })
    };
    let mattes = ids.into_iter().map(matte).collect::<Option<_>>()?;
    Some(MatteTable { mattes })
}

/// The names of all mattes with their ids, as JSON.
fn manifest(mattes: &MatteTable) -> String {
    let mut json = String::from("{");
    for (i, matte) in mattes.mattes.iter().enumerate() {
        let name = serde_json::Value::from(matte.name.as_str());
        let comma = if i == 0 { "" } else { "," };
        json += &format!("{comma}{name}:\"{:08x}\"", matte.id);
    }
    json + "}"
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::{
        film::{FilmLayout, PassRequest, passes::BEAUTY},
        scene::Matte,
    };

    fn plane(pass: &str, names: &[&str]) -> PlaneSpec {
        let passes = PassRequest::parse_list([pass]).unwrap();
        let layout = FilmLayout::new(BEAUTY, &passes, &[]).unwrap();
        let matte = |name: &&str| Matte {
            name: (*name).to_owned(),
            id: hash::name_as_float(name).to_bits(),
        };
        let mattes = names.iter().map(matte).collect();
        PlaneSpec {
            mattes: Some(Arc::new(MatteTable { mattes })),
            ..layout.planes()[1].clone()
        }
    }

    #[test]
    fn keys_are_those_of_the_specification() {
        for (name, key) in [
            ("CryptoObject", "3ae39a5"),
            ("CryptoMaterial", "be359d6"),
            ("CryptoAsset", "f42029d"),
        ] {
            let attributes = attributes(&plane(name, &[]));
            let names: Vec<_> = attributes.iter().map(|a| a.name.clone()).collect();
            assert_eq!(names[0], format!("cryptomatte/{key}/name"));
            assert_eq!(names[3], format!("cryptomatte/{key}/manifest"));
            assert_eq!(
                (&attributes[0].value, &attributes[3].value),
                (&name.into(), &"{}".into())
            );
        }
    }

    #[test]
    fn a_manifest_is_json_whatever_the_names_are() {
        let names = [
            "bunny",
            "a \"quoted\" \\ name",
            "равнина",
            "line\nbreak \u{1}",
            "",
            "cube:[0] {x}",
        ];
        let json = manifest(plane("CryptoObject", &names).mattes.as_ref().unwrap());
        let read: serde_json::Map<String, serde_json::Value> = serde_json::from_str(&json).unwrap();
        assert_eq!(read.len(), names.len());
        assert_eq!(read["bunny"], "13851a76");
        assert_eq!(read["равнина"], "9623511e");
        assert!(names.iter().all(|name| read.contains_key(*name)));
    }
}
