//! What several test files share: the scenes, small, and comparisons of pictures.
#![allow(dead_code)] // not every test file uses every helper

use glam::DVec3;
use octray::{Film, PreparedScene, Scene, Settings};

/// Our scenes; builtin ones small.
pub const SCENES: [&str; 15] = [
    "scenes/cornell.toml",
    "scenes/cornell_mirror.toml",
    "scenes/lecture_lights.toml",
    "scenes/furnace.toml",
    "scenes/lens.toml",
    "scenes/glossy_plates.toml",
    "scenes/glass.toml",
    "scenes/sky.toml",
    "scenes/leaves.toml",
    "scenes/door_ajar.toml",
    "scenes/lights.toml",
    "scenes/principled.toml",
    "builtin:heavy:20000",
    "builtin:lamp_hall:300",
    "builtin:rooms:3",
];

/// A scene of ours, ready; panics with the reason if it does not load.
pub fn prepared(path: &str) -> PreparedScene {
    Scene::load(path).and_then(|scene| scene.prepare()).unwrap_or_else(|error| panic!("{error}"))
}

/// Settings for a small picture.
pub fn small(width: u32, height: u32, spp: u32) -> Settings {
    Settings { spp, width: Some(width), height: Some(height), threads: 1, ..Settings::plain() }
}

/// The first difference between two films' sums, bit for bit.
pub fn first_difference(a: &Film, b: &Film) -> Option<String> {
    assert_eq!((a.width, a.height, a.spp), (b.width, b.height, b.spp));
    let bits = |v: [f64; 3]| v.map(f64::to_bits);
    let differs = |i: &usize| {
        bits(a.pixels[*i].sum) != bits(b.pixels[*i].sum)
            || a.squares.get(*i) != b.squares.get(*i)
            || a.groups.get(*i) != b.groups.get(*i)
    };
    let i = (0..a.pixels.len()).find(differs)?;
    let (x, y) = (i % a.width as usize, i / a.width as usize);
    Some(format!("pixel {x},{y}: {:?} and {:?}", a.pixels[i].sum, b.pixels[i].sum))
}

/// The exact strategies.
pub fn exact_strategies() -> impl Iterator<Item = octray::Strategy> {
    octray::Strategy::ALL.iter().copied().filter(|strategy| !strategy.is_biased())
}

/// Mean, its standard error and the effective sample count (sum x)^2 / sum x^2 of one channel over some pixels. Of films that have
/// sums of groups and no squares, sum x^2 is what the squares of those leave without the products of different samples, which are
/// like the products of different groups; at least what it is for equal samples.
pub struct Estimate {
    pub mean: f64,
    pub error: f64,
    pub effective_samples: f64,
}

/// The estimate that the pixels of `film` in columns `x` and rows `y` make together.
pub fn estimate(film: &Film, x: std::ops::Range<u32>, y: std::ops::Range<u32>, channel: usize) -> Estimate {
    let (mut sum, mut squares, mut variance, mut pixels) = (0.0, 0.0, 0.0, 0.0);
    let n = film.spp as f64;
    for row in y {
        for column in x.clone() {
            let index = (row * film.width + column) as usize;
            sum += film.pixels[index].sum[channel];
            squares += match film.groups.get(index) {
                Some(groups) => {
                    let count = groups.0.len() as f64;
                    let together: f64 = groups.0.iter().map(|group| group[channel] * group[channel]).sum();
                    let apart = film.pixels[index].sum[channel].powi(2) - together;
                    let each = n / count;
                    (together - (1.0 - 1.0 / each) * apart / (count - 1.0)).max(together / each)
                }
                None => film.squares[index].0[channel],
            };
            // Pixel by pixel: differences between pixels are the picture, not noise.
            variance += f64::from(film.variance(column, row)[channel]);
            pixels += 1.0;
        }
    }
    let mean = sum / (pixels * n);
    let effective_samples = if squares > 0.0 { sum * sum / squares } else { f64::INFINITY };
    Estimate { mean, error: variance.sqrt() / pixels, effective_samples }
}

