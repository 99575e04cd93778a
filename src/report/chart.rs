//! Charts with logarithmic axes, as SVG.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint};
use plotters::prelude::*;

use crate::output::printf::format_g;

/// Size of a chart, and of the plot in it; the legend stands beside. Pixels.
const SIZE: (u32, u32) = (860, 480);
const PLOT_WIDTH: i32 = 610;
/// Rows of the legend, pixels.
const LEGEND_ROW: i32 = 27;
/// Space around the points, as a part of an axis.
const AROUND: f64 = 0.06;
/// Least length of an axis, decades.
const LEAST_DECADES: f64 = 0.6;

/// Colors that people with any color vision tell apart (M. Okabe and K. Ito, jfly.uni-koeln.de/color).
pub const COLORS: [RGBColor; 7] = [
    RGBColor(230, 159, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(213, 94, 0),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
];

/// How points look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    Dot,
    Triangle,
    Square,
    Cross,
    OpenDot,
    OpenTriangle,
    OpenSquare,
    /// A stroke through another mark.
    Struck,
    /// A circle around another mark.
    Ring,
    /// A square around another mark.
    Frame,
    /// A line alone.
    None,
}

impl Mark {
    /// The same form, open and larger, so that another mark shows inside.
    pub fn open(self) -> Self {
        match self {
            Self::Dot => Self::OpenDot,
            Self::Triangle => Self::OpenTriangle,
            Self::Square => Self::OpenSquare,
            other => other,
        }
    }
}

/// Points that belong together.
#[derive(Clone, Debug)]
pub struct Series {
    pub name: String,
    pub color: RGBColor,
    pub mark: Mark,
    /// Joined by a line.
    pub line: bool,
    /// Positive numbers; others are left out.
    pub points: Vec<(f64, f64)>,
}

/// A chart with two logarithmic axes.
#[derive(Clone, Debug)]
pub struct Chart {
    pub title: String,
    pub x: String,
    pub y: String,
    pub series: Vec<Series>,
}

impl Chart {
    /// Whether there is anything to draw.
    pub fn is_empty(&self) -> bool {
        self.series.iter().all(|series| logs(series).is_empty())
    }

    /// The chart as an SVG document.
    pub fn svg(&self) -> Result<String, String> {
        let mut text = String::new();
        self.draw(&mut text).map_err(|e| format!("a chart cannot be drawn: {e}"))?;
        Ok(text)
    }

    fn draw(&self, text: &mut String) -> Result<(), Box<dyn std::error::Error>> {
        let root = SVGBackend::with_string(text, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let (plot, legend) = root.split_horizontally(PLOT_WIDTH);
        let (x, y) = (self.range(|p| p.0), self.range(|p| p.1));
        let axis = |(from, to): (f64, f64)| Axis { from, to };
        let mut chart = ChartBuilder::on(&plot)
            .margin(12)
            .caption(&self.title, ("sans-serif", 18))
            .x_label_area_size(46)
            .y_label_area_size(84)
            .build_cartesian_2d(axis(x), axis(y))?;
        let label = |log: &f64| tick_label(*log);
        chart
            .configure_mesh()
            .x_desc(&self.x)
            .y_desc(&self.y)
            .x_label_formatter(&label)
            .y_label_formatter(&label)
            .axis_desc_style(("sans-serif", 15))
            .label_style(("sans-serif", 13))
            .bold_line_style(RGBColor(222, 222, 222))
            .light_line_style(TRANSPARENT)
            .draw()?;
        for series in &self.series {
            let points = logs(series);
            if series.line {
                chart.draw_series(LineSeries::new(points.iter().copied(), series.color.stroke_width(2)))?;
            }
            for point in points {
                let at = chart.backend_coord(&point);
                let area = chart.plotting_area().strip_coord_spec();
                let (left, top) = area.get_base_pixel();
                draw_mark(&area, (at.0 - left, at.1 - top), series)?;
            }
        }
        for (row, series) in self.series.iter().filter(|series| !logs(series).is_empty()).enumerate() {
            let y = 48 + LEGEND_ROW * row as i32;
            if series.line {
                let line = PathElement::new([(0, y), (24, y)], series.color.stroke_width(2));
                legend.draw(&line)?;
            }
            draw_mark(&legend, (12, y), series)?;
            legend.draw(&Text::new(series.name.clone(), (32, y - 7), ("sans-serif", 14)))?;
        }
        root.present()?;
        Ok(())
    }

    /// Both ends of an axis, as logarithms.
    fn range(&self, of: impl Fn(&(f64, f64)) -> f64) -> (f64, f64) {
        let all: Vec<f64> = self.series.iter().flat_map(logs).map(|p| of(&p)).collect();
        let least = all.iter().copied().fold(f64::INFINITY, f64::min);
        let most = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if all.is_empty() {
            return (0.0, 1.0);
        }
        let more = (0.5 * (LEAST_DECADES - (most - least))).max(AROUND * (most - least));
        (least - more, most + more)
    }
}

/// A logarithmic axis; its values are decimal logarithms.
struct Axis {
    from: f64,
    to: f64,
}

impl Ranged for Axis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (begin, end): (i32, i32)) -> i32 {
        begin + ((value - self.from) / (self.to - self.from) * f64::from(end - begin)).round() as i32
    }

    fn key_points<H: KeyPointHint>(&self, _: H) -> Vec<f64> {
        ticks(self.from, self.to)
    }

    fn range(&self) -> Range<f64> {
        self.from..self.to
    }
}

