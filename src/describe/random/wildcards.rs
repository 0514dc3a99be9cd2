//! `*` in the names of values that are drawn: all things of a kind, each of which draws by itself.

use super::{DrawDesc, RandomDesc};

/// Stands for every name.
const ANY: &str = "*";

impl RandomDesc {
    /// Whether a name has `*` in place of that of an object, a light, a material or another thing.
    pub fn has_wildcards(&self) -> bool {
        self.draws.iter().any(|draw| is_wildcard(&draw.name))
    }

    /// The same with a draw for each of the names by which `names` replaces one that has a `*`; `None` keeps it.
    pub(in crate::describe) fn expanded(
        &self,
        mut names: impl FnMut(&DrawDesc, &[String]) -> Option<Vec<String>>,
    ) -> Self {
        let mut draws = Vec::new();
        for draw in &self.draws {
            let steps: Vec<String> = draw.name.split('.').map(str::to_owned).collect();
            match is_wildcard(&draw.name).then(|| names(draw, &steps)).flatten() {
                None => draws.push(draw.clone()),
                Some(names) => draws.extend(names.into_iter().map(|name| DrawDesc { name, ..draw.clone() })),
            }
        }
        Self { draws, ..self.clone() }
    }

    /// The same with a draw for each node and each material of a model by itself.
    #[must_use]
    pub fn of_parts(&self, nodes: &[String], materials: &[String]) -> Self {
        let is_given = |name: &String| {
            let is_drawn = self.draws.iter().any(|draw| draw.name == *name);
            is_drawn || self.left_out.iter().any(|left_out| left_out.name == *name)
        };
        self.expanded(|_, steps| {
            let known = match steps.first().map(String::as_str) {
                Some("node") => nodes,
                Some("material") => materials,
                _ => return None,
            };
            let whole = |name: &String| {
                [&steps[..1], std::slice::from_ref(name), &steps[2..]]
                    .concat()
                    .join(".")
            };
            Some(known.iter().map(whole).filter(|name| !is_given(name)).collect())
        })
    }
}

/// Whether the name of a value has a `*` after its first step.
pub(in crate::describe) fn is_wildcard(name: &str) -> bool {
    name.split('.').nth(1) == Some(ANY)
}
