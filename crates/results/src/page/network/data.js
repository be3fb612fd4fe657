// Reads the network from the text in this page, which is base64 of deflated little-endian arrays.

// Returns the arrays by name, and values computed from them.
async function openNetwork() {
  const element = document.getElementById("data");
  const bytes = await inflated(bytesOfBase64(element.textContent), meta.bytes);
  element.textContent = "";
  if (bytes.length !== meta.bytes) throw new Error("the data is damaged");
  const kinds = { f64: Float64Array, f32: Float32Array, u32: Uint32Array, i32: Int32Array, i64: BigInt64Array };
  const arrays = {};
  for (const { name, kind, start, length } of meta.arrays) arrays[name] = new kinds[kind](bytes.buffer, start, length);
  const { i, j, distance } = arrays;
  const n = meta.elements, m = i.length, d = meta.dimensions;
  const radius = arrays.radius.length === n ? (k) => arrays.radius[k] : () => arrays.radius[0];
  const reach = meta.cutoff === null ? (a, b) => radius(a) + radius(b) : () => meta.cutoff;

  // The contacts of element k are contacts[starts[k]] to contacts[starts[k + 1]].
  const starts = new Uint32Array(n + 1), contacts = new Uint32Array(2 * m);
  for (let c = 0; c < m; c++) { starts[i[c] + 1]++; starts[j[c] + 1]++; }
  for (let k = 0; k < n; k++) starts[k + 1] += starts[k];
  const next = starts.slice(0, n);
  const overlap = arrays.overlap ?? new Float64Array(m), largest = new Float64Array(n).fill(-Infinity);
  for (let c = 0; c < m; c++) {
    const a = i[c], b = j[c];
    contacts[next[a]++] = c;
    contacts[next[b]++] = c;
    if (!arrays.overlap) overlap[c] = reach(a, b) - distance[c];
    largest[a] = Math.max(largest[a], overlap[c]);
    largest[b] = Math.max(largest[b], overlap[c]);
  }
  const ids = arrays.id;
  const id = ids ? (k) => ids[k].toString() : (k) => String(k);
  let numbers = null;
  const find = (text) => {
    if (!/^-?\d{1,19}$/.test(text)) return -1;
    const wanted = BigInt(text).toString();
    numbers ??= new Map(Array.from({ length: n }, (_, k) => [id(n - 1 - k), n - 1 - k]));
    return numbers.get(wanted) ?? -1;
  };
  const at = (k, axis) => (axis < d ? arrays.centre[d * k + axis] : 0);
  const coordination = (k) => starts[k + 1] - starts[k];
  // The columns of the contacts.
  const columns = meta.bodies
    ? meta.bodies.columns.map(({ name, array }) => ({ name, of: (c) => arrays[array][c] }))
    : [{ name: "distance", of: (c) => distance[c] }, { name: meta.value, of: (c) => overlap[c] }];
  const { point, halves, corners, facets, owner } = arrays;
  return { n, m, d, i, j, distance, overlap, columns, point, halves, corners, facets, owner, largest, radius, at, id, find, starts, contacts, coordination, branch: arrays.branch, shift: arrays.shift };
}
