//! Results of runs: equal bytes for equal runs, correct pictures, and no panic on invalid states.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::collections::BTreeSet;
use std::io::ErrorKind;

use fdem_results::picture::PictureError;
use fdem_results::{
    Animation, AnimationError, Field, FragmentCount, Fragments, Frame, FrameError, FrameView, History,
    HistoryWriter, MOST_FRAMES, Names, Outlines, Pictures, Range, RankLoad, Report, Row, SnapshotError,
    plots, rank_loads, write_contacts_vtp, write_cracks_vtp, write_damaged_joints_vtp,
    write_intact_joints_vtp, write_vtu,
};
use fdem_simulation::{ContactForce, Crack, Forces, Mesh, Snapshot};

mod splitting_disc;
use splitting_disc::{Disc, END, RADIUS};

fn frames(rings: u32, count: u32) -> Vec<Frame> {
    let disc = Disc::new(rings);
    let outlines = Outlines::new(&disc.mesh(), &[]);
    let share = |k: u32| f64::from(k) / f64::from(count - 1);
    (0..count).map(|k| Frame::outlined(&disc.snapshot(share(k)), &outlines).unwrap()).collect()
}

fn pictures(frames: &[Frame], field: Field) -> Pictures<'static> {
    Pictures { title: "disc", field, range: Range::of(frames, field), view: FrameView::of(frames) }
}

/// Width, height and red, green and blue of a PNG file.
fn pixels(file: &[u8]) -> (usize, usize, Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    (info.width as usize, info.height as usize, pixels)
}

#[test]
fn frames_come_back_from_their_bytes_and_damaged_ones_are_refused() {
    let frame = &frames(6, 5)[3];
    let bytes = frame.to_bytes();
    assert_eq!(&Frame::from_bytes(&bytes).unwrap(), frame);
    assert_eq!(frames(6, 5)[3].to_bytes(), bytes, "the same bytes again");
    assert_eq!((frame.step(), frame.time()), (75_000, 0.75 * END));
    assert_eq!(Frame::from_bytes(b"something else"), Err(FrameError::NotAFrame));
    for end in 0..bytes.len() {
        assert!(Frame::from_bytes(&bytes[..end]).is_err(), "cut at {end}");
    }
    // Whatever is changed, there is no panic, neither here nor when it is drawn.
    for place in 8..bytes.len().min(700) {
        for flip in [1, 0x80, 0xff] {
            let mut damaged = bytes.clone();
            damaged[place] ^= flip;
            if let Ok(frame) = Frame::from_bytes(&damaged) {
                let frames = [frame];
                let pictures = pictures(&frames, Field::VON_MISES);
                let _ = pictures.svg(&frames[0]);
            }
        }
    }
}

#[test]
fn a_snapshot_that_contradicts_itself_is_refused_and_says_why() {
    let whole = Disc::new(3).snapshot(0.5);
    let mut short = whole.clone();
    short.stresses.pop();
    let mut lost = whole.clone();
    lost.elements[7][1] = 9999;
    let length = SnapshotError::Length { name: "stresses", found: 53, expected: 54 };
    let node = SnapshotError::Node { element: 7, node: 9999, nodes: whole.positions.len() };
    for (snapshot, expected) in [(short, length), (lost, node)] {
        assert_eq!(Frame::new(&snapshot).unwrap_err(), expected);
        let mut out = Vec::new();
        let error = write_vtu(&mut out, &snapshot, &Forces::default(), &Names::default()).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::InvalidInput);
        assert_eq!(error.to_string(), expected.to_string());
        assert!(out.is_empty());
    }
    assert_eq!(
        SnapshotError::Node { element: 7, node: 9999, nodes: 74 }.to_string(),
        "element 7 of the snapshot has node 9999, but there are 74"
    );
}

