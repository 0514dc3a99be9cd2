//! Every row of the pass table, by way of the program: the channels, types and backgrounds of files, what a picture shows, and
//! the same bits whatever else is rendered.

use crate::common::{Folder, repo, repo_str};
use batch_render::film::{
    PassSpec, PixelType,
    passes::{PASSES, PassSource},
};
use exr::prelude::{FlatImage, FlatSamples};
use libtest_mimic::{Failed, Trial};

const SMALL: [&str; 6] = ["--resolution", "48x27", "--samples", "4", "--progress", "none"];

pub fn trials() -> Vec<Trial> {
    let requestable = |spec: &&PassSpec| spec.name != "cost";
    let trials = PASSES.iter().filter(requestable).flat_map(|spec| {
        [
            trial!(format!("aovs_{}", spec.name), move || is_in_the_file(spec)),
            trial!(format!("show_{}", spec.name), move || is_shown(spec)),
        ]
    });
    let more = [
        trial!("bits_do_not_depend_on_threads_or_crops", bits),
        trial!("only_light_claims_a_colour_space", colour_space),
        trial!("cost_is_the_picture_of_its_integrator", cost),
        trial!("wrong_names_are_refused", wrong_names),
    ];
    trials.chain(more).collect()
}

/// Renders `scenes/passes/scene.toml` small into `name`.
fn render(folder: &Folder, name: &str, args: &[&str]) {
    let scene = repo_str("scenes/passes/scene.toml");
    folder.succeed(&[&[&scene, "-o", name], args, &SMALL[..]].concat());
}

/// The names and the samples of a file's channels.
fn channels(image: &FlatImage) -> Vec<(String, FlatSamples)> {
    let list = &image.layer_data[0].channel_data.list;
    list.iter()
        .map(|c| (c.name.to_string(), c.sample_data.clone()))
        .collect()
}

fn values<'a>(channels: &'a [(String, FlatSamples)], name: &str) -> &'a FlatSamples {
    let found = channels.iter().find(|(n, _)| n == name);
    &found.unwrap_or_else(|| panic!("no channel {name}")).1
}

fn pixel_type(samples: &FlatSamples) -> PixelType {
    match samples {
        FlatSamples::F16(_) => PixelType::Half,
        FlatSamples::F32(_) => PixelType::Float,
        FlatSamples::U32(_) => PixelType::Uint,
    }
}

/// The names of the pass's channels in a file.
fn channel_names(spec: &PassSpec) -> Vec<String> {
    let layer = match spec.source {
        PassSource::Integrator => return spec.channels.iter().map(|c| (*c).to_owned()).collect(),
        PassSource::LightGroup => "lightgroup_default",
        // The second rank of few samples may be empty.
        PassSource::Matte(_) => return ["00.R", "00.G"].map(|c| format!("{}{c}", spec.name)).to_vec(),
        _ => spec.name,
    };
    spec.channels.iter().map(|c| format!("{layer}.{c}")).collect()
}

/// Whether it is 0 in a scene where nothing moves and nothing is instanced.
fn is_still(spec: &PassSpec) -> bool {
    matches!(spec.name, "forward" | "backward" | "instanceId")
}

/// The names of all channels of a pass of mattes.
fn matte_channels(spec: &PassSpec) -> Vec<String> {
    let layers = (0..3).flat_map(|layer| ["R", "G", "B", "A"].map(|c| format!("{}{layer:02}.{c}", spec.name)));
    layers.collect()
}

/// Beside the beauty, which stays what it is.
fn is_in_the_file(spec: &PassSpec) -> Result<(), Failed> {
    let folder = Folder::new();
    let plain = folder.path("plain.exr");
    std::fs::write(folder.path("none.toml"), without_aovs())?;
    folder.succeed(&[&["none.toml", "-o", "plain.exr"], &SMALL[..]].concat());
    render(&folder, "pass.exr", &["--aovs", spec.name]);
    assert!(plain.is_file());
    let (plain, with) = (
        channels(&folder.open_exr("plain.exr")),
        channels(&folder.open_exr("pass.exr")),
    );
    for (name, samples) in &plain {
        assert_eq!(values(&with, name), samples, "{name} changes");
    }
    for name in channel_names(spec) {
        let samples = values(&with, &name);
        assert_eq!(pixel_type(samples), spec.pixel, "{name}");
        let numbers: Vec<f32> = samples.values_as_f32().collect();
        // Nothing is in the upper left corner, and something elsewhere.
        if spec.name == "sampleCount" {
            assert!(numbers.iter().all(|n| *n == 4.0));
            continue;
        }
        assert_eq!(numbers[0], spec.background, "{name}");
        if is_still(spec) {
            continue;
        }
        assert!(numbers.iter().any(|v| *v != spec.background), "{name} is empty");
    }
    Ok(())
}

/// In place of the beauty.
fn is_shown(spec: &PassSpec) -> Result<(), Failed> {
    let folder = Folder::new();
    let name = match spec.source {
        PassSource::LightGroup => "lightgroup_default",
        _ => spec.name,
    };
    render(&folder, "f.exr", &["--show", name, "-o", "f.png"]);
    let mut found: Vec<String> = channels(&folder.open_exr("f.exr"))
        .into_iter()
        .map(|(n, _)| n)
        .collect();
    let mut expected = match spec.is_light() {
        true => ["R", "G", "B"].map(str::to_owned).to_vec(),
        false if matches!(spec.source, PassSource::Matte(_)) => matte_channels(spec),
        false => channel_names(spec),
    };
    expected.push("A".to_owned());
    found.sort();
    expected.sort();
    assert_eq!(found, expected);
    let picture = image::load_from_memory(&folder.read("f.png"))?.into_rgba8();
    assert_eq!(picture.get_pixel(0, 0).0[3], 0, "nothing is transparent");
    assert_eq!(picture.get_pixel(24, 20).0[3], 255, "the floor is opaque");
    let floor = picture.get_pixel(24, 20);
    if is_still(spec) || spec.name == "sampleCount" {
        return Ok(());
    }
    assert!(picture.pixels().any(|p| p != floor), "the picture is of one colour");
    Ok(())
}

