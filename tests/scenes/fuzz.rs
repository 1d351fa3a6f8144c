//! Mutated files: whatever they hold, reading them ends in what they say or in one error; within a second, and under the memory
//! limit, beyond which this test's allocator ends it. Seeds are made here, and taken from `../shared` where that is.
//!
//! In CI a short part, the same every time. `OCTRAY_FUZZ=100000` says how many files of each kind there are to be, and
//! `OCTRAY_FUZZ_SEED=7` makes others of them, `OCTRAY_FUZZ_KIND=exr` those alone whose names hold that; a file that fails is left in
//! the system's temporary directory.

use octray::internal::files::sealed::Checksum;
use octray::internal::film::layers::LayerPixel;
use octray::internal::film::{Film, checkpoint, part};
use octray::internal::image::Image;
use octray::report::measure::metrics;
use octray::scene::SceneDesc;
use octray::{Crop, Sampler};
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Files of a kind in CI.
const FILES: u64 = 600;
/// No file of a few kilobytes takes so long, whatever else the machine does.
const MOST: Duration = Duration::from_secs(5);
/// Bytes of a seed, at most: what is large is slow, not deep.
const MOST_SEED: u64 = 40_000;

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ bits >> 31
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }

    fn of<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len())]
    }
}

/// Numbers at the ends of their types, and those that sizes are made of.
const EXTREMES: [i64; 18] = [
    0,
    1,
    -1,
    2,
    3,
    16,
    127,
    128,
    255,
    256,
    32_767,
    65_535,
    65_536,
    1 << 24,
    2_147_483_647,
    -2_147_483_648,
    1 << 40,
    i64::MAX,
];
const WORDS: [&str; 22] = [
    "0",
    "-1",
    "1",
    "4294967295",
    "2147483648",
    "99999999999999999999",
    "1e39",
    "nan",
    "inf",
    "\n",
    " ",
    "\"",
    "[",
    "]",
    "{",
    "}",
    "/",
    "\\",
    "null",
    "-0",
    "1e-46",
    "\u{1b}",
];

/// `seed` with one to eight changes; `other` lends pieces.
fn mutated(numbers: &mut Numbers, seed: &[u8], other: &[u8]) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..=numbers.below(8) {
        // What heads a file decides most: half of the changes are made there.
        let reach = if numbers.below(2) == 0 { bytes.len() } else { bytes.len().min(400) };
        let at = numbers.below(reach);
        match numbers.below(9) {
            0 if !bytes.is_empty() => bytes[at] ^= 1 << numbers.below(8),
            1 if !bytes.is_empty() => bytes[at] = numbers.next() as u8,
            2 | 3 => {
                let number = numbers.of(&EXTREMES).to_le_bytes();
                let length = 1usize << numbers.below(4);
                let end = (at + length).min(bytes.len());
                let mut piece = number[..end - at].to_vec();
                if numbers.below(4) == 0 {
                    piece.reverse();
                }
                bytes[at..end].copy_from_slice(&piece);
            }
            4 => drop(bytes.drain(at..(at + numbers.below(20)).min(bytes.len()))),
            5 => {
                let piece = bytes[at..(at + numbers.below(64)).min(bytes.len())].to_vec();
                let to = numbers.below(bytes.len() + 1);
                bytes.splice(to..to, piece);
            }
            6 => bytes.truncate(at),
            7 => {
                let from = numbers.below(other.len());
                let piece = &other[from..(from + numbers.below(64)).min(other.len())];
                let end = (at + piece.len()).min(bytes.len());
                bytes.splice(at..end, piece.iter().copied());
            }
            _ => {
                let word = numbers.of(&WORDS).bytes();
                let end = (at + numbers.below(4)).min(bytes.len());
                bytes.splice(at..end, word);
            }
        }
    }
    bytes
}

