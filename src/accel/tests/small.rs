//! A few rays for every kernel: few enough for Miri, which runs these tests (`.ci/miri`).

use super::{
    instances::{add_group, add_instance, crowd, place},
    *,
};

/// Returns an image of `side` x `side` rays in scanline order.
fn picture(side: usize) -> Vec<Ray> {
    let place = |i: usize| (i as f32 + 0.5) / side as f32 - 0.5;
    (0..side * side)
        .map(|i| {
            Ray::new(
                Vec3::new(0.0, 0.0, 4.0),
                Vec3::new(place(i % side), place(i / side), -2.0),
            )
        })
        .collect()
}

/// Compares the wide accelerator of the portable level with the linear scan.
fn compare_portable(wide: &dyn Accelerator, linear: &dyn Accelerator, rays: &[Ray], row: u32) {
    let layout = BatchLayout::Rows(row);
    let run = |accel: &dyn Accelerator| {
        let (mut hits, mut blocked) = (vec![None; rays.len()], vec![false; rays.len()]);
        accel.nearest_batch(RayBatch { rays, layout }, &mut hits);
        accel.occluded_batch(RayBatch { rays, layout }, &mut blocked);
        (hits.iter().map(bits).collect::<Vec<_>>(), blocked)
    };
    assert!(run(wide) == run(linear));
}

fn built(g: &Geometry) -> [Box<dyn Accelerator>; 2] {
    let simd = "portable".parse().expect("every processor has it");
    [AccelKind::Wide, AccelKind::Linear]
        .map(|kind| build(BuildOptions { kind, simd }, Arc::new(g.clone())).expect("the scene is valid"))
}

#[test]
fn small_single_rays() {
    let g = soup(40, 3, 0.4);
    let [wide, linear] = built(&g);
    compare_portable(&*wide, &*linear, &rays(&g, 80), 16);
}

#[test]
fn small_packets() {
    let g = soup(40, 3, 0.4);
    let [wide, linear] = built(&g);
    compare_portable(&*wide, &*linear, &picture(8), 8);
}

#[test]
fn small_instances_and_updates() {
    let mut g = crowd(4, 1.0);
    add_group(&mut g, &soup(5, 0, 0.5));
    let group = g.groups.len() as u32 - 1;
    add_instance(&mut g, group, place(&mut Random(8), 2, 1.0));
    let [mut wide, mut linear] = built(&g);
    compare_portable(&*wide, &*linear, &rays(&g, 40), 16);
    let vertices = g.groups[group as usize].vertices.clone();
    let moved = g.vertices[vertices.start as usize..vertices.end as usize].iter();
    let edit = Edit {
        vertices: vec![(vertices.start, moved.map(|p| *p * 1.01).collect())],
        ..Edit::default()
    };
    for accel in [&mut wide, &mut linear] {
        accel.update(&edit).expect("the edit is valid");
    }
    compare_portable(&*wide, &*linear, &rays(&g, 40), 16);
}
