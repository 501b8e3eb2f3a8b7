// A person: a standing figure, the way the chest points, and the way the face does.
import {
  AdditiveBlending, CapsuleGeometry, Color, ConeGeometry, Group, Mesh, MeshBasicMaterial, MeshLambertMaterial,
  PlaneGeometry, RingGeometry, SphereGeometry, Vector2,
} from "./three.module.min.js";
import { words } from "./light.js";
import { fill, line } from "./trail.js";

const HUES = [205, 28, 140, 275, 52, 330];
const FOLLOW = 10; // 1/s
const TRAIL = 120; // places
const LEAP = 1; // m, from one place to the next
const TALL = 1.75; // m, as the figure is made

export class Person {
  constructor(number, texture) {
    const css = `hsl(${HUES[number % HUES.length]}, 85%, 66%)`;
    const color = new Color(css);
    this.goal = new Vector2();
    this.heading = 0;
    this.trail = [];
    this.heard = 0;
    this.group = new Group();
    this.figure = new Group();
    const cloth = new MeshLambertMaterial({ color, transparent: true, opacity: 0.55 });
    const torso = limb(cloth, { radius: 0.19, from: 0.72, to: 1.5, depth: 0.62, width: 1.15 });
    const legs = [-0.1, 0.1].map((y) => limb(cloth, { radius: 0.09, from: 0, to: 0.84, y }));
    this.head = new Group();
    const skull = new Mesh(new SphereGeometry(0.115, 20, 14), new MeshLambertMaterial({ color }));
    const nose = arrow(color, 0.05, 0.16);
    nose.position.x = 0.17;
    this.head.add(skull, nose);
    this.head.position.z = TALL - 0.115;
    const chest = arrow(color, 0.08, 0.34);
    chest.position.set(0.32, 0, 1.3);
    const way = arrow(color, 0.11, 0.3);
    way.position.set(0.5, 0, 0.02);
    way.scale.z = 0.1; // flat on the floor
    this.figure.add(torso, ...legs, this.head, chest, way);
    this.pool = new Mesh(
      new PlaneGeometry(2, 2),
      new MeshBasicMaterial({ map: texture, color, blending: AdditiveBlending, transparent: true, opacity: 0.5, depthWrite: false }),
    );
    this.pool.position.z = 0.01;
    this.cloud = new Mesh(new RingGeometry(0.92, 1, 40), new MeshBasicMaterial({ color, transparent: true, opacity: 0.7 }));
    this.cloud.position.z = 0.015;
    const label = words(`person ${number}`, css, 0.024);
    label.position.z = TALL + 0.2;
    this.walker = new Group(); // what goes along; the trail stays
    this.walker.add(this.figure, this.pool, this.cloud, label);
    this.tail = line(TRAIL, { blending: AdditiveBlending, vertexColors: true });
    this.color = color;
    this.group.add(this.walker, this.tail);
  }

  move({ xy, height, heading, pan, tilt, sigma, time }) {
    this.goal.set(...xy);
    if (!this.heard) this.walker.position.set(...xy, 0);
    this.heard = performance.now();
    this.heading = heading ?? this.heading;
    this.head.rotation.set(0, -(tilt ?? 0), pan ?? 0, "ZYX");
    const before = this.trail.at(-1)?.place ?? [...xy];
    if (Math.hypot(xy[0] - before[0], xy[1] - before[1]) > LEAP) this.trail = []; // found anew elsewhere
    this.trail = this.trail.filter((at) => at.time < time).slice(1 - TRAIL);
    this.trail.push({ place: [...xy, 0.02], time });
    this.figure.scale.z = (height ?? TALL) / TALL;
    this.cloud.scale.set(sigma[0] ?? 0.01, sigma[1] ?? 0.01, 1);
  }

  step(seconds) {
    const share = 1 - Math.exp(-FOLLOW * seconds);
    const place = this.walker.position;
    place.x += (this.goal.x - place.x) * share;
    place.y += (this.goal.y - place.y) * share;
    const places = [...this.trail.slice(0, -1).map((at) => at.place), [place.x, place.y, 0.02]];
    fill(this.tail, places, (i) => this.color.clone().multiplyScalar((i / TRAIL) ** 1.5 * 0.9));
    const turn = Math.atan2(Math.sin(this.heading - this.figure.rotation.z), Math.cos(this.heading - this.figure.rotation.z));
    this.figure.rotation.z += turn * share;
  }
}

// Upright between two heights; depth and width: shares of the radius.
function limb(material, { radius, from, to, y = 0, depth = 1, width = 1 }) {
  const mesh = new Mesh(new CapsuleGeometry(radius, to - from - 2 * radius, 6, 18), material);
  mesh.rotation.x = Math.PI / 2;
  mesh.position.set(0, y, (from + to) / 2);
  mesh.scale.set(depth, 1, width);
  return mesh;
}

// Points along x.
function arrow(color, width, length) {
  const mesh = new Mesh(new ConeGeometry(width, length, 18), new MeshBasicMaterial({ color }));
  mesh.rotation.z = -Math.PI / 2;
  return mesh;
}
