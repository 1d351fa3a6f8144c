//! glTF scenes: what they say arrives, what is not kept is told, and no file makes loading panic.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use octray::Result;
use octray::scene::desc::{DeltaLight, MaterialDesc, Scattering, SceneDesc};
use octray::scene::transform::Transform;
use octray::{Scene, Settings, render};
use std::f64::consts::FRAC_1_SQRT_2;

/// Bytes as a `data:` address.
fn data(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", STANDARD.encode(bytes))
}

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// A file whose only buffer begins with the unit square in the plane z = 0, facing +z: 4 positions (48 bytes), 4 texture
/// coordinates (32), 6 indices of 16 bits (12), then `more`. `rest` is the JSON besides.
fn file(rest: &str, more: &[u8]) -> String {
    let mut bytes = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    bytes.extend(floats(&[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]));
    bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|x| x.to_le_bytes()));
    bytes.extend(more);
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
        "buffers": [{{"byteLength": {}, "uri": "{}"}}], {rest} }}"#,
        bytes.len(),
        data("application/octet-stream", &bytes)
    )
}

/// Views of the square: positions, texture coordinates, indices.
const VIEWS: &str = r#"{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 32},
    {"buffer": 0, "byteOffset": 80, "byteLength": 12}"#;

/// Accessors of them.
const ACCESSORS: &str = r#"
    {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
    {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
    {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}"#;

/// The square, and `rest` of the JSON: nodes and what they name.
fn square(rest: &str) -> String {
    file(&format!(r#""bufferViews": [{VIEWS}], "accessors": [{ACCESSORS}], {rest}"#), &[])
}

/// One node with the square of one material.
fn with_material(material: &str, rest: &str) -> String {
    square(&format!(
        r#""nodes": [{{"mesh": 0}}], "materials": [{material}], {rest} "meshes": [{{"primitives": [{{
        "attributes": {{"POSITION": 0, "TEXCOORD_0": 1}}, "indices": 2, "material": 0}}]}}]"#
    ))
}

fn load_bytes(name: &str, bytes: &[u8]) -> Result<SceneDesc> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    SceneDesc::load(&path)
}

fn load(text: &str) -> SceneDesc {
    load_bytes("scene.gltf", text.as_bytes()).unwrap_or_else(|error| panic!("{error}"))
}

/// What is wrong with a file.
fn refusal(text: &str) -> String {
    let error = load_bytes("scene.gltf", text.as_bytes()).expect_err(text);
    assert_eq!(error.exit_status(), 2, "{error}");
    error.to_string()
}

/// A binary file of JSON and data.
fn binary(json: &str, bytes: &[u8]) -> Vec<u8> {
    let padded = |bytes: &[u8], with: u8| {
        let mut bytes = bytes.to_vec();
        bytes.resize(bytes.len().next_multiple_of(4), with);
        bytes
    };
    let (json, bytes) = (padded(json.as_bytes(), b' '), padded(bytes, 0));
    let words = |words: [u32; 2]| words.map(u32::to_le_bytes).concat();
    let length = 28 + json.len() + bytes.len();
    [
        b"glTF".to_vec(),
        words([2, length as u32]),
        words([json.len() as u32, u32::from_le_bytes(*b"JSON")]),
        json,
        words([bytes.len() as u32, u32::from_le_bytes(*b"BIN\0")]),
        bytes,
    ]
    .concat()
}

fn only_material(scene: &SceneDesc) -> &MaterialDesc {
    let [material] = &scene.materials[..] else { panic!("{:?}", scene.materials) };
    material
}

fn has_warning(scene: &SceneDesc, part: &str) -> bool {
    scene.warnings.iter().any(|warning| warning.contains(part))
}

const MESH: &str = r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 2}]}]"#;

