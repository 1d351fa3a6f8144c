//! `builtin:lamp_hall`: a nave between two rows of pillars, with a dozen bays on each side. Its lamps hang in the bays,
//! under the ceiling, on the pillars and along the floor; cross walls hide the lamps of one bay from those of the next,
//! so which lamps matter changes from place to place.

use crate::scene::builtin::{Mesh, add_ball, diffuse, fractal, uniform};
use crate::scene::desc::{CameraDesc, InstanceDesc, MaterialDesc, RenderDesc, Scattering, SceneDesc};
use glam::DVec3;

/// Bays on each side, and how much of the hall's length each takes.
const BAYS: u32 = 12;
const BAY: f64 = 4.0;
/// From the hall's middle to the bays' mouths, and to their back walls.
const MOUTH: f64 = 7.0;
const BACK: f64 = 10.5;
/// Heights of the hall and of the bays.
const HIGH: f64 = 8.0;
const LOW: f64 = 4.5;
/// Half the thickness of the walls between bays.
const WALL: f64 = 0.25;
/// From the hall's middle to the pillars' axes, and half their side.
const PILLARS: f64 = 4.6;
const PILLAR: f64 = 0.4;
/// How far the lamps stand out from what they are on.
const GAP: f64 = 0.02;

/// Colours of lamps, and what each of [`STRENGTHS`] multiplies.
const COLORS: [(&str, [f64; 3]); 8] = [
    ("candle", [1.0, 0.62, 0.28]),
    ("paper", [1.0, 0.82, 0.55]),
    ("daylight", [0.86, 0.93, 1.0]),
    ("rose", [1.0, 0.32, 0.42]),
    ("leaf", [0.42, 1.0, 0.38]),
    ("sea", [0.22, 0.85, 0.9]),
    ("ink", [0.3, 0.42, 1.0]),
    ("plum", [0.8, 0.34, 1.0]),
];
/// Radiance of the brightest channel, W sr^-1 m^-2.
const STRENGTHS: [f64; 4] = [4.0, 12.0, 36.0, 108.0];

/// The materials in front of the lamps'.
const FLOOR: u32 = 0;
const PLASTER: u32 = 1;
const STONE: u32 = 2;
const CLAY: u32 = 3;
const FIRST_LAMP: u32 = 4;

/// A rectangle that carries lamps: a corner and two sides whose cross product is the way they shine.
struct Panel {
    corner: DVec3,
    sides: [DVec3; 2],
    /// Its share of the lamps.
    share: u64,
    /// The colours its lamps take turns in.
    colors: [usize; 2],
}

/// The hall with `lamps` lamps, two triangles each.
pub(super) fn lamp_hall(name: String, lamps: u32) -> SceneDesc {
    let mut mesh = Mesh::default();
    add_walls(&mut mesh);
    let mut panels = Vec::new();
    for i in 0..2 * BAYS {
        add_bay(&mut mesh, &mut panels, i);
    }
    for i in 0..2 * (BAYS - 1) {
        add_pillar(&mut mesh, &mut panels, i);
    }
    for i in 0..BAYS / 2 {
        add_statue(&mut mesh, i);
    }
    add_lamps(&mut mesh, &panels, u64::from(lamps));
    SceneDesc {
        name,
        camera: CameraDesc {
            position: [-3.4, 2.1, 2.2],
            look_at: [2.9, 2.35, 17.0],
            up: [0.0, 1.0, 0.0],
            vertical_fov: 60.0,
            ..CameraDesc::default()
        },
        film: (640, 480),
        render: RenderDesc { spp: Some(64), ..RenderDesc::default() },
        meshes: vec![mesh.into_desc()],
        instances: vec![InstanceDesc::default()],
        materials: materials(),
        ..SceneDesc::default()
    }
}

