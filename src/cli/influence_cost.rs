//! `tyrewave influence SCENE --cost`: what the fit takes against elements, layers and threads.

use std::sync::atomic::AtomicBool;

use serde_json::{Value, json};
use tyrewave::numeric::StraightLine;
use tyrewave::results::plots::{Axis, LinePlot, Series};
use tyrewave::results::table::{aligned, grouped};
use tyrewave::scene::Tyre;
use tyrewave::tyre::poles::scaling::{FitCost, cost, cut};
use tyrewave::tyre::poles::{FitError, FitOptions};

use super::CliError;

/// Elements of the table.
const ELEMENTS: [usize; 5] = [512, 1024, 2048, 4096, 8192];
/// Parts that the innermost layer is cut into.
const PARTS: [usize; 4] = [1, 2, 4, 8];
/// Pairs of fits, one thread and all, of which the fastest count.
const PAIRS: usize = 3;

/// Everything that was timed.
pub struct CostReport {
    elements: Vec<FitCost>,
    layers: Vec<FitCost>,
    /// Wall time of one thread \[s\], number of threads, wall time of all \[s\].
    threads: (f64, usize, f64),
}

fn line(costs: &[FitCost], x: impl Fn(&FitCost) -> f64, y: impl Fn(&FitCost) -> f64) -> f64 {
    let points: Vec<_> = costs.iter().map(|cost| (x(cost), y(cost))).collect();
    StraightLine::power_law(&points).map_or(f64::NAN, |line| line.slope)
}

impl CostReport {
    /// Fits the tyre with every number of elements and layers, and with one thread beside all of the pool.
    ///
    /// # Errors
    /// [`FitError`] of the first fit that is refused, or stopped.
    pub fn new(tyre: &Tyre, options: &FitOptions, stop: &AtomicBool, tick: &mut dyn FnMut()) -> Result<Self, FitError> {
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

    /// For `influence.json`.
    pub fn to_json(&self) -> Value {
        json!({
            "elements": self.elements,
            "layers": self.layers,
            "one_thread_seconds": self.threads.0,
            "threads": self.threads.1,
            "seconds": self.threads.2,
            "parallel_efficiency": self.efficiency(),
        })
    }

    /// Two tables with their exponents, and the efficiency of the threads.
    pub fn table(&self) -> String {
        let mut text = String::new();
        for (title, costs, x) in [
            ("elements", &self.elements, (&|cost: &FitCost| cost.elements as f64) as &dyn Fn(&FitCost) -> f64),
            ("layers", &self.layers, &|cost: &FitCost| cost.layers as f64),
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
            let exponent = |y: &dyn Fn(&FitCost) -> f64| format!("{:.2}", line(costs, x, y));
            let mut rows: Vec<_> = costs.iter().map(row).collect();
            rows.push([
                "exponent".to_owned(),
                exponent(&|cost| cost.evaluations as f64),
                exponent(&|cost| cost.order as f64),
                exponent(&|cost| cost.seconds),
                String::new(),
            ]);
            text.push_str(&aligned(&[title, "evaluations", "poles", "time [s]", "time per evaluation [ns]"], &rows));
            text.push('\n');
        }
        let (alone, threads, together) = self.threads;
        text.push_str(&format!(
            "{alone:.2} s on one thread, {together:.2} s on {threads}: parallel efficiency {:.2}\n",
            self.efficiency()
        ));
        text
    }

    /// Evaluations and time over elements, relative to the first.
    pub fn plot(&self, title: &str) -> Result<String, CliError> {
        let over = |y: &dyn Fn(&FitCost) -> f64| -> Vec<(f64, f64)> {
            self.elements.iter().map(|cost| (cost.elements as f64, y(cost) / y(&self.elements[0]))).collect()
        };
        let time = over(&|cost| cost.seconds);
        let evaluations = over(&|cost| cost.evaluations as f64);
        let poles = over(&|cost| cost.order as f64);
        let name = |quantity: &str, y: &dyn Fn(&FitCost) -> f64| {
            format!("{quantity}, exponent {:.2}", line(&self.elements, |cost| cost.elements as f64, y))
        };
        let names = [
            name("time", &|cost| cost.seconds),
            name("compliance evaluations", &|cost| cost.evaluations as f64),
            name("poles", &|cost| cost.order as f64),
        ];
        let highest = time.iter().chain(&poles).chain(&evaluations).fold(2.0_f64, |a, point| a.max(point.1));
        let plot = LinePlot {
            title,
            x: Axis::logarithmic("Elements round the tyre", ELEMENTS[0] as f64..ELEMENTS[ELEMENTS.len() - 1] as f64),
            y: Axis::logarithmic("Relative to the fewest elements [1]", 0.8..1.2 * highest),
            series: vec![
                Series { name: &names[0], points: time },
                Series { name: &names[1], points: evaluations },
                Series { name: &names[2], points: poles },
            ],
        };
        Ok(plot.to_svg()?)
    }
}