#[test]
fn files_for_paraview_are_the_same_bytes_again() {
    let snapshot = Disc::new(8).snapshot(0.8);
    let forces = Disc::forces(&snapshot);
    let names = Names { bodies: vec!["left".to_owned(), "<right>".to_owned()], materials: Vec::new() };
    let files = || {
        let mut files: [Vec<u8>; 4] = Default::default();
        write_vtu(&mut files[0], &snapshot, &forces, &names).unwrap();
        write_cracks_vtp(&mut files[1], &snapshot).unwrap();
        write_damaged_joints_vtp(&mut files[2], &snapshot).unwrap();
        write_contacts_vtp(&mut files[3], &snapshot, &forces).unwrap();
        files
    };
    assert_eq!(files(), files());
    let of_joints =
        ["mode", "broken", "damage", "opening", "sliding", "time_of_failure", "length", "elements"];
    let arrays: [&[&str]; 4] = [
        &[
            "displacement",
            "velocity",
            "reaction",
            "stress",
            "principal_stress",
            "von_mises",
            "damage",
            "body",
            "material",
            "fragment",
            "body: left",
            "body: &lt;right&gt;",
        ],
        &of_joints,
        &of_joints,
        &["force", "normal_force", "tangential_force", "elements", "bodies", "fragments"],
    ];
    for (file, names) in files().iter().zip(arrays) {
        let text = String::from_utf8_lossy(&file[..file.len().min(4500)]).into_owned();
        for name in names {
            assert!(text.contains(&format!("Name=\"{name}\"")), "{name} in {text}");
        }
    }
}

#[test]
fn broken_joints_and_damaged_ones_are_apart() {
    let snapshot = Disc::new(8).snapshot(0.6);
    let broken = snapshot.cracks.iter().filter(|crack| crack.time.is_some()).count();
    let damaged = snapshot.cracks.len() - broken;
    assert!(broken > 2 && damaged > 2, "{broken} {damaged}");
    let lines = |write: fn(&mut Vec<u8>, &Snapshot) -> std::io::Result<()>| {
        let mut file = Vec::new();
        write(&mut file, &snapshot).unwrap();
        let text = String::from_utf8_lossy(&file[..1000]).into_owned();
        text.split("NumberOfLines=\"").nth(1).unwrap().split('"').next().unwrap().parse::<usize>().unwrap()
    };
    assert_eq!(lines(write_cracks_vtp), broken);
    assert_eq!(lines(write_damaged_joints_vtp), damaged);
    assert_eq!(lines(write_intact_joints_vtp), 0);
}

/// The joints of a snapshot that are broken are whole, but for the last, which is open from the start.
fn whole_joints(mut snapshot: Snapshot) -> Snapshot {
    let broken = snapshot.cracks.iter().filter(|crack| crack.time.is_some());
    let mut intact: Vec<Crack> = broken.map(|crack| Crack { damage: 0.0, time: None, ..*crack }).collect();
    snapshot.cracks = intact.split_off(intact.len() - 1);
    snapshot.intact = Some(intact);
    snapshot.cracks[0].open_from_start = true;
    snapshot.cracks[0].time = Some(0.0);
    snapshot
}

/// Joints that soften are drawn where whole ones are asked for, also if none is whole any more.
#[test]
fn joints_that_soften_are_a_third_state() {
    let snapshot = Disc::new(8).snapshot(0.6);
    let count = snapshot.cracks.iter().filter(|crack| crack.time.is_none()).count();
    assert!(count > 2);
    let asked = Frame::new(&Snapshot { intact: Some(Vec::new()), ..snapshot.clone() }).unwrap();
    assert_eq!(Frame::from_bytes(&asked.to_bytes()).as_ref(), Ok(&asked));
    let frames = [asked, Frame::new(&snapshot).unwrap()];
    let drawn = frames.each_ref().map(|frame| pictures(&frames, Field::DAMAGE).svg(frame).unwrap());
    let [with, without] = drawn.each_ref().map(|svg| {
        let path = svg.split("class=\"softening\" d=\"").nth(1).map(|rest| rest.split('"').next().unwrap());
        (path.map_or(0, |path| path.matches('M').count()), svg.contains(">softening<"))
    });
    assert_eq!((with, without), ((count, true), (0, false)));
    let [with, without] =
        frames.each_ref().map(|frame| pictures(&frames, Field::DAMAGE).png(frame, None).unwrap());
    assert_ne!(with, without);
    let page = page_of(&frames);
    assert!(page.contains(&format!("\"holding\":[0,{count}]")) && page.contains("\"holding\":[0,0]"));
    assert!(page.contains("\"name\":\"softening\""));
}

