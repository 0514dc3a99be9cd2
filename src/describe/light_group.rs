//! Names of light groups.

use std::fmt;

use serde::{Deserialize, Deserializer, de};

/// The longest name of a channel that every reader of EXR files accepts, in bytes.
const MAX_CHANNEL_NAME: usize = 31;

/// The beginning of names that mean light groups in light links.
pub const LIGHT_GROUP: &str = "group:";

/// The name of a light group: letters, digits, `_` and `-`. Its channels, `lightgroup_NAME.R`, have at most 31 bytes, which every
/// reader of EXR files accepts. `default` means lights without a group and is no valid name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LightGroupName(String);

impl LightGroupName {
    /// The most bytes of a name.
    pub const MAX_LEN: usize = MAX_CHANNEL_NAME - "lightgroup_".len() - ".R".len();

    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl<'de> Deserialize<'de> for LightGroupName {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct NameVisitor;
        impl de::Visitor<'_> for NameVisitor {
            type Value = LightGroupName;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the name of a light group")
            }
            fn visit_str<E: de::Error>(self, name: &str) -> Result<LightGroupName, E> {
                let is_word = |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'-');
                if name.is_empty() || !name.bytes().all(is_word) {
                    return Err(E::custom(format_args!(
                        "the name of a light group has letters, digits, `_` and `-` only, found `{name}`"
                    )));
                }
                if name == "default" {
                    return Err(E::custom(
                        "`default` stands for the lights without a group, choose another name",
                    ));
                }
                if name.len() > LightGroupName::MAX_LEN {
                    return Err(E::custom(format_args!(
                        "the name of a light group has at most {} bytes, found {}: \
                         the name of its channel, `lightgroup_{name}.R`, has to fit into {MAX_CHANNEL_NAME} bytes",
                        LightGroupName::MAX_LEN,
                        name.len()
                    )));
                }
                Ok(LightGroupName(name.to_owned()))
            }
        }
        d.deserialize_str(NameVisitor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(name: &str) -> Result<String, String> {
        #[derive(Deserialize)]
        struct Table {
            group: LightGroupName,
        }
        let table: Result<Table, _> = toml::from_str(&format!("group = '{name}'"));
        table.map(|t| t.group.0).map_err(|e| e.message().to_owned())
    }

    #[test]
    fn names_are_words_whose_channels_fit_into_31_bytes() {
        assert_eq!(read("Key-light_2"), Ok("Key-light_2".to_owned()));
        let longest = "a".repeat(LightGroupName::MAX_LEN);
        assert_eq!(format!("lightgroup_{longest}.R").len(), MAX_CHANNEL_NAME);
        assert!(read(&longest).is_ok());
        let message = read(&format!("{longest}b")).unwrap_err();
        assert!(message.contains("at most 18 bytes, found 19"), "{message}");
        assert!(read("default").unwrap_err().contains("another name"));
        for bad in ["", "key light", "key.light", "schlüssel"] {
            assert!(read(bad).unwrap_err().contains("letters, digits"), "{bad}");
        }
    }
}
