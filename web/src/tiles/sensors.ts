// One tile for each sensor: the last seconds of an inertial one, the newest message of any other as a table.

import { make } from "../elements/make.ts";
import { table } from "../graph/tables.ts";
import type { InertialView, Reading, View } from "../messages/message_views.ts";
import type { StageStatus } from "../messages/run.ts";
import type { SensorData } from "../messages/scene.ts";
import { plot, WINDOW_MS } from "../plots/plot.ts";
import { number, stageOf } from "../words/figures.ts";
import { penOf, Tile } from "./tile.ts";

const MOST_POINTS = 3000;
const PLOTS = [
  { name: "turn_rate", title: "turn rate, rad/s", least: 0.2 },
  { name: "specific_force", title: "specific force, m/s²", least: 2 },
] as const;

export class Sensors {
  private tiles: SensorTile[] = [];
  private shown = "";
  private readonly section: HTMLElement;

  // section: where the tiles of cameras are, too.
  constructor(section: HTMLElement) {
    this.section = section;
  }

  // sensors: their names, and the ports that send their readings.
  show(sensors: SensorData[]): void {
    const shown = JSON.stringify(sensors);
    if (shown !== this.shown) {
      for (const tile of this.tiles) tile.figure.remove();
      this.tiles = sensors.map((sensor) => new SensorTile(sensor));
      this.shown = shown;
    }
    this.section.append(...this.tiles.map((tile) => tile.figure));
  }

  // stages: what each is doing, and how often.
  update(stages: StageStatus[]): void {
    for (const tile of this.tiles) tile.update(stages);
  }

  look(): void {
    for (const tile of this.tiles) tile.look();
  }

  // Whether a view is one of a sensor.
  take(view: View): view is Reading {
    const tile = this.tiles.find(({ sensor }) => sensor.ports.includes(view.port));
    if (view.kind === "Inertial" || view.kind === "Message") tile?.take(view);
    return tile !== undefined;
  }
}

interface Point {
  time: number; // ms
  turn_rate: (number | null)[];
  specific_force: (number | null)[];
}

class SensorTile extends Tile {
  readonly sensor: SensorData;
  private points: Point[] = [];
  private readonly newest = new Map<string, Reading>(); // by port
  private past: { time: number; seq: number }[] = []; // of the first port, of the last seconds
  private readonly tables = make("div", "", { className: "tables" });

  constructor(sensor: SensorData) {
    super(sensor.name, sensor.kind);
    this.sensor = sensor;
    this.figure.classList.add("sensor");
    this.figure.append(this.tables);
    this.canvas.hidden = true;
  }

  update(stages: StageStatus[]): void {
    const [port] = this.sensor.ports;
    const stage = stages.find(({ stage }) => port !== undefined && stage === stageOf(port));
    if (!stage) return;
    this.tell(stage);
    const { kind, rate, mount } = this.sensor;
    const often = `${number(this.rate(port))}/s${rate === null ? "" : ` of ${rate}/s`}`;
    this.kind.textContent = [kind, often, mount && `on ${mount}`].filter(Boolean).join(" · ");
  }

  take(view: Reading): void {
    this.newest.set(view.port, view);
    if (view.port === this.sensor.ports[0]) this.remember(view);
    if (view.kind === "Inertial") this.add(view);
    else this.tellTables();
    this.renew();
  }

  protected draw(): void {
    const scale = devicePixelRatio;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    this.canvas.width = Math.round(width * scale);
    this.canvas.height = Math.round(height * scale);
    const pen = penOf(this.canvas);
    pen.scale(scale, scale);
    const part = height / PLOTS.length;
    PLOTS.forEach(({ name, title, least }, i) => {
      const points = this.points.map((point) => ({ time: point.time, row: point[name] }));
      plot(pen, points, title, least, [10, i * part, width - 20, part - 6]);
    });
  }

  // Readings per second of capture time: of inertial ones within a message if it has several; else messages, as they are numbered.
  private rate(port: string): number | null {
    const view = this.newest.get(port);
    if (view?.rate) return view.rate;
    const [first, last] = [this.past[0], this.past.at(-1)];
    if (!first || !last || last.time === first.time) return null;
    return (1000 * (last.seq - first.seq)) / (last.time - first.time);
  }

  private remember({ time, seq }: Reading): void {
    const last = this.past.at(-1);
    if (last && time < last.time) this.past = []; // a loop began anew
    this.past.push({ time, seq });
    this.past = this.past.filter((at) => at.time >= time - WINDOW_MS);
  }

  private add({ times, turn_rate, specific_force }: InertialView): void {
    if (!times.length) return;
    const before = this.points.at(-1);
    if (before && times[0] < before.time - WINDOW_MS) this.points = []; // a loop began anew
    let newest = this.points.at(-1)?.time ?? Number.NEGATIVE_INFINITY;
    times.forEach((time, i) => {
      if (time <= newest) return;
      newest = time;
      this.points.push({ time, turn_rate: turn_rate[i], specific_force: specific_force[i] });
    });
    this.points = this.points.filter(({ time }) => time >= newest - WINDOW_MS).slice(-MOST_POINTS);
    this.canvas.hidden = false;
    this.redraw();
  }

  private tellTables(): void {
    const others = [...this.newest.values()].filter((view) => view.kind === "Message");
    this.tables.replaceChildren(
      ...others.flatMap(({ port, message, readings, head, rows }) => [
        make("p", `${port} · ${message} · ${readings} row${readings === 1 ? "" : "s"}`),
        table(head, rows),
      ]),
    );
  }
}
