//! Everything that a run leaves behind, of a disc that splits, without a run: for looking at, and for the
//! tests in browsers and in ParaView's library.
//!
//! `cargo run --release -p fdem-results --example run_report -- FOLDER [RINGS [FRAMES]]`

use std::error::Error;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::Instant;

use fdem_results::{
    Animation, ElementMasses, Field, Fragments, Frame, FrameView, History, HistoryWriter, Names, Outlines,
    Pictures, Range, Report, Row, plots, pvd, write_contacts_vtp, write_cracks_vtp, write_damaged_joints_vtp,
    write_vtu,
};
use fdem_simulation::{Forces, Material, MaterialLaw, Model, Snapshot};
use serde_json::json;

#[path = "../tests/suite/run/splitting_disc.rs"]
mod splitting_disc;
use splitting_disc::{Disc, END};

/// Files for ParaView: their names and ends.
const FILES: [(&str, &str); 4] =
    [("mesh", "vtu"), ("cracks", "vtp"), ("damaged_joints", "vtp"), ("contacts", "vtp")];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let folder = PathBuf::from(arguments.first().ok_or("a folder is needed")?);
    let number = |k: usize, usual: u32| arguments.get(k).map_or(Ok(usual), |text| text.parse());
    let (rings, count) = (number(1, 24)?, number(2, 60)?);
    fs::create_dir_all(&folder)?;
    let disc = Disc::new(rings);
    let start = Instant::now();
    let took = |what: &str| eprintln!("{:8.3} s  {what}", start.elapsed().as_secs_f64());

    let mut frames = Vec::new();
    let mut files: [Vec<(f64, String)>; 4] = Default::default();
    let names = Names {
        bodies: ["left half", "right half"].map(String::from).to_vec(),
        materials: vec!["sandstone".to_owned()],
    };
    let outlines = Outlines::new(&disc.mesh(), &[]);
    for k in 0..count {
        let snapshot = disc.snapshot(f64::from(k) / f64::from(count - 1).max(1.0));
        frames.push(Frame::outlined(&snapshot, &outlines)?);
        // ParaView's files of a few: they are large.
        if k % 15 == 0 || k + 1 == count {
            let forces = Disc::forces(&snapshot);
            let mut outs = Vec::new();
            for (files, (name, end)) in files.iter_mut().zip(FILES) {
                let file = format!("{name}_{k:04}.{end}");
                outs.push(BufWriter::new(File::create(folder.join(&file))?));
                files.push((snapshot.time, file));
            }
            write_vtu(&mut outs[0], &snapshot, &forces, &names)?;
            write_cracks_vtp(&mut outs[1], &snapshot)?;
            write_damaged_joints_vtp(&mut outs[2], &snapshot)?;
            write_contacts_vtp(&mut outs[3], &snapshot, &forces)?;
            fs::write(
                folder.join(format!("expected_{k:04}.json")),
                expected(&snapshot, &forces).to_string(),
            )?;
        }
    }
    for ((name, _), files) in FILES.iter().zip(&files) {
        fs::write(
            folder.join(format!("{name}.pvd")),
            pvd(files.iter().map(|(time, file)| (*time, file.as_str()))),
        )?;
    }
    took("frames and files for ParaView");

    history(&folder.join("history.csv"), &disc)?;
    let plots = plots(&History::read(&fs::read(folder.join("history.csv"))?)?);
    for plot in &plots {
        fs::write(folder.join(format!("{}.svg", plot.name)), &plot.svg)?;
        fs::write(folder.join(format!("{}.png", plot.name)), plot.png(None)?)?;
    }
    took("history and plots");

    let title = "A disc that splits";
    let view = FrameView::of(&frames);
    for field in Field::ALL {
        let pictures = Pictures { title, field, range: Range::of(&frames, field), view };
        let last = &frames[frames.len() * 3 / 5];
        fs::write(folder.join(format!("{}.png", field.key())), pictures.png(last, None)?)?;
        fs::write(folder.join(format!("{}.svg", field.key())), pictures.svg(last)?)?;
    }
    took("pictures: seven fields as PNG and SVG");

    let field = Field::MAX_PRINCIPAL;
    let pictures = Pictures { title, field, range: Range::of(&frames, field), view };
    let mut animation = Animation::new(pictures, None, 8);
    for frame in &frames {
        animation.push(frame)?;
    }
    fs::write(folder.join("run.gif"), animation.finish()?)?;
    took("animation");

    let elements = (6 * rings * rings).to_string();
    let facts = [
        ("model", "tests/suite/run/splitting_disc.rs"),
        ("elements", elements.as_str()),
        ("material", "sandstone"),
    ];
    let rock = Material {
        name: names.materials[0].clone(),
        density: 2300.0,
        youngs_modulus: 20e9,
        poissons_ratio: 0.25,
        law: MaterialLaw::NeoHookean,
        damping: 0.0,
        strength: None,
        friction: 0.6,
    };
    let model = Model { mesh: disc.mesh(), materials: vec![rock], ..Model::default() };
    let fragments = Fragments::of(&disc.snapshot(1.0), &ElementMasses::of(&model)?)?;
    let report = Report {
        title,
        facts: &facts,
        plots: &plots,
        frames: &frames,
        fragments: &fragments,
        field,
        names: &names,
    };
    fs::write(folder.join("report.html"), report.html()?)?;
    took("report");
    Ok(())
}

fn history(path: &Path, disc: &Disc) -> Result<(), Box<dyn Error>> {
    let names = ["upper platen, force y [N]", "lower platen, force y [N]", "approach of platens [m]"]
        .map(String::from);
    let mut writer = HistoryWriter::new(BufWriter::new(File::create(path)?), 2, &names)?;
    for k in 0..=1000_u32 {
        let share = f64::from(k) / 1000.0;
        let snapshot = disc.snapshot(share);
        let (broken, lengths) = Row::broken_joints(&snapshot.cracks);
        let force = if share < 0.4 { 2.5 * share } else { (1.0 - 3.0 * (share - 0.4)).max(0.05) } * 78_540.0;
        let wiggle = 1.0 + 0.01 * (share * 200.0).sin();
        let values = vec![-force * wiggle, force / wiggle, 1e-3 * share * END / END];
        writer.row(&Row {
            step: snapshot.step,
            time: snapshot.time,
            energies: Disc::energies(share),
            broken,
            lengths,
            values,
            ..Row::default()
        })?;
    }
    Ok(())
}

/// The numbers of a snapshot, for readers of its files.
fn expected(snapshot: &Snapshot, forces: &Forces) -> serde_json::Value {
    let cracks = snapshot.cracks.iter().map(|crack| {
        json!({
            "ends": crack.corners,
            "elements": crack.elements,
            "mode": crack.mode as i32,
            "damage": crack.damage,
            "opening": crack.opening,
            "sliding": crack.sliding,
            "time": crack.time,
            "length": crack.measure,
        })
    });
    let contacts = forces.contacts.iter().map(|contact| {
        json!({
            "elements": contact.elements,
            "point": contact.point,
            "normal": contact.normal,
            "tangential": contact.tangential,
        })
    });
    json!({
        "time": snapshot.time,
        "fragments": snapshot.fragments,
        "reactions": forces.reactions,
        "contacts": contacts.collect::<Vec<_>>(),
        "positions": snapshot.positions,
        "displacements": snapshot.displacements,
        "velocities": snapshot.velocities,
        "triangles": snapshot.elements,
        "stresses": snapshot.stresses,
        "damage": snapshot.damage,
        "bodies": snapshot.bodies,
        "materials": snapshot.materials,
        "cracks": cracks.collect::<Vec<_>>(),
    })
}
