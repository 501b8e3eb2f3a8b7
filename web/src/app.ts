// The page: takes what the run tells over one WebSocket and hands each thing to the part that draws it.
import { Faults } from "./controls/faults.ts";
import { Header } from "./controls/header.ts";
import { Marker } from "./controls/marker.ts";
import { Player } from "./controls/player.ts";
import { Recorder } from "./controls/recorder.ts";
import { Runs } from "./controls/runs.ts";
import { Scrubber } from "./controls/scrubber.ts";
import { make } from "./elements/make.ts";
import { part } from "./elements/part.ts";
import { Pipeline } from "./graph/pipeline.ts";
import { MergedTracks } from "./messages/merged_tracks.ts";
import type { Drawn, View } from "./messages/message_views.ts";
import type { Answer, ServerMessage } from "./messages/messages.ts";
import type { PageRequest } from "./messages/requests.ts";
import type { Run } from "./messages/run.ts";
import type { Scene } from "./messages/scene.ts";
import { Views } from "./messages/views.ts";
import { Timeline } from "./plots/timeline.ts";
import { Legend } from "./room/legend.ts";
import { Room } from "./room/room.ts";
import { Picker } from "./tiles/picker.ts";
import { Sensors } from "./tiles/sensors.ts";
import { Tiles } from "./tiles/tiles.ts";

const RETRY_MS = 3000;
const LOOK_MS = 500; // between two looks at how old everything is
const NEWS = 4; // lines
const STILL = 0; // what a still picture begins with, instead of the length of a camera's name
const LOST =
  "this page has lost its run, which may go on, or not: its operator's process, or that of the page, is gone";

let socket: WebSocket;
const ask = (request: PageRequest) => socket.send(JSON.stringify(request));
const views = new Views<Drawn>();
const picker = new Picker(part("picker", HTMLDialogElement), ask);
const tiles = new Tiles(part("tiles", HTMLElement), views, (camera) => picker.open(camera));
const sensors = new Sensors(part("tiles", HTMLElement));
const header = new Header();
const pipeline = new Pipeline(part("pipeline", HTMLElement), part("detail", HTMLElement), ask);
const recorder = new Recorder(
  {
    element: part("recorder", HTMLElement),
    record: part("record", HTMLButtonElement),
    recorded: part("recorded", HTMLElement),
    choice: part("choice", HTMLFormElement),
  },
  ask,
);
const player = new Player(
  {
    element: part("player", HTMLElement),
    pause: part("pause", HTMLButtonElement),
    step: part("step", HTMLButtonElement),
    reached: part("reached", HTMLElement),
  },
  ask,
);
const marker = new Marker(
  {
    element: part("marker", HTMLElement),
    mark: part("mark", HTMLButtonElement),
    note: part("note", HTMLInputElement),
    marked: part("marked", HTMLElement),
  },
  ask,
);
const scrubber = new Scrubber(
  {
    element: part("scrubber", HTMLElement),
    play: part("play", HTMLButtonElement),
    line: part("line", HTMLInputElement),
    moment: part("moment", HTMLElement),
  },
  ask,
);
const runs = new Runs(
  {
    element: part("others", HTMLElement),
    button: part("runs", HTMLButtonElement),
    list: part("list", HTMLElement),
  },
  ask,
);
const timeline = new Timeline(part("time", HTMLElement), part("over", HTMLButtonElement), ask);
const legend = new Legend(part("legend", HTMLElement));
const merged = new MergedTracks();
const faults = new Faults(part("faults", HTMLElement));
const news = part("news", HTMLElement);
const canvas = part("view", HTMLCanvasElement);
const room = Room.on(canvas, part("stage", HTMLElement), part("legend", HTMLElement));
part("flat", HTMLElement).hidden = room !== null;
canvas.hidden = room === null;

let ended = ""; // how the run ended, once the server says so
let shown = "";
let fused = false;

// How old everything is by the clock of this browser, whether anybody tells it anything or not.
function look(): void {
  const well = faults.show();
  if (!faults.over) {
    tiles.look();
    sensors.look();
    legend.look();
  }
  header.look(well);
}

