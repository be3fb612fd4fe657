// The page of a sweep: what is plotted, and the table.

const { columns, rows, histories, curves } = meta;
const parameters = columns.slice(1, 1 + meta.parameters);
const isNumber = (value) => typeof value === "number";
const numeric = columns.filter((_, k) => rows.some((row) => isNumber(row[k])));
const results = numeric.filter((name) => name !== "run" && !parameters.includes(name));
let marked = null;

const valueOf = (row, name) => row[columns.indexOf(name)];
const titleOf = (row) => `run ${row[0]}: ${parameters.map((name) => `${name} = ${isNumber(valueOf(row, name)) ? brief(valueOf(row, name)) : valueOf(row, name)}`).join(", ")}`;

function fill(id, names, chosen) {
  $(id).replaceChildren(...names.map((name) => {
    const option = document.createElement("option");
    option.value = option.textContent = name;
    option.selected = name === chosen;
    return option;
  }));
}

// The colour of each run, from the smallest to the largest value of a column. Texts are numbered.
function colours() {
  const values = rows.map((row) => valueOf(row, $("colour").value));
  const texts = [...new Set(values.filter((value) => !isNumber(value)))];
  const numbers = values.map((value) => (isNumber(value) ? value : texts.indexOf(value)));
  const low = Math.min(...numbers), high = Math.max(...numbers);
  return numbers.map((value) => `rgb(${ramp(RAMP, high > low ? (value - low) / (high - low) : 0.4).join(",")})`);
}

function series(points) {
  const colour = colours();
  return rows.map((row, k) => ({ run: k, colour: colour[k], points: points(row, k), marked: k === marked ? 1 : 0, title: titleOf(row) }));
}

function showResults() {
  const x = $("result-x").value, y = $("result-y").value;
  const point = (row) => (isNumber(valueOf(row, x)) && isNumber(valueOf(row, y)) ? [[valueOf(row, x), valueOf(row, y)]] : []);
  const shown = plots.results.show({ series: series(point), x, y, logX: $("log-x").checked, logY: $("log-y").checked, lines: false });
  $("result-note").textContent = `${shown} of ${rows.length} runs have both values.`;
}

// A curve of the model divides a displacement by a length and a force by an area.
function showHistories() {
  const curve = curves.find((curve) => curve.name === $("curve").value);
  const x = curve ? curve.x : $("history-x").value, y = curve ? curve.y : $("history-y").value;
  for (const id of ["history-x", "history-y"]) $(id).disabled = Boolean(curve);
  const points = (_, k) => {
    const history = histories[k];
    if (!history || !history[x] || !history[y]) return [];
    const [over, area] = [(curve && curve.length) || 1, (curve && curve.area) || 1];
    return history[x].map((value, row) => [value === null ? NaN : value / over, history[y][row] === null ? NaN : history[y][row] / area]);
  };
  const named = (name, over, unit) => (over ? name.replace(/\[[^\]]*\]$/, `[${unit}]`) : name);
  const shown = plots.histories.show({
    series: series(points),
    x: named(x, curve && curve.length, "m/m"),
    y: named(y, curve && curve.area, "Pa"),
    lines: true,
  });
  $("history-note").textContent = `${shown} of ${rows.length} runs have these columns. Histories of many rows are thinned; history.csv of each run has them all.`;
}

function showAll() {
  showResults();
  showHistories();
}

function pick(run) {
  marked = marked === run ? null : run;
  bodyRows.forEach((row, k) => row.setAttribute("aria-selected", k === marked));
  showAll();
}

// Missing values come last in both directions.
function sort(name, button) {
  const down = button.dataset.down !== "true";
  document.querySelectorAll("#table th button").forEach((other) => delete other.dataset.down);
  button.dataset.down = down;
  const sign = down ? 1 : -1;
  const compare = (a, b) => {
    const [p, q] = [a, b].map((k) => valueOf(rows[k], name));
    if (p === null || q === null) return (p === null) - (q === null);
    return sign * (isNumber(p) && isNumber(q) ? p - q : String(p).localeCompare(String(q)));
  };
  const order = rows.map((_, k) => k).sort((a, b) => compare(a, b) || a - b);
  document.querySelector("#table tbody").replaceChildren(...order.map((k) => bodyRows[k]));
}

const plots = { results: new Plot("results", pick), histories: new Plot("histories", pick) };
const bodyRows = [...document.querySelectorAll("#table tbody tr")];
bodyRows.forEach((row, k) => row.addEventListener("click", (event) => event.target.closest("a") || pick(k)));
document.querySelectorAll("#table thead th").forEach((head) => {
  const button = document.createElement("button");
  button.type = "button";
  button.textContent = head.textContent;
  button.addEventListener("click", () => sort(button.textContent, button));
  head.replaceChildren(button);
});

const first = histories.find((history) => history);
const recorded = first ? Object.keys(first) : [];
const across = parameters.find((name) => numeric.includes(name));
const peak = results.find((name) => name.endsWith(" peak")) || results.find((name) => name === "broken_joints");
fill("result-x", numeric, across || "run");
fill("result-y", results, peak || results[0]);
fill("colour", ["run", ...parameters, ...results], parameters[parameters.length - 1] || "run");
fill("curve", [...curves.map((curve) => curve.name), "any two columns"]);
fill("history-x", recorded, "time");
fill("history-y", recorded, recorded.find((name) => name.startsWith("kinetic")) || recorded[recorded.length - 1]);
for (const id of ["result-x", "result-y", "log-x", "log-y"]) $(id).addEventListener("change", showResults);
for (const id of ["curve", "history-x", "history-y"]) $(id).addEventListener("change", showHistories);
$("colour").addEventListener("change", showAll);
window.addEventListener("resize", showAll);
theme();
showAll();
