//! Spheres and walls in frames, pictures, pages and files for ParaView.

use std::io::ErrorKind;

use fdem_results::{
    Animation, Field, Fragments, Frame, FrameView, Names, Pictures, QUANTITIES, QuantityValues, Range,
    Report, Shell, Show, SnapshotError, SpaceAnimation, SpaceFrame, SpacePictures, SpaceReport, SpaceView,
    write_sphere_contacts_vtp, write_spheres_vtp, write_walls_vtp,
};
use fdem_simulation::grains::{GrainContact, GrainPartner, SphereColumns, Wall, WallShape};
use fdem_simulation::{Forces, Mesh, Snapshot};

/// Three spheres in a row on a floor: the first two press each other, the third the floor.
fn spheres(discs: Option<f64>) -> SphereColumns {
    let up = if discs.is_some() { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] };
    let at = |x: f64| [x, 0.5 * up[1], 0.5 * up[2]];
    let contact = |sphere, other, place, normal| GrainContact {
        sphere,
        other,
        place,
        force: [normal, 0.0, 0.0],
        normal,
        overlap: 1e-3,
    };
    SphereColumns {
        numbers: vec![2, 5, 9],
        positions: vec![at(0.5), at(1.5), at(3.0)],
        radii: vec![0.5, 0.501, 0.4],
        velocities: vec![[3.0, 4.0, 0.0], [0.0; 3], [0.0, 0.0, -1.0]],
        spins: vec![[0.0, 0.0, 7.0]; 3],
        forces: vec![[0.0; 3]; 3],
        masses: vec![1.0, 2.0, 3.0],
        materials: vec![0, 1, 0],
        groups: vec![0, 0, 1],
        group_names: vec!["sand".to_owned(), "</script><b>".to_owned()],
        contacts: vec![
            contact(0, GrainPartner::Sphere(1), at(1.0), 20.0),
            contact(2, GrainPartner::Wall(0), [3.0, 0.0, 0.0], 10.0),
        ],
        walls: vec![Wall { name: "floor".to_owned(), ..Wall::plane([0.0; 3], up, 0) }],
        wall_forces: vec![up.map(|x| -10.0 * x)],
        discs,
        period: None,
    }
}

fn plane(spheres: SphereColumns) -> Snapshot {
    Snapshot { time: 0.5, step: 7, spheres, ..Snapshot::default() }
}

fn space(spheres: SphereColumns) -> Snapshot<3, 4> {
    Snapshot { time: 0.5, step: 7, spheres, ..Snapshot::default() }
}

/// A tetrahedron with spheres.
fn with_body(spheres: SphereColumns) -> (Snapshot<3, 4>, Shell) {
    let mesh = Mesh {
        nodes: vec![[0.2, -3.0, 0.0], [1.0, -3.0, 0.0], [0.6, -3.0, 0.9], [0.6, -2.0, 0.3]],
        elements: vec![[0, 2, 1, 3]],
        bodies: vec![0],
        materials: vec![0],
    };
    let snapshot = Snapshot {
        positions: mesh.nodes.clone(),
        displacements: vec![[0.0; 3]; 4],
        velocities: vec![[0.0; 3]; 4],
        elements: mesh.elements.clone(),
        stresses: vec![[1e6, 0.0, 0.0, 0.0, 0.0, 0.0]],
        damage: vec![0.0],
        bodies: vec![0],
        materials: vec![0],
        fragments: vec![0],
        ..space(spheres)
    };
    (snapshot, Shell::new(&mesh, &[]))
}

fn pixels(file: &[u8]) -> (usize, Vec<[u8; 3]>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().expect("a picture");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut pixels).expect("pixels");
    (info.width as usize, pixels.as_chunks().0.to_vec())
}

fn flat_pictures(frames: &[Frame], field: Field) -> Pictures<'static> {
    Pictures { title: "discs", field, range: Range::of(frames, field), view: FrameView::of(frames) }
}

fn pictures(frames: &[SpaceFrame], field: Field) -> SpacePictures<'static> {
    let (range, view) = (Range::of_space(frames, field), SpaceView::of(frames));
    SpacePictures { title: "spheres", field, range, view, show: Show::Solid, cut: None }
}

