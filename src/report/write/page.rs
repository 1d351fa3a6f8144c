//! `report.html`: the findings for people. One file, no script, nothing fetched; dark and light; fits a phone.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::report::analysis::equal_time::Shown;
use crate::report::analysis::summary::of_case;
use crate::report::measure::experiment::Budget;
use crate::report::measure::truth::{Reference, Source};
use crate::report::write::contents::{Contents, State};
use crate::report::write::figures::{Figure, figures, names, small_error_plot, small_region_plot};
use crate::report::write::heatmap::{self, Canvas, Scale, scale_legend};
use crate::report::write::images::{self, data_uri, hardest_region, zoomable};
use crate::report::write::numbers::{count, minus, percent, seconds, target};
use crate::report::write::plot::{self, Layout, Plot};
use crate::report::write::tables;
use crate::report::write::words::{Words, tag};
use crate::settings::Crop;

const STYLE: &str = "*{box-sizing:border-box}html{-webkit-text-size-adjust:100%}\
body{margin:0;background:var(--paper);color:var(--ink);font:17px/1.55 Georgia,'Iowan Old Style','Times New Roman',serif}\
main{max-width:66rem;margin:0 auto;padding:2.2rem 1.1rem 4rem}p,ul,ol{max-width:44rem}\
h1,h2,h3,th,td,figcaption,.facts,.scale{font-family:system-ui,-apple-system,'Segoe UI',Roboto,sans-serif}\
h1{font-size:1.9rem;line-height:1.2;margin:0 0 .3rem}h2{font-size:1.35rem;margin:2.8rem 0 .6rem;padding-top:.8rem;border-top:1px solid var(--rule)}\
h3{font-size:1.05rem;margin:1.8rem 0 .4rem}.facts{color:var(--soft);font-size:.9rem;margin:.2rem 0 1.4rem}\
.scroll{overflow-x:auto;margin:.6rem 0 1.2rem}table{border-collapse:separate;border-spacing:0;font-size:.86rem;font-variant-numeric:tabular-nums}\
th,td{padding:.32rem .6rem;text-align:right;white-space:nowrap;border-bottom:1px solid var(--rule)}\
th{color:var(--soft);font-weight:600;vertical-align:bottom}th:first-child,td:first-child{text-align:left;position:sticky;left:0;background:var(--paper)}\
td.best{font-weight:700}td.guess{color:var(--soft);font-style:italic}tr.biased td{color:var(--soft)}\
code,pre{font:.86em ui-monospace,SFMono-Regular,Menlo,Consolas,monospace}pre{overflow-x:auto;padding:.7rem .9rem;border:1px solid var(--rule);border-radius:6px}\
figure{margin:1rem 0}figcaption{font-size:.86rem;color:var(--soft);max-width:44rem}\
.narrow{display:none}@media (max-width:40rem){.narrow{display:block}.wide{display:none}table{font-size:.78rem}th,td{padding:.3rem .34rem}}\
.pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(15.5rem,1fr));gap:1.1rem}\
.pictures figure{margin:0}.pictures .pair{display:grid;grid-template-columns:1fr 1fr;gap:2px}\
.crops{display:grid;grid-template-columns:repeat(auto-fill,minmax(8.5rem,1fr));gap:.8rem}.crops figure{margin:0}\
.multiples{display:grid;grid-template-columns:repeat(auto-fill,minmax(17rem,1fr));gap:1rem;margin:.6rem 0}\
small{color:var(--soft);font-size:.92em}.short li{margin:.35rem 0}dt{font-weight:700;margin-top:.7rem}dd{margin:0;max-width:44rem}\
dt,.name{font-family:ui-monospace,SFMono-Regular,Menlo,Consolas,monospace;font-size:.92em}\
.tag{font:600 .72rem system-ui,sans-serif;border:1px solid currentColor;border-radius:4px;padding:.05rem .35rem;margin-left:.4rem;vertical-align:.1em}";

/// The page as text.
pub fn html(contents: &Contents) -> String {
    Page(*contents).html()
}