fn materials() -> Vec<MaterialDesc> {
    let dark = [0.0; 3];
    let floor = Scattering::Plastic { albedo: [0.32, 0.28, 0.25], ior: 1.5, alpha: 0.12 };
    let mut materials = vec![
        MaterialDesc { name: "floor".into(), scattering: floor, ..MaterialDesc::default() },
        diffuse("plaster", [0.72, 0.7, 0.66], dark),
        diffuse("stone", [0.52, 0.49, 0.45], dark),
        diffuse("clay", [0.62, 0.42, 0.33], dark),
    ];
    for (color, rgb) in COLORS {
        let lamp = |(i, strength)| diffuse(&format!("{color}_{i}"), dark, rgb.map(|c: f64| c * strength));
        materials.extend(STRENGTHS.iter().enumerate().map(|(i, &strength)| lamp((i, strength))));
    }
    materials
}

/// The rectangle at `corner`, front along `u` x `v`.
fn add_rectangle(mesh: &mut Mesh, corner: DVec3, [u, v]: [DVec3; 2], material: u32) {
    mesh.free_quad([corner, corner + u, corner + u + v, corner + v], material);
}

/// Floor, ceiling, and the two end walls.
fn add_walls(mesh: &mut Mesh) {
    let length = BAY * f64::from(BAYS);
    let (across, along, up) = (DVec3::X * (2.0 * BACK), DVec3::Z * length, DVec3::Y * HIGH);
    let corner = DVec3::X * -BACK;
    add_rectangle(mesh, corner, [along, across], FLOOR);
    add_rectangle(mesh, corner + up, [across, along], PLASTER);
    add_rectangle(mesh, corner, [across, up], PLASTER);
    add_rectangle(mesh, corner + along, [up, across], PLASTER);
}

/// Bay `i` (even: left, at negative x) with its lamps, and the stretch of nave in front of it.
fn add_bay(mesh: &mut Mesh, panels: &mut Vec<Panel>, i: u32) {
    let side = if i.is_multiple_of(2) { -1.0 } else { 1.0 };
    let z = BAY * f64::from(i / 2);
    let at = |x: f64, y: f64, z: f64| DVec3::new(side * x, y, z);
    // On the right everything is mirrored: the sides change places, so that fronts stay fronts.
    let turned = |[u, v]: [DVec3; 2]| if side < 0.0 { [u, v] } else { [v, u] };
    let (first, last, depth) = (z + WALL, z + BAY - WALL, BACK - MOUTH);
    let (up, out, along) = (DVec3::Y, DVec3::X * side, DVec3::Z);
    let width = last - first;
    let hue = (i as usize * 5 + i as usize / 2) % COLORS.len();
    let mut wall = |corner: DVec3, sides: [DVec3; 2], share: u64| {
        add_rectangle(mesh, corner, turned(sides), PLASTER);
        panels.push(Panel { corner, sides: turned(sides), share, colors: [hue, (hue + 3) % COLORS.len()] });
    };
    wall(at(BACK, 0.0, first), [up * LOW, along * width], 36);
    wall(at(MOUTH, 0.0, first), [up * LOW, out * depth], 8);
    wall(at(MOUTH, 0.0, last), [out * depth, up * LOW], 8);
    wall(at(MOUTH, LOW, first), [along * width, out * depth], 10);
    // No lamps: the ends of the cross walls, and the wall above the bay's mouth.
    for z in [z, last] {
        add_rectangle(mesh, at(MOUTH, 0.0, z), turned([up * LOW, along * WALL]), STONE);
    }
    add_rectangle(mesh, at(MOUTH, LOW, z), turned([up * (HIGH - LOW), along * BAY]), STONE);
    // Lamps without a wall of their own: half of the nave's ceiling, and a strip along the floor.
    let nave = turned([along * BAY, out * (PILLARS - 0.6)]);
    panels.push(Panel { corner: at(0.0, HIGH, z), sides: nave, share: 5, colors: [1, 2] });
    let strip = turned([out * 0.25, along * BAY]);
    panels.push(Panel { corner: at(PILLARS + 0.8, 0.0, z), sides: strip, share: 4, colors: [0, 1] });
}