/// Irradiance at `point`, on a plane of normal `normal`, from a polygon of radiance 1 above it: Lambert's formula (Lambert 1760; Arvo 1994).
pub fn polygon_irradiance(point: DVec3, normal: DVec3, corners: &[DVec3]) -> f64 {
    let rays: Vec<DVec3> = corners.iter().map(|c| (*c - point).normalize()).collect();
    let edge = |i: usize| {
        let (a, b) = (rays[i], rays[(i + 1) % rays.len()]);
        a.dot(b).clamp(-1.0, 1.0).acos() * a.cross(b).normalize().dot(normal)
    };
    (0.5 * (0..rays.len()).map(edge).sum::<f64>()).abs()
}

/// A scene made in a test.
#[derive(Default)]
pub struct Maker {
    pub desc: octray::scene::SceneDesc,
    /// All its triangles, in world space.
    pub mesh: octray::scene::desc::MeshDesc,
}

impl Maker {
    /// A material; its index.
    pub fn material(&mut self, scattering: octray::scene::desc::Scattering, emission: [f64; 3]) -> u32 {
        let name = format!("m{}", self.desc.materials.len());
        self.desc.materials.push(octray::scene::desc::MaterialDesc {
            name,
            scattering,
            emission,
            ..Default::default()
        });
        self.desc.materials.len() as u32 - 1
    }

    /// A diffuse material; its index.
    pub fn diffuse(&mut self, albedo: [f64; 3], emission: [f64; 3]) -> u32 {
        self.material(octray::scene::desc::Scattering::Diffuse { albedo }, emission)
    }

    /// Two triangles; corners counter-clockwise seen from the front.
    pub fn quad(&mut self, corners: [[f32; 3]; 4], material: u32) {
        let first = self.mesh.positions.len() as u32;
        self.mesh.positions.extend(corners);
        for vertices in [[first, first + 1, first + 2], [first, first + 2, first + 3]] {
            self.mesh.triangles.push(octray::scene::desc::TriangleDesc { vertices, material, flipped: false });
        }
    }

    /// The six sides of a box, fronts outwards or inwards.
    pub fn cuboid(&mut self, [x0, y0, z0]: [f32; 3], [x1, y1, z1]: [f32; 3], inwards: bool, material: u32) {
        let sides = [
            [[x0, y0, z1], [x1, y0, z1], [x1, y1, z1], [x0, y1, z1]],
            [[x1, y0, z0], [x0, y0, z0], [x0, y1, z0], [x1, y1, z0]],
            [[x0, y0, z0], [x0, y0, z1], [x0, y1, z1], [x0, y1, z0]],
            [[x1, y0, z1], [x1, y0, z0], [x1, y1, z0], [x1, y1, z1]],
            [[x0, y1, z1], [x1, y1, z1], [x1, y1, z0], [x0, y1, z0]],
            [[x0, y0, z0], [x1, y0, z0], [x1, y0, z1], [x0, y0, z1]],
        ];
        for [a, b, c, d] in sides {
            self.quad(if inwards { [d, c, b, a] } else { [a, b, c, d] }, material);
        }
    }

    /// The description, its mesh included.
    pub fn whole(&self) -> octray::scene::SceneDesc {
        let mut whole = self.desc.clone();
        whole.add_mesh(self.mesh.clone(), Default::default());
        whole
    }

    /// Looks from `position` at `look_at` with a field of view of `fov` degrees; then ready.
    pub fn seen(self, position: [f64; 3], look_at: [f64; 3], fov: f64) -> PreparedScene {
        self.seen_through(position, look_at, fov, 0.0, 1.0)
    }

    /// [`Maker::seen`] through a thin lens.
    pub fn seen_through(
        mut self,
        position: [f64; 3],
        look_at: [f64; 3],
        vertical_fov: f64,
        aperture_radius: f64,
        focus_distance: f64,
    ) -> PreparedScene {
        let along_y = (position[0] - look_at[0]).abs() + (position[2] - look_at[2]).abs() < 1e-9;
        let up = if along_y { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] };
        self.desc.camera = octray::scene::desc::CameraDesc {
            position,
            look_at,
            up,
            vertical_fov,
            aperture_radius,
            focus_distance,
            to_world: None,
        };
        self.desc.film = (4, 4);
        self.desc.name = "a test's scene".into();
        PreparedScene::new(&self.whole()).unwrap_or_else(|error| panic!("{error}"))
    }
}