/// The page of these frames, with nothing else.
fn page_of(frames: &[Frame]) -> String {
    let report = Report {
        title: "joints",
        facts: &[],
        plots: &[],
        frames,
        fragments: &Fragments::default(),
        field: Field::DAMAGE,
        names: &Names::default(),
    };
    report.html().unwrap()
}

#[test]
fn whole_joints_are_a_layer_of_files_pictures_and_pages() {
    let snapshot = whole_joints(Disc::new(8).snapshot(0.6));
    let count = snapshot.intact.iter().flatten().count();
    assert!(count > 2);
    let mut file = Vec::new();
    write_intact_joints_vtp(&mut file, &snapshot).unwrap();
    let text = String::from_utf8_lossy(&file[..1000]).into_owned();
    assert!(text.contains(&format!("NumberOfLines=\"{count}\"")), "{text}");

    let frame = Frame::new(&snapshot).unwrap();
    assert_eq!(Frame::from_bytes(&frame.to_bytes()).as_ref(), Ok(&frame));
    let without = Frame::new(&Snapshot { intact: None, ..snapshot.clone() }).unwrap();
    assert_ne!(frame, without);
    let frames = [frame, without];
    let drawn = frames.each_ref().map(|frame| pictures(&frames, Field::DAMAGE).svg(frame).unwrap());
    let [with, without] = drawn.each_ref().map(|svg| {
        let path = svg.split("class=\"whole\" d=\"").nth(1).map(|rest| rest.split('"').next().unwrap());
        (path.map_or(0, |path| path.matches('M').count()), svg.contains(">whole<"), svg.contains(">open<"))
    });
    // The legend names the joints that are open from the start, too.
    assert_eq!((with, without), ((count, true, true), (0, false, true)));
    let [with, without] =
        frames.each_ref().map(|frame| pictures(&frames, Field::DAMAGE).png(frame, None).unwrap());
    assert_ne!(with, without);
    let page = page_of(&frames);
    assert!(page.contains(&format!("\"holding\":[{count},0]")) && page.contains("\"holding\":[0,0]"));
}

#[test]
fn forces_of_elements_and_nodes_that_are_not_there_are_refused() {
    let snapshot = Disc::new(3).snapshot(0.5);
    let mut lost = Disc::forces(&snapshot);
    lost.contacts =
        vec![ContactForce { elements: [3, 54], point: [0.0; 2], normal: [1.0, 0.0], tangential: [0.0; 2] }];
    lost.reactions.pop();
    let mut out = Vec::new();
    let error = write_contacts_vtp(&mut out, &snapshot, &lost).unwrap_err();
    assert_eq!(error.to_string(), "a contact has element 54, but there are 54");
    let error = write_vtu(&mut out, &snapshot, &lost, &Names::default()).unwrap_err();
    let nodes = snapshot.positions.len();
    assert_eq!(
        error.to_string(),
        format!("the snapshot has {} reactions, where {nodes} are needed", nodes - 1)
    );
    let outlines = Outlines::default();
    assert!(matches!(
        Frame::outlined(&snapshot, &outlines),
        Err(SnapshotError::Length { name: "outlines", .. })
    ));
    assert!(out.is_empty());
}

/// A wall of bricks: `columns` by `rows`, two triangles each, one body for each row.
fn wall(columns: u32, rows: u32) -> (Mesh, Vec<u32>) {
    let (mut mesh, mut grains) = (Mesh::default(), Vec::new());
    for row in 0..rows {
        let first = mesh.nodes.len() as u32;
        for level in 0..2 {
            mesh.nodes.extend((0..=columns).map(|column| [f64::from(column), 0.5 * f64::from(row + level)]));
        }
        for column in 0..columns {
            let (a, c) = (first + column, first + columns + 1 + column);
            mesh.elements.extend([[a, a + 1, c + 1], [a, c + 1, c]]);
            mesh.bodies.extend([row; 2]);
            mesh.materials.extend([0; 2]);
            grains.extend([column; 2]);
        }
    }
    (mesh, grains)
}

