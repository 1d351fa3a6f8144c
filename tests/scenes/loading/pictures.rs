//! JPEG pictures that are not whole count as pictures that cannot be read.

use super::common::*;
use octray::scene::SceneDesc;
use octray::scene::desc::Scattering;

/// A baseline JPEG as `image` writes it: 24 x 16 pixels in colour.
fn baseline() -> Vec<u8> {
    let picture = image::RgbImage::from_fn(24, 16, |x, y| image::Rgb([(x * 10) as u8, (y * 15) as u8, (x * y) as u8]));
    let mut bytes = Vec::new();
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 80).encode_image(&picture).unwrap();
    bytes
}

/// Entropy-coded bits.
#[derive(Default)]
struct Bits(Vec<bool>);

impl Bits {
    fn push(&mut self, value: u32, size: u32) {
        self.0.extend((0..size).rev().map(|bit| value >> bit & 1 == 1));
    }

    /// Bytes, filled up with ones, a 0 behind each 0xFF.
    fn bytes(mut self) -> Vec<u8> {
        self.0.resize(self.0.len().next_multiple_of(8), true);
        let bytes = self.0.chunks(8).map(|bits| bits.iter().fold(0, |byte, &bit| byte << 1 | u8::from(bit)));
        bytes.flat_map(|byte| if byte == 0xFF { vec![0xFF, 0] } else { vec![byte] }).collect()
    }
}

/// A grey progressive JPEG of 24 x 16 pixels, six blocks, in four scans: all but the lowest bits, then those. `restart`: a restart behind every third block. The codes of the DC coefficients are their symbols in four bits, of the others in eight.
fn progressive(restart: bool) -> Vec<u8> {
    let segment = |marker: u8, body: &[u8]| {
        let length = (body.len() as u16 + 2).to_be_bytes();
        [&[0xFF, marker], &length[..], body].concat()
    };
    let mut jpeg = vec![0xFF, 0xD8];
    jpeg.extend(segment(0xDB, &[&[0][..], &[4; 64]].concat()));
    jpeg.extend(segment(0xC2, &[8, 0, 16, 0, 24, 1, 1, 0x11, 0]));
    let counts =
        |length: usize, count: u8| -> Vec<u8> { (1..=16).map(|l| if l == length { count } else { 0 }).collect() };
    jpeg.extend(segment(0xC4, &[&[0x00][..], &counts(4, 12), &(0..12).collect::<Vec<u8>>()].concat()));
    jpeg.extend(segment(0xC4, &[&[0x10][..], &counts(8, 255), &(0..255).collect::<Vec<u8>>()].concat()));
    if restart {
        jpeg.extend(segment(0xDD, &[0, 3]));
    }
    // Of every block the coefficients 3 and 20 are 2 or 3, and 40 is 0 or 1; the last two blocks have none.
    let has = |block: usize| block < 4;
    let scan = |jpeg: &mut Vec<u8>, header: [u8; 3], block: &dyn Fn(&mut Bits, usize)| {
        jpeg.extend(segment(0xDA, &[&[1, 1, 0x00][..], &header].concat()));
        let blocks = |range: std::ops::Range<usize>| {
            let mut bits = Bits::default();
            range.for_each(|i| block(&mut bits, i));
            bits.bytes()
        };
        match restart {
            true => jpeg.extend([blocks(0..3), vec![0xFF, 0xD0], blocks(3..6)].concat()),
            false => jpeg.extend(blocks(0..6)),
        }
    };
    // DC: a difference of +1, which has one bit.
    scan(&mut jpeg, [0, 0, 0x01], &|bits, _| {
        bits.push(1, 4);
        bits.push(1, 1);
    });
    scan(&mut jpeg, [1, 63, 0x01], &|bits, i| match has(i) {
        true => {
            // Two zeros, then +1; sixteen zeros, then +1 at 20; the end of the block.
            [0x21, 1, 0xF0, 0, 0x01, 1, 0x00].chunks(2).for_each(|code| {
                bits.push(code[0], 8);
                bits.push(code.get(1).copied().unwrap_or(0), code[0] & 15);
            });
        }
        // One end for two blocks.
        false if i == 4 => {
            bits.push(0x10, 8);
            bits.push(0, 1);
        }
        false => {}
    });
    scan(&mut jpeg, [0, 0, 0x10], &|bits, i| bits.push(i as u32 & 1, 1));
    scan(&mut jpeg, [1, 63, 0x10], &|bits, i| match has(i) {
        true => {
            // +1 at 40 behind 37 zeros and two coefficients that get a bit each, then the end.
            for (code, sent) in [(0xF0, 1), (0xF0, 1), (0x51, 0)] {
                bits.push(code, 8);
                bits.push(1, code & 15);
                bits.push(i as u32 & 1, sent);
            }
            bits.push(0x00, 8);
        }
        false if i == 4 => {
            bits.push(0x10, 8);
            bits.push(0, 1);
        }
        false => {}
    });
    jpeg.extend([0xFF, 0xD9]);
    jpeg
}

