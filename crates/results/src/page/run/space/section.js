// The section of elements by a plane.

// An array that grows.
class Growing {
  constructor(Kind, size = 1024) {
    this.Kind = Kind;
    this.array = new Kind(size);
    this.length = 0;
  }

  push(...numbers) {
    if (this.length + numbers.length > this.array.length) {
      const larger = new this.Kind(2 * this.array.length + numbers.length);
      larger.set(this.array);
      this.array = larger;
    }
    for (let k = 0; k < numbers.length; k++) this.array[this.length++] = numbers[k];
  }

  get all() {
    return this.array.subarray(0, this.length);
  }
}

// Returns the polygons in which the plane `[a, b, c, d]`, where a x + b y + c z = d, crosses the elements for which `shown` is true, as triangles: their corners, their elements, and which of their
// edges are edges of the polygon (bit k for the edge opposite to corner k). `lines` are the sides of the polygons that are on facets that are seen, with the mode of the crack there, or 0.
// `place` writes the corners of an element to an array; `still`: these are the corners that it has in the frame.
function section(frame, [a, b, c, d], shown, place, still) {
  const corners = new Growing(Float32Array), owners = new Growing(Uint32Array), edges = new Growing(Uint8Array), lines = new Growing(Float32Array), modes = new Growing(Uint8Array);
  const at = new Float32Array(12), far = new Float64Array(4), points = new Float32Array(12);
  const sides = [0, 0, 0, 0], inner = [], outer = [];
  const triangle = (element, i, j, k, real) => {
    for (const p of [3 * i, 3 * j, 3 * k]) corners.push(points[p], points[p + 1], points[p + 2]);
    owners.push(element);
    edges.push(real);
  };
  const cross = (k, p, q) => {
    const share = far[p] / (far[p] - far[q]);
    for (let axis = 0; axis < 3; axis++) points[3 * k + axis] = at[3 * p + axis] + share * (at[3 * q + axis] - at[3 * p + axis]);
  };
  // Whether all corners of an element are on one side. Most are, and nothing else is done for them.
  const all = frame.corners, within = (k) => a * all[k] + b * all[k + 1] + c * all[k + 2] - d <= 0;
  const aside = (k) => {
    const first = within(k);
    return within(k + 3) === first && within(k + 6) === first && within(k + 9) === first;
  };
  for (let element = 0; element < frame.n; element++) {
    if ((still && aside(12 * element)) || !shown(element)) continue;
    place(element, at);
    inner.length = outer.length = 0;
    for (let corner = 0; corner < 4; corner++) {
      far[corner] = a * at[3 * corner] + b * at[3 * corner + 1] + c * at[3 * corner + 2] - d;
      (far[corner] <= 0 ? inner : outer).push(corner);
    }
    if (!inner.length || !outer.length) continue;
    let count = 3;
    if (inner.length === 2) {
      // A quadrilateral. Each side is on the facet without one corner.
      const [p, q] = inner, [r, s] = outer;
      cross(0, p, r);
      cross(1, p, s);
      cross(2, q, s);
      cross(3, q, r);
      [sides[0], sides[1], sides[2], sides[3]] = [q, r, p, s];
      triangle(element, 0, 1, 2, 0b101);
      triangle(element, 0, 2, 3, 0b011);
      count = 4;
    } else {
      const [alone, others] = inner.length === 1 ? [inner[0], outer] : [outer[0], inner];
      for (let k = 0; k < 3; k++) {
        cross(k, alone, others[k]);
        sides[k] = others[(k + 2) % 3];
      }
      triangle(element, 0, 1, 2, 0b111);
    }
    const marks = frame.marks[element];
    if (!(marks & 15)) continue;
    for (let k = 0; k < count; k++) {
      const facet = WITHOUT[sides[k]];
      if (!((marks >> facet) & 1)) continue;
      const from = 3 * k, to = 3 * ((k + 1) % count);
      lines.push(points[from], points[from + 1], points[from + 2], points[to], points[to + 1], points[to + 2]);
      modes.push(frame.modes[4 * element + facet]);
    }
  }
  return { corners: corners.all, owners: owners.all, edges: edges.all, lines: lines.all, modes: modes.all };
}
