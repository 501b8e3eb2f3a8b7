// Learns a target from a still picture of a camera, in a dialog: click, look at what was learnt, write it.
import { make } from "../elements/make.ts";
import type { Answer, LearntData, StillData } from "../messages/messages.ts";
import type { Ask, PickRequest } from "../messages/requests.ts";
import { boxOf, learnRequestOf, learntWords } from "./pick.ts";
import { penOf } from "./tile.ts";

export class Picker {
  private readonly dialog: HTMLDialogElement;
  private readonly send: Ask<PickRequest>;
  private readonly title = make("h2");
  private readonly canvas = make("canvas");
  private readonly name = make("input", "", { type: "text", size: 12, maxLength: 64 });
  private readonly radius = make("input", "", { type: "text", inputMode: "decimal", size: 6 });
  private readonly names = make("datalist", "", { id: "known" });
  private readonly said = make("p");
  private readonly swatch = make("i");
  private readonly lines = make("ul");
  private readonly write = make("button", "write", { type: "button", className: "write" });
  private camera = "";
  private still: StillData | null = null;
  private image: ImageBitmap | null = null;
  private box: number[] | null = null;
  private learnt: LearntData | null = null;

  constructor(dialog: HTMLDialogElement, send: Ask<PickRequest>) {
    this.dialog = dialog;
    this.send = send;
    this.said.setAttribute("role", "status");
    this.name.setAttribute("list", "known");
    const again = make("button", "another picture", { type: "button", onclick: () => this.take() });
    const close = make("button", "×", { type: "button", className: "close", onclick: () => dialog.close() });
    close.setAttribute("aria-label", "close");
    this.write.onclick = () => this.keep();
    for (const field of [this.name, this.radius]) field.onchange = () => this.ask();
    this.point();
    const fields = make("p", "", { className: "fields" });
    fields.append(labelled("name", this.name), labelled("radius, m", this.radius), this.names, again);
    const result = make("div", "", { className: "learnt" });
    result.append(this.swatch, this.lines);
    dialog.append(close, this.title, this.canvas, fields, this.said, result, this.write);
  }

  // Begins with a picture of this camera.
  open(camera: string): void {
    this.camera = camera;
    this.still = this.image = null;
    this.title.textContent = `learn a target from ${camera}`;
    this.canvas.hidden = true;
    this.dialog.showModal();
    this.take();
  }

  // The JPEG of the answer that follows.
  async picture(jpeg: ArrayBuffer): Promise<void> {
    this.image = await createImageBitmap(new Blob([jpeg], { type: "image/jpeg" }));
    this.draw();
  }

  answer(request: PickRequest, { text, ok, about }: Answer): void {
    if (!ok) this.say(text, false);
    else if ("still" in request) this.takeStill(about as StillData);
    else if ("learn" in request) this.takeLearnt(about as LearntData);
    else {
      this.forget();
      this.say(text, true);
    }
  }

  private take(): void {
    this.forget();
    this.say("taking a picture …", true);
    this.send({ still: this.camera });
  }

  private takeStill(still: StillData): void {
    this.still = still;
    this.names.replaceChildren(...Object.keys(still.targets).map((value) => make("option", "", { value })));
    this.write.textContent = `write to ${still.file.split("/").pop()}`;
    this.write.title = still.file;
    this.draw();
    this.ask();
  }

  private takeLearnt(learnt: LearntData): void {
    this.learnt = learnt;
    this.swatch.style.background = learnt.color;
    this.lines.replaceChildren(...learntWords(learnt).map((line) => make("li", line)));
    this.write.hidden = false;
    this.say("", true);
    this.draw();
  }

  // Learns as soon as all is there that it takes.
  private ask(): void {
    if (!this.still) return;
    const { targets } = this.still;
    const name = this.name.value.trim();
    this.radius.placeholder = `${targets[name] ?? ""}`; // what stays if nothing is given
    const request = learnRequestOf(name, this.radius.value.trim(), this.box, targets);
    this.unlearn();
    if (typeof request === "string") this.say(request, true);
    else {
      this.say("learning …", true);
      this.send(request);
    }
    this.draw();
  }

  private keep(): void {
    this.write.hidden = true;
    this.say("writing …", true);
    this.send({ write: true });
  }

  private forget(): void {
    this.box = null;
    this.unlearn();
    this.draw();
  }

  private unlearn(): void {
    this.learnt = null;
    this.write.hidden = true;
    this.swatch.style.background = "";
    this.lines.replaceChildren();
  }

  private say(text: string, ok: boolean): void {
    this.said.textContent = text;
    this.said.dataset.ok = String(ok);
  }

  private point(): void {
    let from: [number, number] | null = null;
    const at = ({ clientX, clientY }: PointerEvent): [number, number] => {
      const { left, top } = this.canvas.getBoundingClientRect();
      return [clientX - left, clientY - top];
    };
    const follow = (event: PointerEvent) => {
      if (!from || !this.still) return;
      const { width, height } = this.canvas.getBoundingClientRect();
      this.box = boxOf(from, at(event), [width, height], this.still.size);
      this.unlearn();
      this.draw();
    };
    this.canvas.onpointerdown = (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      from = at(event);
    };
    this.canvas.onpointermove = follow;
    this.canvas.onpointerup = (event) => {
      follow(event);
      from = null;
      this.ask();
    };
  }

  // The picture, and over it what is pointed at and what was learnt.
  private draw(): void {
    if (!this.image || !this.still) return;
    const { canvas, image, box, learnt } = this;
    const [width, height] = this.still.size;
    canvas.hidden = false;
    [canvas.width, canvas.height] = [width, height];
    canvas.style.setProperty("--ratio", `${width / height}`);
    const pen = penOf(canvas);
    pen.drawImage(image, 0, 0, width, height);
    pen.lineWidth = Math.max(width / 400, 1);
    pen.strokeStyle = "#fff";
    if (box && box.length === 4) pen.strokeRect(box[0], box[1], box[2], box[3]);
    if (box && box.length === 2) cross(pen, box, width / 60);
    if (!learnt) return;
    pen.strokeStyle = learnt.color;
    pen.beginPath();
    pen.arc(...learnt.center, learnt.radius_px + pen.lineWidth, 0, 2 * Math.PI);
    pen.stroke();
  }
}

function labelled(text: string, field: HTMLInputElement): HTMLElement {
  const label = make("label", text);
  label.append(field);
  return label;
}

function cross(pen: CanvasRenderingContext2D, [x, y]: number[], arm: number): void {
  pen.beginPath();
  pen.moveTo(x - arm, y);
  pen.lineTo(x + arm, y);
  pen.moveTo(x, y - arm);
  pen.lineTo(x, y + arm);
  pen.stroke();
}
