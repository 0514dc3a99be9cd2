//! The pages of `docs/scene`, made from the documentation of modules and descriptions.

use std::{collections::BTreeMap, fs};

use batch_render::{
    camera::CameraDesc,
    describe::BackgroundDesc,
    film::passes::{BEAUTY, Combine, Display, PASSES, PassSource, PixelType},
    filter::FilterDesc,
    integrator::IntegratorDesc,
    light::LightDesc,
    material::MaterialDesc,
    sampler::SamplerDesc,
    shape::ShapeDesc,
    texture::MappingDesc,
    texture::PatternDesc,
};

use super::pictures;
use crate::common::repo;

/// Kinds of one registry, which a table of a scene file chooses from.
struct Registry {
    /// The name of one kind, and of the folder of their pages.
    name: &'static str,
    /// The key that names the kind, where there is one.
    key: &'static str,
    /// The file that documents all kinds, or the folder in which each has its own.
    source: &'static str,
    kinds: &'static [&'static str],
}

/// A table of a scene file.
struct Table {
    name: &'static str,
    /// The text of its header.
    header: &'static str,
    /// The file and the item whose documentation is the table's page.
    source: &'static str,
    item: &'static str,
    registries: &'static [Registry],
}

const TABLES: [Table; 9] = [
    Table {
        name: "render",
        header: "[render]",
        source: "src/describe/settings.rs",
        item: "pub struct RenderDesc",
        registries: &[
            Registry {
                name: "integrator",
                key: "integrator.",
                source: "src/integrator",
                kinds: IntegratorDesc::NAMES,
            },
            Registry {
                name: "sampler",
                key: "sampler.",
                source: "src/sampler",
                kinds: SamplerDesc::NAMES,
            },
            Registry {
                name: "filter",
                key: "filter.",
                source: "src/filter.rs",
                kinds: FilterDesc::NAMES,
            },
        ],
    },
    Table {
        name: "camera",
        header: "[camera]",
        source: "src/describe/scene.rs",
        item: "pub camera:",
        registries: &[Registry {
            name: "camera",
            key: "",
            source: "src/camera",
            kinds: CameraDesc::NAMES,
        }],
    },
    Table {
        name: "background",
        header: "[background]",
        source: "src/describe/scene.rs",
        item: "pub struct BackgroundDesc",
        registries: &[Registry {
            name: "background",
            key: "",
            source: "src/light",
            kinds: BackgroundDesc::NAMES,
        }],
    },
    Table {
        name: "texture",
        header: "[texture.NAME]",
        source: "src/describe/scene.rs",
        item: "pub struct TextureEntry",
        registries: &[
            Registry {
                name: "texture",
                key: "",
                source: "src/texture",
                kinds: PatternDesc::NAMES,
            },
            Registry {
                name: "mapping",
                key: "mapping.",
                source: "src/texture/mapping.rs",
                kinds: MappingDesc::NAMES,
            },
            Registry {
                name: "transform",
                key: "",
                source: "src/texture/transform.rs",
                kinds: &["transform"],
            },
        ],
    },
    Table {
        name: "material",
        header: "[material.NAME]",
        source: "src/describe/scene.rs",
        item: "pub struct MaterialEntry",
        registries: &[Registry {
            name: "material",
            key: "",
            source: "src/material",
            kinds: MaterialDesc::NAMES,
        }],
    },
    Table {
        name: "object",
        header: "[[object]]",
        source: "src/describe/scene.rs",
        item: "pub struct ObjectDesc",
        registries: &[Registry {
            name: "shape",
            key: "shape.",
            source: "src/shape",
            kinds: ShapeDesc::NAMES,
        }],
    },
    Table {
        name: "light",
        header: "[[light]]",
        source: "src/describe/scene.rs",
        item: "pub struct LightEntry",
        registries: &[Registry {
            name: "light",
            key: "",
            source: "src/light",
            kinds: LightDesc::NAMES,
        }],
    },
    Table {
        name: "random",
        header: "[random]",
        source: "src/describe/random.rs",
        item: "pub struct RandomDesc",
        registries: &[],
    },
    Table {
        name: "output",
        header: "[output]",
        source: "src/describe/settings.rs",
        item: "pub struct OutputDesc",
        registries: &[],
    },
];

/// A page of the manual.
pub struct Page {
    /// Its file, below `docs/scene`.
    pub file: String,
    /// The file whose documentation it is.
    pub source: String,
    pub text: String,
}

impl Page {
    fn new(file: String, source: &str, title: &str, doc: &str, end: &str) -> Self {
        let note = format!("<!-- From the documentation of {source}, by BLESS=1 cargo test --test trials manual -->");
        Self {
            file,
            source: source.to_owned(),
            text: format!("{note}\n\n# {title}\n\n{}\n{end}", doc.trim()),
        }
    }
}

