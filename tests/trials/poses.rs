//! Vertices of animated models equal those of a plain evaluation of their files, in double precision and written for this test alone.
//!
//! The models are in the folder `gltf/khronos` of the one that `BATCH_RENDER_ASSETS` names.

use std::{collections::BTreeMap, fs, path::Path};

use batch_render::{
    batch::{Job, Request},
    geometry::InstanceId,
    scene::Scene,
    shape::mesh::AnimationChoice,
};
use glam::{DMat4, DQuat, DVec3, DVec4};
use libtest_mimic::{Failed, Trial};
use serde_json::Value;

/// The models, and an animation of theirs; without a name all are played.
const MODELS: [(&str, Option<&str>); 12] = [
    ("AnimatedCube/glTF/AnimatedCube.gltf", None),
    ("AnimatedMorphCube/glTF/AnimatedMorphCube.gltf", None),
    ("AnimatedTriangle/glTF/AnimatedTriangle.gltf", None),
    ("BoxAnimated/glTF/BoxAnimated.gltf", None),
    ("CesiumMan/glTF/CesiumMan.gltf", None),
    ("Fox/glTF-Binary/Fox.glb", Some("Survey")),
    ("Fox/glTF-Binary/Fox.glb", Some("Walk")),
    ("Fox/glTF-Binary/Fox.glb", Some("Run")),
    ("InterpolationTest/glTF/InterpolationTest.gltf", None),
    ("RiggedSimple/glTF/RiggedSimple.gltf", None),
    ("SimpleMorph/glTF/SimpleMorph.gltf", None),
    ("SimpleSkin/glTF/SimpleSkin.gltf", None),
];

/// The times, as parts of a run.
const TIMES: [f64; 3] = [0.19, 0.5, 0.87];

const FPS: f64 = 24.0;

/// The largest difference of a vertex, as a part of the size of the model.
const TOLERANCE: f64 = 1e-5;

pub fn trials() -> Vec<Trial> {
    let trial = |(model, animation): (&str, Option<&'static str>)| {
        let file = format!("gltf/khronos/{model}");
        let name = model.split('/').next().expect("a name");
        let clip = animation.map_or_else(String::new, |name| format!(" {name}"));
        let path = file.clone();
        asset_trial!(
            format!("the vertices of {name}{clip} are those of its keys"),
            &[file.as_str()],
            move |folder| vertices_are_those_of_the_keys(&folder.join(path), animation),
        )
    };
    MODELS.map(trial).into()
}

type Triangle = [DVec3; 3];

fn vertices_are_those_of_the_keys(path: &Path, animation: Option<&str>) -> Result<(), Failed> {
    let file = File::read(path);
    let clips: Vec<&Value> = list(&file.json["animations"])
        .filter(|clip| animation.is_none_or(|name| clip["name"] == name))
        .collect();
    let end = clips.iter().map(|clip| file.end(clip)).fold(0.0, f64::max);
    let request = Request {
        animation: Some(match animation {
            Some(name) => AnimationChoice::Named(vec![name.to_owned()]),
            None => AnimationChoice::All,
        }),
        ..Request::default()
    };
    let job = Job::open(path, &request).map_err(|e| e.to_string())?;
    let mut scenes = job.scenes(job.compile().map_err(|e| e.to_string())?);
    for part in TIMES {
        let frame = (part * end * FPS).round();
        let expected = file.pose(&clips, f64::from((frame / FPS) as f32));
        let mut found = parts(scenes.seek(frame).map_err(|e| e.to_string())?);
        let corners = || expected.iter().flatten().flatten();
        let low = corners().fold(DVec3::INFINITY, |low, p| low.min(*p));
        let high = corners().fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
        let size = (high - low).length();
        let mut worst = 0.0_f64;
        for part in &expected {
            let away = |other: &Vec<Triangle>| {
                let pairs = part.iter().flatten().zip(other.iter().flatten());
                let farthest = pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
                if part.len() == other.len() {
                    farthest
                } else {
                    f64::INFINITY
                }
            };
            let nearest = (0..found.len()).min_by(|a, b| away(&found[*a]).total_cmp(&away(&found[*b])));
            let nearest = found.swap_remove(nearest.ok_or("a part is missing")?);
            worst = worst.max(away(&nearest));
        }
        println!("{}: frame {frame}: {:.2e} of the size", path.display(), worst / size);
        if !found.is_empty() || worst > TOLERANCE * size {
            return Err(format!("frame {frame}: {worst} m of {size} m, {} parts more", found.len()).into());
        }
    }
    Ok(())
}

