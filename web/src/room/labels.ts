// Names in the room that would cover each other are lifted above each other.
import { type Object3D, type PerspectiveCamera, Sprite, Vector3 } from "three";

const MOST = 4; // heights of a name that it is lifted by at most

export interface Box {
  x: number; // of its middle
  y: number; // upwards
  width: number;
  height: number;
}

// By how many of its own heights each is lifted, so that it covers none before it.
export function lifts(boxes: Box[]): number[] {
  const placed: Box[] = [];
  return boxes.map((box) => {
    let lift = 0;
    while (lift < MOST && placed.some((other) => covers(other, at(box, lift)))) lift += 1;
    placed.push(at(box, lift));
    return lift;
  });
}

const at = (box: Box, lift: number): Box => ({ ...box, y: box.y + lift * box.height });

const covers = (a: Box, b: Box): boolean =>
  Math.abs(a.x - b.x) < (a.width + b.width) / 2 && Math.abs(a.y - b.y) < 0.7 * ((a.height + b.height) / 2);

// Marks a sprite as a name, of a size that does not depend on its distance.
export function named(sprite: Sprite): Sprite {
  sprite.userData.name = true;
  return sprite;
}

// Arrange the names that are seen; those nearer to the viewer stay where they are.
export function arrange(scene: Object3D, camera: PerspectiveCamera): void {
  const found: { sprite: Sprite; place: Vector3 }[] = [];
  scene.traverseVisible((one) => {
    if (one instanceof Sprite && one.userData.name)
      found.push({ sprite: one, place: one.getWorldPosition(new Vector3()).project(camera) });
  });
  found.sort((a, b) => a.place.z - b.place.z);
  const { elements } = camera.projectionMatrix;
  const boxes = found.map(({ sprite: { scale }, place: { x, y } }) => ({
    ...{ x, y },
    width: scale.x * elements[0],
    height: scale.y * elements[5],
  }));
  lifts(boxes).forEach((lift, i) => {
    found[i].sprite.center.y = 0.5 - lift;
  });
}
