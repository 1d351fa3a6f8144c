//! Environment maps and textures as other programs write them.

use super::common::*;
use octray::scene::SceneDesc;
use octray::scene::desc::EnvironmentDesc;

/// Loads [`TOML`] lit by the map `name` of these bytes.
fn lit_by(name: &str, bytes: &[u8]) -> Result<SceneDesc, String> {
    let toml = format!("{TOML}[environment]\nmap = '{name}'\n");
    let folder = Folder::new(&[("mesh.obj", TRIANGLE), ("scene.toml", &toml)]);
    folder.write(name, bytes);
    folder.load("scene.toml")
}

/// The map's width and texels, and the scene's warnings.
fn map(name: &str, bytes: &[u8]) -> (u32, Vec<[f32; 3]>, Vec<String>) {
    let scene = lit_by(name, bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
    match scene.environment().cloned() {
        Some(EnvironmentDesc::Map(map)) => (map.width, map.texels, scene.warnings),
        other => panic!("{name}: no map: {other:?}"),
    }
}

const HEAD: &str = "FORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 9\n";

/// Nine flat pixels of 1 to 9 times 2^-7, in all channels.
fn pixels() -> Vec<u8> {
    (1..=9u8).flat_map(|i| [i, i, i, 129]).collect()
}

fn grey(values: impl IntoIterator<Item = f32>) -> Vec<[f32; 3]> {
    values.into_iter().map(|value| [value / 128.0; 3]).collect()
}

/// A Radiance file: first line, the rest of the header, data.
fn radiance(first: &str, head: &str, data: &[u8]) -> Vec<u8> {
    [first.as_bytes(), b"\n", head.as_bytes(), data].concat()
}

#[test]
fn radiance_headers_of_all_programs_are_read() {
    let plain = grey((1..=9).map(|i| i as f32));
    let of = |first: &str, head: &str| map("a.hdr", &radiance(first, head, &pixels()));
    assert_eq!(of("#?RADIANCE", HEAD), (9, plain.clone(), vec![]));
    assert_eq!(of("#?RGBE", HEAD).1, plain);
    assert_eq!(of("#?RGBE\r", &HEAD.replace('\n', "\r\n")).1, plain);
    assert_eq!(of("#?RADIANCE", &format!("# a = b\nGAMMA=1\nPRIMARIES=0 0 0 0 0 0 0 0\n{HEAD}")).1, plain);
    // What has been multiplied by 2 and by 4 is an eighth of that.
    let dimmed = of("#?RADIANCE", &format!("EXPOSURE=2.0\nEXPOSURE= 4\n{HEAD}")).1;
    assert_eq!(dimmed, grey((1..=9).map(|i| i as f32 / 8.0)));
    let colours = of("#?RADIANCE", &format!("COLORCORR=1 2 4\n{HEAD}")).1;
    assert_eq!(colours[7], [8.0 / 128.0, 4.0 / 128.0, 2.0 / 128.0]);
    for (head, words) in [
        (HEAD.replace("rgbe", "abc"), "FORMAT=32-bit_rle_abc"),
        (format!("EXPOSURE=0\n{HEAD}"), "EXPOSURE=0"),
        (HEAD.replace("+X", "+Z"), "-Y HEIGHT +X WIDTH"),
        ("FORMAT=32-bit_rle_rgbe\n".into(), "cut short"),
    ] {
        let error = lit_by("a.hdr", &radiance("#?RADIANCE", &head, &pixels())).expect_err(words);
        assert!(error.contains(words), "{error}");
    }
    let error = lit_by("a.hdr", b"RADIANCE\n\n").unwrap_err();
    assert!(error.contains("#?RADIANCE or #?RGBE"), "{error}");
}

#[test]
fn radiance_pictures_lie_as_their_size_line_says() {
    let two_by_three = |size: &str| {
        let data: Vec<u8> = (1..=6u8).flat_map(|i| [i, i, i, 129]).collect();
        let (width, texels, _) = map("a.hdr", &radiance("#?RADIANCE", &format!("\n{size}\n"), &data));
        (width, texels.iter().map(|texel| (texel[0] * 128.0) as u32).collect::<Vec<_>>())
    };
    assert_eq!(two_by_three("-Y 2 +X 3"), (3, vec![1, 2, 3, 4, 5, 6]));
    assert_eq!(two_by_three("+Y 2 +X 3"), (3, vec![4, 5, 6, 1, 2, 3]));
    assert_eq!(two_by_three("-Y 2 -X 3"), (3, vec![3, 2, 1, 6, 5, 4]));
    assert_eq!(two_by_three("+X 3 -Y 2"), (3, vec![1, 3, 5, 2, 4, 6]));
    assert_eq!(two_by_three("-X 3 +Y 2"), (3, vec![6, 4, 2, 5, 3, 1]));
}

#[test]
fn radiance_codes_are_told_from_flat_pixels() {
    let read = |data: &[u8]| map("a.hdr", &radiance("#?RADIANCE", HEAD, data)).1;
    // New code: a run of nine, or nine bytes, in each component.
    let run = |value: u8| vec![128 + 9, value];
    let coded = [vec![2, 2, 0, 9], run(64), run(32), [vec![9], (1..=9).collect()].concat(), run(129)].concat();
    let wanted: Vec<[f32; 3]> = (1..=9).map(|i| [64.0, 32.0, i as f32].map(|x: f32| x / 128.0)).collect();
    assert_eq!(read(&coded), wanted);
    // Old code: one pixel, repeated eight times.
    assert_eq!(read(&[5, 5, 5, 129, 1, 1, 1, 8]), grey([5.0; 9]));
    // Flat pixels that look like either.
    let mut flat = pixels();
    flat[..4].copy_from_slice(&[2, 2, 0, 9]);
    assert_eq!(read(&flat)[1..], grey((2..=9).map(|i| i as f32))[..]);
    flat[4..8].copy_from_slice(&[1, 1, 1, 129]);
    assert_eq!(read(&flat)[1..], grey([1].into_iter().chain(3..=9).map(|i| i as f32))[..]);
    for cut in [&coded[..coded.len() - 1], &pixels()[..32], &[2, 2, 0, 9][..], &[][..]] {
        let error = lit_by("a.hdr", &radiance("#?RADIANCE", HEAD, cut)).expect_err("cut");
        assert!(error.contains("cut short"), "{error}");
    }
}

#[test]
fn pfm_headers_of_all_programs_are_read() {
    // The first byte of the data is a line feed.
    let values: Vec<f32> = (0..6).map(|i| f32::from_bits(0x3f80_000a + (i << 20))).collect();
    let data: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let read = |head: &str, tail: &str| map("a.pfm", &[head.as_bytes(), &data, tail.as_bytes()].concat());
    let texels = vec![[values[3], values[4], values[5]], [values[0], values[1], values[2]]];
    for (head, tail) in [
        ("PF\n1 2\n-1.0\n", ""),
        ("PF\r\n1 2\r\n-1.0\r\n", ""),
        ("PF\n# made by hand\n1 2\n-1.0\n", "\n"),
        ("PF 1 2 -1 ", "\r\n"),
    ] {
        assert_eq!(read(head, tail), (1, texels.clone(), vec![]), "{head:?}");
    }
    let (_, photoshop, warnings) = read("PF\n1\n2\n-1.000000\n", "");
    assert_eq!(photoshop, [texels[1], texels[0]]);
    assert!(warnings.iter().any(|warning| warning.contains("rows are taken from the top")), "{warnings:?}");
    for (tail, cut) in [("x", 0), ("", 1)] {
        let bytes = [b"PF\n1 2\n-1\n", &data[..data.len() - cut], tail.as_bytes()].concat();
        assert!(lit_by("a.pfm", &bytes).is_err_and(|error| error.contains("24 are expected")));
    }
}

/// An uncompressed EXR of f32: data and display window, channels by name in the file's order with their planes, attributes.
fn exr(
    data: [i32; 4],
    shown: [i32; 4],
    channels: &[(&str, Vec<f32>)],
    attributes: &[(&str, &str, Vec<u8>)],
) -> Vec<u8> {
    let mut file = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
    let mut attribute = |name: &str, kind: &str, value: &[u8]| {
        let size = (value.len() as u32).to_le_bytes();
        file.extend([name.as_bytes(), &[0], kind.as_bytes(), &[0], &size, value].concat());
    };
    let window = |window: [i32; 4]| window.map(i32::to_le_bytes).concat();
    let one = 1i32.to_le_bytes();
    let list =
        channels.iter().flat_map(|(name, _)| [name.as_bytes(), &[0, 2, 0, 0, 0, 0, 0, 0, 0], &one, &one].concat());
    attribute("channels", "chlist", &list.chain([0]).collect::<Vec<u8>>());
    attributes.iter().for_each(|(name, kind, value)| attribute(name, kind, value));
    attribute("compression", "compression", &[0]);
    attribute("dataWindow", "box2i", &window(data));
    attribute("displayWindow", "box2i", &window(shown));
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
    file.push(0);
    let (width, height) = ((data[2] - data[0] + 1) as usize, (data[3] - data[1] + 1) as usize);
    let row = 8 + width * 4 * channels.len();
    let first = file.len() + 8 * height;
    (0..height).for_each(|y| file.extend(((first + y * row) as u64).to_le_bytes()));
    for y in 0..height {
        file.extend((data[1] + y as i32).to_le_bytes());
        file.extend(((row - 8) as u32).to_le_bytes());
        let values = channels.iter().flat_map(|(_, plane)| &plane[y * width..(y + 1) * width]);
        file.extend(values.flat_map(|value| value.to_le_bytes()));
    }
    file
}

const TWO: [i32; 4] = [0, 0, 1, 0];

/// Red 1 and 4, green 2 and 5, blue 3 and 6, under these names for blue, green, red.
fn rgb(names: [&str; 3]) -> Vec<(&str, Vec<f32>)> {
    vec![(names[0], vec![3.0, 6.0]), (names[1], vec![2.0, 5.0]), (names[2], vec![1.0, 4.0])]
}

#[test]
fn exr_windows_place_the_data() {
    let wanted = vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
    let file = |data, shown| map("a.exr", &exr(data, shown, &rgb(["B", "G", "R"]), &[]));
    assert_eq!(file(TWO, TWO), (2, wanted.clone(), vec![]));
    // Black outside the data window; what is outside the display window is not shown.
    let (width, texels, _) = file([-3, 5, -2, 5], [-4, 4, -1, 6]);
    assert_eq!((width, texels.len(), &texels[5..7]), (4, 12, &wanted[..]));
    assert_eq!(texels.iter().filter(|texel| **texel == [0.0; 3]).count(), 10);
    assert_eq!(file([-1, 0, 0, 0], [0, 0, 0, 0]), (1, vec![wanted[1]], vec![]));
    // A display window that nobody has the memory for.
    let error = lit_by("a.exr", &exr(TWO, [0, 0, i32::MAX - 1, i32::MAX - 1], &rgb(["B", "G", "R"]), &[])).unwrap_err();
    assert!(error.contains("scene.toml:"), "{error}");
}

#[test]
fn exr_layers_are_found_by_their_names() {
    let wanted = vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
    let with = |more: &[(&str, Vec<f32>)], names: [&'static str; 3]| {
        let mut channels: Vec<(&str, Vec<f32>)> = more.iter().cloned().chain(rgb(names)).collect();
        channels.sort_by_key(|(name, _)| name.to_string());
        map("a.exr", &exr(TWO, TWO, &channels, &[]))
    };
    assert_eq!(
        with(&[], ["ViewLayer.Combined.B", "ViewLayer.Combined.G", "ViewLayer.Combined.R"]),
        (2, wanted.clone(), vec![])
    );
    assert_eq!(with(&[], ["b", "g", "r"]).1, wanted);
    let other: Vec<(&str, Vec<f32>)> = ["a.B", "a.G", "a.R"].map(|name| (name, vec![9.0; 2])).to_vec();
    // The file's own colours, and a layer that is called so, come before others.
    assert_eq!(with(&other, ["B", "G", "R"]), (2, wanted.clone(), vec![]));
    assert_eq!(with(&other, ["x.beauty.B", "x.beauty.G", "x.beauty.R"]), (2, wanted.clone(), vec![]));
    // Of two that are called so, the first is a guess.
    let beauty: Vec<(&str, Vec<f32>)> =
        ["l.beauty.B", "l.beauty.G", "l.beauty.R"].map(|name| (name, vec![9.0; 2])).to_vec();
    let (_, texels, warnings) = with(&beauty, ["r.beauty.B", "r.beauty.G", "r.beauty.R"]);
    assert!(texels == [[9.0; 3]; 2] && warnings[0].contains("`l.beauty`, `r.beauty`"), "{warnings:?}");
    // A part's own colours come before its layers, whatever part and layers are called.
    let mut channels =
        [rgb(["B", "G", "R"]), ["color.B", "color.G", "color.R"].map(|name| (name, vec![9.0; 2])).to_vec()].concat();
    channels.sort_by_key(|(name, _)| name.to_string());
    let named = [("name", "string", b"first pass".to_vec())];
    assert_eq!(map("a.exr", &exr(TWO, TWO, &channels, &named)), (2, wanted.clone(), vec![]));
    // Where nothing tells, it is said which one is read.
    let (_, texels, warnings) = with(&other, ["z.B", "z.G", "z.R"]);
    assert!(texels == [[9.0; 3]; 2] && warnings[0].contains("`a`, `z`"), "{warnings:?}");
    // A luminance alone is grey.
    assert_eq!(map("a.exr", &exr(TWO, TWO, &[("Y", vec![1.0, 2.0])], &[])).1, [[1.0; 3], [2.0; 3]]);
    let depth = [("Depth.Z", vec![1.0; 2]), ("N.X", vec![1.0; 2]), ("N.Y", vec![1.0; 2])];
    let error = lit_by("a.exr", &exr(TWO, TWO, &depth, &[])).unwrap_err();
    assert!(error.contains("`Depth.Z`, `N.X`, `N.Y`"), "{error}");
}

#[test]
fn exr_attributes_are_heeded() {
    let chromaticities = |of: [f32; 8]| ("chromaticities", "chromaticities", of.map(f32::to_le_bytes).concat());
    let white = [("B", vec![1.0]), ("G", vec![1.0]), ("R", vec![1.0])];
    let red = [("B", vec![0.0]), ("G", vec![0.0]), ("R", vec![1.0])];
    let one = [0; 4];
    // Rec.2020: white stays white; its red is (1.6605, -0.1246, -0.0182) in Rec.709 (ITU-R BT.2087), negatives count 0.
    let rec2020 = [0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290];
    let (_, texels, warnings) = map("a.exr", &exr(one, one, &white, &[chromaticities(rec2020)]));
    assert!(texels[0].iter().all(|value| (value - 1.0).abs() < 1e-6) && warnings.is_empty(), "{texels:?} {warnings:?}");
    let (_, texels, warnings) = map("a.exr", &exr(one, one, &red, &[chromaticities(rec2020)]));
    assert!((texels[0][0] - 1.6605).abs() < 1e-3 && texels[0][1] == 0.0, "{texels:?}");
    assert!(warnings.iter().any(|warning| warning.contains("negative")), "{warnings:?}");
    // What colours are mixed of has variances, their mixture has none that is known.
    let variances = ["variance.B", "variance.G", "variance.R"].map(|name| (name, vec![0.25]));
    let with_variance = |attributes: &[(&str, &str, Vec<u8>)]| {
        let folder = Folder::new(&[]);
        folder.write("a.exr", &exr(one, one, &[&red[..], &variances].concat(), attributes));
        octray::internal::image::Image::read(folder.path("a.exr")).unwrap().variance
    };
    assert_eq!(with_variance(&[]), Some(vec![[0.25; 3]]));
    assert_eq!(with_variance(&[chromaticities(rec2020)]), None);
    let (_, texels, warnings) = map("a.exr", &exr(one, one, &red, &[chromaticities([0.0; 8])]));
    assert!(texels == [[1.0, 0.0, 0.0]] && warnings[0].contains("chromaticities"), "{warnings:?}");
    // The six faces of a cube are no map of ours; latitude-longitude is.
    let envmap = |kind: u8| [("envmap", "envmap", vec![kind])];
    assert_eq!(map("a.exr", &exr(one, one, &white, &envmap(0))).1, [[1.0; 3]]);
    assert!(lit_by("a.exr", &exr(one, one, &white, &envmap(1))).is_err_and(|error| error.contains("cube")));
}

#[test]
fn exr_headers_of_ours_are_utf8() {
    let mut film = octray::Film::new(octray::Crop { x: 0, y: 0, width: 1, height: 1 });
    film.spp = 1;
    film.metadata = vec![("scene".into(), "bïld → 絵.obj".into())];
    let folder = Folder::new(&[]);
    film.save(folder.path("a.exr")).unwrap();
    let bytes = std::fs::read(folder.path("a.exr")).unwrap();
    let wanted = "scene = bïld → 絵.obj".as_bytes();
    assert!(bytes.windows(wanted.len()).any(|window| window == wanted));
    let image = octray::internal::image::Image::read(folder.path("a.exr")).unwrap();
    assert_eq!(image.metadata, film.metadata);
}

#[test]
fn tga_and_16_bit_textures_are_read() {
    let folder = Folder::new(&[
        ("mesh.obj", &format!("mtllib m.mtl\nusemtl a\n{TRIANGLE}usemtl b\nf 1 2 3\n")),
        ("m.mtl", "newmtl a\nmap_Kd a.TGA\nnewmtl b\nmap_Kd b.png\n"),
    ]);
    // Uncompressed, 24 bits, blue first, from the top.
    let header = [0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 1, 0, 24, 0x20];
    folder.write("a.TGA", &[&header[..], &[3, 2, 1, 6, 5, 4]].concat());
    let deep = image::ImageBuffer::<image::Rgb<u16>, _>::from_raw(1, 1, vec![0x1234, 0x8000, 0xffff]).unwrap();
    deep.save(folder.path("b.png")).unwrap();
    let scene = folder.load("mesh.obj").unwrap();
    assert_eq!(scene.textures[0].texels, [[1, 2, 3], [4, 5, 6]]);
    assert_eq!(scene.textures[1].texels, [[0x12, 0x80, 0xff]]);
    // One that is cut short is no texture.
    folder.write("a.TGA", &[&header[..], &[3, 2, 1, 6]].concat());
    assert!(warned(&folder.load("mesh.obj").unwrap(), &["a.TGA", "cannot read the texture"]));
}
