//! `batch-render fly`.

use std::{
    net::SocketAddr,
    process::{Command, Stdio},
    sync::Arc,
};

use batch_render::{
    accel::BuildOptions,
    batch::Request,
    render::Cancel,
    simd::Isa,
    viewer::{Viewer, ViewerOptions},
};

use super::{fly_args::FlyArgs, memory, progress::say, signals, threads::threads};

/// Serves the page until a signal comes.
pub fn run(args: &FlyArgs, simd: Isa) -> anyhow::Result<()> {
    let request = Request {
        outputs: args.output.clone(),
        resolution: args.resolution,
        samples: args.samples,
        integrator: args.integrator.clone(),
        camera: args.camera.clone(),
        fps: args.fps,
        rotation_order: args.rotation_order,
        max_memory: Some(args.max_memory.unwrap_or_else(memory::default_limit)),
        texture_memory: Some(args.texture_memory.unwrap_or_else(memory::default_textures)),
        variant: args.variant.clone(),
        point_radius: args.point_radius,
        allow_outside: args.allow_outside,
        accel: BuildOptions {
            simd,
            ..BuildOptions::default()
        },
        ..Request::default()
    };
    let options = ViewerOptions {
        listen: SocketAddr::new(args.listen, args.port),
        camera_path: args.frames.clone(),
        command: command(args),
    };
    if !args.listen.is_loopback() {
        tracing::warn!(
            "the page is served on {} to whoever knows its address, without encryption: others can read it on the way",
            args.listen
        );
    }
    let pool = threads(args.threads)?;
    let viewer = pool.install(|| Viewer::open(&args.scene, &request, &options))?;
    let stop = Arc::new(Cancel::default());
    signals::listen(Arc::clone(&stop), Arc::default())?;
    let url = viewer.url();
    say(&format!(
        "{url}\nthe camera path is {}; Ctrl-C ends",
        args.frames.display()
    ));
    if args.open {
        open(&url);
    }
    let threads = pool.current_num_threads();
    // The viewer has threads of its own.
    drop(pool);
    Ok(viewer.run(threads, &stop)?)
}

/// The command of the job, without the camera path and what a look may change.
fn command(args: &FlyArgs) -> Vec<String> {
    let mut words = vec!["batch-render".to_owned(), args.scene.display().to_string()];
    let mut add = |flag: &str, value: Option<String>| {
        if let Some(value) = value {
            words.extend([format!("--{flag}"), value]);
        }
    };
    for pattern in &args.output {
        add("output", Some(pattern.clone()));
    }
    add("resolution", args.resolution.map(|[w, h]| format!("{w}x{h}")));
    add("samples", args.samples.map(|n| n.to_string()));
    add("integrator", args.integrator.clone());
    add("camera", args.camera.clone());
    add("fps", args.fps.map(|fps| fps.to_string()));
    add("rotation-order", args.rotation_order.map(|order| order.to_string()));
    add("texture-memory", args.texture_memory.map(|bytes| bytes.to_string()));
    add("variant", args.variant.clone());
    add("point-radius", args.point_radius.map(|radius| radius.to_string()));
    if args.allow_outside {
        words.push("--allow-outside".to_owned());
    }
    words
}

/// Opens the page with the program that the system opens addresses with.
fn open(url: &str) {
    let program = if cfg!(target_os = "macos") {
        "open"
    } else if cfg!(windows) {
        "explorer"
    } else {
        "xdg-open"
    };
    let mut command = Command::new(program);
    command
        .arg(url)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    if let Err(error) = command.spawn() {
        tracing::warn!("cannot open the browser: {error}: {program}");
    }
}