#[test]
fn bodies_and_grains_have_outlines() {
    let (mesh, grains) = wall(6, 5);
    let count = mesh.elements.len();
    let snapshot = Snapshot {
        displacements: vec![[0.0; 2]; mesh.nodes.len()],
        velocities: vec![[0.0; 2]; mesh.nodes.len()],
        positions: mesh.nodes.clone(),
        elements: mesh.elements.clone(),
        stresses: vec![[0.0; 6]; count],
        damage: vec![0.0; count],
        bodies: mesh.bodies.clone(),
        materials: vec![0; count],
        fragments: mesh.bodies.clone(),
        ..Snapshot::default()
    };
    let outlined = Frame::outlined(&snapshot, &Outlines::new(&mesh, &grains)).unwrap();
    assert_eq!(Frame::from_bytes(&outlined.to_bytes()).as_ref(), Ok(&outlined));
    let frames = [outlined, Frame::new(&snapshot).unwrap()];
    let picture = pictures(&frames, Field::VON_MISES);
    let svg = picture.svg(&frames[0]).unwrap();
    let lines = |class: &str| {
        let path = svg.split(&format!("class=\"{class}\" d=\"")).nth(1).unwrap().split('"').next().unwrap();
        path.matches('M').count()
    };
    // Each row has two long sides of six edges and two short ones; five walls between its grains, from both
    // sides.
    assert_eq!((lines("bodies"), lines("grains")), (5 * 14, 5 * 10));
    assert!(!picture.svg(&frames[1]).unwrap().contains("class=\"bodies\""));
    // Pixels: without outlines the wall is of one colour.
    let [with, without] = [0, 1].map(|k| {
        let (width, height, all) = pixels(&picture.png(&frames[k], None).unwrap());
        let at = |x: usize, y: usize| all[3 * (y * width + x)];
        let row = 66 + (height - 66 - 74) / 2 - 20;
        let column = width / 2 + 20;
        [
            (30..width - 30).filter(|&x| at(x, row) < 190).count(),
            (80..height - 90).filter(|&y| at(column, y) < 190).count(),
        ]
    });
    assert_eq!(without, [0, 0]);
    assert!(with[0] >= 5 && with[1] >= 4, "{with:?}");
}

#[test]
fn a_title_is_whole_while_there_is_room() {
    let frames = frames(6, 3);
    let title = "A disc of sandstone between two platens, which splits along its loaded diameter";
    let svg = Pictures { title, ..pictures(&frames, Field::DAMAGE) }.svg(&frames[0]).unwrap();
    assert!(svg.matches(title).count() >= 2, "as the name of the picture, and in it");
    assert!(!svg.contains('…'));
}

#[test]
fn a_state_that_has_gone_wrong_is_still_drawn() {
    let mut snapshot = Disc::new(6).snapshot(0.6);
    snapshot.positions[3] = [f64::NAN, 0.0];
    snapshot.positions[40] = [1e300, -1e300];
    snapshot.positions[50] = [f64::INFINITY, 0.0];
    snapshot.velocities[5] = [f64::MAX, f64::MAX];
    snapshot.stresses[10] = [f64::NAN; 6];
    snapshot.stresses[11] = [f64::INFINITY, 0.0, 0.0, 0.0, 0.0, 0.0];
    snapshot.cracks[0].corners[0] = [f64::NAN; 2];
    let frames = [Frame::new(&snapshot).unwrap()];
    for field in Field::ALL {
        let pictures = pictures(&frames, field);
        let (width, height, all) = pixels(&pictures.png(&frames[0], Some(300)).unwrap());
        let coloured = all.chunks_exact(3).filter(|pixel| pixel.iter().any(|&x| x < 250)).count();
        assert!(coloured * 4 > width * height, "{field:?}: the disc is neither lost nor a dot");
        assert!(pictures.svg(&frames[0]).unwrap().matches("class=\"elements\"").count() > 0);
    }
    let report = Report {
        title: "gone",
        facts: &[],
        plots: &[],
        frames: &frames,
        fragments: &Fragments::default(),
        field: Field::VON_MISES,
        names: &Names::default(),
    };
    let page = report.html().unwrap();
    let meta = page.split("id=\"meta\">").nth(1).unwrap().split("</script>").next().unwrap();
    let without_spheres = meta.replace("\"grains\":null", "").replace("\"spheres\":null", "");
    assert_eq!(
        without_spheres.matches("null").count(),
        2,
        "of body and material, which are on no scale: every number is one"
    );
    // Nothing at all.
    let none = [Frame::new(&Snapshot::default()).unwrap()];
    assert!(pictures(&none, Field::DAMAGE).png(&none[0], None).is_ok());
    assert!(Report { frames: &none, ..report }.html().is_ok());
    assert!(Report { frames: &[], ..report }.html().is_ok());
}

