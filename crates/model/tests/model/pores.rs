//! Liquid in pores: its values in the model, the places of surfaces, stages, and refusals.

use fdem_model::{AnyPrepared, Entered, Prepared, prepare_any};
use fdem_simulation::fluid::{Drive, PoreLiquid};
use fdem_simulation::{PoreSurface, Probe, Schedule, Simulation, Target};

use crate::{read, right};

/// Two bodies of rock with pores and a platen without, and more tables.
fn ground(more: &str) -> String {
    format!(
        r#"[model]
end_time = 1e-3
plane = "strain"
thickness = 2
gravity = [0, -10]
[[body]]
name = "rock"
material = "rock"
rectangle = {{ min = [0, 0], max = [1, 0.5], holes = [{{ centre = [0.5, 0.25], radius = 0.1 }}] }}
mesh_size = 0.1
[[body]]
name = "clay"
material = "clay"
rectangle = {{ min = [2, 0], max = [3, 0.5] }}
mesh_size = 0.1
[[body]]
name = "platen"
material = "steel"
rectangle = {{ min = [0, 0.6], max = [1, 0.7] }}
mesh_size = 0.1
[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.25
pores = {{ permeability = "1e-3 um^2", biot = 0.8, biot_modulus = "8 GPa" }}
[[material]]
name = "clay"
density = 2000
youngs_modulus = 3e9
poissons_ratio = 0.25
pores = {{ permeability = [2e-17, 1e-17], biot = 0.75, porosity = 0.25 }}
[[material]]
name = "steel"
density = 7800
youngs_modulus = 200e9
poissons_ratio = 0.3
{more}
"#
    )
}

fn with_surface(keys: &str) -> String {
    ground(&format!("[pores]\n[[pore_surface]]\nname = \"drain\"\n{keys}"))
}

fn surfaces(prepared: &Prepared) -> &[PoreSurface] {
    &prepared.model.pores.as_ref().unwrap().surfaces
}

#[test]
fn keys_of_the_pores_are_those_of_the_model() {
    let prepared = right(&ground(
        "[pores]\nviscosity = \"2 cP\"\ndensity = 900\nbulk_modulus = \"1 GPa\"\nsteps = 3\ninitial_pressure = \"1 bar\"",
    ));
    let pores = prepared.model.pores.as_ref().unwrap();
    assert_eq!(pores.liquid, PoreLiquid { viscosity: 2e-3, density: 900.0, gravity: [0.0, -10.0] });
    assert_eq!(pores.steps, 3);
    assert_eq!(pores.initial_pressures, vec![1e5; prepared.model.mesh.nodes.len()]);
    let [Some(rock), Some(clay), None] = pores.materials[..] else { panic!("two with pores") };
    assert_eq!((rock.permeability, rock.biot), ([[1e-15, 0.0], [0.0, 1e-15]], 0.8));
    assert!((rock.storage * 8e9 - 1.0).abs() < 1e-15);
    assert_eq!((clay.permeability, clay.biot), ([[2e-17, 0.0], [0.0, 1e-17]], 0.75));
    // K = 2e9 Pa, Ks = K/(1 - 0.75) = 8e9 Pa.
    let storage: f64 = 0.25 / 1e9 + (0.75 - 0.25) / 8e9;
    assert!((clay.storage / storage - 1.0).abs() < 1e-14, "{}", clay.storage);
    // Water by default, or the fluid in cracks.
    let pores = right(&ground("[pores]")).model.pores.unwrap();
    assert_eq!(pores.liquid, PoreLiquid { gravity: [0.0, -10.0], ..PoreLiquid::WATER });
    assert_eq!((pores.steps, pores.initial_pressures[0]), (10, 0.0));
    let of_clay = pores.materials[1].unwrap().storage;
    assert!((of_clay / (0.25 / 2.2e9 + 0.5 / 8e9) - 1.0).abs() < 1e-14, "{of_clay}");
    let fluid = "[fluid]\nviscosity = 0.1\ndensity = 800\nbulk_modulus = 1e9\n[pores]\n";
    let pores = right(&ground(fluid)).model.pores.unwrap();
    assert_eq!([pores.liquid.viscosity, pores.liquid.density], [0.1, 800.0]);
    assert_eq!(pores.materials[1].unwrap().storage, clay.storage);
    // A gel in cracks, and water in pores.
    let pores = right(&ground(&format!("{fluid}viscosity = 1e-3"))).model.pores.unwrap();
    assert_eq!(pores.liquid.viscosity, 1e-3);
}

#[test]
fn permeabilities_are_numbers_axes_or_tensors() {
    let found = |pores: &str| {
        let text = ground("[pores]").replace("permeability = [2e-17, 1e-17]", pores);
        right(&text).model.pores.unwrap().materials[1].unwrap()
    };
    // A millidarcy.
    let [[along, _], [_, across]] = found("permeability = \"10 mD\"").permeability;
    assert!(along == across && (along / 9.869_233e-15 - 1.0).abs() < 1e-7, "{along}");
    let tensor = found("permeability = [\"2e-17 m^2\", 1e-17, -5e-18]").permeability;
    assert_eq!(tensor, [[2e-17, -5e-18], [-5e-18, 1e-17]]);
    // Rigid grains, and given ones.
    let text = ground("[pores]").replace("biot = 0.75, porosity = 0.25", "biot = 1, porosity = 0.25");
    assert_eq!(right(&text).model.pores.unwrap().materials[1].unwrap().storage, 0.25 / 2.2e9);
    let grains = ground("[pores]").replace("porosity = 0.25", "porosity = 0.25, grain_modulus = \"40 GPa\"");
    let storage = right(&grains).model.pores.unwrap().materials[1].unwrap().storage;
    assert!((storage / (0.25 / 2.2e9 + 0.5 / 40e9) - 1.0).abs() < 1e-14, "{storage}");
}

/// A liquid at rest below a water level stays at rest.
#[test]
fn a_water_level_has_hydrostatic_pressure() {
    let prepared = right(&ground("[pores]\nwater_level = \"40 cm\"\ndensity = 1000"));
    let pores = prepared.model.pores.as_ref().unwrap();
    for (node, pressure) in prepared.model.mesh.nodes.iter().zip(&pores.initial_pressures) {
        assert!((pressure - 1e4 * (0.4 - node[1])).abs() < 1e-9, "{node:?} {pressure}");
    }
    let run = Simulation::new(prepared.model.clone(), 1).unwrap();
    let flows = run.pores().unwrap().flows();
    assert!(flows.as_flattened().iter().all(|flow| flow.abs() < 1e-22), "{flows:?}");
}

/// Ground at rest carries its weight by effective stress and the liquid: nothing moves and nothing flows.
#[test]
fn ground_with_a_water_level_is_at_rest() {
    let text = "[model]\nend_time = 1e-2\nplane = \"strain\"\ngravity = [0, -10]\n[[body]]\nname = \"ground\"\n\
                material = \"soil\"\nrectangle = { min = [0, -10], max = [10, 0] }\nmesh_size = 2\n\
                [[material]]\nname = \"soil\"\ndensity = 2000\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\n\
                pores = { permeability = 1e-10, biot = 0.9, porosity = 0.3 }\n[pores]\nwater_level = -1\n\
                [initial]\nground = { surface = 0, k0 = 0.5 }\n[[boundary]]\nname = \"sides\"\n\
                sides = [\"left\", \"right\"]\nfixed = \"x\"\n[[boundary]]\nname = \"base\"\nside = \"bottom\"\n\
                fixed = \"y\"\n";
    let prepared = right(text);
    let pushes = |nodes: &[u32; 3]| {
        let heights = nodes.iter().map(|node| prepared.model.mesh.nodes[*node as usize][1]);
        let height = heights.sum::<f64>() / 3.0;
        [-2e4 * -height, 0.9 * 9980.0 * (-1.0 - height)]
    };
    for (nodes, stress) in prepared.model.mesh.elements.iter().zip(&prepared.model.stresses) {
        let [weight, push] = pushes(nodes);
        assert!((stress[1][1] - (weight + push)).abs() < 1e-6, "{stress:?}");
        assert!((stress[0][0] - 0.5 * (weight + push)).abs() < 1e-6, "{stress:?}");
    }
    let mut run = Simulation::new(prepared.model.clone(), 1).unwrap();
    run.advance(200).unwrap();
    // It would settle by some millimetres.
    let most = run.snapshot().displacements.as_flattened().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    assert!(most < 1e-10, "{most}");
    let flows = run.pores().unwrap().flows();
    assert!(flows.as_flattened().iter().all(|flow| flow.abs() < 1e-11), "{flows:?}");
    // Below a lake of 5 m: its water is a load, and the effective stress is that of ground up to its surface.
    let lake = "[[boundary]]\nname = \"lake\"\nside = \"top\"\npressure = \"5*9980\"\n";
    let lake = right(
        &(text.replace("water_level = -1", "water_level = 5").replace("biot = 0.9", "biot = 1") + lake),
    );
    let top =
        lake.model.mesh.elements.iter().map(|nodes| {
            nodes.iter().map(|node| lake.model.mesh.nodes[*node as usize][1]).sum::<f64>() / 3.0
        });
    for (height, stress) in top.zip(&lake.model.stresses) {
        assert!((stress[1][1] - (2e4 - 9980.0) * height).abs() < 1e-6, "{height} {stress:?}");
    }
    let mut run = Simulation::new(lake.model.clone(), 1).unwrap();
    run.advance(200).unwrap();
    let most = run.snapshot().displacements.as_flattened().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    assert!(most < 1e-10, "{most}");
    // Without its liquid, the stress is that of the weight; so is that of a liquid of a later stage.
    let stages = "[[stage]]\nname = \"dry\"\nduration = 1e-3\n[[stage]]\nname = \"wet\"\n";
    let later = text.replace("water_level = -1", "water_level = -1\nfrom_stage = \"wet\"") + stages;
    let later = right(&later);
    let [weight, _] = pushes(&later.model.mesh.elements[0]);
    assert!((later.model.stresses[0][1][1] - weight).abs() < 1e-6);
}

/// A conductivity in m/s in place of a permeability.
#[test]
fn a_permeability_above_that_of_gravel_is_questioned() {
    let warnings =
        |permeability: &str| right(&ground("[pores]").replace("\"1e-3 um^2\"", permeability)).warnings;
    let asks = |of: &[String]| of.iter().any(|warning| warning.contains("is it a hydraulic conductivity?"));
    assert!(asks(&warnings("1e-5")) && asks(&warnings("[1e-12, 1e-5]")) && !asks(&warnings("1e-8")));
}

#[test]
fn surfaces_are_sides_groups_boxes_bodies_and_wells() {
    let edges = |keys: &str| {
        let prepared = right(&with_surface(&format!("{keys}\npressure = 0")));
        let [PoreSurface { target: Target::Facets(edges), .. }] = surfaces(&prepared) else {
            panic!("edges of {keys}")
        };
        let place = |edge: &[u32; 2]| edge.map(|node| prepared.model.mesh.nodes[node as usize]);
        edges.iter().map(place).collect::<Vec<_>>()
    };
    // The platen is higher, and has no pores.
    let top = edges("side = \"top\"");
    assert!(top.len() == 20 && top.as_flattened().iter().all(|[_, y]| (y - 0.5).abs() < 1e-9), "{top:?}");
    assert_eq!(edges("body = \"rock\"\nside = \"top\"").len(), 10);
    assert_eq!(edges("body = \"clay\"\nsides = [\"left\", \"bottom\"]").len(), 15);
    let hole = edges("group = \"hole-1\"");
    assert!(hole.as_flattened().iter().all(|[x, y]| ((x - 0.5).hypot(y - 0.25) - 0.1).abs() < 1e-3));
    assert_eq!(edges("box = [0, 0.49, 0.31, 0.51]").len(), 3);
    assert_eq!(edges("body = \"rock\"").len(), 30 + hole.len());
    let prepared = right(&with_surface("at = [2.52, 0.23]\nrate = -1e-6"));
    let [PoreSurface { target: Target::Nodes(node), .. }] = surfaces(&prepared) else { panic!("a well") };
    let [x, y] = prepared.model.mesh.nodes[node[0] as usize];
    let nearest = prepared.model.mesh.nodes.iter().map(|[x, y]| (x - 2.52).hypot(y - 0.23));
    assert_eq!((x - 2.52).hypot(y - 0.23), nearest.fold(f64::INFINITY, f64::min));
}

#[test]
fn pressures_and_rates_follow_their_schedules() {
    let drive = |keys: &str| {
        surfaces(&right(&with_surface(&format!("body = \"rock\"\nside = \"top\"\n{keys}"))))[0].drive.clone()
    };
    let Drive::Rate(rate) = drive("rate = \"2 cm^3/s\"\ntable = [[0, 0], [1e-4, 1], [2e-4, -1]]") else {
        panic!("a rate")
    };
    assert_eq!([0.0, 5e-5, 1e-4, 1.0].map(|time| rate.at(time)), [0.0, 1e-6, 2e-6, -2e-6]);
    let Drive::Pressure(pressure) = drive("pressure = \"4 MPa\"\nramp = 1e-4") else { panic!("a pressure") };
    for time in [0.0, 1.3e-5, 5e-5, 1e-4, 1.0] {
        let expected = 4e6 * Schedule::Ramp(1e-4).factor(time);
        assert!((pressure.at(time) - expected).abs() < 4e6 * 2e-4, "{time}");
    }
    let Drive::Pressure(pressure) = drive("pressure = 1e6\nexpression = \"t/1ms\"") else {
        panic!("a pressure")
    };
    assert!((pressure.at(5e-4) / 5e5 - 1.0).abs() < 1e-9);
}

/// The corner of two sides has the pressure of the first; a side with a rate keeps all of its edges.
#[test]
fn a_node_has_the_pressure_of_the_first_of_its_surfaces() {
    let more = "[pores]\n[[pore_surface]]\nname = \"top\"\nbody = \"rock\"\nside = \"top\"\npressure = 0\n\
                [[pore_surface]]\nname = \"left\"\nbody = \"rock\"\nside = \"left\"\npressure = 1e5\n\
                [[pore_surface]]\nname = \"right\"\nbody = \"rock\"\nside = \"right\"\nrate = 1e-6\n";
    let prepared = right(&ground(more));
    let [top, left, rest] = surfaces(&prepared) else { panic!("three") };
    assert_eq!([top, left, rest].map(|of| of.target.nodes().len()), [11, 5, 6]);
    assert!(left.target.nodes().iter().all(|node| !top.target.nodes().contains(node)));
    assert!(Simulation::new(prepared.model.clone(), 1).is_ok());
}

#[test]
fn surfaces_in_space_are_faces() {
    let text = "[model]\nend_time = 1e-3\n[[body]]\nname = \"block\"\nmaterial = \"soil\"\n\
                box = { min = [0, 0, 0], max = [0.2, 0.2, 0.4] }\nmesh_size = 0.1\n[[material]]\nname = \"soil\"\n\
                density = 2000\nyoungs_modulus = 1e9\npoissons_ratio = 0.25\n\
                pores = { permeability = [3e-14, 2e-14, 1e-14, 0, 5e-15, 0], biot = 1, biot_modulus = 5e9 }\n\
                [pores]\n[[pore_surface]]\nname = \"top\"\nsides = [\"top\", \"front\"]\npressure = 0\n\
                [[history]]\nname = \"base\"\npore_pressure = [0.1, 0.1, 0]\n";
    let prepared = prepare_any(text, "model.toml", &mut |_| Err(String::new()), None);
    let Ok(AnyPrepared::Space(prepared)) = prepared else { panic!("{prepared:?}") };
    let pores = prepared.model.pores.as_ref().unwrap();
    let tensor = pores.materials[0].unwrap().permeability;
    assert_eq!(tensor, [[3e-14, 0.0, 0.0], [0.0, 2e-14, 5e-15], [0.0, 5e-15, 1e-14]]);
    let nodes = &prepared.model.mesh.nodes;
    let faces = pores.surfaces[0].target.facets();
    let is_on = |axis: usize, at: f64| {
        faces.iter().filter(|face| face.iter().all(|node| nodes[*node as usize][axis] == at)).count()
    };
    let (top, front) = (is_on(2, 0.4), is_on(1, 0.0));
    assert!(top > 3 && front > 7 && faces.len() == top + front, "{top} {front} {}", faces.len());
    assert!(prepared.probes.iter().any(|probe| matches!(probe, Probe::PorePressure(_))));
}

/// The common edges of bonded bodies are inside, and liquid flows through them.
#[test]
fn bonded_bodies_have_common_pores() {
    let text = ground(
        "[[joint_set]]\nname = \"bond\"\nbetween = [\"rock\", \"clay\"]\nfriction_angle = 30\ntensile_strength = 1e6\n\
         cohesion = 1e6\nfracture_energy_i = 10\nfracture_energy_ii = 10\n[pores]\ninitial_pressure = 1e5\n\
         [[pore_surface]]\nname = \"all\"\nbody = \"rock\"\npressure = 0\n",
    )
    .replace("min = [2, 0], max = [3, 0.5]", "min = [1, 0], max = [2, 0.5]");
    let prepared = right(&text);
    let edges = surfaces(&prepared)[0].target.facets();
    let nodes = &prepared.model.mesh.nodes;
    let is_common = |edge: &&[u32; 2]| edge.iter().all(|node| nodes[*node as usize][0] == 1.0);
    assert_eq!(edges.iter().filter(is_common).count(), 0);
    assert_eq!(prepared.model.pores.as_ref().unwrap().initial_pressures, vec![1e5; nodes.len()]);
    assert!(Simulation::new(prepared.model.clone(), 1).is_ok());
    let between = text.replace("body = \"rock\"\npressure", "box = [0.99, 0, 1.01, 0.5]\npressure");
    let found = read(&between).map(|_| ()).unwrap_err().to_string();
    assert!(found.contains("lies between bonded bodies alone"), "{found}");
}

/// Liquid begins in the second of three stages, and is drained there alone.
#[test]
fn stages_have_their_pores_and_their_surfaces() {
    let stages = "[[stage]]\nname = \"dry\"\nduration = 1e-4\n[[stage]]\nname = \"drain\"\nduration = 1e-4\n\
                  [[stage]]\nname = \"sealed\"\nexcavate = [\"clay\"]\n";
    let text = ground(&format!(
        "{stages}[pores]\nfrom_stage = \"drain\"\n[[pore_surface]]\nname = \"top\"\nside = \"top\"\nbody = \"rock\"\n\
         pressure = 1e5\nstages = [\"drain\"]\ntable = [[0, 1], [5e-5, 2]]\n[[pore_surface]]\nname = \"clay\"\n\
         body = \"clay\"\nrate = 1e-6\n"
    ));
    let prepared = right(&text);
    let entered = |begun: &[u64]| Entered { begun: begun.to_vec(), ..Entered::alone(begun.len() - 1) };
    let pores = |begun: &[u64]| prepared.at(&entered(begun), 1e-6).unwrap().prepared.model.pores;
    assert!(pores(&[0]).is_none());
    let second = pores(&[0, 70]).unwrap();
    let Drive::Pressure(pressure) = &second.surfaces[0].drive else { panic!("a pressure") };
    assert_eq!([7e-5, 1.2e-4].map(|time| pressure.at(time)), [1e5, 2e5]);
    assert_eq!(second.surfaces.len(), 2);
    // Sealed, and without the body of the second surface.
    let third = pores(&[0, 70, 170]).unwrap();
    let [top] = &third.surfaces[..] else { panic!("one surface") };
    let Drive::Rate(rate) = &top.drive else { panic!("sealed") };
    assert_eq!((top.name.as_str(), rate.at(1.0), top.target.nodes().len()), ("top", 0.0, 11));
    assert!(prepared.in_stages().is_ok());
}

/// A body that loses its pores in a stage has no surface of pores there.
#[test]
fn a_surface_leaves_a_body_that_loses_its_pores() {
    let text = ground(
        "[[material]]\nname = \"grout\"\ndensity = 2000\nyoungs_modulus = 5e9\npoissons_ratio = 0.2\n\
         [[stage]]\nname = \"soft\"\nduration = 1e-4\n[[stage]]\nname = \"grouted\"\nmaterials = { clay = \"grout\" }\n\
         [pores]\n[[pore_surface]]\nname = \"clay\"\nbody = \"clay\"\npressure = 0\n",
    );
    let prepared = right(&text);
    let entered = Entered { begun: vec![0, 100], ..Entered::alone(1) };
    assert!(prepared.at(&entered, 1e-6).unwrap().prepared.model.pores.unwrap().surfaces.is_empty());
    assert!(prepared.in_stages().is_ok());
}

#[test]
fn a_probe_is_in_an_element_with_pores() {
    let probe = |keys: &str| {
        let text = ground(&format!("[pores]\n[[history]]\nname = \"p\"\n{keys}"));
        right(&text).probes[0].clone()
    };
    let Probe::PorePressure(point) = probe("pore_pressure = [\"30 cm\", 0.12]") else { panic!("a pressure") };
    assert!((point.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    assert!(matches!(probe("pore_pressure = [2.5, 0.1]\nbody = \"clay\""), Probe::PorePressure(_)));
    let prepared = right(&with_surface("side = \"top\"\npressure = 0"));
    let names: Vec<&str> = prepared.histories.iter().map(|history| history.name.as_str()).collect();
    assert_eq!(names, ["pores", "drain"]);
    assert_eq!(prepared.probes, [Probe::Pores, Probe::PoreSurface("drain".to_owned())]);
}

#[test]
fn surfaces_that_are_nowhere_are_refused() {
    for (keys, message) in [
        ("pressure = 0", "[[pore_surface]] \"drain\" has no place"),
        ("side = \"top\"", "has no pressure and no rate"),
        ("side = \"top\"\npressure = 0\nrate = 1", "has both pressure and rate"),
        ("side = \"top\"\ngroup = \"holes\"\npressure = 0", "in two places, side and group"),
        ("body = \"platen\"\npressure = 0", "the body \"platen\" has no pores"),
        ("body = \"platen\"\nside = \"top\"\npressure = 0", "the body \"platen\" has no pores"),
        ("body = \"rok\"\npressure = 0", "there is no body \"rok\""),
        ("group = \"hole-2\"\npressure = 0", "no body with pores has a group \"hole-2\""),
        ("box = [0, 0.55, 1, 1]\npressure = 0", "there is no edge of an outline of a body with pores"),
        ("box = [1, 1, 0, 0]\npressure = 0", "its box is turned inside out"),
        ("box = [0, 0, 0, 1, 1, 1]\npressure = 0", "\"box\" has 6 numbers"),
        ("side = \"front\"\npressure = 0", "a flat body has no front"),
        ("at = [0.5, 0.65]\npressure = 0", "is in no body with pores"),
        ("at = [0.5, 0.65, 1]\npressure = 0", "\"at\" has 3 numbers"),
        ("side = \"top\"\npressure = 1\ntable = [[0, 1], [0, 2]]", "the times of its table do not ascend"),
        ("side = \"top\"\npressure = 1\ntable_file = \"no.csv\"", "cannot read no.csv"),
        ("side = \"top\"\npressure = 1\nramp = 1\nexpression = \"t\"", "has both ramp and expression"),
        ("side = \"top\"\npressure = 0\nstages = [\"one\"]", "there is no stage \"one\""),
        ("side = \"top\"\npressure = 0\nstages = []", "acts in no stage"),
        ("side = \"top\"\nrate = \"1 m/s\"", "rate is in m³/s"),
        ("side = \"top\"\npresure = 0", "did you mean \"pressure\"?"),
    ] {
        let found = read(&with_surface(keys)).map(|_| ()).unwrap_err().to_string();
        assert!(found.contains(message) && found.contains("model.toml:"), "{keys}\n{found}");
    }
}

#[test]
fn surfaces_in_one_place_are_refused() {
    let two = |one: &str, other: &str| {
        let text = format!(
            "{one}\n[[pore_surface]]\nname = \"other\"\n{other}\n[[stage]]\nname = \"a\"\n\
                            duration = 1e-4\n[[stage]]\nname = \"b\"\n"
        );
        read(&with_surface(&text)).map(|_| ()).map_err(|found| found.to_string())
    };
    let error = two("side = \"top\"\npressure = 0", "group = \"outer\"\npressure = 1").unwrap_err();
    assert!(error.contains("of it is of [[pore_surface]] \"drain\", too"), "{error}");
    let error = two("side = \"top\"\nrate = 0", "body = \"rock\"\nside = \"top\"\nrate = 1").unwrap_err();
    assert!(error.contains("of it is of [[pore_surface]] \"drain\", too"), "{error}");
    let error = two("side = \"top\"\npressure = 0", "at = [0.3, 0.5]\npressure = 1").unwrap_err();
    assert!(error.contains("prescribe the pressure of all of its nodes"), "{error}");
    let one = "side = \"top\"\npressure = 0\nstages = [\"a\"]";
    assert!(two(one, "group = \"outer\"\npressure = 1\nstages = [\"b\"]").is_ok());
}

#[test]
fn bad_pores_are_refused_with_their_key() {
    for (pores, message) in [
        ("[pores]\nviscosity = 0", "viscosity"),
        ("[pores]\nsteps = 0", "steps"),
        ("[pores]\nviscosty = 1", "did you mean \"viscosity\"?"),
        ("[pores]\ninitial_pressure = 1\nwater_level = 1", "has both initial_pressure and water_level"),
        ("[pores]\nfrom_stage = \"two\"", "there is no stage \"two\""),
        ("[pores]\n[fluid]\nleak_off = 1e-5", "\"leak_off\" would take it twice"),
        (
            "[pores]\n[fluid]\ngas_exponent = 1.4\ndensity = 1.2\nreference_pressure = 1e5",
            "a gas in cracks does not go with the liquid of [pores]",
        ),
        ("", "[[material]] \"rock\": \"pores\" need a liquid"),
        ("[[pore_surface]]\nname = \"top\"\nside = \"top\"\npressure = 0", "there is no liquid in pores"),
        ("[[history]]\nname = \"p\"\npore_pressure = [0.3, 0.1]", "\"p\": there is no liquid in pores"),
        ("[output]\nfields = [\"pore_pressure\"]", "there is no liquid in pores"),
        (
            "[pores]\n[[history]]\nname = \"p\"\npore_pressure = [0.5, 0.65]",
            "there are no pores at the point",
        ),
        ("[pores]\n[[history]]\nname = \"p\"\npore_pressure = [0.5, 9]", "is outside of all bodies"),
        (
            "[pores]\n[[history]]\nname = \"p\"\npore_pressure = [0.5, 0.65, 1]",
            "\"pore_pressure\" has 3 numbers",
        ),
    ] {
        let found = read(&ground(pores)).map(|_| ()).unwrap_err();
        assert!(found.to_string().contains(message), "{pores}\n{found}");
        assert!(found.faults.iter().all(|fault| fault.span.is_some()), "{found}");
    }
    for (old, new, message) in [
        ("plane = \"strain\"", "plane = \"stress\"", "not known in plane stress"),
        ("plane = \"strain\"\n", "", "not known in plane stress"),
        ("gravity = [0, -10]\n", "", "a \"water_level\" needs gravity"),
        ("permeability = \"1e-3 um^2\"", "permeability = 0", "permeability"),
        ("permeability = \"1e-3 um^2\"", "permeability = -1e-15", "permeability"),
        ("permeability = \"1e-3 um^2\"", "permeability = \"1 m\"", "permeability is in m²"),
        ("[2e-17, 1e-17]", "[2e-17, 0]", "above 0 in all directions"),
        ("[2e-17, 1e-17]", "[2e-17, -1e-17]", "above 0 in all directions"),
        ("[2e-17, 1e-17]", "[1e-17, 1e-17, 2e-17]", "symmetric tensor without a negative value"),
        ("[2e-17, 1e-17]", "[1e-17, 1e-17, 1e-17, 0]", "is one number, [x, y] or [xx, yy, xy]"),
        ("biot = 0.8", "biot = 0", "biot"),
        ("biot = 0.8", "biot = 1.1", "biot"),
        ("biot = 0.8, ", "", "lacks the key \"biot\""),
        ("biot_modulus = \"8 GPa\"", "biot_modulus = 8e9, porosity = 0.2", "both biot_modulus and porosity"),
        (", biot_modulus = \"8 GPa\"", "", "lack biot_modulus or porosity"),
        ("biot_modulus = \"8 GPa\"", "biot_modulus = 0", "biot_modulus"),
        ("biot_modulus = \"8 GPa\"", "biot_modulus = 8e9, grain_modulus = 4e10", "goes with porosity"),
        ("porosity = 0.25", "porosity = 0.8", "porosity of 0.8 is above its biot of 0.75"),
    ] {
        let text = ground("[pores]\nwater_level = 0.2").replacen(old, new, 1);
        let found = read(&text).map(|_| ()).unwrap_err();
        assert!(found.to_string().contains(message), "{new}\n{found}");
        assert!(found.faults.iter().all(|fault| fault.span.is_some()), "{found}");
    }
    let dry = ground("[pores]").replace("material = \"rock\"", "material = \"steel\"");
    let dry = dry.replace("material = \"clay\"", "material = \"steel\"");
    let found = read(&dry).map(|_| ()).unwrap_err().to_string();
    assert!(found.contains("[pores]: no body has a material with \"pores\""), "{found}");
    let bedded = "poissons_ratio = 0.25\nanisotropy = { youngs_modulus = 1e9, poissons_ratio = 0.1, shear_modulus = 1e9, dip = 0 }\npores = { permeability = [2e-17";
    let found = ground("[pores]").replace("poissons_ratio = 0.25\npores = { permeability = [2e-17", bedded);
    let found = read(&found).map(|_| ()).unwrap_err().to_string();
    assert!(found.contains("need a grain_modulus"), "{found}");
}

#[test]
fn columns_of_the_history_have_one_name_each() {
    let surface = "[[pore_surface]]\nname = \"top\"\nside = \"top\"\npressure = 0\n";
    let history = "[[history]]\nname = \"top\"\nenergy = true\n";
    let injection = "[fluid]\n[[injection]]\nname = \"top\"\nat = [0.5, 0.25]\n";
    for (more, message) in [
        (format!("{surface}{history}"), "there is a [[history]] \"top\""),
        (format!("{surface}{injection}"), "there is an [[injection]] \"top\""),
        (surface.replace("top\"\nside", "pores\"\nside"), "cannot have the name \"pores\""),
        (format!("{surface}{surface}"), "there is a [[pore_surface]] \"top\" already"),
        (history.replace("top", "pores"), "cannot have the name \"pores\""),
    ] {
        let found = read(&ground(&format!("[pores]\n{more}"))).map(|_| ()).unwrap_err().to_string();
        assert!(found.contains(message), "{more}\n{found}");
    }
}
