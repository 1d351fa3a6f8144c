//! The tree itself: the same bits by any number of threads, every triangle in one leaf, cheap by the surface area heuristic, and
//! whole whatever the triangles are.

use crate::scenes::{Random, Scene, heightfield, slivers, soup, sphere};
use obvhs::bvh2::Bvh2;
use octray::internal::bvh::{BuildOptions, Bvh};

/// Small triangles anywhere, and one large one under them.
fn crowd(count: usize) -> Scene {
    let mut scene = soup(count, 0.01, 21);
    scene.name = format!("crowd of {count}");
    let first = scene.positions.len() as u32;
    scene.positions.extend([[-40.0, -1.0, -40.0], [40.0, -1.0, -40.0], [0.0, -1.0, 40.0]]);
    scene.triangles.push([first, first + 1, first + 2]);
    scene
}

fn build(scene: &Scene, leaf_size: usize, threads: usize) -> Bvh {
    let bvh = Bvh::build_with(&scene.positions, &scene.triangles, |_| true, BuildOptions { leaf_size, threads });
    bvh.validate().unwrap_or_else(|e| panic!("{} with {threads} threads: {e}", scene.name));
    bvh
}

/// How often each triangle is in a leaf.
fn times_in_leaves(bvh: &Bvh, triangles: usize) -> Vec<usize> {
    let mut times = vec![0; triangles];
    let ids = bvh.leaves().iter().flat_map(|leaf| leaf.ids);
    ids.filter(|&id| (id as usize) < triangles).for_each(|id| times[id as usize] += 1);
    times
}

#[test]
fn threads_change_no_bit() {
    // Beyond 2^17 triangles threads share the splits; below them, whole subtrees.
    for scene in [sphere(330, 250), crowd(150_000), heightfield(120), slivers(5_000, 4, 9), soup(3, 0.5, 1)] {
        let one = build(&scene, 8, 1);
        assert!(times_in_leaves(&one, scene.triangles.len()).iter().all(|&times| times == 1), "{}", scene.name);
        for threads in [2, 3, 7] {
            let other = build(&scene, 8, threads);
            let same = bytemuck::cast_slice::<_, u8>(one.nodes()) == bytemuck::cast_slice::<_, u8>(other.nodes())
                && bytemuck::cast_slice::<_, u8>(one.leaves()) == bytemuck::cast_slice::<_, u8>(other.leaves())
                && one.depth() == other.depth()
                && one.precise_triangles() == other.precise_triangles();
            assert!(same, "{}: {threads} threads build another tree than one", scene.name);
        }
    }
}

/// What a ray is expected to visit by the surface area heuristic: an inner node costs 1, a triangle 1.
fn cost(tree: &Bvh2) -> f64 {
    let area = |index: usize| f64::from(tree.nodes[index].aabb().half_area());
    let of = |index: usize| area(index) * f64::from(tree.nodes[index].prim_count.max(1));
    (0..tree.nodes.len()).map(of).sum::<f64>() / area(0)
}

/// The cost of the tree cut from the top at the best of all places, along all axes, down to leaves of `leaf_size`: 40 lines that
/// sort at every node.
fn cost_of_full_sweeps(scene: &Scene, leaf_size: usize) -> f64 {
    type Box3 = [[f32; 2]; 3];
    let union = |a: Box3, b: Box3| [0, 1, 2].map(|k| [a[k][0].min(b[k][0]), a[k][1].max(b[k][1])]);
    let area = |b: Box3| {
        let [x, y, z] = b.map(|side| f64::from(side[1] - side[0]));
        x * y + y * z + z * x
    };
    let nothing: Box3 = [[f32::INFINITY, f32::NEG_INFINITY]; 3];
    let of_triangle = |id| {
        let corners = scene.corners(id);
        corners.iter().fold(nothing, |b, corner| union(b, corner.map(|x| [x, x])))
    };
    let boxes: Vec<Box3> = (0..scene.triangles.len()).map(of_triangle).collect();
    let whole = |ids: &[usize]| ids.iter().fold(nothing, |b, &id| union(b, boxes[id]));
    let mut pending = vec![(0..boxes.len()).collect::<Vec<_>>()];
    let root = area(whole(&pending[0]));
    let mut cost = 0.0;
    while let Some(mut ids) = pending.pop() {
        if ids.len() <= leaf_size {
            cost += area(whole(&ids)) * ids.len() as f64;
            continue;
        }
        cost += area(whole(&ids));
        let sort = |ids: &mut Vec<usize>, axis: usize| {
            ids.sort_by(|&a, &b| {
                let centre = |id: usize| boxes[id][axis][0] + boxes[id][axis][1];
                centre(a).total_cmp(&centre(b)).then(a.cmp(&b))
            });
        };
        let mut best = (f64::INFINITY, 0, ids.len() / 2);
        for axis in 0..3 {
            sort(&mut ids, axis);
            let mut right = vec![nothing; ids.len() + 1];
            for i in (0..ids.len()).rev() {
                right[i] = union(right[i + 1], boxes[ids[i]]);
            }
            let mut left = nothing;
            for i in 1..ids.len() {
                left = union(left, boxes[ids[i - 1]]);
                let split = area(left) * i as f64 + area(right[i]) * (ids.len() - i) as f64;
                if split < best.0 {
                    best = (split, axis, i);
                }
            }
        }
        sort(&mut ids, best.1);
        let right = ids.split_off(best.2);
        pending.extend([ids, right]);
    }
    cost / root
}

