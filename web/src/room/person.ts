// A person: a standing figure, the way the chest points, and the way the face does.
import {
  AdditiveBlending,
  type BufferGeometry,
  CapsuleGeometry,
  Color,
  ConeGeometry,
  Group,
  type Line,
  type Material,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  PlaneGeometry,
  RingGeometry,
  SphereGeometry,
  type Texture,
  Vector2,
} from "three";
import type { Triple } from "../messages/triple.ts";
import { words } from "./light.ts";
import { fill, line } from "./trail.ts";

const HUES = [205, 28, 140, 275, 52, 330];
const FOLLOW = 10; // 1/s
const TRAIL = 120; // places
const LEAP = 1; // m, from one place to the next
const TALL = 1.75; // m, as the figure is made

export interface Stance {
  xy: [number, number];
  height: number | null;
  heading: number | null;
  pan: number | null;
  tilt: number | null;
  sigma: (number | null)[];
  time: number; // ms
}

export class Person {
  readonly group = new Group();
  heard = 0;
  private readonly color: Color;
  private readonly goal = new Vector2();
  private heading = 0;
  private trail: { place: Triple; time: number }[] = [];
  private readonly figure = new Group();
  private readonly head: Group;
  private readonly cloud: Mesh;
  private readonly walker = new Group(); // what goes along; the trail stays
  private readonly tail: Line<BufferGeometry>;

  constructor(number: number, texture: Texture) {
    const css = `hsl(${HUES[number % HUES.length]}, 85%, 66%)`;
    const color = new Color(css);
    this.color = color;
    this.head = headOf(color);
    const chest = arrow(color, 0.08, 0.34);
    chest.position.set(0.32, 0, 1.3);
    const way = arrow(color, 0.11, 0.3);
    way.position.set(0.5, 0, 0.02);
    way.scale.z = 0.1; // flat on the floor
    this.figure.add(...bodyOf(color), this.head, chest, way);
    const shine = { map: texture, color, blending: AdditiveBlending };
    const pool = new Mesh(
      new PlaneGeometry(2, 2),
      new MeshBasicMaterial({ ...shine, transparent: true, opacity: 0.5, depthWrite: false }),
    );
    pool.position.z = 0.01;
    const faint = new MeshBasicMaterial({ color, transparent: true, opacity: 0.7 });
    this.cloud = new Mesh(new RingGeometry(0.92, 1, 40), faint);
    this.cloud.position.z = 0.015;
    const label = words(`person ${number}`, css, 0.024);
    label.position.z = TALL + 0.2;
    this.walker.add(this.figure, pool, this.cloud, label);
    this.tail = line(TRAIL, { blending: AdditiveBlending, vertexColors: true });
    this.group.add(this.walker, this.tail);
  }

  move({ xy, height, heading, pan, tilt, sigma, time }: Stance): void {
    this.goal.set(...xy);
    if (!this.heard) this.walker.position.set(...xy, 0);
    this.heard = performance.now();
    this.heading = heading ?? this.heading;
    this.head.rotation.set(0, -(tilt ?? 0), pan ?? 0, "ZYX");
    const [x, y] = this.trail.at(-1)?.place ?? xy;
    if (Math.hypot(xy[0] - x, xy[1] - y) > LEAP) this.trail = []; // found anew elsewhere
    this.trail = this.trail.filter((at) => at.time < time).slice(1 - TRAIL);
    this.trail.push({ place: [...xy, 0.02], time });
    this.figure.scale.z = (height ?? TALL) / TALL;
    this.cloud.scale.set(sigma[0] ?? 0.01, sigma[1] ?? 0.01, 1);
  }

  step(seconds: number): void {
    const share = 1 - Math.exp(-FOLLOW * seconds);
    const place = this.walker.position;
    place.x += (this.goal.x - place.x) * share;
    place.y += (this.goal.y - place.y) * share;
    const past = this.trail.slice(0, -1).map((at) => at.place);
    fill(this.tail, [...past, [place.x, place.y, 0.02]], (i) =>
      this.color.clone().multiplyScalar((i / TRAIL) ** 1.5 * 0.9),
    );
    const off = this.heading - this.figure.rotation.z;
    this.figure.rotation.z += Math.atan2(Math.sin(off), Math.cos(off)) * share;
  }
}

function headOf(color: Color): Group {
  const head = new Group();
  const skull = new Mesh(new SphereGeometry(0.115, 20, 14), new MeshLambertMaterial({ color }));
  const nose = arrow(color, 0.05, 0.16);
  nose.position.x = 0.17;
  head.add(skull, nose);
  head.position.z = TALL - 0.115;
  return head;
}

function bodyOf(color: Color): Mesh[] {
  const cloth = new MeshLambertMaterial({ color, transparent: true, opacity: 0.55 });
  const torso = limb(cloth, { radius: 0.19, from: 0.72, to: 1.5, depth: 0.62, width: 1.15 });
  const legs = [-0.1, 0.1].map((y) => limb(cloth, { radius: 0.09, from: 0, to: 0.84, y }));
  return [torso, ...legs];
}

interface Limb {
  radius: number;
  from: number;
  to: number;
  y?: number;
  depth?: number;
  width?: number;
}

// Upright between two heights; depth and width: shares of the radius.
function limb(material: Material, { radius, from, to, y = 0, depth = 1, width = 1 }: Limb): Mesh {
  const mesh = new Mesh(new CapsuleGeometry(radius, to - from - 2 * radius, 6, 18), material);
  mesh.rotation.x = Math.PI / 2;
  mesh.position.set(0, y, (from + to) / 2);
  mesh.scale.set(depth, 1, width);
  return mesh;
}

// Points along x.
function arrow(color: Color, width: number, length: number): Mesh {
  const mesh = new Mesh(new ConeGeometry(width, length, 18), new MeshBasicMaterial({ color }));
  mesh.rotation.z = -Math.PI / 2;
  return mesh;
}
