// The bones of all skeletons of a port, as lines in the room.
import { BufferGeometry, Color, Float32BufferAttribute, LineBasicMaterial, LineSegments } from "three";
import type { SkeletonsView } from "../messages/message_views.ts";

const HUES = [205, 28, 140, 275, 52, 330];

export class Bones {
  readonly lines = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ vertexColors: true }));
  heard = 0;

  constructor() {
    this.lines.frustumCulled = false; // they move, and their bounds are not computed
  }

  move({ person, bones }: Pick<SkeletonsView, "person" | "bones">): void {
    this.heard = performance.now();
    const known = bones.map((ends) => ends.flat().every((value) => value !== null));
    const places = bones.filter((_, i) => known[i]).flat(2) as number[];
    const colors = person
      .filter((_, i) => known[i])
      .flatMap((number) => {
        const { r, g, b } = new Color(`hsl(${HUES[number % HUES.length]}, 85%, 66%)`);
        return [r, g, b, r, g, b];
      });
    this.lines.geometry.dispose();
    this.lines.geometry = new BufferGeometry();
    this.lines.geometry.setAttribute("position", new Float32BufferAttribute(places, 3));
    this.lines.geometry.setAttribute("color", new Float32BufferAttribute(colors, 3));
  }
}