/// The triangles of each mesh of a scene, in the world.
fn parts(scene: &Scene) -> Vec<Vec<Triangle>> {
    let geometry = scene.geometry.accel.geometry();
    let mut parts = Vec::new();
    for mesh in &scene.geometry.meshes {
        let group = (geometry.groups.iter()).position(|group| group.triangles.contains(&mesh.triangles.start));
        let corners = |at: u32| geometry.corners(at as usize);
        let Some(group) = group else {
            let world = |at| corners(at).map(|p| p.as_dvec3() + scene.origin);
            parts.push(mesh.triangles.clone().map(world).collect());
            continue;
        };
        for (number, instance) in geometry.instances.iter().enumerate() {
            if instance.group as usize == group {
                let place = geometry.place(InstanceId(number as u32)).expect("it is placed");
                let world = |at| corners(at).map(|p| place.widened().transform_point3(p.as_dvec3()) + scene.origin);
                parts.push(mesh.triangles.clone().map(world).collect());
            }
        }
    }
    parts
}

fn list(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

fn floats<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let numbers: Vec<f64> = list(value).filter_map(Value::as_f64).collect();
    numbers.try_into().ok()
}

fn number(value: &Value) -> usize {
    value.as_u64().expect("an index") as usize
}

/// A glTF file with its buffers.
struct File {
    json: Value,
    buffers: Vec<Vec<u8>>,
}

/// The values of a node that animations replace.
#[derive(Clone)]
struct Node {
    translation: DVec3,
    rotation: DQuat,
    scale: DVec3,
    /// In place of the three above.
    matrix: Option<DMat4>,
    weights: Vec<f64>,
}

impl File {
    fn read(path: &Path) -> Self {
        let bytes = fs::read(path).expect("a file");
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize;
        let (json, embedded) = match bytes.starts_with(b"glTF") {
            true => (&bytes[20..20 + word(12)], Some(bytes[28 + word(12)..].to_vec())),
            false => (&bytes[..], None),
        };
        let json: Value = serde_json::from_slice(json).expect("JSON");
        let buffer = |buffer: &Value| match buffer["uri"].as_str() {
            Some(uri) => fs::read(path.with_file_name(uri)).expect("a buffer"),
            None => embedded.clone().expect("a buffer in the file"),
        };
        let buffers = list(&json["buffers"]).map(buffer).collect();
        Self { json, buffers }
    }

    /// The elements of an accessor.
    fn elements(&self, accessor: &Value) -> Vec<Vec<f64>> {
        let accessor = &self.json["accessors"][number(accessor)];
        let view = &self.json["bufferViews"][number(&accessor["bufferView"])];
        let width = match accessor["type"].as_str() {
            Some("SCALAR") => 1,
            Some("VEC2") => 2,
            Some("VEC3") => 3,
            Some("VEC4") => 4,
            Some("MAT4") => 16,
            other => panic!("{other:?}"),
        };
        let size = match accessor["componentType"].as_u64() {
            Some(5121) => 1,
            Some(5123) => 2,
            Some(5125 | 5126) => 4,
            other => panic!("{other:?}"),
        };
        let is_float = accessor["componentType"] == 5126;
        let offset = |value: &Value| value["byteOffset"].as_u64().unwrap_or(0) as usize;
        let begin = offset(accessor) + offset(view);
        let stride = view["byteStride"]
            .as_u64()
            .map_or(width * size, |stride| stride as usize);
        let bytes = &self.buffers[number(&view["buffer"])];
        let component = |at: usize| {
            let own = &bytes[at..at + size];
            match own.try_into().map(u32::from_le_bytes) {
                Ok(bits) if is_float => f64::from(f32::from_bits(bits)),
                _ => own.iter().rev().fold(0.0, |sum, byte| 256.0 * sum + f64::from(*byte)),
            }
        };
        let element = |n: usize| (0..width).map(|i| component(begin + n * stride + i * size)).collect();
        (0..number(&accessor["count"])).map(element).collect()
    }

