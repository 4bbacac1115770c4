//! A picture of numbered colours: what PNG and GIF take as it is.

use font8x8::UnicodeFonts;

/// A smaller polygon has no line around it, pixels.
const LEAST_OUTLINED: f64 = 8.0;

/// Colours of the scale; the rest of the 256 are those of [`Tone`].
pub(crate) const COLOURS: u8 = 240;

/// Width and height of a letter, pixels.
const WIDE: usize = 8;
pub(crate) const HIGH: usize = 16;

/// Viridis (Smith & van der Walt 2015) in nine steps.
const SEQUENTIAL: [[u8; 3]; 9] = [
    [0x44, 0x01, 0x54],
    [0x47, 0x2D, 0x7B],
    [0x3B, 0x52, 0x8B],
    [0x2C, 0x72, 0x8E],
    [0x21, 0x91, 0x8C],
    [0x28, 0xAE, 0x80],
    [0x5E, 0xC9, 0x62],
    [0xAD, 0xDC, 0x30],
    [0xFD, 0xE7, 0x25],
];

/// From blue over white to red (ColorBrewer RdBu, Brewer 2003) in nine steps.
const DIVERGING: [[u8; 3]; 9] = [
    [0x21, 0x66, 0xAC],
    [0x43, 0x93, 0xC3],
    [0x92, 0xC5, 0xDE],
    [0xD1, 0xE5, 0xF0],
    [0xF7, 0xF7, 0xF7],
    [0xFD, 0xDB, 0xC7],
    [0xF4, 0xA5, 0x82],
    [0xD6, 0x60, 0x4D],
    [0xB2, 0x18, 0x2B],
];

/// A colour by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tone(u8);

impl Tone {
    pub(crate) const PAPER: Self = Self(COLOURS);
    pub(crate) const INK: Self = Self(COLOURS + 1);
    pub(crate) const GRAIN: Self = Self(COLOURS + 2);
    pub(crate) const HELD: Self = Self(COLOURS + 3);
    /// In the order of their numbers.
    const OTHERS: [[u8; 3]; 4] = [[255; 3], [20; 3], [205; 3], [120; 3]];

    /// One of the scale.
    pub(crate) fn colour(number: u8) -> Self {
        Self(number.min(COLOURS - 1))
    }
}

pub(crate) struct Raster {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Numbers of colours, row by row from above.
    pub(crate) pixels: Vec<u8>,
    /// Red, green and blue of each colour.
    pub(crate) palette: Vec<u8>,
}

/// The scale of colours in nine steps; `signed`: zero lies in the middle.
pub(crate) fn stops(signed: bool) -> &'static [[u8; 3]; 9] {
    if signed { &DIVERGING } else { &SEQUENTIAL }
}

impl Raster {
    /// An empty one; `signed`: zero lies in the middle of the colours.
    pub(crate) fn new(width: usize, height: usize, signed: bool) -> Self {
        let stops = stops(signed);
        let mut palette = Vec::new();
        for number in 0..COLOURS {
            let along = f64::from(number) / f64::from(COLOURS - 1) * (stops.len() - 1) as f64;
            let first = (along as usize).min(stops.len() - 2);
            let part = along - first as f64;
            let mixed = |channel: usize| {
                let (from, to) = (f64::from(stops[first][channel]), f64::from(stops[first + 1][channel]));
                (from + part * (to - from)).round() as u8
            };
            palette.extend([mixed(0), mixed(1), mixed(2)]);
        }
        palette.extend(Tone::OTHERS.as_flattened());
        palette.resize(3 * 256, 255);
        Self { width, height, pixels: vec![Tone::PAPER.0; width * height], palette }
    }

    pub(crate) fn set(&mut self, column: usize, row: usize, tone: Tone) {
        if column < self.width && row < self.height {
            self.pixels[column + self.width * row] = tone.0;
        }
    }

    /// The same within margins to the left, above, to the right and below.
    pub(crate) fn within(self, [left, above, right, below]: [usize; 4]) -> Self {
        let (width, height) = (left + self.width + right, above + self.height + below);
        let mut whole = Self { width, height, pixels: vec![Tone::PAPER.0; width * height], ..self };
        for (row, line) in self.pixels.chunks(self.width).enumerate() {
            let start = left + width * (above + row);
            whole.pixels[start..start + self.width].copy_from_slice(line);
        }
        whole
    }

