// The frames in this page. Each is decompressed when it is needed for the first time.

// Numbers are 16-bit positions between two limits. The last code means no value.
const STEPS = 65534, NOWHERE = 65535;

class Frames {
  constructor() {
    this.texts = document.querySelectorAll("script.frame");
    this.opened = new Map();
  }

  get count() {
    return meta.frames.length;
  }

  // Returns a promise of frame k.
  get(k) {
    let frame = this.opened.get(k);
    if (!frame) {
      frame = this.open(k);
      this.opened.set(k, frame);
    }
    return frame;
  }

  async open(k) {
    const about = meta.frames[k], n = about.elements;
    const bytes = await inflated(bytesOfBase64(this.texts[k].textContent), about.size);
    this.texts[k].textContent = "";
    if (bytes.length !== about.size) throw new Error("the data is damaged");
    let at = 0;
    // Each array has all upper bytes first, then all lower bytes.
    const numbers = (count) => {
      const array = new Uint16Array(count);
      for (let i = 0; i < count; i++) array[i] = (bytes[at + i] << 8) | bytes[at + count + i];
      at += 2 * count;
      return array;
    };
    const value = (place, [low, high]) => (place === NOWHERE ? NaN : low + (place / STEPS) * (high - low));
    // Coordinates are relative to the centre of the view, in units of half its longer side, so that 32 bits suffice.
    const corners = new Float32Array(6 * n);
    for (let corner = 0; corner < 3; corner++) {
      for (let axis = 0; axis < 2; axis++) {
        const places = numbers(n);
        for (let i = 0; i < n; i++) corners[6 * i + 2 * corner + axis] = (value(places[i], about.bounds[axis]) - meta.view.middle[axis]) / meta.view.unit;
      }
    }
    // A triangle that lacks a coordinate becomes a point, which is not drawn.
    for (let i = 0; i < n; i++) {
      const mine = corners.subarray(6 * i, 6 * i + 6);
      if (mine.some(Number.isNaN)) mine.fill(0);
    }
    const scales = about.scales.map(() => numbers(n));
    const upper = numbers(n), lower = numbers(n), material = numbers(n);
    const body = (i) => upper[i] * 65536 + lower[i];
    const outlines = outlinesOf(corners, numbers(n));
    // A sample has the numbers of its elements, in ascending order.
    const sample = about.sample ? [numbers(n), numbers(n)] : null;
    const number = (i) => (sample && i >= 0 ? sample[0][i] * 65536 + sample[1][i] : i);
    const place = (element) => {
      let low = 0, high = n;
      while (low < high) {
        const middle = (low + high) >> 1;
        if (number(middle) < element) low = middle + 1;
        else high = middle;
      }
      return low < n && number(low) === element ? low : -1;
    };
    const cracks = new Float32Array(4 * about.cracks);
    for (let end = 0; end < 2; end++) {
      for (let axis = 0; axis < 2; axis++) {
        const places = numbers(about.cracks);
        for (let i = 0; i < about.cracks; i++) cracks[4 * i + 2 * end + axis] = (value(places[i], about.bounds[axis]) - meta.view.middle[axis]) / meta.view.unit;
      }
    }
    return { k, about, corners, scales, number, place, body, material, outlines, cracks, modes: numbers(about.cracks), value: (scale, i) => value(scales[scale][i], about.scales[scale]) };
  }
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

// Returns the factor and the prefixed unit with which numbers are short.
function prefixed(unit, largest) {
  if (!["Pa", "m", "m/s", "s", "J", "N"].includes(unit) || !(largest >= 1e-9 && largest < 1e15)) return [1, unit];
  const most = unit.startsWith("m") || unit === "s" ? 1 : Infinity;
  for (const [size, prefix] of [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"]]) {
    if (size <= most && largest * 1.000001 >= size) return [1 / size, prefix + unit];
  }
  return [1, unit];
}

function quantity(x, unit, digits = 5) {
  if (Number.isNaN(x)) return "not finite";
  const [factor, name] = prefixed(unit, Math.abs(x));
  return `${brief(Number((x * factor).toPrecision(digits)))}${name ? ` ${name}` : ""}`;
}