/// Three rooms in a row with narrow doors between, four lamps under each ceiling: weak ones in the middle, where the camera is,
/// and 30 times stronger ones at both sides. A glossy block and a metal one stand in the middle. `sky`: light falls in by a roof
/// window, too.
pub fn rooms(sky: bool) -> PreparedScene {
    use octray::scene::desc::{EnvironmentDesc, Scattering};
    let mut maker = Maker::default();
    let wall = maker.diffuse([0.6, 0.5, 0.4], [0.0; 3]);
    let plastic = maker.material(Scattering::Plastic { albedo: [0.2, 0.3, 0.6], ior: 1.5, alpha: 0.1 }, [0.0; 3]);
    let metal = Scattering::Conductor { alpha: 0.2, reflectance: [0.9, 0.8, 0.6], complex_ior: None };
    let metal = maker.material(metal, [0.0; 3]);
    maker.quad([[0.0, 0.0, 4.0], [12.0, 0.0, 4.0], [12.0, 0.0, 0.0], [0.0, 0.0, 0.0]], wall);
    maker.quad([[0.0, 0.0, 0.0], [12.0, 0.0, 0.0], [12.0, 3.0, 0.0], [0.0, 3.0, 0.0]], wall);
    maker.quad([[12.0, 0.0, 4.0], [0.0, 0.0, 4.0], [0.0, 3.0, 4.0], [12.0, 3.0, 4.0]], wall);
    maker.quad([[12.0, 0.0, 0.0], [12.0, 0.0, 4.0], [12.0, 3.0, 4.0], [12.0, 3.0, 0.0]], wall);
    maker.quad([[0.0, 0.0, 4.0], [0.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 3.0, 4.0]], wall);
    // The ceiling, of which the window takes a part of the middle room.
    let window = if sky { 4.8 } else { 4.2 };
    maker.quad([[0.0, 3.0, 0.0], [4.2, 3.0, 0.0], [4.2, 3.0, 4.0], [0.0, 3.0, 4.0]], wall);
    maker.quad([[window, 3.0, 0.0], [12.0, 3.0, 0.0], [12.0, 3.0, 4.0], [window, 3.0, 4.0]], wall);
    for x in [4.0, 8.0] {
        maker.cuboid([x, 0.0, 0.0], [x + 0.1, 3.0, 3.7], false, wall);
    }
    maker.cuboid([5.5, 0.0, 0.5], [6.5, 0.8, 1.5], false, plastic);
    maker.cuboid([6.8, 0.0, 1.0], [7.6, 1.2, 1.8], false, metal);
    for (room, radiance) in [30.0, 1.0, 30.0].into_iter().enumerate() {
        let lamp = maker.diffuse([0.0; 3], [radiance, radiance, 0.8 * radiance]);
        for (i, k) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let (x, z) = (4.0 * room as f32 + 1.2 + 1.6 * i as f32, 1.0 + 1.8 * k as f32);
            maker.quad([[x, 2.9, z], [x + 0.3, 2.9, z], [x + 0.3, 2.9, z + 0.3], [x, 2.9, z + 0.3]], lamp);
        }
    }
    if sky {
        maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [0.5, 0.6, 0.8] }));
    }
    maker.seen([4.4, 1.6, 3.6], [6.6, 0.8, 1.2], 75.0)
}

