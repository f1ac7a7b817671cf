//! Long rollouts: no drift, and memory that does not grow with the length.
#![cfg(target_os = "linux")]

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use tyrewave::internals::{scene_text, with_all_terms};

use crate::common::{mean_and_deviation, program, read_array, read_summary};

/// Resident memory of a process now, and its peak so far \[bytes\]; `None` once it has ended.
fn memory(process: u32) -> Option<[f64; 2]> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let field = |name: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(name))?;
        line.trim().strip_suffix(" kB")?.trim().parse::<f64>().ok().map(|kilobytes| 1024.0 * kilobytes)
    };
    Some([field("VmRSS:")?, field("VmHWM:")?])
}

/// A run with its memory as it went on.
struct Watched {
    folder: tempfile::TempDir,
    /// Share of the steps whose rows have been written, resident memory \[bytes\].
    samples: Vec<(f64, f64)>,
    /// Peak memory \[bytes\].
    peak: f64,
    wall: Duration,
}

impl Watched {
    fn of(scene: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("scene.toml"), scene).unwrap();
        let begin = Instant::now();
        // Quiet: the first of the lines that come every ten seconds takes 2 MiB, once.
        let mut run = Command::new(program())
            .args(["run", "scene.toml", "--out", "out", "--threads", "2", "--quiet"])
            .current_dir(folder.path())
            .stdout(Stdio::null())
            .stderr(Stdio::inherit())
            .spawn()
            .unwrap();
        let rows = folder.path().join(format!("out.partial-{}/patch_force.npy", run.id()));
        let (mut samples, mut peak) = (Vec::new(), 0.0);
        let status = loop {
            let done = fs::metadata(&rows).map_or(0.0, |file| file.len() as f64);
            if let Some([resident, highest]) = memory(run.id()) {
                samples.push((done, resident));
                peak = highest;
            }
            if let Some(status) = run.try_wait().unwrap() {
                break status;
            }
            sleep(Duration::from_millis(5));
        };
        assert!(status.success());
        let all = fs::metadata(folder.path().join("out/patch_force.npy")).unwrap().len() as f64;
        samples.iter_mut().for_each(|(done, _)| *done /= all);
        Self { folder, samples, peak, wall: begin.elapsed() }
    }

    fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    /// Largest resident memory while the share of the steps done was in a range \[bytes\].
    fn resident(&self, share: Range<f64>) -> f64 {
        let within: Vec<f64> =
            self.samples.iter().filter(|(done, _)| share.contains(done)).map(|(_, resident)| *resident).collect();
        assert!(!within.is_empty(), "no sample in {share:?}");
        within.into_iter().fold(0.0, f64::max)
    }

    /// How much the memory has grown from the second tenth of the steps to the last one \[bytes\].
    fn growth(&self) -> f64 {
        self.resident(0.85..1.0) - self.resident(0.05..0.2)
    }
}

fn force(out: &Path) -> Vec<f64> {
    read_array::<f64>(&out.join("total_force.npy")).1
}

/// A smooth road at 80 km/h and N = 64 by poles, for a number of steps.
fn smooth(steps: u64) -> (String, u64) {
    let time_step = tyrewave::internals::CIRCUMFERENCE / 64.0 / (80.0 / 3.6);
    let warm_up = 1000;
    let rolling = format!(
        "speed_kmh = 80.0\nwarm_up = {:?}\nduration = {:?}\naxle = {{ indentation = 0.012, ramp = 0.1 }}",
        warm_up as f64 * time_step,
        (steps - warm_up) as f64 * time_step
    );
    let text =
        scene_text(64, "kind = \"smooth\"", &rolling, "history = \"modal\"", "[outputs]\ncheckpoint_interval = 0.02");
    (text, steps)
}

#[test]
fn a_longer_run_takes_no_more_memory() {
    let (text, steps) = smooth(300_000);
    let watched = Watched::of(&text);
    assert_eq!(read_summary(&watched.out())["outcome"]["steps"], steps);
    let force = force(&watched.out());
    let (mean, deviation) = mean_and_deviation(&force[force.len() / 2..]);
    println!(
        "{steps} steps in {:?}: std/mean {:.1e}; memory grows by {:+.0} kB, peak {:.1} MB",
        watched.wall,
        deviation / mean,
        watched.growth() / 1e3,
        watched.peak / 1e6
    );
    assert!(deviation <= 1e-6 * mean, "{deviation} N of {mean} N");
    // Keeping one number a step would take 1.6 MB.
    assert!(watched.growth() < 0.5e6, "{} bytes", watched.growth());
}

#[test]
#[ignore = "10^6 steps: some seconds"]
fn a_million_steps_on_a_smooth_road_neither_drift_nor_grow() {
    let watched = Watched::of(&smooth(1_000_000).0);
    let force = force(&watched.out());
    let parts: Vec<(f64, f64)> = force[10_000..].chunks(99_000).map(mean_and_deviation).collect();
    let (first, last) = (parts[0].0, parts[parts.len() - 1].0);
    let worst = parts.iter().fold(0.0_f64, |worst, part| worst.max(part.1 / part.0));
    println!(
        "10^6 steps in {:?}: drift {:+.1e} of the mean, std/mean at most {worst:.1e}; memory grows by {:+.0} kB, peak \
         {:.1} MB",
        watched.wall,
        (last - first) / first,
        watched.growth() / 1e3,
        watched.peak / 1e6
    );
    assert!((last - first).abs() <= 1e-6 * first && worst <= 1e-6);
    // Keeping one number a step would take 6 MB.
    assert!(watched.growth() < 0.5e6, "{} bytes", watched.growth());
}

#[test]
#[ignore = "60 s of dense asphalt at N = 512: some minutes"]
fn sixty_seconds_at_130_complete_in_bounded_memory() {
    let rolling = "speed_kmh = 130.0\nwarm_up = 0.5\nduration = 60.0\naxle = { load = 3400.0 }";
    let text = with_all_terms(&scene_text(512, "kind = \"made\"\nseed = 1", rolling, "history = \"modal\"", ""));
    let watched = Watched::of(&text);
    let summary = read_summary(&watched.out());
    let residuals = ["tension", "penetration", "complementarity"].map(|key| summary["contact"][key].as_f64().unwrap());
    println!(
        "{} steps, 60.5 s in {:?} ({:.2} x real time); memory grows by {:+.1} MB, peak {:.1} MB; largest residual \
         {:.1e}; {}",
        summary["outcome"]["steps"],
        watched.wall,
        60.5 / watched.wall.as_secs_f64(),
        watched.growth() / 1e6,
        watched.peak / 1e6,
        residuals.iter().fold(0.0_f64, |a, &b| a.max(b)),
        summary["cost"]["counters"]
    );
    assert_eq!(summary["complete"], true);
    assert!(residuals.iter().all(|residual| *residual <= 1e-9));
    // The cache of factors fills up to its bound; nothing else grows.
    assert!(watched.peak < 0.5e9, "{} bytes", watched.peak);
}
