//! Both engines beside each other, ray by ray and value by value.

use crate::bvh::ray::NO_HIT;
use crate::cli::numbers::{counted, nine_digits};
use crate::cli::output::table_in;
use crate::trace::{PathStep, Value};

/// What the widest row takes; digits that are compared are not wrapped.
const COLUMNS: usize = 80;

/// Every value of every ray: once where both engines have it, else under each other, marked and with their bits.
pub fn comparison(scalar: &[PathStep], packet: &[PathStep]) -> String {
    let mut rows = vec![["depth", "value", "engine", ""].map(str::to_owned).to_vec()];
    for depth in 0..scalar.len().max(packet.len()) {
        let [scalar, packet] = [scalar, packet].map(|path| path.get(depth).map(PathStep::values));
        let Some(names) = scalar.or(packet) else { break };
        for (index, (name, _)) in names.into_iter().enumerate() {
            let [a, b] = [scalar, packet].map(|values| values.map_or(Value::None, |values| values[index].1));
            let row = |mark: &str, engine: &str, value: String| {
                // So short that three long numbers fit beside it.
                vec![format!("{mark} {depth}"), name.replace("contribution", "gain"), engine.to_owned(), value]
            };
            let below = |engine: &str, value: String| vec![String::new(), String::new(), engine.to_owned(), value];
            match (a, b) {
                (Value::None, Value::None) => {}
                (a, b) if a == b => rows.push(row(" ", "both", shown(a))),
                (a, b) => {
                    rows.push(row(">", "scalar", shown(a)));
                    rows.push(below("", bits(a)));
                    rows.push(below("packet", shown(b)));
                    rows.push(below("", bits(b)));
                }
            }
        }
    }
    rows.retain(|row| row.iter().any(|cell| !cell.is_empty()));
    table_in(&rows, COLUMNS)
}

/// Whether the engines agree, and on what.
pub fn verdict(scalar: &[PathStep], difference: Option<(usize, &'static str)>) -> String {
    let rays = scalar.len();
    let shadow_rays = scalar.iter().filter(|step| step.shadow.is_some()).count();
    match difference {
        Some((depth, "end")) => {
            format!("the engines differ: at depth {depth} one has ended its path, the other has not")
        }
        Some((depth, name)) => format!("the engines differ: first in the {name} at depth {depth}"),
        None => format!(
            "both engines agree to the last bit on {} and {}",
            counted(rays, "ray"),
            counted(shadow_rays, "shadow ray")
        ),
    }
}

fn shown(value: Value) -> String {
    match value {
        Value::Triangle(NO_HIT) | Value::None => "-".to_owned(),
        Value::Triangle(id) => id.to_string(),
        Value::Number(value) => nine_digits(f64::from(value)),
        Value::Vector(value) => value.map(|c| nine_digits(f64::from(c))).join(" "),
        Value::Flag(flag) => if flag { "yes" } else { "no" }.to_owned(),
    }
}

fn bits(value: Value) -> String {
    match value {
        Value::Number(value) => format!("bits {:08x}", value.to_bits()),
        Value::Vector(value) => format!("bits {}", value.map(|c| format!("{:08x}", c.to_bits())).join(" ")),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::{ShadowStep, first_difference};

    fn step() -> PathStep {
        PathStep {
            origin: [0.0, 1e-9, -2.5],
            direction: [0.0, 0.0, 1.0],
            beta: [1.0; 3],
            triangle: NO_HIT,
            t: f32::INFINITY,
            shadow: None,
            radiance: [0.1; 3],
        }
    }

    #[test]
    fn what_both_have_stands_once_and_what_differs_is_marked() {
        let same = comparison(&[step()], &[step()]);
        assert!(same.contains("  0    origin      both    0 9.99999972e-10 -2.50000000\n"), "{same}");
        assert!(!same.contains('>') && !same.contains("shadow") && !same.contains("scalar"), "{same}");
        assert_eq!(verdict(&[step()], None), "both engines agree to the last bit on 1 ray and 0 shadow rays");
        let other = PathStep { t: 2.0, radiance: [0.1, 0.1, 0.1f32.next_up()], ..step() };
        let text = comparison(&[step()], &[other]);
        let marked: Vec<&str> = text.lines().filter(|line| line.starts_with('>')).collect();
        assert!(marked.len() == 2 && marked[0].contains(" t ") && marked[1].contains(" radiance "), "{text}");
        assert!(text.contains("bits 3dcccccd 3dcccccd 3dccccce"), "{text}");
        let difference = first_difference(&[step()], &[other]);
        assert_eq!(verdict(&[step()], difference), "the engines differ: first in the t at depth 0");
        let longer = comparison(&[step(), step()], &[step()]);
        assert!(longer.lines().any(|line| line.starts_with("> 1")) && longer.contains("packet  -"), "{longer}");
    }

    #[test]
    fn the_widest_values_fit_eighty_columns() {
        let wide = [-1.234_567_9e-30; 3];
        let shadow = Some(ShadowStep { direction: wide, contribution: wide, blocked: true });
        let step = PathStep { origin: wide, direction: wide, beta: wide, shadow, ..step() };
        let text = comparison(&vec![step; 1000], &[]);
        assert!(text.lines().all(|line| line.len() <= 80), "{}", text.lines().max_by_key(|line| line.len()).unwrap());
    }
}
