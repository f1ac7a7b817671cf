//! The references: finite elements of the section.

use std::collections::BTreeMap;

use serde_json::Value;

use super::belt::Resolution;
use super::reference_models::{belt, complex, document, number, parity};

/// Errors of one case: of C over sqrt(C_ii C_jj), and of the strip.
struct CaseErrors {
    label: String,
    n: i64,
    waves: f64,
    strip: Option<f64>,
}

fn errors(resolution: Resolution) -> Vec<CaseErrors> {
    let document = document();
    let belts: BTreeMap<&String, _> =
        document["tyres"].as_object().unwrap().iter().map(|(name, tyre)| (name, belt(tyre, resolution))).collect();
    let case = |case: &Value| {
        let name = case["tyre"].as_str().unwrap();
        let (belt, tyre) = (&belts[&name.to_owned()], &document["tyres"][name]);
        let (n, s) = (case["n"].as_i64().unwrap(), complex(&case["s"]));
        let correction = belt.section(n, parity(&case["parity"])).at(s);
        let waves: Vec<usize> =
            case["waves"].as_array().unwrap().iter().map(|m| m.as_u64().unwrap() as usize).collect();
        let wanted = |i: usize, j: usize| complex(&case["C_waves"][i][j]);
        let mut largest = 0.0_f64;
        for (i, &m) in waves.iter().enumerate() {
            for (j, &other) in waves.iter().enumerate() {
                let found = correction.compliance(m, other).unwrap();
                let size = (wanted(i, i).norm() * wanted(j, j).norm()).sqrt();
                largest = largest.max((found - wanted(i, j)).norm() / size);
            }
        }
        let strip = case.get("H_strip").map(|wanted| {
            let wanted = complex(wanted);
            (belt.strip(n, s, number(&tyre["bc"])) - wanted).norm() / wanted.norm()
        });
        let label = format!("{name}, n = {n}, s = {s}, {}", case["parity"]);
        CaseErrors { label, n, waves: largest, strip }
    };
    document["cases"].as_array().unwrap().iter().map(case).collect()
}

/// Bounds of waves and strip at n = 0 and elsewhere.
fn check(resolution: Resolution, bounds: [[f64; 2]; 2]) {
    let found = errors(resolution);
    assert_eq!(found.len(), 28);
    let mut worst = [[0.0_f64; 2]; 2];
    for CaseErrors { label, n, waves, strip } in &found {
        println!("{label}: waves {waves:.1e}, strip {:.1e}", strip.unwrap_or(0.0));
        let worst = &mut worst[usize::from(*n != 0)];
        *worst = [worst[0].max(*waves), worst[1].max(strip.unwrap_or(0.0))];
    }
    println!("worst of waves and strip, n = 0: {:?}, elsewhere: {:?}", worst[0], worst[1]);
    for (worst, bounds) in worst.iter().zip(bounds) {
        assert!(worst.iter().zip(bounds).all(|(&worst, bound)| worst < bound), "{worst:?} over {bounds:?}");
    }
}

#[test]
fn waves_and_strips_are_the_references() {
    check(Resolution::RUN, [[3e-3, 1e-3], [3e-3, 2e-3]]);
}

#[test]
fn a_finer_section_is_closer_to_the_references() {
    check(Resolution::FINE, [[1e-3, 5e-4], [1e-3, 1e-3]]);
}
