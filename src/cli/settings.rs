//! The flags that set keys of the scene file: one field each, whose id is the path of the key.

use std::path::Path;

use batch_render::{
    describe::{Overrides, Stage, number_or_text},
    error::Error as JobError,
    sampler::SeedMode,
};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, Error, FromArgMatches, parser::ValueSource};

use super::{
    heading::{OUTPUT, PICTURE, STAGE},
    preview::is_animated,
    stream::STANDARD_OUTPUT,
    values::{assignment, color, positive, resolution, sun},
};

/// The declarations of the flags, in the order in which they are applied.
#[derive(Args)]
#[allow(dead_code, reason = "values are found by the ids of the arguments")]
struct Flags {
    /// Output files: out.####.exr, film.gif, or - for standard output; repeatable
    ///
    /// They replace those of the scene. The ending is the format: .exr, .npz, .png or .jpg. #### may be %04d or $F4. A file .gif or
    /// .apng is one animated picture of all frames.
    #[arg(id = "output.files", short, long = "output", value_name = "PATTERN", help_heading = OUTPUT)]
    output: Vec<String>,

    /// Compression of EXR files: zips, zip, piz, rle, none, or the lossy dwaa
    #[arg(id = "output.compression", long = "compression", value_name = "NAME", hide_short_help = true, help_heading = OUTPUT)]
    compression: Option<String>,

    /// Type of the numbers of light in EXR files: half or float
    #[arg(id = "output.exr_type", long = "exr-type", value_name = "TYPE", hide_short_help = true, help_heading = OUTPUT)]
    exr_type: Option<String>,

    /// Make each layer of an EXR file a part of its own
    #[arg(id = "output.multipart", long = "multipart", hide_short_help = true, help_heading = OUTPUT)]
    multipart: bool,

    /// Store EXR files in tiles of 64x64 pixels instead of lines
    #[arg(id = "output.tiled", long = "tiled", hide_short_help = true, help_heading = OUTPUT)]
    tiled: bool,

    /// Bits of PNG files: 8, 8-dithered or 16
    #[arg(id = "output.png_bits", long = "png-bits", value_name = "BITS", hide_short_help = true, help_heading = OUTPUT)]
    png_bits: Option<String>,

    /// Quality of JPEG files, from 1 to 100 [default: the scene's, or 95]
    #[arg(id = "output.jpeg_quality", long = "jpeg-quality", value_name = "N", allow_hyphen_values = true, hide_short_help = true, help_heading = OUTPUT)]
    jpeg_quality: Option<String>,

    /// Compression of NPZ files: none (arrays may be mapped) or deflate
    #[arg(id = "output.npz_compression", long = "npz-compression", value_name = "NAME", hide_short_help = true, help_heading = OUTPUT)]
    npz_compression: Option<String>,

    /// Samples per pixel; with --noise-threshold the most
    #[arg(id = "render.samples", long = "samples", visible_alias = "max-samples", value_name = "N", help_heading = PICTURE)]
    samples: Option<String>,

    /// Error of what is shown at which a block of pixels has enough samples, such as 0.01 (adaptive sampling)
    ///
    /// 0 gives every pixel --max-samples. Without this flag the scene file decides.
    #[arg(id = "render.samples.threshold", long = "noise-threshold", value_name = "ERROR", hide_short_help = true, help_heading = PICTURE)]
    noise_threshold: Option<String>,

    /// Samples that every pixel gets with adaptive sampling [default: the scene's, or 16]
    #[arg(id = "render.samples.min", long = "min-samples", value_name = "N", hide_short_help = true, help_heading = PICTURE)]
    min_samples: Option<String>,

    /// Width and height in pixels
    #[arg(id = "render", long = "resolution", value_name = "WxH", value_parser = resolution, help_heading = PICTURE)]
    resolution: Option<[u32; 2]>,

    /// Seed of the random numbers
    #[arg(id = "render.seed", long = "seed", value_name = "N", hide_short_help = true, help_heading = PICTURE)]
    seed: Option<String>,

    /// Whether the noise changes from frame to frame
    #[arg(id = "render.seed_mode", long = "seed-mode", value_name = "MODE", value_parser = SeedMode::ALL.map(SeedMode::name), hide_short_help = true, help_heading = PICTURE)]
    seed_mode: Option<String>,

    /// Integrator, such as path or whitted
    ///
    /// It keeps the scene's settings if the scene uses the same one, and has its default settings otherwise.
    #[arg(id = "render.integrator", long = "integrator", value_name = "NAME", hide_short_help = true, help_heading = PICTURE)]
    integrator: Option<String>,

    /// Passes of EXR and NPZ files beside the beauty: depth,N,denoise or all
    #[arg(id = "output.aovs", long = "aovs", value_name = "LIST", value_delimiter = ',', conflicts_with = "output.show", help_heading = PICTURE)]
    aovs: Vec<String>,

    /// Mattes of each pixel that Cryptomatte passes keep, an even number up to 16
    #[arg(id = "output.cryptomatte_levels", long = "cryptomatte-levels", value_name = "N", hide_short_help = true, help_heading = PICTURE)]
    cryptomatte_levels: Option<String>,

    /// One pass in place of the beauty, such as depth
    #[arg(id = "output.show", long = "show", value_name = "PASS", hide_short_help = true, help_heading = PICTURE)]
    show: Option<String>,

    /// Display transform of PNG and JPEG files and films, such as srgb or raw
    #[arg(id = "output.view", long = "view", value_name = "NAME", hide_short_help = true, help_heading = PICTURE)]
    view: Option<String>,