/// The scene of all passes without its `aovs`.
fn without_aovs() -> String {
    let text = std::fs::read_to_string(repo("scenes/passes/scene.toml")).expect("the scene");
    text.lines()
        .filter(|l| !l.starts_with("aovs"))
        .map(|l| format!("{l}\n"))
        .collect()
}

fn bits() -> Result<(), Failed> {
    let folder = Folder::new();
    for threads in ["1", "7"] {
        render(
            &folder,
            &format!("{threads}.exr"),
            &["--aovs", "all", "--threads", threads],
        );
    }
    assert_eq!(folder.read("1.exr"), folder.read("7.exr"));
    let [x0, y0, x1, y1] = [9, 7, 33, 25];
    render(&folder, "crop.exr", &["--aovs", "all", "--crop", "9,7,33,25"]);
    let (full, crop) = (
        channels(&folder.open_exr("1.exr")),
        channels(&folder.open_exr("crop.exr")),
    );
    assert_eq!(full.len(), crop.len());
    for (name, samples) in &full {
        let all: Vec<u32> = samples.values_as_f32().map(f32::to_bits).collect();
        let rows = (y0..y1).flat_map(|y| all[y * 48 + x0..y * 48 + x1].to_vec());
        let part: Vec<u32> = values(&crop, name).values_as_f32().map(f32::to_bits).collect();
        assert_eq!(rows.collect::<Vec<_>>(), part, "{name}");
    }
    Ok(())
}

fn colour_space() -> Result<(), Failed> {
    let folder = Folder::new();
    for (args, claims) in [
        (["--show", "depth"], false),
        (["--show", "objectId"], false),
        (["--show", "diffuse_direct"], true),
        (["--aovs", "depth"], true),
        (["--integrator", "cost"], false),
    ] {
        let scene = folder.write("s.toml", &without_aovs());
        folder.succeed(&[&[scene.to_str().expect("UTF-8"), "-o", "f.exr"], &args[..], &SMALL[..]].concat());
        let found = folder.open_exr("f.exr").attributes.chromaticities.is_some();
        assert_eq!(found, claims, "{args:?}");
    }
    Ok(())
}

fn cost() -> Result<(), Failed> {
    let folder = Folder::new();
    folder.write("s.toml", &without_aovs());
    let names = |args: &[&str]| -> Vec<String> {
        folder.succeed(&[&["s.toml", "-o", "f.exr"], args, &SMALL[..]].concat());
        channels(&folder.open_exr("f.exr"))
            .into_iter()
            .map(|(n, _)| n)
            .collect()
    };
    for args in [&[][..], &["--aovs", "all"]] {
        let found = names(&[&["--integrator", "cost"], args].concat());
        assert_eq!(found, ["A", "cost.nodes", "cost.primitives"]);
    }
    let found = names(&["--integrator", "occlusion", "--aovs", "all"]);
    assert!(found.contains(&"depth.Z".to_owned()) && !found.iter().any(|n| n.starts_with("emission")));
    for (integrator, pass) in [
        ("cost", "depth"),
        ("cost", "emission"),
        ("occlusion", "transmission"),
        ("occlusion", "lightgroup_default"),
    ] {
        let error = folder.fail(
            2,
            &["s.toml", "-o", "f.exr", "--integrator", integrator, "--aovs", pass],
        );
        let expected = format!("the integrator `{integrator}` cannot fill the pass `{pass}`");
        assert!(error.contains(&expected), "{error}");
    }
    Ok(())
}

fn wrong_names() -> Result<(), Failed> {
    let folder = Folder::new();
    folder.write("s.toml", &without_aovs());
    for (args, code, message) in [
        (&["--aovs", "depht"][..], 2, "did you mean `depth`?"),
        (&["--show", "Normal"], 2, "--show: unknown pass `Normal`"),
        (&["--show", "lightgroup"], 2, "stands for several passes"),
        (&["--aovs", "lightgroup_kee"], 2, "unknown light group `lightgroup_kee`"),
        (&["--integrator", "depth"], 2, "use --show depth"),
        (&["--aovs", "N", "--show", "N"], 2, "cannot be used with"),
    ] {
        let error = folder.fail(code, &[&["s.toml", "-o", "f.exr"], args].concat());
        assert!(error.contains(message), "{args:?}: {error}");
    }
    let error = folder.fail(2, &["s.toml", "-o", "f.png", "--aovs", "N"]);
    assert!(error.contains("only EXR and NPZ files hold passes"), "{error}");
    folder.write("bad.toml", "[output]\nfiles = \"f.png\"\naovs = \"depth\"\n");
    let error = folder.fail(65, &["bad.toml"]);
    assert!(
        error.contains("only EXR and NPZ files hold passes, and `files` names none"),
        "{error}"
    );
    for (text, message) in [
        ("[output]\naovs = [\"depth\", \"nrm\"]\n", "unknown pass `nrm`"),
        ("[output]\nshow = \"Depth\"\n", "did you mean `depth`?"),
        ("[render]\nintegrator = \"normals\"\n", "`[output] show = \"N\"`"),
    ] {
        folder.write("bad.toml", text);
        let error = folder.fail(65, &["bad.toml", "-o", "f.exr"]);
        assert!(error.contains(message), "{error}");
    }
    Ok(())
}
