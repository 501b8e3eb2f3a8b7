// The range of a parameter, as the server writes it (">= 0, < 1"), and what a slider makes of it.
import type { ParameterData, Value } from "../messages/scene.ts";

export interface Limits {
  low: number | null; // null: none
  high: number | null;
  above: boolean; // whether low itself is out of the range
  below: boolean;
}

export interface Slider {
  low: number;
  high: number;
  step: number;
}

const STEPS = 200; // of a slider
const FURTHER = 4; // how far a slider goes where there is no limit: so many times the value

export function limitsOf(range: string): Limits {
  const found: Limits = { low: null, high: null, above: false, below: false };
  for (const [, sign, text] of range.matchAll(/(>=?|<=?) (-?[\d.e+-]+)/g)) {
    const equal = sign.endsWith("=");
    if (sign[0] === ">") [found.low, found.above] = [Number(text), !equal];
    else [found.high, found.below] = [Number(text), !equal];
  }
  return found;
}

// In words: "more than 0, at most 1"; "" without limits.
export function rangeText({ low, high, above, below }: Limits): string {
  const parts = [
    low === null ? "" : `${above ? "more than" : "at least"} ${low}`,
    high === null ? "" : `${below ? "less than" : "at most"} ${high}`,
  ];
  return parts.filter(Boolean).join(", ");
}

// Null for what is no number, and where nothing says how far it may go.
export function sliderOf({ type, range, default: usual }: ParameterData, value: Value): Slider | null {
  if (typeof value !== "number") return null;
  const { low, high, above, below } = limitsOf(range);
  const size = Math.max(Math.abs(value), typeof usual === "number" ? Math.abs(usual) : 0);
  const [first, last] = [low ?? (value < 0 ? -FURTHER * size : 0), high ?? FURTHER * size];
  if (!(last > first)) return null;
  const whole = type === "int";
  const step = whole ? Math.max(1, Math.round((last - first) / STEPS)) : nice((last - first) / STEPS);
  return { low: above ? first + step : first, high: below ? last - step : last, step };
}

// The largest of 1, 2 and 5 times a power of ten that is no larger.
function nice(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  const lead = value / power;
  return Number(((lead >= 5 ? 5 : lead >= 2 ? 2 : 1) * power).toPrecision(1));
}