#[test]
fn frames_with_spheres_come_back_and_damaged_ones_are_refused() {
    let flat = Frame::new(&plane(spheres(Some(0.1)))).unwrap();
    let bytes = flat.to_bytes();
    assert_eq!(Frame::from_bytes(&bytes).as_ref(), Ok(&flat));
    assert_eq!(flat.counts(), [0, 3]);
    let (snapshot, shell) = with_body(spheres(None));
    let frame = SpaceFrame::new(&snapshot, &shell).unwrap();
    let of_space = frame.to_bytes();
    assert_eq!(SpaceFrame::from_bytes(&of_space).as_ref(), Ok(&frame));
    assert_eq!(frame.counts(), [1, 3]);
    for end in 0..bytes.len() {
        assert!(Frame::from_bytes(&bytes[..end]).is_err(), "cut at {end}");
    }
    // Whatever is changed, there is no panic, neither here nor when it is drawn.
    for place in 8..of_space.len() {
        for flip in [1, 0x80, 0xff] {
            let mut damaged = of_space.clone();
            damaged[place] ^= flip;
            if let Ok(frame) = SpaceFrame::from_bytes(&damaged) {
                let frames = [frame];
                if place % 8 == 0 {
                    let _ = pictures(&frames, Field::VELOCITY).png(&frames[0], Some(200));
                }
            }
        }
    }
}

#[test]
fn spheres_that_contradict_themselves_are_refused() {
    let mut short = spheres(None);
    short.spins.pop();
    let mut lost = spheres(None);
    lost.contacts[0].other = GrainPartner::Sphere(3);
    let mut gone = spheres(None);
    gone.contacts[1].other = GrainPartner::Wall(1);
    for (columns, expected) in [
        (short, "the snapshot has 2 spins, where 3 are needed"),
        (lost, "a contact has sphere 3, but there are 3"),
        (gone, "a contact has wall 1, but there are 1"),
    ] {
        let snapshot = space(columns);
        let error: SnapshotError = SpaceFrame::new(&snapshot, &Shell::default()).unwrap_err();
        assert_eq!(error.to_string(), expected);
        let error = write_sphere_contacts_vtp(&mut Vec::new(), &snapshot).unwrap_err();
        assert_eq!((error.kind(), error.to_string().as_str()), (ErrorKind::InvalidInput, expected));
    }
}

#[test]
fn files_for_paraview_have_points_lines_and_walls() {
    let snapshot = space(spheres(None));
    let mut files: [Vec<u8>; 3] = Default::default();
    write_spheres_vtp(&mut files[0], &snapshot).unwrap();
    write_sphere_contacts_vtp(&mut files[1], &snapshot).unwrap();
    write_walls_vtp(&mut files[2], &snapshot).unwrap();
    let heads = files.map(|file| String::from_utf8_lossy(&file[..file.len().min(3500)]).into_owned());
    for (head, names, counts) in [
        (
            &heads[0],
            &["number", "radius", "velocity", "spin", "force", "mass", "coordination", "group", "material"][..],
            "NumberOfPoints=\"3\" NumberOfVerts=\"3\" NumberOfLines=\"0\"",
        ),
        (
            &heads[1],
            &["force", "normal_force", "overlap", "kind", "couple"],
            "NumberOfPoints=\"4\" NumberOfVerts=\"0\" NumberOfLines=\"2\"",
        ),
        (
            &heads[2],
            &["wall", "force", "material"],
            "NumberOfPoints=\"6\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"2\"",
        ),
    ] {
        assert!(head.contains(counts), "{head}");
        for name in names {
            assert!(head.contains(&format!("Name=\"{name}\"")), "{name} in {head}");
        }
    }
    let mut lines = Vec::new();
    write_walls_vtp(&mut lines, &plane(spheres(Some(0.1)))).unwrap();
    assert!(String::from_utf8_lossy(&lines[..900]).contains("NumberOfLines=\"1\""), "a segment in the plane");
}

#[test]
fn programs_read_the_values_of_spheres() {
    let snapshot = space(spheres(None));
    let values = |place: &str, key: &str| {
        let row = QUANTITIES.iter().find(|row| row.place.word() == place && row.key == key).unwrap();
        row.values_of(&snapshot, &Forces::default()).unwrap()
    };
    assert_eq!(values("sphere", "radius"), QuantityValues::Real(vec![0.5, 0.501, 0.4]));
    assert_eq!(values("sphere", "coordination"), QuantityValues::Whole(vec![1, 1, 1]));
    assert_eq!(values("sphere contact", "couple"), QuantityValues::Whole(vec![2, 5, 9, 0]));
    assert_eq!(values("sphere contact", "kind"), QuantityValues::Whole(vec![0, 1]));
    assert_eq!(values("wall", "force"), QuantityValues::Real(vec![0.0, 0.0, -10.0]));
}

