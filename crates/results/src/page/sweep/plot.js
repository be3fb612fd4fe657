// A plot with axes, points and lines.

const RAMP = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [230, 200, 40]];

// Values between two ends at which an axis has its numbers.
function ticks(low, high, log) {
  if (log) {
    const found = [];
    for (let power = Math.floor(low); power <= Math.ceil(high); power++) found.push(power);
    const inside = found.filter((power) => power >= low - 1e-9 && power <= high + 1e-9);
    if (inside.length >= 2) return inside;
  }
  const raw = (high - low) / 6, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((k) => k * power).find((step) => step >= raw * 0.999);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  return found;
}

// The ends of an axis: those of the values, and a little more.
function ends(values) {
  const low = Math.min(...values), high = Math.max(...values);
  const room = high > low ? 0.04 * (high - low) : Math.abs(low) * 0.1 || 1;
  return [low - room, high + room];
}

class Plot {
  constructor(id, pick) {
    this.svg = $(id);
    this.pick = pick;
  }

  // series: { run, colour, points, marked }; a series of one point is a circle.
  show({ series, x, y, logX = false, logY = false, lines }) {
    const on = (value, log) => (log ? Math.log10(value) : value);
    const place = ([a, b]) => [on(a, logX), on(b, logY)];
    const fits = ([a, b]) => Number.isFinite(a) && Number.isFinite(b);
    const shown = series.map((one) => ({ ...one, points: one.points.map(place).filter(fits) })).filter((one) => one.points.length);
    const width = this.svg.clientWidth || 800, height = this.svg.clientHeight || 420;
    this.svg.replaceChildren();
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    if (!shown.length) {
      this.svg.append(svg("text", { x: width / 2, y: height / 2, "text-anchor": "middle", class: "pale" }, "No run has these values."));
      return 0;
    }
    const all = shown.flatMap((one) => one.points);
    const [left, right, top, bottom] = [84, 16, 14, 48];
    const [x0, x1] = ends(all.map((point) => point[0])), [y0, y1] = ends(all.map((point) => point[1]));
    const across = (value) => left + ((value - x0) / (x1 - x0)) * (width - left - right);
    const up = (value) => height - bottom - ((value - y0) / (y1 - y0)) * (height - top - bottom);
    this.axes({ width, height, left, right, top, bottom, across, up, x, y, xs: ticks(x0, x1, logX), ys: ticks(y0, y1, logY), logX, logY });
    for (const one of [...shown].sort((a, b) => a.marked - b.marked)) this.draw(one, across, up, lines);
    return shown.length;
  }

  axes({ width, height, left, right, top, bottom, across, up, x, y, xs, ys, logX, logY }) {
    const named = (values, log) => (log ? values.map((value) => brief(10 ** value)) : alike(values));
    const put = (name, attributes, text) => this.svg.append(svg(name, attributes, text));
    named(xs, logX).forEach((text, k) => {
      const at = across(xs[k]);
      put("line", { x1: at, x2: at, y1: top, y2: height - bottom, class: "grid" });
      put("text", { x: at, y: height - bottom + 17, "text-anchor": "middle" }, text);
    });
    named(ys, logY).forEach((text, k) => {
      const at = up(ys[k]);
      put("line", { x1: left, x2: width - right, y1: at, y2: at, class: "grid" });
      put("text", { x: left - 7, y: at + 4, "text-anchor": "end" }, text);
    });
    put("line", { x1: left, x2: width - right, y1: height - bottom, y2: height - bottom, class: "axis" });
    put("line", { x1: left, x2: left, y1: top, y2: height - bottom, class: "axis" });
    put("text", { x: (left + width - right) / 2, y: height - 9, "text-anchor": "middle" }, x);
    const middle = (top + height - bottom) / 2;
    put("text", { x: 14, y: middle, "text-anchor": "middle", transform: `rotate(-90 14 ${middle})` }, y);
  }

  draw({ run, colour, points, marked, title }, across, up, lines) {
    const placed = points.map(([a, b]) => [across(a).toFixed(1), up(b).toFixed(1)]);
    const made = lines && placed.length > 1
      ? svg("polyline", { points: placed.map((point) => point.join(",")).join(" "), stroke: colour, class: marked ? "run marked" : "run" })
      : svg("circle", { cx: placed[0][0], cy: placed[0][1], r: marked ? 7 : 5, fill: colour, class: marked ? "marked" : "" });
    made.append(svg("title", {}, title));
    made.addEventListener("click", () => this.pick(run));
    this.svg.append(made);
  }
}
