//! The request that arguments make.

use std::path::{Path, PathBuf};

use batch_render::{
    accel::BuildOptions,
    batch::{DenoiseSteps, Existing, FrameRange, OnFailure, Policy, Request, Views, metadata::Sidecar},
    error::Error,
    shape::mesh::AnimationChoice,
    simd::Isa,
    value::UnknownName,
    warnings::Warnings,
};

use super::{
    args::RenderArgs,
    figure_files::{ALBUM, PAGE},
    memory,
    outlets::Outlets,
    standard_input,
};

/// The request that the arguments with these outlets make.
pub fn request(args: &RenderArgs, outlets: &Outlets, simd: Isa) -> Result<Request, Error> {
    let range: Option<FrameRange> = args
        .range
        .as_deref()
        .map(|text| text.parse().map_err(|e| Error::Usage(format!("--range: {e}"))))
        .transpose()?;
    let part = args.part.map(|part| part.counted_from(args.part_base.into()));
    let part = part.transpose().map_err(|e| Error::Usage(format!("--part: {e}")))?;
    if args.denoise.is_some() && args.part.is_some() && args.denoise_step.is_none() {
        let message = "--part with --denoise: a frame is denoised with those around it, which other parts render. Render the \
                       parts with --denoise-step render, and denoise them with --denoise-step denoise";
        return Err(Error::Usage(message.to_owned()));
    }
    let files = [
        ("stats", &args.stats),
        ("report", &args.report),
        ("preview", &args.preview),
    ];
    let is_stream = |(_, path): &(&str, &Option<PathBuf>)| path.as_deref() == Some(Path::new("-"));
    if let Some((flag, _)) = files.into_iter().find(is_stream) {
        let message = format!("--{flag} -: only frames go to standard output (-o -); a file of this name is ./-");
        return Err(Error::Usage(message));
    }
    let existing = match (args.existing.skips(), args.existing.fail_existing) {
        (true, _) => Existing::Skip,
        (_, true) => Existing::Fail,
        _ => Existing::Overwrite,
    };
    let sidecars: Result<Vec<Sidecar>, UnknownName> = args.metadata.iter().map(|name| name.parse()).collect();
    Ok(Request {
        overrides: args.settings.overrides.clone(),
        supplied: standard_input::read(args.scene.as_deref(), args.input_format.as_deref())?,
        taken: outlets.taken(),
        camera_path: args.frames.clone(),
        values: args.values.clone(),
        random: args.random.clone(),
        turntable: args.turntable,
        views: views(args)?,
        stereo: args.views.stereo.and_then(|stereo| stereo.eye()),
        second_eye: args.views.stereo.and_then(|stereo| stereo.second()),
        frame_to_fit: args.frame_to_fit,
        ground: args.ground,
        normalise: args.normalise,
        range,
        part,
        policy: Policy {
            existing,
            // A stream with a gap is another film.
            on_failure: if args.fail_fast || outlets.stream.is_some() {
                OnFailure::FailFast
            } else {
                OnFailure::KeepGoing
            },
            retries: args.retries,
            if_busy: args.if_busy.into(),
            checkpoint: args.checkpoint,
            keep_sums: args.keep_sums,
        },
        time_limit: args.time_limit,
        sample_ranges: args.sample_range,
        crop: args.crop,
        denoise: args
            .denoise
            .map(|filter| super::denoise::options(filter, args.temporal, args.oidn_lib.as_deref())),
        denoise_steps: args.denoise_step.map_or(DenoiseSteps::Both, DenoiseSteps::from),
        metadata: sidecars.map_err(|unknown| Error::Usage(format!("--metadata: {unknown}")))?,
        categories: args.categories,
        png_depth: args.png_depth.clone(),
        png_normals: args.png_normals.clone(),
        png_ids: args.png_ids.clone(),
        png_depth_unit: args.png_depth_unit,
        files_of_caller: files_of_caller(args, &outlets.films),
        overscan: args.overscan,
        accel: BuildOptions {
            simd,
            ..args.accel.into()
        },
        fps: args.fps,
        rotation_order: args.rotation_order,
        max_memory: Some(args.max_memory.unwrap_or_else(memory::default_limit)),
        texture_memory: Some(args.texture_memory.unwrap_or_else(memory::default_textures)),
        missing_assets: args.missing_assets.into(),
        allow_outside: args.allow_outside,
        strict: args.strict,
        camera: args.camera.clone(),
        animation: animation(&args.animation),
        variant: args.variant.clone(),
        light_units: args.light_units,
        point_radius: args.point_radius,
        warnings: Warnings::default(),
    })
}

/// The views that the arguments ask for, if any.
fn views(args: &RenderArgs) -> Result<Option<Views>, Error> {
    let (sets, fit) = (args.views.views.clone(), args.views.fit);
    if !(fit > 0.0 && fit <= 1.0) {
        return Err(Error::Usage(format!(
            "--fit: expected a number above 0 and at most 1, found {fit}"
        )));
    }
    Ok((!sets.is_empty()).then_some(Views { sets, fit }))
}

/// The animations that these names choose, if any.
pub(super) fn animation(names: &[String]) -> Option<AnimationChoice> {
    match names {
        [] => None,
        [name] => Some(AnimationChoice::of_name(name)),
        names => Some(AnimationChoice::Named(names.to_vec())),
    }
}

/// The files that the program writes beside those of the job.
pub(super) fn files_of_caller(args: &RenderArgs, films: &[PathBuf]) -> Vec<PathBuf> {
    let report = args
        .report
        .iter()
        .flat_map(|folder| [PAGE, ALBUM].map(|name| folder.join(name)));
    let files = args.stats.iter().chain(&args.preview).chain(films).cloned();
    files.chain(report).chain(args.of_command.iter().cloned()).collect()
}
