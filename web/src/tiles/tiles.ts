// One tile for each camera: its picture, and over it what belongs to its moment.
import { make } from "../elements/make.ts";
import type { Drawn } from "../messages/message_views.ts";
import type { StageStatus } from "../messages/run.ts";
import type { CameraData, RoomData, StageAbout } from "../messages/scene.ts";
import type { Views } from "../messages/views.ts";
import { overlay } from "./overlay.ts";
import { penOf, Tile } from "./tile.ts";

const MOST_PICTURES = 12; // of a camera that are kept: over a second at ten a second
const WIDE = 2; // times as wide as high, and wider: such a picture has a row to itself

const NARROW = 130; // px: no tile is narrower, so that all are seen at once

const TIGHT = 200; // px: narrower ones have smaller captions

// How many tiles beside each other leave all in sight, as large as can be. ratio: width over height of each.
export function columnsOf(count: number, ratio: number, width: number, height: number): number {
  const most = Math.max(1, Math.min(count, Math.floor(width / NARROW)));
  for (let columns = 1; columns < most; columns++) {
    if ((Math.ceil(count / columns) * width) / columns / ratio <= height) return columns;
  }
  return Math.min(count, most);
}

export class Tiles {
  private tiles = new Map<string, CameraTile>();
  private sources = new Map<string, string>(); // the camera of each stage that sends pictures
  private readonly section: HTMLElement;
  private readonly views: Views<Drawn>;
  private readonly learn: (camera: string) => void;

  // learn: begins to learn a target from a picture of a camera.
  constructor(section: HTMLElement, views: Views<Drawn>, learn: (camera: string) => void) {
    this.section = section;
    this.views = views;
    this.learn = learn;
    new ResizeObserver(() => this.arrange()).observe(section);
  }

  // stages: of the graph; the sources among them send the pictures of their cameras.
  from(stages: StageAbout[]): void {
    this.sources = new Map(
      stages.flatMap(({ source, name, camera }) => (source && camera ? [[name, camera]] : [])),
    );
  }

  // stages: what each is doing.
  update(stages: StageStatus[]): void {
    for (const stage of stages) {
      const camera = this.sources.get(stage.stage);
      if (camera !== undefined) this.tiles.get(camera)?.tell(stage);
    }
  }

  look(): void {
    for (const tile of this.tiles.values()) tile.look();
  }

  show(room: RoomData): void {
    const colors = room.targets.map(({ color }) => color);
    this.tiles = new Map(
      room.cameras.map((camera) => [camera.name, new CameraTile(camera, this.views, colors)]),
    );
    const figures = [...this.tiles.values()].map((tile) => tile.figure);
    for (const figure of figures) enlarging(figure, figures);
    for (const { camera, figure } of this.tiles.values())
      if (camera.kind === "color") figure.append(this.learning(camera.name));
    this.section.replaceChildren(...figures);
    document.body.classList.toggle("single", room.cameras.length === 1);
    this.arrange();
  }

  // The button that learns a target from a camera; it is seen where the picture is large.
  private learning(camera: string): HTMLElement {
    const button = make("button", "learn a target", { type: "button", className: "learn" });
    button.onclick = (event) => {
      event.stopPropagation();
      this.learn(camera);
    };
    button.onkeydown = (event) => event.stopPropagation();
    return button;
  }

  private arrange(): void {
    const sizes = [...this.tiles.values()].map(({ camera }) => camera.size[0] / camera.size[1]);
    const ratio = Math.min(...sizes.filter((size) => size < WIDE), WIDE);
    const { clientWidth, clientHeight } = this.section;
    const columns = columnsOf(sizes.length, ratio, clientWidth, clientHeight);
    this.section.style.setProperty("--tiles", `${columns}`);
    this.section.classList.toggle("tight", clientWidth / columns < TIGHT);
  }

  // bytes: length of the camera's name, the name, width, height, ms, the JPEG.
  picture(bytes: ArrayBuffer): void {
    const data = new DataView(bytes);
    const end = 1 + data.getUint8(0);
    const name = new TextDecoder().decode(bytes.slice(1, end));
    const time = data.getFloat64(end + 4, true);
    const jpeg = new Blob([bytes.slice(end + 12)], { type: "image/jpeg" });
    createImageBitmap(jpeg).then(
      (image) => this.tiles.get(name)?.show(image, time),
      () => {},
    );
  }

  changed(view: Drawn): void {
    for (const tile of this.tiles.values()) {
      if (!view.camera || view.camera === tile.camera.name) tile.redraw();
    }
  }
}

// A click, or Enter, shows one large, and another as before.
function enlarging(figure: HTMLElement, all: HTMLElement[]): void {
  const toggle = () => {
    for (const other of all) other.classList.toggle("large", other === figure && !figure.matches(".large"));
  };
  figure.tabIndex = 0;
  figure.onclick = toggle;
  figure.onkeydown = ({ key }) => key === "Enter" && toggle();
}

interface Picture {
  image: ImageBitmap;
  time: number; // ms
}

class CameraTile extends Tile {
  readonly camera: CameraData;
  private readonly views: Views<Drawn>;
  private readonly colors: string[];
  private readonly pictures: Picture[] = []; // the one that is shown, and those that wait for what belongs to them
  private readonly scale: number;

  constructor(camera: CameraData, views: Views<Drawn>, colors: string[]) {
    super(camera.name, camera.kind);
    this.camera = camera;
    this.views = views;
    this.colors = colors;
    const [width, height] = camera.size;
    this.figure.classList.toggle("wide", width > WIDE * height);
    this.scale = Math.max(1, Math.min(2, devicePixelRatio, 960 / width)) * Math.min(1, 800 / width);
    this.canvas.width = Math.round(width * this.scale);
    this.canvas.height = Math.round(height * this.scale);
    if (camera.depths) this.figure.append(depthScale(camera.depths));
  }

  show(image: ImageBitmap, time: number): void {
    this.renew();
    const last = this.pictures.at(-1);
    if (last && time < last.time) this.forget(this.pictures.length); // a loop began anew
    this.pictures.push({ image, time });
    this.redraw();
  }

  protected draw(): void {
    const last = this.pictures.at(-1);
    if (!last) return;
    const { image, time } = this.current(last.time);
    const pen = penOf(this.canvas);
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.drawImage(image, 0, 0, this.canvas.width, this.canvas.height);
    pen.scale(this.scale, this.scale);
    const line = (number: number) => Math.max(this.camera.size[0] / 320, 0.6) * number;
    const sheet = { pen, camera: this.camera.name, line, colors: this.colors };
    for (const view of this.views.at(time)) {
      if (!view.camera || view.camera === this.camera.name) overlay(sheet, view);
    }
  }

  // The newest picture that everything has come for; waiting for it has a limit.
  private current(newest: number): Picture {
    const reached = this.views.reached(this.camera.name, newest);
    const complete = this.pictures.findLastIndex(({ time }) => time <= reached);
    this.forget(Math.max(complete, this.pictures.length - MOST_PICTURES, 0));
    return this.pictures[0];
  }

  private forget(count: number): void {
    for (const { image } of this.pictures.splice(0, count)) image.close();
  }
}

// What colour is how far; black is what was not measured.
function depthScale({ farthest, colors }: { farthest: number; colors: string[] }): HTMLElement {
  const bar = make("i");
  bar.style.background = `linear-gradient(to right, ${colors.join(", ")})`;
  const element = make("div", "0", { className: "scale", title: "depth; black was not measured" });
  element.append(bar, `${farthest} m`);
  return element;
}
