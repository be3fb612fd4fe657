// Frames of triangles.

function openedFrame(about, [arrays]) {
  const n = about.elements, corners = arrays.points(n, 3, about.bounds);
  // A triangle that lacks a coordinate becomes a point, which is not drawn.
  for (let i = 0; i < n; i++) {
    const mine = corners.subarray(6 * i, 6 * i + 6);
    if (mine.some(Number.isNaN)) mine.fill(0);
  }
  const scales = about.scales.map(() => arrays.numbers(n));
  const body = arrays.halves(n), material = arrays.numbers(n);
  const outlines = outlinesOf(corners, arrays.numbers(n));
  // A sample has the numbers of its elements, in ascending order.
  const sample = about.sample ? arrays.halves(n) : null;
  const number = (i) => (sample && i >= 0 ? sample[i] : i);
  const place = (element) => (sample ? placeOf(element, sample, 0, n) : element < n ? element : -1);
  const cracks = arrays.points(about.cracks, 2, about.bounds);
  const modes = arrays.numbers(about.cracks), intact = arrays.points(about.holding[0] + about.holding[1], 2, about.bounds);
  return { corners, scales, number, place, body, material, outlines, cracks, modes, intact };
}

// Returns the outlines of grains and of bodies: the ends of their lines, and the mean size of a grain or body. The bits of an element mark its edges that are outlines.
function outlinesOf(corners, bits) {
  let area = 0;
  for (let at = 0; at < corners.length; at += 6) {
    area += Math.abs((corners[at + 2] - corners[at]) * (corners[at + 5] - corners[at + 1]) - (corners[at + 3] - corners[at + 1]) * (corners[at + 4] - corners[at])) / 2;
  }
  return [3, 0].map((first) => {
    const ends = [];
    let length = 0;
    bits.forEach((of, i) => {
      for (let k = 0; k < 3; k++) {
        if (!((of >> (first + k)) & 1)) continue;
        const a = 6 * i + 2 * k, b = 6 * i + 2 * ((k + 1) % 3);
        ends.push(corners[a], corners[a + 1], corners[b], corners[b + 1]);
        length += Math.hypot(corners[b] - corners[a], corners[b + 1] - corners[a + 1]);
      }
    });
    return { ends: new Float32Array(ends), size: length > 0 ? (4 * area) / length : 0 };
  });
}