/// Pillar `i` between bays, with lamps on its four faces.
fn add_pillar(mesh: &mut Mesh, panels: &mut Vec<Panel>, i: u32) {
    let side = if i.is_multiple_of(2) { -1.0 } else { 1.0 };
    let centre = DVec3::new(side * PILLARS, 0.0, BAY * f64::from(i / 2 + 1));
    let mut axes = [DVec3::X, DVec3::Z];
    for _ in 0..4 {
        // A quarter turn about y takes x to -z and z to x.
        axes = axes.map(|a| DVec3::new(a.z, 0.0, -a.x));
        let corner = centre + (axes[0] + axes[1]) * PILLAR;
        let face = [axes[1] * (-2.0 * PILLAR), DVec3::Y * HIGH];
        add_rectangle(mesh, corner, face, STONE);
        let band = [face[0], DVec3::Y * 1.5];
        panels.push(Panel { corner: corner + DVec3::Y * 2.4, sides: band, share: 2, colors: [0, 0] });
    }
}

/// A plinth in the nave with a rough stone on it.
fn add_statue(mesh: &mut Mesh, i: u32) {
    let side = if i.is_multiple_of(2) { -1.0 } else { 1.0 };
    let foot = DVec3::new(1.5 * side, 0.0, 2.0 * BAY * f64::from(i) + 7.0);
    let (half, height) = (0.45, 0.9);
    let at = |x: f64, y: f64, z: f64| foot + DVec3::new(x * half, y, z * half);
    let ring = |y: f64| [at(-1.0, y, 1.0), at(1.0, y, 1.0), at(1.0, y, -1.0), at(-1.0, y, -1.0)];
    let (low, high) = (ring(0.0), ring(height));
    for k in 0..4 {
        mesh.free_quad([low[k], low[(k + 1) % 4], high[(k + 1) % 4], high[k]], STONE);
    }
    mesh.free_quad(high, STONE);
    let (centre, seed) = (foot + DVec3::Y * (height + 0.62), 300 + u64::from(i));
    let surface = |p: DVec3| {
        let p = p / p.length();
        centre + p * (0.4 + 0.45 * fractal(1.4 * p, 4, seed))
    };
    add_ball(mesh, 14, surface, CLAY);
}

/// Shares the lamps out among the panels and puts each panel's on a grid, none over another.
fn add_lamps(mesh: &mut Mesh, panels: &[Panel], lamps: u64) {
    let total: u64 = panels.iter().map(|panel| panel.share).sum();
    let mut before = 0;
    let mut lamp = 0;
    for panel in panels {
        before += panel.share;
        // Rounded down at every panel's end, so the last one ends at exactly `lamps`.
        let count = lamps * before / total - lamp;
        // Room at the borders, so that lamps of walls that meet do not cross.
        let border = panel.sides.map(|side| side * (2.0 * GAP / side.length()));
        let [u, v] = [panel.sides[0] - border[0] * 2.0, panel.sides[1] - border[1] * 2.0];
        let (width, height) = (u.length(), v.length());
        let columns = ((count as f64 * width / height).sqrt().ceil() as u64).max(1);
        let rows = count.div_ceil(columns);
        let (across, up) = (u / columns as f64, v / rows.max(1) as f64);
        let cell = across.length().min(up.length());
        let lift = u.cross(v) * (GAP / (width * height));
        for i in 0..count {
            let random = |k: u64| uniform(lamp + i, 60 + k);
            let half = cell * (0.06 + 0.32 * random(0) * random(1));
            let (du, dv) = (u * (half / width), v * (half / height));
            // The middle keeps half a lamp's width from the cell's borders.
            let place =
                |side: DVec3, k: u64| side * 0.5 + side * ((random(k) - 0.5) * (1.0 - 2.2 * half / side.length()));
            let middle = panel.corner
                + (border[0] + border[1] + lift)
                + (across * (i % columns) as f64 + place(across, 2))
                + (up * (i / columns) as f64 + place(up, 3));
            let color = panel.colors[usize::from(random(4) > 0.8)];
            // Bright lamps are rare: each strength is half as likely as the one before.
            let strength = [0.5, 0.75, 0.875].iter().filter(|&&bound| random(5) > bound).count();
            let material = FIRST_LAMP + (color * STRENGTHS.len() + strength) as u32;
            add_rectangle(mesh, middle - du - dv, [du * 2.0, dv * 2.0], material);
        }
        lamp += count;
    }
}
