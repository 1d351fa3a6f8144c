//! Whether a JPEG file is whole. Decoders fill up what is missing with grey and say nothing; so the codes of a picture are counted
//! here, block by block (ITU-T T.81), none of them turned into pixels.

/// What a file that was cut off says.
const CUT_OFF: &str = "the JPEG ends before its picture does: it was not copied or saved as a whole";
/// What one that was damaged says.
const BROKEN: &str = "the JPEG's data are broken: they hold a code that it does not define";

/// Why a decoder had to make up a part of the picture in `bytes`, if so. What stands behind the end of the picture does not
/// matter, and neither do kinds of JPEG that decoders refuse.
pub fn fault(bytes: &[u8]) -> Option<&'static str> {
    Jpeg { rest: bytes, frame: None, tables: Default::default(), restart: 0 }.walk().err()
}

type Outcome<T> = Result<T, &'static str>;

/// A file being walked through.
struct Jpeg<'a> {
    rest: &'a [u8],
    /// `None` before it, or if its codes cannot be counted.
    frame: Option<Frame>,
    /// Codes of DC coefficients, then of AC coefficients.
    tables: [Option<Codes>; 8],
    /// Units between two restarts; 0: none.
    restart: usize,
}

struct Frame {
    progressive: bool,
    /// In pixels.
    size: [usize; 2],
    /// The largest sampling factors of all components.
    factors: [usize; 2],
    components: Vec<Component>,
}

struct Component {
    id: u8,
    /// Sampling factors.
    factors: [usize; 2],
    /// Of each coefficient the lowest bit that a scan has sent so far.
    lowest_bit: [Option<u8>; 64],
    /// Of a progressive picture, which coefficients of each block are not zero so far, in zigzag order.
    nonzero: Vec<u64>,
}

impl Frame {
    /// Units of several components, along both axes.
    fn units(&self) -> [usize; 2] {
        std::array::from_fn(|axis| self.size[axis].div_ceil(8 * self.factors[axis]))
    }
}

impl Jpeg<'_> {
    fn walk(&mut self) -> Outcome<()> {
        loop {
            match self.marker()? {
                0xD9 => return self.check_sent(),
                // These stand alone: start of image, restarts, one without meaning.
                0x01 | 0xD0..=0xD8 => {}
                marker => {
                    let length = self.rest.first_chunk().map_or(0, |&length| usize::from(u16::from_be_bytes(length)));
                    // Segments are passed by their lengths: they may hold other pictures.
                    let (segment, rest) = self.rest.split_at_checked(length.max(2)).ok_or(CUT_OFF)?;
                    self.rest = rest;
                    let segment = &segment[2..];
                    match marker {
                        0xC4 => self.read_tables(segment),
                        0xC0..=0xC2 => self.frame = read_frame(segment, marker == 0xC2),
                        0xC3 | 0xC5..=0xC7 | 0xC9..=0xCB | 0xCD..=0xCF => self.frame = None,
                        0xDD => self.restart = segment.first_chunk().map_or(0, |&n| u16::from_be_bytes(n).into()),
                        0xDA => self.scan(segment)?,
                        _ => {}
                    }
                }
            }
        }
    }

    /// The next marker; decoders pass what is none.
    fn marker(&mut self) -> Outcome<u8> {
        let is_marker = |pair: &[u8]| pair[0] == 0xFF && !matches!(pair[1], 0x00 | 0xFF);
        let place = self.rest.windows(2).position(is_marker).ok_or(CUT_OFF)?;
        let marker = self.rest[place + 1];
        self.rest = &self.rest[place + 2..];
        Ok(marker)
    }

    fn read_tables(&mut self, mut segment: &[u8]) {
        while let Some((&[class, ref counts @ ..], rest)) = segment.split_first_chunk::<17>() {
            let symbols = counts.iter().map(|&count| usize::from(count)).sum();
            let Some((symbols, rest)) = rest.split_at_checked(symbols) else { return };
            if let Some(table) = self.tables.get_mut(usize::from(class >> 4) * 4 + usize::from(class & 3)) {
                *table = Some(Codes::new(counts, symbols));
            }
            segment = rest;
        }
    }

    /// Whether every component was sent, down to the lowest bit of what was begun.
    fn check_sent(&self) -> Outcome<()> {
        let mut components = self.frame.iter().flat_map(|frame| &frame.components);
        let sent =
            |c: &Component| c.lowest_bit[0].is_some() && c.lowest_bit.iter().all(|bit| bit.is_none_or(|bit| bit == 0));
        if components.all(sent) { Ok(()) } else { Err(CUT_OFF) }
    }

    /// Walks through the data behind the header of a scan.
    fn scan(&mut self, header: &[u8]) -> Outcome<()> {
        let data = self.scan_data();
        let Some(frame) = &mut self.frame else { return Ok(()) };
        let Some(scan) = Scan::read(header, frame, &self.tables) else {
            self.frame = None;
            return Ok(());
        };
        let units = match scan.components[..] {
            // A component by itself has no more blocks than it needs.
            [(component, ..)] => std::array::from_fn(|axis| {
                let samples = frame.size[axis] * frame.components[component].factors[axis];
                samples.div_ceil(frame.factors[axis]).div_ceil(8)
            }),
            _ => frame.units(),
        };
        let per_row = frame.units()[0];
        let interval = if self.restart == 0 { usize::MAX } else { self.restart };
        let mut parts = data.iter();
        let mut bits = Bits::default();
        let mut run = 0;
        for unit in 0..units[0] * units[1] {
            if unit % interval == 0 {
                (bits, run) = (Bits { bytes: parts.next().ok_or(CUT_OFF)?, ..Bits::default() }, 0);
            }
            let [x, y] = [unit % units[0], unit / units[0]];
            for &(place, dc, ac) in &scan.components {
                let component = &mut frame.components[place];
                let [width, height] = if scan.components.len() == 1 { [1, 1] } else { component.factors };
                let columns = per_row * component.factors[0];
                for block in 0..width * height {
                    let at = (y * height + block / width) * columns + x * width + block % width;
                    let mut none = 0;
                    let nonzero = component.nonzero.get_mut(at).unwrap_or(&mut none);
                    scan.block(&mut bits, [dc, ac], nonzero, &mut run)?;
                }
            }
        }
        for &(place, ..) in &scan.components {
            frame.components[place].lowest_bit[scan.first..=scan.last].fill(Some(scan.low));
        }
        Ok(())
    }

    /// The data of a scan between its restarts, each 0xFF without the 0 behind it; they end at any other marker.
    fn scan_data(&mut self) -> Vec<Vec<u8>> {
        let mut parts = vec![Vec::new()];
        while let Some(place) = self.rest.iter().position(|&byte| byte == 0xFF) {
            let (data, rest) = self.rest.split_at(place);
            let last = parts.len() - 1;
            parts[last].extend_from_slice(data);
            match rest.get(1) {
                Some(0x00) => parts[last].push(0xFF),
                Some(0xD0..=0xD7) => parts.push(Vec::new()),
                // Fill in front of a marker.
                Some(0xFF) => {
                    self.rest = &rest[1..];
                    continue;
                }
                _ => {
                    self.rest = rest;
                    return parts;
                }
            }
            self.rest = &rest[2..];
        }
        self.rest = &[];
        parts
    }
}

