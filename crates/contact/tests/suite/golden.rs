//! The numbers printed in the book: the ten-body example in 2D and the nine bodies of Fig. 3.58 in 3D.

#[path = "../../examples/ten_bodies.rs"]
mod ten_bodies;

use fdem_contact::{Elements, Lists, Nbs, Observer, Search, Set};
use fdem_scenes::book;

use ten_bodies::{Figures, in_the_books_numbers};

fn figures() -> Figures {
    Figures::draw(&book::ten_bodies().centres).unwrap()
}

/// Figs 3.41 and 3.42, pp. 105-106.
#[test]
fn y_lists() {
    let figures = figures();
    let expected: [&[i64]; 10] = [&[], &[], &[], &[], &[5], &[9, 8, 6, 3], &[10, 7, 4, 1], &[2], &[], &[]];
    assert_eq!(figures.y_lists, expected);
    assert_eq!(figures.b, [-1, -1, -1, -1, 5, 9, 10, 2, -1, -1]);
    assert_eq!(figures.y, [-1, -1, -1, 1, -1, 3, 4, 6, 8, 7]);
}

/// Figs 3.43 and 3.44, p. 108. The figure prints X\[1\] = 2, the text X\[1\] = 10; the text is right.
#[test]
fn x_lists_of_row_7() {
    let figures = figures();
    let row = &figures.rows[0];
    assert_eq!(row.i_y, 7, "body 1 is the first to be visited, and is in row 7");
    assert_eq!(row.a[0], [-1, -1, 7, 1, 4, -1, -1, -1, -1, -1]);
    let x = |body: usize| row.x[body - 1];
    assert_eq!((x(1), x(4), x(7), x(10)), (10, -1, -1, -1));
    // The row below, step 4: bodies 9, 3, 6 and 8 in columns 3 to 6.
    assert_eq!(row.a[1], [-1, -1, 9, 3, 6, 8, -1, -1, -1, -1]);
    assert_eq!(row.x, [10, -1, -1, -1, -1, -1, -1, -1, -1, -1]);
}

/// The following rows, in the order in which the bodies lead to them: 2 is in row 8, 3 in row 6, 5 in row 5.
#[test]
fn x_lists_of_the_other_rows() {
    let figures = figures();
    assert_eq!(figures.rows.iter().map(|row| row.i_y).collect::<Vec<_>>(), [7, 8, 6, 5]);
    let empty = [-1; 10];
    assert_eq!(
        figures.rows[1].a,
        [[-1, -1, -1, -1, 2, -1, -1, -1, -1, -1], [-1, -1, 7, 1, 4, -1, -1, -1, -1, -1]]
    );
    assert_eq!(
        figures.rows[2].a,
        [[-1, -1, 9, 3, 6, 8, -1, -1, -1, -1], [-1, -1, -1, 5, -1, -1, -1, -1, -1, -1]]
    );
    assert_eq!(figures.rows[3].a, [[-1, -1, -1, 5, -1, -1, -1, -1, -1, -1], empty]);
}

/// p. 110 names (3, 7), (4, 7) and (5, 7) as the new x-lists of row 7; body 10, the first on the list, is in
/// (4, 7).
#[test]
fn central_cells_in_the_order_of_the_visit() {
    assert_eq!(
        figures().central_cells,
        [(4, 7), (3, 7), (5, 7), (5, 8), (3, 6), (6, 6), (5, 6), (4, 6), (4, 5)]
    );
}

const CANDIDATES: &str = "1-2 1-3 1-4 1-6 1-7 1-9 1-10 2-4 2-10 3-4 3-5 3-6 3-7 3-9 3-10 4-6 4-8 4-10 5-6 5-9 6-8 6-10 \
                          7-9 7-10 9-10";

fn couples(text: &str) -> Vec<(u32, u32)> {
    let number = |text: &str| text.parse::<u32>().unwrap();
    text.split_whitespace()
        .map(|couple| couple.split_once('-').unwrap())
        .map(|(i, j)| (number(i), number(j)))
        .collect()
}

