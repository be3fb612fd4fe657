//! Pictures and animations of frames in three dimensions: the drawn parts and their places, the texts around
//! them, the same bytes.

use std::io::Cursor;

use fdem_results::picture::PictureError;
use fdem_results::{
    AnimationError, Cut, Field, Range, Shell, Show, SpaceAnimation, SpaceFrame, SpacePictures, SpaceView,
};
use fdem_simulation::{Crack, Mesh, Mode, Snapshot};

/// A bar of `cells` unit cubes along x, each of six tetrahedra around its diagonal.
fn bar(cells: usize) -> Mesh<3, 4> {
    let number = |[i, j, k]: [usize; 3]| ((k * 2 + j) * (cells + 1) + i) as u32;
    let mut mesh = Mesh::default();
    for place in 0..4 * (cells + 1) {
        let (i, rest) = (place % (cells + 1), place / (cells + 1));
        mesh.nodes.push([i as f64, (rest % 2) as f64, (rest / 2) as f64]);
    }
    for cell in 0..cells {
        for (order, odd) in [
            ([0, 1, 2], false),
            ([1, 2, 0], false),
            ([2, 0, 1], false),
            ([0, 2, 1], true),
            ([1, 0, 2], true),
            ([2, 1, 0], true),
        ] {
            let mut at = [cell, 0, 0];
            let mut element = [number(at); 4];
            for (corner, axis) in (1..).zip(order) {
                at[axis] += 1;
                element[corner] = number(at);
            }
            if odd {
                element.swap(0, 1);
            }
            mesh.elements.push(element);
            mesh.bodies.push(cell as u32);
            mesh.materials.push(0);
        }
    }
    mesh
}

/// A bar of four cubes whose right half is moved by `gap`: cracks are between the second and the third cube,
/// if `broken`. The stress along x is 1e6 in the first cube, 2e6 in the second and so on.
fn snapshot(mesh: &Mesh<3, 4>, gap: f64, broken: bool) -> Snapshot<3, 4> {
    let count = mesh.elements.len();
    // Each element has its own nodes.
    let right = |element: usize| element >= 12;
    let place = |element: usize, node: u32| {
        let [x, y, z] = mesh.nodes[node as usize];
        [x + if right(element) { gap } else { 0.0 }, y, z]
    };
    let positions: Vec<[f64; 3]> =
        (0..count).flat_map(|element| mesh.elements[element].map(|node| place(element, node))).collect();
    let mut cracks = Vec::new();
    for one in 6..12 {
        for other in 12..18 {
            let shared: Vec<u32> =
                mesh.elements[one].into_iter().filter(|node| mesh.elements[other].contains(node)).collect();
            if let (true, &[a, b, c]) = (broken, &shared[..]) {
                cracks.push(Crack {
                    corners: [a, b, c].map(|node| {
                        let [x, y, z] = mesh.nodes[node as usize];
                        [x + gap / 2.0, y, z]
                    }),
                    elements: [one as u32, other as u32],
                    damage: 1.0,
                    mode: if cracks.is_empty() { Mode::Tension } else { Mode::Shear },
                    opening: gap,
                    sliding: 0.0,
                    time: Some(1e-3),
                    measure: 0.5,
                    open_from_start: false,
                    softens: None,
                    dissipated: 1.0,
                });
            }
        }
    }
    let stress = |element: usize| [1e6 * (element / 6 + 1) as f64, 0.0, 0.0, 0.0, 0.0, 0.0];
    Snapshot {
        step: 1200,
        time: 1e-3 * (1.0 + gap),
        displacements: vec![[0.0; 3]; positions.len()],
        velocities: vec![[0.0; 3]; positions.len()],
        elements: (0..count as u32).map(|k| [0, 1, 2, 3].map(|corner| 4 * k + corner)).collect(),
        positions,
        stresses: (0..count).map(stress).collect(),
        damage: vec![0.0; count],
        bodies: mesh.bodies.clone(),
        materials: mesh.materials.clone(),
        fragments: (0..count).map(|element| u32::from(broken && right(element))).collect(),
        cracks,
        ..Snapshot::default()
    }
}

fn frame(gap: f64, broken: bool) -> SpaceFrame {
    let mesh = bar(4);
    SpaceFrame::new(&snapshot(&mesh, gap, broken), &Shell::new(&mesh, &[])).expect("a frame")
}

const RANGE: Range = Range { low: -4e6, high: 4e6 };