/// Decimal logarithms of the points that have some.
fn logs(series: &Series) -> Vec<(f64, f64)> {
    let positive = series.points.iter().filter(|(x, y)| *x > 0.0 && *y > 0.0 && x.is_finite() && y.is_finite());
    positive.map(|(x, y)| (x.log10(), y.log10())).collect()
}

fn draw_mark<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    at: (i32, i32),
    series: &Series,
) -> Result<(), Box<dyn std::error::Error>>
where
    DB::ErrorType: 'static,
{
    let (x, y) = at;
    let fill = series.color.filled();
    match series.mark {
        Mark::Dot => area.draw(&Circle::new(at, 5, fill))?,
        Mark::Triangle => area.draw(&TriangleMarker::new(at, 7, fill))?,
        Mark::Square => area.draw(&Rectangle::new([(x - 4, y - 4), (x + 5, y + 5)], fill))?,
        Mark::Cross => area.draw(&Cross::new(at, 5, series.color.stroke_width(2)))?,
        Mark::OpenDot => area.draw(&Circle::new(at, 8, series.color.stroke_width(2)))?,
        Mark::OpenTriangle => {
            let corners = [(x, y - 11), (x + 10, y + 7), (x - 10, y + 7), (x, y - 11)];
            area.draw(&PathElement::new(corners, series.color.stroke_width(2)))?;
        }
        Mark::OpenSquare => {
            area.draw(&Rectangle::new([(x - 8, y - 8), (x + 9, y + 9)], series.color.stroke_width(2)))?;
        }
        Mark::Struck => {
            area.draw(&PathElement::new([(x - 13, y + 13), (x + 13, y - 13)], series.color.stroke_width(2)))?;
        }
        Mark::Ring => area.draw(&Circle::new(at, 9, series.color.stroke_width(2)))?,
        Mark::Frame => {
            let style = series.color.stroke_width(2);
            area.draw(&Rectangle::new([(x - 12, y - 12), (x + 12, y + 12)], style))?;
        }
        Mark::None => {}
    }
    Ok(())
}

/// Where an axis has labels, as logarithms: at powers of ten, of all or some, or at 1, 2 and 5 where there is room.
fn ticks(from: f64, to: f64) -> Vec<f64> {
    let decades = to - from;
    let digits: &[f64] = match decades {
        d if d < 1.1 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
        d if d < 2.2 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let step = (decades / 8.0).ceil().max(1.0) as i32;
    let powers = (from.floor() as i32..=to.ceil() as i32).filter(|k| k.rem_euclid(step) == 0);
    let all = powers.flat_map(|k| digits.iter().map(move |digit| f64::from(k) + digit.log10()));
    all.filter(|log| (from..=to).contains(log)).collect()
}

/// A power of ten in as few letters as it takes.
fn tick_label(log: f64) -> String {
    let value = 10f64.powf(log);
    if (1e-3..1e4).contains(&(value * 1.000_001)) {
        format_g(value, 0, 4, false)
    } else {
        format!("{value:.1e}").replace(".0e", "e")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_round_numbers() {
        let labels = |from, to| ticks(from, to).into_iter().map(tick_label).collect::<Vec<_>>();
        assert_eq!(labels(-3.1, -1.9), ["0.001", "0.002", "0.005", "0.01"]);
        assert_eq!(labels(-5.1, -4.6), ["1e-5", "1.5e-5", "2e-5"]);
        assert_eq!(labels(-7.5, -3.5), ["1e-7", "1e-6", "1e-5", "1e-4"]);
        assert_eq!(labels(-0.1, 1.1), ["1", "2", "5", "10"]);
        assert!(labels(-20.0, 5.0).len() <= 9);
    }

    #[test]
    fn a_chart_is_an_svg_with_its_names() {
        let mark = |mark, points: &[(f64, f64)]| Series {
            name: format!("{mark:?} <&>"),
            color: COLORS[1],
            mark,
            line: mark == Mark::Dot,
            points: points.to_vec(),
        };
        let open = [Mark::OpenDot, Mark::OpenTriangle, Mark::OpenSquare, Mark::Struck, Mark::None];
        let all =
            [Mark::Dot, Mark::Triangle, Mark::Square, Mark::Cross, Mark::Ring, Mark::Frame].into_iter().chain(open);
        let series = all.map(|of| mark(of, &[(1.0, 1e-5), (2.0, 3e-4), (0.0, 1.0), (f64::NAN, 2.0)])).collect();
        let chart = Chart { title: "Title".into(), x: "time".into(), y: "error".into(), series };
        let svg = chart.svg().unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{svg}");
        for word in ["Title", "time", "error", "Dot &lt;&amp;&gt;", "Cross"] {
            assert!(svg.contains(word), "{word} is not in {svg}");
        }
        // Two of a mark and one in the legend; an open mark hides nothing.
        let open =
            svg.lines().filter(|line| line.starts_with("<circle") && line.contains("r=\"8\"")).collect::<Vec<_>>();
        assert!(open.len() == 3 && open.iter().all(|line| line.contains("fill=\"none\"")), "{open:?}");
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert!(!chart.is_empty() && Chart { series: vec![mark(Mark::Dot, &[(0.0, 1.0)])], ..chart }.is_empty());
    }
}