struct Page<'a>(Contents<'a>);

impl Page<'_> {
    fn html(&self) -> String {
        let name = self.scenes();
        let root = format!(":root{{color-scheme:light dark;{}}}", plot::LIGHT);
        let dark = format!("@media (prefers-color-scheme:dark){{:root{{{}}}}}", plot::DARK);
        let markup = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { "Error against run time: " (name) }
                    style { (PreEscaped([&root, &dark, STYLE, plot::STYLE, heatmap::STYLE, images::STYLE].concat())) }
                }
                body {
                    main {
                        h1 { "Error against run time: " (name) }
                        (self.facts())
                        (self.overview())
                        @for index in 0..self.0.experiment.cases.len() { (self.case(index)) }
                        (self.method())
                    }
                }
            }
        };
        markup.into_string()
    }

    fn facts(&self) -> Markup {
        let (width, height) = self.0.experiment.film();
        let runs = self.0.measured.runs.len();
        let threads = match self.0.experiment.settings.threads {
            0 => self.0.machine.cores,
            n => n,
        };
        html! {
            p class="facts" {
                (width) " × " (height) " pixels, " (runs) " runs, " (self.0.machine.cpu) ", " (threads)
                (if threads == 1 { " thread" } else { " threads" }) ", " (crate::simd::simd_level())
                ", octray " (env!("CARGO_PKG_VERSION"))
            }
            @match self.0.state {
                State::Finished => {}
                State::Running => {
                    p {
                        strong { "Still running: " (self.0.so_far()) "." }
                        " What follows is about these; this page is written anew now and then."
                    }
                }
                State::Stopped => p { strong { "Stopped after " (self.0.so_far()) "." } " What follows is about these." }
            }
        }
    }

    /// The scenes' names.
    fn scenes(&self) -> String {
        let mut names: Vec<&str> = self.0.experiment.cases.iter().map(|case| case.scene_name.as_str()).collect();
        names.dedup();
        names.join(", ")
    }

    /// Where there are several cases: who is best in which, and over all.
    fn overview(&self) -> Markup {
        if self.0.experiment.cases.len() == 1 {
            return html! {};
        }
        let small = |case: usize| {
            let words = self.words(case);
            html! { @if !words.findings.is_empty() { (small_error_plot(&words, &self.0.experiment.case_title(case)).svg(Layout::SMALL)) } }
        };
        html! {
            (tables::overview(&self.words(0), self.0.summaries, self.0.findings))
            div class="multiples" { @for case in 0..self.0.experiment.cases.len() { (small(case)) } }
            (legend(&self.all_configurations()))
        }
    }

    /// A finding of every configuration that has one in any case.
    fn all_configurations(&self) -> Words<'_> {
        let experiment = self.0.experiment;
        let first = |own: usize| self.0.findings.iter().find(|finding| finding.configuration == own);
        Words { experiment, findings: (0..experiment.entries()).filter_map(first).collect() }
    }

    fn words(&self, case: usize) -> Words<'_> {
        let findings = of_case(self.0.findings, case).collect();
        Words { experiment: self.0.experiment, findings }
    }

    fn case(&self, index: usize) -> Markup {
        let words = self.words(index);
        if words.findings.is_empty() {
            return html! {};
        }
        let title = self.0.experiment.case_title(index);
        html! {
            @if !title.is_empty() { h2 { (title) } }
            ul class="short" { @for sentence in words.in_short() { li { (sentence) } } }
            @for Figure { plot, name } in figures(&words, &title) {
                figure { (plotted(&plot)) figcaption { (caption(name, &plot)) } }
            }
            h3 { "How they compare" }
            (tables::comparison(&words))
            h3 { "One by one" }
            dl {
                @for finding in &words.findings {
                    dt {
                        (words.label(finding))
                        @if let Some(tag) = tag(finding) { span class="tag" { (tag) } }
                    }
                    dd { (words.sentence(finding)) }
                }
            }
            h3 { "CPU time to an error" }
            (tables::prices(&words))
            (tables::samples(&words))
            (tables::distribution(&words))
            (self.regions(&words))
            (self.pictures(index, &words))
        }
    }

    fn regions(&self, words: &Words) -> Markup {
        let regions = self.0.experiment.regions.len();
        if regions == 0 {
            return html! {};
        }
        html! {
            h3 { "By region" }
            p { "Relative error in parts of the film at the largest budget; the least of each in bold." }
            (tables::regions(words))
            div class="multiples" { @for region in 0..regions { (small_region_plot(words, region).svg(Layout::SMALL)) } }
            (legend(words))
        }
    }

    fn pictures(&self, case: usize, words: &Words) -> Markup {
        let shown: Vec<&Shown> = self.0.shown.iter().filter(|shown| shown.case == case).collect();
        if shown.is_empty() {
            return html! {};
        }
        let exposure = self.0.experiment.exposure;
        let reference = &self.0.references[case].image;
        let (width, height) = (reference.width, reference.height);
        let own = shown.iter().filter(|shown| self.0.experiment.strategy(shown.configuration).is_some());
        let times: Vec<f64> = own.map(|shown| shown.cpu_seconds).collect();
        let time = times.iter().sum::<f64>() / times.len().max(1) as f64;
        let scale = heat_scale(&shown);
        let encoded = |rgb: &[u8]| images::picture(rgb, width, height, images::MOST_BYTES);
        let image = |(kind, bytes): &(&str, Vec<u8>), what: &str| {
            zoomable(&data_uri(kind, bytes), width, height, what, width.max(height) < SMALL_IMAGE)
        };
        let tagged = |shown: &Shown| {
            let found = words.findings.iter().find(|finding| finding.configuration == shown.configuration);
            let label = self.0.experiment.label(shown.configuration);
            html! {
                span class="name" { (label) }
                @if let Some(tag) = found.and_then(|finding| tag(finding)) { span class="tag" { (tag) } }
            }
        };
        let errors: Vec<&[f64]> = shown.iter().map(|shown| &shown.errors[..]).collect();
        let window = hardest_region(&errors, width, height);
        let bytes: Vec<Vec<u8>> = shown.iter().map(|shown| shown.image.srgb8(exposure)).collect();
        let truth = reference.srgb8(exposure);
        let pictures: Vec<_> = bytes.iter().map(|rgb| encoded(rgb)).collect();
        let of_truth = encoded(&truth);
        let lossy = pictures.iter().chain([&of_truth]).any(|(kind, _)| *kind == "jpeg");
        html! {
            h3 { "The same time, " (count(shown.len() as u64, "image")) }
            p {
                "What each makes of about " (seconds(time)) " of CPU time, and beside it the relative error of every pixel. \
                 Exposure " (minus(exposure.to_string())) " EV, sRGB. A click enlarges an image."
                @if lossy { " (Some are JPEG here; without loss they lie beside this page as PNG.)" }
            }
            (scale_legend(scale))
            div class="pictures" {
                figure {
                    (image(&of_truth, "the reference"))
                    figcaption { "the reference" }
                }
                @for (shown, picture) in shown.iter().zip(&pictures) {
                    @let label = self.0.experiment.label(shown.configuration);
                    figure {
                        div class="pair" {
                            (image(picture, &label))
                            (zoomable(
                                &data_uri("png", &Canvas::plain(&shown.errors, width, scale).png()),
                                width,
                                height,
                                &format!("relative error of {label}"),
                                true,
                            ))
                        }
                        figcaption {
                            (tagged(shown)) " error " (percent(shown.relmse.max(0.0).sqrt())) " in " (seconds(shown.cpu_seconds))
                        }
                    }
                }
            }
            (tables::equal_time(words, &shown))
            p class="facts" {
                "PSNR and FLIP are of what is seen: PSNR of sRGB values from 0 to 1 at this exposure; FLIP (Andersson et al. 2021, \
                 HDR) is 0 where no difference is noticed and 1 where black stands for white."
            }
            h3 { "Where it is hardest" }
            p {
                "The " (window.width) " × " (window.height) " pixels at " (window.x) "," (window.y) " in which the error of all \
                 together is largest, without loss."
            }
            div class="crops" {
                (crop(&truth, width, window, "the reference", &html! { "the reference" }))
                @for (shown, rgb) in shown.iter().zip(&bytes) {
                    (crop(rgb, width, window, &self.0.experiment.label(shown.configuration), &tagged(shown)))
                }
            }
        }
    }

    /// How often the budgets were run: "6 times", "2 or 3 times".
    fn repeats(&self) -> String {
        let asked = self.0.experiment.budgets.len();
        let own = self.0.findings.iter().filter(|finding| self.0.experiment.strategy(finding.configuration).is_some());
        let runs = || own.clone().flat_map(|finding| finding.points.iter().take(asked)).map(|point| point.runs as u64);
        match (runs().min(), runs().max()) {
            (Some(least), Some(most)) if least < most => format!("{least} to {}", count(most, "time")),
            (_, most) => count(most.unwrap_or(0), "time"),
        }
    }

    fn method(&self) -> Markup {
        let experiment = self.0.experiment;
        let budgets = budgets_text(&experiment.budgets);
        html! {
            h2 { "How this was measured" }
            p {
                "relMSE is the mean over pixels and channels of (a − b)² / (b² + 0.01), b being the reference; the error stated \
                 everywhere is its root. The noise of the reference is subtracted. Efficiency is 1 / (relMSE × CPU seconds) at the \
                 largest budget. CPU seconds are those of all threads, of rendering alone."
            }
            p {
                "Each budget (" (budgets) ") was run " (self.repeats()) " with independent seeds, \
                 runs interleaved so that a slow moment of the machine hits all alike: many short renders, whose spread is shown \
                 (Celarek et al. 2019). Intervals are 95 %, of Student's t, from the spread of the runs in each of up to 1,024 tiles \
                 (Welch and Satterthwaite); those of the slopes hold for all configurations at once. Where a few pixels hold most of \
                 the error no interval holds: none is given, and slopes and prices do without that budget. What costs lie between \
                 budgets is read off a curve through them; beyond them it goes on from the last along the slope of the last three, and \
                 the interval includes that slope's. A ratio of times to the same error is that of the error named with it. The \
                 bias is that of all runs of a configuration together; z is its distance from 0 in standard errors, the \
                 reference's included. The level of a biased strategy comes from products of independent parts of its runs."
                @if let Some(error) = experiment.reach {
                    " Exact strategies were run on with more samples until their error was down to " (target(error)) ", or did not fall as \
                     more samples ought to make it."
                }
                @if !experiment.others.is_empty() {
                    " Of other renderers (" (experiment.others.join(", ")) ") the seconds are those of the given file, which should be CPU \
                     seconds of all threads, of rendering alone; their images are judged by the same reference."
                }
            }
            @for (case, reference) in self.0.references.iter().enumerate() {
                (reference_text(&experiment.case_title(case), reference, experiment.cases[case].max_depth))
            }
            p { "To repeat it:" }
            pre { (self.0.command) }
            p {
                "The runs are in " code { "converge.csv" } ", everything else in " code { "converge.json" } ", the plots and \
                 images beside them."
            }
        }
    }
}