/// Gives files of a kind of ours the checksum that belongs to them: else nothing behind it would ever be reached.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.truncate(bytes.len().saturating_sub(8));
    let mut sum = Checksum::default();
    sum.add(&bytes);
    bytes.extend(sum.value().to_le_bytes());
    bytes
}

/// Files of one kind, and what reads them.
struct Kind {
    /// The name of the file.
    name: &'static str,
    seeds: Vec<Vec<u8>>,
    /// They are of ours: every second one gets its checksum.
    sealed: bool,
    read: fn(&Path),
}

fn image(path: &Path) {
    if let Ok(image) = Image::read(path) {
        assert_eq!(image.pixels.len(), image.width as usize * image.height as usize);
        let _ = metrics::check(&image, &image);
        if let Some(area) = image.data().overlap(&image.display()) {
            assert_eq!(image.part(area).pixels.len(), area.width as usize * area.height as usize);
        }
    }
}

/// A file of the scene beside it.
fn of_scene(path: &Path) {
    scene(&path.with_file_name("scene.toml"));
}

fn scene(path: &Path) {
    if let Err(error) = SceneDesc::load(path) {
        let message = error.to_string();
        assert!(!message.is_empty() && message.len() < 40_000 && !message.contains('\u{1b}'), "{message}");
    }
}

fn state(path: &Path) {
    if let Ok(found) = checkpoint::read(path) {
        let film = found.film;
        assert!(film.pixels.iter().all(|pixel| pixel.sum.iter().all(|sum| sum.is_finite())));
        let _ = (film.mean_radiance(), film.relative_error(), film.most_spp());
    }
}

fn of_render(path: &Path) {
    let Ok(part) = part::open(path) else { return };
    let Ok(mut film) = part.whole() else { return };
    if part.put(path, &mut film).is_ok() {
        assert!(film.mean_radiance().iter().all(|mean| mean.is_finite()));
    }
}

/// The files in `../shared` that end so.
fn shared(extension: &str) -> Vec<Vec<u8>> {
    fn add(folder: &Path, extension: &str, found: &mut Vec<PathBuf>) {
        for path in fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
            if path.is_dir() {
                add(&path, extension, found);
            } else if path.extension().is_some_and(|found| found == extension)
                && path.metadata().is_ok_and(|about| about.len() <= MOST_SEED)
            {
                found.push(path);
            }
        }
    }
    let mut found = Vec::new();
    for folder in ["cases", "scenes"] {
        add(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared").join(folder), extension, &mut found);
    }
    // The system lists them in any order.
    found.sort();
    found.truncate(40);
    found.iter().filter_map(|path| fs::read(path).ok()).collect()
}

/// What our own writers make of a small film, as the seeds of a kind.
fn own(folder: &Path, extension: &str) -> Vec<Vec<u8>> {
    let film = |sampler: Sampler| {
        let mut film = Film::of_sampler(Crop { x: 0, y: 0, width: 5, height: 3 }, sampler);
        film.spp = 4;
        for (pixel, sample) in (0..15).flat_map(|pixel| (0..4).map(move |sample| (pixel, sample))) {
            assert!(film.add(pixel, sample, [0.25 * pixel as f32, 1.0, sample as f32]));
        }
        film.metadata = vec![("seed".into(), "7".into())];
        film
    };
    let path = folder.join(format!("seed.{extension}"));
    let mut seeds = Vec::new();
    for sampler in Sampler::ALL {
        let film = film(*sampler);
        match extension {
            "unfinished" => checkpoint::write(&path, &film.metadata, (1.0, false), &film).unwrap(),
            "part" => {
                let about = part::About {
                    recipe: film.metadata.clone(),
                    metadata: film.metadata.clone(),
                    film: (40, 33),
                    crop: [3, 2, 30, 30],
                    shard: (2, 3),
                    spp: 4,
                    layers: vec!["depth".into()],
                    alpha: *sampler == Sampler::Sobol,
                    grouped: *sampler == Sampler::Sobol,
                };
                let mut strip = part::strip(&about.tiles(), *sampler).unwrap();
                strip.layers.pixels = vec![LayerPixel::default(); strip.pixels.len()];
                part::write(&path, &about, &strip).unwrap();
            }
            _ => film.save(&path).unwrap(),
        }
        seeds.push(fs::read(&path).unwrap());
    }
    fs::remove_file(&path).unwrap();
    seeds
}