#[test]
fn pixels_have_the_colours_of_their_elements() {
    let frames = frames(10, 11);
    let picture = pictures(&frames, Field::BODY);
    let (width, height, all) = pixels(&picture.png(&frames[0], None).unwrap());
    assert!((600..=900).contains(&width), "{width}");
    // The middle of the disc is the middle of the area, which is between 66 and 74 from top and bottom.
    let middle = 66 + (height - 66 - 74) / 2;
    let at = |x: usize, y: usize| [0, 1, 2].map(|k| all[3 * (y * width + x) + k]);
    let (left, right) = (at(width / 2 - 100, middle), at(width / 2 + 100, middle));
    assert_ne!(left, right, "two halves, two bodies");
    assert_ne!(left, [255; 3]);
    assert_eq!(at(width / 2 - 100, middle + 60), left);
    assert_eq!(at(5, middle), [255; 3]);
    // Every pixel of a body has its colour, one of white paper, one between them at the rim, or that of a
    // text.
    let of_bodies = all.chunks_exact(3).filter(|pixel| **pixel == left || **pixel == right).count();
    let area = std::f64::consts::PI * 346.0 * 346.0;
    assert!((0.9..1.05).contains(&(of_bodies as f64 / area)), "{of_bodies}");
}

#[test]
fn cracks_are_drawn_in_the_colours_of_their_modes() {
    let frames = frames(10, 11);
    let picture = pictures(&frames, Field::VON_MISES);
    let (first, last) = (picture.svg(&frames[0]).unwrap(), picture.svg(&frames[10]).unwrap());
    for class in ["class=\"tension\"", "class=\"shear\"", "class=\"mixed\""] {
        assert!(!first.contains(class) && last.contains(class), "{class}");
    }
    assert!(last.contains("of cracks") && last.contains("t = 2.000 ms") && first.contains("t = 0.000 ms"));
    assert!(last.contains("von Mises stress (MPa)"));
    let (_, _, before) = pixels(&picture.png(&frames[0], None).unwrap());
    let (_, _, after) = pixels(&picture.png(&frames[10], None).unwrap());
    let magenta = |pixels: &[u8]| pixels.chunks_exact(3).filter(|pixel| **pixel == [200, 0, 170]).count();
    assert_eq!(magenta(&before), 0);
    assert!(magenta(&after) > 40, "{}", magenta(&after));
}

#[test]
fn the_view_and_the_colours_are_those_of_the_series() {
    let frames = frames(8, 11);
    let view = FrameView::of(&frames);
    let range = Range::of(&frames, Field::MAX_PRINCIPAL);
    assert_eq!(range.low, -range.high, "no stress is in the middle");
    assert!(range.high > 5e6 && range.high < 3e7, "{range:?}");
    assert_eq!(Range::of(&frames[..1], Field::VELOCITY).low, 0.0);
    assert_eq!(Range::of(&frames, Field::DAMAGE), Range { low: 0.0, high: 1.0 });
    let pictures = Pictures { title: "disc", field: Field::MAX_PRINCIPAL, range, view };
    let sizes: BTreeSet<(usize, usize)> = frames
        .iter()
        .map(|frame| {
            let (width, height, _) = pixels(&pictures.png(frame, None).unwrap());
            (width, height)
        })
        .collect();
    assert_eq!(sizes.len(), 1);
    assert_eq!(
        pictures.png(&frames[0], Some(50)).unwrap_err(),
        PictureError::Width { found: 50, least: 200, most: 10_000 }
    );
    assert_eq!(pixels(&pictures.png(&frames[0], Some(450)).unwrap()).0, 450);
    assert_eq!(pictures.png(&frames[4], None).unwrap(), pictures.png(&frames[4], None).unwrap());
}