/// Pictures from the front.
fn pictures(frames: &[SpaceFrame]) -> SpacePictures<'static> {
    SpacePictures {
        title: "A bar",
        field: Field::MAX_PRINCIPAL,
        range: RANGE,
        view: SpaceView::of(frames).seen_from(0.0, 0.0),
        show: Show::Solid,
        cut: None,
    }
}

fn pixels(png: &[u8]) -> (usize, usize, Vec<u8>) {
    let mut reader = png::Decoder::new(Cursor::new(png)).read_info().expect("a PNG file");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut pixels).expect("pixels");
    assert_eq!(info.color_type, png::ColorType::Rgb);
    (info.width as usize, info.height as usize, pixels)
}

/// Colours of a picture at places of the bar from the front, x from 0 to 4 and z from 0 to 1.
fn colours<const N: usize>(png: &[u8], places: [[f64; 2]; N]) -> [[u8; 3]; N] {
    let (width, _, pixels) = pixels(png);
    assert_eq!(width, 900);
    // The drawing is 852 wide, with 8 on each side; the bar is in its middle, 836 wide and 209 high, below a
    // head of 66.
    places.map(|[x, z]| {
        let (column, row) = (24.0 + 8.0 + 209.0 * x, 66.0 + 8.0 + 209.0 * (1.0 - z));
        let place = 3 * (row as usize * width + column as usize);
        [pixels[place], pixels[place + 1], pixels[place + 2]]
    })
}

#[test]
fn elements_have_the_colours_of_their_values() {
    let frames = [frame(0.0, false)];
    let all = pictures(&frames);
    let places = [0.4, 1.4, 2.4, 3.4].map(|x| [x, 0.2]);
    let found = colours(&all.png(&frames[0], None).unwrap(), places);
    // Redder from left to right.
    for pair in found.windows(2) {
        assert!(pair[0][1] > pair[1][1], "{found:?}");
    }
    // Values beyond an end have the colour of the end.
    let png =
        |high: f64| SpacePictures { range: Range { low: -high, high }, ..all }.png(&frames[0], None).unwrap();
    let narrow = colours(&png(2e6), places);
    assert_eq!((narrow[1], narrow[2], narrow[3]), (found[3], found[3], found[3]));
    let bodies = SpacePictures { field: Field::BODY, ..all }.png(&frames[0], None).unwrap();
    let mut bodies = colours(&bodies, places).to_vec();
    bodies.dedup();
    assert_eq!(bodies.len(), 4);
}

#[test]
fn values_that_are_no_numbers_are_grey() {
    let mesh = bar(4);
    let mut snapshot = snapshot(&mesh, 0.0, false);
    for stress in &mut snapshot.stresses[6..12] {
        stress[0] = f64::NAN;
    }
    let frame = SpaceFrame::new(&snapshot, &Shell::new(&mesh, &[])).unwrap();
    let found =
        colours(&pictures(std::slice::from_ref(&frame)).png(&frame, None).unwrap(), [[0.4, 0.2], [1.4, 0.2]]);
    let grey = |[r, g, b]: [u8; 3]| r.abs_diff(b) < 8 && g.abs_diff(b) < 6;
    assert!(!grey(found[0]) && grey(found[1]), "{found:?}");
}

#[test]
fn elements_whose_places_are_no_numbers_are_not_drawn() {
    let mesh = bar(4);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut snapshot = snapshot(&mesh, 0.0, false);
        for node in &mut snapshot.positions[4 * 6..4 * 12] {
            node[1] = bad;
        }
        let frame = SpaceFrame::new(&snapshot, &Shell::new(&mesh, &[])).unwrap();
        let view = SpaceView::of([&frame]).seen_from(0.0, 0.0);
        for cut in [None, Some(Cut::across(1, 0.5))] {
            let png = SpacePictures { view, cut, ..pictures(&[]) }.png(&frame, None).unwrap();
            let found = colours(&png, [[0.4, 0.2], [1.4, 0.2], [2.4, 0.2]]);
            assert!(found[0] != [255; 3] && found[1] == [255; 3] && found[2] != [255; 3], "{bad} {found:?}");
        }
    }
    let mut nowhere = snapshot(&mesh, 0.0, false);
    nowhere.positions.fill([f64::NAN; 3]);
    let mut point = snapshot(&mesh, 0.0, true);
    point.positions.fill([3.0, -1.0, 2.0]);
    // Too many for being outliers.
    let mut far = snapshot(&mesh, 0.0, true);
    far.positions[4 * 6..4 * 12].fill([1e300, 0.0, -1e300]);
    for snapshot in [nowhere, point, far] {
        let frame = SpaceFrame::new(&snapshot, &Shell::new(&mesh, &[])).unwrap();
        let view = SpaceView::of([&frame]);
        for (show, cut) in [
            (Show::Solid, None),
            (Show::Solid, Some(Cut::across(0, 3.0))),
            (Show::Solid, Some(Cut { normal: [0.0; 3], offset: f64::NAN })),
            (Show::Cracks, None),
            (Show::Cracks, Some(Cut::across(0, 3.0))),
        ] {
            let pictures = SpacePictures { view, show, cut, ..pictures(&[]) };
            assert!(pictures.png(&frame, Some(300)).is_ok());
        }
    }
}