/// All pages, by file.
pub fn pages() -> Vec<Page> {
    let mut index = String::new();
    let mut pages = BTreeMap::new();
    for table in &TABLES {
        let doc = item_doc(table.source, table.item);
        let mut kinds = String::new();
        for registry in table.registries {
            kinds += &format!("\n## {}\n\n", plural(registry.name));
            for (names, page) in registry.pages() {
                if let Some(page) = page {
                    kinds += &format!("- [{names}]({}): {}\n", page.file, summary(&page));
                    pages.insert(page.file.clone(), page);
                } else {
                    kinds += &format!("- {names}: see [`{}`]({}.md)\n", table.header, table.name);
                }
            }
        }
        let file = format!("{}.md", table.name);
        let end = format!("{kinds}\n[All tables](README.md)\n");
        let page = Page::new(file, table.source, &format!("`{}`", table.header), &doc, &end);
        index += &format!("\n## [`{}`]({})\n\n{}\n", table.header, page.file, summary(&page));
        index += &kinds.replace("\n## ", "\n### ");
        pages.insert(page.file.clone(), page);
    }
    let passes = passes_page();
    index += &format!("\n## [Passes]({})\n\n{}\n", passes.file, summary(&passes));
    pages.insert(passes.file.clone(), passes);
    let source = "src/describe/scene.rs";
    let readme = Page::new(
        "README.md".to_owned(),
        source,
        "The scene file",
        &module_doc(source),
        &index,
    );
    pages.insert(readme.file.clone(), readme);
    let files: Vec<String> = pages.keys().cloned().collect();
    for page in pages.values_mut() {
        pictures::insert(page, &files);
    }
    pages.into_values().collect()
}

/// The names of all registries of kinds, with those of their kinds.
pub fn registries() -> impl Iterator<Item = (&'static str, &'static [&'static str])> {
    let registries = TABLES.iter().flat_map(|table| table.registries);
    // The transform of textures is no kind.
    let registries = registries.filter(|registry| registry.name != "transform");
    registries.map(|registry| (registry.name, registry.kinds))
}

/// The page of all passes, from their table.
fn passes_page() -> Page {
    let mut doc = String::from(
        "The pictures that a frame can hold, for `aovs` and `show` in `[output]`, `--aovs` and `--show`.\n\n\
         | pass | EXR channels | type | samples | where nothing is seen | in PNG | content |\n|---|---|---|---|---|---|---|\n",
    );
    for spec in PASSES {
        let pixel = match spec.pixel {
            PixelType::Half => "half",
            PixelType::Float => "float",
            PixelType::Uint => "uint",
        };
        let combine = match spec.combine {
            Combine::Filtered => "filtered",
            Combine::Nearest => "nearest",
            Combine::Ranked => "ranked",
            Combine::Counted => "counted",
        };
        let display = match spec.display {
            Display::Light => "light",
            Display::Heat => "heat",
            Display::Signed => "signed",
            Display::Near => "near",
            Display::Fraction => "fraction",
            Display::Share => "share",
            Display::Id => "id",
        };
        let layer = match spec.source {
            _ if spec == BEAUTY => String::new(),
            PassSource::LightGroup => format!("{}_NAME.", spec.name),
            PassSource::Matte(_) => format!("{}00.", spec.name),
            _ => format!("{}.", spec.name),
        };
        let channels: Vec<String> = spec.channels.iter().map(|c| format!("`{layer}{c}`")).collect();
        let (name, channels) = (spec.name, channels.join(" "));
        let about = spec.about;
        let background = match spec.background {
            0.0 => "0".to_owned(),
            far => format!("{far:e}"),
        };
        doc += &format!("| `{name}` | {channels} | {pixel} | {combine} | {background} | {display} | {about} |\n");
    }
    doc += "\nFiltered passes are means of a pixel's samples, weighted by the pixel filter and premultiplied. Nearest ones show the \
            sample nearest to the pixel's centre. The pixel filter chooses where samples are: with few of them that one may lie in the \
            next pixel, 1.2 pixels away with 2 samples, 0.7 with 4, 0.3 with 16. With one sample it is the centre: render labels with \
            `--samples 1`. Ranked ones are Cryptomatte: the ids of the mattes that cover the pixel and the \
            coverage of each, two in a layer (`CryptoObject00`, `CryptoObject01`, ...), weighted by the pixel filter where it is \
            positive; lens, shutter and opacity are in the coverage. The light components (`diffuse_direct` to `emission`) sum to the beauty, and so \
            do the light groups, except on shadow catchers, which both leave out. `denoise` stands for the passes that denoisers read: `objectId`, the halves, and the means of features with their \
            variances, and where objects move `forward` and `backward`; the notes say [how true these are](../notes/denoising.md#how-true-the-variances-are). Only EXR and NPZ files hold passes beside the beauty.\n\n\
            PNG and JPEG files of one pass (`show`) show light as the beauty is, and data in ways of their own: heat, the sum of the first two channels from dark \
            blue (0) over green (31) to red (1023 and more); signed, from black (-1) to white (1); near, from white (0) to black (1023 m and more); fraction, what is \
            behind the point of each number; share, from black (0) to white (1); id, a colour for each number and black for 0.\n";
    let source = "src/film/passes.rs";
    Page::new(
        "passes.md".to_owned(),
        source,
        "Passes",
        &doc,
        "\n[All tables](README.md)\n",
    )
}

impl Registry {
    /// The kinds of each page, as a list of names, and the page. A kind without one is explained by its table.
    fn pages(&self) -> Vec<(String, Option<Page>)> {
        let code = |kind: &str| format!("`{}{kind}`", self.key);
        if self.source.ends_with(".rs") {
            let names: Vec<String> = self.kinds.iter().map(|kind| code(kind)).collect();
            return vec![(names.join(", "), Some(self.page(self.source, self.name, self.kinds)))];
        }
        let page = |kind: &&'static str| {
            let source = format!("{}/{}.rs", self.source, kind.replace('-', "_"));
            let page = repo(&source).is_file();
            let page = page.then(|| self.page(&source, &format!("{}/{kind}", self.name), &[kind]));
            (code(kind), page)
        };
        self.kinds.iter().map(page).collect()
    }

    fn page(&self, source: &str, file: &str, kinds: &[&str]) -> Page {
        let root = "../".repeat(2 + file.matches('/').count());
        let scene = |kind: &&str| {
            let scene = format!("scenes/kinds/{}.toml", crate::common::kind_scene(self.name, kind));
            let exists = repo(&scene).is_file();
            exists.then(|| format!("[{scene}]({root}{scene})"))
        };
        let scenes: Vec<String> = kinds.iter().filter_map(scene).collect();
        let mut end = String::new();
        if !scenes.is_empty() {
            end = format!("\nExample scenes: {}\n", scenes.join(", "));
        }
        end += &format!("\n[All tables]({}README.md)\n", &root[6..]);
        let title = match file.split_once('/') {
            Some((_, kind)) => format!("{}: `{kind}`", capital(self.name)),
            None if kinds.len() == 1 => capital(self.name),
            None => plural(self.name),
        };
        Page::new(format!("{file}.md"), source, &title, &module_doc(source), &end)
    }
}

