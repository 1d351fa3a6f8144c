//! The story of a path, step by step, in the words of Veach (1997) and of Physically Based Rendering.

use crate::cli::numbers::{percent, short};
use crate::cli::output::{table_in, wrapped};
use crate::cli::trace::Traced;
use crate::strategy::Weight;
use crate::trace::{
    COIN, END, LIGHT_SAMPLE, LIGHT_SAMPLE_BLOCKED, LIGHT_SAMPLE_IDLE, RAY, ROULETTE, ROULETTE_SURVIVED, TraceVertex,
    TracedLight,
};

/// Prose is hard to read in longer lines.
const MOST_COLUMNS: usize = 100;
/// How far what happens at a depth is moved right, and what explains it.
const INDENT: usize = 2;
const DEEPER: usize = 6;

/// A blank at which no line ends; in what is printed it is one like others.
const NO_BREAK: &str = "\u{a0}";

/// What the words of the story mean.
const LEGEND: [(&str, &str); 8] = [
    ("depth", "scattering events before a ray; 0 is the camera ray"),
    ("p_light", "density per steradian at which light sampling draws a direction, the choice of the light included"),
    ("p_bsdf", "density per steradian at which BSDF sampling draws it (`uniform`: as the uniform hemisphere does)"),
    ("delta", "a lobe with one direction (mirror, glass): it has no density, and no light sample can be in it"),
    ("weight", "of multiple importance sampling, by which the two ways to find a light add up to one"),
    ("throughput", "product of BSDF x cos / p along the path (and of 1 / survival): what emission met now counts"),
    ("gain", "what a step adds to the radiance"),
    ("(r g b)", "linear Rec.709, radiance in W sr^-1 m^-2; lengths and positions in scene units"),
];

/// All of it, in so many columns: the path, what it has gathered where, the legend.
pub(super) fn story(traced: &Traced, columns: usize) -> String {
    let prose = columns.min(MOST_COLUMNS);
    let mut text = heading(traced, prose);
    let mut told = Story { traced, prose, text: String::new(), throughput: [1.0; 3], by: "" };
    traced.vertices.iter().enumerate().for_each(|(index, vertex)| told.tell(vertex, &traced.vertices[index + 1..]));
    text += &told.text;
    text += &gathered(traced, columns);
    let legend: Vec<_> =
        LEGEND.iter().map(|(word, meaning)| vec![format!("  {word}"), (*meaning).to_owned()]).collect();
    text += &format!("\nlegend\n{}", table_in(&legend, columns));
    text.replace(NO_BREAK, " ")
}

fn heading(traced: &Traced, prose: usize) -> String {
    let settings = traced.settings;
    let ((x, y), (width, height)) = (traced.pixel, traced.film);
    let depth = settings.max_depth.map_or("unbounded".to_owned(), |depth| depth.to_string());
    let roulette = settings.rr_depth.map_or("off".to_owned(), |depth| format!("from depth {depth} on"));
    let biased = if settings.strategy.is_biased() { " (biased)" } else { "" };
    let first = format!(
        "{}, pixel {x},{y} of {width} x {height}, sample {}, seed {}",
        traced.scene.name, traced.sample, settings.seed
    );
    let second = format!(
        "{}{biased}, lights {}, {}, max depth {depth}, roulette {roulette}",
        settings.strategy, settings.lights, settings.sampler
    );
    let unit = match traced.radiance_unit {
        1.0 => String::new(),
        unit => format!("gains and radiances count in units of {unit:e}: this scene's are extreme\n"),
    };
    let prose = |text: &str| wrapped(text, prose - INDENT, INDENT);
    format!("{}\n{}\n{unit}\n", prose(&first), prose(&second))
}

/// What a story needs to remember.
struct Story<'a> {
    traced: &'a Traced<'a>,
    /// Columns.
    prose: usize,
    text: String,
    /// Before the step.
    throughput: [f64; 3],
    /// What the ray was drawn by.
    by: &'static str,
}

