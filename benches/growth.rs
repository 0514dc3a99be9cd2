//! Growth of the time of a picture with the triangles of one and the same terrain:
//! `cargo bench --bench growth -- OUT.svg 10000 100000 1000000 10000000`. Prints a row for each number of triangles, the best of
//! three pictures, and draws the times over the logarithm of the triangles. Without arguments it prints up to a million.

use std::{error::Error, fmt::Write, time::Instant};

use batch_render::{
    accel::AccelKind,
    camera::{Camera, Lens, LookAt, Pose, perspective::PerspectiveLens},
    integrator::IntegratorDesc,
    material::{Material, matte::Matte},
    math::{DVec3, Rgb, Vec3, trig},
    render::{Control, Counters, Renderer, Settings},
    scene::{Background, SceneBuilder},
    shape::mesh::Mesh,
    texture::Color,
};

/// Hills over a square of 20 m, `side` squares along each side.
fn terrain(side: u32) -> Mesh {
    let point = |i: u32| {
        let [x, z] = [i % (side + 1), i / (side + 1)].map(|k| 20.0 * (k as f32 / side as f32 - 0.5));
        let hills = [(0.4, 0.9), (1.1, 0.35), (2.9, 0.12), (7.3, 0.04), (17.0, 0.015)];
        let height = hills.map(|(f, a)| a * trig::sin(f * x + 0.7 * f) * trig::cos(f * z - 0.3 * f * x));
        Vec3::new(x, height.iter().sum(), z)
    };
    let corners = |i: u32| [i, i + side + 1, i + side + 2, i + 1];
    let squares = (0..side * side).map(|k| corners(k / side * (side + 1) + k % side));
    Mesh {
        positions: (0..(side + 1) * (side + 1)).map(point).collect(),
        triangles: squares.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..Mesh::default()
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1).filter(|a| a != "--bench");
    let out = args.next();
    let mut counts: Vec<u32> = args.map(|n| n.parse()).collect::<Result<_, _>>()?;
    if counts.is_empty() {
        counts = vec![10_000, 100_000, 1_000_000];
    }
    let settings = Settings::new([640, 360], 16);
    let pose = Pose::look_at(DVec3::new(6.0, 4.0, 9.0), &LookAt::new(DVec3::new(0.0, 0.0, 0.0)))?;
    let lens = Lens::Perspective(PerspectiveLens::vertical(45.0));
    let camera = Camera::new(&pose, &lens, settings.resolution);
    let path = IntegratorDesc::default().compile().map_err(|problem| problem.message)?;
    let mut points = Vec::new();
    println!("| triangles | tree, s | picture, s | rays, M | ns a ray |\n|---|---|---|---|---|");
    for count in counts {
        let mut scene = SceneBuilder::new(Background::new(Rgb::WHITE));
        let gray = scene.material(Material::Matte(Matte::smooth(Color::Constant(Rgb::gray(0.6)))));
        let mesh = terrain((f64::from(count) / 2.0).sqrt().round() as u32);
        let triangles = mesh.triangles.len();
        scene.mesh("terrain", mesh, gray)?;
        let scene = scene.build(AccelKind::default())?;
        let picture = || {
            let (counters, start) = (Counters::default(), Instant::now());
            let control = Control {
                counters: Some(&counters),
                ..Control::default()
            };
            let film = Renderer::new().render(&scene, &camera.into(), path.as_dyn(), &settings, &control);
            film.expect("nobody cancels");
            (start.elapsed().as_secs_f64(), counters.rays() as f64)
        };
        let (seconds, rays) = (0..3)
            .map(|_| picture())
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .expect("three");
        let tree = scene.geometry.accel.stats().build_time.as_secs_f64();
        println!(
            "| {triangles} | {tree:.2} | {seconds:.2} | {:.1} | {:.0} |",
            rays / 1e6,
            1e9 * seconds / rays
        );
        points.push((triangles as f64, seconds));
    }
    if let Some(out) = out {
        std::fs::write(out, plot(&points)?)?;
    }
    Ok(())
}

fn plot(points: &[(f64, f64)]) -> Result<String, std::fmt::Error> {
    let top = points.iter().fold(0.0_f64, |a, p| a.max(p.1)) * 1.15;
    let place = |&(n, s): &(f64, f64)| (60.0 + 100.0 * (n.log10() - 3.5), 270.0 - 240.0 * s / top);
    let mut svg = String::from(
        "<svg xmlns='http://www.w3.org/2000/svg' width='480' height='310' font-family='sans-serif' font-size='12'>\n<rect width='480' height='310' fill='white'/>\n<path d='M60 20V270H450' fill='none' stroke='black'/>\n<text x='250' y='303' text-anchor='middle'>triangles</text>\n<text x='64' y='16'>seconds a picture</text>\n<path fill='none' stroke='#06c' stroke-width='2' d='",
    );
    for (i, p) in points.iter().map(place).enumerate() {
        write!(svg, "{}{:.1} {:.1}", if i == 0 { 'M' } else { 'L' }, p.0, p.1)?;
    }
    svg += "'/>\n";
    for point in points {
        let ((x, y), (n, s)) = (place(point), point);
        writeln!(
            svg,
            "<circle cx='{x:.1}' cy='{y:.1}' r='4' fill='#06c'/><text x='{x:.1}' y='{:.1}' text-anchor='middle'>{s:.2}</text>",
            y - 10.0
        )?;
        writeln!(svg, "<text x='{x:.1}' y='286' text-anchor='middle'>{n:.0}</text>")?;
    }
    Ok(svg + "</svg>\n")
}
