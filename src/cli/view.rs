//! How a scene is seen and lit from outside: flags that several commands share.

use crate::cli::args;
use crate::error::{Error, Result};
use crate::import::assembly::NO_LIGHT;
use crate::import::framing::NO_CAMERA;
use crate::scene::SceneDesc;
use crate::scene::camera::CameraPath;
use crate::scene::desc::CameraDesc;
use crate::scene::studio::add_studio;
use crate::scene::transform::distance;
use crate::scene::validate::camera_fault;

/// Flags of the camera, and of light for what has none.
#[derive(clap::Args, Default)]
pub struct ViewArgs {
    /// See the scene by its camera of this name
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// Put the camera here; it stands still then
    #[arg(long, value_name = "X,Y,Z", value_parser = args::place, allow_hyphen_values = true)]
    look_from: Option<[f64; 3]>,
    /// Turn the camera to this point, which a lens then has in focus
    #[arg(long, value_name = "X,Y,Z", value_parser = args::place, allow_hyphen_values = true)]
    look_at: Option<[f64; 3]>,
    /// Which way is up in the image [default: the scene's, else 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = args::place, allow_hyphen_values = true)]
    up: Option<[f64; 3]>,
    /// Full vertical field of view in degrees [default: the scene's, else 35]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    fov: Option<f64>,
    /// Put a scene without light onto a ground and below a soft key light
    #[arg(long)]
    studio: bool,
}

impl ViewArgs {
    /// Whether the camera is placed from outside, so that it stands still.
    pub fn places_camera(&self) -> bool {
        self.look_from.is_some() || self.look_at.is_some() || self.up.is_some() || self.fov.is_some()
    }

    /// Puts the flags over `scene`.
    ///
    /// # Errors
    /// [`Error::Usage`]: no such camera, a camera that cannot look, `--studio` for a scene that has light.
    pub fn apply(&self, scene: &mut SceneDesc) -> Result<()> {
        if let Some(name) = &self.camera
            && let Err(known) = scene.choose_camera(name)
        {
            let known = match known.len() {
                0 => "it names none: write [[camera]] with `name`".to_owned(),
                _ => format!("it has {}", known.join(", ")),
            };
            let message = format!("--camera {name}: {} has no camera of that name; {known}", scene.name);
            return Err(Error::Usage(message));
        }
        if self.places_camera() {
            scene.camera = self.placed(scene.camera)?;
            scene.camera_path = CameraPath::default();
            if self.look_from.is_some() {
                scene.warnings.retain(|warning| !warning.starts_with(NO_CAMERA));
            }
        }
        if self.studio {
            let is_lit = scene.emits() || !scene.lights.is_empty();
            if is_lit && !scene.default_light {
                return Err(Error::Usage(format!("--studio: {} has light of its own: leave the flag out", scene.name)));
            }
            scene.warnings.retain(|warning| !warning.starts_with(NO_LIGHT));
            add_studio(scene);
            scene.default_light = false;
        }
        Ok(())
    }

    /// `camera` with the flags put over it.
    fn placed(&self, camera: CameraDesc) -> Result<CameraDesc> {
        let mut placed = camera;
        placed.vertical_fov = self.fov.unwrap_or(camera.vertical_fov);
        if self.look_from.is_some() || self.look_at.is_some() || self.up.is_some() {
            // A camera that a matrix places looks along its own -z.
            let (eye, ahead, up) = match camera.to_world {
                None => (camera.position, camera.look_at, camera.up),
                Some(rows) => {
                    let eye = camera.eye();
                    (eye, std::array::from_fn(|i| eye[i] - rows[i][2]), rows.map(|row| row[1]))
                }
            };
            placed.to_world = None;
            placed.position = self.look_from.unwrap_or(eye);
            placed.look_at = self.look_at.unwrap_or(ahead);
            placed.up = self.up.unwrap_or(up);
            let far = distance(placed.position, placed.look_at);
            placed.focus_distance = if far > 0.0 { far } else { camera.focus_distance };
        }
        match camera_fault(&placed) {
            Some(fault) => Err(Error::Usage(format!("--look-from, --look-at, --up, --fov: {fault}"))),
            None => Ok(placed),
        }
    }
}