#[test]
fn the_tree_of_nodes_places_meshes_and_cameras() {
    // A parent that turns by 90 degrees about +y and moves, a child that scales and mirrors, a camera below the parent.
    let scene = load(&square(&format!(
        r#"{MESH}, "cameras": [{{"type": "perspective", "perspective": {{"yfov": 0.5, "aspectRatio": 1.5, "znear": 0.1}}}}],
        "nodes": [{{"children": [1, 2], "translation": [10, 0, 0], "rotation": [0, {FRAC_1_SQRT_2}, 0, {FRAC_1_SQRT_2}]}},
        {{"mesh": 0, "scale": [2, 3, -1]}}, {{"name": "eye", "camera": 0, "translation": [0, 0, 5], "scale": [7, 7, 7]}}]"#
    )));
    let geometry = scene.geometry();
    // (1, 1, 0) is scaled to (2, 3, 0), turned to (0, 3, -2), moved.
    let corner = geometry.positions[2];
    assert!(corner.iter().zip([10.0, 3.0, -2.0]).all(|(a, b)| (a - b).abs() < 1e-5), "{corner:?}");
    assert!(geometry.triangles.iter().all(|triangle| triangle.flipped), "a mirrored mesh turns its winding");
    assert_eq!(scene.film, (768, 512));
    let camera = scene.camera;
    assert!((camera.vertical_fov - 0.5f64.to_degrees()).abs() < 1e-5);
    let eye = camera.eye();
    assert!(eye.iter().zip([15.0, 0.0, 0.0]).all(|(a, b)| (a - b).abs() < 1e-5), "{eye:?}");
    let rows = camera.to_world.unwrap();
    let backward = rows.map(|row| row[2]);
    assert!(backward.iter().zip([1.0, 0.0, 0.0]).all(|(a, b)| (a - b).abs() < 1e-6), "unit vectors: {rows:?}");
    assert_eq!(scene.cameras.iter().map(|camera| camera.name.as_str()).collect::<Vec<_>>(), ["eye"]);
    assert!(scene.default_light && has_warning(&scene, "nothing emits light"));
}

#[test]
fn a_mesh_at_many_nodes_is_read_once() {
    let scene = load(&square(&format!(
        r#"{MESH}, "nodes": [{{"children": [1, 2, 3], "mesh": 0}}, {{"mesh": 0, "translation": [2, 0, 0]}},
        {{"mesh": 0, "scale": [0, 1, 1]}}, {{"mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,5,0,1]}}]"#
    )));
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 3));
    assert_eq!(scene.instances[0].transform, Transform::Identity);
    assert_eq!(scene.geometry().positions[8], [0.0, 5.0, 0.0]);
    assert!(has_warning(&scene, "scaled to nothing"));
}

#[test]
fn punctual_lights_are_delta_lights() {
    let scene = load(&square(&format!(
        r#"{MESH}, "extensionsUsed": ["KHR_lights_punctual"], "extensions": {{"KHR_lights_punctual": {{"lights": [
        {{"type": "point", "intensity": 8, "color": [1, 0.5, 0.25], "range": 5}}, {{"type": "directional", "name": "sun"}},
        {{"type": "spot", "spot": {{"innerConeAngle": 0.2, "outerConeAngle": 0.5}}}}]}}}},
        "nodes": [{{"mesh": 0, "children": [1, 2, 3]}},
        {{"name": "bulb", "translation": [1, 2, 3], "extensions": {{"KHR_lights_punctual": {{"light": 0}}}}}},
        {{"rotation": [-{FRAC_1_SQRT_2}, 0, 0, {FRAC_1_SQRT_2}], "extensions": {{"KHR_lights_punctual": {{"light": 1}}}}}},
        {{"extensions": {{"KHR_lights_punctual": {{"light": 2}}}}}}]"#
    )));
    let lights: Vec<_> = scene.delta_lights().collect();
    assert_eq!(lights.iter().map(|light| light.name.as_str()).collect::<Vec<_>>(), ["bulb", "sun", "light 2"]);
    assert_eq!(lights[0].light, DeltaLight::Point { position: [1.0, 2.0, 3.0], intensity: [8.0, 4.0, 2.0] });
    let DeltaLight::Directional { direction, irradiance } = lights[1].light else { panic!("{lights:?}") };
    // -z, turned by -90 degrees about +x.
    assert!((direction[1] + 1.0).abs() < 1e-6 && irradiance == [1.0; 3], "{direction:?}");
    let DeltaLight::Spot { direction, cone_angle, cone_delta_angle, .. } = lights[2].light else {
        panic!("{lights:?}")
    };
    assert_eq!(direction, [0.0, 0.0, -1.0]);
    assert!((cone_angle - 0.5f64.to_degrees()).abs() < 1e-5 && (cone_delta_angle - 0.3f64.to_degrees()).abs() < 1e-5);
    assert!(!scene.default_light && has_warning(&scene, "the range of lights is not kept"));
}

