// A target: a ball of light in its own colour, its trail, its uncertainty, and its light on the floor.
import {
  AdditiveBlending, Color, Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, PlaneGeometry,
  SphereGeometry, Vector3, WireframeGeometry,
} from "./three.module.min.js";
import { Axes } from "./axes.js";
import { glow, words } from "./light.js";
import { fill, line } from "./trail.js";

const TRAIL = 75; // places, at 30 a second
const SIGMAS = 2.8; // standard deviations from the ball to the shell around it: 95 % in three dimensions
const FOLLOW = 16; // 1/s: how fast the ball goes to where the track is

export class Target {
  constructor({ name, color, radius }, texture) {
    this.color = new Color(color);
    this.radius = radius;
    this.goal = new Vector3();
    this.trail = [];
    this.group = new Group();
    this.group.visible = false;
    this.ball = new Group();
    const core = new Mesh(new SphereGeometry(radius, 24, 16), new MeshBasicMaterial({ color: this.color }));
    this.halo = glow(texture, this.color, radius * 11);
    this.cloud = new LineSegments(
      new WireframeGeometry(new SphereGeometry(1, 10, 6)),
      new LineBasicMaterial({ color: this.color, transparent: true, opacity: 0.35 }),
    );
    const label = words(name, color, 0.024);
    label.position.z = radius + 0.2;
    this.axes = new Axes(radius);
    this.ball.add(core, this.halo, this.cloud, label, this.axes.group);
    this.pool = new Mesh(
      new PlaneGeometry(1.5, 1.5),
      new MeshBasicMaterial({ map: texture, color: this.color, blending: AdditiveBlending, transparent: true, opacity: 0.55, depthWrite: false }),
    );
    this.tail = line(TRAIL, { blending: AdditiveBlending, vertexColors: true });
    this.drop = line(2, { color: this.color, opacity: 0.35 });
    this.group.add(this.ball, this.pool, this.tail, this.drop);
  }

  move({ xyz, sigma, state, quaternion, time }) {
    this.goal.set(...xyz);
    if (!this.group.visible) this.ball.position.copy(this.goal);
    this.group.visible = true;
    if (this.trail.length && time < this.trail.at(-1).time) this.trail = [];
    this.trail.push({ xyz, time });
    if (this.trail.length > TRAIL) this.trail.shift();
    this.cloud.visible = sigma.every((s) => s !== null); // none, where it is not known how far off it may be
    if (this.cloud.visible) this.cloud.scale.set(...sigma.map((s) => this.radius + SIGMAS * s));
    this.axes.turn(quaternion);
    this.halo.material.opacity = state === "tracked" ? 1 : 0.35;
  }

  lose() {
    this.group.visible = false;
    this.trail = [];
  }

  step(seconds) {
    if (!this.group.visible) return;
    const share = 1 - Math.exp(-FOLLOW * seconds);
    this.ball.position.lerp(this.goal, share);
    this.axes.step(share);
    const { x, y, z } = this.ball.position;
    this.pool.position.set(x, y, 0.01);
    this.pool.material.opacity = 0.6 / (1 + 0.35 * z);
    fill(this.drop, [[x, y, z], [x, y, 0]]);
    const places = [...this.trail.slice(0, -1).map((at) => at.xyz), [x, y, z]];
    fill(this.tail, places, (i) => this.color.clone().multiplyScalar((i / TRAIL) ** 1.5 * 0.9));
  }
}
