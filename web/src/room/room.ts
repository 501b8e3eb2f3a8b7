// The room in 3D: a dark stage, the cameras above it, and light where the targets are.
import { Color, Fog, HemisphereLight, PerspectiveCamera, Scene, Vector3, WebGLRenderer } from "three";
import type { Tracked } from "../messages/merged_tracks.ts";
import type { PosesView, SkeletonsView } from "../messages/message_views.ts";
import type { RoomData } from "../messages/scene.ts";
import { Bones } from "./bones.ts";
import { freeOf } from "./free_area.ts";
import { arrange } from "./labels.ts";
import { glowTexture } from "./light.ts";
import { Orbit } from "./orbit.ts";
import { Person } from "./person.ts";
import { frustum, grid, patch } from "./scenery.ts";
import { Target } from "./target.ts";

const NIGHT = 0x06080c;
const GONE_MS = 1500; // after which a target without a new place is not shown
const SETTLED_MS = 2000; // after which nothing moves any more

export class Room {
  private readonly stage: HTMLElement;
  private readonly legend: HTMLElement;
  private readonly renderer: WebGLRenderer;
  private readonly camera = new PerspectiveCamera(38, 1, 0.05, 200);
  private readonly orbit: Orbit;
  private readonly texture = glowTexture();
  private readonly scene = new Scene();
  private targets: Target[] = [];
  private readonly people = new Map<string, Person>();
  private readonly skeletons = new Map<string, Bones>(); // by port
  private box: [Vector3, Vector3] | null = null;
  private before = performance.now();
  private stirred = 0; // when something was last new; until it has settled the room is drawn

  // Null where the browser has no WebGL. stage: what the canvas fills; legend: lies over its upper left corner.
  static on(canvas: HTMLCanvasElement, stage: HTMLElement, legend: HTMLElement): Room | null {
    try {
      return new Room(canvas, stage, legend);
    } catch {
      return null;
    }
  }

  private constructor(canvas: HTMLCanvasElement, stage: HTMLElement, legend: HTMLElement) {
    this.stage = stage;
    this.legend = legend;
    this.renderer = new WebGLRenderer({ canvas, antialias: true });
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.camera.up.set(0, 0, 1);
    this.orbit = new Orbit(this.camera, canvas, () => this.stir());
    this.scene.background = new Color(NIGHT);
    new ResizeObserver(() => this.resize()).observe(stage);
    this.resize();
    this.renderer.setAnimationLoop((now) => this.draw(now));
  }

  show(room: RoomData): void {
    const low = new Vector3(...room.low);
    const high = new Vector3(...room.high);
    this.box = [low, high];
    const size = high.clone().sub(low).length();
    this.scene.clear();
    this.scene.fog = new Fog(NIGHT, size * 1.1, size * 3.2);
    this.scene.add(new HemisphereLight(0xffffff, 0x223044, 2.2), grid(low, high));
    this.scene.add(...room.planes.flatMap(patch), ...room.cameras.map(frustum));
    this.targets = room.targets.map((target) => new Target(target, this.texture));
    for (const { group } of this.targets) this.scene.add(group);
    this.people.clear();
    this.skeletons.clear();
    this.resize();
  }

  private stir(): void {
    this.stirred = performance.now();
  }

  tracks({ target, state, xyz, sigma, quaternion, time }: Tracked): void {
    this.stir();
    const known = new Map(target.map((t, i) => [t, i]));
    this.targets.forEach((mark, t) => {
      const i = known.get(t);
      if (i === undefined) mark.lose();
      else mark.move({ xyz: xyz[i], sigma: sigma[i], state: state[i], quaternion: quaternion[i], time });
    });
  }

  poses({ camera, person, xy, height, heading, pan, tilt, sigma, time }: PosesView): void {
    this.stir();
    person.forEach((number, i) => {
      const columns = { height: height[i], heading: heading[i], pan: pan[i], tilt: tilt[i] };
      this.person(`${camera} ${number}`, number).move({ xy: xy[i], ...columns, sigma: sigma[i], time });
    });
  }

  bones(view: SkeletonsView): void {
    this.stir();
    let known = this.skeletons.get(view.port);
    if (!known) {
      known = new Bones();
      this.skeletons.set(view.port, known);
      this.scene.add(known.lines);
    }
    known.move(view);
  }

  private person(name: string, number: number): Person {
    const known = this.people.get(name);
    if (known) return known;
    const mark = new Person(number, this.texture);
    this.people.set(name, mark);
    this.scene.add(mark.group);
    return mark;
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.stage;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    const { offsetLeft, offsetTop, offsetWidth, offsetHeight, childElementCount } = this.legend;
    const corner: [number, number] = childElementCount
      ? [offsetLeft + offsetWidth, offsetTop + offsetHeight]
      : [0, 0];
    const free = freeOf(width, height, ...corner);
    this.camera.aspect = free.width / free.height;
    this.camera.setViewOffset(free.width, free.height, -free.x, -free.y, width, height);
    this.stir();
    if (this.box) this.orbit.show(...this.box);
  }

  private draw(now: number): void {
    const seconds = Math.min(0.1, (now - this.before) / 1000);
    this.before = now;
    if (performance.now() - this.stirred > SETTLED_MS) return;
    for (const target of this.targets) target.step(seconds);
    for (const [name, mark] of this.people) {
      mark.step(seconds);
      if (performance.now() - mark.heard > GONE_MS) {
        this.scene.remove(mark.group);
        this.people.delete(name);
      }
    }
    for (const { lines, heard } of this.skeletons.values())
      lines.visible = performance.now() - heard < GONE_MS;
    arrange(this.scene, this.camera);
    this.renderer.render(this.scene, this.camera);
  }
}