#[test]
fn materials_are_principled_and_extensions_change_them() {
    let scene = load(&with_material(
        r#"{"name": "paint", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 1, 1], "metallicFactor": 0.5,
        "roughnessFactor": 0.3}, "emissiveFactor": [1, 0, 0.5], "extensions": {"KHR_materials_ior": {"ior": 1.33},
        "KHR_materials_emissive_strength": {"emissiveStrength": 4}, "KHR_materials_sheen": {}}}"#,
        "",
    ));
    let material = only_material(&scene);
    assert_eq!((material.name.as_str(), material.emission, material.two_sided), ("paint", [4.0, 0.0, 2.0], false));
    let Scattering::Principled { base_color, metallic, roughness, ior } = material.scattering else { panic!() };
    assert_eq!((base_color, metallic, roughness as f32, ior as f32), ([0.5, 0.25, 1.0], 0.5, 0.3, 1.33));
    assert!(has_warning(&scene, "`KHR_materials_sheen` is not kept"), "{:?}", scene.warnings);

    let unlit = r#"{"doubleSided": true, "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 1, 1]},
        "extensions": {"KHR_materials_unlit": {}}}"#;
    let scene = load(&with_material(unlit, ""));
    let material = only_material(&scene);
    assert_eq!((material.emission, material.two_sided), ([0.5, 0.25, 1.0], true));
    assert_eq!(material.scattering, Scattering::Diffuse { albedo: [0.0; 3] });

    let glass = |volume: &str| {
        let text = format!(
            r#"{{"pbrMetallicRoughness": {{"metallicFactor": 0, "baseColorFactor": [0.9, 1, 0.8, 1]}}, "extensions": {{
            "KHR_materials_transmission": {{"transmissionFactor": 1}} {volume}}}}}"#
        );
        only_material(&load(&with_material(&text, ""))).scattering
    };
    let solid = glass(r#", "KHR_materials_volume": {"thicknessFactor": 1}"#);
    let transmittance = [0.9f32, 1.0, 0.8].map(f64::from);
    assert_eq!(solid, Scattering::Dielectric { ior: 1.5, transmittance });
    assert_eq!(glass(""), Scattering::Dielectric { ior: 1.0, transmittance });
}

/// A picture of two pixels: red with an alpha of 200, blue with one of 60.
fn png() -> String {
    let mut bytes = Vec::new();
    let picture = image::RgbaImage::from_raw(2, 1, vec![255, 0, 0, 200, 0, 0, 255, 60]).unwrap();
    picture.write_to(&mut std::io::Cursor::new(&mut bytes), image::ImageFormat::Png).unwrap();
    data("image/png", &bytes)
}

