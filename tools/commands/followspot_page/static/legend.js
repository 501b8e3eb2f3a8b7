const SILENT_MS = 2000; // longer without a word, the places that are shown are old

// Each target by name and colour, where it is and how well that is known.
export class Legend {
  constructor(list) {
    this.list = list;
    this.rows = [];
  }

  show(targets) {
    this.rows = targets.map(({ name, color }) => {
      const row = document.createElement("li");
      const dot = document.createElement("i");
      dot.style.background = color;
      dot.style.boxShadow = `0 0 10px ${color}`;
      const place = document.createElement("span");
      row.append(dot, name, place);
      row.dataset.state = "lost";
      return { row, place };
    });
    this.list.replaceChildren(...this.rows.map(({ row }) => row));
  }

  // How old the places are, where they are.
  look() {
    const silent = this.heard === undefined ? 0 : performance.now() - this.heard;
    if (silent > SILENT_MS) this.list.dataset.old = `these places are ${(silent / 1000).toFixed(0)} s old`;
    else delete this.list.dataset.old;
  }

  tracks({ target, state, xyz }) {
    this.heard = performance.now();
    const known = new Map(target.map((t, i) => [t, i]));
    this.rows.forEach(({ row, place }, t) => {
      const i = known.get(t);
      row.dataset.state = i === undefined ? "lost" : state[i];
      place.textContent =
        i === undefined ? "lost" : xyz[i].map((v) => (v < 0 ? "" : "\u2007") + v.toFixed(2)).join("  ").replaceAll("-", "\u2212") + " m" + (state[i] === "tracked" ? "" : `  ${state[i]}`);
    });
  }
}
