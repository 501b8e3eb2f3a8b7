// The room in 3D: a dark stage, the cameras above it, and light where the targets are.
import {
  BufferGeometry, Color, DoubleSide, Float32BufferAttribute, Fog, Group, HemisphereLight, LineBasicMaterial,
  LineLoop, LineSegments, Mesh, MeshBasicMaterial, PerspectiveCamera, Scene, Vector3, WebGLRenderer,
} from "./three.module.min.js";
import { glowTexture, words } from "./light.js";
import { Orbit } from "./orbit.js";
import { Person } from "./person.js";
import { Target } from "./target.js";

const around = Array.from({ length: 24 }, (_, i) => [Math.cos((i * Math.PI) / 12) / 3, Math.sin((i * Math.PI) / 12) / 3, 0]);
const NIGHT = 0x06080c;
const FRUSTUM = 0.55; // m, as long as a camera is drawn
const GONE_MS = 1500; // after which who was not told of is not shown

export class Room {
  // Null where the browser has no WebGL.
  static on(canvas) {
    try {
      return new Room(canvas);
    } catch {
      return null;
    }
  }

  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, antialias: true });
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.camera = new PerspectiveCamera(38, 1, 0.05, 200);
    this.camera.up.set(0, 0, 1);
    this.orbit = new Orbit(this.camera, canvas);
    this.texture = glowTexture();
    this.scene = new Scene();
    this.scene.background = new Color(NIGHT);
    this.targets = [];
    this.people = new Map();
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
    this.before = performance.now();
    this.renderer.setAnimationLoop((now) => this.draw(now));
  }

  show(room) {
    const low = new Vector3(...room.low);
    const high = new Vector3(...room.high);
    this.box = [low, high];
    const size = high.clone().sub(low).length();
    this.scene.clear();
    this.scene.fog = new Fog(NIGHT, size * 1.1, size * 3.2);
    this.scene.add(new HemisphereLight(0xffffff, 0x223044, 2.2), grid(low, high));
    for (const plane of room.planes) this.scene.add(...patch(plane));
    for (const camera of room.cameras) this.scene.add(frustum(camera));
    this.targets = room.targets.map((target) => new Target(target, this.texture));
    this.targets.forEach((target) => this.scene.add(target.group));
    this.people.clear();
    this.orbit.show(low, high);
  }

  tracks({ target, state, xyz, sigma, quaternion, time }) {
    const known = new Map(target.map((t, i) => [t, i]));
    this.targets.forEach((mark, t) => {
      const i = known.get(t);
      if (i === undefined) mark.lose();
      else mark.move({ xyz: xyz[i], sigma: sigma[i], state: state[i], quaternion: quaternion[i], time });
    });
  }

  poses({ camera, person, xy, height, heading, pan, tilt, sigma, time }) {
    person.forEach((number, i) => {
      const name = `${camera} ${number}`;
      if (!this.people.has(name)) {
        const mark = new Person(number, this.texture);
        this.people.set(name, mark);
        this.scene.add(mark.group);
      }
      this.people.get(name).move({ xy: xy[i], height: height[i], heading: heading[i], pan: pan[i], tilt: tilt[i], sigma: sigma[i], time });
    });
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (this.box) this.orbit.show(...this.box);
  }

  draw(now) {
    const seconds = Math.min(0.1, (now - this.before) / 1000);
    this.before = now;
    for (const target of this.targets) target.step(seconds);
    for (const [name, mark] of this.people) {
      mark.step(seconds);
      if (performance.now() - mark.heard > GONE_MS) {
        this.scene.remove(mark.group);
        this.people.delete(name);
      }
    }
    this.renderer.render(this.scene, this.camera);
  }
}

function lines(points, color, opacity) {
  const geometry = new BufferGeometry().setAttribute("position", new Float32BufferAttribute(points.flat(), 3));
  return new LineSegments(geometry, new LineBasicMaterial({ color, transparent: true, opacity }));
}

// The floor, a line each half metre and a brighter one each metre.
function grid(low, high) {
  const [fine, whole] = [[], []];
  const rule = (from, to, at) => {
    for (let i = Math.ceil(from * 2); i <= Math.floor(to * 2); i++) (i % 2 ? fine : whole).push(...at(i / 2));
  };
  rule(low.x, high.x, (x) => [[x, low.y, 0], [x, high.y, 0]]);
  rule(low.y, high.y, (y) => [[low.x, y, 0], [high.x, y, 0]]);
  const group = new Group();
  group.add(lines(fine, 0x2a3a52, 0.35), lines(whole, 0x3d5474, 0.6));
  return group;
}

function patch({ corners }) {
  if (corners.length < 3) return [];
  const points = corners.map((corner) => new Vector3(...corner));
  const edge = new LineLoop(new BufferGeometry().setFromPoints(points), new LineBasicMaterial({ color: 0x42597a, transparent: true, opacity: 0.5 }));
  const index = corners.slice(2).flatMap((_, i) => [0, i + 1, i + 2]);
  const geometry = new BufferGeometry().setFromPoints(points).setIndex(index);
  const sheet = new Mesh(geometry, new MeshBasicMaterial({ color: 0x3a5478, transparent: true, opacity: 0.07, side: DoubleSide, depthWrite: false }));
  return [edge, sheet];
}

function frustum({ name, kind, center, rays }) {
  const color = kind === "infrared" ? 0xc46a6a : 0x9fb4cf;
  const tip = new Vector3(...center);
  if (!rays.length) rays = around; // it looks all around
  const corners = rays.map((ray) => new Vector3(...ray).multiplyScalar(FRUSTUM).add(tip).toArray());
  const edges = corners.length > 4 ? [] : corners.flatMap((corner) => [tip.toArray(), corner]);
  const sides = [...edges, ...corners.flatMap((corner, i) => [corner, corners[(i + 1) % corners.length]])];
  const group = new Group();
  const label = words(name, kind === "infrared" ? "#c98080" : "#a9bbd3", 0.018);
  label.position.copy(tip).z += 0.18;
  group.add(lines(sides, color, 0.9), label);
  return group;
}
