use fdem_fluid::*;

use crate::common::*;

/// A sheet upright in gravity, with apertures over three orders of magnitude, some cells full, some empty,
/// some dry, a pump and sometimes a hole at a pressure; steps over eight orders of magnitude. Shapes change
/// at each.
fn try_case(case: u32) -> Result<u32, String> {
    let number = |k: u32| random(1000 * case + k);
    let mut mesh = sheet(7, 0.6 * number(1), 1e-4);
    let power = |low: f64, high: f64, part: f64| 10.0_f64.powf(low + (high - low) * part);
    for (k, cell) in mesh.cells.iter_mut().enumerate() {
        let part = number(100 + k as u32);
        cell.initial_pressure = (part < 0.4).then(|| 1e6 * part * number(2));
        cell.leak_off = if number(3) < 0.5 { 0.0 } else { 1e-6 };
    }
    let gravity = [0.0, -9.81 * f64::from(number(4) < 0.7), 0.0];
    let model = FlowModel { gravity, ..FlowModel::new(liquid(power(7.0, 10.0, number(5)))) };
    let rate = power(-10.0, -6.0, number(6)) * if number(7) < 0.8 { 1.0 } else { -1.0 };
    let mut sources = vec![pumped(1, &[(98.0 * number(8)) as u64], rate)];
    if number(9) < 0.4 {
        let hole = Source { volume: 1e-6 * number(10), ..held(2, &[97], 1e6 * number(11)) };
        sources.extend((sources[0].cells[0] != 97).then_some(hole));
    }
    let mut network: Option<Network<3>> = None;
    let mut solutions = 0;
    for step in 0..12 {
        let shapes: Vec<Shape<3>> = (0..mesh.shapes.len() as u32)
            .map(|k| {
                let opening = power(-5.0, -2.0, number(300 + k)) * (1.0 + 0.1 * number(300 * step + k));
                let is_wet =
                    number(700 + k) < 0.9 || [98.0 * number(8), 97.0].map(|at| at as u32).contains(&k);
                let compliance = if number(12) < 0.5 { 0.0 } else { 1e-12 };
                Shape { opening, compliance, is_wet, ..mesh.shapes[k as usize] }
            })
            .collect();
        let network = match &mut network {
            Some(network) => network,
            empty => empty.insert(
                Network::new(model, sources.clone(), &mesh.cells, &shapes)
                    .map_err(|error| error.to_string())?,
            ),
        };
        network.update(&shapes).map_err(|error| error.to_string())?;
        let length = power(-5.0, 3.0, number(20 + step));
        let report = network.advance(length).map_err(|error| format!("step {step}: {error}"))?;
        solutions += report.solutions;
        let balance = network.balance();
        let size = balance.initial + balance.injected.abs() + balance.stored + balance.leaked;
        if balance.error().abs() > 1e-12 * size {
            return Err(format!("{balance:?}"));
        }
        if !(network.masses().iter().all(|of| *of >= 0.0) && network.pressures().iter().all(|of| *of >= 0.0))
        {
            return Err("a mass or a pressure is negative".to_owned());
        }
        if !network.saturations().iter().all(|part| (0.0..=1.0).contains(part)) {
            return Err("a saturation is not in 0 to 1".to_owned());
        }
    }
    Ok(solutions)
}

#[test]
fn networks_of_all_kinds_take_steps_of_all_lengths() {
    let results: Vec<Result<u32, String>> = (0..150).map(try_case).collect();
    let failed: Vec<String> = (results.iter().enumerate())
        .filter_map(|(case, result)| result.as_ref().err().map(|why| format!("{case}: {why}\n")))
        .collect();
    let solutions: u32 = results.iter().flatten().sum();
    assert!(failed.is_empty(), "{} cases of 150\n{}", failed.len(), failed.concat());
    assert!(solutions < 150 * 12 * 100, "{solutions}");
}