    /// The time of the last key of an animation.
    fn end(&self, clip: &Value) -> f64 {
        let times = list(&clip["samplers"]).flat_map(|sampler| self.elements(&sampler["input"]));
        times.flatten().fold(0.0, f64::max)
    }

    /// The value of a sampler at a time.
    fn sample(&self, sampler: &Value, time: f64, is_rotation: bool) -> Vec<f64> {
        let times = self.elements(&sampler["input"]).concat();
        let flat = self.elements(&sampler["output"]).concat();
        let interp = sampler["interpolation"].as_str().unwrap_or("LINEAR");
        let parts = if interp == "CUBICSPLINE" { 3 } else { 1 };
        let width = flat.len() / (parts * times.len());
        let part = |key: usize, part: usize| &flat[(key * parts + part) * width..][..width];
        let value = |key: usize| match (is_rotation, interp) {
            (true, "LINEAR" | "STEP") => unit(part(key, 0)),
            (_, "CUBICSPLINE") => part(key, 1).to_vec(),
            _ => part(key, 0).to_vec(),
        };
        let finish = |value: Vec<f64>| if is_rotation { unit(&value) } else { value };
        let next = times.partition_point(|key| *key <= time);
        if next == 0 || next == times.len() {
            return finish(value(next.saturating_sub(1)));
        }
        let (a, b) = (value(next - 1), value(next));
        let step = times[next] - times[next - 1];
        let u = (time - times[next - 1]) / step;
        let mixed = |weight: &dyn Fn(usize) -> f64| (0..width).map(weight).collect::<Vec<f64>>();
        finish(match interp {
            "STEP" => a,
            "LINEAR" if is_rotation => {
                let cosine: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
                let sign = cosine.signum();
                let angle = libm::acos(cosine.abs().min(1.0));
                match angle < 1e-9 {
                    true => a,
                    false => mixed(&|i| {
                        let sin = libm::sin;
                        (sin((1.0 - u) * angle) * a[i] + sign * sin(u * angle) * b[i]) / sin(angle)
                    }),
                }
            }
            "LINEAR" => mixed(&|i| a[i] + (b[i] - a[i]) * u),
            "CUBICSPLINE" => {
                let (leaving, arriving) = (part(next - 1, 2), part(next, 0));
                mixed(&|i| {
                    let (u2, u3) = (u * u, u * u * u);
                    (2.0 * u3 - 3.0 * u2 + 1.0) * a[i]
                        + step * (u3 - 2.0 * u2 + u) * leaving[i]
                        + (3.0 * u2 - 2.0 * u3) * b[i]
                        + step * (u3 - u2) * arriving[i]
                })
            }
            other => panic!("{other}"),
        })
    }

    fn node(&self, node: &Value) -> Node {
        let weights = match node["weights"].is_array() {
            true => &node["weights"],
            false => &self.json["meshes"][node["mesh"].as_u64().unwrap_or(u64::MAX) as usize]["weights"],
        };
        Node {
            translation: floats(&node["translation"]).map_or(DVec3::ZERO, DVec3::from_array),
            rotation: floats(&node["rotation"]).map_or(DQuat::IDENTITY, |r| DQuat::from_array(r).normalize()),
            scale: floats(&node["scale"]).map_or(DVec3::ONE, DVec3::from_array),
            matrix: floats(&node["matrix"]).map(|m: [f64; 16]| DMat4::from_cols_array(&m)),
            weights: list(weights).filter_map(Value::as_f64).collect(),
        }
    }

