//! Bodies of one kind that do not overlap: circles at random places or from a file, and polygons in them.

use std::f64::consts::{PI, TAU};
use std::sync::atomic::AtomicU64;

use fdem_io::numbers::brief;
use fdem_io::{Centres, ReadOptions};
use fdem_mesh::Grading;
use fdem_scenes::random::Random;

use crate::model::file::{Packing, Piece};
use crate::model::outline::{Point, circle};

/// A centre and a radius, m.
pub(crate) type Circle = (Point, f64);

/// Places that are tried for each before there is no room for it.
const ATTEMPTS: u32 = 20_000;

/// Places that are tried in all before a packing is given up: about a minute.
const ALL_ATTEMPTS: u64 = 500_000_000;

/// Share of a rectangle that discs of one size can cover at most; of discs of several sizes a little more.
const DENSEST: f64 = 0.95;

/// Circles with radii between two, the largest placed first, none nearer to another or to the sides than `gap`.
///
/// # Errors
/// A message with the number of circles that found room.
pub(crate) fn scatter(
    count: usize,
    [least, most]: [f64; 2],
    [low, high]: [Point; 2],
    gap: f64,
    seed: u64,
) -> Result<Vec<Circle>, String> {
    let area = (high[0] - low[0]) * (high[1] - low[1]);
    let covered = count as f64 * PI * (least * least + least * most + most * most) / 3.0 / area;
    if covered.is_nan() || covered > DENSEST {
        return Err(format!(
            "{count} discs cover {} times the rectangle; at random places they cover little more than half",
            brief(covered)
        ));
    }
    let mut random = Random::with_stream(seed, 2);
    let mut radii: Vec<f64> = (0..count).map(|_| random.between(least, most)).collect();
    radii.sort_by(|a, b| b.total_cmp(a));
    let cell = 2.0 * most + gap;
    let [columns, rows] = [0, 1].map(|axis| ((high[axis] - low[axis]) / cell).floor().clamp(1.0, 1e6));
    // No more cells than there is use for.
    let wider = (columns * rows / (4.0 * count as f64)).sqrt().max(1.0);
    let [columns, rows] = [columns, rows].map(|cells| (cells / wider).floor().max(1.0) as usize);
    let mut left = ALL_ATTEMPTS;
    let edges = [(high[0] - low[0]) / columns as f64, (high[1] - low[1]) / rows as f64];
    let mut cells: Vec<Vec<usize>> = vec![Vec::new(); columns * rows];
    let mut placed: Vec<Circle> = Vec::with_capacity(count);
    for radius in radii {
        let wall = radius + gap;
        let room = (0..2).all(|axis| high[axis] - low[axis] >= 2.0 * wall);
        let free = (0..if room { ATTEMPTS } else { 0 }).find_map(|_| {
            left = left.checked_sub(1)?;
            let point = [0, 1].map(|axis| random.between(low[axis] + wall, high[axis] - wall));
            let [column, row] = [0, 1].map(|axis| ((point[axis] - low[axis]) / edges[axis]) as usize);
            let (column, row) = (column.min(columns - 1), row.min(rows - 1));
            let mut near = (row.saturating_sub(1)..=(row + 1).min(rows - 1)).flat_map(|row| {
                (column.saturating_sub(1)..=(column + 1).min(columns - 1))
                    .map(move |column| row * columns + column)
            });
            let clear = near.all(|cell| {
                cells[cell].iter().all(|&other| {
                    let (centre, other): Circle = placed[other];
                    (centre[0] - point[0]).hypot(centre[1] - point[1]) >= radius + other + gap
                })
            });
            clear.then_some((point, row * columns + column))
        });
        let Some((point, cell)) = free else {
            return Err(format!("only {} of {count} found room", placed.len()));
        };
        cells[cell].push(placed.len());
        placed.push((point, radius));
    }
    Ok(placed)
}

/// The circles of a file.
///
/// # Errors
/// Messages of [`fdem_io::read_packing`], and about spheres, points and radii of zero.
pub(crate) fn read(bytes: &[u8], name: &str) -> Result<Vec<Circle>, String> {
    let packing = fdem_io::read_packing(bytes, name, &ReadOptions::default(), &AtomicU64::new(0))
        .map_err(|error| format!("{name}: {error}"))?;
    let Centres::Two(centres) = packing.centres else {
        return Err(format!("{name} has z: a packing of discs has x, y and radius"));
    };
    let radii = packing.radii.ok_or_else(|| format!("{name} has no radii"))?;
    if let Some(row) = radii.iter().position(|&radius| radius <= 0.0) {
        return Err(format!("{name}: the radius of row {row} is 0"));
    }
    Ok(centres.into_iter().zip(radii).collect())
}

/// The outline of a piece.
pub(crate) fn outline(
    packing: &Packing,
    (centre, radius): Circle,
    size: &Grading<2>,
    random: &mut Random,
) -> Vec<Point> {
    match packing.shape {
        Piece::Disc => circle(centre, radius, size),
        Piece::Polygon => {
            let [least, most] = packing.corners;
            let corners = u64::from(least) + random.below(u64::from(most.saturating_sub(least)) + 1);
            let start = random.uniform();
            (0..corners)
                .map(|corner| {
                    // Never two in one place: each stays within a third of its share.
                    let turn = (corner as f64 + start + 0.6 * (random.uniform() - 0.5)) / corners as f64;
                    let (sine, cosine) = libm::sincos(TAU * turn);
                    [centre[0] + radius * cosine, centre[1] + radius * sine]
                })
                .collect()
        }
    }
}
