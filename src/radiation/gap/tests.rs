//! The gap equation against closed forms, its symmetry and its power; grooves through a tyre's patch against fields in
//! three dimensions, and the sheet of a sealed tyre against boundary elements.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;

use super::GapAir;
use super::patch::{GapChannel, PatchSheet, RoughGap};
use super::resonance::Resonance;
use super::sheet::{Edge, Edges, Sheet, SheetDrive};
use crate::radiation::{
    MeshResolution, ParityBlock, RadiatingBody, SurfaceTransfer, TransferGrid, TransferProblem, Vector,
};

/// Air at 20 degrees.
pub(crate) const AIR: GapAir = GapAir { sound_speed: 343.2, viscosity: 1.506e-5, prandtl: 0.709, heat_ratio: 1.4 };
/// Air without losses.
const PERFECT: GapAir = GapAir { viscosity: 1e-30, ..AIR };
/// Density of the air \[kg/m^3\].
const DENSITY: f64 = 1.204;
/// Length 2 a of a patch \[m\].
const LENGTH: f64 = 0.108;

/// A duct of one cell across, whose height is that of each cell's middle, from 0 to [`LENGTH`].
fn duct(cells: usize, height: impl Fn(f64) -> f64) -> Sheet {
    let x: Vec<f64> = (0..=cells).map(|end| LENGTH * end as f64 / cells as f64).collect();
    let heights = x.windows(2).map(|ends| height(0.5 * (ends[0] + ends[1]))).collect();
    Sheet { x, y: vec![0.0, 0.01], heights }
}

const OPEN: Edges = [Edge::OPEN, Edge::OPEN, Edge::CLOSED, Edge::CLOSED];
const CLOSED_AT_ONE_END: Edges = [Edge::CLOSED, Edge::OPEN, Edge::CLOSED, Edge::CLOSED];