/// The printed data do not determine whether body 9 is in column 3 or 4. The fixture has it in column 3.
#[test]
fn candidate_couples() {
    let expected = couples(CANDIDATES);
    assert_eq!(expected.len(), 25);
    assert_eq!(figures().candidates, expected);

    let mut centres = book::ten_bodies().centres;
    centres[8][0] += 1.0;
    let mut with_9_in_column_4 = expected;
    with_9_in_column_4.extend([(4, 9), (6, 9)]);
    with_9_in_column_4.sort_unstable();
    assert_eq!(Figures::draw(&centres).unwrap().candidates, with_9_in_column_4);
}

/// The output of the example contains the arrays of the figures.
#[test]
fn the_example_prints_the_figures() {
    let text = figures().to_string();
    for line in [
        "  y7  10  7  4  1",
        "  y6   9  8  6  3",
        "B = -1 -1 -1 -1  5  9 10  2 -1 -1",
        "Y = -1 -1 -1  1 -1  3  4  6  8  7",
        "  A = -1 -1  7  1  4 -1 -1 -1 -1 -1",
        "  X = 10 -1 -1 -1 -1 -1 -1 -1 -1 -1",
        "  central cells (i_x, i_y): (4, 7) (3, 7) (5, 7)",
        "25 candidate couples",
        CANDIDATES,
    ] {
        assert!(text.contains(line), "{line:?} is not in:\n{text}");
    }
}

/// After the detection every head is empty again: p. 109, and the last step of the procedure.
#[test]
fn all_heads_are_empty_afterwards() {
    struct Heads(Vec<Vec<i64>>);
    impl Observer<2> for Heads {
        fn lists(&mut self, axis: usize, _: &[u32; 2], lists: &Lists) {
            if axis == 1 {
                self.0.push(in_the_books_numbers(lists.heads(Set::Central)));
            }
        }
    }
    // The same search again, on other bodies: anything left in the heads would show.
    let mut nbs = Nbs::new().with_domain([[0.0, 10.0]; 2]);
    nbs.count(&Elements::points(&book::ten_bodies().centres, 1.0).unwrap()).unwrap();
    let mut heads = Heads(Vec::new());
    nbs.observe(&Elements::points(&[[0.5, 0.5]; 10], 1.0).unwrap(), &mut heads, |_| {}).unwrap();
    assert_eq!(heads.0, [[10, -1, -1, -1, -1, -1, -1, -1, -1, -1]]);
}

/// Fig. 3.58, p. 122: nine bodies on layers in 3D.
#[test]
fn z_lists_in_3d() {
    #[derive(Default)]
    struct Layers {
        c: Vec<i64>,
        z: Vec<i64>,
        lists: Vec<Vec<u32>>,
    }
    impl Observer<3> for Layers {
        fn lists(&mut self, axis: usize, _: &[u32; 3], lists: &Lists) {
            if axis == 2 {
                self.c = in_the_books_numbers(lists.heads(Set::Central));
                self.z = in_the_books_numbers(lists.next());
                self.lists = (0..10)
                    .map(|layer| lists.iter(Set::Central, layer).map(|body| body + 1).collect())
                    .collect();
            }
        }
    }
    let layers = book::nine_body_layers();
    let centres: Vec<[f64; 3]> = layers.iter().map(|&layer| [0.5, 0.5, f64::from(layer) - 0.5]).collect();
    let mut figure = Layers::default();
    let elements = Elements::points(&centres, 1.0).unwrap();
    Nbs::new().with_domain([[0.0, 10.0]; 3]).observe(&elements, &mut figure, |_| {}).unwrap();
    assert_eq!(figure.c, [-1, -1, -1, -1, 5, 9, 7, 2, -1, -1]);
    assert_eq!(figure.z, [-1, -1, -1, 1, -1, 3, 4, 6, 8]);
    let expected: [&[u32]; 10] = [&[], &[], &[], &[], &[5], &[9, 8, 6, 3], &[7, 4, 1], &[2], &[], &[]];
    assert_eq!(figure.lists, expected);
}