const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.2 0.5 0\nvt 0 0\nvn 0 0 1\nusemtl a\n\
                   f 1/1/1 2/1/1 3/1/1 4/1/1 5/1/1\nusemtl b\nf -1//1 -2//1 -3//1\n";
const MTL: &str = "newmtl a\nKd 0.5 0.5 0.5\nKs 0.1 0.1 0.1\nNs 10\nmap_Kd a.png\nmap_d a.png\nnewmtl b\nKe 1 2 3\n";
const TOML: &str = "[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\n[film]\nwidth = 64\nheight = 32\n[render]\nspp = 4\n\
                    [[mesh]]\nobj = \"m.obj\"\ntranslate = [0, 0, 0]\n[material.a]\nkind = \"diffuse\"\ntexture = \"a.png\"\n\
                    [environment]\nmap = \"e.pfm\"\n[[camera.key]]\ntime = 0.0\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\n";

/// A triangle with a camera, a light and what else a glTF scene may have.
const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],"buffers":[{"byteLength":44,"uri":
"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIAAAA="}],"bufferViews":[{"buffer":0,"byteLength":36},
{"buffer":0,"byteOffset":36,"byteLength":6,"byteStride":2}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,
"type":"VEC3"},{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"},{"componentType":5126,"count":3,"type":"VEC2",
"sparse":{"count":1,"indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":0}}}],"meshes":[{"primitives":[
{"attributes":{"POSITION":0,"TEXCOORD_0":2},"indices":1,"material":0}]}],"nodes":[{"mesh":0,"camera":0,"children":[2]},
{"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,5,1],"extensions":{"KHR_lights_punctual":{"light":0}}},{"scale":[1,-1,1],"mesh":0}],
"cameras":[{"type":"perspective","perspective":{"yfov":0.6,"znear":0.1}}],"materials":[{"alphaMode":"MASK",
"pbrMetallicRoughness":{"roughnessFactor":0.5,"baseColorTexture":{"index":0}}}],"textures":[{"source":0}],"images":[{"uri":
"a.png"}],"extensions":{"KHR_lights_punctual":{"lights":[{"type":"spot","spot":{"outerConeAngle":0.5}}]}}}"#;

fn kinds(folder: &Path) -> Vec<Kind> {
    let both = |extension: &str| [own(folder, extension), shared(extension)].concat();
    let text = |text: &str, extension: &str| [vec![text.as_bytes().to_vec()], shared(extension)].concat();
    let jpeg = {
        let mut bytes = Vec::new();
        let texels: Vec<u8> = (0..16 * 16 * 3).map(|texel| texel as u8).collect();
        let mut encoder = image::codecs::jpeg::JpegEncoder::new(&mut bytes);
        encoder.encode(&texels, 16, 16, image::ExtendedColorType::Rgb8).unwrap();
        bytes
    };
    vec![
        Kind { name: "image.exr", seeds: both("exr"), sealed: false, read: image },
        Kind { name: "image.pfm", seeds: both("pfm"), sealed: false, read: image },
        Kind { name: "image.hdr", seeds: both("hdr"), sealed: false, read: image },
        Kind { name: "image.png", seeds: both("png"), sealed: false, read: image },
        Kind {
            name: "a.png",
            seeds: [vec![jpeg], shared("jpg"), own(folder, "png")].concat(),
            sealed: false,
            read: of_scene,
        },
        Kind { name: "m.obj", seeds: text(OBJ, "obj"), sealed: false, read: of_scene },
        Kind { name: "m.mtl", seeds: text(MTL, "mtl"), sealed: false, read: of_scene },
        Kind { name: "scene.toml", seeds: text(TOML, "toml"), sealed: false, read: of_scene },
        Kind { name: "scene.gltf", seeds: text(GLTF, "gltf"), sealed: false, read: scene },
        Kind { name: "scene.glb", seeds: text(GLTF, "glb"), sealed: false, read: scene },
        Kind { name: "a.unfinished", seeds: own(folder, "unfinished"), sealed: true, read: state },
        Kind { name: "a.part", seeds: own(folder, "part"), sealed: true, read: of_render },
    ]
}

fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

#[test]
fn no_file_makes_reading_panic_hang_or_take_all_memory() {
    let folder = tempfile::tempdir().unwrap();
    let count = number("OCTRAY_FUZZ", FILES);
    octray::set_max_memory(Some(4_000_000_000));
    // What failed is told below, once.
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| ()));
    let mut faults = Vec::new();
    let mut slowest = (Duration::ZERO, String::new());
    let only = std::env::var("OCTRAY_FUZZ_KIND").unwrap_or_default();
    for (index, kind) in kinds(folder.path()).into_iter().enumerate().filter(|(_, kind)| kind.name.contains(&only)) {
        let own = folder.path().join(kind.name.replace('.', "-"));
        fs::create_dir(&own).unwrap();
        let films = Film { spp: 1, ..Film::of_sampler(Crop { x: 0, y: 0, width: 4, height: 4 }, Sampler::Independent) };
        for (name, text) in [("m.obj", OBJ), ("m.mtl", MTL), ("scene.toml", TOML)] {
            fs::write(own.join(name), text).unwrap();
        }
        films.save(own.join("e.pfm")).unwrap();
        films.save(own.join("a.png")).unwrap();
        let mut numbers = Numbers(number("OCTRAY_FUZZ_SEED", 1) << 8 | index as u64);
        let path = own.join(kind.name);
        for file in 0..count {
            let seed = numbers.of(&kind.seeds).clone();
            let other = numbers.of(&kind.seeds).clone();
            let mut bytes = mutated(&mut numbers, &seed, &other);
            if kind.sealed && file % 2 == 0 {
                bytes = sealed(bytes);
            }
            fs::write(&path, &bytes).unwrap();
            let begun = Instant::now();
            let done = catch_unwind(AssertUnwindSafe(|| (kind.read)(&path)));
            let took = begun.elapsed();
            if took > slowest.0 {
                slowest = (took, format!("{} {file}", kind.name));
            }
            if done.is_err() || took > MOST {
                let kept = std::env::temp_dir().join(format!("octray-fuzz-{file}-{}", kind.name));
                fs::write(&kept, &bytes).unwrap();
                let what = done.err().and_then(|panic| panic.downcast::<String>().ok()).map(|text| *text);
                faults.push(format!("{}: {} after {took:?}", kept.display(), what.unwrap_or_default()));
            }
        }
    }
    std::panic::set_hook(hook);
    octray::set_max_memory(None);
    println!("{count} files of each kind; the slowest took {:?}: {}", slowest.0, slowest.1);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Parts and states that a render made, cut or changed at every 64th byte: each is refused with a message.
#[test]
fn every_damaged_state_and_part_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for extension in ["unfinished", "part"] {
        for bytes in own(folder.path(), extension) {
            let path = folder.path().join(format!("a.{extension}"));
            let refused = |bytes: &[u8]| {
                fs::write(&path, bytes).unwrap();
                match extension {
                    "part" => part::open(&path).is_err(),
                    _ => checkpoint::read(&path).is_err(),
                }
            };
            assert!(!refused(&bytes));
            for place in (0..bytes.len()).step_by(64) {
                let mut changed = bytes.clone();
                changed[place] ^= 0x10;
                assert!(refused(&changed) && refused(&bytes[..place]), "{extension}, byte {place}");
            }
        }
    }
}
