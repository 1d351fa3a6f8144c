//! What a scene says, nothing derived: meshes, instances, materials, camera, lights, render defaults.

use crate::scene::camera::CameraPath;
use crate::scene::transform::Transform;
use crate::settings::{Guide, Lights, Roulette, Sampler, Train};
use crate::strategy::Strategy;

pub use crate::scene::camera::CameraDesc;

/// A scene as its files say it, before any table is built.
#[derive(Clone, Debug, Default)]
pub struct SceneDesc {
    /// The path it was loaded from, or `builtin:NAME`; used in messages and metadata.
    pub name: String,
    /// The camera of an image by itself.
    pub camera: CameraDesc,
    /// How it moves in a sequence of frames.
    pub camera_path: CameraPath,
    /// The cameras that have names, the scene's own among them if it has one.
    pub cameras: Vec<NamedCamera>,
    /// The environment is a white one that loading has put there, since nothing emits.
    pub default_light: bool,
    /// Film size in pixels (width, height).
    pub film: (u32, u32),
    /// How samples are spread about a pixel's centre.
    pub filter: PixelFilter,
    /// What the file's `[render]` table sets.
    pub render: RenderDesc,
    /// Meshes, indexed by [`InstanceDesc::mesh`].
    pub meshes: Vec<MeshDesc>,
    /// Where meshes stand. Triangle ids count instance after instance, each in the order of its mesh.
    pub instances: Vec<InstanceDesc>,
    /// Pictures, indexed by [`TextureUse::texture`].
    pub textures: Vec<TextureDesc>,
    /// Masks of cut-outs, indexed by the [`TextureUse::texture`] of [`MaterialDesc::alpha_mask`].
    pub masks: Vec<MaskDesc>,
    /// Materials, indexed by [`TriangleDesc::material`].
    pub materials: Vec<MaterialDesc>,
    /// Lights that are no surfaces; surfaces shine by [`MaterialDesc::emission`].
    pub lights: Vec<LightDesc>,
    /// What the user should know, one sentence each.
    pub warnings: Vec<String>,
}

impl SceneDesc {
    /// Adds a mesh and one instance of it.
    pub fn add_mesh(&mut self, mesh: MeshDesc, transform: Transform) {
        self.instances.push(InstanceDesc { mesh: self.meshes.len() as u32, transform });
        self.meshes.push(mesh);
    }

    /// Sees the scene by the camera called `name`.
    ///
    /// # Errors
    /// The names that there are.
    pub fn choose_camera(&mut self, name: &str) -> Result<(), Vec<String>> {
        let Some(chosen) = self.cameras.iter().find(|camera| camera.name == name) else {
            return Err(self.cameras.iter().map(|camera| camera.name.clone()).collect());
        };
        (self.camera, self.camera_path) = (chosen.camera, chosen.path.clone());
        Ok(())
    }

    /// Whether any triangle shines.
    ///
    /// # Panics
    /// Where an index names nothing, which [`validate::check`](crate::scene::validate::check) refuses.
    pub fn emits(&self) -> bool {
        let shines = |triangle: &TriangleDesc| self.materials[triangle.material as usize].emission != [0.0; 3];
        self.instances.iter().any(|instance| self.meshes[instance.mesh as usize].triangles.iter().any(shines))
    }

    /// What surrounds the scene, if anything does.
    pub fn environment(&self) -> Option<&EnvironmentDesc> {
        self.lights.iter().find_map(|light| match light {
            LightDesc::Environment(environment) => Some(environment),
            LightDesc::Delta(_) => None,
        })
    }

    /// The delta lights, in their order.
    pub fn delta_lights(&self) -> impl Iterator<Item = &DeltaLightDesc> {
        self.lights.iter().filter_map(|light| match light {
            LightDesc::Delta(light) => Some(light),
            LightDesc::Environment(_) => None,
        })
    }

    /// Puts `environment` in the place of every environment there is.
    pub fn set_environment(&mut self, environment: Option<EnvironmentDesc>) {
        self.lights.retain(|light| !matches!(light, LightDesc::Environment(_)));
        self.lights.extend(environment.map(LightDesc::Environment));
    }
}

/// A camera with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedCamera {
    /// The name.
    pub name: String,
    /// The camera of an image by itself.
    pub camera: CameraDesc,
    /// How it moves in a sequence of frames.
    pub path: CameraPath,
}

/// A triangle mesh in object space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshDesc {
    /// Vertex positions in object space, scene units before the instance's transform; all finite. Coordinates with more
    /// digits than f32 has (a country's grid) are best placed in f64 before they are rounded, as loading does
    /// ([`Similarity::place`](crate::scene::transform::Similarity::place)): no instance can bring back what is lost here.
    pub positions: Vec<[f32; 3]>,
    /// Triangles in file order after triangulation (n - 2 per polygon). Zero-area triangles keep their place here and
    /// are left out of the BVH.
    pub triangles: Vec<TriangleDesc>,
    /// What the triangles' corners carry besides positions: empty, or one entry a triangle.
    pub corners: Vec<CornerDesc>,
}

