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

use super::{
    fly_args::FlyArgs, log, memory, progress::say, replay::Replay, request::animation, signals, threads::threads,
};

/// Serves the page until a signal comes.
pub fn run(args: &FlyArgs, simd: Isa) -> anyhow::Result<()> {
    args.settings.refuse_stream()?;
    let request = Request {
        overrides: args.settings.overrides.clone(),
        values: args.values.clone(),
        random: args.random.clone(),
        camera: args.camera.clone(),
        animation: animation(&args.animation),
        fps: args.fps,
        rotation_order: args.rotation_order,
        max_memory: Some(args.max_memory.unwrap_or_else(memory::default_limit)),
        texture_memory: Some(args.texture_memory.unwrap_or_else(memory::default_textures)),
        variant: args.variant.clone(),
        light_units: args.light_units,
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
        command,
    };
    if !args.listen.is_loopback() {
        tracing::warn!(
            "the page is served on {} to whoever knows its address, without encryption: others can read it on the way",
            args.listen
        );
    }
    let pool = threads(args.threads)?;
    let _last = log::LastWarnings(request.warnings.clone());
    let viewer = pool.install(|| Viewer::open(&args.scene, &request, &options))?;
    log::warnings(&request.warnings);
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
    // The viewer starts its own threads.
    drop(pool);
    Ok(viewer.run(threads, &stop)?)
}

/// The command of the job, with these values instead of the given ones.
fn command(changes: &[(&str, String)]) -> String {
    // Flags of the viewer alone.
    const OWN: [&str; 8] = [
        "frames",
        "port",
        "listen",
        "open",
        "threads",
        "max-memory",
        "verbose",
        "quiet",
    ];
    let Ok(replay) = Replay::of_process() else {
        return String::new();
    };
    let change = |replay: Replay, (flag, value): &(&str, String)| replay.with(flag, value);
    changes.iter().fold(replay.without(&OWN), change).shell_line()
}

/// Opens the page in the system's browser.
fn open(url: &str) {
    let (program, words): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        // Explorer takes an address with a query for a folder.
        ("rundll32", &["url.dll,FileProtocolHandler"])
    } else {
        ("xdg-open", &[])
    };
    let mut command = Command::new(program);
    command
        .args(words)
        .arg(url)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    if let Err(error) = command.spawn() {
        tracing::warn!("cannot open the browser: {error}: {program}");
    }
}
