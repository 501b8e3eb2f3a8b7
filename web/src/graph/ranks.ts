// Where the cards of a graph stand: how many steps each is from a source, and which of those beside it.
export interface Standing {
  rank: number; // steps from a source
  row: number; // among those of the same rank
}

// Where a card stands in a graph that runs downwards.
export interface Step {
  step: number;
  column: number;
  alone: boolean; // whether no other stands at its step
}

// names: of cards, in the order of the plan; links: between them. Links against this order lead back and do not count.
export function standings(names: string[], links: [string, string][]): Map<string, Standing> {
  const order = new Map(names.map((name, i) => [name, i]));
  const senders = new Map<string, string[]>(names.map((name) => [name, []]));
  for (const [from, to] of links) {
    const [first, second] = [order.get(from), order.get(to)];
    if (first !== undefined && second !== undefined && first < second) senders.get(to)?.push(from);
  }
  const found = new Map<string, Standing>();
  const filled: number[] = []; // how many stand in each rank
  for (const name of names) {
    const before = (senders.get(name) ?? []).map((from) => found.get(from)?.rank ?? 0);
    const rank = before.length ? 1 + Math.max(...before) : 0;
    filled[rank] ??= 0;
    found.set(name, { rank, row: filled[rank]++ });
  }
  return found;
}

// A step for each rank, and one for each card that is wide.
export function steps(found: Map<string, Standing>, wide: Set<string>): Map<string, Step> {
  const last = Math.max(-1, ...[...found.values()].map(({ rank }) => rank));
  const made = new Map<string, Step>();
  let step = 0;
  for (let rank = 0; rank <= last; rank++) {
    const here = [...found.keys()].filter((name) => found.get(name)?.rank === rank);
    const narrow = here.filter((name) => !wide.has(name));
    for (const [column, name] of narrow.entries()) {
      made.set(name, { step, column, alone: narrow.length === 1 });
    }
    if (narrow.length) step++;
    for (const name of here) if (wide.has(name)) made.set(name, { step: step++, column: 0, alone: true });
  }
  return made;
}
