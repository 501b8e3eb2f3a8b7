// A person: a standing figure, the way the chest points, and the way the face does.
import {
  AdditiveBlending, CapsuleGeometry, Color, ConeGeometry, Group, Mesh, MeshBasicMaterial, MeshLambertMaterial,
  PlaneGeometry, RingGeometry, SphereGeometry, Vector2,
} from "./three.module.min.js";
import { words } from "./light.js";

const HUES = [205, 28, 140, 275, 52, 330];
const FOLLOW = 10; // 1/s
const TALL = 1.75; // m, as the figure is made

export class Person {
  constructor(number, texture) {
    const css = `hsl(${HUES[number % HUES.length]}, 85%, 66%)`;
    const color = new Color(css);
    this.goal = new Vector2();
    this.heading = 0;
    this.heard = 0;
    this.group = new Group();
    this.figure = new Group();
    const cloth = new MeshLambertMaterial({ color, transparent: true, opacity: 0.55 });
    const body = new Mesh(new CapsuleGeometry(0.2, 1.0, 6, 18), cloth);
    body.rotation.x = Math.PI / 2;
    body.position.z = 0.72;
    body.scale.z = 0.75;
    this.head = new Group();
    const skull = new Mesh(new SphereGeometry(0.115, 20, 14), new MeshLambertMaterial({ color }));
    const nose = arrow(color, 0.05, 0.16);
    nose.position.x = 0.17;
    this.head.add(skull, nose);
    this.head.position.z = TALL - 0.115;
    const chest = arrow(color, 0.11, 0.34);
    chest.position.set(0.48, 0, 0.02);
    this.figure.add(body, this.head, chest);
    this.pool = new Mesh(
      new PlaneGeometry(2, 2),
      new MeshBasicMaterial({ map: texture, color, blending: AdditiveBlending, transparent: true, opacity: 0.5, depthWrite: false }),
    );
    this.pool.position.z = 0.01;
    this.cloud = new Mesh(new RingGeometry(0.92, 1, 40), new MeshBasicMaterial({ color, transparent: true, opacity: 0.7 }));
    this.cloud.position.z = 0.015;
    const label = words(`person ${number}`, css, 0.024);
    label.position.z = TALL + 0.2;
    this.group.add(this.figure, this.pool, this.cloud, label);
  }

  move(xy, height, heading, pan, sigma) {
    this.goal.set(...xy);
    if (!this.heard) this.group.position.set(...xy, 0);
    this.heard = performance.now();
    this.heading = heading ?? this.heading;
    this.head.rotation.z = pan ?? 0;
    this.figure.scale.z = (height ?? TALL) / TALL;
    this.cloud.scale.set(sigma[0] ?? 0.01, sigma[1] ?? 0.01, 1);
  }

  step(seconds) {
    const share = 1 - Math.exp(-FOLLOW * seconds);
    this.group.position.x += (this.goal.x - this.group.position.x) * share;
    this.group.position.y += (this.goal.y - this.group.position.y) * share;
    const turn = Math.atan2(Math.sin(this.heading - this.figure.rotation.z), Math.cos(this.heading - this.figure.rotation.z));
    this.figure.rotation.z += turn * share;
  }
}

// Points along x.
function arrow(color, width, length) {
  const mesh = new Mesh(new ConeGeometry(width, length, 18), new MeshBasicMaterial({ color }));
  mesh.rotation.z = -Math.PI / 2;
  return mesh;
}