#[test]
fn trees_cost_hardly_more_than_full_sweeps() {
    // Borders between bins miss the lines of a grid, on which the sweeps cut.
    let scenes = [
        (soup(800, 0.2, 2), 1.03),
        (soup(20_000, 0.02, 3), 1.03),
        (sphere(60, 80), 1.03),
        (heightfield(70), 1.1),
        (crowd(5_000), 1.03),
    ];
    for (scene, most) in scenes {
        let leaf_size = if scene.triangles.len() <= 1024 { 1 } else { 2 };
        let (own, full) = (
            cost(&Bvh::source_tree(&scene.positions, &scene.triangles, |_| true)),
            cost_of_full_sweeps(&scene, leaf_size),
        );
        eprintln!("{}: {own:.2}, by full sweeps {full:.2}, ratio {:.3}", scene.name, own / full);
        assert!(own < most * full, "{}: the tree costs {own}, one by full sweeps {full}", scene.name);
    }
}

#[test]
fn what_is_tested_in_f64_does_not_depend_on_the_leaves() {
    for scene in [crowd(4_000), slivers(3_000, 8, 5)] {
        // Leaves of one make the binary tree's leaves hold one triangle, not two.
        let (one, eight) = (build(&scene, 1, 1), build(&scene, 8, 1));
        let classes = |bvh: &Bvh| -> Vec<u8> { (0..scene.triangles.len() as u32).map(|id| bvh.class(id)).collect() };
        assert_eq!(classes(&one), classes(&eight), "{}", scene.name);
        assert!(classes(&one).iter().any(|&class| class != 0), "{} puts it to the test", scene.name);
    }
}

#[test]
fn any_triangles_give_a_whole_and_shallow_tree() {
    let mut random = Random(31);
    let mut scenes = vec![];
    let mut add = |name: &str, corners: Vec<[[f32; 3]; 3]>| {
        let triangles = (0..corners.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        scenes.push(Scene::new(name, corners.concat(), triangles));
    };
    let around = |centre: [f32; 3], size: f32| {
        let at = |x: f32, y: f32| [centre[0] + size * x, centre[1] + size * y, centre[2]];
        [at(-1.0, -1.0), at(1.0, -1.0), at(0.0, 1.0)]
    };
    add("one", vec![around([0.0; 3], 1.0)]);
    add("two in one place", vec![around([0.0; 3], 1.0); 2]);
    add("one centre", (0..3_000).map(|i| around([0.0; 3], 1.0 + (i % 1_500) as f32)).collect());
    add("one box", (0..40_000).map(|_| around([1.0, 2.0, 3.0], 0.5)).collect());
    add(
        "a line",
        (0..5_000).map(|i| [[i as f32, 0.0, 0.0], [i as f32 + 0.5, 0.0, 0.0], [i as f32 + 1.0, 0.0, 0.0]]).collect(),
    );
    add("doubling", (0..250).map(|i| around([2f32.powi(i - 126), 0.0, 0.0], 2f32.powi(i - 127))).collect());
    for (name, scale) in [("largest", 3e38), ("large", 1e30), ("small", 1e-30), ("below all normal numbers", 1e-41)] {
        let mut corner = || random.point().map(|x| (x * scale).clamp(-f32::MAX, f32::MAX));
        add(name, (0..3_000).map(|_| [corner(), corner(), corner()]).collect());
    }
    let mut thin = |i: usize| {
        let (at, along) = (random.point(), i % 3);
        let end = |step: f32| std::array::from_fn(|axis| at[axis] + if axis == along { step } else { 0.001 * step });
        [at, end(50.0), end(-50.0)]
    };
    add("long and thin", (0..4_000).map(&mut thin).collect());
    for scene in scenes {
        let (one, three) = (build(&scene, 8, 1), build(&scene, 8, 3));
        assert_eq!(one.nodes().len(), three.nodes().len(), "{}", scene.name);
        assert!(times_in_leaves(&three, scene.triangles.len()).iter().all(|&times| times == 1), "{}", scene.name);
        // Below 32 + 2 log2 n levels sets are halved, and moving subtrees may add some.
        let most = 40 + 4 * scene.triangles.len().ilog2() as usize;
        assert!(one.depth() <= most && one.stack_bound() <= 7 * most + 1, "{}: depth {}", scene.name, one.depth());
    }
}