#[test]
fn a_fragment_that_flies_away_leaves_the_picture_instead_of_making_it_small() {
    let disc = Disc::new(6);
    let start = disc.snapshot(0.0);
    let mut later = disc.snapshot(0.9);
    let alone = later.elements[20];
    // A triangle far away, without its neighbours.
    let nodes = later.positions.len() as u32;
    for node in alone {
        let [x, y] = later.positions[node as usize];
        later.positions.push([x + 300.0 * RADIUS, y]);
        later.displacements.push([300.0 * RADIUS, 0.0]);
        later.velocities.push([1.0, 0.0]);
    }
    later.elements[20] = [nodes, nodes + 1, nodes + 2];
    let frames = [Frame::new(&start).unwrap(), Frame::new(&later).unwrap()];
    let svg = pictures(&frames, Field::BODY).svg(&frames[0]).unwrap();
    let before = pictures(&frames[..1], Field::BODY).svg(&frames[0]).unwrap();
    let scale = |svg: &str| svg.contains(">10 mm<") || svg.contains(">5 mm<");
    assert!(scale(&svg) && scale(&before), "millimetres, not metres");
}

#[test]
fn more_elements_than_a_browser_likes_are_an_image() {
    let frames = [Frame::new(&Disc::new(60).snapshot(0.7)).unwrap()];
    let svg = pictures(&frames, Field::DISPLACEMENT).svg(&frames[0]).unwrap();
    assert!(svg.contains("<image ") && !svg.contains("class=\"elements\""));
    assert!(svg.contains("21,600 elements"));
}

#[test]
fn an_animation_has_all_frames_and_the_last_is_that_of_the_picture() {
    let frames = frames(8, 9);
    let pictures = pictures(&frames, Field::VELOCITY);
    let made = || {
        let mut animation = Animation::new(pictures, Some(400), 8);
        for frame in &frames {
            animation.push(frame).unwrap();
        }
        animation.finish().unwrap()
    };
    let file = made();
    assert_eq!(file, made(), "the same bytes again");
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(&file[..]).unwrap();
    let (width, height) = (usize::from(decoder.width()), usize::from(decoder.height()));
    let mut screen = vec![0_u8; 4 * width * height];
    let mut delays = Vec::new();
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        delays.push(frame.delay);
        let [left, top, across] = [frame.left, frame.top, frame.width].map(usize::from);
        for (row, line) in frame.buffer.chunks_exact(4 * across).enumerate() {
            let at = 4 * ((top + row) * width + left);
            screen[at..at + line.len()].copy_from_slice(line);
        }
    }
    assert_eq!(delays, [8, 8, 8, 8, 8, 8, 8, 8, 150]);
    let (wide, high, expected) = pixels(&pictures.png(&frames[8], Some(400)).unwrap());
    assert_eq!((wide, high), (width, height));
    let (mut off, mut far) = (0_u64, 0);
    for (found, expected) in screen.chunks_exact(4).zip(expected.chunks_exact(3)) {
        let most = (0..3).map(|k| found[k].abs_diff(expected[k])).max().unwrap();
        off += u64::from(most);
        far += u32::from(most > 48);
    }
    let count = (width * height) as f64;
    assert!(off as f64 / count < 4.0, "256 colours: {}", off as f64 / count);
    assert!(f64::from(far) / count < 0.005, "{far}");
    assert_eq!(Animation::new(pictures, None, 8).finish().unwrap_err(), AnimationError::Empty);
}

fn history(rows: u32) -> History {
    let disc = Disc::new(8);
    let mut text = Vec::new();
    let names = ["force, \"upper\" <platen> [N]".to_owned(), "gap [m]".to_owned()];
    let mut writer = HistoryWriter::new(&mut text, 2, &names).unwrap();
    for k in 0..rows {
        let share = f64::from(k) / f64::from(rows);
        let snapshot = disc.snapshot(share);
        let (broken, lengths) = Row::broken_joints(&snapshot.cracks);
        let values = vec![-7.8e4 * share, if k == 5 { f64::NAN } else { 1e-4 * share }];
        let energies = Disc::energies(share);
        let number = snapshot.fragments.iter().max().map_or(0, |&last| u64::from(last) + 1);
        let fragments = FragmentCount { number, largest: 1.0 / number as f64 };
        writer
            .row(&Row {
                step: u64::from(k),
                time: snapshot.time,
                energies,
                broken,
                lengths,
                fragments,
                values,
            })
            .unwrap();
    }
    History::read(&text).unwrap()
}