/// Discs are drawn without any mesh, as circles of their sizes, and by the colours of the field.
#[test]
fn discs_are_circles() {
    let frames = [Frame::new(&plane(spheres(Some(0.1)))).unwrap()];
    let drawn = flat_pictures(&frames, Field::VELOCITY);
    let svg = drawn.svg(&frames[0]).unwrap();
    assert_eq!(svg.matches("<circle").count(), 3);
    assert!(
        svg.contains("step 7, 3 discs") && svg.contains("velocity (m/s)") && svg.contains("class=\"walls\"")
    );
    let radii: Vec<f64> =
        svg.split(" r=\"").skip(1).map(|rest| rest.split('"').next().unwrap().parse().unwrap()).collect();
    assert!((radii[1] / radii[2] - 0.501 / 0.4).abs() < 1e-3, "{radii:?}");
    // The area of the coloured pixels is that of the discs.
    let (width, seen) = pixels(&drawn.png(&frames[0], None).unwrap());
    let rows = seen.len() / width;
    let area = |seen: &[[u8; 3]]| {
        let inside = |k: &usize| (80..rows - 90).contains(&(k / width));
        (0..seen.len()).filter(inside).filter(|&k| seen[k] != [255; 3]).count() as f64
    };
    let expected = std::f64::consts::PI * radii.iter().map(|radius| radius * radius).sum::<f64>();
    assert!((area(&seen) / expected - 1.0).abs() < 0.05, "{} {expected}", area(&seen));
    // The slow and the fast one have the two ends of the scale.
    let fills: Vec<&str> = svg
        .split("<circle")
        .skip(1)
        .map(|rest| rest.split("fill=\"").nth(1).unwrap().split('"').next().unwrap())
        .collect();
    assert_eq!(fills[1], "#c7e593");
    assert_ne!(fills[0], fills[1]);
    let chains = flat_pictures(&frames, Field::FORCE_CHAINS).svg(&frames[0]).unwrap();
    assert!(chains.contains("normal force of contacts (N)"));
    assert!(chains.matches("<path").count() >= svg.matches("<path").count() + 2, "two contacts");
}

/// A body before the spheres hides them; one behind them is hidden.
#[test]
fn spheres_stand_among_bodies() {
    let (snapshot, shell) = with_body(spheres(None));
    let mut behind = snapshot.clone();
    for node in &mut behind.positions {
        node[1] += 6.0;
    }
    let alone = space(spheres(None));
    let frames = [
        SpaceFrame::new(&snapshot, &shell).unwrap(),
        SpaceFrame::new(&behind, &shell).unwrap(),
        SpaceFrame::new(&alone, &Shell::default()).unwrap(),
    ];
    let view = SpaceView::of(&frames).seen_from(0.0, 0.0);
    let drawn = SpacePictures { view, ..pictures(&frames, Field::MAX_PRINCIPAL) };
    let count = |frame: &SpaceFrame| {
        let (_, seen) = pixels(&drawn.png(frame, None).unwrap());
        // Stress colours the body dark red; spheres have the pale colours of their groups.
        seen.iter().filter(|[r, g, b]| i32::from(*r) > 2 * i32::from(*g) + 20 && *r / 2 > *b).count()
    };
    let [before, after, none] = [0, 1, 2].map(|k| count(&frames[k]));
    assert!(before > 5 * after && after > 2 * none, "{before} {after} {none}");
    let svg = drawn.svg(&frames[2]).unwrap();
    assert!(svg.contains("step 7, 3 spheres"), "pictures need no mesh");
}

#[test]
fn a_cut_takes_spheres_away() {
    let frames = [SpaceFrame::new(&space(spheres(None)), &Shell::default()).unwrap()];
    let whole = pictures(&frames, Field::GROUP);
    let cut = SpacePictures { cut: Some(fdem_results::Cut::across(0, 2.0)), ..whole };
    let count = |pictures: &SpacePictures<'_>| {
        let (_, seen) = pixels(&pictures.png(&frames[0], None).unwrap());
        // The second group.
        seen.iter().filter(|[r, g, b]| b > r && r > g).count()
    };
    assert!(count(&whole) > 500 && count(&cut) < count(&whole) / 10, "{} {}", count(&whole), count(&cut));
}