fn read_frame(segment: &[u8], progressive: bool) -> Option<Frame> {
    let (&[_precision, y0, y1, x0, x1, count], rows) = segment.split_first_chunk::<6>()?;
    let size = [u16::from_be_bytes([x0, x1]), u16::from_be_bytes([y0, y1])].map(usize::from);
    let rows = rows.get(..3 * usize::from(count))?.as_chunks::<3>().0;
    let factors = |row: &[u8; 3]| [row[1] >> 4, row[1] & 15].map(usize::from);
    if rows.is_empty() || rows.iter().any(|row| factors(row).iter().any(|f| !(1..=4).contains(f))) {
        return None;
    }
    let largest = |axis: usize| rows.iter().map(|row| factors(row)[axis]).max().unwrap_or(1);
    let mut frame = Frame { progressive, size, factors: [largest(0), largest(1)], components: Vec::new() };
    let [columns, lines] = frame.units();
    for row in rows {
        let factors = factors(row);
        let blocks = if progressive { columns * lines * factors[0] * factors[1] } else { 0 };
        let nonzero = vec![0; blocks];
        frame.components.push(Component { id: row[0], factors, lowest_bit: [None; 64], nonzero });
    }
    Some(frame)
}

/// What the header of a scan says.
struct Scan<'a> {
    progressive: bool,
    /// Their places in the frame, and their codes.
    components: Vec<(usize, Option<&'a Codes>, Option<&'a Codes>)>,
    /// The first and the last coefficient, in zigzag order.
    first: usize,
    last: usize,
    /// Whether bits are added to coefficients that were sent before.
    refines: bool,
    /// The lowest bit that is sent.
    low: u8,
}

