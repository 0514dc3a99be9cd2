//! Writes the triangles of a subdivided model as an OBJ file to the standard output:
//!
//! ```sh
//! cargo run --example subdivide -- scenes/cube/cube.obj 2 > smooth.obj
//! ```
//!
//! After the number of levels may come a scheme (`catmull-clark`, `loop`, `linear`), the angle of creases in degrees, their sharpness in
//! levels, and the rule of boundaries (`smooth`, `corners`).

use std::{
    env,
    error::Error,
    io::{BufWriter, Write, stdout},
    path::PathBuf,
};

use batch_render::{
    assets::{
        Store,
        model::{ModelChoice, Subdivision},
        store::ModelRequest,
    },
    shape::mesh::Bits,
};

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = env::args().skip(1);
    let path = PathBuf::from(args.next().ok_or("expected the path of a model")?);
    let levels = args.next().ok_or("expected a number of levels")?.parse()?;
    let mut how = Subdivision::of_levels(levels);
    how.scheme = args.next().map(|name| name.parse()).transpose()?;
    how.crease_angle = args.next().map(|n| n.parse().map(Bits::new)).transpose()?;
    if let Some(sharpness) = args.next() {
        how.crease_sharpness = Bits::new(sharpness.parse()?);
    }
    if let Some(rule) = args.next() {
        how.boundary = rule.parse()?;
    }
    let choice = ModelChoice {
        subdivision: Some(how),
        ..ModelChoice::default()
    };
    let model = Store::default().model(&ModelRequest { path, choice })?;
    let mut out = BufWriter::new(stdout().lock());
    let (mut first, mut first_uv, mut first_normal) = (1, 1, 1);
    for part in &model.instances {
        let mesh = &model.meshes[part.mesh];
        for p in &mesh.positions {
            let p = part.model_from_mesh.transform_point3(p.as_dvec3());
            writeln!(out, "v {} {} {}", p.x, p.y, p.z)?;
        }
        let normals_to_model = part.model_from_mesh.matrix3.inverse().transpose();
        for n in &mesh.normals {
            let n = (normals_to_model * n.as_dvec3()).normalize_or_zero();
            writeln!(out, "vn {} {} {}", n.x, n.y, n.z)?;
        }
        for uv in &mesh.uvs {
            writeln!(out, "vt {} {}", uv.x, uv.y)?;
        }
        for corners in &mesh.triangles {
            let [a, b, c] = corners.map(|v| {
                let (p, uv, n) = (v + first, v + first_uv, v + first_normal);
                match (mesh.uvs.is_empty(), mesh.normals.is_empty()) {
                    (true, true) => format!("{p}"),
                    (false, true) => format!("{p}/{uv}"),
                    (true, false) => format!("{p}//{n}"),
                    (false, false) => format!("{p}/{uv}/{n}"),
                }
            });
            writeln!(out, "f {a} {b} {c}")?;
        }
        first_uv += mesh.uvs.len() as u32;
        first_normal += mesh.normals.len() as u32;
        first += mesh.positions.len() as u32;
    }
    out.flush()?;
    Ok(())
}