/// An image below this many columns and rows keeps hard pixels where it is enlarged to its column.
const SMALL_IMAGE: u32 = 200;

/// A part of an image with its name below.
fn crop(rgb: &[u8], width: u32, window: Crop, what: &str, name: &Markup) -> Markup {
    let png = images::crop(rgb, width, window, 1);
    let what = format!("the hardest part by {what}");
    html! {
        figure {
            (zoomable(&data_uri("png", &png), window.width, window.height, &what, true))
            figcaption { (name) }
        }
    }
}

/// The names of all configurations beside their lines and markers.
fn legend(words: &Words) -> Markup {
    let names = names(words);
    let names: Vec<(&str, usize)> = names.iter().map(|(name, style)| (name.as_str(), *style)).collect();
    plot::legend(&names)
}

/// What stands below a figure.
fn caption(name: &str, plot: &Plot) -> Markup {
    let outside = plot.outside().join(", ");
    match name {
        "error-against-seconds" => html! {
            "Relative error (root of relMSE) against CPU seconds of all threads together. Bars and bands are 95 % intervals; \
             lines join the budgets, and go on dotted along the slope of the last three. Dotted levels, with their intervals, are \
             where biased images stop."
        },
        "efficiency-against-seconds" => html! {
            "Efficiency, 1 / (relMSE × CPU seconds), near the best, with 95 % intervals: the higher, the less time for the same \
             error. A level line is the law of random sampling; a rising one falls faster with every sample."
            @if !outside.is_empty() { " Below: " (outside) "." }
        },
        "error-against-samples" => html! {
            "Relative error against samples a pixel: what a sample is worth, whatever it costs. The number behind a name is the slope \
             of its error: −0.5 is the law of random sampling, four times the samples for half the error."
        },
        _ => html! {
            "The power spectrum of the error at the largest budget, mean over runs, radially averaged (Celarek et al. 2019). Level: \
             white noise, every pixel by itself; higher on the left: blotches that filters and eyes do not average away."
        },
    }
}