/// The first paragraph after the title, up to the first full stop.
fn summary(page: &Page) -> String {
    let paragraph = page.text.split("\n\n").nth(2).expect("a page has text");
    let sentence = paragraph.replace('\n', " ");
    let end = sentence.find(". ").map_or(sentence.len(), |at| at + 1);
    sentence[..end].to_owned()
}

fn capital(word: &str) -> String {
    format!("{}{}", word[..1].to_uppercase(), &word[1..])
}

fn plural(word: &str) -> String {
    match word {
        "background" | "transform" => capital(word),
        _ => format!("{}s", capital(word)),
    }
}

fn read(file: &str) -> String {
    fs::read_to_string(repo(file)).unwrap_or_else(|e| panic!("{file}: {e}"))
}

/// The documentation at the head of a file.
fn module_doc(file: &str) -> String {
    let text = read(file);
    let lines = text.lines().map_while(|line| line.strip_prefix("//!"));
    for_users(file, lines)
}

/// The documentation of the item in `file` whose first line begins with `item`.
fn item_doc(file: &str, item: &str) -> String {
    let text = read(file);
    let lines: Vec<&str> = text.lines().map(str::trim_start).collect();
    let at = lines.iter().position(|line| line.starts_with(item));
    let at = at.unwrap_or_else(|| panic!("{file} has no {item}"));
    let above = lines[..at].iter().rev();
    let doc: Vec<&str> = above
        .skip_while(|line| line.starts_with("#["))
        .map_while(|line| line.strip_prefix("///"))
        .collect();
    for_users(file, doc.into_iter().rev())
}

/// The part before the heading `# Implementation`, with headings below the page's title.
fn for_users<'a>(file: &str, lines: impl Iterator<Item = &'a str>) -> String {
    let mut doc = String::new();
    let mut code = false;
    for line in lines.map(|line| line.strip_prefix(' ').unwrap_or(line)) {
        code ^= line.starts_with("```");
        match line {
            "# Implementation" => break,
            heading if !code && heading.starts_with('#') => doc += "#",
            _ => {}
        }
        doc += line;
        doc.push('\n');
    }
    let item = doc.contains("crate::") || doc.contains("super::") || doc.contains("`]\n") || doc.contains("`] ");
    assert!(
        !item,
        "{file}: a manual page links to an item; it belongs below `# Implementation`"
    );
    assert!(!doc.trim().is_empty(), "{file} has no documentation");
    doc
}
