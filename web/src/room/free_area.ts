// The part of the stage that nothing lies over, in which the room is shown.
export interface Area {
  x: number; // px, from the left
  y: number; // from the top
  width: number;
  height: number;
}

// Beside what lies in the upper left corner, or below it, where the room is larger.
export function freeOf(width: number, height: number, right: number, bottom: number): Area {
  const beside = { x: right, y: 0, width: width - right, height };
  const below = { x: 0, y: bottom, width, height: height - bottom };
  const size = (area: Area) => Math.min(area.width, area.height);
  const best = size(beside) >= size(below) ? beside : below;
  return size(best) > 0 ? best : { x: 0, y: 0, width, height };
}
