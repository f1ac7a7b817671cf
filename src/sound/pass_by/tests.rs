//! Pass-bys of monopoles against the closed form of a moving one.

use std::f64::consts::TAU;

use super::*;
use crate::sound::detector::meter_levels;
use crate::sound::{CoastByLine, Detector, FrequencyWeighting, TimeWeighting};

const SOUND: f64 = 343.2;
const SPEED: f64 = 110.0 / 3.6;

fn passage(receivers: usize) -> Passage {
    Passage {
        receivers: CoastByLine { receivers, ..CoastByLine::default() }.positions(),
        speed: SPEED,
        sound_speed: SOUND,
        input_rate: 5800.0,
        output_rate: 48_000.0,
        amplification: true,
    }
}

fn distance(source: Position, point: Position) -> f64 {
    source.iter().zip(point).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Cosine and sine of a tone from a monopole in the tyre's frame at the microphone, 1 Pa at 1 m: two pass-bys, a
/// quarter of a period apart.
fn received(pass_by: &PassBy, frequency: f64, source: Position) -> Vec<[f64; 2]> {
    let tone = |shift: f64| {
        let pressure = |receiver: usize, needed: Range<i64>| -> Vec<f64> {
            let r = distance(source, pass_by.passage.receivers[receiver]);
            // The transformation's time at the source: sound of sources ahead is early.
            let delay = (r - SPEED / SOUND * source[0]) / SOUND;
            let at = |n: i64| n as f64 / pass_by.passage.input_rate - delay;
            needed.map(|n| (TAU * frequency * at(n) - shift).cos() / r).collect()
        };
        pass_by.synthesise(pressure).unwrap()
    };
    tone(0.0).into_iter().zip(tone(0.25 * TAU)).map(|(cosine, sine)| [cosine, sine]).collect()
}

/// The same for a monopole that really moves, from its potential q(tau)/(4 pi R), whose time derivative is q'(tau)/(R
/// (1 - M cos)) + q c (M cos - M^2)/(R^2 (1 - M cos)): far field and near field (Morse and Ingard, 11.2). q' = 4 pi
/// cos(omega tau).
fn exact(pass_by: &PassBy, frequency: f64, source: Position, sample: usize) -> [f64; 2] {
    let mach = SPEED / SOUND;
    let [_, y, z] = pass_by.passage.receivers[0];
    let aside = (y - source[1]).hypot(z - source[2]);
    let x = pass_by.place(sample) - source[0];
    let shortened = (x * x + (1.0 - mach * mach) * aside * aside).sqrt();
    let r = (shortened + mach * x) / (1.0 - mach * mach);
    let towards = mach * (x + mach * r) / r;
    let phase = TAU * frequency * (pass_by.time(sample) - r / SOUND);
    let far = 1.0 / (shortened * (1.0 - towards));
    let near = SOUND * (towards - mach * mach) / (shortened * shortened * (1.0 - towards)) / (TAU * frequency);
    [far * phase.cos() + near * phase.sin(), far * phase.sin() - near * phase.cos()]
}

fn size([cosine, sine]: [f64; 2]) -> f64 {
    cosine.hypot(sine)
}

fn decibels(ratio: f64) -> f64 {
    20.0 * ratio.log10()
}

#[test]
fn a_monopole_at_the_origin_sounds_as_the_closed_form() {
    let pass_by = PassBy::new(passage(81)).unwrap();
    assert!((pass_by.time(pass_by.samples() - 1) - pass_by.time(0) - 20.0 / SPEED).abs() < 1.0 / 48_000.0);
    for frequency in [100.0, 1000.0, 2500.0] {
        for (sample, found) in received(&pass_by, frequency, [0.0; 3]).into_iter().enumerate() {
            let exact = exact(&pass_by, frequency, [0.0; 3], sample);
            let off = size([found[0] - exact[0], found[1] - exact[1]]) / size(exact);
            // The near field that is left out, V/(omega r), and the interpolation.
            let near = 1.1 * SPEED / (TAU * frequency * pass_by.aside);
            assert!(off < near + 2e-5, "{frequency} Hz, sample {sample}: {off}");
            assert!(decibels(size(found) / size(exact)).abs() < 0.005);
        }
    }
}

#[test]
fn pitch_glides_by_the_doppler_ratio() {
    let frequency = 1000.0;
    let pass_by = PassBy::new(passage(81)).unwrap();
    let tone = received(&pass_by, frequency, [0.0; 3]);
    for sample in 0..tone.len() - 1 {
        let [[a, b], [c, d]] = [tone[sample], tone[sample + 1]];
        let turn = (a * d - b * c).atan2(a * c + b * d);
        let ratio = turn * 48_000.0 / (TAU * frequency);
        // 1/(1 - M cos) at the angle of emission, found by iteration of the retarded time rather than in closed form.
        let (mut emission, x_at) =
            (pass_by.time(sample) + 0.5 / 48_000.0, |time: f64| pass_by.place(0) - SPEED * (time - pass_by.time(0)));
        let received = emission;
        for _ in 0..30 {
            emission = received - x_at(emission).hypot(pass_by.aside) / SOUND;
        }
        let cosine = x_at(emission) / x_at(emission).hypot(pass_by.aside);
        let exact = 1.0 / (1.0 - SPEED / SOUND * cosine);
        assert!((ratio / exact - 1.0).abs() < 5e-5, "sample {sample}: {ratio}, exactly {exact}");
        assert!((pass_by.doppler_ratio(sample) / exact - 1.0).abs() < 1e-4);
    }
    assert!(pass_by.doppler_ratio(0) > 1.075 && pass_by.doppler_ratio(pass_by.samples() - 1) < 0.94);
}

#[test]
fn without_amplification_the_level_falls_with_the_distance_run() {
    let pass_by = PassBy::new(Passage { amplification: false, ..passage(81) }).unwrap();
    for (sample, found) in received(&pass_by, 1000.0, [0.0; 3]).into_iter().enumerate() {
        let (r, _) = pass_by.path(pass_by.place(sample));
        assert!(decibels(size(found) * r).abs() < 0.001, "sample {sample}");
    }
}

#[test]
fn sources_round_the_patch_interfere_as_moving_ones() {
    // Two monopoles and their images under the road: on either side of the tyre, and ahead and behind.
    let across = [[0.0, 0.1, 0.15], [0.0, -0.1, 0.05]];
    let along = [[0.1, 0.05, 0.05], [-0.1, -0.05, 0.05]];
    // Error of second order in M, which grows with the sources' distance along the travel.
    let second_order = |frequency: f64| 0.01 + (SPEED / SOUND).powi(2) * TAU * frequency / SOUND * 0.2;
    for (sources, receivers, frequency, bound) in [
        (across, 161, 2500.0, 0.02),
        (across, 81, 1000.0, 0.02),
        (across, 81, 2500.0, 0.02),
        (along, 81, 1000.0, second_order(1000.0)),
        (along, 81, 2500.0, second_order(2500.0)),
    ] {
        let pass_by = PassBy::new(Passage { output_rate: 12e3, ..passage(receivers) }).unwrap();
        let mut sums = vec![[[0.0; 2]; 2]; pass_by.samples()];
        for source in sources.iter().flat_map(|&[x, y, z]| [[x, y, z], [x, y, -z]]) {
            for (sample, found) in received(&pass_by, frequency, source).into_iter().enumerate() {
                let exact = exact(&pass_by, frequency, source, sample);
                for part in 0..2 {
                    sums[sample][0][part] += found[part];
                    sums[sample][1][part] += exact[part];
                }
            }
        }
        // Relative to four monopoles of any phase: in the minima of an interference no level is right.
        let worst = sums.iter().enumerate().map(|(sample, &[found, exact])| {
            let (r, _) = pass_by.path(pass_by.place(sample));
            (size(found) - size(exact)).abs() * r / 2.0
        });
        let worst = worst.fold(0.0, f64::max);
        assert!(worst < bound, "{sources:?}, {receivers} receivers, {frequency} Hz: {worst}");
    }
}

#[test]
fn a_meter_at_the_roadside_reads_what_the_closed_form_gives() {
    let (frequency, rate) = (1000.0, 48_000.0);
    let pass_by = PassBy::new(passage(81)).unwrap();
    let tone: Vec<f64> = received(&pass_by, frequency, [0.0; 3]).into_iter().map(|[cosine, _]| cosine).collect();
    let read = meter_levels(&tone, rate, FrequencyWeighting::A, TimeWeighting::Fast).unwrap();
    let mut detector = Detector::new(TimeWeighting::Fast, rate);
    let expected: Vec<f64> = (0..pass_by.samples())
        .map(|sample| {
            let weight = FrequencyWeighting::A.gain(frequency * pass_by.doppler_ratio(sample));
            detector.push(weight * size(exact(&pass_by, frequency, [0.0; 3], sample)) / 2.0_f64.sqrt());
            detector.level()
        })
        .collect();
    // From 30 ms on the detector's ripple at twice the frequency is small.
    for (sample, (read, expected)) in read.iter().zip(&expected).enumerate().skip(1440) {
        assert!((read - expected).abs() < 0.1, "sample {sample}: {read} dB(A), expected {expected}");
    }
    let (sample, highest) = pass_by.highest(&read, 10.0).unwrap();
    // 1/(sqrt(2) 7.595) Pa, less the detector's lag, and therefore a little past the microphone.
    assert!((72.0..73.4).contains(&highest), "{highest}");
    assert!((-5.0..0.0).contains(&pass_by.place(sample)), "{}", pass_by.place(sample));
    let (first, before) = pass_by.highest(&read[..9000], 6.0).unwrap();
    assert!((pass_by.place(first) - 10.0 + SPEED * 8999.0 / rate).abs() < 0.1 && before < highest);
    assert_eq!(pass_by.highest(&read[..9000], 3.0), None);
}

#[test]
fn nothing_jumps_from_one_receiver_to_the_next() {
    let pass_by = PassBy::new(passage(81)).unwrap();
    let frequency = 2000.0;
    let tone = received(&pass_by, frequency, [0.15, 0.1, 0.0]);
    let sizes: Vec<f64> = tone.iter().map(|&p| size(p)).collect();
    for (sample, pair) in sizes.windows(2).enumerate() {
        // The slope of 1/r at 13 m/s and 48 kHz, 3e-5 a sample at most, and the interpolation's ripple.
        assert!((pair[1] / pair[0] - 1.0).abs() < 1e-4, "sample {sample}");
    }
}

#[test]
fn one_point_at_a_time_is_the_same_as_all_at_once() {
    let pass_by = PassBy::new(passage(81)).unwrap();
    let longest = (0..81).map(|receiver| pass_by.needed(receiver)).map(|needed| needed.end - needed.start).max();
    // At most five spacings of 0.25 m: at 30 m/s and 5.8 kHz 237 samples, 8 % more by Doppler, and the kernel's width.
    assert!(longest.is_some_and(|longest| longest < 330), "{longest:?}");
    let noise = |receiver: usize, n: i64| ((n * 37 + receiver as i64 * 11) % 101) as f64 - 50.0;
    let whole = pass_by.synthesise(|receiver, needed| needed.map(|n| noise(receiver, n)).collect()).unwrap();
    let mut backwards = vec![0.0; pass_by.samples()];
    for receiver in (0..81).rev() {
        let excerpt: Vec<f64> = pass_by.needed(receiver).map(|n| noise(receiver, n)).collect();
        pass_by.add(receiver, &excerpt, &mut backwards).unwrap();
    }
    assert!(whole.iter().zip(&backwards).all(|(a, b)| (a - b).abs() < 1e-12));
    assert!(whole.iter().any(|p| p.abs() > 0.1));
    let short = pass_by.add(3, &[0.0; 5], &mut backwards);
    assert!(matches!(short, Err(PassByError::ExcerptLength { receiver: 3, given: 5, .. })));
}

#[test]
fn what_is_no_line_or_no_speed_is_refused() {
    let refused = |change: &dyn Fn(&mut Passage)| {
        let mut passage = passage(81);
        change(&mut passage);
        PassBy::new(passage).unwrap_err()
    };
    assert_eq!(refused(&|p| p.receivers.truncate(3)), PassByError::TooFewReceivers { given: 3 });
    assert_eq!(refused(&|p| p.receivers[5][1] += 0.01), PassByError::NotALine { receiver: 5 });
    assert_eq!(refused(&|p| p.receivers[7][0] = f64::NAN), PassByError::NotALine { receiver: 7 });
    assert!(matches!(refused(&|p| p.receivers.reverse()), PassByError::NotALine { .. }));
    for speed in [0.0, -20.0, 400.0, f64::NAN] {
        assert!(matches!(refused(&|p| p.speed = speed), PassByError::BadValue { quantity: "the speed", .. }));
    }
    for rate in [0.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(refused(&|p| p.input_rate = rate), PassByError::BadValue { .. }));
        assert!(matches!(refused(&|p| p.output_rate = rate), PassByError::BadValue { .. }));
    }
}