#[test]
fn empty_frames_and_strange_views_are_drawn() {
    let frame = SpaceFrame::new(&Snapshot::default(), &Shell::default()).unwrap();
    let empty = SpacePictures { view: SpaceView::of([&frame]), ..pictures(&[]) };
    assert!(empty.png(&frame, None).is_ok());
    for [azimuth, elevation] in [[f64::NAN, f64::INFINITY], [1e300, -1e9], [0.0, 90.0]] {
        let view = SpaceView::of(&[]).seen_from(azimuth, elevation);
        assert!(SpacePictures { view, ..empty }.png(&frame, Some(200)).is_ok());
    }
    let error = empty.png(&frame, Some(100)).unwrap_err();
    assert_eq!(error, PictureError::Width { found: 100, least: 200, most: 10_000 });
}

#[test]
fn coordinates_as_large_as_numbers_are_too_wide() {
    let mesh = bar(4);
    let mut snapshot = snapshot(&mesh, 0.0, false);
    for (k, node) in snapshot.positions.iter_mut().enumerate() {
        *node = node.map(|x| if k % 2 == 0 { 1.7e308 * (x - 0.5).signum() } else { x });
    }
    let frame = SpaceFrame::new(&snapshot, &Shell::new(&mesh, &[])).unwrap();
    let result = SpacePictures { view: SpaceView::of([&frame]), ..pictures(&[]) }.png(&frame, None);
    assert!(result.is_ok() || result == Err(PictureError::TooWide));
}

#[test]
fn a_cut_shows_the_inside_in_the_colours_of_the_scale() {
    let frames = [frame(0.0, false)];
    let places = [[0.4, 0.2], [3.4, 0.2]];
    let field = Field::BODY;
    let cut = |offset: f64| SpacePictures { field, cut: Some(Cut::across(1, offset)), ..pictures(&frames) };
    // The section is without light: the colours of the first and of the fourth body.
    let expected = [[127, 172, 214], [222, 180, 120]];
    assert_eq!(colours(&cut(0.5).png(&frames[0], None).unwrap(), places), expected);
    // The same plane with the opposite normal.
    let turned = Cut { normal: [0.0, -2.0, 0.0], offset: -1.0 };
    let png = SpacePictures { cut: Some(turned), ..cut(0.0) }.png(&frames[0], None).unwrap();
    assert_eq!(png, cut(0.5).png(&frames[0], None).unwrap());
    let all = cut(-1.0).png(&frames[0], None).unwrap();
    assert_eq!(
        all,
        SpacePictures { cut: None, ..cut(0.0) }.png(&frames[0], None).unwrap(),
        "nothing is before it"
    );
    assert_eq!(colours(&cut(2.0).png(&frames[0], None).unwrap(), places), [[255; 3]; 2], "nothing is left");
    // A frame without the elements inside shows the surface open.
    let mesh = bar(4);
    let shell = Shell::new(&mesh, &[]);
    let open = SpaceFrame::with_inside(&snapshot(&mesh, 0.0, false), &shell, 0).unwrap();
    let found = colours(&cut(0.5).png(&open, None).unwrap(), places);
    assert!(
        found.iter().zip(expected).all(|(found, whole)| *found != whole && *found != [255; 3]),
        "{found:?}"
    );
}

