// One tile for each camera: its picture, and over it what was detected, where it was searched, where tracks are.
import { make } from "./make.js";
import { Tile } from "./tile.js";

const MOST_PICTURES = 12; // of a camera that are kept: over a second at ten a second
const WIDE = 2; // times as wide as high, and wider: such a picture has a row to itself
const PERSON_HUES = [205, 28, 140, 275, 52, 330];

export class Tiles {
  constructor(section, views) {
    this.section = section;
    this.views = views;
    this.tiles = new Map();
    this.sources = new Map();
    this.colors = [];
  }

  // stages: of the graph; the sources among them send the pictures of their cameras.
  from(stages) {
    this.sources = new Map(stages.filter(({ source, camera }) => source && camera).map(({ name, camera }) => [name, camera]));
  }

  // stages: what each is doing.
  update(stages) {
    for (const stage of stages) this.tiles.get(this.sources.get(stage.stage))?.tell(stage);
  }

  look() {
    for (const tile of this.tiles.values()) tile.look();
  }

  show(room) {
    this.colors = room.targets.map(({ color }) => color);
    this.tiles = new Map(room.cameras.map((camera) => [camera.name, new CameraTile(camera, this)]));
    this.section.replaceChildren(...[...this.tiles.values()].map((tile) => tile.figure));
  }

  // bytes: length of the camera's name, the name, width, height, ms, the JPEG.
  picture(bytes) {
    const data = new DataView(bytes);
    const end = 1 + data.getUint8(0);
    const name = new TextDecoder().decode(bytes.slice(1, end));
    const time = data.getFloat64(end + 4, true);
    const jpeg = new Blob([bytes.slice(end + 12)], { type: "image/jpeg" });
    createImageBitmap(jpeg).then((image) => this.tiles.get(name)?.show(image, time), () => {});
  }

  changed(view) {
    for (const tile of this.tiles.values()) {
      if (!view.camera || view.camera === tile.camera.name) tile.redraw();
    }
  }
}

class CameraTile extends Tile {
  constructor(camera, { views, colors }) {
    super(camera.name, camera.kind);
    this.camera = camera;
    this.views = views;
    this.colors = colors;
    this.pictures = []; // {image, time}: the one that is shown, and those that wait for what belongs to them
    const [width, height] = camera.size;
    this.figure.classList.toggle("wide", width > WIDE * height);
    this.scale = Math.max(1, Math.min(2, devicePixelRatio, 960 / width)) * Math.min(1, 800 / width);
    this.canvas.width = Math.round(width * this.scale);
    this.canvas.height = Math.round(height * this.scale);
    if (camera.depths) this.figure.append(scale(camera.depths));
  }

  show(image, time) {
    this.renew();
    if (this.pictures.length && time < this.pictures.at(-1).time) this.forget(this.pictures.length); // a loop began anew
    this.pictures.push({ image, time });
    this.redraw();
  }

  // The newest picture that everything has come for; waiting for it has a limit.
  current() {
    const reached = this.views.reached(this.camera.name, this.pictures.at(-1).time);
    const newest = this.pictures.findLastIndex(({ time }) => time <= reached);
    this.forget(Math.max(newest, this.pictures.length - MOST_PICTURES, 0));
    return this.pictures[0];
  }

  forget(count) {
    for (const { image } of this.pictures.splice(0, count)) image.close();
  }

  draw() {
    if (!this.pictures.length) return;
    const { image, time } = this.current();
    const pen = this.canvas.getContext("2d");
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.drawImage(image, 0, 0, this.canvas.width, this.canvas.height);
    pen.scale(this.scale, this.scale);
    for (const view of this.views.at(time)) {
      if (!view.camera || view.camera === this.camera.name) DRAW[view.kind]?.(pen, view, this);
    }
  }

  line(number) {
    return Math.max(this.camera.size[0] / 320, 0.6) * number;
  }
}

// What colour is how far; black is what was not measured.
function scale({ farthest, colors }) {
  const bar = make("i");
  bar.style.background = `linear-gradient(to right, ${colors.join(", ")})`;
  const element = make("div", "0", { className: "scale", title: "depth; black was not measured" });
  element.append(bar, `${farthest} m`);
  return element;
}

function circle(pen, [x, y, r], tile, color, { width = 1.2, dash = [] } = {}) {
  pen.strokeStyle = color;
  pen.lineWidth = tile.line(width);
  pen.setLineDash(dash.map((d) => tile.line(d)));
  pen.beginPath();
  pen.arc(x, y, Math.max(r, tile.line(2)), 0, 2 * Math.PI);
  pen.stroke();
}

function arrow(pen, [x0, y0], [x1, y1], tile, color, width) {
  const along = Math.atan2(y1 - y0, x1 - x0);
  const barb = Math.min(tile.line(6), Math.hypot(x1 - x0, y1 - y0) / 2);
  pen.strokeStyle = color;
  pen.lineWidth = tile.line(width);
  pen.setLineDash([]);
  pen.beginPath();
  pen.moveTo(x0, y0);
  pen.lineTo(x1, y1);
  for (const side of [-0.5, 0.5]) {
    pen.moveTo(x1, y1);
    pen.lineTo(x1 - barb * Math.cos(along + side), y1 - barb * Math.sin(along + side));
  }
  pen.stroke();
}

const person = (number) => `hsl(${PERSON_HUES[number % PERSON_HUES.length]} 90% 65%)`;

const DRAW = {
  Blobs(pen, { pixel, radius, target }, tile) {
    pixel.forEach(([x, y], i) => circle(pen, [x, y, radius[i] + tile.line(2)], tile, tile.colors[target[i]] ?? "#ffffff99"));
  },
  Forecast(pen, { images }, tile) {
    images[tile.camera.name]?.forEach((place, t) => place && circle(pen, [place[0], place[1], Math.min(Math.max(place[2], tile.line(9)), tile.line(60))], tile, `${tile.colors[t]}66`, { width: 0.9, dash: [3, 3] }));
  },
  Tracks(pen, { target, images }, tile) {
    images[tile.camera.name]?.forEach((place, i) => {
      if (!place) return;
      const [x, y, r] = place;
      const color = tile.colors[target[i]] ?? "#fff";
      const inner = Math.max(r, tile.line(3)) + tile.line(3);
      const outer = inner + tile.line(4);
      pen.strokeStyle = color;
      pen.lineWidth = tile.line(1.6);
      pen.setLineDash([]);
      pen.beginPath();
      for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
        pen.moveTo(x + dx * inner, y + dy * inner);
        pen.lineTo(x + dx * outer, y + dy * outer);
      }
      pen.stroke();
    });
  },
  Boxes(pen, { box }, tile) {
    pen.strokeStyle = "#ffffff99";
    pen.lineWidth = tile.line(1);
    pen.setLineDash([]);
    for (const [x0, y0, x1, y1] of box) pen.strokeRect(x0, y0, x1 - x0, y1 - y0);
  },
  Poses(pen, { person: number, images, arrows }, tile) {
    images[tile.camera.name]?.forEach((place, i) => place && circle(pen, place, tile, person(number[i]), { width: 1.6 }));
    arrows[tile.camera.name]?.forEach((points, i) => {
      if (!points) return;
      const [head, gaze, chest, front] = points;
      arrow(pen, head, gaze, tile, person(number[i]), 1.6);
      arrow(pen, chest, front, tile, person(number[i]), 2.6);
    });
  },
  ImageTracks(pen, { target, pixel }, tile) {
    pixel.forEach(([x, y], i) => circle(pen, [x, y, tile.line(8)], tile, tile.colors[target[i]] ?? "#fff", { width: 1.6 }));
  },
};
