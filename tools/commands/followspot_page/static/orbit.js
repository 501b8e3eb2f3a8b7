// Turning around the room with mouse, fingers or keys; z is up.
import { Spherical, Vector3 } from "./three.module.min.js";

const TURN = 0.006; // rad for each px
const KEYS = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.08], ArrowDown: [0, 0.08] };

export class Orbit {
  constructor(camera, canvas) {
    this.camera = camera;
    this.center = new Vector3();
    this.place = new Spherical(8, 1.1, 0.7); // theta counts from the x axis here
    this.home = null;
    this.touches = new Map();
    canvas.addEventListener("pointerdown", (event) => this.down(event, canvas));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", ({ pointerId }) => this.touches.delete(pointerId));
    canvas.addEventListener("pointercancel", ({ pointerId }) => this.touches.delete(pointerId));
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    canvas.addEventListener("keydown", (event) => this.key(event));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  // Look at a box so that all of it is seen. low, high: corners, m.
  show(low, high) {
    this.center.addVectors(low, high).multiplyScalar(0.5);
    this.center.z = low.z + 0.3 * (high.z - low.z);
    const radius = high.clone().sub(low).length() / 2;
    const angle = Math.min(this.camera.fov, this.camera.fov * this.camera.aspect) * (Math.PI / 360);
    this.place.set((0.84 * radius) / Math.sin(angle), 1.13, -0.95);
    this.home = [this.center.clone(), this.place.clone()];
    this.apply();
  }

  apply() {
    const { radius, phi, theta } = this.place;
    const flat = radius * Math.sin(phi);
    this.camera.position.set(flat * Math.cos(theta), flat * Math.sin(theta), radius * Math.cos(phi)).add(this.center);
    this.camera.lookAt(this.center);
  }

  turn(dx, dy) {
    this.place.theta -= dx;
    this.place.phi = Math.min(1.56, Math.max(0.02, this.place.phi - dy));
    this.apply();
  }

  zoom(factor) {
    this.place.radius = Math.min(60, Math.max(0.8, this.place.radius * factor));
    this.apply();
  }

  pan(dx, dy) {
    const step = this.place.radius * 0.0015;
    const right = new Vector3().setFromMatrixColumn(this.camera.matrix, 0).multiplyScalar(-dx * step);
    const up = new Vector3().setFromMatrixColumn(this.camera.matrix, 1).multiplyScalar(dy * step);
    this.center.add(right).add(up);
    this.apply();
  }

  down(event, canvas) {
    canvas.setPointerCapture(event.pointerId);
    this.touches.set(event.pointerId, [event.clientX, event.clientY]);
  }

  move(event) {
    const before = this.touches.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY];
    const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    if (this.touches.size === 1) {
      if (event.buttons & 2 || event.shiftKey) this.pan(dx, dy);
      else this.turn(dx * TURN, dy * TURN);
    } else {
      const [other] = [...this.touches].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      const span = (at) => Math.hypot(at[0] - other[0], at[1] - other[1]);
      this.zoom(span(before) / Math.max(1, span(now)));
      this.pan(dx / 2, dy / 2);
    }
    this.touches.set(event.pointerId, now);
  }

  wheel(event) {
    event.preventDefault();
    this.zoom(Math.exp(event.deltaY * 0.001));
  }

  key(event) {
    if (KEYS[event.key]) this.turn(...KEYS[event.key]);
    else if (event.key === "+" || event.key === "=") this.zoom(0.9);
    else if (event.key === "-") this.zoom(1.1);
    else if (event.key === "Home" && this.home) {
      this.center.copy(this.home[0]);
      this.place.copy(this.home[1]);
      this.apply();
    } else return;
    event.preventDefault();
  }
}