    /// Exposure of PNG and JPEG files and films, in stops, or auto: that which suits the first frame
    #[arg(id = "output.exposure", long = "exposure", value_name = "STOPS", allow_hyphen_values = true, hide_short_help = true, help_heading = PICTURE)]
    exposure: Option<String>,

    /// Environment map that lights the scene and is seen behind it, HDR or EXR, in place of the sky
    #[arg(id = "stage.environment", long = "environment", value_name = "FILE", hide_short_help = true, help_heading = STAGE)]
    environment: Option<String>,

    /// Color that is seen behind the scene and lights nothing: 0.18, 1,0.9,0.8 (linear light) or '#rrggbb' (sRGB)
    #[arg(id = "stage.backdrop", long = "background", value_name = "COLOR", value_parser = color, hide_short_help = true, help_heading = STAGE)]
    background: Option<toml::Value>,

    /// Direction of the sun in degrees, such as 30,45, and its irradiance in W/m2: turns that of the scene, or adds one
    ///
    /// The azimuth 0 is +z, where the default camera stands, and 90 is +x; the elevation 90 is +y, straight above. The azimuth of a
    /// [background] sky counts from -z, its north, clockwise: 180 there is 0 here.
    #[arg(id = "stage.sun", long = "sun", value_name = "AZIMUTH,ELEVATION[,IRRADIANCE]", value_parser = sun, allow_hyphen_values = true, hide_short_help = true, help_heading = STAGE)]
    sun: Option<toml::Value>,

    /// Focal length in mm of the scene's camera, with a sensor that is 36 mm wide
    #[arg(id = "stage.lens", long = "lens", value_name = "MM", value_parser = positive, allow_negative_numbers = true, hide_short_help = true, help_heading = STAGE)]
    lens: Option<toml::Value>,

    /// F-number of its lens, such as 2.8; it focuses on the target, unless the scene says where
    #[arg(id = "stage.fstop", long = "fstop", value_name = "N", value_parser = positive, allow_negative_numbers = true, hide_short_help = true, help_heading = STAGE)]
    fstop: Option<toml::Value>,

    /// A value of the scene by its name, such as light.key.point.intensity=90; repeatable
    #[arg(id = "set", long = "set", value_name = "NAME=VALUE", value_parser = assignment, hide_short_help = true, help_heading = PICTURE)]
    set: Vec<(String, toml::Value)>,
}

/// The id of `--output`.
const OUTPUT_FILES: &str = "output.files";

/// The values of the flags that set keys of the scene file.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    pub overrides: Overrides,
    /// The patterns of the files of frames by `--output`.
    pub files: Vec<String>,
    /// Whether frames go to standard output (`-o -`).
    pub has_stream: bool,
    /// The names of animated pictures of whole sequences (`-o film.gif`).
    pub films: Vec<String>,
}

impl Settings {
    /// Whether a name of `--output` is that of standard output or a film, and keeps it then.
    fn takes(&mut self, name: &str) -> bool {
        let is_film = is_animated(Path::new(name));
        self.has_stream |= name == STANDARD_OUTPUT;
        self.films.extend(is_film.then(|| name.to_owned()));
        is_film || name == STANDARD_OUTPUT
    }

    /// Refuses standard output and films, for commands that have no frames.
    pub fn refuse_stream(&self) -> Result<(), JobError> {
        let message = "-o - and -o film.gif: only a job that this command runs itself writes to standard output or an animated picture";
        match self.has_stream || !self.films.is_empty() {
            true => Err(JobError::Usage(message.to_owned())),
            false => Ok(()),
        }
    }
}

impl Args for Settings {
    fn augment_args(command: Command) -> Command {
        Flags::augment_args(command)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Flags::augment_args_for_update(command)
    }
}

impl FromArgMatches for Settings {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let mut settings = Self::default();
        settings.update_from_arg_matches(matches)?;
        Ok(settings)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        let flags = Flags::augment_args(Command::new(""));
        let is_typed = |arg: &&Arg| matches.value_source(arg.get_id().as_str()) == Some(ValueSource::CommandLine);
        for arg in flags.get_arguments().filter(is_typed) {
            let key = arg.get_id().as_str();
            let flag = format!("--{}", arg.get_long().expect("all have long names"));
            let stage = Stage::ALL
                .into_iter()
                .find(|stage| key.strip_prefix("stage.") == Some(stage.name()));
            if let Some(stage) = stage {
                let value = match matches.try_get_one::<toml::Value>(key) {
                    Ok(value) => value.cloned(),
                    Err(_) => matches.get_one::<String>(key).map(|text| text.as_str().into()),
                };
                value
                    .into_iter()
                    .for_each(|value| self.overrides.set_stage(&flag, stage, value));
            } else if let Ok(Some([width, height])) = matches.try_get_one::<[u32; 2]>(key) {
                self.overrides.set(&flag, "render.width", *width);
                self.overrides.set(&flag, "render.height", *height);
            } else if let Ok(Some(all)) = matches.try_get_many::<(String, toml::Value)>(key) {
                all.for_each(|(key, value)| self.overrides.set(&format!("{flag} {key}"), key, value.clone()));
            } else if let ArgAction::SetTrue = arg.get_action() {
                self.overrides.set(&flag, key, true);
            } else if let ArgAction::Append = arg.get_action() {
                let mut texts: Vec<String> = matches.get_many(key).into_iter().flatten().cloned().collect();
                if key == OUTPUT_FILES {
                    texts.retain(|text| !self.takes(text));
                    self.files.clone_from(&texts);
                }
                if !texts.is_empty() {
                    self.overrides.set(&flag, key, texts);
                }
            } else if let Some(text) = matches.get_one::<String>(key) {
                self.overrides.set(&flag, key, number_or_text(text));
            }
        }
        Ok(())
    }
}
