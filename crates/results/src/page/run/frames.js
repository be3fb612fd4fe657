// The frames in this page. Each is decompressed when it is shown.

// Numbers are 16-bit positions between two limits. The last code means no value.
const STEPS = 65534, NOWHERE = 65535;

// Decompressed frames are kept while they have fewer elements than this together.
const MOST_OPEN = 4e6;

// Reads arrays of numbers in the order in which they were packed.
class Arrays {
  constructor(bytes) {
    this.bytes = bytes;
    this.at = 0;
  }

  // Each array has all upper bytes first, then all lower bytes.
  numbers(count) {
    const { bytes, at } = this, array = new Uint16Array(count);
    for (let i = 0; i < count; i++) array[i] = (bytes[at + i] << 8) | bytes[at + count + i];
    this.at += 2 * count;
    return array;
  }

  // 32-bit numbers: an array of upper halves, then one of lower halves.
  halves(count) {
    const upper = this.numbers(count), lower = this.numbers(count), array = new Uint32Array(count);
    for (let i = 0; i < count; i++) array[i] = upper[i] * 65536 + lower[i];
    return array;
  }

  // `count` points of `corners` corners each. Coordinates are relative to the centre of the view, in units of the view, so that 32 bits suffice.
  points(count, corners, bounds) {
    const axes = bounds.length, size = axes * corners, points = new Float32Array(size * count);
    for (let corner = 0; corner < corners; corner++) {
      for (let axis = 0; axis < axes; axis++) {
        const places = this.numbers(count), first = axes * corner + axis;
        for (let i = 0; i < count; i++) points[size * i + first] = (valueOf(places[i], bounds[axis]) - (meta.view.middle[axis] ?? 0)) / meta.view.unit;
      }
    }
    return points;
  }
}

const valueOf = (place, [low, high]) => (place === NOWHERE ? NaN : low + (place / STEPS) * (high - low));

// Returns the place of a number in an array whose entries from `low` to `high` ascend, or -1.
function placeOf(number, array, low, high) {
  const end = high;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (array[middle] < number) low = middle + 1;
    else high = middle;
  }
  return low < end && array[low] === number ? low : -1;
}

class Frames {
  constructor() {
    // The texts of each frame: one, or one for each of its parts.
    this.texts = meta.frames.map(() => []);
    for (const text of document.querySelectorAll("script.frame")) this.texts[text.dataset.frame].push(text);
    this.packed = new Map();
    this.opened = new Map();
  }

  get count() {
    return meta.frames.length;
  }

  // Returns a promise of frame k.
  get(k) {
    const frame = this.opened.get(k) ?? this.open(k);
    // The last is the one that was used last.
    this.opened.delete(k);
    this.opened.set(k, frame);
    let total = 0;
    for (const other of [...this.opened.keys()].reverse()) {
      total += meta.frames[other].elements + (meta.frames[other].grains?.spheres ?? 0);
      if (total > MOST_OPEN && other !== k) this.opened.delete(other);
    }
    return frame;
  }

  async open(k) {
    const about = meta.frames[k];
    if (!this.packed.has(k)) {
      this.packed.set(k, this.texts[k].map((text) => bytesOfBase64(text.textContent)));
      for (const text of this.texts[k]) text.textContent = "";
    }
    const parts = await Promise.all(this.packed.get(k).map((bytes, part) => inflated(bytes, about.sizes[part])));
    if (parts.some((bytes, part) => bytes.length !== about.sizes[part])) throw new Error("the data is damaged");
    const arrays = parts.map((bytes) => new Arrays(bytes));
    // The spheres are the last part.
    const grains = about.grains ? openedGrains(about.grains, arrays.pop()) : null;
    const frame = openedFrame(about, arrays);
    return Object.assign(frame, { k, about, grains, value: (scale, i) => valueOf(frame.scales[scale][i], about.scales[scale]) });
  }
}

// Returns the factor and the prefixed unit with which numbers are short.
function prefixed(unit, largest) {
  if (unit === "m²") {
    const found = [[1, "m²"], [1e-4, "cm²"], [1e-6, "mm²"]].find(([size]) => largest * 1.000001 >= size) ?? [1e-6, "mm²"];
    return largest > 0 ? [1 / found[0], found[1]] : [1, unit];
  }
  if (!["Pa", "m", "m/s", "s", "J", "N"].includes(unit) || !(largest >= 1e-9 && largest < 1e15)) return [1, unit];
  const most = unit.startsWith("m") || unit === "s" ? 1 : Infinity;
  for (const [size, prefix] of [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"]]) {
    if (size <= most && largest * 1.000001 >= size) return [1 / size, prefix + unit];
  }
  return [1, unit];
}

function quantity(x, unit, digits = 5) {
  if (Number.isNaN(x)) return "no value";
  const [factor, name] = prefixed(unit, Math.abs(x));
  return `${brief(Number((x * factor).toPrecision(digits)))}${name ? ` ${name}` : ""}`;
}
