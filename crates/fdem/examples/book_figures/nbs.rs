//! Munjiza-NBS on the ten bodies of Figs 3.40 to 3.44: the view of an observer of the search, step by step.

use fdem_contact::{Couple, Elements, Error, Lists, NONE, Nbs, Observer, Set};
use fdem_scenes::book::ten_bodies;

use super::cells::Frame;
use super::paper::{BODY, CENTRAL, COUPLE, FAINT, INK, NEIGHBOUR, Paper};

/// Cells along an axis.
const CELLS: usize = 10;
/// Pixels per cell.
const SCALE: f64 = 34.0;
/// Room left of the cells for the heads of the y-lists, and below for those of the x-lists.
const LEFT: f64 = 74.0;
const TOP: f64 = 44.0;
const BELOW: f64 = 82.0;
const WIDTH: f64 = LEFT + SCALE * CELLS as f64 + 16.0;
const HEIGHT: f64 = TOP + SCALE * CELLS as f64 + BELOW;
/// Seconds that a step of the animation stays.
const SECONDS: usize = 2;

/// The state that a figure shows after a step; rows, columns and bodies are counted from 0, as the library
/// counts them.
#[derive(Clone, Debug, Default)]
struct Step {
    caption: String,
    /// Heads of the y-lists, and the next body on each; empty when the lists are.
    y_lists: Option<[Vec<u32>; 2]>,
    /// Heads of the x-lists of the central row and of the row below, and the next body on each.
    x_lists: Option<[Vec<u32>; 3]>,
    central_row: Option<u32>,
    central_cell: Option<[u32; 2]>,
    /// Compared so far, and in this step.
    candidates: [Vec<Couple>; 2],
}

/// All steps of a search.
#[derive(Debug)]
pub(crate) struct Steps {
    centres: Vec<[f64; 2]>,
    steps: Vec<Step>,
}

impl Steps {
    pub(crate) fn of_ten_bodies() -> Result<Self, Error> {
        let first =
            Step { caption: "Ten bodies, each in the cell of its centre".to_owned(), ..Step::default() };
        let mut watched = Self { centres: ten_bodies().centres, steps: vec![first] };
        let centres = watched.centres.clone();
        let elements = Elements::points(&centres, 1.0)?;
        Nbs::new().with_domain([[0.0, CELLS as f64]; 2]).observe(&elements, &mut watched, |_| {})?;
        let [found, _] = watched.next().candidates;
        let caption = "All lists are empty again".to_owned();
        watched.steps.push(Step { caption, candidates: [found, Vec::new()], ..Step::default() });
        Ok(watched)
    }

    /// Six of the steps, side by side: those of the row that the book draws, Figs 3.41 to 3.45.
    pub(crate) fn sequence(&self) -> String {
        let row =
            self.steps.iter().position(|step| step.central_row == Some(6) && step.central_cell.is_none());
        let row = row.expect("the seventh row has bodies");
        let last = self.steps.len() - 1;
        let mut paper = Paper::new();
        for (k, step) in [0, 1, row, row + 1, row + 2, last].into_iter().enumerate() {
            let at = [(k % 2) as f64 * WIDTH, (k / 2) as f64 * HEIGHT];
            paper.place(&self.draw(step, &format!("{}. ", k + 1)), at);
        }
        let title = "Munjiza-NBS on ten bodies: bodies in cells, y-lists, x-lists of two rows, two central cells with their contact masks, and empty lists again";
        paper.svg([2.0 * WIDTH, 3.0 * HEIGHT], title, "")
    }

    /// All steps, one after the other.
    pub(crate) fn animation(&self) -> String {
        let (count, mut paper) = (self.steps.len(), Paper::new());
        for step in 0..count {
            let begin = step * SECONDS;
            paper.raw(format_args!("<g class=\"step\" style=\"animation-delay:{begin}s\">"));
            paper.place(&self.draw(step, ""), [0.0, 0.0]);
            paper.raw("</g>");
        }
        let share = 100.0 / count as f64;
        // The last step is shown to readers who prefer reduced motion, and by viewers without animation.
        let style = format!(
            "<style>\n@media (prefers-reduced-motion: no-preference) {{\n.step {{ opacity: 0; animation: show {}s step-end infinite; }}\n\
             @keyframes show {{ 0% {{ opacity: 1; }} {share:.4}% {{ opacity: 0; }} }}\n}}\n\
             @media (prefers-reduced-motion: reduce) {{ .step:not(:last-of-type) {{ display: none; }} }}\n</style>\n",
            count * SECONDS
        );
        paper.svg([WIDTH, HEIGHT], "Munjiza-NBS on ten bodies, step by step", &style)
    }

