// One tile for each sensor: the last seconds of an inertial one, the newest message of any other as a table.
import { number, stageOf } from "./figures.js";
import { make } from "./make.js";
import { WINDOW_MS, plot } from "./plot.js";
import { table } from "./tables.js";
import { Tile } from "./tile.js";

const MOST_POINTS = 3000;
const PLOTS = [
  { name: "turn_rate", title: "turn rate, rad/s", least: 0.2 },
  { name: "specific_force", title: "specific force, m/s²", least: 2 },
];

export class Sensors {
  // section: where the tiles of cameras are, too.
  constructor(section) {
    this.section = section;
    this.tiles = [];
    this.shown = "";
  }

  // sensors: their names, and the ports that send their readings.
  show(sensors) {
    const shown = JSON.stringify(sensors);
    if (shown !== this.shown) {
      for (const tile of this.tiles) tile.figure.remove();
      this.tiles = sensors.map((sensor) => new SensorTile(sensor));
      this.shown = shown;
    }
    this.section.append(...this.tiles.map((tile) => tile.figure));
  }

  // stages: what each is doing, and how often.
  update(stages) {
    for (const tile of this.tiles) tile.update(stages);
  }

  look() {
    for (const tile of this.tiles) tile.look();
  }

  // Whether a view is one of a sensor.
  take(view) {
    const tile = this.tiles.find(({ sensor }) => sensor.ports.includes(view.port));
    tile?.take(view);
    return tile !== undefined;
  }
}

class SensorTile extends Tile {
  constructor(sensor) {
    super(sensor.name, sensor.kind);
    this.sensor = sensor;
    this.points = []; // {time, turn_rate, specific_force}
    this.newest = new Map(); // by port
    this.past = []; // {time, seq} of the first port, of the last seconds
    this.tables = make("div", "", { className: "tables" });
    this.figure.classList.add("sensor");
    this.figure.append(this.tables);
    this.canvas.hidden = true;
  }

  update(stages) {
    const [port] = this.sensor.ports;
    const stage = stages.find(({ stage }) => port !== undefined && stage === stageOf(port));
    if (!stage) return;
    this.tell(stage);
    const { kind, rate, mount } = this.sensor;
    const often = `${number(this.rate(port))}/s${rate === null ? "" : ` of ${rate}/s`}`;
    this.kind.textContent = [kind, often, mount && `on ${mount}`].filter(Boolean).join(" · ");
  }

  // Readings per second of capture time: of inertial ones within a message if it has several; else messages, as they are numbered.
  rate(port) {
    const view = this.newest.get(port);
    if (view?.rate) return view.rate;
    const [first, last] = [this.past[0], this.past.at(-1)];
    if (!first || last.time === first.time) return null;
    return (1000 * (last.seq - first.seq)) / (last.time - first.time);
  }

  remember({ time, seq }) {
    if (this.past.length && time < this.past.at(-1).time) this.past = []; // a loop began anew
    this.past.push({ time, seq });
    this.past = this.past.filter((at) => at.time >= time - WINDOW_MS);
  }

  take(view) {
    this.newest.set(view.port, view);
    if (view.port === this.sensor.ports[0]) this.remember(view);
    if (view.kind === "Inertial") this.add(view);
    else this.tell_tables();
    this.renew();
  }

  add({ times, turn_rate, specific_force }) {
    if (!times.length) return;
    if (this.points.length && times[0] < this.points.at(-1).time - WINDOW_MS) this.points = []; // a loop began anew
    times.forEach((time, i) => {
      if (time > (this.points.at(-1)?.time ?? -Infinity)) this.points.push({ time, turn_rate: turn_rate[i], specific_force: specific_force[i] });
    });
    const since = this.points.at(-1).time - WINDOW_MS;
    this.points = this.points.filter(({ time }) => time >= since).slice(-MOST_POINTS);
    this.canvas.hidden = false;
    this.redraw();
  }

  draw() {
    const scale = devicePixelRatio;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    this.canvas.width = Math.round(width * scale);
    this.canvas.height = Math.round(height * scale);
    const pen = this.canvas.getContext("2d");
    pen.scale(scale, scale);
    const part = height / PLOTS.length;
    PLOTS.forEach(({ name, title, least }, i) => {
      const points = this.points.map((point) => ({ time: point.time, row: point[name] }));
      plot(pen, points, title, least, [10, i * part, width - 20, part - 6]);
    });
  }

  tell_tables() {
    const others = [...this.newest.values()].filter(({ kind }) => kind !== "Inertial");
    this.tables.replaceChildren(...others.flatMap(({ port, message, readings, head, rows }) => [
      make("p", `${port} · ${message} · ${readings} row${readings === 1 ? "" : "s"}`),
      table(head, rows),
    ]));
  }
}
