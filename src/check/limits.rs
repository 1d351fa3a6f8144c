//! How far octray goes: the table of measured limits.
//!
//! Each limit is the end of what a row of `octray check` goes through, and holds within that row's bound.
//!
//! | limit | up to | within | row |
//! | --- | --- | --- | --- |
//! | distance from the origin | 1e3 times the scene's size | 1e-3 of the mean | `scale/offset_1e1_to_1e3_sizes` |
//! | the same, f32 coordinates stepping by 1e-3 of the scene | 1e4 times the scene's size | 5e-2 of the mean | `scale/offset_1e4_sizes` |
//! | size of the scene | 1e-9 to 1e11 | twins render alike | `scale/powers_of_ten_are_twins` |
//! | smallest light | 1e-12 sr | 5 standard errors | `lights/solid_angle_1e-12_to_2pi` |
//! | aspect of a closed mesh, along the axes | 1e6 | no ray leaks | `geometry/leaks_of_corridors_to_1e6` |
//! | aspect of a closed mesh, rotated | 1e4 | no ray leaks | `geometry/leaks_of_tilted_corridors_to_1e4` |
//! | thinnest closed box | 1e-7 of its length | no ray leaks | `geometry/leaks_of_boxes_to_1e-7_thin` |
//! | aspect of a light | 1e6 along the axes, 1e4 rotated | 5 standard errors | `lights/needle_to_1e6` |
//! | largest triangle, along the axes | 1e6 times the detail on it | 1e-3 | `geometry/huge_ground_to_1e6` |
//! | largest triangle, tilted | 1e4 times the detail on it | 1e-3 | `geometry/tilted_huge_ground_to_1e4` |
//! | albedo of a closed room | .99999 | 1e-4 of the geometric sum | `transport/albedo_.99999` |
//! | height of an environment map | 16,384 rows, the polar ones too | 1e-4 | `environment/polar_row_of_16384` |
//! | angle of a pixel | 2^-22 rad | 1 pixel | `camera/narrow_views` |
//! | radiance | 1e-30 to 1e30 | 5 standard errors | `lights/radiance_1e-30_to_1e30` |
//! | lights in one scene | 1e12 times each other's power | 5 standard errors | `lights/1e12_apart` |
//!
//! README.md shows the same table; a test compares the two and looks the rows up.

#[cfg(test)]
mod tests {
    /// The lines of the table in a text whose lines begin with `prefix`.
    fn table<'a>(text: &'a str, prefix: &str) -> Vec<&'a str> {
        let lines = text.lines().filter_map(|line| line.strip_prefix(prefix));
        lines.skip_while(|line| !line.starts_with("| limit ")).take_while(|line| line.starts_with('|')).collect()
    }

    #[test]
    fn the_readme_shows_the_table_and_its_rows_exist() {
        let limits = table(include_str!("limits.rs"), "//! ");
        assert_eq!(limits, table(include_str!("../../README.md"), ""));
        let names = crate::check::names();
        for line in &limits[2..] {
            let row = line.trim_end_matches(" |").rsplit("| ").next().unwrap_or_default().trim_matches('`');
            assert!(names.iter().any(|name| name == row), "no row {row}");
        }
    }
}
