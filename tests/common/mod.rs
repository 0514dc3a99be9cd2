//! A folder to work in and the program to run there.

#![allow(dead_code, reason = "each test binary uses its own part")]

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use exr::prelude::{FlatImage, read_all_flat_layers_from_file};
use libtest_mimic::{Failed, Trial};

/// A temporary folder, gone at the end.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, text).expect("writable");
        path
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// The pixels of the one picture that the program makes of a scene, row by row from the top.
    pub fn render(&self, scene: &str) -> Vec<[f32; 3]> {
        self.write("s.toml", scene);
        self.succeed(&["s.toml", "--progress", "none", "-o", "f.exr"]);
        pixels(&self.path("f.exr")).1
    }

    /// All layers of an EXR file.
    pub fn open_exr(&self, name: &str) -> FlatImage {
        read_all_flat_layers_from_file(self.path(name)).expect("an EXR")
    }

    /// The names in it, sorted.
    pub fn names(&self) -> Vec<String> {
        names(self.0.path())
    }

    /// The program, started here.
    pub fn program(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_batch-render"));
        command.current_dir(self.0.path());
        command
    }

    /// The program, which takes SIGINT even where this test runs in the background of a shell that ignores it.
    pub fn program_with_signals(&self) -> Command {
        if !cfg!(target_os = "linux") {
            return self.program();
        }
        let mut command = Command::new("env");
        command
            .args(["--default-signal=INT,TERM", env!("CARGO_BIN_EXE_batch-render")])
            .current_dir(self.0.path());
        command
    }

    /// Runs a command that the program printed, in the shell for which it is quoted, and demands success.
    pub fn run_printed(&self, command: &str) {
        #[cfg(unix)]
        let mut shell = Command::new("sh");
        #[cfg(unix)]
        shell.args(["-c", command]);
        #[cfg(windows)]
        let mut shell = Command::new("cmd");
        // The command prompt takes the outer quotes away and reads the rest as it is.
        #[cfg(windows)]
        std::os::windows::process::CommandExt::raw_arg(shell.arg("/s").arg("/c"), format!("\"{command}\""));
        let status = shell.current_dir(self.0.path()).status().expect("a shell");
        assert!(status.success(), "{command}");
    }

    /// Runs the program with these arguments.
    pub fn run(&self, args: &[&str]) -> Output {
        self.program().args(args).output().expect("the program starts")
    }

    /// Runs the program and demands success.
    pub fn succeed(&self, args: &[&str]) -> String {
        let output = self.run(args);
        assert!(output.status.success(), "{args:?}: {}", stderr(&output));
        String::from_utf8(output.stdout).expect("UTF-8")
    }

    /// Runs the program, demands this exit code, and returns what it says on stderr.
    pub fn fail(&self, code: i32, args: &[&str]) -> String {
        let output = self.run(args);
        assert_eq!(output.status.code(), Some(code), "{args:?}: {}", stderr(&output));
        stderr(&output)
    }
}

pub fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<_> = entries
        .map(|e| e.expect("readable").file_name().into_string().expect("UTF-8"))
        .collect();
    names.sort();
    names
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("UTF-8")
}

/// The name of the scene of a kind, without its ending. Where two rooms have a kind of the name, one of the two is named after its room.
pub fn kind_scene(room: &str, kind: &str) -> String {
    let own = format!("{room}-{kind}");
    let exists = repo(&format!("scenes/kinds/{own}.toml")).is_file();
    if exists { own } else { kind.to_owned() }
}