function takeScene(scene: Scene): void {
  header.show(scene);
  pipeline.show(scene);
  tiles.from(scene.stages);
  timeline.show(scene.stages, scene.room.targets, scene.figures);
  document.body.classList.toggle("learns", Object.keys(scene.forms).length > 0);
  recorder.show(scene.ports);
  player.show(scene.replay);
  runs.show(scene.others);
  scrubber.show(scene.recorded);
  if (JSON.stringify(scene.room) !== shown) {
    // else only stages or parameters are others
    shown = JSON.stringify(scene.room);
    tiles.show(scene.room);
    legend.show(scene.room.targets);
    room?.show(scene.room);
  }
  sensors.show(scene.sensors);
}

function takeRun(run: Run): void {
  header.update(run, player.update(run.stages));
  faults.take(run.faults);
  news.replaceChildren(
    ...[...change(run), ...clocks(run), ...run.news.slice(-NEWS)].map((line) => make("li", line)),
  );
  pipeline.update(run);
  timeline.take(run, views.all());
  tiles.update(run.stages);
  sensors.update(run.stages);
  look();
}

// What the change of the run that is under way waits for.
function change(run: Run): string[] {
  return run.change_awaits ? [`a change waits for ${run.change_awaits}`] : [];
}

// Hosts whose clocks are so far off that the run warns.
function clocks(run: Run): string[] {
  const off = run.clocks.filter(({ warning }) => warning);
  return off.map(({ host, warning }) => `${host || "this host"}: ${warning}`);
}

function takeView(view: View): void {
  if (sensors.take(view)) return;
  views.take(view);
  if (view.kind === "Tracks") {
    const tracks = merged.take(view);
    legend.tracks(tracks);
    timeline.tracks(tracks);
    room?.tracks(tracks);
  } else if (view.kind === "Poses") {
    fused ||= !view.camera;
    if (!(fused && view.camera)) room?.poses(view); // what cameras see apart is shown until it is fused
  } else if (view.kind === "Skeletons") {
    room?.bones(view);
  }
  tiles.changed(view);
}

function takeAnswer(answer: Answer): void {
  const request: PageRequest = JSON.parse(answer.to);
  if ("on" in request) recorder.answer(answer);
  else if ("hold" in request) player.answer(answer);
  else if ("mark" in request) marker.answer(answer);
  else if ("open" in request) runs.answer(answer);
  else if ("seek" in request) return;
  else if ("plot" in request) timeline.answer(answer);
  else if ("still" in request || "learn" in request || "write" in request) picker.answer(request, answer);
  else if ("save" in request) pipeline.detail.tellSaved(answer);
  else {
    pipeline.detail.answer(answer);
    if (answer.ok) timeline.note(`${request.stage}: ${answer.text}`);
  }
}

function take(message: ServerMessage): void {
  if (message.type === "scene") takeScene(message);
  else if (message.type === "run") takeRun(message);
  else if (message.type === "view") takeView(message);
  else if (message.type === "curves") timeline.takeCurves(message);
  else if (message.type === "recording") recorder.update(message);
  else if (message.type === "kept") marker.update(message);
  else if (message.type === "position") scrubber.update(message);
  else if (message.type === "answer") takeAnswer(message);
  else {
    ended = message.how;
    socket.close(); // says that this was read: the page's process waits for it
  }
}

function takeBytes(bytes: ArrayBuffer): void {
  if (new DataView(bytes).getUint8(0) === STILL) picker.picture(bytes.slice(1));
  else tiles.picture(bytes);
}

function connect(again: boolean): void {
  socket = new WebSocket(`ws://${location.host}/look`);
  socket.binaryType = "arraybuffer";
  socket.onmessage = ({ data }) => {
    if (again)
      location.reload(); // it may be another run, of another room
    else if (typeof data === "string") take(JSON.parse(data));
    else takeBytes(data);
  };
  socket.onclose = ({ reason }) => {
    faults.end(ended ? [] : [reason || LOST]);
    look();
    header.live(ended ? "ended" : "gone", ended || "gone");
    setTimeout(connect, RETRY_MS, true);
  };
}

connect(false);
setInterval(look, LOOK_MS);
