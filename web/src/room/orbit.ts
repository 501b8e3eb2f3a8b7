// Turning around the room with mouse, fingers or keys; z is up.
import { type PerspectiveCamera, Spherical, Vector3 } from "three";

const TURN = 0.006; // rad for each px
const FLAT = 0.84; // half the height of a room as it is seen, over half of its diagonal
const WIDE = 1; // half its width
const KEYS: Record<string, [number, number]> = {
  ArrowLeft: [-0.12, 0],
  ArrowRight: [0.12, 0],
  ArrowUp: [0, -0.08],
  ArrowDown: [0, 0.08],
};

export class Orbit {
  private readonly camera: PerspectiveCamera;
  private readonly moved: () => void;
  private readonly center = new Vector3();
  private readonly place = new Spherical(8, 1.1, 0.7); // theta counts from the x axis here
  private home: { center: Vector3; place: Spherical } | null = null;
  private readonly touches = new Map<number, [number, number]>();

  // moved: called when the view is another.
  constructor(camera: PerspectiveCamera, canvas: HTMLCanvasElement, moved: () => void) {
    this.camera = camera;
    this.moved = moved;
    canvas.addEventListener("pointerdown", (event) => this.down(event, canvas));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", ({ pointerId }) => this.touches.delete(pointerId));
    canvas.addEventListener("pointercancel", ({ pointerId }) => this.touches.delete(pointerId));
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    canvas.addEventListener("keydown", (event) => this.key(event));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  // Look at a box so that all of it is seen. low, high: corners, m.
  show(low: Vector3, high: Vector3): void {
    this.center.addVectors(low, high).multiplyScalar(0.5);
    this.center.z = low.z + 0.3 * (high.z - low.z);
    const radius = high.clone().sub(low).length() / 2;
    const { fov, aspect } = this.camera;
    const [up, across] = [fov, fov * aspect].map((angle) => Math.sin((angle * Math.PI) / 360));
    const distance = Math.max((FLAT * radius) / up, (WIDE * radius) / across);
    this.place.set(distance, 1.13, -0.95);
    this.home = { center: this.center.clone(), place: this.place.clone() };
    this.apply();
  }

  private apply(): void {
    const { radius, phi, theta } = this.place;
    const flat = radius * Math.sin(phi);
    const offset = new Vector3(flat * Math.cos(theta), flat * Math.sin(theta), radius * Math.cos(phi));
    this.camera.position.copy(offset).add(this.center);
    this.camera.lookAt(this.center);
    this.moved();
  }

  private turn(dx: number, dy: number): void {
    this.place.theta -= dx;
    this.place.phi = Math.min(1.56, Math.max(0.02, this.place.phi - dy));
    this.apply();
  }

  private zoom(factor: number): void {
    this.place.radius = Math.min(60, Math.max(0.8, this.place.radius * factor));
    this.apply();
  }

  private pan(dx: number, dy: number): void {
    const step = this.place.radius * 0.0015;
    const right = new Vector3().setFromMatrixColumn(this.camera.matrix, 0).multiplyScalar(-dx * step);
    const up = new Vector3().setFromMatrixColumn(this.camera.matrix, 1).multiplyScalar(dy * step);
    this.center.add(right).add(up);
    this.apply();
  }

  private down(event: PointerEvent, canvas: HTMLCanvasElement): void {
    canvas.setPointerCapture(event.pointerId);
    this.touches.set(event.pointerId, [event.clientX, event.clientY]);
  }

  private move(event: PointerEvent): void {
    const before = this.touches.get(event.pointerId);
    if (!before) return;
    const now: [number, number] = [event.clientX, event.clientY];
    const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    const other = [...this.touches].find(([id]) => id !== event.pointerId)?.[1];
    if (other) {
      const span = (at: [number, number]) => Math.hypot(at[0] - other[0], at[1] - other[1]);
      this.zoom(span(before) / Math.max(1, span(now)));
      this.pan(dx / 2, dy / 2);
    } else if (event.buttons & 2 || event.shiftKey) this.pan(dx, dy);
    else this.turn(dx * TURN, dy * TURN);
    this.touches.set(event.pointerId, now);
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    this.zoom(Math.exp(event.deltaY * 0.001));
  }

  private key(event: KeyboardEvent): void {
    if (KEYS[event.key]) this.turn(...KEYS[event.key]);
    else if (event.key === "+" || event.key === "=") this.zoom(0.9);
    else if (event.key === "-") this.zoom(1.1);
    else if (event.key === "Home" && this.home) {
      this.center.copy(this.home.center);
      this.place.copy(this.home.place);
      this.apply();
    } else return;
    event.preventDefault();
  }
}