/// A plot for a desk and for a phone; the width of the page decides which is seen.
fn plotted(plot: &Plot) -> Markup {
    html! {
        div class="wide" { (plot.svg(Layout::WIDE)) }
        div class="narrow" { (plot.svg(Layout::NARROW)) }
    }
}

/// The colours of the heatmaps of a case.
pub fn heat_scale(shown: &[&Shown]) -> Scale {
    let all: Vec<f64> = shown.iter().flat_map(|shown| shown.errors.iter().copied()).collect();
    Scale::fitting(&all)
}

/// "1, 4 and 16 samples a pixel".
fn budgets_text(budgets: &[Budget]) -> String {
    let text = |budget: &Budget| match budget {
        Budget::Spp(spp) => spp.to_string(),
        Budget::Time(time) => seconds(time.as_secs_f64()),
    };
    let texts: Vec<String> = budgets.iter().map(text).collect();
    let list = match texts.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => texts.concat(),
    };
    match budgets {
        [Budget::Spp(1)] => "1 sample a pixel".to_owned(),
        [Budget::Spp(_), ..] => format!("{list} samples a pixel"),
        _ => list,
    }
}

fn reference_text(title: &str, reference: &Reference, max_depth: Option<u32>) -> Markup {
    let (_, noise) = reference.noise();
    let noise = percent(noise.sqrt());
    html! {
        p {
            @if title.is_empty() { "The reference" } @else { "The reference for " (title) }
            @match &reference.source {
                Source::ClosedForm => {
                    " is exact: inside a closed surface that emits E and reflects the share a, the radiance is "
                    @match max_depth {
                        None => { "E / (1 − a)." }
                        Some(0) => { "E, as no path scatters." }
                        Some(depth) => { "E (1 − a" sup { (depth as u64 + 1) } ") / (1 − a), as paths end after " (count(depth.into(), "scattering event")) "." }
                    }
                }
                Source::File { path } => {
                    " is the file " code { (path) } ". "
                    @if reference.image.variance.is_some() { "By its variance layers its own error is " (noise) "; that is subtracted." }
                    @else { "It says nothing about its noise and counts as exact." }
                }
                Source::Rendered { strategy, lights, sampler, spp, seconds: wall, cpu_seconds, cached } => {
                    " is an image of " (strategy) " (lights " (lights) ", sampler " (sampler) ") with " (spp) " samples a pixel, \
                     in eight parts with seeds, and so sampling patterns, that no run has; nothing is learned or guided in it. It took " (seconds(*cpu_seconds)) " of CPU time (" (seconds(*wall)) " by the clock"
                    @if *cached { ", in an earlier call" } "). By the spread of its parts its own error is " (noise)
                    "; that is subtracted."
                }
            }
        }
    }
}