/// A mesh put into the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InstanceDesc {
    /// Index into [`SceneDesc::meshes`].
    pub mesh: u32,
    /// From the mesh's object space to world space.
    pub transform: Transform,
}

/// A light that is no surface.
#[derive(Clone, Debug, PartialEq)]
pub enum LightDesc {
    /// What surrounds the scene; a scene has at most one.
    Environment(EnvironmentDesc),
    /// A light that no ray can hit.
    Delta(DeltaLightDesc),
}

/// A light that shines from one point, or in one direction: what it sends to a point comes from one direction only, so no ray
/// ever hits it, and only light samples find it (pbrt-v4, section 12.1).
#[derive(Clone, Debug, PartialEq)]
pub struct DeltaLightDesc {
    /// Its name, for messages and for reports on single lights.
    pub name: String,
    /// How it shines.
    pub light: DeltaLight,
}

/// How a delta light shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DeltaLight {
    /// The same into every direction.
    Point {
        /// Where it is, scene units.
        position: [f64; 3],
        /// Radiant intensity, W sr^-1, linear Rec.709.
        intensity: [f64; 3],
    },
    /// Into a cone, whole near its axis and fading smoothly towards its edge (pbrt-v4, section 12.2.1).
    Spot {
        /// Where it is, scene units.
        position: [f64; 3],
        /// The cone's axis, away from the light; of any length but 0.
        direction: [f64; 3],
        /// Radiant intensity along the axis, W sr^-1, linear Rec.709.
        intensity: [f64; 3],
        /// Between the axis and the edge, where it has faded to nothing, degrees; above 0, at most 180.
        cone_angle: f64,
        /// How much of that it fades over, degrees; from 0, a sharp edge, to `cone_angle`.
        cone_delta_angle: f64,
    },
    /// In one direction everywhere, from infinitely far away.
    Directional {
        /// The way the light goes; of any length but 0.
        direction: [f64; 3],
        /// Irradiance of a surface that faces it, W m^-2, linear Rec.709.
        irradiance: [f64; 3],
    },
}

impl DeltaLight {
    /// Its kind, as scene files name it.
    pub fn kind(&self) -> &'static str {
        match self {
            DeltaLight::Point { .. } => "point",
            DeltaLight::Spot { .. } => "spot",
            DeltaLight::Directional { .. } => "directional",
        }
    }

    /// Its intensity (W sr^-1), of a directional light its irradiance (W m^-2).
    pub fn strength(&self) -> [f64; 3] {
        match *self {
            DeltaLight::Point { intensity, .. } | DeltaLight::Spot { intensity, .. } => intensity,
            DeltaLight::Directional { irradiance, .. } => irradiance,
        }
    }
}

/// One triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TriangleDesc {
    /// Indices into [`MeshDesc::positions`]; counter-clockwise seen from the front.
    pub vertices: [u32; 3],
    /// Index into [`SceneDesc::materials`].
    pub material: u32,
    /// The front is the clockwise side: the file's vertex normals oppose the winding, or a mirroring transform turned
    /// it (but not both). The order of [`TriangleDesc::vertices`] stays the file's, so hit coordinates do too.
    pub flipped: bool,
}

/// What the corners of a triangle carry besides their positions, in the order of [`TriangleDesc::vertices`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CornerDesc {
    /// Normals of the smooth surface, object space, towards the front; zero: this corner has none. Of any length where the
    /// instances' transforms make unit vectors of them; [`Transform::Identity`] takes them as they are, unit vectors.
    pub normals: [[f32; 3]; 3],
    /// Texture coordinates (u, v), v up; finite.
    pub uvs: [[f32; 2]; 3],
}

/// A picture: sRGB, 8 bits a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureDesc {
    /// Its file, for messages.
    pub name: String,
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Red, green and blue, row by row from the top.
    pub texels: Vec<[u8; 3]>,
}

/// Where a surface is and where not: opacities, linear, 8 bits.
#[derive(Clone, Debug, PartialEq)]
pub struct MaskDesc {
    /// Its file, for messages.
    pub name: String,
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Opacities, 255 whole, row by row from the top.
    pub texels: Vec<u8>,
}

/// A picture on a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureUse {
    /// Index into [`SceneDesc::textures`], or of a cut-out into [`SceneDesc::masks`].
    pub texture: u32,
    /// Factors on the texture coordinates, ..
    pub scale: [f64; 2],
    /// .. before these are added.
    pub offset: [f64; 2],
}

/// A material: how it scatters, what it emits.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialDesc {
    /// Its name in the MTL or TOML file.
    pub name: String,
    /// How it scatters (on both sides).
    pub scattering: Scattering,
    /// Emitted radiance on the front side, W sr^-1 m^-2, linear Rec.709.
    pub emission: [f64; 3],
    /// The back emits as the front does.
    pub two_sided: bool,
    /// Multiplies the albedo of diffuse and plastic, the base colour of principled.
    pub texture: Option<TextureUse>,
    /// Multiplies the emission.
    pub emission_texture: Option<TextureUse>,
    /// Where the surface is: points whose mask is below one half are not there.
    pub alpha_mask: Option<TextureUse>,
}