#[test]
fn plots_show_every_column_with_its_unit() {
    let plots = plots(&history(50));
    let names: Vec<&str> = plots.iter().map(|plot| plot.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "energies",
            "energy_error",
            "crack_growth",
            "fragments",
            "histories_forces",
            "histories_displacements",
            "load_displacement"
        ]
    );
    let svg = |name: &str| &plots.iter().find(|plot| plot.name == name).unwrap().svg;
    assert_eq!(svg("energies").matches("class=\"curve\"").count(), 9);
    assert!(svg("energies").contains("energy (mJ)") && svg("energies").contains("time (ms)"));
    assert!(svg("crack_growth").contains("length (mm)"));
    assert!(svg("load_displacement").contains("(kN)") && svg("load_displacement").contains("gap (µm)"));
    assert!(
        svg("histories_forces").contains("&lt;platen&gt;") && !svg("histories_forces").contains("<platen>")
    );
    for plot in &plots {
        assert!(!plot.svg.contains("NaN"), "{}", plot.name);
        let (width, height, _) = pixels(&plot.png(None).unwrap());
        assert_eq!((width, height), (1280, 720));
    }
    // One row, and none, are no reason to fail.
    for rows in [0, 1] {
        for plot in fdem_results::plots(&history(rows)) {
            assert!(!plot.svg.contains("NaN") && !plot.svg.contains("inf"), "{} of {rows} rows", plot.name);
        }
    }
}

/// Each rank is a level of the curves: the second one, with twice the elements, is twice as high.
#[test]
fn ranks_are_drawn_as_levels() {
    let rank = |own: f64| RankLoad { own, halo: 0.0, bytes: 800.0 };
    let [elements, messages] = rank_loads(&[rank(1000.0), rank(2000.0)]);
    assert_eq!([&*elements.name, &*messages.name], ["ranks_elements", "ranks_messages"]);
    let first = elements.svg.split("class=\"curve\" d=\"M").nth(1).unwrap().split('"').next().unwrap();
    let heights = first.split(['L', ' ']).skip(1).step_by(2).map(|y| y.parse().unwrap());
    let heights: Vec<f64> = heights.collect();
    // The axis is 308 down.
    let [floor, low, high] = [308.0, heights[0], heights[2]];
    assert_eq!((heights[0], heights[2]), (heights[1], heights[3]), "{first}");
    assert!(((floor - high) / (floor - low) - 2.0).abs() < 0.01, "{first}");
    assert!(
        messages.svg.contains("sent (B)") && !messages.svg.contains(">0.5<") && messages.png(None).is_ok()
    );
}

#[test]
fn the_page_is_whole_safe_and_says_what_it_leaves_out() {
    let frames = frames(4, 150);
    let plots = plots(&history(20));
    let hostile = r#"</script><img src=x onerror="alert(1)">'{{script}}"#;
    let facts = [("model", hostile), (hostile, "1")];
    let report = Report {
        title: hostile,
        facts: &facts,
        plots: &plots,
        frames: &frames,
        fragments: &Fragments::default(),
        field: Field::DAMAGE,
        names: &Names { bodies: vec![hostile.to_owned()], materials: vec![hostile.to_owned()] },
    };
    let page = report.html().unwrap();
    assert_eq!(page, report.html().unwrap(), "the same bytes again");
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>\n"));
    assert!(!page.contains("<img src=x"));
    assert_eq!(page.matches("class=\"frame\"").count(), MOST_FRAMES);
    assert_eq!(page.matches("</script>").count(), MOST_FRAMES + 2, "no text ends a script");
    assert!(page.contains("121 of 150 frames are in this page; the others are in the folder of frames."));
    assert!(page.contains("<option value=\"damage\" selected>"));
    assert_eq!(page.matches("<figure><svg").count(), plots.len());
    for address in ["http://", "https://"] {
        assert!(page.split(address).skip(1).all(|rest| rest.starts_with("www.w3.org")), "{address}");
    }
    for handler in ["onclick=", "onload=", "javascript:", " style="] {
        assert!(!page.contains(handler), "{handler} would need a weaker policy");
    }
    let few = Report { frames: &frames[..3], ..report }.html().unwrap();
    assert!(!few.contains("frames are in this page"));
    let one = Report { frames: &frames[..=MOST_FRAMES], ..report }.html().unwrap();
    assert!(one.contains("121 of 122 frames are in this page; frame 120 is left out."));
}