    /// The triangles of each primitive in the default scene at a time, in the world.
    fn pose(&self, clips: &[&Value], time: f64) -> Vec<Vec<Triangle>> {
        let mut nodes: Vec<Node> = list(&self.json["nodes"]).map(|node| self.node(node)).collect();
        for clip in clips {
            for channel in list(&clip["channels"]) {
                let (target, path) = (&channel["target"]["node"], channel["target"]["path"].as_str());
                let sampler = &clip["samplers"][number(&channel["sampler"])];
                let value = self.sample(sampler, time, path == Some("rotation"));
                let node = &mut nodes[number(target)];
                match path {
                    Some("translation") => node.translation = DVec3::from_slice(&value),
                    Some("rotation") => node.rotation = DQuat::from_slice(&value),
                    Some("scale") => node.scale = DVec3::from_slice(&value),
                    Some("weights") => node.weights = value,
                    other => panic!("{other:?}"),
                }
            }
        }
        let mut world: BTreeMap<usize, DMat4> = BTreeMap::new();
        let scene = &self.json["scenes"][self.json["scene"].as_u64().unwrap_or(0) as usize];
        let mut open: Vec<(usize, DMat4)> = list(&scene["nodes"]).map(|at| (number(at), DMat4::IDENTITY)).collect();
        while let Some((at, above)) = open.pop() {
            let node = &nodes[at];
            let parts = DMat4::from_scale_rotation_translation(node.scale, node.rotation, node.translation);
            let own = above * node.matrix.unwrap_or(parts);
            world.insert(at, own);
            let children = list(&self.json["nodes"][at]["children"]);
            open.extend(children.map(|child| (number(child), own)));
        }
        let mut parts = Vec::new();
        for at in world.keys() {
            let node = &self.json["nodes"][*at];
            if node["mesh"].is_null() {
                continue;
            }
            for primitive in list(&self.json["meshes"][number(&node["mesh"])]["primitives"]) {
                parts.push(self.triangles(primitive, node, &nodes[*at].weights, (&world, *at)));
            }
        }
        parts
    }

    /// The triangles of a primitive at a node in the world.
    fn triangles(
        &self,
        primitive: &Value,
        node: &Value,
        weights: &[f64],
        (world, at): (&BTreeMap<usize, DMat4>, usize),
    ) -> Vec<Triangle> {
        let attributes = &primitive["attributes"];
        let points = |accessor: &Value| -> Vec<DVec3> {
            let elements = self.elements(accessor).into_iter();
            elements.map(|p| DVec3::from_slice(&p)).collect()
        };
        let mut positions = points(&attributes["POSITION"]);
        for (target, weight) in list(&primitive["targets"]).zip(weights) {
            for (p, offset) in positions.iter_mut().zip(points(&target["POSITION"])) {
                *p += *weight * offset;
            }
        }
        if node["skin"].is_null() {
            for p in &mut positions {
                *p = world[&at].transform_point3(*p);
            }
        } else {
            let skin = &self.json["skins"][number(&node["skin"])];
            let inverse = self.elements(&skin["inverseBindMatrices"]);
            let bone = |(joint, inverse): (&Value, &Vec<f64>)| {
                let inverse: [f64; 16] = inverse.as_slice().try_into().expect("a matrix");
                world[&number(joint)] * DMat4::from_cols_array(&inverse)
            };
            let bones: Vec<DMat4> = list(&skin["joints"]).zip(&inverse).map(bone).collect();
            let joints = self.elements(&attributes["JOINTS_0"]);
            let shares = self.elements(&attributes["WEIGHTS_0"]);
            for ((p, joints), shares) in positions.iter_mut().zip(joints).zip(shares) {
                let moved = |(joint, share): (&f64, &f64)| *share * (bones[*joint as usize] * p.extend(1.0));
                let sum: DVec4 = joints.iter().zip(&shares).map(moved).sum();
                *p = sum.truncate() / shares.iter().sum::<f64>();
            }
        }
        let indices: Vec<usize> = match primitive["indices"].is_null() {
            true => (0..positions.len()).collect(),
            false => (self.elements(&primitive["indices"]).iter())
                .map(|i| i[0] as usize)
                .collect(),
        };
        let corners = indices.chunks_exact(3);
        corners
            .map(|corners| [0, 1, 2].map(|i| positions[corners[i]]))
            .collect()
    }
}

fn unit(value: &[f64]) -> Vec<f64> {
    let length = value.iter().map(|v| v * v).sum::<f64>().sqrt();
    value.iter().map(|v| v / length).collect()
}