/// A file of the repository.
pub fn repo(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

pub fn repo_str(path: &str) -> String {
    repo(path).to_str().expect("UTF-8").to_owned()
}

/// A small scene that uses every material, a filter and several samples, and reflects.
pub const SMALL_SCENE: &str = r#"
[render]
width = 70
height = 50
samples = 20
seed = 7
integrator.whitted = { max_depth = 4, ambient = 0.1 }

[camera]
perspective = { eye = [0, 2, 6], target = [0, 0.8, 0], fov = 40, aperture_radius = 0.05, focus_distance = 6 }

[background]
color = [0.2, 0.4, 0.8]

[texture.board]
checker = { a = [0.9, 0.9, 0.9], b = [0.1, 0.1, 0.1], scale = 6 }

[material.floor]
matte = { albedo = "texture.board" }
[material.mirror]
mirror = { reflectance = 0.9 }
[material.red]
phong = { color = [0.8, 0.1, 0.1], specular = 0.5, reflect = 0.2 }

[[object]]
material = "floor"
shape.quad = { corners = [[-4, 0, 4], [4, 0, 4], [4, 0, -4], [-4, 0, -4]] }
[[object]]
material = "mirror"
shape.sphere = { center = [-1, 1, 0], radius = 1 }
[[object]]
material = "red"
shape.cone = { base = [1.2, 0, 0.5], radius = 0.8, height = 1.6 }
[[object]]
material = "red"
shape.cylinder = { base = [0, 0, 1.6], radius = 0.3, height = 0.6 }
transform = { rotate = [0, 0, 10], scale = [1, 1, 2] }

[[light]]
point = { position = [3, 5, 4], intensity = 60 }
[[light]]
sun = { direction = [1, -2, -1], irradiance = 1 }
[[light]]
spot = { position = [0, 4, 2], target = [0, 0, 0], cone_angle = 30, penumbra_angle = 10, intensity = 40 }
"#;

/// Five frames, the middle three between keys.
pub const SMALL_PATH: &str = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n1,0,2,6,0,0.8,0\n5,2,2,5,0,0.8,0\n";

/// A triangle that two animations move, each over half a second.
pub const MOVING_MODEL: &str = r#"{"asset": {"version": "2.0"}, "buffers": [{"byteLength": 68, "uri":
    "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAA="}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8},
    {"buffer": 0, "byteOffset": 44, "byteLength": 24}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
    {"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [0.5]},
    {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": [{"mesh": 0}],
    "animations": [{"name": "Walk", "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
    "samplers": [{"input": 1, "output": 2}]},
    {"name": "Run", "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
    "samplers": [{"input": 1, "output": 2}]}]}"#;

/// A test of files that may not be part of the project, in the folder that the variable `BATCH_RENDER_ASSETS` names.
/// The test is ignored where one of `files` is not there, with the reason beside its name.
pub fn asset_trial(
    name: impl Into<String>,
    files: &[&str],
    test: impl FnOnce(&Path) -> Result<(), Failed> + Send + 'static,
) -> Trial {
    let folder = std::env::var_os("BATCH_RENDER_ASSETS").map(PathBuf::from);
    let missing = match folder.as_deref().filter(|f| f.is_dir()) {
        None => Some("needs the folder BATCH_RENDER_ASSETS".to_owned()),
        Some(folder) => {
            let file = files.iter().find(|file| !folder.join(file).is_file());
            file.map(|file| format!("needs {file} in BATCH_RENDER_ASSETS"))
        }
    };
    let kind = missing.clone().unwrap_or_default();
    let ignored = missing.is_some();
    let run = move || match (missing, folder) {
        (None, Some(folder)) => test(&folder),
        (missing, _) => Err(missing.unwrap_or_default().into()),
    };
    Trial::test(name, run).with_kind(kind).with_ignored_flag(ignored)
}

/// All files below a folder, sorted.
pub fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        let entries = fs::read_dir(&folder).into_iter().flatten();
        for path in entries.map(|e| e.expect("readable").path()) {
            if path.is_dir() {
                folders.push(path);
            } else {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// The width of an EXR, and red, green and blue of its pixels, row by row from the top.
pub fn pixels(file: &Path) -> (usize, Vec<[f32; 3]>) {
    let image = exr::prelude::read_first_rgba_layer_from_file(
        file,
        |size, _| (size.width(), vec![[0.0; 3]; size.area()]),
        |(width, pixels), at, (r, g, b, _): (f32, f32, f32, f32)| pixels[at.y() * *width + at.x()] = [r, g, b],
    );
    image.expect("an EXR").layer_data.channel_data.pixels
}
