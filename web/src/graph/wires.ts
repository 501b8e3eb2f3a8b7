// The lines between the cards of a graph, with what each carries.
import { type Link, labelOf } from "./links.ts";
import { type Box, type Place, type Route, routed } from "./routes.ts";

const SVG = "http://www.w3.org/2000/svg";
const BEND = 7; // px, radius of a turn
const LINE = 15; // px from a line of text to the next
const TIGHT = 12; // the same, where there is little room

export class Wires {
  private readonly area: HTMLElement;
  private readonly list: HTMLElement;
  private readonly sheet = document.createElementNS(SVG, "svg");

  // area: holds the list of cards, with room for lanes.
  constructor(area: HTMLElement, list: HTMLElement) {
    this.area = area;
    this.list = list;
    this.sheet.setAttribute("aria-hidden", "true");
    area.prepend(this.sheet);
  }

  // cards: those that are seen; upright: whether the graph runs downwards.
  draw(cards: Map<string, HTMLElement>, links: Link[], upright: boolean): void {
    const origin = this.list.getBoundingClientRect();
    const boxes = new Map([...cards].map(([name, card]) => [name, boxOf(card, origin, upright)]));
    const known = links.filter(({ from, to }) => boxes.has(from) && boxes.has(to));
    const { routes, before, behind } = routed(boxes, known);
    this.area.style.setProperty("--before", `${before}px`);
    this.area.style.setProperty("--behind", `${behind}px`);
    this.sheet.replaceChildren(
      ...routes.map((route, i) => wire(known[i], route, upright ? origin.width / 2 : null)),
    );
  }
}

function boxOf(card: HTMLElement, origin: DOMRect, upright: boolean): Box {
  const { left, right, top, bottom } = card.getBoundingClientRect();
  const across = {
    u0: left - origin.left,
    u1: right - origin.left,
    v0: top - origin.top,
    v1: bottom - origin.top,
  };
  return upright ? { u0: across.v0, u1: across.v1, v0: across.u0, v1: across.u1 } : across;
}

// center: of the drawing, where the graph runs downwards.
function wire(link: Link, route: Route, center: number | null): SVGElement {
  const upright = center !== null;
  const place = ([u, v]: Place): [number, number] => (upright ? [v, u] : [u, v]);
  const { loss, old } = labelOf(link);
  const group = element("g", { class: `wire ${link.kind}${old ? " old" : ""}${loss ? " lossy" : ""}` });
  const { corners } = route;
  const path = corners.length === 2 ? straight(corners, upright) : bent(corners.map(place));
  const [x, y] = place(corners[corners.length - 1]);
  const title = element("title", {});
  title.textContent = `${link.from} → ${link.to} · ${link.kind}${link.delay ? ", to a later frame" : ""}`;
  group.append(
    title,
    element("path", { d: path, ...(link.delay ? { "stroke-dasharray": "5 4" } : {}) }),
    element("circle", { cx: `${x}`, cy: `${y}`, r: "3" }),
    ...(upright ? besideOf(link, route, center) : aboveOf(link, route)),
  );
  return group;
}

// Rate and age above and below a line that goes straight over, or above a lane.
function aboveOf(link: Link, { corners, label: [x, y], stack }: Route): SVGElement[] {
  const { rate, age, loss } = labelOf(link);
  if (corners.length > 2) {
    const back = corners[2][0] > corners[3][0];
    return [words(x, y - 4, back ? "start" : "middle", join(rate, age), loss)];
  }
  const top = y - 4 + 3 * LINE * stack;
  return [
    words(x, top, "middle", rate),
    words(x, top + LINE, "middle", age),
    words(x, top + 2 * LINE, "middle", "", loss),
  ];
}

// On the outer side of a line that goes straight down, or where one of a lane turns to its end.
function besideOf(link: Link, { corners, stack }: Route, center: number): SVGElement[] {
  const { rate, age, loss } = labelOf(link);
  const text = join(rate, age);
  const [[u0, v0], [, v1]] = corners;
  if (corners.length === 2) {
    const left = (v0 + v1) / 2 < center - 1;
    const x = (v0 + v1) / 2 + (left ? -5 : 5);
    return [words(x, u0 + 18 + TIGHT * stack, left ? "end" : "start", text, loss)];
  }
  const [turn, lane] = corners[3];
  const behind = lane > corners[5][1];
  const y = turn - 4 - TIGHT * stack;
  return [words(behind ? lane - 5 : lane + 5, y, behind ? "end" : "start", text, loss)];
}

const join = (...texts: string[]): string => texts.filter(Boolean).join(" ");

function words(x: number, y: number, anchor: string, text: string, loss = ""): SVGElement {
  const made = element("text", { x: `${x}`, y: `${y}`, "text-anchor": anchor });
  made.textContent = loss && text ? `${text} ` : text;
  if (loss) {
    const lost = element("tspan", { class: "loss" });
    lost.textContent = loss;
    made.append(lost);
  }
  return made;
}

// A curve that leaves and enters with the flow.
function straight(corners: Place[], upright: boolean): string {
  const [[u0, v0], [u1, v1]] = corners;
  const half = (u0 + u1) / 2;
  const at = (u: number, v: number) => (upright ? `${v},${u}` : `${u},${v}`);
  return `M${at(u0, v0)} C${at(half, v0)} ${at(half, v1)} ${at(u1, v1)}`;
}

// Through corners, with bends.
function bent(corners: [number, number][]): string {
  const words = [`M${corners[0]}`];
  for (let i = 1; i < corners.length - 1; i++) {
    const [before, here, after] = corners.slice(i - 1, i + 2);
    words.push(`L${towards(here, before)} Q${here} ${towards(here, after)}`);
  }
  return `${words.join(" ")} L${corners[corners.length - 1]}`;
}

// A bend's length from here, or half of the way.
function towards([x0, y0]: [number, number], [x1, y1]: [number, number]): [number, number] {
  const share = Math.min(0.5, BEND / Math.max(Math.abs(x1 - x0) + Math.abs(y1 - y0), 1e-9));
  return [x0 + share * (x1 - x0), y0 + share * (y1 - y0)];
}

function element(tag: string, attributes: Record<string, string>): SVGElement {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}