impl Story<'_> {
    fn line(&mut self, indent: usize, text: String) {
        let room = self.prose - indent - INDENT;
        self.text += &format!("{:indent$}{}\n", "", wrapped(&text, room, indent + INDENT));
    }

    /// Tells a step; `rest` is what follows.
    fn tell(&mut self, vertex: &TraceVertex, rest: &[TraceVertex]) {
        match vertex.event {
            RAY => self.ray(vertex),
            "hit" => {
                let at = format!("at t = {}, the point {}", short(vertex.t, 4), place(vertex.position));
                let kind = self.kind(rest);
                let hit = self.triangle(vertex.triangle, kind);
                self.line(INDENT, format!("It hits {hit} {at}."));
            }
            "miss" => {
                let dark = !rest.iter().any(|vertex| vertex.event == "environment");
                let nothing = if dark { ", where nothing shines: the path ends" } else { "" };
                self.line(INDENT, format!("It leaves the scene{nothing}."));
            }
            "emission" | "environment" => self.emission(vertex),
            COIN if vertex.note == "light" => {
                let why = "the light sample counts twice, and what the next ray finds does not count";
                self.line(INDENT, format!("A fair coin chooses light sampling: {why}."));
            }
            COIN => {
                let why = "no light sample is drawn, and what the next ray finds counts twice";
                self.line(INDENT, format!("A fair coin chooses BSDF sampling: {why}."));
            }
            LIGHT_SAMPLE_IDLE => {
                let light = self.light(vertex);
                self.line(INDENT, format!("Light sample: {light}. It brings nothing: {}.", vertex.note));
            }
            LIGHT_SAMPLE | LIGHT_SAMPLE_BLOCKED => self.light_sample(vertex),
            ROULETTE if vertex.probability == 0.0 => self.line(INDENT, "Roulette ends the path.".to_owned()),
            ROULETTE => {
                let chance = short(vertex.probability, 3);
                self.line(INDENT, format!("Roulette ends the path; it would have survived with probability {chance}."));
            }
            ROULETTE_SURVIVED if vertex.probability == 1.0 => {
                self.line(INDENT, "Roulette lets it go on for certain.".to_owned());
            }
            ROULETTE_SURVIVED => {
                let (chance, after) = (short(vertex.probability, 3), color(vertex.beta));
                let text = format!("Roulette: it survives with probability {chance}; throughput / {chance} = {after}.");
                self.line(INDENT, text);
            }
            END => self.line(INDENT, format!("The path ends: {}.", vertex.note)),
            _ => self.bounce(vertex),
        }
        self.throughput = vertex.beta;
    }

    fn ray(&mut self, vertex: &TraceVertex) {
        let (from, to) = (place(vertex.position), color(vertex.direction));
        let text = match vertex.depth {
            0 => format!("Depth 0: a camera ray from {from} in direction {to}."),
            depth => format!("Depth {depth}: a ray from {from} in direction {to}, throughput {}.", color(vertex.beta)),
        };
        self.line(0, text);
    }

    fn emission(&mut self, vertex: &TraceVertex) {
        let what = if vertex.event == "environment" { "The environment there shines" } else { "It shines" };
        let emitted = color(vertex.emitted);
        let hit = self.traced.settings.strategy.row().hit;
        let certain = if vertex.depth == 0 { "the camera sees it" } else { "met by a delta lobe" };
        let weight = weight(vertex.weight);
        match vertex.note {
            "certain" => self.line(
                INDENT,
                format!("{what} {emitted}: {certain}, where light sampling cannot work; weight {weight}."),
            ),
            "light chosen" => {
                self.line(INDENT, format!("{what} {emitted}: the coin had chosen the light sample; weight {weight}."));
            }
            _ => {
                self.line(INDENT, format!("{what} {emitted}, found by {}.", self.by));
                let densities = format!("p_bsdf = {}, p_light = {}", short(vertex.pdf, 3), short(vertex.pdf_other, 3));
                self.line(DEEPER, densities);
                self.line(DEEPER, formula(hit, "p_bsdf", "p_light", vertex.weight));
            }
        }
        let gain = format!("gain = throughput {} x {emitted} x weight = {}", color(vertex.beta), color(vertex.gain));
        self.line(DEEPER, format!("{gain}; radiance now {}", color(vertex.radiance)));
    }

    fn light_sample(&mut self, vertex: &TraceVertex) {
        let light = self.light(vertex);
        let emitted = color(vertex.emitted);
        self.line(INDENT, format!("Light sample: {light}, shining {emitted}."));
        if vertex.survival < 1.0 {
            let chance = short(vertex.survival, 3);
            self.line(
                DEEPER,
                format!("that is its radiance / {chance}, with which roulette has let its shadow ray be traced"),
            );
        }
        let p_light = short(vertex.pdf, 3);
        if let Some(TracedLight::Delta(_)) = vertex.light {
            let weight = short(vertex.weight, 3);
            self.line(
                DEEPER,
                format!("p_light = {p_light}, the choice alone; weight {weight}: no ray can hit a delta light"),
            );
        } else {
            let rule = self.traced.settings.strategy.row().light_sample;
            self.line(DEEPER, format!("p_light = {p_light}, p_bsdf = {}", short(vertex.pdf_other, 3)));
            self.line(DEEPER, formula(rule, "p_light", "p_bsdf", vertex.weight));
        }
        let factors = format!("{} x BSDF cos {} x {emitted}", color(vertex.beta), color(vertex.bsdf));
        self.line(DEEPER, format!("gain = throughput {factors} x weight / p_light = {}", color(vertex.gain)));
        let radiance = color(vertex.radiance);
        let seen = match vertex.event == LIGHT_SAMPLE_BLOCKED {
            true => format!("BLOCKED: something is in between, and the gain is lost; radiance still {radiance}"),
            false => format!("nothing is in between; radiance now {radiance}"),
        };
        self.line(DEEPER, seen);
    }

    fn bounce(&mut self, vertex: &TraceVertex) {
        let throughput = format!("throughput {} becomes {}", color(self.throughput), color(vertex.beta));
        let uniform = self.traced.settings.strategy.row().uniform_directions && vertex.pdf.is_finite();
        let (name, by) = match uniform {
            true => ("Uniform direction sample", "the uniform direction sample"),
            false => ("BSDF sample", "the BSDF sample"),
        };
        self.by = by;
        let density = match vertex.pdf.is_finite() {
            true => format!("p_bsdf = {}, BSDF cos / p_bsdf = {}", short(vertex.pdf, 3), color(vertex.bsdf)),
            false => format!("delta, factor {}", color(vertex.bsdf)),
        };
        self.line(INDENT, format!("{name} ({}): {density}; {throughput}.", vertex.event));
    }

    /// The kind of the surface that has just been hit, as far as the rest of the path at this depth says it.
    fn kind(&self, rest: &[TraceVertex]) -> &'static str {
        let here = rest.iter().take_while(|vertex| vertex.event != RAY);
        here.map(|vertex| vertex.event).find(|event| !KNOWN.contains(event)).unwrap_or_default()
    }

    /// `triangle 7 (short_box: diffuse)`.
    fn triangle(&self, id: u32, kind: &str) -> String {
        let words: Vec<&str> = [self.traced.material(id).unwrap_or_default(), kind].into_iter().collect();
        match &words[..] {
            ["", ""] => format!("triangle {id}"),
            [name, ""] | ["", name] => format!("triangle {id} ({name})"),
            [name, kind, ..] => format!("triangle {id} ({name}: {kind})"),
            _ => format!("triangle {id}"),
        }
    }

    /// The light of a light sample, how likely it was chosen and how far it is.
    fn light(&self, vertex: &TraceVertex) -> String {
        let chance = format!("chosen with probability {}", short(vertex.probability, 3));
        let distance = vertex.direction.iter().map(|c| c * c).sum::<f64>().sqrt();
        let light = match vertex.light {
            Some(TracedLight::Triangle(id)) => self.triangle(id, ""),
            Some(TracedLight::Delta(number)) => {
                format!("delta light {number} ({})", self.traced.delta_kinds[number as usize])
            }
            Some(TracedLight::Environment) | None => return format!("the environment, {chance}"),
        };
        match distance > 0.0 {
            true => format!("{light}, {chance}, {} away", short(distance, 3)),
            false => format!("{light}, {chance}"),
        }
    }
}

