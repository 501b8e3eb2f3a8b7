// Ways of lines between boxes, so that none passes behind a box. u runs with the graph, v across it; px.
//
// A line leaves its box at the far end of u and enters the next at the near end. One that would meet a box on
// its way runs in a lane before all boxes (smaller v), one that leads back in a lane behind them. Lines with
// the same destination share a lane before, those from the same box a lane behind.
export interface Box {
  u0: number;
  u1: number;
  v0: number;
  v1: number;
}
export type Place = [u: number, v: number];

export interface Route {
  from: string;
  to: string;
  corners: Place[]; // two of a line that goes straight over, else six
  label: Place;
  stack: number; // how many labels stand there already
}

export interface Routed {
  routes: Route[];
  before: number; // room that the lanes take, on either side
  behind: number;
}

interface Way {
  from: string;
  to: string;
  start: Box;
  end: Box;
  lane: string; // "" of one that goes straight over
  u: number; // of its label
  stack: number;
}

const LANE = 15; // between two lanes, and two labels of one
const PORT = 9; // from the middle of a box to where lines of lanes begin and end
const TURN = 9; // from a box to where such a line turns
const BESIDE = 6; // from where a line that leads back turns to its label
const CLEAR = 18; // from the boxes to the first lane
const BEHIND = "behind ";

export function routed(boxes: Map<string, Box>, links: { from: string; to: string }[]): Routed {
  const all = [...boxes.values()];
  const near = Math.min(...all.map(({ v0 }) => v0));
  const far = Math.max(...all.map(({ v1 }) => v1));
  const ways = stacked(links.flatMap((link) => wayOf(link, boxes)));
  const [before, behind] = [false, true].map((side) =>
    offsets(ways.filter(({ lane }) => lane && lane.startsWith(BEHIND) === side)),
  );
  const routes = ways.map((way): Route => {
    const { from, to, lane, u, stack } = way;
    if (!lane) {
      const corners = straight(way);
      const [[u0, v0], [u1, v1]] = corners;
      return { from, to, corners, label: [(u0 + u1) / 2, (v0 + v1) / 2], stack };
    }
    const back = lane.startsWith(BEHIND);
    const v = back ? far + (behind.at.get(lane) ?? 0) : near - (before.at.get(lane) ?? 0);
    const label: Place = [u, v + (back ? 1 : -1) * LANE * stack];
    return { from, to, corners: around(way, v, back ? PORT : -PORT), label, stack };
  });
  return { routes, before: before.room, behind: behind.room };
}

function wayOf({ from, to }: { from: string; to: string }, boxes: Map<string, Box>): Way[] {
  const [start, end] = [boxes.get(from), boxes.get(to)];
  if (!start || !end) return [];
  const forward = end.u0 >= start.u1;
  const met = [...boxes.values()].some((box) => box !== start && box !== end && meets(box, start, end));
  if (forward && !met) return [{ from, to, start, end, lane: "", u: 0, stack: 0 }];
  const lane = forward ? `before ${to}` : BEHIND + from;
  const u = forward ? (start.u1 + end.u0) / 2 : end.u0 - TURN + BESIDE;
  return [{ from, to, start, end, lane, u, stack: 0 }];
}

// Tells each of several labels at one place how many stand there already.
function stacked(ways: Way[]): Way[] {
  const taken = new Map<string, number>();
  return ways.map((way) => {
    const place = way.lane ? `${way.lane} ${Math.round(way.u)}` : `${way.from} ${way.to}`;
    const stack = taken.get(place) ?? 0;
    taken.set(place, stack + 1);
    return { ...way, stack };
  });
}

// How far from the boxes each lane of one side is, with room for its labels.
function offsets(ways: Way[]): { at: Map<string, number>; room: number } {
  const depths = new Map<string, number>();
  for (const { lane, stack } of ways) depths.set(lane, Math.max(depths.get(lane) ?? 0, stack + 1));
  const at = new Map<string, number>();
  let room = ways.length ? CLEAR : 0;
  for (const [lane, depth] of depths) {
    at.set(lane, room);
    room += LANE * depth;
  }
  return { at, room };
}

function straight({ start, end }: Way): Place[] {
  return [
    [start.u1, middle(start)],
    [end.u0, middle(end)],
  ];
}

function around({ start, end }: Way, v: number, port: number): Place[] {
  const [out, into] = [start.u1 + TURN, end.u0 - TURN];
  return [
    [start.u1, middle(start) + port],
    [out, middle(start) + port],
    [out, v],
    [into, v],
    [into, middle(end) + port],
    [end.u0, middle(end) + port],
  ];
}

// Whether a box lies on the straight way between two others.
function meets(box: Box, start: Box, end: Box): boolean {
  if (box.u1 <= start.u1 || box.u0 >= end.u0) return false;
  const [low, high] = [Math.min(middle(start), middle(end)), Math.max(middle(start), middle(end))];
  return box.v0 < high + 1 && box.v1 > low - 1;
}

const middle = ({ v0, v1 }: Box): number => (v0 + v1) / 2;
