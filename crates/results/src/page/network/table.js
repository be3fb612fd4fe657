// The table of elements, page by page.

class Table {
  constructor(network, pick) {
    this.network = network;
    this.pick = pick;
    this.rowsOnPage = 50;
    this.page = 0;
    this.order = null;
    this.sorted = { column: 0, down: false };
    const unit = meta.unit ? ` (${meta.unit})` : "";
    const axes = ["x", "y", "z"].slice(0, network.d);
    this.columns = [
      { name: "id", text: network.id, compare: (a, b) => this.compareIds(a, b) },
      ...axes.map((name, axis) => this.column(name + unit, (k) => network.at(k, axis))),
      this.column(`radius${unit}`, (k) => (meta.cutoff === null && !(meta.bodies && network.radius(k) === 0) ? network.radius(k) : NaN)),
      this.column("contacts", network.coordination),
      this.column(`largest ${meta.value}${meta.bodies ? "" : unit}`, (k) => (network.coordination(k) ? network.largest[k] : NaN)),
    ];
    this.head();
    const on = (id, kind, act) => document.getElementById(id).addEventListener(kind, act);
    on("filter", "submit", (event) => event.preventDefault());
    on("filter-id", "input", () => this.arrange());
    on("first", "click", () => this.show(0));
    on("previous", "click", () => this.show(this.page - 1));
    on("next", "click", () => this.show(this.page + 1));
    on("last", "click", () => this.show(Infinity));
    on("page", "change", (event) => this.show(Number(event.target.value) - 1));
    this.arrange();
  }

  column(name, value) {
    const text = (k) => (Number.isNaN(value(k)) ? "–" : String(value(k)));
    // Missing numbers come last in both directions.
    const compare = (a, b) => {
      const [x, y] = [value(a), value(b)];
      if (Number.isNaN(x) || Number.isNaN(y)) return (Number.isNaN(x) - Number.isNaN(y)) * (this.sorted.down ? -1 : 1);
      return x - y;
    };
    return { name, text, compare };
  }

  compareIds(a, b) {
    if (!meta.ids) return a - b;
    const [x, y] = [BigInt(this.network.id(a)), BigInt(this.network.id(b))];
    return x < y ? -1 : Number(x > y);
  }

  head() {
    const row = document.getElementById("table-head");
    row.replaceChildren(...this.columns.map(({ name }, column) => {
      const head = document.createElement("th"), button = document.createElement("button");
      head.scope = "col";
      button.type = "button";
      button.textContent = name;
      button.addEventListener("click", () => {
        this.sorted = { column, down: this.sorted.column === column && !this.sorted.down };
        this.arrange();
      });
      head.append(button);
      return head;
    }));
  }

  arrange() {
    const { network } = this;
    const start = document.getElementById("filter-id").value.trim();
    const order = [];
    for (let k = 0; k < network.n; k++) if (!start || network.id(k).startsWith(start)) order.push(k);
    const { column, down } = this.sorted;
    const { compare } = this.columns[column];
    // Equal elements stay in the order of the file.
    order.sort(down ? (a, b) => compare(b, a) || a - b : (a, b) => compare(a, b) || a - b);
    this.order = order;
    document.querySelectorAll("#table-head th").forEach((head, k) => {
      head.setAttribute("aria-sort", k !== column ? "none" : down ? "descending" : "ascending");
      head.firstChild.textContent = this.columns[k].name + (k !== column ? "" : down ? " ↓" : " ↑");
    });
    document.getElementById("table-count").textContent = `${grouped(order.length)} of ${grouped(network.n)} elements`;
    this.show(0);
  }

  show(page) {
    const pages = Math.max(1, Math.ceil(this.order.length / this.rowsOnPage));
    this.page = Math.max(0, Math.min(pages - 1, Number.isNaN(page) ? 0 : page));
    const start = this.page * this.rowsOnPage;
    document.getElementById("table-body").replaceChildren(...this.order.slice(start, start + this.rowsOnPage).map((k) => {
      const row = document.createElement("tr");
      row.dataset.index = k;
      this.columns.forEach(({ text }, column) => {
        const cell = document.createElement(column === 0 ? "th" : "td");
        if (column === 0) {
          cell.scope = "row";
          cell.append(elementButton(this.network, k, this.pick));
        } else cell.textContent = text(k);
        row.append(cell);
      });
      return row;
    }));
    const field = document.getElementById("page");
    field.value = this.page + 1;
    field.max = pages;
    document.getElementById("pages").textContent = `of ${grouped(pages)}`;
    for (const id of ["first", "previous"]) document.getElementById(id).disabled = this.page === 0;
    for (const id of ["next", "last"]) document.getElementById(id).disabled = this.page === pages - 1;
    this.mark(this.marked ?? -1);
  }

  mark(selected) {
    this.marked = selected;
    for (const row of document.getElementById("table-body").rows) row.setAttribute("aria-selected", Number(row.dataset.index) === selected);
  }
}

function elementButton(network, k, pick) {
  const button = document.createElement("button");
  button.type = "button";
  button.textContent = network.id(k);
  button.setAttribute("aria-label", `select element ${network.id(k)}`);
  button.addEventListener("click", () => pick(k));
  return button;
}