/// The events that are no bounce.
const KNOWN: [&str; 12] = [
    RAY,
    "hit",
    "miss",
    "emission",
    "environment",
    COIN,
    LIGHT_SAMPLE,
    LIGHT_SAMPLE_BLOCKED,
    LIGHT_SAMPLE_IDLE,
    ROULETTE,
    ROULETTE_SURVIVED,
    END,
];

/// Where the radiance came from: the answer to why the sample is what it is.
fn gathered(traced: &Traced, columns: usize) -> String {
    let total: f64 = traced.radiance().iter().map(|c| f64::from(*c)).sum();
    let mut rows = Vec::new();
    let mut lost = 0;
    for vertex in &traced.vertices {
        let how = match vertex.event {
            LIGHT_SAMPLE => "light sample",
            "emission" | "environment" if vertex.note == "certain" && vertex.depth == 0 => "seen by the camera",
            "emission" | "environment" if vertex.note == "certain" => "met after a delta lobe",
            "emission" | "environment" => "found by the BSDF sample",
            LIGHT_SAMPLE_BLOCKED => {
                lost += 1;
                continue;
            }
            _ => continue,
        };
        let sum: f64 = vertex.gain.iter().sum();
        if sum > 0.0 {
            let share = if total > 0.0 { percent(sum / total) } else { String::new() };
            rows.push(vec![format!("  depth {}", vertex.depth), how.to_owned(), color(vertex.gain), share]);
        }
    }
    let blocked = match lost {
        0 => String::new(),
        1 => " (1 light sample was blocked)".to_owned(),
        n => format!(" ({n} light samples were blocked)"),
    };
    let sum = color(traced.radiance().map(f64::from));
    let verdict = match rows.is_empty() {
        true => format!("So the sample is black: the path has met no light{blocked}."),
        false => format!("So the sample has the radiance {sum}{blocked}:"),
    };
    format!("\n{}\n{}", wrapped(&verdict, columns - INDENT, INDENT), table_in(&rows, columns))
}

/// A weight; one that is almost 1 is told from 1.
fn weight(weight: f64) -> String {
    match short(weight, 3) {
        text if text == "1" && weight < 1.0 => format!("1 - {}", short(1.0 - weight, 2)),
        text => text,
    }
}

/// A weight, and the rule it comes from.
fn formula(rule: Weight, own: &str, other: &str, of_sample: f64) -> String {
    let weight = weight(of_sample);
    match rule {
        Weight::Zero | Weight::One | Weight::Half => format!("weight = {weight} by the strategy"),
        Weight::Balance => format!("weight = {own} / ({own} + {other}) = {weight}"),
        Weight::TwiceBalance => format!("weight = 2 {own} / ({own} + {other}) = {weight}"),
        Weight::Power => format!("weight = {own}^2 / ({own}^2 + {other}^2) = {weight}"),
    }
}

/// A colour or direction.
fn color(value: [f64; 3]) -> String {
    format!("({})", value.map(|c| short(c, 3)).join(NO_BREAK))
}

/// A place.
fn place(value: [f64; 3]) -> String {
    format!("({})", value.map(|c| short(c, 4)).join(NO_BREAK))
}

#[cfg(test)]
#[path = "story_tests.rs"]
mod tests;
