//! Requests for passes, by name.

use super::passes::{BEAUTY, GROUP_PREFIX, PASSES, PassSource, PassSpec, group_pass_name};
use crate::value::UnknownName;

/// The name for all passes.
pub const ALL: &str = "all";

/// The name for the passes that denoisers read.
pub const DENOISE: &str = "denoise";

/// Names of passes in Blender and other programs, in small letters, and the names of ours.
const ELSEWHERE: &[(&[&str], &str)] = &[
    (&["z", "zdepth", "mist", "depth_z"], "depth"),
    (&["normal", "normals", "nrm", "ns", "sh_normal"], "N"),
    (&["position", "pos", "world_position"], "P"),
    (&["vector", "motion", "motionvector", "velocity"], "forward"),
    (&["combined", "rgb", "rgba", "image", "color"], "beauty"),
    (&["diffcol", "diffuse_color", "basecolor", "base_color"], "albedo"),
    (&["emit", "emissive"], "emission"),
    (&["diffdir"], "diffuse_direct"),
    (&["diffind", "gi"], "diffuse_indirect"),
    (&["glossdir", "specular"], "specular_direct"),
    (&["glossind", "reflection"], "specular_indirect"),
    (&["transdir", "transind", "refraction"], "transmission"),
    (&["indexob", "id", "ids", "object_id", "shape_index"], "objectId"),
    (&["indexma", "material_id", "mask"], "materialId"),
    (&["cryptomatte"], "CryptoObject"),
];

/// The error of an unknown pass.
fn unknown(name: &str) -> UnknownName {
    let small = name.to_ascii_lowercase();
    let own = ELSEWHERE.iter().find(|(names, _)| names.contains(&small.as_str()));
    let unknown = UnknownName::new("pass", name, PassRequest::names());
    match own {
        Some((_, own)) => unknown.with_suggestion(own),
        None => unknown,
    }
}

/// A requested pass.
#[derive(Clone, Debug, PartialEq)]
pub enum PassRequest {
    /// A row of the table; `lightgroup` stands for all groups.
    Pass(&'static PassSpec),
    /// The light of the group of this name.
    LightGroup(String),
}

impl PassRequest {
    /// Parses a list of names; `all` means every pass, `denoise` those that denoisers read.
    ///
    /// # Errors
    /// The first unknown name.
    pub fn parse_list<'a>(names: impl IntoIterator<Item = &'a str>) -> Result<Vec<Self>, UnknownName> {
        let mut list = Vec::new();
        for name in names {
            if name == ALL {
                list.extend(PASSES.iter().filter(|spec| is_requestable(spec)).map(Self::Pass));
            } else if name == DENOISE {
                list.extend(PASSES.iter().filter(|spec| spec.serves_denoisers()).map(Self::Pass));
            } else {
                list.push(Self::parse(name)?);
            }
        }
        Ok(list)
    }

    /// The pass of this name.
    ///
    /// # Errors
    /// There is none.
    pub fn parse(name: &str) -> Result<Self, UnknownName> {
        if let Some(spec) = PASSES.iter().find(|spec| is_requestable(spec) && spec.name == name) {
            return Ok(Self::Pass(spec));
        }
        match name.strip_prefix(GROUP_PREFIX) {
            Some(group) if !group.is_empty() => Ok(Self::LightGroup(group.to_owned())),
            _ => Err(unknown(name)),
        }
    }

    /// The names that [`PassRequest::parse_list`] reads, without those of light groups.
    pub fn names() -> impl Iterator<Item = &'static str> {
        let requestable = PASSES.iter().filter(|spec| is_requestable(spec));
        requestable.map(|spec| spec.name).chain([ALL, DENOISE])
    }

    /// The name of the request.
    pub fn name(&self) -> String {
        match self {
            Self::Pass(spec) => spec.name.to_owned(),
            Self::LightGroup(group) => group_pass_name(group),
        }
    }

    pub fn spec(&self) -> &'static PassSpec {
        match self {
            Self::Pass(spec) => spec,
            Self::LightGroup(_) => light_group(),
        }
    }
}

/// Whether it can be requested: false for passes that replace the beauty.
fn is_requestable(spec: &PassSpec) -> bool {
    !matches!(spec.source, PassSource::Integrator) || spec == BEAUTY
}

fn light_group() -> &'static PassSpec {
    let spec = PASSES.iter().find(|spec| matches!(spec.source, PassSource::LightGroup));
    spec.expect("the table has the row")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_other_programs_suggest_passes_that_there_are() {
        for (names, own) in ELSEWHERE {
            assert!(PassRequest::parse(own).is_ok(), "{own}");
            for name in *names {
                assert_eq!(PassRequest::parse(name).unwrap_err().suggestion(), Some(*own));
            }
        }
    }

    #[test]
    fn a_list_names_passes_groups_and_all() {
        let names = |list: &[&str]| -> Vec<String> {
            let list = PassRequest::parse_list(list.iter().copied()).unwrap();
            list.iter().map(|p| p.spec().name.to_owned()).collect()
        };
        assert_eq!(names(&["depth", "lightgroup_key"]), ["depth", "lightgroup"]);
        assert_eq!(names(&["all"]).len(), PASSES.len() - 1);
        let denoise = names(&["denoise"]);
        assert_eq!(denoise[..4], ["albedo", "objectId", "beauty_a", "beauty_b"]);
        assert_eq!(denoise.len(), 10);
        let error = PassRequest::parse_list(["dept"]).unwrap_err();
        assert_eq!(error.suggestion(), Some("depth"));
        assert!(PassRequest::parse("cost").is_err() && PassRequest::parse("lightgroup_").is_err());
    }
}