/// The same triangle with the picture `jpeg`, once named by an MTL and once by a TOML.
fn load_with(folder: &Folder, jpeg: &[u8]) -> [Result<SceneDesc, String>; 2] {
    folder.write("a.jpg", jpeg);
    ["mesh.obj", "scene.toml"].map(|name| folder.load(name))
}

fn folder() -> Folder {
    let obj = format!("mtllib mesh.mtl\nusemtl m\n{TRIANGLE}");
    let toml = format!("{}[material.m]\ntexture = 'a.jpg'\n", TOML.replace("mesh.obj", "plain.obj"));
    let plain = format!("usemtl m\n{TRIANGLE}");
    let mtl = "newmtl m\nKd 0.25 0.5 0.75\nmap_Kd a.jpg\n";
    Folder::new(&[("mesh.obj", &obj), ("mesh.mtl", mtl), ("plain.obj", &plain), ("scene.toml", &toml)])
}

fn assert_read(folder: &Folder, jpeg: &[u8], what: &str) {
    let [of_mtl, of_toml] = load_with(folder, jpeg).map(|scene| scene.expect(what));
    assert!(of_mtl.materials[0].texture.is_some(), "{what}: {:?}", of_mtl.warnings);
    assert!(of_toml.materials[0].texture.is_some(), "{what}: {:?}", of_toml.warnings);
}

fn assert_refused(folder: &Folder, jpeg: &[u8], what: &str) {
    let [of_mtl, of_toml] = load_with(folder, jpeg);
    let message = of_toml.expect_err(what);
    assert!(message.starts_with("scene.toml:7: [material.m]: texture `a.jpg`: "), "{what}: {message}");
    let scene = of_mtl.expect(what);
    assert!(warned(&scene, &["a.jpg: cannot read the texture of material `m`"]), "{what}: {:?}", scene.warnings);
    assert_eq!(scene.materials[0].scattering, Scattering::Diffuse { albedo: [0.25, 0.5, 0.75] }, "{what}");
}

#[test]
fn whole_jpegs_are_read_and_cut_ones_refused_wherever_they_end() {
    let folder = folder();
    for (whole, what) in
        [(baseline(), "baseline"), (progressive(false), "progressive"), (progressive(true), "restarts")]
    {
        assert_read(&folder, &whole, what);
        // Trailing bytes are no part of the picture.
        assert_read(&folder, &[&whole[..], &[0, 0xFF, 0xD8, 7]].concat(), what);
        for end in 0..whole.len() {
            assert_refused(&folder, &whole[..end], &format!("{what}: {end} of {} bytes", whole.len()));
        }
    }
}

#[test]
fn an_end_put_behind_what_was_cut_off_makes_no_jpeg_whole() {
    let folder = folder();
    for (whole, what) in
        [(baseline(), "baseline"), (progressive(false), "progressive"), (progressive(true), "restarts")]
    {
        let scan = whole.windows(2).position(|pair| pair == [0xFF, 0xDA]).expect("a scan") + 10;
        // The last bytes may be filled up with bits that say nothing: only their loss can go unnoticed.
        for end in scan..whole.len() - 3 {
            let ended = [&whole[..end], &[0xFF, 0xD9]].concat();
            assert_refused(&folder, &ended, &format!("{what}: {end} of {} bytes", whole.len()));
        }
    }
    // A header that claims more than there is.
    let mut taller = baseline();
    let frame = taller.windows(2).position(|pair| pair == [0xFF, 0xC0]).expect("a frame");
    taller[frame + 5] = 1;
    assert_refused(&folder, &taller, "256 lines more");
}