#[test]
fn textures_lie_as_the_file_says_and_alpha_cuts_out() {
    let images = format!(r#""textures": [{{"source": 0}}], "images": [{{"uri": "{}"}}],"#, png());
    let textured = |rest: &str| {
        let text = format!(r#"{{"pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0 {rest}}}}}}}"#);
        load(&with_material(&text, &images))
    };
    let scene = textured("");
    assert_eq!(scene.textures[0].texels, [[255, 0, 0], [0, 0, 255]]);
    // v is turned: the square's first corner, at (0, 0), shows the picture's lower left.
    assert_eq!(scene.meshes[0].corners[0].uvs, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);

    // Turned by 90 degrees counter-clockwise with v down: (u, v) goes to (v, -u), then is shifted.
    let scene = textured(
        r#", "extensions": {"KHR_texture_transform": {"offset": [0.25, 1], "rotation": 1.5707963705062866, "scale": [2, 1]}}"#,
    );
    let close = |a: [f32; 2], b: [f32; 2]| (0..2).all(|i| (a[i] - b[i]).abs() < 1e-6);
    let [a, b, c] = scene.meshes[0].corners[0].uvs;
    assert!(close(a, [1.25, 0.0]) && close(b, [1.25, 2.0]) && close(c, [0.25, 2.0]), "{a:?} {b:?} {c:?}");

    let masked = |cutoff: f64, alpha: f64| {
        let text = format!(
            r#"{{"alphaMode": "MASK", "alphaCutoff": {cutoff}, "pbrMetallicRoughness": {{
            "baseColorFactor": [1, 1, 1, {alpha}], "baseColorTexture": {{"index": 0}}}}}}"#
        );
        load_bytes("scene.gltf", with_material(&text, &images).as_bytes())
    };
    let seen = |cutoff: f64, alpha: f64| {
        let scene = masked(cutoff, alpha).unwrap();
        let seen = scene.masks.first().map(|mask| mask.texels.iter().map(|&texel| texel >= 128).collect::<Vec<_>>());
        (only_material(&scene).alpha_mask.is_some(), seen)
    };
    assert_eq!(seen(0.5, 1.0), (true, Some(vec![true, false])));
    assert_eq!(seen(0.9, 1.0), (true, Some(vec![false, false])));
    assert!(!seen(0.2, 1.0).0, "nothing is hidden: no mask");
    assert_eq!(seen(0.2, 0.5), (true, Some(vec![true, false])), "the factor counts");
    // An image that only an extension knows.
    let text = r#"{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}"#;
    let scene = load(&with_material(text, r#""textures": [{"extensions": {"KHR_texture_basisu": {"source": 0}}}],"#));
    assert!(only_material(&scene).texture.is_none() && has_warning(&scene, "cannot read its base colour texture"));
    // Without a texture the factor alone decides.
    let gone = r#"{"alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.4]}}"#;
    assert!(refusal(&with_material(gone, "")).contains("no triangles"));
}

#[test]
fn numbers_of_every_type_arrive() {
    // Positions as normalised bytes with a stride of 4, one of them replaced by a sparse value; indices are given by a fan.
    let mut more: Vec<u8> = [[127i8, 0, 0, 9], [0, 127, 0, 9], [-127, 0, 0, 9], [0, -128, 0, 9]]
        .concat()
        .iter()
        .map(|&x| x as u8)
        .collect();
    more.extend([3, 0, 0, 0]);
    more.extend([0, 0, 64, 0]);
    let text = file(
        r#""extensionsUsed": ["KHR_mesh_quantization"], "extensionsRequired": ["KHR_mesh_quantization"],
        "bufferViews": [{"buffer": 0, "byteOffset": 92, "byteLength": 16, "byteStride": 4},
        {"buffer": 0, "byteOffset": 108, "byteLength": 4}, {"buffer": 0, "byteOffset": 112, "byteLength": 4}],
        "accessors": [{"bufferView": 0, "componentType": 5120, "normalized": true, "count": 4, "type": "VEC3",
        "sparse": {"count": 1, "indices": {"bufferView": 1, "componentType": 5121}, "values": {"bufferView": 2}}}],
        "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 6}]}]"#,
        &more,
    );
    let scene = load(&text);
    let expected = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 64.0 / 127.0]];
    assert_eq!(scene.meshes[0].positions, expected);
    assert_eq!(scene.meshes[0].triangles.iter().map(|t| t.vertices).collect::<Vec<_>>(), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn binary_files_hold_their_data() {
    let text = square(&format!(r#"{MESH}, "nodes": [{{"mesh": 0}}]"#));
    let plain = load(&text);
    let (uri, _) = text.split_once("base64,").map(|(_, rest)| rest.split_once('"').unwrap()).unwrap();
    let bytes = STANDARD.decode(uri).unwrap();
    let json = text.replace(&format!(r#", "uri": "data:application/octet-stream;base64,{uri}""#), "");
    let whole = binary(&json, &bytes);
    let scene = load_bytes("scene.glb", &whole).unwrap();
    assert_eq!((&scene.meshes, &scene.instances), (&plain.meshes, &plain.instances));
    for end in [4, 8, 11, 12, 19, 40, whole.len() - 70] {
        assert_eq!(load_bytes("scene.glb", &whole[..end]).unwrap_err().exit_status(), 2, "{end}");
    }
    let mut short = whole.clone();
    short[8..12].copy_from_slice(&3u32.to_le_bytes());
    assert!(load_bytes("scene.glb", &short).unwrap_err().to_string().contains("ends within its header"));
}

#[test]
fn faults_are_named_by_their_place() {
    let nodes = |nodes: &str| square(&format!(r#"{MESH}, "nodes": [{nodes}]"#));
    let square_of = |accessors: &str| {
        file(&format!(r#""bufferViews": [{VIEWS}], "accessors": [{accessors}], {MESH}, "nodes": [{{"mesh": 0}}]"#), &[])
    };
    let replaced = |from: &str, to: &str| square_of(&ACCESSORS.replacen(from, to, 1));
    let cases = [
        (nodes(r#"{"children": [0]}"#), "nodes[0]: it stands at two places"),
        (nodes(r#"{"children": [1, 1]}, {"mesh": 0}"#), "nodes[1]: it stands at two places"),
        (nodes(r#"{"children": [1]}, {"children": [0]}"#), "nodes[0]: it stands at two places"),
        (nodes(r#"{"mesh": 7}"#), "nodes[0].mesh: index out of bounds"),
        (nodes(r#"{"children": [1]}"#), "index out of bounds"),
        (nodes(r#"{}"#), "no triangles"),
        (replaced(r#""count": 4"#, r#""count": 5"#), "accessors[0]: its 5 elements reach beyond bufferViews[0]"),
        (replaced(r#""count": 4"#, r#""count": 18446744073709551615"#), "reach beyond bufferViews[0]"),
        (replaced(r#""count": 6"#, r#""count": 7"#), "accessors[2]: its 7 elements reach beyond bufferViews[2]"),
        (replaced(r#""count": 4"#, r#""count": 2"#), "meshes[0].primitives[0]: it names vertex 2; it has 2"),
        (replaced(r#""bufferView": 0"#, r#""bufferView": 0, "byteOffset": 9e18"#), "invalid"),
        (replaced("5123", "5126"), "accessors[2]: "),
        (replaced("5126", "5127"), "componentType"),
        (replaced("VEC3", "VEC2"), "accessors[0]: its elements are of type Vec2"),
        (nodes(r#"{"mesh": 0}"#).replace("\"2.0\"", "\"1.0\""), "octray reads glTF 2.0"),
        (
            nodes(r#"{"mesh": 0}"#).replace("\"byteLength\": 92", "\"byteLength\": 93"),
            "it has 92 bytes where the JSON says 93",
        ),
        (nodes(r#"{"mesh": 0}"#).replace("base64,", "base64,*"), "not base64"),
        ("{}".into(), "not a glTF 2.0 scene"),
        ("[[".into(), "not a glTF 2.0 scene"),
        (String::new(), "not a glTF 2.0 scene"),
    ];
    for (text, part) in cases {
        let message = refusal(&text);
        assert!(message.contains(part), "{part}: {message}\n{text}");
    }
    let elsewhere = |uri: &str| {
        let text = nodes(r#"{"mesh": 0}"#);
        let (start, rest) = text.split_once("data:").unwrap();
        refusal(&format!("{start}{uri}\"{}", rest.split_once('"').unwrap().1))
    };
    assert!(elsewhere("missing%20file.bin").contains("missing file.bin: cannot read it"));
    assert!(elsewhere("a%1bb.bin").contains("hold no control characters"));
    assert!(elsewhere("https://example.org/a.bin").contains("nothing from the network"));
    let required = nodes(r#"{"mesh": 0}"#).replacen(
        "\"scene\": 0,",
        r#""scene": 0, "extensionsRequired": ["KHR_draco_mesh_compression"],"#,
        1,
    );
    assert!(refusal(&required).contains("KHR_draco_mesh_compression"));
}

#[test]
fn a_file_renders() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.gltf");
    let metal = r#"{"pbrMetallicRoughness": {"roughnessFactor": 0.2}}"#;
    std::fs::write(&path, with_material(metal, "")).unwrap();
    let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
    let prepared = scene.prepare().unwrap();
    let settings = Settings { spp: 4, ..scene.settings() };
    let film = render(&prepared, &settings).film;
    // A square of white, nearly smooth metal in a white environment can hardly be told from it.
    let mean = film.mean_radiance();
    assert!(mean.iter().all(|c| (0.95..=1.0).contains(c)), "{mean:?}");
}
