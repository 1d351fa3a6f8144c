//! `report.html`: the findings for people. One file, no script, nothing fetched; dark and light; fits a phone.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::report::analysis::equal_time::Shown;
use crate::report::measure::experiment::Budget;
use crate::report::measure::truth::{Reference, Source};
use crate::report::write::contents::Contents;
use crate::report::write::figures;
use crate::report::write::heatmap::{Canvas, Scale};
use crate::report::write::numbers::{count, percent, seconds};
use crate::report::write::plot;
use crate::report::write::plot::{Layout, Plot};
use crate::report::write::tables;
use crate::report::write::words::{Words, tag};

const STYLE: &str = "*{box-sizing:border-box}html{-webkit-text-size-adjust:100%}\
body{margin:0;background:var(--paper);color:var(--ink);font:17px/1.55 Georgia,'Iowan Old Style','Times New Roman',serif}\
main{max-width:66rem;margin:0 auto;padding:2.2rem 1.1rem 4rem}p,ul,ol{max-width:44rem}\
h1,h2,h3,th,td,figcaption,.facts,.scale{font-family:system-ui,-apple-system,'Segoe UI',Roboto,sans-serif}\
h1{font-size:1.9rem;line-height:1.2;margin:0 0 .3rem}h2{font-size:1.35rem;margin:2.8rem 0 .6rem;padding-top:.8rem;border-top:1px solid var(--rule)}\
h3{font-size:1.05rem;margin:1.8rem 0 .4rem}.facts{color:var(--soft);font-size:.9rem;margin:.2rem 0 1.4rem}\
.scroll{overflow-x:auto;margin:.6rem 0 1.2rem}table{border-collapse:collapse;font-size:.86rem;font-variant-numeric:tabular-nums}\
th,td{padding:.32rem .6rem;text-align:right;white-space:nowrap;border-bottom:1px solid var(--rule)}\
th{color:var(--soft);font-weight:600;vertical-align:bottom}th:first-child,td:first-child{text-align:left;position:sticky;left:0;background:var(--paper)}\
td.best{font-weight:700}td.guess{color:var(--soft);font-style:italic}tr.biased td{color:var(--soft)}\
code,pre{font:.86em ui-monospace,SFMono-Regular,Menlo,Consolas,monospace}pre{overflow-x:auto;padding:.7rem .9rem;border:1px solid var(--rule);border-radius:6px}\
figure{margin:1rem 0}figcaption{font-size:.86rem;color:var(--soft);max-width:44rem}\
.narrow{display:none}@media (max-width:40rem){.narrow{display:block}.wide{display:none}}\
.pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(15.5rem,1fr));gap:1.1rem}\
.pictures figure{margin:0}.pictures .pair{display:grid;grid-template-columns:1fr 1fr;gap:2px}\
.pictures img{width:100%;height:auto;display:block}.short li{margin:.35rem 0}dt{font-weight:700;margin-top:.7rem}dd{margin:0;max-width:44rem}\
dt,.name{font-family:ui-monospace,SFMono-Regular,Menlo,Consolas,monospace;font-size:.92em}\
.tag{font:600 .72rem system-ui,sans-serif;border:1px solid currentColor;border-radius:4px;padding:.05rem .35rem;margin-left:.4rem;vertical-align:.1em}\
.scale{display:flex;align-items:center;gap:.6rem;font-size:.82rem;color:var(--soft);margin:.4rem 0 1rem}.scale i{display:block;width:12rem;height:.8rem}";

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
                    style { (PreEscaped(root + &dark + STYLE + plot::STYLE)) }
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
        let (runs, of) = (self.0.measured.runs.len(), self.0.experiment.run_count());
        let threads = match self.0.experiment.settings.threads {
            0 => self.0.machine.cores,
            n => n,
        };
        html! {
            p class="facts" {
                (width) " × " (height) " pixels, " (runs) " runs, " (self.0.machine.cpu) ", " (threads)
                (if threads == 1 { " thread" } else { " threads" }) ", " (crate::lanes::simd_level())
                ", octray " (env!("CARGO_PKG_VERSION"))
            }
            @if !self.0.finished {
                p { strong { "Stopped after " (runs) " of " (of) " runs." } " What follows is about these." }
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
        tables::overview(&self.words(0), self.0.summaries, self.0.findings)
    }

    fn words(&self, case: usize) -> Words<'_> {
        let findings = self.0.findings.iter().filter(|finding| finding.case == case).collect();
        Words { experiment: self.0.experiment, findings }
    }

    fn case(&self, index: usize) -> Markup {
        let words = self.words(index);
        if words.findings.is_empty() {
            return html! {};
        }
        let title = self.0.experiment.case_title(index);
        let [(by_seconds, _), (by_samples, _)] = figures::plots(&words, &title);
        html! {
            @if !title.is_empty() { h2 { (title) } }
            ul class="short" { @for sentence in words.in_short() { li { (sentence) } } }
            figure {
                (plotted(&by_seconds))
                figcaption {
                    "Relative error (root of relMSE) against CPU seconds of all threads together. Bars and bands are 95 % \
                     intervals; lines are fits, and the number behind a name is the fitted slope: −0.5 is the law of random \
                     sampling, four times the work for half the error. Dotted levels are where biased pictures stop."
                }
            }
            figure {
                (plotted(&by_samples))
                figcaption { "The same against samples a pixel: what a sample is worth, whatever it costs." }
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
        if self.0.experiment.regions.is_empty() {
            return html! {};
        }
        html! {
            h3 { "By region" }
            p { "Relative error in parts of the film at the largest budget; the least of each in bold." }
            (tables::regions(words))
        }
    }

    fn pictures(&self, case: usize, words: &Words) -> Markup {
        let shown: Vec<&Shown> = self.0.shown.iter().filter(|shown| shown.case == case).collect();
        let Some(first) = shown.first() else { return html! {} };
        let scale = heat_scale(&shown);
        let time = shown.iter().map(|shown| shown.cpu_seconds).sum::<f64>() / shown.len() as f64;
        html! {
            h3 { "The same time, " (shown.len()) " pictures" }
            p {
                "What each makes of about " (seconds(time)) " of CPU time, and beside it the relative error of every pixel."
            }
            div class="scale" {
                span { (percent(10f64.powi(scale.low))) }
                i style=(gradient(scale)) {}
                span { (percent(10f64.powi(scale.high))) }
            }
            div class="pictures" {
                @for shown in &shown {
                    @let label = self.0.experiment.label(shown.configuration);
                    @let found = words.findings.iter().find(|finding| finding.configuration == shown.configuration);
                    figure {
                        div class="pair" {
                            (picture(&shown.image.srgb8(self.0.experiment.exposure), &format!("{label}, {} samples a pixel", shown.spp)))
                            (picture(
                                &Canvas::plain(&shown.errors, first.image.width, scale).png(),
                                &format!("relative error of {label}"),
                            ))
                        }
                        figcaption {
                            span class="name" { (label) }
                            @if let Some(tag) = found.and_then(|finding| tag(finding)) { span class="tag" { (tag) } }
                            br;
                            (shown.spp) " samples a pixel, error " (percent(shown.relmse.max(0.0).sqrt()))
                        }
                    }
                }
            }
        }
    }

    fn method(&self) -> Markup {
        let experiment = self.0.experiment;
        let budgets: Vec<String> = experiment.budgets.iter().map(budget_text).collect();
        html! {
            h2 { "How this was measured" }
            p {
                "relMSE is the mean over pixels and channels of (a − b)² / (b² + 0.01), b being the reference; the error stated \
                 everywhere is its root. The noise of the reference is subtracted. Efficiency is 1 / (relMSE × CPU seconds) at the \
                 largest budget: twice the efficiency is half the time to the same error. CPU seconds are those of all threads, of \
                 rendering alone. Each budget (" (budgets.join(", ")) ") was run " (experiment.repeats) " times with independent \
                 seeds, runs interleaved so that a slow moment of the machine hits all alike. Intervals are 95 %, by a bootstrap \
                 over runs in 1,024 tiles; those of the slopes hold for all strategies at once. The bias is that of all runs of a \
                 configuration together; z is its distance from 0 in standard errors, the reference's included."
            }
            @for (case, reference) in self.0.references.iter().enumerate() { (reference_text(&experiment.case_title(case), reference)) }
            p { "To repeat it:" }
            pre { (self.0.command) }
            p {
                "The runs are in " code { "converge.csv" } ", everything else in " code { "converge.json" } ", the plots and \
                 pictures beside them."
            }
        }
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

fn budget_text(budget: &Budget) -> String {
    match budget {
        Budget::Spp(spp) => format!("{} a pixel", count((*spp).into(), "sample")),
        Budget::Time(time) => seconds(time.as_secs_f64()),
    }
}

fn picture(png: &[u8], what: &str) -> Markup {
    html! { img src=(format!("data:image/png;base64,{}", STANDARD.encode(png))) alt=(what); }
}

fn gradient(scale: Scale) -> String {
    let stop = |i: i32| {
        let exponent = scale.low as f64 + (scale.high - scale.low) as f64 * i as f64 / 10.0;
        let [r, g, b] = scale.color(10f64.powf(exponent));
        format!("#{r:02x}{g:02x}{b:02x}")
    };
    format!("background:linear-gradient(90deg,{})", (0..=10).map(stop).collect::<Vec<_>>().join(","))
}

fn reference_text(title: &str, reference: &Reference) -> Markup {
    let (_, noise) = reference.noise();
    let noise = percent(noise.sqrt());
    html! {
        p {
            @if title.is_empty() { "The reference" } @else { "The reference for " (title) }
            @match &reference.source {
                Source::ClosedForm => { " is exact: inside a closed surface that emits E and reflects the share a, the radiance is \
                                         E / (1 − a)." }
                Source::File { path } => {
                    " is the file " code { (path) } ". "
                    @if reference.image.variance.is_some() { "By its variance layers its own error is " (noise) "; that is subtracted." }
                    @else { "It says nothing about its noise and counts as exact." }
                }
                Source::Rendered { strategy, lights, sampler, spp, seconds: wall, cpu_seconds, cached } => {
                    " is a picture of " (strategy) " (lights " (lights) ", sampler " (sampler) ") with " (spp) " samples a pixel \
                     and seeds of its own. It took " (seconds(*cpu_seconds)) " of CPU time (" (seconds(*wall)) " by the clock"
                    @if *cached { ", in an earlier call" } "). By the spread of its eight parts its own error is " (noise)
                    "; that is subtracted."
                }
            }
        }
    }
}
