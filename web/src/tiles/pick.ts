// A target by a click or a rectangle in a still picture: what is asked for, and what was learnt in words.
import type { LearntData } from "../messages/messages.ts";
import type { LearnRequest } from "../messages/requests.ts";

type Place = [number, number];
const LARGEST_M = 10; // radius of a target
const CLICK = 4; // px of the screen: what moved less is a click

// The click x, y or the rectangle x, y, width, height, in px of the picture; null outside.
// from and to: where the pointer went down and up, px of the screen from the corner of the shown picture.
export function boxOf(from: Place, to: Place, shown: Place, size: Place): number[] | null {
  const inside = ([x, y]: Place): Place => [
    Math.min(Math.max(Math.floor((x / shown[0]) * size[0]), 0), size[0] - 1),
    Math.min(Math.max(Math.floor((y / shown[1]) * size[1]), 0), size[1] - 1),
  ];
  if (!(shown[0] > 0 && shown[1] > 0)) return null;
  if (Math.hypot(to[0] - from[0], to[1] - from[1]) < CLICK) return inside(from);
  const [[x0, y0], [x1, y1]] = [inside(from), inside(to)];
  return [Math.min(x0, x1), Math.min(y0, y1), Math.abs(x1 - x0) + 1, Math.abs(y1 - y0) + 1];
}

// What to ask the server for, or in one sentence why not yet. known: radius of each target of the room file, m.
export function learnRequestOf(
  name: string,
  radius: string,
  box: number[] | null,
  known: Record<string, number>,
): LearnRequest | string {
  if (!/^[A-Za-z0-9_-]{1,64}$/.test(name))
    return name ? "a name has letters, digits, _ and -" : "name the target";
  const meters = Number(radius.replace(",", "."));
  if (radius && !(meters > 0 && meters <= LARGEST_M)) return `a radius is in metres, at most ${LARGEST_M}`;
  if (!radius && !(name in known)) return `${name} is new: give its radius, half of its width, in metres`;
  if (!box) return "click on the middle of the ball, or drag a rectangle around it";
  return { learn: name, box, radius: radius ? meters : null };
}

// What was learnt, a line each.
export function learntWords(learnt: LearntData): string[] {
  const { name, camera, hue, share, pixels, radius_px, area, radius_m, alike, minimum_saturation } = learnt;
  const colour = `hue ${hue}°, ${Math.round(100 * share)} % of ${pixels} px; ${radius_px} px in radius here`;
  const taken = `taken for it: from ${Math.round(area[0])} to ${Math.round(area[1])} px`;
  const strong = minimum_saturation
    ? `if paler things of its hue are found, skin or wood, set minimum_saturation ${minimum_saturation}`
    : "a pale colour: things of its hue, such as skin or wood, may be taken for it";
  const written = learnt.new
    ? `will be written: a new target ${name}, radius ${radius_m} m, with this colour in ${camera}`
    : `will be written: this colour of ${name} in ${camera}, radius ${radius_m} m; other cameras keep theirs`;
  return [colour, taken, apart(alike), strong, written];
}

function apart(alike: LearntData["alike"]): string {
  if (!alike.length) return "no other target is known to this camera";
  const confused = alike.filter((one) => one.confused).map(({ name }) => name);
  if (confused.length) return `looks like ${confused.join(", ")}: they will be taken for each other`;
  const [{ name, similarity }] = alike;
  return `told apart from all others; most alike is ${name}, ${Math.round(100 * similarity)} %`;
}