    /// The latest step, before anything more is compared.
    fn next(&self) -> Step {
        let mut step = self.steps.last().cloned().unwrap_or_default();
        let [past, now] = &mut step.candidates;
        past.append(now);
        step.central_cell = None;
        step
    }

    fn draw(&self, step: usize, number: &str) -> Paper {
        let Step { caption, y_lists, x_lists, central_row, central_cell, candidates } = &self.steps[step];
        let cells = CELLS as f64;
        let frame = Frame { origin: [0.0; 2], size: [cells; 2], scale: SCALE, at: [LEFT, TOP] };
        let places = self.places();
        let mut paper = Paper::new();
        paper.rect([1.0, 1.0], [WIDTH - 2.0, HEIGHT - 2.0], "fill=\"white\" rx=\"8\"");
        paper.text([LEFT, TOP / 2.0], 14.0, "start", format_args!("{number}{caption}"));
        if let Some(row) = central_row {
            let y = f64::from(*row);
            frame.rect(
                &mut paper,
                [0.0, y],
                [cells, 1.0],
                &format!("fill=\"{CENTRAL}\" fill-opacity=\"0.18\""),
            );
            if *row > 0 {
                let style = format!("fill=\"{NEIGHBOUR}\" fill-opacity=\"0.18\"");
                frame.rect(&mut paper, [0.0, y - 1.0], [cells, 1.0], &style);
            }
        }
        if let Some(cell) = central_cell {
            let [x, y] = cell.map(f64::from);
            for (column, row) in [(x - 1.0, y), (x - 1.0, y - 1.0), (x, y - 1.0), (x + 1.0, y - 1.0)] {
                if (0.0..cells).contains(&column) && row >= 0.0 {
                    let style = format!("fill=\"{NEIGHBOUR}\" fill-opacity=\"0.6\"");
                    frame.rect(&mut paper, [column, row], [1.0, 1.0], &style);
                }
            }
            frame.rect(&mut paper, [x, y], [1.0, 1.0], &format!("fill=\"{CENTRAL}\" fill-opacity=\"0.75\""));
        }
        frame.grid(&mut paper, 1.0, [true, true]);
        for centre in &places {
            let style = format!("fill=\"{BODY}\" fill-opacity=\"0.8\" stroke=\"{INK}\" stroke-width=\"1\"");
            frame.circle(&mut paper, *centre, 0.5, &style);
        }
        for (couples, style) in candidates.iter().zip([
            format!("stroke=\"{COUPLE}\" stroke-width=\"1.2\" stroke-opacity=\"0.35\""),
            format!("stroke=\"{COUPLE}\" stroke-width=\"2.6\""),
        ]) {
            for couple in couples {
                let [a, b] = [couple.i, couple.j].map(|k| places[k as usize]);
                frame.line(&mut paper, a, b, &style);
            }
        }
        // Links between the bodies of a list, under their numbers.
        match (x_lists, y_lists) {
            (Some([_, _, next]), _) if candidates[1].is_empty() => links(&mut paper, &frame, &places, next),
            (None, Some([_, next])) => links(&mut paper, &frame, &places, next),
            _ => {}
        }
        for (body, centre) in places.iter().enumerate() {
            paper.circle(frame.point(*centre), 7.5, "fill=\"white\" fill-opacity=\"0.85\"");
            paper.text(frame.point(*centre), 11.0, "middle", body + 1);
        }
        heads_of_y_lists(
            &mut paper,
            &frame,
            y_lists.as_ref().map(|[heads, _]| heads.as_slice()),
            *central_row,
        );
        heads_of_x_lists(&mut paper, &frame, x_lists.as_ref());
        paper
    }

    /// Where bodies are drawn: those in the same place a little apart.
    fn places(&self) -> Vec<[f64; 2]> {
        let twins = |body: usize| {
            let same = |other: &usize| self.centres[*other] == self.centres[body];
            let all = (0..self.centres.len()).filter(same).collect::<Vec<_>>();
            (all.iter().position(|&other| other == body).unwrap_or(0), all.len())
        };
        let place = |(body, &[x, y]): (usize, &[f64; 2])| {
            let (k, of) = twins(body);
            let shift = 0.46 * (k as f64 - (of as f64 - 1.0) / 2.0);
            [x + shift, y - shift]
        };
        self.centres.iter().enumerate().map(place).collect()
    }
}