impl Default for MaterialDesc {
    /// Nameless, black, dark.
    fn default() -> Self {
        let scattering = Scattering::Diffuse { albedo: [0.0; 3] };
        MaterialDesc {
            name: String::new(),
            scattering,
            emission: [0.0; 3],
            two_sided: false,
            texture: None,
            emission_texture: None,
            alpha_mask: None,
        }
    }
}

/// How a surface scatters light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scattering {
    /// Lambertian; albedo in [0, 1] per channel.
    Diffuse {
        /// Reflected fraction.
        albedo: [f64; 3],
    },
    /// Perfect mirror; reflectance in [0, 1] per channel.
    Mirror {
        /// Reflected fraction.
        reflectance: [f64; 3],
    },
    /// Metal with a GGX distribution of microfacets.
    Conductor {
        /// GGX width, in [0, 1]; below 1e-4 it is a mirror.
        alpha: f64,
        /// Reflected fraction of every facet, in [0, 1]; not used where there is a complex index.
        reflectance: [f64; 3],
        /// Complex index of refraction (eta, k) per channel, for Fresnel's equations.
        complex_ior: Option<([f64; 3], [f64; 3])>,
    },
    /// Smooth glass.
    Dielectric {
        /// Index of refraction of what the back side faces, relative to the front; above 0.
        ior: f64,
        /// Fraction let through per refraction, in [0, 1] per channel.
        transmittance: [f64; 3],
    },
    /// Diffuse base under a GGX coat.
    Plastic {
        /// Albedo of the base, in [0, 1] per channel.
        albedo: [f64; 3],
        /// Index of refraction of the coat, at least 1.
        ior: f64,
        /// GGX width of the coat, in [0, 1].
        alpha: f64,
    },
    /// The metallic-roughness model of glTF 2.0 (appendix B of its specification), opaque: a plastic and a metal, mixed.
    ///
    /// The metal has a GGX distribution of microfacets of width `roughness` squared and Schlick's reflectance, `base_color` at
    /// normal incidence. What is not metal is [`Scattering::Plastic`] of albedo `base_color` and the same width. Appendix B
    /// leaves the formulas to the renderer; those here differ from its examples in three points. They reflect the coat by
    /// Fresnel's equations, which its example approximates. They let through to the base what the coat does not reflect on
    /// the way in and out, scaled so that no direction reflects more than arrives; the example's base takes no notice of
    /// how flat light arrives, and near grazing reflects, with its coat, up to almost twice what arrives. And facets are
    /// masked towards viewer and light by their height (Heitz 2014), as in all kinds here, not independently of each other.
    Principled {
        /// Albedo of the base and reflectance of the metal at normal incidence, in [0, 1] per channel.
        base_color: [f64; 3],
        /// How much of it is metal, in [0, 1].
        metallic: f64,
        /// Square root of the GGX width, in [0, 1].
        roughness: f64,
        /// Index of refraction of the coat, at least 1; at 1 there is none. The metal does not depend on it.
        ior: f64,
    },
}

/// What surrounds the scene.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentDesc {
    /// The same from every direction.
    Constant {
        /// W sr^-1 m^-2, linear Rec.709; at least one channel above 0.
        radiance: [f64; 3],
    },
    /// A picture of the surroundings.
    Map(MapDesc),
}

/// A latitude-longitude map: +y up, the centre column towards -z, columns rising towards +x.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapDesc {
    /// The file it was read from, for messages.
    pub file: String,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` values, linear Rec.709, row by row from the top; finite, none negative, not all 0.
    pub texels: Vec<[f32; 3]>,
    /// Degrees by which the surroundings are turned about +y, counter-clockwise seen from above.
    pub rotate: f64,
    /// Factor from texels to radiance, W sr^-1 m^-2; above 0.
    pub scale: f64,
}

/// The pixel filter, imposed by where samples are put (filter importance sampling, Ernst et al. 2006): every sample then
/// has weight 1 in its own pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PixelFilter {
    /// Uniform over the pixel.
    #[default]
    Box,
    /// A tent over two pixels' width.
    Tent,
}

/// What `[render]` of a scene file sets; `None` where it is silent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderDesc {
    /// Samples a pixel.
    pub spp: Option<u32>,
    /// Strategy.
    pub strategy: Option<Strategy>,
    /// Light selection.
    pub lights: Option<Lights>,
    /// Whether directions are guided.
    pub guide: Option<Guide>,
    /// What roulette goes by.
    pub roulette: Option<Roulette>,
    /// How long the training render is.
    pub train: Option<Train>,
    /// Sampler.
    pub sampler: Option<Sampler>,
    /// Largest number of scattering events.
    pub max_depth: Option<u32>,
    /// First roulette depth; `Some(None)`: `"off"`.
    pub rr_depth: Option<Option<u32>>,
    /// Seed.
    pub seed: Option<u32>,
}
