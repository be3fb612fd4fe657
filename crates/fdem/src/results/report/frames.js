// Frames from the texts in this page, each opened when it is first looked at.

// Places between two numbers, of 16 bits; the last is nowhere.
const STEPS = 65534, NOWHERE = 65535;

class Frames {
  constructor() {
    this.texts = document.querySelectorAll("script.frame");
    this.opened = new Map();
  }

  get count() {
    return meta.frames.length;
  }

  // A promise of frame k.
  get(k) {
    let frame = this.opened.get(k);
    if (!frame) {
      frame = this.open(k);
      this.opened.set(k, frame);
    }
    return frame;
  }

  async open(k) {
    const about = meta.frames[k], n = meta.elements;
    const bytes = await inflated(bytesOfBase64(this.texts[k].textContent), about.size);
    this.texts[k].textContent = "";
    if (bytes.length !== about.size) throw new Error("the data is damaged");
    let at = 0;
    // Of each array first all upper bytes, then all lower ones.
    const numbers = (count) => {
      const array = new Uint16Array(count);
      for (let i = 0; i < count; i++) array[i] = (bytes[at + i] << 8) | bytes[at + count + i];
      at += 2 * count;
      return array;
    };
    const value = (place, [low, high]) => (place === NOWHERE ? NaN : low + (place / STEPS) * (high - low));
    // In units of half the view, from its middle: 32 bits are enough then.
    const corners = new Float32Array(6 * n);
    for (let corner = 0; corner < 3; corner++) {
      for (let axis = 0; axis < 2; axis++) {
        const places = numbers(n);
        for (let i = 0; i < n; i++) corners[6 * i + 2 * corner + axis] = (value(places[i], about.bounds[axis]) - meta.view.middle[axis]) / meta.view.unit;
      }
    }
    // Triangles that are nowhere become points.
    for (let i = 0; i < n; i++) {
      const mine = corners.subarray(6 * i, 6 * i + 6);
      if (mine.some(Number.isNaN)) mine.fill(0);
    }
    const scales = about.scales.map(() => numbers(n));
    const upper = numbers(n), lower = numbers(n), material = numbers(n);
    const body = (i) => upper[i] * 65536 + lower[i];
    const cracks = new Float32Array(4 * about.cracks);
    for (let end = 0; end < 2; end++) {
      for (let axis = 0; axis < 2; axis++) {
        const places = numbers(about.cracks);
        for (let i = 0; i < about.cracks; i++) cracks[4 * i + 2 * end + axis] = (value(places[i], about.bounds[axis]) - meta.view.middle[axis]) / meta.view.unit;
      }
    }
    return { k, about, corners, scales, body, material, cracks, modes: numbers(about.cracks), value: (scale, i) => value(scales[scale][i], about.scales[scale]) };
  }
}

// A factor and a unit with a prefix, so that numbers are short.
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
