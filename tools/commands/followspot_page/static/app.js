// The page: takes what the run tells over one WebSocket and hands each thing to the part that draws it.
import { Faults } from "./faults.js";
import { lossOf, slowest, span } from "./figures.js";
import { Legend } from "./legend.js";
import { make } from "./make.js";
import { Pipeline } from "./pipeline.js";
import { Player } from "./player.js";
import { Recorder } from "./recorder.js";
import { Room } from "./room.js";
import { Sensors } from "./sensors.js";
import { Tiles } from "./tiles.js";
import { Together } from "./together.js";
import { Views } from "./views.js";

const RETRY_MS = 3000;
const LOOK_MS = 500; // between two looks at how old everything is
const NEWS = 4; // lines
const $ = (id) => document.getElementById(id);

const views = new Views();
const tiles = new Tiles($("tiles"), views);
const sensors = new Sensors($("tiles"));
let socket = null;
const ask = (wish) => socket.send(JSON.stringify(wish));
const pipeline = new Pipeline($("groups"), $("detail"), ask);
const recorder = new Recorder($("recorder"), ask);
const player = new Player($("player"), ask);
const legend = new Legend($("legend"));
const together = new Together();
const faults = new Faults($("faults"));
const room = Room.on($("view"));
$("flat").hidden = room !== null;
$("view").hidden = room === null;

function setLife(life, text) {
  $("life").dataset.life = life;
  $("life").textContent = text;
}

// Hosts whose clocks are so far off that the run warns.
const clocks = (run) => run.clocks.filter(({ warning }) => warning).map(({ host, warning }) => `${host || "this host"}: ${warning}`);

// How old everything is by the clock of this browser, whether anybody tells it anything or not.
function look() {
  const well = faults.show();
  if (!faults.over) {
    tiles.look();
    sensors.look();
    legend.look();
  }
  const life = $("life").dataset.life;
  if (life === "running" && !well) setLife("fault", "fault");
  else if (life === "fault" && well) setLife("running", "running");
  document.title = `${well ? "" : "! "}${$("graph").textContent} · followspot`;
}

let ended = ""; // how, where this was told
let shown = "";
let fused = false;
const takers = {
  answer(answer) {
    const wish = JSON.parse(answer.to);
    ("on" in wish ? recorder : "hold" in wish ? player : pipeline).answer(answer);
  },
  scene(scene) {
    $("graph").textContent = scene.graph;
    $("room").textContent = scene.room.name;
    pipeline.show(scene.stages, scene.forms);
    tiles.from(scene.stages);
    recorder.show(scene.ports);
    player.show(scene.replay);
    if (JSON.stringify(scene.room) !== shown) { // else only stages or parameters are others
      shown = JSON.stringify(scene.room);
      tiles.show(scene.room);
      legend.show(scene.room.targets);
      room?.show(scene.room);
    }
    sensors.show(scene.sensors);
  },
  run(run) {
    const running = run.stages.some((stage) => stage.state !== "over");
    const life = player.update(run.stages) ? "paused" : "running";
    setLife(running ? life : "waiting", running ? life : "starting");
    faults.take(run.faults);
    const path = slowest(run.paths.filter(({ old }) => !old));
    const lost = lossOf(run.edges);
    $("rate").textContent = run.rate === null ? "–" : run.rate.toFixed(run.rate < 10 ? 1 : 0);
    $("fired").textContent = run.expected ? `${run.fired} / ${run.expected}` : run.fired;
    $("latency").textContent = path ? span(path.p50_ms, path.p95_ms) : "–";
    $("lost").textContent = lost;
    $("lost").className = lost ? "lossy" : "";
    $("news").replaceChildren(...[...clocks(run), ...run.news.slice(-NEWS)].map((line) => make("li", line)));
    pipeline.update(run);
    tiles.update(run.stages);
    sensors.update(run.stages);
    look();
  },
  end({ how }) {
    ended = how;
    socket.close(); // says that this was read: the page's process waits for it
  },
  recording(recording) {
    recorder.update(recording);
  },
  view(view) {
    if (sensors.take(view)) return;
    views.take(view);
    if (view.kind === "Tracks") {
      const tracks = together.take(view);
      legend.tracks(tracks);
      room?.tracks(tracks);
    } else if (view.kind === "Poses") {
      fused ||= !view.camera;
      if (!(fused && view.camera)) room?.poses(view); // what cameras see apart is shown until it is fused
    }
    tiles.changed(view);
  },
};

function connect(again) {
  socket = new WebSocket(`ws://${location.host}/look`);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => again && location.reload(); // it may be another run, of another room
  socket.onmessage = ({ data }) => {
    if (typeof data !== "string") return tiles.picture(data);
    const thing = JSON.parse(data);
    takers[thing.type]?.(thing);
  };
  socket.onclose = () => {
    faults.end(ended ? [] : ["this page has lost its run, which may go on, or not: its operator's process, or that of the page, is gone"]);
    look();
    if (ended) setLife("ended", ended);
    else setLife("gone", "gone");
    setTimeout(connect, RETRY_MS, true);
  };
}

connect(false);
setInterval(look, LOOK_MS);
