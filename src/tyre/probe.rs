//! probe
#[cfg(test)]
mod tests {
    use crate::tyre::influence::*; use crate::scene::*; use num_complex::Complex64;
    fn tyre() -> Tyre { toml::from_str(r#"
circumference = 1.95
width = 0.2
contact_width = 0.12
foundation = { normal = 1.8e6, tangential = 1e6, loss_factor = 0.1 }
[[layers]]
name = "belt"
thickness = 0.006
tension = [6e4, 2e4]
material = { law = "power-law", modulus = 5e8, poisson = 0.3, density = 1300, loss_factor = 0.08 }
[[layers]]
name = "tread"
thickness = 0.013
material = { law = "power-law", modulus = 8e6, poisson = 0.49, density = 1150, loss_factor = 0.25 }
"#).unwrap() }
    #[test] fn probe() {
        let n = 512; let dx = 1.95/n as f64; let dt = dx/(80.0/3.6);
        let num = Numerics { elements: n, influence_tolerance: 1e-8, ..Default::default() };
        let t0 = std::time::Instant::now();
        let sum = InfluenceSum::new(&tyre(), &num, 4.0/dt);
        println!("moments {:?}", t0.elapsed());
        let reference = InfluenceSum::with(&tyre(), Projection::new(&tyre(), n), Truncation::Bounded, 1e-5, 4.0/dt);
        for s in [Complex64::new(0.0,0.0), Complex64::new(1.5/dt,0.0), Complex64::new(10.0, 600.0), Complex64::new(1.0,2.0/dt), Complex64::new(4.0/dt,0.0)] {
            let (a, b) = (sum.at(s), reference.at(s));
            for w in [0usize, 1, 20, 100, 200] {
                let (x, y) = (sum.value(w, &a, Field::Surface), reference.value(w, &b, Field::Surface));
                println!("{s} n {w}: {:.6e} {} {} rel {:.1e} omitted {:.1e} ", x.value, x.evaluations, y.evaluations, (x.value-y.value).norm()/y.value.norm(), y.omitted/y.value.norm());
            }
        }
    }
}
