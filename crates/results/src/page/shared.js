// Code for the pages of contact networks and of runs: decoding of numbers, colours, light and dark mode.

const meta = JSON.parse(document.getElementById("meta").textContent);

function bytesOfBase64(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const characters = atob(text);
  const bytes = new Uint8Array(characters.length);
  for (let k = 0; k < bytes.length; k++) bytes[k] = characters.charCodeAt(k);
  return bytes;
}

async function inflated(bytes, length) {
  try {
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  } catch {
    // Browsers before 2023.
    return inflate(bytes, length);
  }
}

// RFC 1951.
function inflate(input, length) {
  const output = new Uint8Array(length);
  let at = 0, held = 0, holds = 0, to = 0;
  const bits = (count) => {
    while (holds < count) {
      held |= input[at++] << holds;
      holds += 8;
    }
    const value = held & ((1 << count) - 1);
    held >>>= count;
    holds -= count;
    return value;
  };
  const code = (lengths) => {
    const counts = new Uint16Array(16), starts = new Uint16Array(16), symbols = new Uint16Array(lengths.length);
    for (const bit of lengths) counts[bit]++;
    counts[0] = 0;
    for (let bit = 1; bit < 16; bit++) starts[bit] = starts[bit - 1] + counts[bit - 1];
    lengths.forEach((bit, symbol) => { if (bit) symbols[starts[bit]++] = symbol; });
    return { counts, symbols };
  };
  const symbol = ({ counts, symbols }) => {
    let value = 0, first = 0, index = 0;
    for (let bit = 1; bit < 16; bit++) {
      value |= bits(1);
      const count = counts[bit];
      if (value - first < count) return symbols[index + value - first];
      index += count;
      first = (first + count) << 1;
      value <<= 1;
    }
    throw new Error("the data is damaged");
  };
  const baseOf = (extra, first) => {
    const base = [first];
    extra.forEach((bit, k) => base.push(base[k] + (1 << bit)));
    return base;
  };
  const lengthExtra = [0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0];
  const lengthBase = baseOf(lengthExtra, 3);
  lengthBase[28] = 258;
  const farExtra = [0, 0, 0, 0, ...Array.from({ length: 26 }, (_, k) => (k >> 1) + 1)];
  const farBase = baseOf(farExtra, 1);
  const fixed = [code([...Array(144).fill(8), ...Array(112).fill(9), ...Array(24).fill(7), ...Array(8).fill(8)]), code(Array(30).fill(5))];
  const dynamic = () => {
    const order = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];
    const literals = bits(5) + 257, fars = bits(5) + 1, count = bits(4) + 4;
    const lengths = new Array(19).fill(0);
    for (let k = 0; k < count; k++) lengths[order[k]] = bits(3);
    const meaning = code(lengths), all = [];
    while (all.length < literals + fars) {
      const found = symbol(meaning);
      if (found < 16) all.push(found);
      else {
        const value = found === 16 ? all[all.length - 1] : 0;
        for (let k = found === 16 ? bits(2) + 3 : found === 17 ? bits(3) + 3 : bits(7) + 11; k > 0; k--) all.push(value);
      }
    }
    return [code(all.slice(0, literals)), code(all.slice(literals))];
  };
  for (let last = 0; !last;) {
    last = bits(1);
    const kind = bits(2);
    if (kind === 0) {
      held = holds = 0;
      const size = input[at] | (input[at + 1] << 8);
      output.set(input.subarray(at + 4, at + 4 + size), to);
      at += 4 + size;
      to += size;
      continue;
    }
    const [literal, far] = kind === 1 ? fixed : dynamic();
    for (;;) {
      const found = symbol(literal);
      if (found === 256) break;
      if (found < 256) {
        output[to++] = found;
        continue;
      }
      const size = lengthBase[found - 257] + bits(lengthExtra[found - 257]);
      const place = symbol(far);
      const back = farBase[place] + bits(farExtra[place]);
      for (let k = 0; k < size; k++, to++) output[to] = output[to - back];
    }
  }
  return output;
}

// Six digits for legends. Values of single elements are shown with all digits.
function brief(x) {
  const rounded = Number(x.toPrecision(6)) + 0;
  return Math.abs(rounded) >= 1e-4 && Math.abs(rounded) < 1e6 || rounded === 0 ? String(rounded) : rounded.toExponential().replace("e+", "e");
}

// Formats the numbers of a scale with the same number of decimals and the same power of ten.
function alike(numbers) {
  const largest = Math.max(...numbers.map(Math.abs));
  if (!(largest > 0) || !Number.isFinite(largest)) return numbers.map(brief);
  const of = Math.floor(Math.log10(largest)), power = largest >= 1e-3 && largest < 1e6 ? 0 : of;
  const scaled = numbers.map((x) => x / 10 ** power);
  // Three digits of the largest number, without decimals that are zero for all numbers.
  let decimals = Math.max(0, 2 - of + power);
  while (decimals > 0 && scaled.every((x) => Number(x.toFixed(decimals - 1)) === Number(x.toFixed(decimals)))) decimals--;
  return scaled.map((x) => (x === 0 && power ? "0" : (x + 0).toFixed(decimals) + (power ? `e${power}` : "")));
}

function grouped(x) {
  return String(x).replace(/\B(?=(\d{3})+$)/g, ",");
}

function ramp(stops, share) {
  const place = Math.max(0, Math.min(1, share)) * (stops.length - 1), k = Math.min(Math.floor(place), stops.length - 2);
  return stops[k].map((x, channel) => Math.round(x + (stops[k + 1][channel] - x) * (place - k)));
}

const $ = (id) => document.getElementById(id);
const svg = (name, attributes, text = "") => {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const key in attributes) made.setAttribute(key, attributes[key]);
  made.textContent = text;
  return made;
};

function theme() {
  const system = window.matchMedia("(prefers-color-scheme: dark)");
  const root = document.documentElement;
  const isDark = () => (root.dataset.theme ? root.dataset.theme === "dark" : system.matches);
  const show = () => {
    $("theme").setAttribute("aria-pressed", isDark());
    $("theme").textContent = isDark() ? "Light mode" : "Dark mode";
    $("theme").setAttribute("aria-label", "Dark mode");
    window.dispatchEvent(new Event("fdem-theme"));
  };
  $("theme").addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
    show();
  });
  system.addEventListener("change", show);
  show();
}

const isDark = () => $("theme").getAttribute("aria-pressed") === "true";
