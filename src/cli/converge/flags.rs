//! The flags of `octray converge`.

use crate::cli::args::{self, List, RrDepth};
use crate::cli::view::ViewArgs;
use crate::settings::{Crop, Engine, Guide, Lights, Sampler, Settings, Shard, Train};
use crate::strategy::Strategy;
use std::path::PathBuf;
use std::time::Duration;

/// Flags of `octray converge`.
#[derive(clap::Args)]
pub struct ConvergeArgs {
    /// Scene files (.toml), bare .obj, .gltf or .glb files, or builtin:NAME; several make one report
    #[arg(value_name = "SCENE", required = true)]
    pub scenes: Vec<PathBuf>,
    #[command(flatten)]
    pub view: ViewArgs,
    /// Directory for report.html, converge.csv, converge.json, plots, images and the reference; made if need be
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    #[arg(long, value_name = "S,..", default_value = "all", hide_default_value = true,
          help = args::list_help("Strategies", Strategy::ALL, "all"),
          value_parser = |text: &str| args::list(text, Strategy::ALL))]
    pub strategies: List<Strategy>,
    /// Samples a pixel of the runs
    #[arg(long, value_name = "N,..", value_delimiter = ',', default_value = "1,4,16,64,256", conflicts_with = "times",
          value_parser = args::positive, allow_negative_numbers = true)]
    pub spps: Vec<u32>,
    /// Wall time of the runs, instead of --spps (10, 10s, 2m); ended on whole passes
    #[arg(long, value_name = "TIME,..", value_delimiter = ',', value_parser = args::seconds, allow_negative_numbers = true)]
    pub times: Vec<Duration>,
    /// Independent runs of each; intervals need at least two
    #[arg(long, value_name = "R", default_value = "5", value_parser = clap::value_parser!(u32).range(1..=10_000),
          allow_negative_numbers = true)]
    pub repeats: u32,
    /// Run exact strategies with more and more samples until their error (root of relMSE) is down to E (0.05 or 5%)
    #[arg(long, value_name = "E", value_parser = args::relative_error, allow_hyphen_values = true)]
    pub reach: Option<f64>,
    /// Another renderer's images beside ours: a CSV file with the columns name, seconds (CPU seconds of all threads, of rendering
    /// alone), image, and scene and spp where known; may be given several times
    #[arg(long, value_name = "FILE.csv")]
    pub against: Vec<PathBuf>,
    /// Judge by this image instead of a closed form or a long render; noise in its variance layers is subtracted. Once for
    /// every scene, in their order
    #[arg(long, value_name = "FILE", conflicts_with = "reference_spp")]
    pub reference: Vec<PathBuf>,
    /// Samples a pixel of the rendered reference [default: 16 times the largest of --spps; with --times: 16 times the longest]
    #[arg(long, value_name = "N", value_parser = args::positive, allow_negative_numbers = true)]
    pub reference_spp: Option<u32>,
    #[arg(long, value_name = "L,..",
          help = args::list_help("Light selections", Lights::ALL, &scene_else(Settings::plain().lights)),
          value_parser = |text: &str| args::list(text, Lights::ALL))]
    pub lights: Option<List<Lights>>,
    #[arg(long, value_name = "G,..",
          help = args::list_help("Whether directions at diffuse surfaces are guided", Guide::ALL, Guide::Off.name()),
          value_parser = |text: &str| args::list(text, Guide::ALL))]
    pub guide: Option<List<Guide>>,
    #[arg(long, value_name = "PATHS|auto|off", help = args::train_help(),
          value_parser = |text: &str| text.parse::<Train>(), allow_negative_numbers = true)]
    pub train: Option<Train>,
    #[arg(long, value_name = "S,..",
          help = args::list_help("Samplers", Sampler::ALL, &scene_else(Settings::default().sampler)),
          value_parser = |text: &str| args::list(text, Sampler::ALL))]
    pub sampler: Option<List<Sampler>>,
    #[arg(long, value_name = "E,..",
          help = args::list_help("Engines", Engine::ALL, Settings::default().engine.name()),
          value_parser = |text: &str| args::list(text, Engine::ALL))]
    pub engine: Option<List<Engine>>,
    /// Keep the light of this material only (`environment`: of the surroundings); given several times, each is measured by
    /// itself; `all` is the whole scene, `each` every light of the scene in turn after it
    #[arg(long, value_name = "MATERIAL")]
    pub only_light: Vec<String>,
    /// Also tell the error in this part of the film; may be given several times
    #[arg(long, value_name = "[NAME=]X,Y,W,H", value_parser = args::region, allow_hyphen_values = true)]
    pub region: Vec<(String, Crop)>,
    /// Film width in pixels
    #[arg(long, value_name = "W", default_value = "256", value_parser = args::side, allow_negative_numbers = true)]
    pub width: u32,
    /// Film height in pixels
    #[arg(long, value_name = "H", default_value = "256", value_parser = args::side, allow_negative_numbers = true)]
    pub height: u32,
    #[arg(long, value_name = "N", help = args::max_depth_help(), allow_negative_numbers = true)]
    pub max_depth: Option<u32>,
    #[arg(long, value_name = "D|off", help = args::rr_depth_help(),
          value_parser = args::rr_depth, allow_negative_numbers = true)]
    pub rr_depth: Option<RrDepth>,
    /// Worker threads [default: one for every core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096), allow_negative_numbers = true)]
    pub threads: Option<u16>,
    /// Stops of exposure at which images are shown, and compared as they are seen (PSNR, FLIP)
    #[arg(long, value_name = "EV", default_value = "0", value_parser = args::exposure, allow_negative_numbers = true)]
    pub exposure: f64,
    /// First of the runs' seeds
    #[arg(long, value_name = "N", default_value = "0", allow_negative_numbers = true)]
    pub seed: u32,
    /// Make part K of N of the runs, every N-th, and write it to DIR/converge.part, for --merge; parts may be made anywhere, with
    /// the same other flags
    #[arg(long, value_name = "K/N", allow_hyphen_values = true)]
    pub shard: Option<Shard>,
    /// Report of these parts, all of one call's, instead of making runs; may be given several times
    #[arg(long, value_name = "PART", num_args = 1.., conflicts_with = "shard")]
    pub merge: Vec<PathBuf>,
    /// Keep what has been measured so often, at least: after whatever ended it, the same command goes on from there
    #[arg(long, value_name = "TIME", default_value = "30s", value_parser = args::seconds, allow_negative_numbers = true)]
    pub every: Duration,
    /// No progress bar and no table; warnings stay
    #[arg(long)]
    pub quiet: bool,
}

fn scene_else(default: impl std::fmt::Display) -> String {
    format!("the scene's, else {default}")
}