/// Frequency near an expected one at which the pressure in a cell, not in a node of the field, due to a source there is
/// infinite.
fn resonance(sheet: &Sheet, edges: &Edges, expected: f64) -> f64 {
    let inverse = |frequency: f64| {
        let cell = 2 * sheet.heights.len() / 7;
        let mut sources = vec![Complex64::ZERO; sheet.heights.len()];
        sources[cell] = Complex64::ONE;
        let drive = SheetDrive { sources, ..SheetDrive::default() };
        let field = sheet.factorise(&PERFECT, TAU * frequency, edges).unwrap().solve(&[drive]);
        field[0][cell].re.recip()
    };
    let (mut low, mut high) = (0.97 * expected, 1.03 * expected);
    let at_low = inverse(low);
    assert!(at_low * inverse(high) < 0.0, "no resonance near {expected} Hz");
    while high - low > 1e-9 * expected {
        let middle = 0.5 * (low + high);
        if inverse(middle) * at_low > 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[test]
fn a_closed_gap_resonates_where_pipes_do_with_order_2() {
    let half = 0.5 * LENGTH;
    let c = PERFECT.sound_speed;
    for (edges, known) in [
        (OPEN, [1.0, 2.0].map(|n| n * c / (4.0 * half))),
        (CLOSED_AT_ONE_END, [1.0, 3.0].map(|n| n * c / (8.0 * half))),
    ] {
        for known in known {
            let [coarse, fine] = [54, 108].map(|cells| resonance(&duct(cells, |_| 1e-3), &edges, known) / known - 1.0);
            assert!(coarse.abs() < 1e-3, "{known} Hz: {coarse:e}");
            let order = (coarse / fine).log2();
            assert!((order - 2.0).abs() < 0.05, "{known} Hz: order {order}, {coarse:e} {fine:e}");
        }
    }
}

#[test]
fn the_field_of_a_piston_with_losses_is_the_closed_form() {
    let (height, angular) = (0.3e-3, TAU * 900.0);
    let k = angular / AIR.sound_speed * (AIR.compression(height, angular) / AIR.flow(height, angular)).sqrt();
    let sheet = duct(54, |_| height);
    let factored = sheet.factorise(&AIR, angular, &OPEN).unwrap();
    // h F_v (p'' + k^2 p) = q.
    let q = -Complex64::I * angular * DENSITY;
    let piston = SheetDrive { sources: vec![q; 54], ..SheetDrive::default() };
    let one = vec![Complex64::ONE];
    let ends = SheetDrive { edges: [one.clone(), one, Vec::new(), Vec::new()], ..SheetDrive::default() };
    let fields = factored.solve(&[piston, ends]);
    let half = 0.5 * LENGTH;
    let still = q / (height * AIR.flow(height, angular) * k * k);
    let size = (still * (1.0 - 1.0 / (k * half).cos())).norm();
    for (cell, ends) in sheet.x.windows(2).enumerate() {
        let x = 0.5 * (ends[0] + ends[1]) - half;
        let weight = (k * x).cos() / (k * half).cos();
        assert!((fields[1][cell] / weight - 1.0).norm() < 1e-3, "{x}: {} {weight}", fields[1][cell]);
        let expected = still * (1.0 - weight);
        assert!((fields[0][cell] - expected).norm() < 1e-3 * size, "{x}: {} {expected}", fields[0][cell]);
    }
    // By reciprocity the weights of the ends' flow are the field of given ends: -h F_v p' of the piston's field at both
    // ends is minus the integral of q times the weights.
    let way = 0.5 * LENGTH / 54.0;
    let flow = -height * AIR.flow(height, angular) * (fields[0][0] + fields[0][53]) / way;
    let weighted: Complex64 = fields[1].iter().map(|weight| weight * q * (LENGTH / 54.0)).sum();
    assert!((flow / weighted - 1.0).norm() < 1e-10, "{flow} {weighted}");
}

#[test]
fn stepped_ducts_resonate_within_half_a_percent() {
    // Closed at 0: tan(k l) tan(k (L - l)) = S_open/S_closed, l the length of the closed part.
    for (ratio, part) in [(0.25, 0.5), (4.0, 0.5), (8.0, 2.0 / 9.0), (0.1, 1.0 / 3.0)] {
        let (near, far) = (part * LENGTH, (1.0 - part) * LENGTH);
        let (mut low, mut high) = (0.0, 0.5 * PI / near.max(far));
        for _ in 0..60 {
            let k = 0.5 * (low + high);
            if (k * near).tan() * (k * far).tan() < ratio { low = k } else { high = k }
        }
        let known = low * PERFECT.sound_speed / TAU;
        let sheet = duct(54, |x| if x < near { 1e-3 } else { ratio * 1e-3 });
        let found = resonance(&sheet, &CLOSED_AT_ONE_END, known) / known - 1.0;
        assert!(found.abs() < 5e-3, "{ratio}, {part}: {found:e}");
    }
}

fn tyre(patch: f64) -> RadiatingBody {
    RadiatingBody::standing_tyre(1.95 / TAU, 0.176, 0.02, 0.5 * patch).unwrap()
}

const GRID: TransferGrid = TransferGrid { around: 512, across: 4 };

/// Two grooves that are not mirror images of each other.
const CHANNELS: [GapChannel; 2] = [
    GapChannel { position: -0.02, width: 0.012, depth: 0.008 },
    GapChannel { position: 0.03, width: 0.006, depth: 0.005 },
];

fn sheet_of(patch: f64, channels: &[GapChannel]) -> PatchSheet {
    PatchSheet::new(&tyre(patch), GRID, channels, None).unwrap()
}

#[test]
fn source_and_receiver_in_the_gap_may_be_exchanged() {
    let frequency = 1100.0;
    let patch = sheet_of(0.108, &CHANNELS);
    let [along, across] = patch.sheet.cells();
    let open: Vec<usize> = (0..along * across).filter(|&cell| patch.sheet.heights[cell] > 0.0).collect();
    let places = [open[3], open[open.len() / 2], open[open.len() / 2 + 7], open[open.len() - 40]];
    let area = |cell: usize| {
        let (i, j) = (cell / across, cell % across);
        (patch.sheet.x[i + 1] - patch.sheet.x[i]) * (patch.sheet.y[j + 1] - patch.sheet.y[j])
    };
    let drives: Vec<SheetDrive> = places
        .iter()
        .map(|&cell| {
            let mut sources = vec![Complex64::ZERO; along * across];
            sources[cell] = Complex64::new(1.0 / area(cell), 0.0);
            SheetDrive { sources, ..SheetDrive::default() }
        })
        .collect();
    let wavenumber = TAU * frequency / AIR.sound_speed;
    let factored = patch.sheet.factorise(&AIR, TAU * frequency, &patch.edges(wavenumber)).unwrap();
    let fields = factored.solve(&drives);
    for one in 0..places.len() {
        for other in 0..one {
            let [there, back] = [fields[one][places[other]], fields[other][places[one]]];
            assert!((there - back).norm() < 1e-10 * there.norm(), "{one} {other}: {there} {back}");
            assert!(there.norm() > 0.0);
        }
    }
}

#[test]
fn points_in_a_groove_and_sources_are_reciprocal() {
    let patch = sheet_of(0.108, &CHANNELS);
    let factored = patch.factorise(&AIR, TAU * 1100.0 / AIR.sound_speed).unwrap();
    let [along, across] = patch.sheet.cells();
    let edges = patch.edges(TAU * 1100.0 / AIR.sound_speed);
    let plain = patch.sheet.factorise(&AIR, TAU * 1100.0, &edges).unwrap();
    for GapChannel { position, .. } in CHANNELS {
        let by_reciprocity = factored.sourced_in_middle(position);
        for cell in [3, along / 2 * across + across / 3, along * across - 5] {
            // A unit volume source: div(h F grad G) + ... = -1 over its cell.
            let mut sources = vec![Complex64::ZERO; along * across];
            sources[cell] = Complex64::new(-1.0 / plain.area(cell), 0.0);
            let field = plain.solve(&[SheetDrive { sources, ..SheetDrive::default() }]).remove(0);
            let there = patch.in_middle(&field, position);
            let expected = by_reciprocity[cell];
            assert!((there - expected).norm() <= 1e-9 * there.norm(), "{position} {cell}: {there} {expected}");
        }
        assert!(patch.in_middle(&by_reciprocity, position).norm() > 0.0);
    }
}

#[test]
fn power_that_comes_in_goes_out_or_is_lost() {
    let frequency = 1100.0;
    let (angular, wavenumber) = (TAU * frequency, TAU * frequency / AIR.sound_speed);
    let patch = sheet_of(0.108, &CHANNELS);
    let (sheet, edges) = (&patch.sheet, patch.edges(wavenumber));
    let across = sheet.cells()[1];
    let driven = vec![Complex64::new(1.0, 0.3); across];
    let drive = SheetDrive { edges: [driven.clone(), Vec::new(), Vec::new(), Vec::new()], ..SheetDrive::default() };
    let field = sheet.factorise(&AIR, angular, &edges).unwrap().solve(&[drive]).remove(0);
    // Volume velocity -h F_v grad p/(i w rho).
    let velocity = |flow: Complex64| -flow / (Complex64::I * angular * DENSITY);
    let (mut through, mut lost) = ([0.0; 4], [0.0; 2]);
    for (edge, condition) in edges.iter().enumerate() {
        for (place, cell, [drive, feedback]) in sheet.on_edge(&AIR, angular, edge, condition) {
            let given = if edge == 0 { driven[place] } else { Complex64::ZERO };
            // The flow h F_v dp/dn dl, and the pressure on the edge, half a cell away.
            let flow = drive * given - feedback * field[cell];
            let (i, j) = (cell / across, cell % across);
            let [dx, dy] = [sheet.x[i + 1] - sheet.x[i], sheet.y[j + 1] - sheet.y[j]];
            let (way, length) = if edge < 2 { (dx, dy) } else { (dy, dx) };
            let height = sheet.heights[cell];
            let conductance = height * AIR.flow(height, angular) * (2.0 * length / way);
            let there = field[cell] + flow / conductance;
            through[edge] += 0.5 * (there.conj() * velocity(flow)).re;
            lost[0] += 0.5 * ((there - field[cell]).conj() * -velocity(flow)).re;
        }
    }
    for (one, other, flow) in sheet.faces(&AIR, angular) {
        let fall = field[one] - field[other];
        lost[0] += 0.5 * (fall.conj() * velocity(-flow * fall)).re;
    }
    for (cell, pressure) in field.iter().enumerate().filter(|(cell, _)| sheet.heights[*cell] > 0.0) {
        let storage = sheet.storage(&AIR, angular, cell / across, cell % across);
        lost[1] += -0.5 * (storage / (Complex64::I * angular * DENSITY)).re * pressure.norm_sqr();
    }
    let incoming = -through[0];
    let outgoing = through[1] + through[2] + through[3];
    assert!(incoming > 0.0 && through[1] > 0.0 && lost[0] > 0.0 && lost[1] > 0.0, "{through:?} {lost:?}");
    assert!((incoming - outgoing - lost[0] - lost[1]).abs() < 1e-8 * incoming, "{through:?} {lost:?}");
    // The losses are not just rounding.
    assert!(lost[0] + lost[1] > 0.01 * incoming, "{through:?} {lost:?}");
}

/// Resonance in the middle of a groove that the field before and behind the tyre drives in phase.
fn groove(patch: f64, width: f64, depth: f64) -> Resonance {
    let channels = [GapChannel { position: 0.0, width, depth }];
    let sheet = sheet_of(patch, &channels);
    let response = (0..41).map(|step| 700.0 + 20.0 * f64::from(step)).map(|frequency| {
        let wavenumber = TAU * frequency / AIR.sound_speed;
        let factored = sheet.factorise(&AIR, wavenumber).unwrap();
        (frequency, sheet.in_middle(&factored.between_equal_ends(), 0.0).norm())
    });
    Resonance::of(&response.collect::<Vec<_>>()).unwrap()
}

#[test]
fn grooves_in_the_horn_resonate_as_in_three_dimensions() {
    // Finite differences in time of the field in three dimensions: patch, width and depth \[m\], frequency \[Hz\].
    let known = [
        (0.108, 0.012, 0.008, 1048.0),
        (0.098, 0.012, 0.008, 1070.0),
        (0.118, 0.012, 0.008, 1012.0),
        (0.108, 0.012, 0.004, 1227.0),
        (0.108, 0.006, 0.008, 1209.0),
    ];
    for (patch, width, depth, frequency) in known {
        let found = groove(patch, width, depth);
        println!("{patch} {width} {depth}: {found:?}, {:+.1} %", 100.0 * (found.frequency / frequency - 1.0));
        assert!((found.frequency / frequency - 1.0).abs() < 0.1, "{patch} {width} {depth}: {found:?}");
    }
    let found = groove(0.108, 0.012, 0.008);
    // It is 11 to 16 in those fields.
    assert!(found.quality > 11.0 / 2.0 && found.quality < 16.0 * 2.0, "{found:?}");
    // A pipe with flanged ends: c/2 over L + 2 x 0.82 sqrt(S/pi).
    let flanged = 0.5 * AIR.sound_speed / (0.108 + 2.0 * 0.82 * (0.012 * 0.008 / PI).sqrt());
    assert!((flanged / 1048.0 - 1.4).abs() < 0.01, "{flanged} Hz");
    assert!(flanged / found.frequency > 1.25, "{flanged} Hz, {found:?}");
}

/// Far and near beside the tyre, and in the wheel's plane.
const RECEIVERS: [Vector; 3] = [[0.0, 7.5, 1.2], [0.2, 0.32, 0.1], [2.0, 0.3, 0.2]];

fn transfers(body: &RadiatingBody, frequency: f64) -> Vec<SurfaceTransfer> {
    let problem = TransferProblem {
        body,
        receivers: &RECEIVERS,
        grid: GRID,
        flank: None,
        resolution: MeshResolution::of(6.0),
        blocks: &ParityBlock::ALL,
        memory_limit: 1 << 31,
    };
    problem.solve(TAU * frequency / AIR.sound_speed).unwrap().0
}

/// Largest difference in level between the sheet's field and G within the sheet of a sealed tyre, averaged over the
/// width \[dB\].
fn off_boundary_elements(frequency: f64) -> f64 {
    let body = tyre(0.108);
    let transfers = transfers(&body, frequency);
    let patch = sheet_of(0.108, &[]);
    let fields = patch.factorise(&AIR, TAU * frequency / AIR.sound_speed).unwrap().solve(&transfers);
    let mut worst: f64 = 0.0;
    for (transfer, field) in transfers.iter().zip(&fields) {
        let (known, found) = (patch.outside(transfer), patch.on_grid(field));
        let across = patch.sheet.cells()[1];
        for (known, found) in known.chunks_exact(across).zip(found.chunks_exact(across)) {
            let square = |row: &[Complex64]| row.iter().map(Complex64::norm_sqr).sum::<f64>();
            if square(known) > 0.0 {
                let off = 10.0 * (square(found) / square(known)).log10();
                worst = worst.max(off.abs());
            }
        }
    }
    worst
}

#[test]
fn the_sheet_of_a_sealed_tyre_agrees_with_boundary_elements() {
    for frequency in [400.0, 1600.0] {
        let off = off_boundary_elements(frequency);
        println!("{frequency} Hz: {off:.3} dB");
        assert!(off < 1.0, "{frequency} Hz: {off} dB");
    }
}

#[test]
fn a_groove_of_no_depth_changes_nothing() {
    let body = tyre(0.108);
    let frequency = 1000.0;
    let (transfers, wavenumber) = (transfers(&body, frequency), TAU * frequency / AIR.sound_speed);
    let solve = |depth: f64| {
        let patch = sheet_of(0.108, &[GapChannel { position: 0.0, width: 0.012, depth }]);
        let fields = patch.factorise(&AIR, wavenumber).unwrap().solve(&transfers);
        (patch, fields)
    };
    let [(patch, open), (_, closed), (_, none)] = [0.008, 1e-7, 0.0].map(solve);
    for ((open, closed), none) in open.iter().zip(&closed).zip(&none) {
        let largest = none.iter().map(|value| value.norm()).fold(0.0, f64::max);
        let [middle_open, middle_closed] = [open, closed].map(|field| patch.in_middle(field, 0.0).norm());
        assert!(middle_open > 0.0 && middle_closed < 1e-12 * middle_open, "{middle_open} {middle_closed:e}");
        let beside = closed.iter().zip(none).filter(|(_, none)| none.norm() > 0.0);
        let off = beside.map(|(closed, none)| (closed - none).norm()).fold(0.0, f64::max);
        println!(
            "open {middle_open:.3}, closed {middle_closed:.1e}, largest of none {largest:.3} 1/m, off by {off:.1e}"
        );
        assert!(off < 1e-3 * largest, "{off:e} of {largest:e}");
    }
}

#[test]
fn a_gap_given_by_cells_is_that_of_its_channels() {
    let channel = CHANNELS[0];
    let known = sheet_of(LENGTH, &[channel]);
    let ends = known.sheet.y.clone();
    let rough = |channels: &[GapChannel], height: &dyn Fn(f64, f64) -> Option<f64>| {
        PatchSheet::new(&tyre(LENGTH), GRID, channels, Some(&RoughGap { ends: &ends, height })).unwrap()
    };
    assert_eq!(rough(&[channel], &|_, _| None), known);
    let is_under = |x: f64| x.abs() < 0.5 * LENGTH - 1e-9;
    // The groove is given by heights, without a channel.
    let place = |ends: &[f64], at: f64| ends.partition_point(|end| *end <= at) - 1;
    let reported = rough(&[], &|x, y| {
        let Sheet { x: columns, y: strips, heights } = &known.sheet;
        Some(heights[place(columns, x) * (strips.len() - 1) + place(strips, y)])
    });
    let field = |sheet: &PatchSheet| {
        let factored = sheet.factorise(&AIR, TAU * 900.0 / AIR.sound_speed).unwrap();
        sheet.on_grid(&factored.between_equal_ends())
    };
    let (one, other) = (field(&known), field(&reported));
    let [one, other] = [&one, &other].map(|field| known.in_middle(field, channel.position).norm());
    println!("in the middle of the groove {one} and {other}");
    assert!((other / one - 1.0).abs() < 1e-9, "{one} {other}");
    let pocket = |x: f64, y: f64| if x.abs() < 0.01 && (y + 0.02).abs() < 0.01 { 3e-3 } else { 0.0 };
    let closed = rough(&[], &|x, y| is_under(x).then(|| pocket(x, y)));
    let found = field(&closed);
    assert!(closed.in_middle(&found, -0.02).norm() <= 0.0);
    let (open, all) =
        closed.within(&found).fold((0.0, 0.0), |(open, all), (value, area)| (open + value.norm() * area, all + area));
    assert!(open <= 0.0 && all > 0.0);
}
