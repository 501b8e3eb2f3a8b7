import assert from "node:assert/strict";
import { test } from "node:test";
import { limitsOf, rangeText, sliderOf } from "../src/elements/limits.ts";
import { Undo } from "../src/graph/form.ts";
import type { Change } from "../src/messages/requests.ts";

const parameter = (type: string, range: string, usual: number) => ({
  name: "n",
  type,
  default: usual,
  required: false,
  range,
  unit: "1",
  description: "",
});

test("a range has a text", () => {
  assert.equal(rangeText(limitsOf("> 0, <= 1")), "more than 0, at most 1");
  assert.equal(rangeText(limitsOf(">= -3.5, < 1e-3")), "at least -3.5, less than 0.001");
  assert.equal(rangeText(limitsOf("")), "");
});

test("a slider keeps to the limits, and where there are none goes some way beyond the value", () => {
  const share = sliderOf(parameter("float", "> 0, <= 1", 0.3), 0.5);
  assert.ok(share && share.low > 0 && share.high === 1);
  assert.deepEqual(sliderOf(parameter("int", ">= 1, <= 9", 3), 3), { low: 1, high: 9, step: 1 });
  assert.deepEqual(sliderOf(parameter("float", ">= 0", 10), 5), { low: 0, high: 40, step: 0.2 });
  const shift = sliderOf(parameter("float", "", 0), -2);
  assert.ok(shift && shift.low === -8 && shift.high === 8);
  assert.equal(sliderOf(parameter("float", "", 0), 0), null);
  assert.equal(sliderOf(parameter("str", "", 0), "abc"), null);
});

test("the newest change of a stage that was made is taken back, and one that was refused is not", () => {
  const sent: Change[] = [];
  const undo = new Undo((change) => sent.push(change));
  const ask = (stage: string, value: string, before: string, ok: boolean) => {
    undo.ask({ stage, key: "k", value }, before);
    undo.answer(JSON.stringify({ stage, key: "k", value }), ok);
  };
  ask("a", "2", "1", true);
  ask("a", "3", "2", true);
  ask("a", "-1", "3", false);
  ask("b", "7", "6", true);
  assert.equal(undo.last("a"), "k = 2");
  undo.undo("a");
  assert.deepEqual(sent.at(-1), { stage: "a", key: "k", value: "2" });
  undo.answer(JSON.stringify(sent.at(-1)), true);
  assert.equal(undo.last("a"), "k = 1");
  undo.undo("a");
  assert.equal(undo.last("a"), "");
});
