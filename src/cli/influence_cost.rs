//! `tyrewave influence SCENE --cost`: time of the fit over elements, layers and threads.

use std::sync::atomic::AtomicBool;

use crate::numeric::StraightLine;
use crate::results::plots::{Axis, LinePlot, Series};
use crate::results::table::{Report, aligned, grouped};
use crate::scene::Tyre;
use crate::tyre::poles::scaling::{FitCost, cost, cut};
use crate::tyre::poles::{FitError, FitOptions};
use serde_json::{Value, json};

const ELEMENTS: [usize; 5] = [512, 1024, 2048, 4096, 8192];
/// Numbers of parts that the innermost layer is cut into.
const PARTS: [usize; 4] = [1, 2, 4, 8];
/// Pairs of fits, on one thread and on all; the fastest of each count.
const PAIRS: usize = 3;

/// One quantity of a fit's cost.
type Measure = fn(&FitCost) -> f64;

/// Quantities in the picture, in its order.
const QUANTITIES: [(&str, Measure); 3] = [
    ("time", |cost| cost.seconds),
    ("compliance evaluations", |cost| cost.evaluations as f64),
    ("poles", |cost| cost.order as f64),
];

/// Costs of all fits.
pub(super) struct CostReport {
    elements: Vec<FitCost>,
    layers: Vec<FitCost>,
    /// Wall time on one thread \[s\], number of threads, wall time on all \[s\].
    threads: (f64, usize, f64),
}

fn line(costs: &[FitCost], x: impl Fn(&FitCost) -> f64, y: impl Fn(&FitCost) -> f64) -> f64 {
    let points: Vec<_> = costs.iter().map(|cost| (x(cost), y(cost))).collect();
    StraightLine::power_law(&points).map_or(f64::NAN, |line| line.slope)
}

impl CostReport {
    /// Fits the tyre with every number of elements and layers, and on one thread beside all of the pool; fails with the
    /// first fit that is refused, or stopped. `tick` is called before each fit, except those on one thread.
    pub(super) fn new(
        tyre: &Tyre,
        options: &FitOptions,
        stop: &AtomicBool,
        tick: &mut dyn FnMut(),
    ) -> Result<Self, FitError> {
        let mut of = |tyre: &Tyre, elements: usize| {
            tick();
            cost(tyre, &FitOptions { elements, ..*options }, stop)
        };
        let elements = ELEMENTS.iter().map(|&n| of(tyre, n)).collect::<Result<_, _>>()?;
        let layers = PARTS.iter().map(|&parts| of(&cut(tyre, parts), ELEMENTS[0])).collect::<Result<_, _>>()?;
        let threads = rayon::current_num_threads();
        let (mut alone, mut together) = (f64::INFINITY, f64::INFINITY);
        if let Ok(single) = rayon::ThreadPoolBuilder::new().num_threads(1).build() {
            for _ in 0..PAIRS {
                alone = alone.min(single.install(|| cost(tyre, options, stop))?.seconds);
                together = together.min(of(tyre, options.elements)?.seconds);
            }
        }
        Ok(Self { elements, layers, threads: (alone, threads, together) })
    }

    fn efficiency(&self) -> f64 {
        let (alone, threads, together) = self.threads;
        alone / (together * threads as f64)
    }

    /// Content of `influence.json`.
    pub(super) fn to_json(&self) -> Value {
        json!({
            "elements": self.elements,
            "layers": self.layers,
            "one_thread_seconds": self.threads.0,
            "threads": self.threads.1,
            "seconds": self.threads.2,
            "parallel_efficiency": self.efficiency(),
        })
    }

    /// Two tables with their exponents, and the parallel efficiency.
    pub(super) fn report(&self) -> Report {
        let mut report = Report::default();
        for (title, costs, x) in [
            ("elements", &self.elements, (|cost| cost.elements as f64) as Measure),
            ("layers", &self.layers, |cost| cost.layers as f64),
        ] {
            let row = |cost: &FitCost| {
                [
                    format!("{}", x(cost)),
                    grouped(cost.evaluations),
                    grouped(cost.order as u64),
                    format!("{:.2}", cost.seconds),
                    format!("{:.0}", 1e9 * cost.seconds / cost.evaluations as f64),
                ]
            };
            let mut rows: Vec<_> = costs.iter().map(row).collect();
            let exponent = |(_, y): (&str, Measure)| format!("{:.2}", line(costs, x, y));
            let [time, evaluations, poles] = QUANTITIES.map(exponent);
            rows.push(["exponent".to_owned(), evaluations, poles, time, String::new()]);
            report.table(aligned([title, "evaluations", "poles", "time [s]", "time per evaluation [ns]"], rows));
            report.text("\n");
        }
        let (alone, threads, together) = self.threads;
        report.text(format!(
            "{alone:.2} s on one thread, {together:.2} s on {threads}: parallel efficiency {:.2}\n",
            self.efficiency()
        ));
        report
    }

    /// Cost over the number of elements, relative to the fewest.
    pub(super) fn plot(&self, title: &str) -> String {
        let x = |cost: &FitCost| cost.elements as f64;
        let curves = QUANTITIES.map(|(quantity, y)| {
            let points = self.elements.iter().map(|cost| (x(cost), y(cost) / y(&self.elements[0])));
            (format!("{quantity}, exponent {:.2}", line(&self.elements, x, y)), points.collect::<Vec<_>>())
        });
        let highest = curves.iter().flat_map(|(_, points)| points).fold(2.0_f64, |highest, point| highest.max(point.1));
        let plot = LinePlot {
            title,
            x: Axis::logarithmic("Elements round the tyre", ELEMENTS[0] as f64..ELEMENTS[ELEMENTS.len() - 1] as f64),
            y: Axis::logarithmic("Relative to the fewest elements [1]", 0.8..1.2 * highest),
            series: curves.iter().map(|(name, points)| Series { name, points: points.clone() }).collect(),
        };
        plot.to_svg()
    }
}