impl<'a> Scan<'a> {
    fn read(header: &[u8], frame: &Frame, tables: &'a [Option<Codes>; 8]) -> Option<Scan<'a>> {
        let (&count, rest) = header.split_first()?;
        let (rows, rest) = rest.split_at_checked(2 * usize::from(count))?;
        let &[first, last, bits] = rest.first_chunk()?;
        let component = |&[id, table]: &[u8; 2]| {
            let place = frame.components.iter().position(|component| component.id == id)?;
            let codes = |place: u8| tables[usize::from(place)].as_ref();
            Some((place, codes(table >> 4 & 3), codes(4 + (table & 3))))
        };
        let components = rows.as_chunks().0.iter().map(component).collect::<Option<Vec<_>>>()?;
        let (first, last) = if frame.progressive { (first.into(), last.into()) } else { (0, 63) };
        let fits = first <= last && last < 64 && !components.is_empty() && (first == 0 || components.len() == 1);
        let (refines, low) = if frame.progressive { (bits >> 4 != 0, bits & 15) } else { (false, 0) };
        let (of_dc, of_ac) = (first == 0 && !refines, last > 0);
        // Decoders know the tables of films, which do not say them.
        let known = components.iter().all(|(_, dc, ac)| !(of_dc && dc.is_none() || of_ac && ac.is_none()));
        (fits && known).then_some(Scan { progressive: frame.progressive, components, first, last, refines, low })
    }

    /// Passes the codes of one block. `run`: how many blocks, this one among them, have no more codes.
    fn block(&self, bits: &mut Bits<'_>, codes: [Option<&Codes>; 2], nonzero: &mut u64, run: &mut u32) -> Outcome<()> {
        let mut at = self.first;
        if at == 0 {
            if self.refines {
                bits.read(1)?;
            } else {
                let size = bits.symbol(codes[0])?;
                bits.read(size.into())?;
            }
            at = 1;
            if self.progressive {
                return Ok(());
            }
        }
        while *run == 0 && at <= self.last {
            let symbol = bits.symbol(codes[1])?;
            let (mut zeros, size) = (symbol >> 4, u32::from(symbol & 15));
            if size == 0 && zeros < 15 {
                // The end of this block, and of progressive pictures that of some more.
                *run = if self.progressive { (1 << zeros) + bits.read(zeros.into())? } else { 1 };
                break;
            }
            bits.read(size)?;
            while at <= self.last {
                if self.refines && *nonzero >> at & 1 == 1 {
                    bits.read(1)?;
                } else if zeros > 0 {
                    zeros -= 1;
                } else {
                    *nonzero |= u64::from(size > 0) << at;
                    at += 1;
                    break;
                }
                at += 1;
            }
        }
        if *run > 0 {
            if self.refines && at <= self.last {
                let of_scan = u64::MAX >> (63 - self.last) & u64::MAX << at;
                bits.read((*nonzero & of_scan).count_ones())?;
            }
            *run -= 1;
        }
        Ok(())
    }
}

/// Huffman codes: by the next 16 bits of the data, the length of the code they begin with and its symbol; 0: there is none.
struct Codes(Vec<[u8; 2]>);

impl Codes {
    /// The codes of which `counts` have the lengths 1 to 16; `symbols` by ascending code.
    fn new(counts: &[u8], symbols: &[u8]) -> Codes {
        let mut codes = Vec::with_capacity(1 << 16);
        let mut symbols = symbols.iter();
        for (length, &count) in (1u8..).zip(counts) {
            for &symbol in symbols.by_ref().take(count.into()) {
                codes.resize((codes.len() + (1 << (16 - length))).min(1 << 16), [length, symbol]);
            }
        }
        codes.resize(1 << 16, [0; 2]);
        Codes(codes)
    }
}

/// Bits in the order of their bytes, the highest first.
#[derive(Default)]
struct Bits<'a> {
    bytes: &'a [u8],
    /// The bits that are read next, from the highest on.
    next: u64,
    count: u32,
}

impl Bits<'_> {
    /// Makes the next bits at least 56, as long as there are so many; behind them are ones.
    fn fill(&mut self) {
        while self.count <= 56 {
            let Some((&byte, rest)) = self.bytes.split_first() else { return };
            self.next |= u64::from(byte) << (56 - self.count);
            (self.bytes, self.count) = (rest, self.count + 8);
        }
    }

    /// A number of so many bits; only of the first 16 bits the value is asked for.
    fn read(&mut self, mut size: u32) -> Outcome<u32> {
        let value = |bits: &Self, size: u32| if size == 0 { 0 } else { (bits.next >> (64 - size)) as u32 };
        while size > 32 {
            self.read(32)?;
            size -= 32;
        }
        self.fill();
        let number = value(self, size);
        self.pass(size)?;
        Ok(number)
    }

    fn symbol(&mut self, codes: Option<&Codes>) -> Outcome<u8> {
        self.fill();
        let padding = if self.count >= 16 { 0 } else { u64::MAX >> self.count };
        let [length, symbol] = codes.ok_or(BROKEN)?.0[((self.next | padding) >> 48) as usize];
        self.pass(length.into())?;
        if length > 0 {
            Ok(symbol)
        } else if self.count < 16 {
            Err(CUT_OFF)
        } else {
            Err(BROKEN)
        }
    }

    fn pass(&mut self, size: u32) -> Outcome<()> {
        self.count = self.count.checked_sub(size).ok_or(CUT_OFF)?;
        self.next = if size < 64 { self.next << size } else { 0 };
        Ok(())
    }
}
