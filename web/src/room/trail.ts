// A line through places, for trails: as long as there are places, and each with a colour of its own.
import {
  BufferGeometry,
  type Color,
  Float32BufferAttribute,
  Line,
  LineBasicMaterial,
  type LineBasicMaterialParameters,
} from "three";
import type { Triple } from "../messages/triple.ts";

export function line(count: number, look: LineBasicMaterialParameters): Line<BufferGeometry> {
  const geometry = new BufferGeometry().setAttribute("position", new Float32BufferAttribute(3 * count, 3));
  if (look.vertexColors) geometry.setAttribute("color", new Float32BufferAttribute(3 * count, 3));
  const made = new Line(geometry, new LineBasicMaterial({ transparent: true, depthWrite: false, ...look }));
  made.frustumCulled = false;
  return made;
}

// colorAt: of the place with this number, counted from the oldest that there could be.
export function fill(
  { geometry }: Line<BufferGeometry>,
  places: Triple[],
  colorAt?: (i: number) => Color,
): void {
  const { position, color } = geometry.attributes;
  const from = position.count - places.length;
  places.forEach((place, i) => {
    position.setXYZ(i, ...place);
    if (color && colorAt) {
      const shade = colorAt(from + i);
      color.setXYZ(i, shade.r, shade.g, shade.b);
    }
  });
  position.needsUpdate = true;
  if (color) color.needsUpdate = true;
  geometry.setDrawRange(0, places.length);
}