/// Two rooms under a sky that is brightest towards +x and above: one has a window towards -z, the other one in its ceiling, and
/// there is a door between them. `lamps`: four weak ones, too.
pub fn windows(lamps: bool) -> PreparedScene {
    use octray::scene::desc::{EnvironmentDesc, MapDesc};
    let mut maker = Maker::default();
    let wall = maker.diffuse([0.6, 0.55, 0.5], [0.0; 3]);
    maker.quad([[0.0, 0.0, 4.0], [8.0, 0.0, 4.0], [8.0, 0.0, 0.0], [0.0, 0.0, 0.0]], wall);
    maker.quad([[8.0, 0.0, 4.0], [0.0, 0.0, 4.0], [0.0, 3.0, 4.0], [8.0, 3.0, 4.0]], wall);
    maker.quad([[8.0, 0.0, 0.0], [8.0, 0.0, 4.0], [8.0, 3.0, 4.0], [8.0, 3.0, 0.0]], wall);
    maker.quad([[0.0, 0.0, 4.0], [0.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 3.0, 4.0]], wall);
    // The wall with the window, in four parts, and the ceiling.
    let mut frame = |[x0, x1, x2, x3]: [f32; 4], [y0, y1, y2, y3]: [f32; 4], at: &dyn Fn(f32, f32) -> [f32; 3]| {
        for ([left, right], [low, high]) in
            [([x0, x1], [y0, y3]), ([x2, x3], [y0, y3]), ([x1, x2], [y0, y1]), ([x1, x2], [y2, y3])]
        {
            maker.quad([at(left, low), at(right, low), at(right, high), at(left, high)], wall);
        }
    };
    frame([0.0, 1.5, 2.4, 8.0], [0.0, 1.0, 1.9, 3.0], &|x, y| [x, y, 0.0]);
    frame([0.0, 5.5, 6.4, 8.0], [0.0, 1.4, 2.3, 4.0], &|x, z| [x, 3.0, z]);
    maker.cuboid([4.0, 0.0, 0.0], [4.1, 3.0, 3.2], false, wall);
    if lamps {
        let lamp = maker.diffuse([0.0; 3], [1.5, 1.4, 1.2]);
        for (x, z) in [(1.0, 3.0), (3.0, 3.0), (5.0, 3.0), (7.0, 3.0)] {
            maker.quad([[x, 2.9, z], [x + 0.2, 2.9, z], [x + 0.2, 2.9, z + 0.2], [x, 2.9, z + 0.2]], lamp);
        }
    }
    let (width, height) = (48, 25);
    let texel = |i: u32| {
        let (turn, down) = ((i % width) as f64 / f64::from(width), f64::from(i / width) / f64::from(height));
        let light = 0.4 + 3.0 * (1.0 - down) * (1.0 + (std::f64::consts::TAU * turn).sin()).powi(2);
        [0.8 * light, 0.9 * light, light].map(|c| c as f32)
    };
    let texels = (0..width * height).map(texel).collect();
    let map = MapDesc { file: "a test's map".into(), width, height, texels, rotate: 0.0, scale: 1.0 };
    maker.desc.set_environment(Some(EnvironmentDesc::Map(map)));
    maker.seen([0.4, 1.6, 3.7], [5.0, 1.0, 1.6], 80.0)
}

/// Threads, a break after three samples and a crop leave no trace in the image that `settings` give by either engine, with more than three samples
/// and at least 20 x 12 pixels.
pub fn check_no_trace(scene: &PreparedScene, settings: &Settings) {
    use octray::{Crop, Engine, render, render_from};
    for engine in [Engine::Packet, Engine::Scalar] {
        let settings = &Settings { engine, ..settings.clone() };
        let whole = render(scene, settings).film;
        let many = render(scene, &Settings { threads: 3, ..settings.clone() }).film;
        assert_eq!(first_difference(&whole, &many), None, "{engine}, threads");
        let first = render(scene, &Settings { spp: 3, ..settings.clone() }).film;
        let resumed = render_from(scene, settings, Some(first), &|_| true).film;
        assert_eq!(first_difference(&whole, &resumed), None, "{engine}, resumed");
        let crop = Crop { x: 11, y: 5, width: 9, height: 7 };
        let part = render(scene, &Settings { crop: Some(crop), ..settings.clone() }).film;
        for (x, y) in (0..crop.height).flat_map(|y| (0..crop.width).map(move |x| (x, y))) {
            let bits = |mean: [f32; 3]| mean.map(f32::to_bits);
            assert_eq!(bits(part.mean(x, y)), bits(whole.mean(crop.x + x, crop.y + y)), "{engine}, {x},{y}");
        }
    }
}

/// Pearson's chi-square of counts against what was expected, as a standard normal number (Wilson and Hilferty 1931). Cells of
/// fewer than 8 expected counts are pooled. Cells need not hold all draws: nothing is said of the rest.
pub fn chi_square_z(counts: &[f64], expected: &[f64]) -> f64 {
    let (mut chi_square, mut freedom, mut rest) = (0.0, -1.0, (0.0, 0.0));
    for (count, expected) in counts.iter().zip(expected) {
        if *expected < 8.0 {
            rest = (rest.0 + count, rest.1 + expected);
        } else {
            chi_square += (count - expected).powi(2) / expected;
            freedom += 1.0;
        }
    }
    if rest.1 > 8.0 {
        chi_square += (rest.0 - rest.1).powi(2) / rest.1;
        freedom += 1.0;
    }
    let freedom: f64 = freedom;
    let spread = 2.0 / (9.0 * freedom);
    ((chi_square / freedom).cbrt() - (1.0 - spread)) / spread.sqrt()
}
