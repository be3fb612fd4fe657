// Frames of tetrahedra.

// Corners of the facets, counter-clockwise seen from outside; the facet without each corner; ends of the edges.
const FACETS = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], WITHOUT = [2, 3, 1, 0], EDGES = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

// The first `about.surface` elements have facets that are seen. The others are inside, and only in frames that are solid.
function openedFrame(about, parts) {
  const { surface, elements: n } = about, counts = [surface, n - surface];
  const corners = new Float32Array(12 * n), scales = about.scales.map(() => new Uint16Array(n));
  const numbers = new Uint32Array(n), body = new Uint32Array(n), fragment = new Uint32Array(n), material = new Uint16Array(n), marks = new Uint16Array(n);
  let first = 0;
  parts.forEach((arrays, part) => {
    const count = counts[part];
    corners.set(arrays.points(count, 4, about.bounds), 12 * first);
    for (const scale of scales) scale.set(arrays.numbers(count), first);
    let number = 0;
    arrays.halves(count).forEach((difference, i) => { numbers[first + i] = number += difference; });
    body.set(arrays.halves(count), first);
    fragment.set(arrays.halves(count), first);
    material.set(arrays.numbers(count), first);
    marks.set(arrays.numbers(count), first);
    first += count;
  });
  const m = about.cracks, sides = [parts[0].halves(m), parts[0].halves(m)], codes = parts[0].numbers(m), openings = parts[0].numbers(m);
  // Mode of the crack on each facet, from 1; 0 where there is none.
  const modes = new Uint8Array(4 * surface);
  for (const side of sides) for (let c = 0; c < m; c++) modes[side[c]] = (codes[c] & 3) + 1;
  const w = about.holding[0] + about.holding[1], intact = { count: w, corners: parts[0].points(w, 3, about.bounds), body: parts[0].halves(w), fragment: parts[0].halves(w) };
  const number = (i) => (i >= 0 ? numbers[i] : -1);
  const place = (element) => {
    const found = placeOf(element, numbers, 0, surface);
    return found >= 0 ? found : placeOf(element, numbers, surface, n);
  };
  // What is told of element i beside its values: its broken joints.
  const more = (i) => {
    const facts = [];
    for (let c = 0; c < m; c++) {
      if (sides[0][c] >> 2 !== i && sides[1][c] >> 2 !== i) continue;
      facts.push([facts.length ? `crack ${facts.length + 1}` : "crack", `${meta.cracks[codes[c] & 3].name}, opening ${quantity(valueOf(openings[c], about.openings), "m", 3)}`]);
    }
    return facts;
  };
  return { n, surface, solid: about.solid, corners, scales, numbers, body, fragment, material, marks, modes, cracks: { count: m, sides, codes }, intact, number, place, more };
}