#[test]
fn cracks_are_dark_lines_on_the_surface_and_facets_in_their_own_view() {
    let frames = [frame(0.0, false), frame(0.0, true)];
    let pictures = pictures(&frames);
    let places = [[2.0, 0.3], [2.0, 0.7], [1.0, 0.3]];
    let [whole, broken] = [0, 1].map(|k| colours(&pictures.png(&frames[k], None).unwrap(), places));
    assert!(
        whole[0] != [17, 24, 39] && whole[1] != [17, 24, 39] && whole[2] == broken[2],
        "{whole:?} {broken:?}"
    );
    assert_eq!([broken[0], broken[1]], [[17, 24, 39]; 2]);
    let svg = pictures.svg(&frames[1]).unwrap();
    assert!(svg.contains(">cracks<") && !pictures.svg(&frames[0]).unwrap().contains(">cracks<"));
    assert!(svg.contains("2 pieces, 1 m² of cracks"));
    // From the right the crack is a square of two triangles, in the colours of two modes.
    let view = pictures.view.seen_from(90.0, 0.0);
    let cracks = SpacePictures { show: Show::Cracks, view, ..pictures };
    let (width, height, pixels) = pixels(&cracks.png(&frames[1], None).unwrap());
    let at = |x: f64, z: f64| {
        let side = (height - 66 - 74) as f64;
        let place = [width as f64 / 2.0 + (x - 0.5) * side, 66.0 + (1.0 - z) * side].map(|x| x as usize);
        let place = 3 * (place[1] * width + place[0]);
        [pixels[place], pixels[place + 1], pixels[place + 2]]
    };
    let mut found = [at(0.3, 0.7), at(0.7, 0.3)];
    found.sort_unstable();
    assert!(found[0].iter().all(|&channel| channel < 140), "tension is dark: {found:?}");
    assert!(found[1][0] > 140 && found[1][1] < 120 && found[1][2] > 120, "shear is magenta: {found:?}");
    let svg = cracks.svg(&frames[1]).unwrap();
    assert!(svg.contains(">tension<") && svg.contains(">shear<") && !svg.contains(">mixed<"));
    assert!(!svg.contains("principal stress"));
}

#[test]
fn texts_legends_and_scales_are_around_the_image() {
    let frames = [frame(0.0, false), frame(0.5, true)];
    let pictures = SpacePictures { title: "A <bar>", ..pictures(&frames) };
    let svg = pictures.svg(&frames[0]).unwrap();
    for text in [
        "A &lt;bar&gt;",
        "t = 1.000 ms, step 1,200, 24 elements",
        "largest principal stress (MPa)",
        ">x<",
        ">z<",
        ">500 mm<",
        "<image ",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    assert!(!svg.contains(">y<"), "y points away from the eye");
    assert!(pictures.svg(&frames[1]).unwrap().contains("t = 1.500 ms"));
    let above = SpacePictures { view: pictures.view.seen_from(30.0, 25.0), ..pictures };
    assert!(above.svg(&frames[0]).unwrap().contains(">y<"));
}

#[test]
fn pictures_are_as_wide_as_asked_and_the_same_again() {
    let frames = [frame(0.2, true)];
    for show in [Show::Solid, Show::Cracks] {
        let view = SpaceView::of(&frames);
        let pictures = SpacePictures { show, view, cut: Some(Cut::across(2, 0.6)), ..pictures(&frames) };
        let png = pictures.png(&frames[0], Some(1234)).unwrap();
        assert_eq!(pixels(&png).0, 1234);
        assert_eq!(png, pictures.png(&frames[0], Some(1234)).unwrap());
    }
}

#[test]
fn an_animation_has_all_frames_and_the_last_is_that_of_the_picture() {
    let frames = [0.0, 0.2, 0.4].map(|gap| frame(gap, gap > 0.05));
    for (show, field) in [
        (Show::Solid, Field::MAX_PRINCIPAL),
        (Show::Solid, Field::BODY),
        (Show::Solid, Field::VON_MISES),
        (Show::Cracks, Field::BODY),
    ] {
        let view = SpaceView::of(&frames);
        let pictures = SpacePictures { show, field, view, ..pictures(&frames) };
        let made = || {
            let mut animation = SpaceAnimation::new(pictures, Some(400), 8);
            for frame in &frames {
                animation.push(frame).unwrap();
            }
            animation.finish().unwrap()
        };
        let file = made();
        if field == Field::VON_MISES {
            assert_eq!(file, made(), "the same bytes again");
        }
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
        assert_eq!(delays, [8, 8, 150]);
        let (wide, high, expected) = pixels(&pictures.png(&frames[2], Some(400)).unwrap());
        assert_eq!((wide, high), (width, height));
        let (mut off, mut far) = (0_u64, 0);
        for (found, expected) in screen.chunks_exact(4).zip(expected.chunks_exact(3)) {
            let most = (0..3).map(|k| found[k].abs_diff(expected[k])).max().unwrap();
            off += u64::from(most);
            far += u32::from(most > 48);
        }
        let count = (width * height) as f64;
        assert!(off as f64 / count < 4.0, "{show:?} {field:?}, 256 colours: {}", off as f64 / count);
        assert!(f64::from(far) / count < 0.005, "{show:?} {field:?} {far}");
        assert_eq!(SpaceAnimation::new(pictures, None, 8).finish().unwrap_err(), AnimationError::Empty);
    }
}