/// From each body to the next on its list.
fn links(paper: &mut Paper, frame: &Frame, places: &[[f64; 2]], next: &[u32]) {
    for (body, &next) in next.iter().enumerate().filter(|(_, next)| **next != NONE) {
        let [[x1, y1], [x2, y2]] = [body, next as usize].map(|k| frame.point(places[k]));
        let bend = 0.25 * (x2 - x1).abs() + 4.0;
        let (x, y) = (f64::midpoint(x1, x2), f64::midpoint(y1, y2) - bend);
        paper.raw(format_args!(
            "<path d=\"M{x1:.1} {y1:.1}Q{x:.1} {y:.1} {x2:.1} {y2:.1}\" fill=\"none\" stroke=\"{INK}\" stroke-width=\"1.4\" stroke-dasharray=\"4 2\"/>"
        ));
    }
}

/// One box per row: the first body on its y-list.
fn heads_of_y_lists(paper: &mut Paper, frame: &Frame, heads: Option<&[u32]>, central: Option<u32>) {
    let x = LEFT - 34.0;
    paper.text([x + 13.0, TOP - 8.0], 12.0, "middle", "B");
    for row in 0..CELLS {
        let [_, y] = frame.point([0.0, row as f64 + 1.0]);
        let fill = match central {
            Some(central) if central as usize == row => CENTRAL,
            Some(central) if central as usize == row + 1 => NEIGHBOUR,
            _ => "none",
        };
        head(paper, [x, y + 4.0], heads.map_or(NONE, |heads| heads[row]), fill);
        paper.text([LEFT - 44.0, y + SCALE / 2.0], 11.0, "end", format_args!("y{}", row + 1));
    }
}

/// One box per column and set: the first body on its x-list.
fn heads_of_x_lists(paper: &mut Paper, frame: &Frame, lists: Option<&[Vec<u32>; 3]>) {
    for (set, (name, fill)) in [("A, row", CENTRAL), ("A, below", NEIGHBOUR)].into_iter().enumerate() {
        let [_, bottom] = frame.point([0.0, 0.0]);
        let y = bottom + 10.0 + 33.0 * set as f64;
        paper.text([LEFT - 8.0, y + 13.0], 11.0, "end", name);
        for column in 0..CELLS {
            let [x, _] = frame.point([column as f64, 0.0]);
            let body = lists.map_or(NONE, |lists| lists[set].get(column).copied().unwrap_or(NONE));
            head(paper, [x + 4.0, y], body, if lists.is_some() { fill } else { "none" });
        }
    }
}

fn head(paper: &mut Paper, [x, y]: [f64; 2], body: u32, fill: &str) {
    let style = format!("fill=\"{fill}\" fill-opacity=\"0.25\" stroke=\"{FAINT}\" rx=\"3\"");
    paper.rect([x, y], [26.0, 26.0], &style);
    let text = if body == NONE { "−1".to_owned() } else { (body + 1).to_string() };
    let size = if body == NONE { 9.0 } else { 13.0 };
    paper.text([x + 13.0, y + 13.0], size, "middle", text);
}

impl Observer<2> for Steps {
    fn lists(&mut self, axis: usize, cell: &[u32; 2], lists: &Lists) {
        let mut step = self.next();
        if axis == 1 {
            "Y-lists of the rows: heads B, linked by Y".clone_into(&mut step.caption);
            step.y_lists = Some([lists.heads(Set::Central).to_vec(), lists.next().to_vec()]);
        } else {
            step.caption = format!("X-lists of row {} and of the row below", cell[1] + 1);
            let [central, below] = [Set::Central, Set::Neighbours].map(|set| lists.heads(set).to_vec());
            step.x_lists = Some([central, below, lists.next().to_vec()]);
            step.central_row = Some(cell[1]);
            // Numbers of bodies on other rows are left over from before.
            let row_of = |body: usize| self.centres[body][1] as u32;
            if let Some([.., next]) = &mut step.x_lists {
                for (body, next) in next.iter_mut().enumerate() {
                    if row_of(body) != cell[1] && row_of(body) + 1 != cell[1] {
                        *next = NONE;
                    }
                }
            }
        }
        self.steps.push(step);
    }

    fn central_cell(&mut self, cell: &[u32; 2]) {
        let mut step = self.next();
        step.caption = format!("Cell ({}, {}) and the half mask around it", cell[0] + 1, cell[1] + 1);
        step.central_cell = Some(*cell);
        self.steps.push(step);
    }

    fn candidate(&mut self, couple: Couple) {
        if let Some(step) = self.steps.last_mut() {
            step.candidates[1].push(couple);
        }
    }
}
