//! The paths by which source files name one another.

use std::collections::{BTreeMap, BTreeSet};

/// A path as segments from `crate` on.
pub type Segments = Vec<String>;

/// Source files with the paths by which they use others and those that they hand on.
pub struct Sources {
    /// The files by their modules.
    modules: BTreeMap<Segments, String>,
    /// The re-exports of each module: the full path of each name that `pub use` re-exports.
    handed_on: BTreeMap<(Segments, String), Segments>,
    uses: BTreeMap<String, BTreeSet<Segments>>,
}

impl Sources {
    /// Reads `files`, whose code has no comments and no tests.
    pub fn read(files: &BTreeMap<String, String>) -> Self {
        let modules: BTreeMap<Segments, String> = files.keys().map(|f| (module(f), f.clone())).collect();
        let mut sources = Self {
            modules,
            handed_on: BTreeMap::new(),
            uses: BTreeMap::new(),
        };
        for (file, code) in files {
            sources.read_file(file, code);
        }
        sources
    }

    fn read_file(&mut self, file: &str, code: &str) {
        let own = module(file);
        let mut uses = BTreeSet::new();
        let mut rest = String::new();
        // A statement or a declaration ends by one of these; a `use` has braces of its own.
        let mut left = code;
        while let Some((before, public, tree, after)) = next_use(left) {
            rest.push_str(before);
            for path in flatten(&tree) {
                let Some(path) = self.absolute(&own, &path) else {
                    continue;
                };
                if public {
                    let name = path.last().expect("a path has a segment").clone();
                    self.handed_on.insert((own.clone(), name), path);
                } else {
                    uses.insert(path);
                }
            }
            left = after;
        }
        rest.push_str(left);
        uses.extend(inline_paths(&rest).iter().filter_map(|path| self.absolute(&own, path)));
        self.uses.insert(file.to_owned(), uses);
    }

    /// The path from `crate` on; `None` for one into another package, or to an item of the same file.
    fn absolute(&self, own: &[String], path: &[String]) -> Option<Segments> {
        let mut base = own.to_vec();
        let mut path = path;
        match path.first()?.as_str() {
            "crate" => return Some(path.to_vec()),
            "self" => path = &path[1..],
            "super" => {
                while path.first().is_some_and(|s| s == "super") {
                    base.pop();
                    path = &path[1..];
                }
            }
            child => {
                let mut module = base.clone();
                module.push(child.to_owned());
                self.modules.get(&module)?;
            }
        }
        base.extend_from_slice(path);
        Some(base)
    }

    /// The file that defines what a path leads to: a name that a module only hands on is defined elsewhere.
    fn definition(&self, path: &[String]) -> Option<&str> {
        let mut path = path.to_vec();
        // As many steps as no chain of names has.
        for _ in 0..8 {
            let len = (1..=path.len())
                .rev()
                .find(|&n| self.modules.contains_key(&path[..n]))?;
            let name = path.get(len).cloned().unwrap_or_default();
            match self.handed_on.get(&(path[..len].to_vec(), name)) {
                Some(target) => path = [&target[..], &path[len + 1..]].concat(),
                None => return self.modules.get(&path[..len]).map(String::as_str),
            }
        }
        None
    }

    /// Which files each file uses.
    pub fn edges(&self) -> BTreeMap<&str, BTreeSet<&str>> {
        let of = |(file, paths): (&'_ String, &'_ BTreeSet<Segments>)| {
            let used = paths.iter().filter_map(|path| self.definition(path));
            let used = used
                .filter(|to| *to != file.as_str())
                .map(str::to_owned)
                .collect::<BTreeSet<_>>();
            (file.clone(), used)
        };
        let owned: BTreeMap<String, BTreeSet<String>> = self.uses.iter().map(of).collect();
        let name = |file: &str| self.modules.get(&module(file)).map_or("", String::as_str);
        owned
            .iter()
            .map(|(file, used)| (name(file), used.iter().map(|f| name(f)).collect()))
            .collect()
    }
}

/// The module of a file: `src/a/mod.rs` and `src/a.rs` are both `crate::a`.
pub fn module(file: &str) -> Segments {
    let path = file.trim_start_matches("src/").trim_end_matches(".rs");
    let path = path.strip_suffix("/mod").unwrap_or(path);
    let inside = path.split('/').filter(|s| !matches!(*s, "lib" | "main"));
    std::iter::once("crate").chain(inside).map(str::to_owned).collect()
}

/// The next `use` of some code: what stands before it, whether it hands on, its tree and what stands after it.
fn next_use(code: &str) -> Option<(&str, bool, String, &str)> {
    let mut from = 0;
    loop {
        let at = from + code[from..].find("use ")?;
        let line = code[..at].rfind('\n').map_or(0, |i| i + 1);
        let before = code[line..at].trim();
        let is_use = before.is_empty() || (before.starts_with("pub") && !before.contains(' '));
        if is_use && let Some(end) = code[at..].find(';') {
            let tree: String = code[at + 4..at + end].split_whitespace().collect::<Vec<_>>().join(" ");
            return Some((&code[..line], !before.is_empty(), tree, &code[at + end + 1..]));
        }
        from = at + 4;
    }
}

/// All paths of a `use` tree, without the names that they get.
pub fn flatten(tree: &str) -> Vec<Segments> {
    let tree = tree.trim();
    let Some((prefix, list)) = tree.split_once('{') else {
        let path = tree.split(" as ").next().unwrap_or_default();
        let segments = path.split("::").map(|s| s.trim().to_owned());
        let mut segments: Segments = segments.filter(|s| !s.is_empty() && s != "*").collect();
        if segments.len() > 1 && segments.last().is_some_and(|s| s == "self") {
            segments.pop();
        }
        return vec![segments];
    };
    let prefix: Segments = prefix
        .split("::")
        .map(|s| s.trim().to_owned())
        .filter(|s| !s.is_empty())
        .collect();
    let list = list.strip_suffix('}').unwrap_or(list);
    let (mut depth, mut start, mut items) = (0, 0, Vec::new());
    for (i, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                items.push(&list[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    items.push(&list[start..]);
    let items = items.into_iter().filter(|item| !item.trim().is_empty());
    items
        .flat_map(flatten)
        .map(|path| match &path[..] {
            [only] if only == "self" => prefix.clone(),
            _ => [&prefix[..], &path[..]].concat(),
        })
        .collect()
}

/// Paths of two segments or more in code that has no `use`.
fn inline_paths(code: &str) -> Vec<Segments> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    code.split(|c: char| !is_part(c))
        .filter(|path| path.contains("::") && !path.starts_with(':'))
        .map(|path| path.split("::").filter(|s| !s.is_empty()).map(str::to_owned).collect())
        .collect()
}