#[test]
fn animations_of_spheres_move() {
    let mut moved = spheres(None);
    moved.positions[2][0] += 0.5;
    let frames =
        [spheres(None), moved].map(|spheres| SpaceFrame::new(&space(spheres), &Shell::default()).unwrap());
    let mut film = SpaceAnimation::new(pictures(&frames, Field::VELOCITY), Some(300), 10);
    for frame in &frames {
        film.push(frame).unwrap();
    }
    let gif = film.finish().unwrap();
    assert!(gif.starts_with(b"GIF89a") && gif.len() > 2000);
    let frames = [Frame::new(&plane(spheres(Some(0.1)))).unwrap()];
    let mut film = Animation::new(flat_pictures(&frames, Field::FORCE_CHAINS), Some(300), 10);
    film.push(&frames[0]).unwrap();
    assert!(film.finish().unwrap().starts_with(b"GIF89a"));
}

#[test]
fn pages_have_spheres_and_are_safe() {
    let frames = [SpaceFrame::new(&space(spheres(None)), &Shell::default()).unwrap()];
    let page = |frames: &[SpaceFrame]| {
        let report = SpaceReport {
            title: "spheres",
            facts: &[],
            plots: &[],
            frames,
            fragments: &Fragments::default(),
            field: Field::FORCE_CHAINS,
            names: &Names::default(),
        };
        report.html(None).unwrap()
    };
    let with = page(&frames);
    assert!(with.contains("id=\"sphere-field\"") && with.contains("id=\"show-chains\" checked"));
    assert!(with.contains("3 spheres") && with.contains("class Grains") && !with.contains("<b>"));
    assert_eq!(with.matches("class=\"frame\"").count(), 3, "surface, inside and spheres");
    let without = page(&[SpaceFrame::new(&Snapshot::default(), &Shell::default()).unwrap()]);
    assert!(!without.contains("sphere-field") && !without.contains("class Grains"));
    let frames = [Frame::new(&plane(spheres(Some(0.1)))).unwrap()];
    let report = Report {
        title: "discs",
        facts: &[],
        plots: &[],
        frames: &frames,
        fragments: &Fragments::default(),
        field: Field::VELOCITY,
        names: &Names::default(),
    };
    let flat = report.html().unwrap();
    assert!(flat.contains("3 discs") && flat.contains("<legend>Discs</legend>"));
}

/// A contact through the boundary of a periodic box leads to the image beside its sphere.
#[test]
fn contacts_through_a_periodic_boundary_are_short() {
    let mut columns = spheres(None);
    columns.positions[1] = [9.6, 0.0, 0.5];
    columns.period = Some([[0.0; 3], [10.0, f64::INFINITY, f64::INFINITY]]);
    let mut apart = columns.clone();
    apart.period = None;
    let frames = [columns, apart].map(|columns| SpaceFrame::new(&space(columns), &Shell::default()).unwrap());
    let dark = |frame: &SpaceFrame| {
        let drawn = SpacePictures { view: SpaceView::of(&frames), ..pictures(&frames, Field::FORCE_CHAINS) };
        let (_, seen) = pixels(&drawn.png(frame, None).unwrap());
        seen.iter().filter(|[r, g, _]| i32::from(*r) > i32::from(*g) + 25).count()
    };
    let [near, far] = [0, 1].map(|k| dark(&frames[k]));
    assert!(3 * near < far && near > 100, "{near} {far}");
}

#[test]
fn walls_of_all_shapes_are_drawn_and_written() {
    let mut columns = spheres(None);
    let wall = |shape| Wall { shape, ..Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 0) };
    columns.walls = vec![
        wall(WallShape::Tube { axis: [[1.5, 0.0, 0.0], [1.5, 0.0, 1.0]], radius: 2.0 }),
        wall(WallShape::Cone { axis: [[1.5, 0.0, 2.0], [1.5, 0.0, 3.0]], radii: [0.5, 2.0] }),
        wall(WallShape::Disc { centre: [1.5, 0.0, 0.0], normal: [0.0, 0.0, 1.0], radius: 2.0 }),
        wall(WallShape::Mesh { triangles: vec![[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]] }),
    ];
    columns.wall_forces = vec![[0.0; 3]; 4];
    let snapshot = space(columns);
    let mut file = Vec::new();
    write_walls_vtp(&mut file, &snapshot).unwrap();
    let expected = format!("NumberOfPolys=\"{}\"", 96 + 96 + 48 + 1);
    assert!(String::from_utf8_lossy(&file[..1200]).contains(&expected));
    let frames = [SpaceFrame::new(&snapshot, &Shell::default()).unwrap()];
    let bare = [SpaceFrame::new(&space(spheres(None)), &Shell::default()).unwrap()];
    let drawn = |frames: &[SpaceFrame]| pictures(frames, Field::VELOCITY).png(&frames[0], None).unwrap();
    assert_ne!(drawn(&frames), drawn(&bare));
}
