// A target: a ball of light in its own colour, its trail, its uncertainty, and its light on the floor.
import {
  AdditiveBlending,
  type BufferGeometry,
  Color,
  Group,
  type Line,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  PlaneGeometry,
  SphereGeometry,
  type Sprite,
  type Texture,
  Vector3,
  WireframeGeometry,
} from "three";
import type { TargetData } from "../messages/scene.ts";
import type { Triple } from "../messages/triple.ts";
import { Axes } from "./axes.ts";
import { glow, words } from "./light.ts";
import { fill, line } from "./trail.ts";

const TRAIL = 75; // places, at 30 a second
const SIGMAS = 2.8; // standard deviations from the ball to the shell around it: 95 % in three dimensions
const FOLLOW = 16; // 1/s: how fast the ball goes to where the track is

export interface Seen {
  xyz: Triple;
  sigma: (number | null)[];
  state: string;
  quaternion: (number | null)[] | undefined;
  time: number; // ms
}

// Half-axes of the shell around a ball, m; null where it is not known how far off the ball may be.
export function shellOf(radius: number, sigma: (number | null)[]): Triple | null {
  const [x, y, z] = sigma.filter((s) => s !== null).map((s) => radius + SIGMAS * s);
  return z === undefined ? null : [x, y, z];
}

export class Target {
  readonly group = new Group();
  private readonly color: Color;
  private readonly radius: number;
  private readonly goal = new Vector3();
  private trail: { xyz: Triple; time: number }[] = [];
  private readonly ball = new Group();
  private readonly halo: Sprite;
  private readonly cloud: LineSegments;
  private readonly axes: Axes;
  private readonly pool: Mesh<PlaneGeometry, MeshBasicMaterial>;
  private readonly tail: Line<BufferGeometry>;
  private readonly drop: Line<BufferGeometry>;

  constructor({ name, color, radius }: TargetData, texture: Texture) {
    this.color = new Color(color);
    this.radius = radius;
    this.group.visible = false;
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
    const shine = { map: texture, color: this.color, blending: AdditiveBlending };
    this.pool = new Mesh(
      new PlaneGeometry(1.5, 1.5),
      new MeshBasicMaterial({ ...shine, transparent: true, opacity: 0.55, depthWrite: false }),
    );
    this.tail = line(TRAIL, { blending: AdditiveBlending, vertexColors: true });
    this.drop = line(2, { color: this.color, opacity: 0.35 });
    this.group.add(this.ball, this.pool, this.tail, this.drop);
  }

  move({ xyz, sigma, state, quaternion, time }: Seen): void {
    this.goal.set(...xyz);
    if (!this.group.visible) this.ball.position.copy(this.goal);
    this.group.visible = true;
    const last = this.trail.at(-1);
    if (last && time < last.time) this.trail = [];
    this.trail.push({ xyz, time });
    if (this.trail.length > TRAIL) this.trail.shift();
    const shell = shellOf(this.radius, sigma);
    this.cloud.visible = shell !== null;
    if (shell) this.cloud.scale.set(...shell);
    this.axes.turn(quaternion);
    this.halo.material.opacity = state === "tracked" ? 1 : 0.35;
  }

  lose(): void {
    this.group.visible = false;
    this.trail = [];
  }

  step(seconds: number): void {
    if (!this.group.visible) return;
    const share = 1 - Math.exp(-FOLLOW * seconds);
    this.ball.position.lerp(this.goal, share);
    this.axes.step(share);
    const { x, y, z } = this.ball.position;
    this.pool.position.set(x, y, 0.01);
    this.pool.material.opacity = 0.6 / (1 + 0.35 * z);
    fill(this.drop, [
      [x, y, z],
      [x, y, 0],
    ]);
    const places: Triple[] = [...this.trail.slice(0, -1).map((at) => at.xyz), [x, y, z]];
    fill(this.tail, places, (i) => this.color.clone().multiplyScalar((i / TRAIL) ** 1.5 * 0.9));
  }
}