    /// A convex or other polygon, filled, with a thin line around it.
    pub(crate) fn polygon(&mut self, points: &[(f64, f64)], fill: Tone) {
        let edges = || points.iter().zip(points.iter().cycle().skip(1));
        let (low, high) = points
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, y)| (low.min(*y), high.max(*y)));
        let rows = low.max(0.0) as usize..(high.max(0.0).ceil() as usize).min(self.height);
        for row in rows {
            let y = row as f64 + 0.5;
            let crossing = |(from, to): (&(f64, f64), &(f64, f64))| {
                ((from.1 <= y) != (to.1 <= y))
                    .then(|| from.0 + (y - from.1) / (to.1 - from.1) * (to.0 - from.0))
            };
            let mut crossings: Vec<f64> = edges().filter_map(crossing).collect();
            crossings.sort_by(f64::total_cmp);
            for pair in crossings.as_chunks::<2>().0 {
                let columns =
                    (pair[0].max(0.0).round() as usize)..(pair[1].max(0.0).round() as usize).min(self.width);
                columns.for_each(|column| self.set(column, row, fill));
            }
        }
        for (from, to) in edges().filter(|_| high - low >= LEAST_OUTLINED) {
            let length = (to.0 - from.0).hypot(to.1 - from.1).ceil().clamp(1.0, 1e5) as usize;
            for step in 0..length {
                let part = step as f64 / length as f64;
                let (x, y) = (from.0 + part * (to.0 - from.0), from.1 + part * (to.1 - from.1));
                if x >= 0.0 && y >= 0.0 {
                    self.set(x as usize, y as usize, Tone::INK);
                }
            }
        }
    }

    /// Width of a text, pixels.
    pub(crate) fn wide(text: &str) -> usize {
        WIDE * text.chars().count()
    }

    /// Writes a text with its upper left corner at a place.
    pub(crate) fn text(&mut self, column: usize, row: usize, text: &str) {
        for (number, letter) in text.chars().enumerate() {
            let Some(lines) = font8x8::BASIC_FONTS.get(letter).or_else(|| font8x8::LATIN_FONTS.get(letter))
            else {
                continue;
            };
            for (k, i) in (0..HIGH).flat_map(|k| (0..WIDE).map(move |i| (k, i))) {
                if lines[k / 2] >> i & 1 == 1 {
                    self.set(column + WIDE * number + i, row + k, Tone::INK);
                }
            }
        }
    }

    pub(crate) fn png(&self) -> Result<Vec<u8>, String> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_palette(&self.palette);
        let mut writer = encoder.write_header().map_err(|error| error.to_string())?;
        writer.write_image_data(&self.pixels).map_err(|error| error.to_string())?;
        writer.finish().map_err(|error| error.to_string())?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polygon_fills_what_it_encloses_and_no_margin() {
        let mut raster = Raster::new(20, 12, false);
        raster.polygon(&[(2.0, 2.0), (10.0, 2.0), (10.0, 30.0), (2.0, 30.0)], Tone::GRAIN);
        let raster = raster.within([3, 1, 2, 8]);
        assert_eq!((raster.width, raster.height, raster.pixels.len()), (25, 21, 525));
        let at = |column: usize, row: usize| raster.pixels[3 + column + 25 * (1 + row)];
        assert_eq!(
            (at(5, 6), at(5, 11), at(5, 13), at(15, 6)),
            (Tone::GRAIN.0, Tone::GRAIN.0, Tone::PAPER.0, Tone::PAPER.0)
        );
        assert_eq!(at(2, 6), Tone::INK.0);
    }

    #[test]
    fn what_is_written_as_png_is_read_back() {
        let mut raster = Raster::new(64, 32, true);
        raster.text(0, 0, "t = 1");
        let bytes = raster.png().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(pixels, raster.pixels);
        assert!(raster.pixels.contains(&Tone::INK.0));
        // White lies in the middle of a scale with a sign.
        let middle = usize::from(COLOURS / 2) * 3;
        assert!(raster.palette[middle..middle + 3].iter().all(|channel| *channel > 240));
    }
}
