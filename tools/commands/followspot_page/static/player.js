// The buttons that pause a replay, let it go on, and let it take one step.
const STEP = 1; // capture times of the first camera

export class Player {
  // send: receives {hold, count}.
  constructor(element, send) {
    this.element = element;
    [this.toggle, this.step, this.status] = element.children;
    this.send = send;
    this.paused = false;
    this.toggle.onclick = () => this.ask(this.paused ? "resume" : "pause");
    this.step.onclick = () => this.ask("step");
  }

  // replay: whether this page may pause the run.
  show(replay) {
    this.element.hidden = !replay;
  }

  // stages: the run's, with their states; returns whether the run is paused.
  update(stages) {
    this.paused = stages.some(({ state }) => state === "paused");
    this.toggle.textContent = this.paused ? "resume" : "pause";
    return this.paused;
  }

  answer({ text }) {
    this.status.textContent = text;
  }

  ask(hold) {
    this.status.textContent = "…";
    this.send({ hold, count: STEP });
  }
}
