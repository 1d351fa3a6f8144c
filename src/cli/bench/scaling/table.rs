//! The rows as text: a table a sweep.

use crate::cli::bench::measure::{MOST_COLUMNS, number, rounds};
use crate::cli::bench::scaling::sweep::{Row, Swept, overall};
use crate::cli::numbers::{count, three_digits};
use crate::cli::output::{aligned_in, columns, wrapped};
use crate::settings::Settings;
use crate::simd::simd_level;

/// What the columns of the tables mean.
const LEGEND: &str = "\
Mpaths/s, ns/path and Mrays/s are of CPU time, all threads together; growth is e where what stands before it grew as size^e since the \
line above: 0 does not grow, 1 grows in proportion";
const OF_THREADS: &str = "\
speed-up is by wall time and CPU by CPU time, both against one thread; shared/tile counts what workers did on what they share: \
locks and atomic read-modify-writes";

/// Everything, for renders of `scene` with `settings`.
pub fn text(scene: &str, settings: &Settings, rows: &[Row]) -> String {
    let runs = rows.first().map_or(0, |row| row.runs);
    let (width, height) = (settings.width.unwrap_or(0), settings.height.unwrap_or(0));
    let head = format!(
        "{scene}, {width} x {height} pixels, {}, lights {}, {}, {}, {}; one size varied in each sweep, one thread but in the last",
        settings.strategy,
        settings.lights,
        settings.sampler,
        rounds(runs),
        simd_level(),
    );
    let prose = |text: &str| wrapped(text, columns().min(MOST_COLUMNS) - 2, 2);
    let mut text = format!("{}\n{}\n{}\n", prose(&head), prose(LEGEND), prose(OF_THREADS));
    for what in Swept::ALL {
        let rows: Vec<Row> = rows.iter().filter(|row| row.what == what).cloned().collect();
        text += &format!("\n{}\n{}", prose(&title(what, &rows)), table(what, &rows));
    }
    text
}

/// What was varied, and how the time of a path grows over all of it.
fn title(what: Swept, rows: &[Row]) -> String {
    let title = match what {
        Swept::Triangles => "triangles of builtin:heavy:N",
        Swept::Lights => "lamps of builtin:lamp_hall:N",
        Swept::Bounces => "most bounces of a path, --max-depth N",
        Swept::Pixels => "pixels of a square film",
        Swept::Threads => "threads",
    };
    let grows =
        |exponent| format!("{title}: from first to last the time of a path grows as N^{}", growth(Some(exponent)));
    overall(rows).map_or(title.to_owned(), grows)
}

/// An exponent; never -0.00.
fn growth(exponent: Option<f64>) -> String {
    exponent.map_or("-".to_owned(), |exponent| format!("{:.2}", (exponent * 100.0).round() / 100.0 + 0.0))
}

/// A heading and a line a size, all numbers.
fn table(what: Swept, rows: &[Row]) -> String {
    let mut heading = vec![what.name(), "spp", "Mpaths/s", "wall s", "ns/path", "growth"];
    match what {
        Swept::Triangles | Swept::Lights => heading.extend(["Mrays/s", "prepare s", "growth"]),
        Swept::Bounces | Swept::Pixels => heading.extend(["Mrays/s"]),
        Swept::Threads => heading.extend(["speed-up", "CPU", "tiles", "shared/tile"]),
    }
    let mut lines = vec![heading.iter().map(|&word| word.to_owned()).collect::<Vec<_>>()];
    for row in rows {
        let mut line = vec![count(row.size), count(row.spp.into())];
        line.extend([row.mpaths_per_s, row.wall_s, row.ns_per_path].map(three_digits));
        line.push(growth(row.growth));
        let mrays_per_s = three_digits(row.mrays_per_s);
        match what {
            Swept::Triangles | Swept::Lights => {
                line.extend([mrays_per_s, number(row.prepare_s), growth(row.prepare_growth)]);
            }
            Swept::Bounces | Swept::Pixels => line.push(mrays_per_s),
            Swept::Threads => {
                let of_tiles = [count(row.tiles), three_digits(row.operations_per_tile)];
                line.extend([row.speed_up, row.cpu_ratio].map(number).into_iter().chain(of_tiles));
            }
        }
        lines.push(line);
    }
    lines.iter_mut().for_each(|line| line[0] = format!("  {:>9}", line[0]));
    aligned_in(&lines, &(0..heading.len()).collect::<Vec<_>>(), MOST_COLUMNS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::bench::scaling::sweep::tests::rows;

    #[test]
    fn the_tables_fit_a_hundred_columns() {
        let most = |what| match what {
            Swept::Threads => (4096, 262_144),
            _ => (4_294_836_225, 16_777_216),
        };
        for what in Swept::ALL {
            let (size, tiles) = most(what);
            let mut rows = rows(what, &[(1, 123_456.7), (64, 123_455.0), (512, 246_910.0), (size, 1e-4)]);
            rows.iter_mut().for_each(|row| (row.tiles, row.spp) = (tiles, 65_536));
            let text = text("builtin:lamp_hall", &Settings::plain(), &rows);
            assert!(text.lines().all(|line| line.chars().count() <= MOST_COLUMNS), "{text}");
            let table = table(what, &rows);
            assert_eq!(table.lines().count(), 1 + rows.len(), "{table}");
            assert!(table.contains(&count(size)) && table.contains("  0.33"), "{table}");
        }
    }

    #[test]
    fn exponents_have_one_zero() {
        assert_eq!([None, Some(-0.001), Some(0.104), Some(-1.0)].map(growth), ["-", "0.00", "0.10", "-1.00"]);
        let rows = rows(Swept::Lights, &[(100, 1.0), (10_000, 10.0)]);
        let title = title(Swept::Lights, &rows);
        assert!(title.ends_with("grows as N^0.50"), "{title}");
    }
}
