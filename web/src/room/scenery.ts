// What of the room stands still: its floor, its planes, and its cameras.
import {
  BufferGeometry,
  DoubleSide,
  Float32BufferAttribute,
  Group,
  LineBasicMaterial,
  LineLoop,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  type Object3D,
  Vector3,
} from "three";
import type { CameraData, PlaneData } from "../messages/scene.ts";
import type { Triple } from "../messages/triple.ts";
import { words } from "./light.ts";

const FRUSTUM = 0.55; // m, as long as a camera is drawn
const AROUND = Array.from({ length: 24 }, (_, i): Triple => {
  const angle = (i * Math.PI) / 12;
  return [Math.cos(angle) / 3, Math.sin(angle) / 3, 0];
});

function lines(points: Triple[], color: number, opacity: number): LineSegments {
  const position = new Float32BufferAttribute(points.flat(), 3);
  const geometry = new BufferGeometry().setAttribute("position", position);
  return new LineSegments(geometry, new LineBasicMaterial({ color, transparent: true, opacity }));
}

// The floor, a line each half metre and a brighter one each metre.
export function grid(low: Vector3, high: Vector3): Group {
  const fine: Triple[] = [];
  const whole: Triple[] = [];
  const rule = (from: number, to: number, at: (along: number) => Triple[]) => {
    for (let i = Math.ceil(from * 2); i <= Math.floor(to * 2); i++) (i % 2 ? fine : whole).push(...at(i / 2));
  };
  rule(low.x, high.x, (x) => [
    [x, low.y, 0],
    [x, high.y, 0],
  ]);
  rule(low.y, high.y, (y) => [
    [low.x, y, 0],
    [high.x, y, 0],
  ]);
  return new Group().add(lines(fine, 0x2a3a52, 0.35), lines(whole, 0x3d5474, 0.6));
}

// Nothing for a plane that does not meet the room.
export function patch({ corners }: PlaneData): Object3D[] {
  if (corners.length < 3) return [];
  const points = corners.map((corner) => new Vector3(...corner));
  const rim = new LineBasicMaterial({ color: 0x42597a, transparent: true, opacity: 0.5 });
  const edge = new LineLoop(new BufferGeometry().setFromPoints(points), rim);
  const index = corners.slice(2).flatMap((_, i) => [0, i + 1, i + 2]);
  const geometry = new BufferGeometry().setFromPoints(points).setIndex(index);
  const glass = { color: 0x3a5478, transparent: true, opacity: 0.07 };
  const sheet = new Mesh(geometry, new MeshBasicMaterial({ ...glass, side: DoubleSide, depthWrite: false }));
  return [edge, sheet];
}

export function frustum({ name, kind, center, rays }: CameraData): Group {
  const color = kind === "infrared" ? 0xc46a6a : 0x9fb4cf;
  const tip = new Vector3(...center);
  const corners = (rays.length ? rays : AROUND).map((ray): Triple => {
    const { x, y, z } = new Vector3(...ray).multiplyScalar(FRUSTUM).add(tip);
    return [x, y, z];
  });
  const edges = rays.length ? corners.flatMap((corner) => [center, corner]) : [];
  const sides = corners.flatMap((corner, i) => [corner, corners[(i + 1) % corners.length]]);
  const label = words(name, kind === "infrared" ? "#c98080" : "#a9bbd3", 0.018);
  label.position.copy(tip).z += 0.18;
  return new Group().add(lines([...edges, ...sides], color, 0.9), label);
}
