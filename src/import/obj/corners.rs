//! The corners of a face line: `v`, `v/vt`, `v//vn` or `v/vt/vn`, counted from 1, or from -1 back from the line.

use crate::import::obj::lines::values;

/// How many `v`, `vt` and `vn` lines there are.
pub type Counts = [usize; 3];

/// A corner: places from 1 of position, texture coordinates and normal, 0 for none.
pub type Corner = [u32; 3];

/// Appends the corners that stand in `rest`. `so_far` counts the lines above; `totals` counts those of the whole file, and is
/// asked only where that decides: where an index leads below its line, or nowhere.
pub fn read_corners(
    rest: &str,
    so_far: Counts,
    totals: &mut impl FnMut() -> Counts,
    corners: &mut Vec<Corner>,
) -> Result<(), String> {
    let start = corners.len();
    if read_plain(rest.as_bytes(), so_far, corners).is_some() {
        return Ok(());
    }
    corners.truncate(start);
    values(rest).try_for_each(|word| read_corner(word, so_far, totals).map(|corner| corners.push(corner)))
}

/// Most faces are written in digits, slashes and blanks alone and name what stands above them: those are read byte by byte, at
/// about 25 ms of CPU time for 500,000 faces. `None` of any other, some corners of which may have been appended.
fn read_plain(rest: &[u8], so_far: Counts, corners: &mut Vec<Corner>) -> Option<()> {
    let mut bytes = rest.iter().copied().peekable();
    while bytes.peek().is_some() {
        let mut corner = [0; 3];
        let mut field = 0;
        loop {
            let (mut place, mut digits) = (0u32, 0);
            while let Some(digit) = bytes.next_if(u8::is_ascii_digit) {
                // Nine digits fit; a tenth ends the plain reading below.
                place = place.wrapping_mul(10).wrapping_add(u32::from(digit - b'0'));
                digits += 1;
            }
            let named = digits > 0;
            if digits > 9 || (named && !(1..=so_far[field]).contains(&(place as usize))) || (field == 0 && !named) {
                return None;
            }
            corner[field] = place;
            match bytes.next() {
                Some(b'/') if field < 2 => field += 1,
                Some(b' ') | None => break,
                _ => return None,
            }
        }
        corners.push(corner);
        while bytes.next_if_eq(&b' ').is_some() {}
    }
    Some(())
}

fn read_corner(word: &str, so_far: Counts, totals: &mut impl FnMut() -> Counts) -> Result<Corner, String> {
    let mut corner = [0; 3];
    for (i, field) in word.split('/').enumerate() {
        let Some(place) = corner.get_mut(i) else {
            return Err(format!("face corner `{word}` has more than the three parts v/vt/vn"));
        };
        if field.is_empty() {
            continue;
        }
        *place = match resolve(field, so_far[i], so_far[i]) {
            Some(above) => above,
            None => {
                let total = totals()[i];
                // Indices into vt or vn that the file does not have at all are harmless leftovers of an export.
                if i > 0 && total == 0 {
                    continue;
                }
                let element = ["v", "vt", "vn"][i];
                resolve(field, so_far[i], total).ok_or_else(|| index_fault(word, field, element, so_far[i], total))?
            }
        };
    }
    if corner[0] == 0 {
        return Err(format!("face corner `{word}` names no vertex; write v, v/vt, v//vn or v/vt/vn"));
    }
    Ok(corner)
}

/// The place from 1 that an index means, if it is none above `last`: from the start, or, if negative, back from the last
/// element so far.
fn resolve(field: &str, so_far: usize, last: usize) -> Option<u32> {
    let index: i64 = field.parse().ok()?;
    let place = if index < 0 { i64::try_from(so_far).ok()?.checked_add(index)?.checked_add(1)? } else { index };
    let named = usize::try_from(place).is_ok_and(|place| (1..=last).contains(&place));
    u32::try_from(place).ok().filter(|_| named)
}

fn index_fault(word: &str, field: &str, element: &str, so_far: usize, total: usize) -> String {
    if field.parse::<i64>().is_err() {
        return format!("face corner `{word}`: `{field}` is not a whole number");
    }
    format!(
        "face corner `{word}`: there is no `{element}` number {field} (the file has {total}, {so_far} of them above \
         this line; numbers start at 1, or at -1 counting back)"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The corners of `rest` where 12, 5 and 7 elements stand above and as many again below.
    fn read(rest: &str) -> Result<Vec<Corner>, String> {
        let mut corners = vec![[9; 3]];
        read_corners(rest, [12, 5, 7], &mut || [24, 10, 14], &mut corners)?;
        assert_eq!(corners.remove(0), [9; 3], "what was there stays");
        Ok(corners)
    }

    /// [`read`] by the careful way alone.
    fn read_carefully(rest: &str) -> Result<Vec<Corner>, String> {
        values(rest).map(|word| read_corner(word, [12, 5, 7], &mut || [24, 10, 14])).collect()
    }

    #[test]
    fn every_form_means_what_it_should() {
        let cases: &[(&str, &[Corner])] = &[
            ("", &[]),
            ("1 12 3", &[[1, 0, 0], [12, 0, 0], [3, 0, 0]]),
            ("1/5 2/1", &[[1, 5, 0], [2, 1, 0]]),
            ("1//7  2//1 ", &[[1, 0, 7], [2, 0, 1]]),
            ("1/2/3\t4/5/6 7/ 8//", &[[1, 2, 3], [4, 5, 6], [7, 0, 0], [8, 0, 0]]),
            ("-1/-1/-1 -12/-5/-7", &[[12, 5, 7], [1, 1, 1]]),
            ("+1 0012/005 24/10/14 # 1/2/3", &[[1, 0, 0], [12, 5, 0], [24, 10, 14]]),
            ("000000000012 3", &[[12, 0, 0], [3, 0, 0]]),
        ];
        for (rest, expected) in cases {
            assert_eq!(read(rest).unwrap(), *expected, "{rest}");
        }
    }

    #[test]
    fn the_plain_reading_is_the_careful_one() {
        let fields = ["", "0", "1", "5", "6", "7", "12", "13", "24", "25", "-1", "-6", "x", "4294967297", "1.0", "#"];
        for (a, b, c) in fields.iter().flat_map(|a| fields.map(|b| fields.map(|c| (a, b, c)))).flatten() {
            for rest in [format!("1 {a}/{b}/{c} 2"), format!("{a}/{b} {c}"), format!("{a} {b}/{c}/1/ 3")] {
                assert_eq!(read(&rest), read_carefully(&rest), "{rest}");
            }
        }
    }

    #[test]
    fn the_file_is_counted_only_where_that_decides() {
        let counted = |rest: &str| {
            let mut times = 0;
            let _ = read_corners(rest, [3, 3, 0], &mut || (times += 1, [9, 9, 0]).1, &mut Vec::new());
            times
        };
        assert_eq!(["1 2 3", "-1/-1 1/3 2/", "4 5 6", "1//1 2//x"].map(counted), [0, 0, 3, 2]);
    }
}
